//! What of a light would fall on a surface if nothing were in its way, without noise: for previews.
//!
//! - **Points and suns** as they are.
//! - **Spheres** of which a part may be below the horizon: π L sin² times the cosine, smoothly clipped where the sphere
//!   touches the horizon. Boxes are taken for spheres of the same surface, any other shape for a sphere of the disc that it
//!   shows on average.
//! - **Rectangles** exactly above the horizon, by Lambert's sum over edges (Lambert 1760; Baum, Rushmeier and Winget 1989),
//!   its terms in the approximation of Heitz, Dupuy, Hill and Neubelt 2016 ("Real-Time Polygonal-Light Shading with Linearly
//!   Transformed Cosines"); clipped at the horizon as a sphere of the same form factor (Hill and Heitz 2017). Discs are taken
//!   for squares of the same area.

use super::lights::{BOX, DISC, LightRecord, POINT, RECT, SUN};
use glam::Vec3;
use std::f32::consts::PI;

/// Light that falls on a surface if nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Falling {
    /// To the middle of what is seen of the light, of length one.
    pub(super) direction: Vec3,
    /// Metres up to which something may be in the way.
    pub(super) distance: f32,
    /// On the surface, its cosine included, W/m².
    pub(super) irradiance: Vec3,
    /// Sine of half the angle that the light fills.
    pub(super) sine: f32,
}

/// The light that falls on the point `p` of a surface with normal `n`. A light that is neither point, sun, sheet nor sphere is
/// seen as a sphere of `radius`.
pub(super) fn falling(light: &LightRecord, radius: f32, p: Vec3, n: Vec3) -> Falling {
    let power = Vec3::from(light.power);
    if light.kind == SUN {
        let direction = Vec3::from(light.place);
        let sine = (light.extent * (2.0 - light.extent)).max(0.0).sqrt();
        let irradiance = power * direction.dot(n).max(0.0);
        return Falling { direction, distance: f32::INFINITY, irradiance, sine };
    }
    let offset = Vec3::from(light.place) - p;
    let square = offset.length_squared().max(1e-12);
    let distance = square.sqrt();
    let direction = offset / distance;
    if light.kind == POINT {
        let irradiance = power * (direction.dot(n).max(0.0) / square);
        return Falling { direction, distance, irradiance, sine: 0.0 };
    }
    if light.kind == RECT || light.kind == DISC {
        return from_sheet(light, offset, n);
    }
    let sine = (radius / distance).min(1.0);
    let irradiance = power * (PI * sine * sine * above_horizon(direction.dot(n), sine));
    Falling { direction, distance: (distance - radius).max(0.0), irradiance, sine }
}

/// Radius of the sphere as which a light is seen.
pub(super) fn seen_radius(light: &LightRecord) -> f32 {
    if light.kind == BOX {
        let [x, y, z] = [light.x, light.y, light.z].map(|axis| Vec3::from(axis).length());
        return (8.0 * (x * y + y * z + z * x) / (4.0 * PI)).sqrt();
    }
    light.extent
}

/// The cosine of a sphere's middle, or what is left of it where the horizon cuts the sphere.
fn above_horizon(cosine: f32, sine: f32) -> f32 {
    if cosine >= sine {
        return cosine;
    }
    let shown = (cosine + sine).max(0.0);
    shown * shown / (4.0 * sine).max(1e-6)
}

fn from_sheet(light: &LightRecord, offset: Vec3, n: Vec3) -> Falling {
    let facing = Vec3::from(light.y);
    let (mut x, mut z) = (Vec3::from(light.x), Vec3::from(light.z));
    if light.kind == DISC {
        // Half the edge of a square.
        let half = 0.886_226_9 * light.extent;
        (x, z) = (x * half, z * half);
    }
    let below = -offset.dot(facing);
    let corners = [offset + x + z, offset + x - z, offset - x - z, offset - x + z].map(|v| v.normalize_or(Vec3::Y));
    let mut factor = Vec3::ZERO;
    for k in 0..4 {
        factor += edge(corners[k], corners[(k + 1) % 4]);
    }
    factor *= factor.dot(offset).signum();
    let share = factor.length();
    if below <= 0.0 || share < 1e-9 {
        return Falling { direction: facing, distance: 0.0, irradiance: Vec3::ZERO, sine: 0.0 };
    }
    let direction = factor / share;
    let toward = -direction.dot(facing);
    let distance = below / toward.max(1e-4);
    let radius = (4.0 / PI * x.length() * z.length()).sqrt();
    let irradiance = Vec3::from(light.power) * (PI * share * above_horizon(direction.dot(n), share.min(1.0).sqrt()));
    // A surface beside the sheet is not in its way: across the plane of both, the sheet is this narrow.
    let narrow = radius * toward.max(0.0);
    let sine = narrow / (narrow * narrow + distance * distance).sqrt();
    Falling { direction, distance: distance * (1.0 - radius / distance).max(0.3), irradiance, sine }
}

/// Angle between two directions times the unit vector across both, over 2π.
fn edge(a: Vec3, b: Vec3) -> Vec3 {
    let x = a.dot(b);
    let y = x.abs();
    let v = (0.854_398_5 + (0.496_515_5 + 0.014_520_6 * y) * y) / (3.417_594 + (4.161_672_4 + y) * y);
    let angle = if x > 0.0 { v } else { 0.5 / (1.0 - x * x).max(1e-7).sqrt() - v };
    a.cross(b) * angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::lights::SPHERE;
    use bytemuck::Zeroable;

    /// A square lamp of half edge `half` at height 1 above the origin, facing down.
    fn square(half: f32) -> LightRecord {
        let mut light = above(RECT);
        (light.x, light.y, light.z) = ([half, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, half]);
        light
    }

    /// A light of this kind and power 1, one metre above the origin.
    fn above(kind: u32) -> LightRecord {
        let mut light = LightRecord::zeroed();
        (light.kind, light.power, light.place) = (kind, [1.0; 3], [0.0, 1.0, 0.0]);
        light
    }

    #[test]
    fn a_square_gives_its_form_factor() {
        // Siegel and Howell: a parallel square above a point, four times that of a quarter over its corner.
        for half in [0.01f32, 0.3, 1.0, 4.0] {
            let leg = half / (1.0 + half * half).sqrt();
            let expected = 4.0 * leg * leg.atan();
            let found = falling(&square(half), 0.0, Vec3::ZERO, Vec3::Y);
            assert!((found.irradiance.x / expected - 1.0).abs() < 0.01, "{half}: {} {expected}", found.irradiance.x);
            assert!(found.direction.distance(Vec3::Y) < 1e-3 && found.distance <= 1.0);
        }
        let above = falling(&square(1.0), 0.0, Vec3::new(0.0, 1.5, 0.0), Vec3::NEG_Y);
        assert_eq!(above.irradiance, Vec3::ZERO, "it shines on one side");
    }

    #[test]
    fn a_sphere_that_the_horizon_cuts_fades() {
        let mut sphere = above(SPHERE);
        sphere.extent = 0.5;
        let irradiance = |degrees: f32| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            falling(&sphere, seen_radius(&sphere), Vec3::ZERO, Vec3::new(sine, cosine, 0.0)).irradiance.x
        };
        assert!((irradiance(0.0) / (PI * 0.25) - 1.0).abs() < 1e-5);
        assert!((irradiance(45.0) / irradiance(0.0) - std::f32::consts::FRAC_1_SQRT_2).abs() < 1e-5);
        assert!(irradiance(90.0) > 0.0 && irradiance(90.0) < irradiance(80.0) && irradiance(121.0) == 0.0);
    }
}
