//! Participating media: homogeneous media that absorb, scatter and emit light (Chandrasekhar 1950, "Radiative Transfer").
//!
//! **Idea.** On each segment of a path in a medium that scatters, two things are sampled. (1) The distance of the next
//! scattering event: for one channel, chosen in proportion to the throughput, by its extinction; the balance heuristic over
//! the channels weights the event, so that the weight is never larger than three and coloured media are unbiased (the single-sample
//! model of Veach 1997, section 9.2.4; spectral MIS of Wilkie et al. 2014). If the event lies beyond the surface, the path
//! arrives there. (2) Independently of it, a point of the segment at which one light is sampled. Half of these points
//! are *equiangular*, uniform in the angle around the light (Kulla and Fajardo 2012, "Importance Sampling Techniques for
//! Path Tracing in Participating Media"); the others have the density of (1), within the segment. The balance heuristic
//! weights both. The light is chosen for the segment, by the [light tree](crate::scene::light_tree) if there is one. So light near
//! a lamp converges, thin fog is lit by every path, and each segment costs one shadow ray.
//! The radius of the light is the least distance from its centre that equiangular points assume.
//!
//! At an event, the phase function of Henyey and Greenstein (1941) is sampled; the power heuristic weights lights that
//! the ray hits against those that are sampled, as at surfaces. Emission along a segment is integrated in closed form.
//!
//! **Cost.** A shadow ray and two exponentials for each segment in a medium that scatters.

use super::light_sampling::{ChosenLight, choose_light_along};
use super::medium::{UNBOUNDED_LENGTH, transmittance};
use crate::intersect::ray::Ray;
use crate::sampling::basis::{basis, renormalized};
use crate::scene::{Medium, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::unit_circle;
use std::f32::consts::PI;

shared_constants! {
    /// Optical depth below which a series replaces 1 - exp(-x).
    const SMALL_DEPTH: f32 = 0.02;
    /// Anisotropy below which the phase function is sampled as an isotropic one.
    const ISOTROPIC: f32 = 1e-3;
    /// Optical depth of the part of a segment for which a light is chosen.
    const LIT_DEPTH: f32 = 2.0;
    /// Least distance of a light from a ray for equiangular points, divided by its distance from the origin of the ray.
    const SMALLEST_HEIGHT: f32 = 1e-4;
}

/// Transmittance over a length in metres, within these solids.
#[inline]
pub(super) fn transmittance_in(ctx: &TraceContext, solids: &Medium, length: f32) -> Vec3 {
    let medium = if ctx.config.media { &solids.with_fog(&ctx.scene.media.fog) } else { solids };
    transmittance(medium.extinction(), length)
}

/// Media of the solids beyond the surface of a leaf that a path crosses.
#[inline]
pub(super) fn medium_after(ctx: &TraceContext, solids: &Medium, leaf: usize, inside: bool) -> Medium {
    if ctx.config.nested_dielectrics {
        return ctx.scene.medium_across(solids, leaf, inside);
    }
    let solid = &ctx.scene.media.of_materials[ctx.scene.leaves[leaf].material as usize];
    if ctx.config.media {
        return solids.beyond(solid, inside);
    }
    Medium { absorption: super::medium::medium_beyond(solids.absorption, solid.absorption, inside), ..*solids }
}

/// 1 - exp(-x), without cancellation for small x.
fn absorbed_share(x: f32) -> f32 {
    if x < SMALL_DEPTH { x * (1.0 - x * (0.5 - x * 0.166_666_67)) } else { 1.0 - (-x).exp() }
}

/// Radiance that a medium adds to light along a length in metres.
pub(super) fn emitted_radiance(medium: &Medium, length: f32) -> Vec3 {
    let extinction = medium.extinction();
    let limited = length.min(UNBOUNDED_LENGTH);
    let mean_transmittance = |extinction: f32| {
        if extinction > 0.0 { absorbed_share(extinction * limited) / extinction } else { limited }
    };
    medium.emission * Vec3::from(extinction.to_array().map(mean_transmittance))
}

/// Henyey and Greenstein's phase function, 1/sr, for the cosine between the directions before and after.
pub(super) fn phase_function(anisotropy: f32, cosine: f32) -> f32 {
    let g = anisotropy;
    let square = (1.0 + g * g - 2.0 * g * cosine).max(1e-12);
    (1.0 - g * g) / (4.0 * PI * square * square.sqrt())
}

/// Direction that the phase function chooses.
pub(super) fn sample_phase(anisotropy: f32, incoming: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let g = anisotropy;
    let mut cosine = 1.0 - 2.0 * u;
    if g.abs() > ISOTROPIC {
        let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
        cosine = ((1.0 + g * g - root * root) / (2.0 * g)).clamp(-1.0, 1.0);
    }
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let [cos_phi, sin_phi] = unit_circle(v);
    renormalized(basis(incoming) * Vec3::new(sine * cos_phi, sine * sin_phi, cosine))
}

/// Probabilities of the channels, in proportion to what they carry.
fn channel_weights(carried: Vec3) -> Vec3 {
    let sum = carried.x + carried.y + carried.z;
    if sum > 0.0 { carried / sum } else { Vec3::splat(1.0 / 3.0) }
}

/// Index of the channel that a random number chooses.
fn channel(weights: Vec3, random: f32) -> usize {
    match () {
        () if random < weights.x => 0,
        () if random < weights.x + weights.y => 1,
        () => 2,
    }
}

/// Samples the distance to the next scattering event on a segment of this length. Returns it, or `None` where the segment
/// has none, and the weight of the path.
pub(super) fn sample_distance(medium: &Medium, throughput: Vec3, length: f32, [u, v]: [f32; 2]) -> (Option<f32>, Vec3) {
    let extinction = medium.extinction();
    let weights = channel_weights(throughput);
    let sigma = extinction[channel(weights, v)];
    if sigma > 0.0 {
        let t = -(1.0 - u).ln() / sigma;
        if t < length.min(UNBOUNDED_LENGTH) {
            let remaining = (-extinction * t).exp();
            return (Some(t), remaining * medium.scattering / weights.dot(extinction * remaining));
        }
    }
    let remaining = transmittance(extinction, length);
    (None, remaining / weights.dot(remaining))
}

/// Light that a medium may scatter into a path: the light, and the point of the segment from which it is sampled.
pub(super) struct SegmentPoint<'a> {
    pub(super) light: ChosenLight<'a>,
    /// Distance from the origin of the segment, metres.
    pub(super) distance: f32,
    /// Pdf of the distance, 1/m.
    pub(super) pdf: f32,
}

/// Chooses a light with the uniform number `choice`, and a point of a segment for the light that it scatters.
pub(super) fn sample_point<'a>(
    ctx: &TraceContext<'a>,
    ray: &Ray,
    length: f32,
    medium: &Medium,
    throughput: Vec3,
    choice: f32,
    [u, v]: [f32; 2],
) -> Option<SegmentPoint<'a>> {
    let limited = length.min(UNBOUNDED_LENGTH);
    let extinction = medium.extinction();
    let lit_length = limited.min(LIT_DEPTH / extinction.min_element()).min(ctx.frame.far);
    let light = choose_light_along(ctx, ray, lit_length, choice)?;
    let weights = channel_weights(throughput * medium.scattering);
    let near = light.shape.extent().map(|(centre, radius)| Equiangular::new(ray, limited, centre, radius));
    let choice = if near.is_some() { 2.0 * v } else { v };
    let t = match &near {
        Some(equiangular) if choice < 1.0 => equiangular.distance(u),
        _ => {
            let choice = if near.is_some() { choice - 1.0 } else { choice };
            let sigma = extinction[channel(weights, choice)];
            if sigma > 0.0 {
                let y = u * absorbed_share(sigma * limited);
                let series = y * (1.0 + y * (0.5 + y * (0.333_333_33 + y * 0.25)));
                (if y < SMALL_DEPTH { series } else { -(1.0 - y).ln() }) / sigma
            } else {
                u * limited
            }
        }
    };
    let t = t.clamp(0.0, limited);
    let density = |sigma: f32| match sigma > 0.0 {
        true => sigma * (-sigma * t).exp() / absorbed_share(sigma * limited),
        false => 1.0 / limited,
    };
    let pdf = weights.dot(Vec3::from(extinction.to_array().map(density)));
    let pdf = near.map_or(pdf, |equiangular| 0.5 * (pdf + equiangular.pdf(t)));
    Some(SegmentPoint { light, distance: t, pdf })
}

/// Points of a segment, uniform in the angle around a light.
struct Equiangular {
    /// Distance along the ray of the point that is nearest to the light, metres.
    axis: f32,
    /// Distance of that point from the light, metres.
    height: f32,
    /// Angle at which the segment begins, and the angle that it takes, radians.
    first_angle: f32,
    angle: f32,
}

impl Equiangular {
    fn new(ray: &Ray, length: f32, centre: Vec3, radius: f32) -> Self {
        let offset = centre - ray.origin;
        let axis = offset.dot(ray.direction);
        let across = (offset - ray.direction * axis).length();
        let height = across.max(radius).max((SMALLEST_HEIGHT * offset.length()).max(1e-18));
        let first_angle = (-axis).atan2(height);
        let angle = ((length - axis).atan2(height) - first_angle).max(1e-12);
        Self { axis, height, first_angle, angle }
    }

    fn distance(&self, random: f32) -> f32 {
        self.axis + self.height * (self.first_angle + self.angle * random).tan()
    }

    fn pdf(&self, t: f32) -> f32 {
        let d = t - self.axis;
        self.height / (self.angle * (self.height * self.height + d * d))
    }
}
