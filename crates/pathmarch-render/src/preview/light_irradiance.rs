//! Irradiance of unoccluded lights in closed form, for previews.
//!
//! - **Points, spots and suns**: exact.
//! - **Spheres**: π L sin² times the cosine, smoothly clipped where the horizon cuts the sphere. A box is approximated
//!   by a sphere of the same surface area, any other shape by a sphere of the same average visible area.
//! - **Rectangles**: exact above the horizon, by Lambert's sum over edges (Lambert 1760; Baum, Rushmeier and Winget
//!   1989) with the approximated terms of Heitz, Dupuy, Hill and Neubelt 2016 ("Real-Time Polygonal-Light Shading with
//!   Linearly Transformed Cosines"). The horizon clips a sphere of the same form factor (Hill and Heitz 2017). Discs
//!   are approximated by squares of the same area.

use crate::scene::light::{LightShape, SheetLight, TrianglesLight};
use glam::Vec3;
use std::f32::consts::PI;

/// Unoccluded light at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnoccludedLight {
    /// Unit vector to the centre of the light's part above the horizon.
    pub(super) direction: Vec3,
    /// Largest distance of an occluder, metres.
    pub(super) distance: f32,
    /// Irradiance of the surface, cosine included, W/m².
    pub(super) irradiance: Vec3,
    /// Sine of half the angle that the light subtends.
    pub(super) sine: f32,
}

/// Unoccluded light at the point `p` of a surface with normal `n`. A sphere of `radius` replaces boxes and bounded
/// lights.
pub(super) fn unoccluded_light(light: &LightShape, radius: f32, p: Vec3, n: Vec3) -> UnoccludedLight {
    match light {
        LightShape::Sun(sun) => {
            let direction = sun.direction;
            let sine = (sun.one_minus_cos * (2.0 - sun.one_minus_cos)).max(0.0).sqrt();
            let irradiance = sun.irradiance * direction.dot(n).max(0.0);
            UnoccludedLight { direction, distance: f32::INFINITY, irradiance, sine }
        }
        LightShape::Point(point) => {
            let (direction, distance, square) = towards(point.position, p);
            let irradiance = point.radiant_intensity * (direction.dot(n).max(0.0) / square);
            UnoccludedLight { direction, distance, irradiance, sine: 0.0 }
        }
        LightShape::Spot(spot) => {
            let (direction, distance, square) = towards(spot.point.position, p);
            let intensity = spot.radiant_intensity_towards(-direction);
            let irradiance = intensity * (direction.dot(n).max(0.0) / square);
            UnoccludedLight { direction, distance, irradiance, sine: 0.0 }
        }
        LightShape::Rect(sheet) => from_sheet(sheet, sheet.axes, p, n),
        LightShape::Disc(sheet) => {
            // Half side of a square of the same area.
            let half = 0.886_226_9 * sheet.radius;
            from_sheet(sheet, sheet.axes.map(|axis| axis * half), p, n)
        }
        LightShape::Sphere(sphere) | LightShape::Bounded(sphere) => {
            from_sphere(sphere.centre, sphere.radiance, radius, p, n)
        }
        LightShape::Triangles(TrianglesLight { bounds, .. }) => {
            from_sphere(bounds.centre, bounds.radiance, radius, p, n)
        }
        LightShape::Box(light) => from_sphere(light.centre, light.radiance, radius, p, n),
        LightShape::Environment => UnoccludedLight { direction: n, distance: 0.0, irradiance: Vec3::ZERO, sine: 0.0 },
    }
}

/// Direction from `p` to a position, its distance, and its squared distance.
fn towards(position: Vec3, p: Vec3) -> (Vec3, f32, f32) {
    let offset = position - p;
    let square = offset.length_squared().max(1e-12);
    let distance = square.sqrt();
    (offset / distance, distance, square)
}

/// Unoccluded light of a sphere.
fn from_sphere(centre: Vec3, radiance: Vec3, radius: f32, p: Vec3, n: Vec3) -> UnoccludedLight {
    let (direction, distance, _) = towards(centre, p);
    let sine = (radius / distance).min(1.0);
    let irradiance = radiance * (PI * sine * sine * clipped_cosine(direction.dot(n), sine));
    UnoccludedLight { direction, distance: (distance - radius).max(0.0), irradiance, sine }
}

/// Radius of the sphere that approximates a light, metres.
pub(super) fn bounding_radius(light: &LightShape) -> f32 {
    match light {
        LightShape::Box(light) => {
            let [x, y, z] = light.axes.map(Vec3::length);
            (8.0 * (x * y + y * z + z * x) / (4.0 * PI)).sqrt()
        }
        LightShape::Sphere(sphere) | LightShape::Bounded(sphere) => sphere.radius,
        LightShape::Triangles(light) => light.bounds.radius,
        LightShape::Disc(sheet) => sheet.radius,
        LightShape::Sun(sun) => sun.one_minus_cos,
        LightShape::Point(_) | LightShape::Spot(_) | LightShape::Rect(_) | LightShape::Environment => 0.0,
    }
}

/// Cosine factor of a sphere's irradiance: the cosine to its centre, less where the horizon cuts the sphere.
fn clipped_cosine(cosine: f32, sine: f32) -> f32 {
    if cosine >= sine {
        return cosine;
    }
    let visible = (cosine + sine).max(0.0);
    visible * visible / (4.0 * sine).max(1e-6)
}

/// Unoccluded light of a rectangle with these half edges.
fn from_sheet(light: &SheetLight, [x, z]: [Vec3; 2], p: Vec3, n: Vec3) -> UnoccludedLight {
    let (normal, offset) = (light.normal, light.centre - p);
    let plane_distance = -offset.dot(normal);
    let corners = [offset + x + z, offset + x - z, offset - x - z, offset - x + z].map(|v| v.normalize_or(Vec3::Y));
    let mut vector_factor = Vec3::ZERO;
    for k in 0..4 {
        vector_factor += edge_term(corners[k], corners[(k + 1) % 4]);
    }
    vector_factor *= vector_factor.dot(offset).signum();
    let form_factor = vector_factor.length();
    if plane_distance <= 0.0 || form_factor < 1e-9 {
        return UnoccludedLight { direction: normal, distance: 0.0, irradiance: Vec3::ZERO, sine: 0.0 };
    }
    let direction = vector_factor / form_factor;
    let cosine = -direction.dot(normal);
    let distance = plane_distance / cosine.max(1e-4);
    let radius = (4.0 / PI * x.length() * z.length()).sqrt();
    let irradiance =
        light.radiance * (PI * form_factor * clipped_cosine(direction.dot(n), form_factor.min(1.0).sqrt()));
    // Foreshortened radius: seen from the side, the sheet is narrow, and surfaces beside it do not occlude it.
    let foreshortened_radius = radius * cosine.max(0.0);
    let sine = foreshortened_radius / (foreshortened_radius * foreshortened_radius + distance * distance).sqrt();
    UnoccludedLight { direction, distance: distance * (1.0 - radius / distance).max(0.3), irradiance, sine }
}

/// Lambert's term of an edge: the angle between two directions times the unit normal of both, divided by 2π.
fn edge_term(a: Vec3, b: Vec3) -> Vec3 {
    let x = a.dot(b);
    let y = x.abs();
    let v = (0.854_398_5 + (0.496_515_5 + 0.014_520_6 * y) * y) / (3.417_594 + (4.161_672_4 + y) * y);
    let angle = if x > 0.0 { v } else { 0.5 / (1.0 - x * x).max(1e-7).sqrt() - v };
    a.cross(b) * angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::light::SphereLight;

    /// Square with half side `half` at height 1 above the origin, facing down.
    fn square(half: f32) -> LightShape {
        LightShape::Rect(SheetLight {
            centre: Vec3::Y,
            axes: [Vec3::X * half, Vec3::Z * half],
            normal: Vec3::NEG_Y,
            radius: 0.0,
            area: 4.0 * half * half,
            radiance: Vec3::ONE,
            leaf: 0,
        })
    }

    #[test]
    fn a_square_has_its_form_factor() {
        // Siegel and Howell: a parallel square above a point, four times that of a quarter over its corner.
        for half in [0.01f32, 0.3, 1.0, 4.0] {
            let leg = half / (1.0 + half * half).sqrt();
            let expected = 4.0 * leg * leg.atan();
            let found = unoccluded_light(&square(half), 0.0, Vec3::ZERO, Vec3::Y);
            assert!((found.irradiance.x / expected - 1.0).abs() < 0.01, "{half}: {} {expected}", found.irradiance.x);
            assert!(found.direction.distance(Vec3::Y) < 1e-3 && found.distance <= 1.0);
        }
        let above = unoccluded_light(&square(1.0), 0.0, Vec3::new(0.0, 1.5, 0.0), Vec3::NEG_Y);
        assert_eq!(above.irradiance, Vec3::ZERO, "it shines on one side");
    }

    #[test]
    fn a_sphere_that_the_horizon_cuts_fades() {
        let sphere = LightShape::Sphere(SphereLight { centre: Vec3::Y, radius: 0.5, radiance: Vec3::ONE, leaf: 0 });
        let irradiance = |degrees: f32| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            unoccluded_light(&sphere, bounding_radius(&sphere), Vec3::ZERO, Vec3::new(sine, cosine, 0.0)).irradiance.x
        };
        assert!((irradiance(0.0) / (PI * 0.25) - 1.0).abs() < 1e-5);
        assert!((irradiance(45.0) / irradiance(0.0) - std::f32::consts::FRAC_1_SQRT_2).abs() < 1e-5);
        assert!(irradiance(90.0) > 0.0 && irradiance(90.0) < irradiance(80.0) && irradiance(121.0) == 0.0);
    }
}
