//! State of a path on its way from the camera, and what all kinds of its segments share.

use super::light_sampling;
use crate::intersect::ray::Ray;
use crate::sampling::sobol::PixelSampler;
use crate::scene::frame::NO_CLAMP;
use crate::scene::{Medium, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::dispersion;
use wide::f32x8;

shared_constants! {
    /// Survival probability of a path divided by its throughput: Russian roulette never ends a path of throughput 1/3
    /// or more.
    pub(super) const SURVIVAL_FACTOR: f32 = 3.0;
    /// Number of bounces without Russian roulette.
    pub(super) const ROULETTE_DEPTH: u32 = 4;
}

/// Path before its next surface.
#[derive(Clone)]
pub(super) struct Path {
    /// Index into the radiances of all paths.
    pub(super) slot: usize,
    pub(super) sampler: PixelSampler,
    pub(super) ray: Ray,
    /// Point that the light at the previous surface was sampled from, in world space.
    pub(super) previous_vertex: Vec3,
    /// Shading normal of the previous surface; `None` if it transmits, or in a medium, so that light arrives on both
    /// sides.
    pub(super) previous_normal: Option<Vec3>,
    pub(super) throughput: Vec3,
    /// Length from the camera, metres.
    pub(super) length: f32,
    /// Pdf of the ray's direction over solid angle; 0 for a delta distribution.
    pub(super) scatter_pdf: f32,
    /// Media of the solids around the path.
    pub(super) medium: Medium,
    /// True if others have contributed the lights that the ray hits: with fast caustics shadow rays, if it has only
    /// passed through clear glass since it last sampled a light; with traced caustics photons, if it has only met
    /// focusing surfaces since it met photons.
    pub(super) lights_are_counted: bool,
    /// True if the path met photons where it last scattered at anything but a focusing surface: at a surface, not in a
    /// medium.
    pub(super) met_photons: bool,
    /// Square of the refractive index around the path.
    pub(super) index_square: f32,
    /// Wavelength, nanometres; `None` before the first surface that disperses.
    pub(super) wavelength: Option<f32>,
}

impl Path {
    /// Russian roulette with a random number. Returns false if the path ends.
    pub(super) fn survives(&mut self, surface_index: u32, random: f32) -> bool {
        if surface_index > ROULETTE_DEPTH {
            let survival_probability = (SURVIVAL_FACTOR * self.throughput.max_element() * self.index_square).min(1.0);
            if random >= survival_probability {
                return false;
            }
            self.throughput /= survival_probability;
        }
        true
    }

    /// Radiance of the sky and the suns for the path if it escapes, times its MIS weight.
    pub(super) fn escaped_radiance(&self, ctx: &TraceContext) -> Vec3 {
        escaped_radiance(ctx, self.lights_are_counted, self.ray.direction, self.scatter_pdf)
    }

    /// Footprint of a surface at `p` for photons, see [`LitSurface::footprint`](crate::scene::photon_map::LitSurface).
    pub(super) fn footprint(&self, p: Vec3) -> f32 {
        match () {
            () if self.lights_are_counted => f32::INFINITY,
            () if self.scatter_pdf > 0.0 => p.distance_squared(self.previous_vertex) / self.scatter_pdf,
            () => 0.0,
        }
    }
}

/// Wavelength of a path, in nanometres. If it has none, a random number chooses it, and what the path carries takes its
/// colour.
pub(super) fn disperse(wavelength: &mut Option<f32>, carried: &mut Vec3, random: impl FnOnce() -> f32) -> f32 {
    *wavelength.get_or_insert_with(|| {
        let wavelength = dispersion::wavelength(random());
        *carried *= dispersion::colour(wavelength);
        wavelength
    })
}

/// Contribution of light after this many bounces; that of indirect light is clamped to the limit of the frame.
pub(super) fn clamped(ctx: &TraceContext, contribution: Vec3, bounces: u32) -> Vec3 {
    if bounces == 0 || ctx.frame.clamp >= NO_CLAMP {
        return contribution;
    }
    contribution * (ctx.frame.clamp / contribution.max_element().max(ctx.frame.clamp))
}

/// [`clamped`] in lanes.
#[inline(always)]
pub(super) fn clamped_lanes(ctx: &TraceContext, contribution: FieldVec3<f32x8>, bounces: u32) -> FieldVec3<f32x8> {
    if bounces == 0 || ctx.frame.clamp >= NO_CLAMP {
        return contribution;
    }
    let limit = f32x8::splat(ctx.frame.clamp);
    contribution * (limit / contribution.largest().fast_max(limit))
}

/// Radiance of the sky and the suns in the direction of an escaping ray with this pdf, times its MIS weight. `lights_are_counted`
/// is that of its [`Path`].
pub(super) fn escaped_radiance(
    ctx: &TraceContext,
    lights_are_counted: bool,
    direction: Vec3,
    scatter_pdf: f32,
) -> Vec3 {
    let (sky, direct_lighting) = (&ctx.scene.sky, ctx.config.direct_lighting);
    if lights_are_counted && !ctx.config.traced_caustics {
        // Shadow rays have already contributed suns and a sampled sky.
        return match sky.radiance(direction) {
            (radiance, None) => radiance,
            _ => Vec3::ZERO,
        };
    }
    let radiance = light_sampling::sky_radiance(sky, direct_lighting, direction, scatter_pdf);
    if lights_are_counted { radiance } else { radiance + light_sampling::sun_radiance(ctx, direction, scatter_pdf) }
}
