//! Lambertian surfaces, shaded in SIMD lanes, eight paths at a time.
//!
//! They are most surfaces of most scenes. What [`path`](super::path) does for surfaces of any material is done here for these:
//! one light is sampled, and the scattered ray is sampled by the cosine, so that its weight is the albedo.

use super::light_sampling::{ChosenLight, choose_light};
use super::light_sampling_lanes::sample_directions;
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

/// Reports whether [`shade`] may shade this leaf.
pub(super) fn is_lambertian(ctx: &TraceContext, leaf: usize) -> bool {
    !ctx.config.traced_caustics && ctx.scene.material_of(leaf).has(LAMBERTIAN)
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
    // Copies of the last surface fill the last lanes.
    let surface = |lane: usize| surfaces[lane.min(count - 1)];
    let (mut albedo, mut ns) = ([Vec3::ZERO; 8], [Vec3::Y; 8]);
    for lane in 0..8 {
        let (index, interaction) = surface(lane);
        (albedo[lane], ns[lane]) = albedo_and_normal(ctx, &paths[index], interaction);
    }
    let of_interaction = |vector: fn(&SurfaceInteraction) -> Vec3| pack(std::array::from_fn(|lane| vector(surface(lane).1)));
    let numbers = |pairs: &[[f32; 2]]| [0, 1].map(|k| lanes(|lane| pairs[surface(lane).0][k]));
    let origin = of_interaction(|interaction| interaction.p) + of_interaction(|interaction| interaction.normal_offset);
    let origins = unpack(origin);
    let (shading_normal, normal) = (pack(ns), of_interaction(|interaction| interaction.normal));
    // Light through the geometric surface is lost.
    let crosses_surface = |direction: FieldVec3<f32x8>| {
        Mask8(direction.dot(normal).simd_lt(f32x8::ZERO)) & f32x8::truth(ctx.config.shading_normals)
    };
    let albedo_in_lanes = pack(albedo);
    let mut throughput = pack(std::array::from_fn(|lane| paths[surface(lane).0].throughput));

    let lights: [Option<ChosenLight>; 8] = std::array::from_fn(|lane| {
        let choice = samples.choice[surface(lane).0][0];
        choose_light(ctx, origins[lane], Some(ns[lane]), choice)
    });
    let light = sample_directions(ctx, &lights, origin, numbers(&samples.light));
    let cosine = shading_normal.dot(light.direction);
    let pdf = cosine * f32x8::splat(FRAC_1_PI);
    let reflected = times(albedo_in_lanes, throughput) * pdf;
    let is_lit = light.exist & !crosses_surface(light.direction) & Mask8(cosine.simd_gt(f32x8::ZERO))
        & Mask8(albedo_in_lanes.largest().simd_gt(f32x8::ZERO));
    let lit = is_lit.0.to_bitmask();
    if lit != 0 {
        let (directions, irradiance) = (unpack(light.direction), unpack(light.irradiance));
        let (radiance, pdf) = (unpack(times(reflected, light.irradiance)), pdf.to_array());
        for (lane, chosen) in lights.iter().enumerate().take(count).filter(|(lane, _)| lit >> lane & 1 == 1) {
            let (Some(chosen), path) = (chosen, &paths[surface(lane).0]) else { continue };
            shadow_tests.push(ShadowTest {
                slot: path.slot,
                radiance: radiance[lane],
                scatter_pdf: pdf[lane],
                ray: Ray { origin: origins[lane], direction: directions[lane] },
                light: light.of_lane(lane, chosen, directions[lane], irradiance[lane]),
                path_length: path.length,
                medium: path.medium,
                sampler: path.sampler,
            });
        }
    }

    let [u, v] = numbers(&samples.scatter);
    let radius = u.sqrt();
    let (sine, cosine) = (f32x8::splat(TAU) * v).sin_cos();
    let height = (f32x8::ONE - u).fast_max(f32x8::splat(1e-8)).sqrt();
    let direction = Basis8::new(shading_normal).to_world(FieldVec3::new(radius * cosine, radius * sine, height));
    let direction = direction / direction.length();
    throughput = times(throughput, albedo_in_lanes);
    let mut goes_on = !crosses_surface(direction);
    if surface_index > ROULETTE_DEPTH {
        let [_, random] = numbers(&samples.choice);
        let index_square = lanes(|lane| paths[surface(lane).0].index_square);
        let survival_probability = f32x8::splat(SURVIVAL_FACTOR) * throughput.largest() * index_square;
        let survival_probability = survival_probability.fast_min(f32x8::ONE);
        goes_on = goes_on & Mask8(random.simd_lt(survival_probability));
        throughput = throughput / survival_probability;
    }
    let (directions, throughputs) = (unpack(direction), unpack(throughput));
    let scatter_pdfs = (height * f32x8::splat(FRAC_1_PI)).to_array();
    for lane in 0..count {
        let path = &mut paths[surface(lane).0];
        path.previous_vertex = origins[lane];
        path.previous_normal = Some(ns[lane]);
        path.throughput = throughputs[lane];
        path.lights_are_counted = false;
        path.ray = Ray { origin: origins[lane], direction: directions[lane] };
        path.scatter_pdf = scatter_pdfs[lane];
    }
    goes_on.0.to_bitmask() & ((1 << count) - 1)
}

/// Products of the components.
fn times(a: FieldVec3<f32x8>, b: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
    FieldVec3::new(a.x * b.x, a.y * b.y, a.z * b.z)
}
