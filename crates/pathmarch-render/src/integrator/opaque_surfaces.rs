//! Opaque surfaces, shaded in SIMD lanes, eight paths at a time.
//!
//! They are most surfaces of most scenes. What [`path`](super::path) does for surfaces of any material is done here for
//! materials whose BSDF has functions [in lanes](pathmarch_scene::materials::Bsdf::in_lanes): Lambertian surfaces, metal and
//! `principled` surfaces that do not transmit.

use super::light_sampling::nth_light_sample;
use super::light_sampling_lanes::{choose_lights, sample_directions, sample_weights};
use super::path_state::{Path, ROULETTE_DEPTH, SURVIVAL_FACTOR};
use super::shadow::ShadowTest;
use super::surface_samples::{SurfaceSample, SurfaceSamples};
use crate::intersect::ray::{Ray, lane_of, mask_of, pack, set_bits, unpack};
use crate::sampling::basis::Basis8;
use crate::scene::material::{DELTA, LAMBERTIAN};
use crate::scene::{LightShape, TraceContext};
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::{TexturedPoint, parameters_of_eight, shading_normal};
use glam::Vec3;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use pathmarch_scene::materials::{
    BsdfInLanes, DiffuseInLanes, KindInLanes, MetalInLanes, ParametersInLanes, PrincipledInLanes,
};
use wide::f32x8;

/// Kind of the material of an index, if [`shade`] may shade it: it knows neither photons nor the lights that they contribute.
#[inline(always)]
pub(super) fn kind_in_lanes(ctx: &TraceContext, material: usize) -> Option<KindInLanes> {
    let is_apart = !ctx.config.traced_caustics || ctx.scene.materials[material].has(LAMBERTIAN);
    ctx.scene.kinds_in_lanes[material].filter(|_| is_apart && ctx.photons.is_none())
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
        KindInLanes::Principled => shade::<PrincipledInLanes>,
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
    let points = textured_points(ctx, paths, surfaces);
    let (inputs, samples_lights) = ShadingInputs::new(ctx, paths, surfaces, &points, samples);
    let material = |lane: usize| &ctx.scene.material_of(surfaces[lane].1.leaf).parameters;
    let textured = match ctx.config.textures {
        true => parameters_of_eight(&points, material),
        false => [None; 8],
    };
    let of_lane = |lane: usize| {
        let lane = lane.min(surfaces.len() - 1);
        textured[lane].as_ref().unwrap_or(material(lane))
    };
    let parameters = ParametersInLanes::new(std::array::from_fn(of_lane), B::PARAMETERS);
    let origins = unpack(inputs.origin);
    let light_samples = (samples.light_samples, samples_lights);
    let scattered = shade_lanes::<B>(ctx, &inputs, &parameters, light_samples, surface_index, |light| {
        let of_lane = |lane: usize| light.test(lane, &paths[surfaces[lane].0], origins[lane]);
        shadow_tests.extend(set_bits(light.lit).map(of_lane));
    });
    let (directions, throughputs) = (unpack(scattered.direction), unpack(scattered.throughput));
    let (scatter_pdfs, normals) = (scattered.pdf.to_array(), unpack(inputs.shading_normal));
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
    scattered.goes_on & ((1 << surfaces.len()) - 1)
}

/// Light samples of eight paths, before visibility.
pub(super) struct LightOfPaths<'a> {
    /// Lanes with light, a bit for each.
    pub(super) lit: u32,
    pub(super) direction: FieldVec3<f32x8>,
    /// Radiance without occlusion, W/(m² sr).
    pub(super) radiance: FieldVec3<f32x8>,
    /// Weights of multiple importance sampling.
    pub(super) weight: f32x8,
    /// Largest distances of occluders, metres.
    pub(super) distance: f32x8,
    pub(super) shapes: [&'a LightShape; 8],
}

impl LightOfPaths<'_> {
    /// Shadow test of the light sample of a lane, for its path and the origin of its ray.
    #[inline(always)]
    pub(super) fn test(&self, lane: usize, path: &Path, origin: Vec3) -> ShadowTest {
        let shape = self.shapes[lane];
        ShadowTest {
            slot: path.slot,
            radiance: lane_of(self.radiance, lane),
            weight: self.weight.as_array()[lane],
            ray: Ray { origin, direction: lane_of(self.direction, lane) },
            distance: self.distance.as_array()[lane],
            target: shape.target(),
            penumbra: shape.penumbra(),
            path_length: path.length,
            medium: path.medium,
            sampler: path.sampler,
        }
    }
}

/// Rays of eight paths that leave their surfaces, from the origins of the [`ShadingInputs`].
pub(super) struct ScatteredPaths {
    pub(super) direction: FieldVec3<f32x8>,
    pub(super) throughput: FieldVec3<f32x8>,
    /// Pdfs over solid angle; 0 for delta distributions.
    pub(super) pdf: f32x8,
    /// Lanes of paths that go on, a bit for each.
    pub(super) goes_on: u32,
}

/// Samples lights, each of which it passes to `test_light`, and the next rays, of materials of one kind with these parameters. A
/// number of lights is sampled in the lanes of which it has a bit: at all surfaces but mirrors.
#[inline(always)]
pub(super) fn shade_lanes<'a, B: BsdfInLanes>(
    ctx: &TraceContext<'a>,
    inputs: &ShadingInputs,
    parameters: &ParametersInLanes,
    (light_samples, samples_lights): (u32, u32),
    surface_index: u32,
    mut test_light: impl FnMut(&LightOfPaths<'a>),
) -> ScatteredPaths {
    let &ShadingInputs { origin, normal, shading_normal, throughput, choice, scatter: [u, v], lobe, .. } = inputs;
    // Light through the geometric surface is lost.
    let crosses_surface = |direction: FieldVec3<f32x8>| {
        Mask8(direction.dot(normal).simd_lt(f32x8::ZERO)) & f32x8::truth(ctx.config.shading_normals)
    };
    let basis = Basis8::new(shading_normal);
    let wo = basis.local_viewer(inputs.to_viewer);
    let bsdf = B::new(parameters, wo, mask_of(inputs.inside));

    let share = f32x8::splat(1.0 / light_samples as f32);
    for sample in 0..light_samples {
        let (choice, position) = nth_light_sample(sample, light_samples, choice[0], inputs.light);
        let lights = choose_lights(ctx, origin, shading_normal, choice, samples_lights);
        let light = sample_directions(ctx, &lights, origin, position);
        let wi = basis.to_local(light.direction);
        let evaluated = bsdf.eval(parameters, wo, wi);
        let is_lit = light.exist
            & !crosses_surface(light.direction)
            & Mask8(wi.z.simd_gt(f32x8::ZERO))
            & Mask8(evaluated.value.largest().simd_gt(f32x8::ZERO));
        test_light(&LightOfPaths {
            lit: is_lit.0.to_bitmask(),
            direction: light.direction,
            radiance: throughput.times(evaluated.value).times(light.irradiance) * share,
            weight: sample_weights(ctx.config.direct_lighting, light.pdf, evaluated.pdf),
            distance: light.distance,
            shapes: lights.shapes,
        });
    }

    let scattered = bsdf.sample(parameters, wo, [u, v, lobe]);
    let direction = basis.to_world(scattered.wi).renormalized();
    let goes_on = Mask8(scattered.wi.z.simd_gt(f32x8::ZERO)) & !crosses_surface(direction);
    let throughput = throughput.times(scattered.weight);
    let (throughput, survive) = roulette(throughput, inputs.index_square, choice[1], surface_index);
    ScatteredPaths { direction, throughput, pdf: scattered.pdf, goes_on: goes_on.0.to_bitmask() & survive }
}

/// Russian roulette with a random number for each path, as [`Path::survives`]: the throughputs of those that survive, and a bit for
/// each.
#[inline(always)]
pub(super) fn roulette(
    throughput: FieldVec3<f32x8>,
    index_square: f32x8,
    random: f32x8,
    surface_index: u32,
) -> (FieldVec3<f32x8>, u32) {
    if surface_index <= ROULETTE_DEPTH {
        return (throughput, 0xff);
    }
    let survival_probability = f32x8::splat(SURVIVAL_FACTOR) * throughput.largest() * index_square;
    let survival_probability = survival_probability.fast_min(f32x8::ONE);
    (throughput / survival_probability, random.simd_lt(survival_probability).to_bitmask())
}

/// What [`shade_lanes`] reads of eight surfaces, their paths and random numbers.
pub(super) struct ShadingInputs {
    /// Origins of rays that leave the surfaces, in world space.
    pub(super) origin: FieldVec3<f32x8>,
    /// Unit geometric normals.
    pub(super) normal: FieldVec3<f32x8>,
    /// Unit shading normals.
    pub(super) shading_normal: FieldVec3<f32x8>,
    /// Unit vectors back along the paths.
    pub(super) to_viewer: FieldVec3<f32x8>,
    pub(super) throughput: FieldVec3<f32x8>,
    /// Square of the refractive index around the paths.
    pub(super) index_square: f32x8,
    /// Surfaces that are seen from within their solids, a bit for each.
    pub(super) inside: u32,
    /// As in [`SurfaceSamples`].
    pub(super) choice: [f32x8; 2],
    pub(super) light: [f32x8; 2],
    pub(super) scatter: [f32x8; 2],
    pub(super) lobe: f32x8,
}

/// Textured points of one to eight surfaces at the ends of these paths, where they have textures.
fn textured_points<'a>(
    ctx: &'a TraceContext,
    paths: &[Path],
    surfaces: &[SurfaceOfPath<'a>],
) -> [Option<TexturedPoint<'a>>; 8] {
    let point = |(index, interaction): &SurfaceOfPath<'a>| TexturedPoint::new(ctx, interaction, paths[*index].length);
    std::array::from_fn(|lane| surfaces.get(lane).and_then(point))
}

impl ShadingInputs {
    /// Inputs of one to eight surfaces, and a bit for each that is no mirror.
    #[inline(always)]
    fn new(
        ctx: &TraceContext,
        paths: &[Path],
        surfaces: &[SurfaceOfPath],
        points: &[Option<TexturedPoint>; 8],
        samples: &SurfaceSamples,
    ) -> (Self, u32) {
        let (mut origins, mut samples_lights, mut inside) = ([Vec3::ZERO; 8], 0, 0);
        let mut components = [[0.0; 8]; 20];
        for (lane, &(index, interaction)) in surfaces.iter().enumerate() {
            let (path, SurfaceInteraction { p, normal: n, normal_offset, .. }) = (&paths[index], interaction);
            let ns = shading_normal(ctx.config, points[lane].as_ref(), interaction, -path.ray.direction);
            origins[lane] = p + normal_offset;
            samples_lights |= u32::from(!ctx.scene.material_of(interaction.leaf).has(DELTA)) << lane;
            inside |= u32::from(interaction.inside) << lane;
            let SurfaceSample { choice: [a, b], light: [c, d], scatter: [e, f], lobe: [g, _], .. } = samples.of(index);
            let (v, t) = (-path.ray.direction, path.throughput);
            let values =
                [n.x, n.y, n.z, ns.x, ns.y, ns.z, v.x, v.y, v.z, t.x, t.y, t.z, path.index_square, a, b, c, d, e, f, g];
            for (component, value) in components.iter_mut().zip(values) {
                component[lane] = value;
            }
        }
        let [nx, ny, nz, sx, sy, sz, vx, vy, vz, tr, tg, tb, index_square, a, b, c, d, e, f, lobe] =
            components.map(f32x8::from);
        let inputs = Self {
            origin: pack(origins),
            normal: FieldVec3::new(nx, ny, nz),
            shading_normal: FieldVec3::new(sx, sy, sz),
            to_viewer: FieldVec3::new(vx, vy, vz),
            throughput: FieldVec3::new(tr, tg, tb),
            index_square,
            inside,
            choice: [a, b],
            light: [c, d],
            scatter: [e, f],
            lobe,
        };
        (inputs, samples_lights)
    }
}
