//! Starts of light paths: a light, a point on it, and a direction towards a focusing object.
//!
//! An alias table chooses a pair of a light and a target, the bounding sphere of focusing objects, in proportion to the
//! power that reaches the target. The density of a ray is the sum over all targets, so that targets may overlap. Where
//! a focusing object has no end, such as a water surface, a share of the paths goes in all directions, or from a sun to
//! a wide region around the scene.

use crate::integrator::light_sampling::{cone_direction, face_areas, mesh_radiance, sample_area, subtended_cone};
use crate::intersect::march::START_OFFSET;
use crate::intersect::ray::Ray;
use crate::sampling::alias_table;
use crate::sampling::basis::basis;
use crate::scene::leaf::IN_GLASS;
use crate::scene::light::{LightShape, PointLight, SheetLight, SphereLight, SpotLight, luminance};
use crate::scene::material::FOCUSES;
use crate::scene::medium::medium_at;
use crate::scene::{Extent, FrameUniforms, Medium, RenderScene};
use glam::Vec3;
use pathmarch_field::Aabb;
use pathmarch_field::number::unit_circle;
use pathmarch_scene::{Camera, Scene};
use std::f32::consts::{PI, TAU};

/// Largest number of targets.
const MAX_TARGETS: usize = 16;
/// Distance at which the light paths of a sun start, in distances from the middle of the scene.
const SUN_START: f32 = 8.0;

/// Unit axis of a cone, and 1 - cosine of its half angle.
type Cone = (Vec3, f32);

const ALL_DIRECTIONS: Cone = (Vec3::Y, 2.0);

/// Cone in which a spot shines.
fn cone_of(spot: &SpotLight) -> Cone {
    (spot.axis, 1.0 - spot.cos_outer)
}

/// Region at which light paths are aimed.
#[derive(Clone, Copy, Debug)]
enum Target {
    Sphere {
        centre: Vec3,
        /// Radius, metres.
        radius: f32,
    },
    /// All directions; for suns, a plane on which the density falls with the distance from the middle of the scene.
    Everywhere,
}

/// Choice of the starts of light paths.
#[derive(Clone, Debug)]
pub(crate) struct Emission {
    targets: Vec<Target>,
    /// Indices of the lights, and the media around them.
    lights: Vec<(usize, Medium)>,
    /// Alias table over all pairs of a light and a target, light by light.
    cells: Vec<alias_table::Cell>,
    /// Probability of each pair.
    probabilities: Vec<f32>,
    /// Finite part of the scene.
    extent: Extent,
}

/// Start of a light path.
pub(super) struct EmittedRay {
    pub(super) ray: Ray,
    /// Power of the path, W, if it were the only one.
    pub(super) power: Vec3,
    /// Media of the solids around the start.
    pub(super) medium: Medium,
    /// True for a sun, whose light may be blocked before the start.
    pub(super) is_parallel: bool,
}

/// Point of a light that has an area.
struct AreaPoint {
    p: Vec3,
    normal: Vec3,
    radiance: Vec3,
    /// Emits on both sides.
    is_two_sided: bool,
}

impl RenderScene {
    /// True if light paths start at a light of this shape.
    #[inline]
    pub(crate) fn starts_light_paths(&self, shape: &LightShape) -> bool {
        !matches!(shape, LightShape::Bounded(_) | LightShape::Environment)
            && !shape.leaf().is_some_and(|leaf| self.leaves[leaf as usize].has(IN_GLASS))
    }
}

impl Emission {
    /// Choice of starts for a scene. `None` if it has no focusing object or no light at which light paths start.
    pub(crate) fn new(render_scene: &RenderScene, scene: &Scene, camera: &Camera) -> Option<Self> {
        let targets = targets(render_scene);
        let extent = Extent::new(scene, camera);
        let shapes = render_scene.lights.iter().map(|light| &light.shape).enumerate();
        let traced = shapes.filter(|(_, shape)| render_scene.starts_light_paths(shape));
        let mut lights = Vec::new();
        let mut weights: Vec<f64> = Vec::new();
        for (index, shape) in traced {
            let powers: Vec<f64> =
                targets.iter().map(|target| f64::from(power_towards(shape, target, &extent))).collect();
            if powers.iter().any(|power| *power > 0.0) {
                let medium = shape
                    .extent()
                    .map_or_else(Medium::default, |(centre, _)| medium_at(scene, render_scene, centre.into()));
                lights.push((index, medium));
                weights.extend(powers);
            }
        }
        let total: f64 = weights.iter().sum();
        (total > 0.0 && total.is_finite()).then(|| Self {
            cells: alias_table::table(&weights),
            probabilities: weights.iter().map(|weight| (weight / total) as f32).collect(),
            targets,
            lights,
            extent,
        })
    }

    /// Start of a light path for uniform numbers: of the choice, of the position on the light, and of the direction.
    pub(super) fn sample(
        &self,
        scene: &RenderScene,
        frame: &FrameUniforms,
        choice: f32,
        position: [f32; 2],
        direction: [f32; 2],
    ) -> Option<EmittedRay> {
        let (pair, _) = alias_table::sample(&self.cells, choice);
        let (light, target) = (pair / self.targets.len(), pair % self.targets.len());
        let probabilities = &self.probabilities[light * self.targets.len()..][..self.targets.len()];
        let (index, medium) = self.lights[light];
        let shape = &scene.lights[index].shape;
        let emitted = |origin, direction, power, is_parallel| {
            Some(EmittedRay { ray: Ray { origin, direction }, power, medium, is_parallel })
        };
        match shape {
            LightShape::Sun(sun) => {
                let axis = cone_direction(sun.direction, sun.one_minus_cos, position);
                let (point, density) = self.parallel_point(probabilities, target, axis, direction);
                let away = point.distance(self.extent.centre);
                let start = self.extent.radius + SUN_START * away;
                let along = (self.extent.centre - point).dot(axis) + start;
                let irradiance = sun.irradiance * (2.0 / (2.0 - sun.one_minus_cos));
                emitted(point + axis * along, -axis, irradiance / density, true)
            }
            LightShape::Point(PointLight { position, radiant_intensity, .. }) => {
                let (direction, pdf) = self.direction(probabilities, target, ALL_DIRECTIONS, *position, direction);
                emitted(*position, direction, *radiant_intensity / pdf, false)
            }
            LightShape::Spot(spot) => {
                let p = spot.point.position;
                let (direction, pdf) = self.direction(probabilities, target, cone_of(spot), p, direction);
                emitted(p, direction, spot.radiant_intensity_towards(direction) / pdf, false)
            }
            _ => {
                let (point, area) = area_point(scene, shape, position)?;
                let (direction, pdf) = self.direction(probabilities, target, ALL_DIRECTIONS, point.p, direction);
                let cosine = point.normal.dot(direction);
                if cosine == 0.0 || (cosine < 0.0 && !point.is_two_sided) {
                    return None;
                }
                let offset = START_OFFSET * frame.rounding * point.p.abs().max_element();
                let origin = point.p + point.normal * offset.copysign(cosine);
                emitted(origin, direction, point.radiance * (area * cosine.abs() / pdf), false)
            }
        }
    }

    /// Direction from `p` to a target, and its pdf over solid angle, that of all targets together. `all` are the
    /// directions in which the light shines.
    fn direction(&self, probabilities: &[f32], target: usize, all: Cone, p: Vec3, random: [f32; 2]) -> (Vec3, f32) {
        let (axis, one_minus_cos) = self.targets[target].cone(p, all);
        let direction = cone_direction(axis, one_minus_cos, random);
        let density = |(index, (other, probability)): (usize, (&Target, &f32))| {
            let (axis, one_minus_cos) = other.cone(p, all);
            // By rounding, a direction at the edge of its own cone may seem to be outside.
            let inside = index == target || one_minus_cosine(axis, direction) <= one_minus_cos;
            if inside { probability / (TAU * one_minus_cos) } else { 0.0 }
        };
        let pdf: f32 = self.targets.iter().zip(probabilities).enumerate().map(density).sum();
        (direction, pdf.max(f32::MIN_POSITIVE))
    }

    /// Point of a plane across parallel light, and its pdf over area, that of all targets together.
    fn parallel_point(&self, probabilities: &[f32], target: usize, axis: Vec3, [u, v]: [f32; 2]) -> (Vec3, f32) {
        let [cos_phi, sin_phi] = unit_circle(v);
        let (middle, distance) = match &self.targets[target] {
            Target::Sphere { centre, radius } => (*centre, radius * u.sqrt()),
            Target::Everywhere => (self.extent.centre, self.extent.radius * (u / (1.0 - u).max(1e-6)).sqrt()),
        };
        let point = middle + basis(axis) * Vec3::new(distance * cos_phi, distance * sin_phi, 0.0);
        let square = |centre: Vec3| {
            let offset = point - centre;
            (offset - axis * offset.dot(axis)).length_squared()
        };
        let density = |(index, (other, probability)): (usize, (&Target, &f32))| match other {
            Target::Sphere { centre, radius } => {
                let inside = index == target || square(*centre) <= radius * radius;
                if inside { probability / (PI * radius * radius) } else { 0.0 }
            }
            Target::Everywhere => {
                let scale = self.extent.radius * self.extent.radius;
                let sum = scale + square(self.extent.centre);
                probability * scale / (PI * sum * sum)
            }
        };
        let pdf: f32 = self.targets.iter().zip(probabilities).enumerate().map(density).sum();
        (point, pdf.max(f32::MIN_POSITIVE))
    }
}

impl Target {
    /// Cone that the target subtends at `p`; `all` for all directions.
    fn cone(&self, p: Vec3, all: Cone) -> Cone {
        match self {
            Self::Sphere { centre, radius } => {
                let offset = *centre - p;
                (offset.normalize_or(Vec3::Y), subtended_cone(offset.length_squared(), *radius))
            }
            Self::Everywhere => all,
        }
    }
}

/// 1 - cosine of the angle between two unit vectors, without cancellation.
fn one_minus_cosine(a: Vec3, b: Vec3) -> f32 {
    0.5 * a.distance_squared(b)
}

/// Approximate power that a light sends to a target, W.
fn power_towards(shape: &LightShape, target: &Target, extent: &Extent) -> f32 {
    match shape {
        LightShape::Sun(sun) => {
            let radius = match target {
                Target::Sphere { radius, .. } => *radius,
                Target::Everywhere => 2.0 * extent.radius,
            };
            luminance(sun.irradiance.into()) * PI * radius * radius
        }
        LightShape::Point(light) => {
            luminance(light.radiant_intensity.into()) * TAU * target.cone(light.position, ALL_DIRECTIONS).1
        }
        LightShape::Spot(spot) => {
            let (axis, one_minus_cos) = target.cone(spot.point.position, cone_of(spot));
            let angles = [one_minus_cos, 1.0 - spot.cos_outer].map(|x| (1.0 - x).clamp(-1.0, 1.0).acos());
            if axis.angle_between(spot.axis) > angles.iter().sum::<f32>() + 1e-3 {
                return 0.0;
            }
            luminance(spot.point.radiant_intensity.into()) * TAU * one_minus_cos.min(1.0 - spot.cos_outer)
        }
        _ => {
            let Some((centre, _)) = shape.extent() else { return 0.0 };
            let (radiance, area) = match shape {
                LightShape::Sphere(light) => (light.radiance, 4.0 * PI * light.radius * light.radius),
                LightShape::Rect(light) | LightShape::Disc(light) => {
                    let is_behind = matches!(target, Target::Sphere { centre, radius }
                        if (*centre - light.centre).dot(light.normal) < -radius);
                    (light.radiance, if is_behind { 0.0 } else { light.area })
                }
                LightShape::Box(light) => (light.radiance, face_areas(light).iter().sum::<f32>() * 2.0),
                LightShape::Triangles(light) => (light.bounds.radiance, light.area),
                _ => (Vec3::ZERO, 0.0),
            };
            luminance(radiance.into()) * area * (TAU * target.cone(centre, ALL_DIRECTIONS).1).min(PI)
        }
    }
}

/// Uniform point of a light that has an area, and the area, square metres.
fn area_point(scene: &RenderScene, shape: &LightShape, [u, v]: [f32; 2]) -> Option<(AreaPoint, f32)> {
    let one_sided = |p, normal, radiance| AreaPoint { p, normal, radiance, is_two_sided: false };
    Some(match shape {
        LightShape::Sphere(SphereLight { centre, radius, radiance, .. }) => {
            let normal = cone_direction(Vec3::Z, 2.0, [u, v]);
            (one_sided(*centre + normal * *radius, normal, *radiance), 4.0 * PI * radius * radius)
        }
        LightShape::Rect(SheetLight { radiance, .. }) | LightShape::Disc(SheetLight { radiance, .. }) => {
            let (p, normal, area) = sample_area(shape, Vec3::ZERO, [u, v]);
            (one_sided(p, normal, *radiance), area)
        }
        LightShape::Box(light) => {
            let areas = face_areas(light);
            let total = areas.iter().sum::<f32>();
            let mut rest = u * total;
            let mut k = 0;
            while k < 2 && rest >= areas[k] {
                rest -= areas[k];
                k += 1;
            }
            let twice = (2.0 * rest / areas[k].max(1e-30)).clamp(0.0, 2.0);
            let (side, u) = if twice < 1.0 { (-1.0, twice) } else { (1.0, twice - 1.0) };
            let (axis, a, b) = (light.axes[k], light.axes[(k + 1) % 3], light.axes[(k + 2) % 3]);
            let p = light.centre + axis * side + a * (2.0 * u - 1.0) + b * (2.0 * v - 1.0);
            (one_sided(p, axis.normalize() * side, light.radiance), 2.0 * total)
        }
        LightShape::Triangles(triangles) => {
            let mesh = &scene.mesh_lights[triangles.mesh];
            let point = mesh.point([u, v]);
            let radiance = mesh_radiance(scene, triangles, point.attributes);
            let is_two_sided = !mesh.is_single_sided;
            (AreaPoint { p: point.p, normal: point.normal, radiance, is_two_sided }, triangles.area)
        }
        LightShape::Point(_)
        | LightShape::Spot(_)
        | LightShape::Sun(_)
        | LightShape::Bounded(_)
        | LightShape::Environment => return None,
    })
}

/// Bounding spheres of the focusing objects, at most [`MAX_TARGETS`], and all directions if one has no end.
fn targets(scene: &RenderScene) -> Vec<Target> {
    let field = &scene.field;
    let focusing = field.leaves().iter().enumerate().filter(|(index, _)| scene.material_of(*index).has(FOCUSES));
    let mut leaves_of = vec![Vec::new(); field.object_bounds().len()];
    for (index, leaf) in focusing {
        leaves_of[leaf.object as usize].push(index);
    }
    let mut spheres = Vec::new();
    let mut is_endless = false;
    for (bounds, leaves) in field.object_bounds().iter().zip(&leaves_of).filter(|(_, leaves)| !leaves.is_empty()) {
        if !bounds.is_finite() {
            is_endless = true;
            continue;
        }
        // The object as a whole, since blends extend beyond the bounds of their leaves, and each of its leaves.
        spheres.extend(sphere_around(bounds));
        if leaves.len() > 1 {
            let bounds = leaves.iter().map(|&leaf| field.leaf_bounds(leaf));
            spheres.extend(bounds.filter_map(|bounds| sphere_around(&bounds)));
        }
    }
    let mut targets: Vec<Target> = Vec::new();
    group(&mut spheres, MAX_TARGETS, &mut targets);
    if is_endless {
        targets.push(Target::Everywhere);
    }
    targets
}

/// Bounding sphere of a box: centre and radius, metres.
fn sphere_around(bounds: &Aabb) -> Option<(Vec3, f32)> {
    let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
    let radius = 0.5 * (max - min).length() * 1.001;
    (bounds.is_finite() && radius > 0.0).then_some(((min + max) * 0.5, radius))
}

/// Adds at most `count` spheres around groups of neighbouring spheres.
fn group(spheres: &mut [(Vec3, f32)], count: usize, targets: &mut Vec<Target>) {
    if spheres.is_empty() {
        return;
    }
    if spheres.len() <= count {
        targets.extend(spheres.iter().map(|&(centre, radius)| Target::Sphere { centre, radius }));
        return;
    }
    let min = spheres.iter().fold(Vec3::INFINITY, |min, (centre, radius)| min.min(*centre - *radius));
    let max = spheres.iter().fold(Vec3::NEG_INFINITY, |max, (centre, radius)| max.max(*centre + *radius));
    if count == 1 {
        targets.push(Target::Sphere { centre: (min + max) * 0.5, radius: 0.5 * (max - min).length() * 1.001 });
        return;
    }
    let axis = (max - min).max_position();
    spheres.sort_by(|(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
    let (low, high) = spheres.split_at_mut(spheres.len() / 2);
    group(low, count / 2, targets);
    group(high, count - count / 2, targets);
}
