//! Opaque surfaces, shaded in SIMD lanes, eight paths at a time.
//!
//! They are most surfaces of most scenes. What [`path`](super::path) does for surfaces of any material is done here for
//! materials whose BSDF has functions [in lanes](pathmarch_scene::materials::Bsdf::in_lanes): Lambertian surfaces and metal.

use super::light_sampling::nth_light_sample;
use super::light_sampling_lanes::{choose_lights, sample_directions, sample_weights};
use super::path_state::{Path, ROULETTE_DEPTH, SURVIVAL_FACTOR};
use super::shadow::ShadowTest;
use super::surface_samples::SurfaceSamples;
use crate::intersect::ray::{Ray, pack, set_bits, unpack};
use crate::sampling::basis::Basis8;
use crate::scene::TraceContext;
use crate::scene::material::{DELTA, LAMBERTIAN};
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use glam::Vec3;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use pathmarch_scene::materials::{BsdfInLanes, DiffuseInLanes, KindInLanes, MetalInLanes, ParametersInLanes};
use wide::f32x8;

/// Kind of a leaf's material, if [`shade`] may shade it: it knows neither photons nor the lights that they contribute.
pub(super) fn kind_in_lanes(ctx: &TraceContext, leaf: usize) -> Option<KindInLanes> {
    let material = ctx.scene.leaves[leaf].material as usize;
    let is_apart = !ctx.config.traced_caustics || ctx.scene.materials[material].has(LAMBERTIAN);
    ctx.scene.bsdfs[material]?.in_lanes.filter(|_| is_apart && ctx.photons.is_none())
}

/// Surface of a path, by the index of the path.
pub(super) type SurfaceOfPath<'a> = (usize, &'a SurfaceInteraction);

/// [`shade`] for the surfaces of a kind of material.
pub(super) type Shade =
    fn(&TraceContext, &mut [Path], &[SurfaceOfPath], &SurfaceSamples, u32, &mut Vec<ShadowTest>) -> u32;

/// Shading of the surfaces of a kind of material.
pub(super) fn shading_of(kind: KindInLanes) -> Shade {
    match kind {
        KindInLanes::Diffuse => shade::<DiffuseInLanes>,
        KindInLanes::Metal => shade::<MetalInLanes>,
    }
}

/// Shades surfaces of materials of one kind at the ends of one to eight paths: samples a light of each and its next ray.
/// Returns a bit for each that goes on.
fn shade<B: BsdfInLanes>(
    ctx: &TraceContext,
    paths: &mut [Path],
    surfaces: &[SurfaceOfPath],
    samples: &SurfaceSamples,
    surface_index: u32,
    shadow_tests: &mut Vec<ShadowTest>,
) -> u32 {
    let count = surfaces.len();
    let Inputs {
        origins,
        normals,
        samples_lights,
        parameters,
        normal,
        shading_normal,
        to_viewer,
        throughput,
        index_square,
        choice,
        light,
        scatter,
    } = Inputs::new::<B>(ctx, paths, surfaces, samples);
    // Light through the geometric surface is lost.
    let crosses_surface = |direction: FieldVec3<f32x8>| {
        Mask8(direction.dot(normal).simd_lt(f32x8::ZERO)) & f32x8::truth(ctx.config.shading_normals)
    };
    let basis = Basis8::new(shading_normal);
    let wo = basis.local_viewer(to_viewer);

    let light_samples = samples.light_samples;
    let share = f32x8::splat(1.0 / light_samples as f32);
    for sample in 0..light_samples {
        let (choice, position) = nth_light_sample(sample, light_samples, choice[0], light);
        let lights = choose_lights(ctx, &origins, &normals, choice, samples_lights);
        let light = sample_directions(ctx, &lights, pack(origins), position);
        let wi = basis.to_local(light.direction);
        let evaluated = B::eval(&parameters, wo, wi);
        let radiance = throughput.times(evaluated.value).times(light.irradiance) * share;
        let is_lit = light.exist
            & !crosses_surface(light.direction)
            & Mask8(wi.z.simd_gt(f32x8::ZERO))
            & Mask8(evaluated.value.largest().simd_gt(f32x8::ZERO));
        let lit = is_lit.0.to_bitmask();
        let weight = sample_weights(ctx.config.direct_lighting, light.pdf, evaluated.pdf).to_array();
        let (directions, radiance, distance) = (unpack(light.direction), unpack(radiance), light.distance.to_array());
        for lane in set_bits(lit) {
            let (path, shape) = (&paths[surfaces[lane].0], lights.shapes[lane]);
            shadow_tests.push(ShadowTest {
                slot: path.slot,
                radiance: radiance[lane],
                weight: weight[lane],
                ray: Ray { origin: origins[lane], direction: directions[lane] },
                distance: distance[lane],
                target: shape.target(),
                penumbra: shape.penumbra(),
                path_length: path.length,
                medium: path.medium,
                sampler: path.sampler,
            });
        }
    }

    let scattered = B::sample(&parameters, wo, scatter);
    let direction = basis.to_world(scattered.wi);
    let direction = direction / direction.length();
    let mut goes_on = Mask8(scattered.wi.z.simd_gt(f32x8::ZERO)) & !crosses_surface(direction);
    let mut throughput = throughput.times(scattered.weight);
    if surface_index > ROULETTE_DEPTH {
        let survival_probability = f32x8::splat(SURVIVAL_FACTOR) * throughput.largest() * index_square;
        let survival_probability = survival_probability.fast_min(f32x8::ONE);
        goes_on = goes_on & Mask8(choice[1].simd_lt(survival_probability));
        throughput = throughput / survival_probability;
    }
    let (directions, throughputs, scatter_pdfs) = (unpack(direction), unpack(throughput), scattered.pdf.to_array());
    for (lane, (index, _)) in surfaces.iter().enumerate() {
        let path = &mut paths[*index];
        if samples_lights >> lane & 1 == 1 {
            path.previous_vertex = origins[lane];
            path.previous_normal = Some(normals[lane]);
        }
        path.throughput = throughputs[lane];
        path.lights_are_counted = false;
        path.met_photons |= ctx.config.traced_caustics;
        path.ray = Ray { origin: origins[lane], direction: directions[lane] };
        path.scatter_pdf = scatter_pdfs[lane];
    }
    goes_on.0.to_bitmask() & ((1 << count) - 1)
}

/// What [`shade`] reads of eight surfaces, their paths and random numbers.
struct Inputs {
    /// Origins of rays that leave the surfaces, in world space.
    origins: [Vec3; 8],
    /// Unit shading normals.
    normals: [Vec3; 8],
    /// Lanes where a light is sampled, a bit for each: all surfaces but mirrors.
    samples_lights: u32,
    parameters: ParametersInLanes,
    /// Unit geometric normals.
    normal: FieldVec3<f32x8>,
    /// Unit shading normals.
    shading_normal: FieldVec3<f32x8>,
    /// Unit vectors back along the paths.
    to_viewer: FieldVec3<f32x8>,
    throughput: FieldVec3<f32x8>,
    /// Square of the refractive index around the paths.
    index_square: f32x8,
    /// As in [`SurfaceSamples`].
    choice: [f32x8; 2],
    light: [f32x8; 2],
    scatter: [f32x8; 2],
}

impl Inputs {
    #[inline(always)]
    fn new<B: BsdfInLanes>(
        ctx: &TraceContext,
        paths: &[Path],
        surfaces: &[SurfaceOfPath],
        samples: &SurfaceSamples,
    ) -> Self {
        let (mut origins, mut normals, mut samples_lights) = ([Vec3::ZERO; 8], [Vec3::Y; 8], 0);
        let mut components = [[0.0; 8]; 19];
        let mut parameters = [[0.0; 8]; 8];
        for (lane, &(index, interaction)) in surfaces.iter().enumerate() {
            let (path, SurfaceInteraction { p, normal: n, normal_offset, .. }) = (&paths[index], interaction);
            let material = ctx.scene.material_of(interaction.leaf);
            let textured = TexturedPoint::new(ctx, interaction, path.length);
            let ns = shading_normal(ctx.config, textured.as_ref(), interaction, -path.ray.direction);
            (origins[lane], normals[lane]) = (p + normal_offset, ns);
            samples_lights |= u32::from(!material.has(DELTA)) << lane;
            let ([a, b], [c, d], [e, f]) = (samples.choice[index], samples.light[index], samples.scatter[index]);
            let (v, t) = (-path.ray.direction, path.throughput);
            let values =
                [n.x, n.y, n.z, ns.x, ns.y, ns.z, v.x, v.y, v.z, t.x, t.y, t.z, path.index_square, a, b, c, d, e, f];
            for (component, value) in components.iter_mut().zip(values) {
                component[lane] = value;
            }
            let textured_parameters = textured.map(|textured| textured.parameters(&material.parameters));
            let own = textured_parameters.as_ref().unwrap_or(&material.parameters);
            for (parameter, value) in parameters.iter_mut().zip(&own[..B::PARAMETERS]) {
                parameter[lane] = *value;
            }
        }
        let [nx, ny, nz, sx, sy, sz, vx, vy, vz, tr, tg, tb, index_square, a, b, c, d, e, f] =
            components.map(f32x8::from);
        Self {
            origins,
            normals,
            samples_lights,
            parameters: parameters.map(f32x8::from),
            normal: FieldVec3::new(nx, ny, nz),
            shading_normal: FieldVec3::new(sx, sy, sz),
            to_viewer: FieldVec3::new(vx, vy, vz),
            throughput: FieldVec3::new(tr, tg, tb),
            index_square,
            choice: [a, b],
            light: [c, d],
            scatter: [e, f],
        }
    }
}
