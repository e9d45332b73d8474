//! Lambertian surfaces, shaded in SIMD lanes, eight paths at a time.
//!
//! They are most surfaces of most scenes. What [`path`](super::path) does for surfaces of any material is done here for these:
//! one light is sampled, and the scattered ray is sampled by the cosine, so that its weight is the albedo.

use super::light_sampling::{ChosenLight, choose_light};
use super::light_sampling_lanes::{sample_directions, sample_weights};
use super::path::SurfaceSamples;
use super::path_state::{Path, ROULETTE_DEPTH, SURVIVAL_FACTOR};
use super::shadow::ShadowTest;
use crate::intersect::ray::{Ray, lanes, pack, unpack};
use crate::sampling::basis::Basis8;
use crate::scene::TraceContext;
use crate::scene::material::LAMBERTIAN;
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use glam::Vec3;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use std::f32::consts::{FRAC_1_PI, TAU};
use wide::f32x8;

/// Reports whether [`shade`] may shade this leaf: it knows no photons.
pub(super) fn is_lambertian(ctx: &TraceContext, leaf: usize) -> bool {
    ctx.photons.is_none() && ctx.scene.material_of(leaf).has(LAMBERTIAN)
}

/// Albedo and shading normal at the end of a path.
fn albedo_and_normal(ctx: &TraceContext, path: &Path, interaction: &SurfaceInteraction) -> (Vec3, Vec3) {
    let parameters = &ctx.scene.material_of(interaction.leaf).parameters;
    let textured = TexturedPoint::new(ctx, interaction, path.length);
    let albedo = match &textured {
        Some(textured) => Vec3::from_slice(&textured.parameters(parameters)),
        None => Vec3::from_slice(parameters),
    };
    (albedo, shading_normal(ctx.config, textured.as_ref(), interaction, -path.ray.direction))
}

/// Shades the surfaces at the ends of one to eight paths, given by the indices of the paths: samples a light of each and its
/// next ray. Returns a bit for each that goes on.
pub(super) fn shade(
    ctx: &TraceContext,
    paths: &mut [Path],
    surfaces: &[(usize, &SurfaceInteraction)],
    samples: &SurfaceSamples,
    surface_index: u32,
    shadow_tests: &mut Vec<ShadowTest>,
) -> u32 {
    let count = surfaces.len();
    let Inputs { origins, normals, normal, shading_normal, albedo, throughput, choice, light, scatter } =
        Inputs::new(ctx, paths, surfaces, samples);
    // Light through the geometric surface is lost.
    let crosses_surface = |direction: FieldVec3<f32x8>| {
        Mask8(direction.dot(normal).simd_lt(f32x8::ZERO)) & f32x8::truth(ctx.config.shading_normals)
    };
    let reflected = times(albedo, throughput);

    let choices = choice[0].to_array();
    let lights: [Option<ChosenLight>; 8] = std::array::from_fn(|lane| {
        (lane < count).then(|| choose_light(ctx, origins[lane], Some(normals[lane]), choices[lane])).flatten()
    });
    let light = sample_directions(ctx, &lights, pack(origins), light);
    let cosine = shading_normal.dot(light.direction);
    let pdf = cosine * f32x8::splat(FRAC_1_PI);
    let radiance = times(reflected * pdf, light.irradiance);
    let is_lit = light.exist
        & !crosses_surface(light.direction)
        & Mask8(cosine.simd_gt(f32x8::ZERO))
        & Mask8(albedo.largest().simd_gt(f32x8::ZERO));
    let lit = is_lit.0.to_bitmask();
    let weight = sample_weights(ctx.config.direct_lighting, light.pdf, pdf).to_array();
    let (directions, radiance, distance) = (unpack(light.direction), unpack(radiance), light.distance.to_array());
    for (lane, (chosen, (index, _))) in lights.iter().zip(surfaces).enumerate() {
        let Some(chosen) = chosen.as_ref().filter(|_| lit >> lane & 1 == 1) else { continue };
        let path = &paths[*index];
        shadow_tests.push(ShadowTest {
            slot: path.slot,
            radiance: radiance[lane],
            weight: weight[lane],
            ray: Ray { origin: origins[lane], direction: directions[lane] },
            distance: distance[lane],
            target: chosen.target(),
            penumbra: chosen.shape.penumbra(),
            path_length: path.length,
            medium: path.medium,
            sampler: path.sampler,
        });
    }

    let [u, v] = scatter;
    let radius = u.sqrt();
    let (sine, cosine) = (f32x8::splat(TAU) * v).sin_cos();
    let height = (f32x8::ONE - u).fast_max(f32x8::splat(1e-8)).sqrt();
    let direction = Basis8::new(shading_normal).to_world(FieldVec3::new(radius * cosine, radius * sine, height));
    let direction = direction / direction.length();
    let mut throughput = reflected;
    let mut goes_on = !crosses_surface(direction);
    if surface_index > ROULETTE_DEPTH {
        let index_square = lanes(|lane| surfaces.get(lane).map_or(1.0, |(index, _)| paths[*index].index_square));
        let survival_probability = f32x8::splat(SURVIVAL_FACTOR) * throughput.largest() * index_square;
        let survival_probability = survival_probability.fast_min(f32x8::ONE);
        goes_on = goes_on & Mask8(choice[1].simd_lt(survival_probability));
        throughput = throughput / survival_probability;
    }
    let (directions, throughputs) = (unpack(direction), unpack(throughput));
    let scatter_pdfs = (height * f32x8::splat(FRAC_1_PI)).to_array();
    for (lane, (index, _)) in surfaces.iter().enumerate() {
        let path = &mut paths[*index];
        path.previous_vertex = origins[lane];
        path.previous_normal = Some(normals[lane]);
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
    /// Unit geometric normals.
    normal: FieldVec3<f32x8>,
    /// Unit shading normals.
    shading_normal: FieldVec3<f32x8>,
    albedo: FieldVec3<f32x8>,
    throughput: FieldVec3<f32x8>,
    /// As in [`SurfaceSamples`].
    choice: [f32x8; 2],
    light: [f32x8; 2],
    scatter: [f32x8; 2],
}

impl Inputs {
    fn new(
        ctx: &TraceContext,
        paths: &[Path],
        surfaces: &[(usize, &SurfaceInteraction)],
        samples: &SurfaceSamples,
    ) -> Self {
        let (mut origins, mut normals) = ([Vec3::ZERO; 8], [Vec3::Y; 8]);
        let mut components = [[0.0; 8]; 18];
        for (lane, &(index, interaction)) in surfaces.iter().enumerate() {
            let (path, SurfaceInteraction { p, normal, normal_offset, .. }) = (&paths[index], interaction);
            let (albedo, ns) = albedo_and_normal(ctx, path, interaction);
            (origins[lane], normals[lane]) = (p + normal_offset, ns);
            let ([a, b], [c, d], [e, f]) = (samples.choice[index], samples.light[index], samples.scatter[index]);
            let (t, n) = (path.throughput, normal);
            let values =
                [n.x, n.y, n.z, ns.x, ns.y, ns.z, albedo.x, albedo.y, albedo.z, t.x, t.y, t.z, a, b, c, d, e, f];
            for (component, value) in components.iter_mut().zip(values) {
                component[lane] = value;
            }
        }
        let [nx, ny, nz, sx, sy, sz, ar, ag, ab, tr, tg, tb, a, b, c, d, e, f] = components.map(f32x8::from);
        Self {
            origins,
            normals,
            normal: FieldVec3::new(nx, ny, nz),
            shading_normal: FieldVec3::new(sx, sy, sz),
            albedo: FieldVec3::new(ar, ag, ab),
            throughput: FieldVec3::new(tr, tg, tb),
            choice: [a, b],
            light: [c, d],
            scatter: [e, f],
        }
    }
}

/// Products of the components.
fn times(a: FieldVec3<f32x8>, b: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
    FieldVec3::new(a.x * b.x, a.y * b.y, a.z * b.z)
}
