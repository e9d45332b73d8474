//! Light sampling: next-event estimation (Kajiya 1986, "The Rendering Equation") with multiple importance sampling.
//!
//! One light is chosen at each surface. A share of the random numbers chooses a sun or the environment by an alias table, in
//! proportion to their irradiance; the others choose a light with a position by the [light tree](crate::scene::light_tree), in
//! proportion to an estimate of its irradiance at the point. A scene of up to three such lights has no tree, and the table chooses
//! them by their irradiance at the centre of the scene. What counts of a colour is its share of the light of each channel. A
//! sphere is sampled uniformly in the cone that it subtends (Shirley, Wang and Zimmerman 1996, "Monte Carlo Techniques for Direct
//! Lighting Calculations"); a rectangle, a disc,
//! the visible faces of a box, and the triangles of a mesh are sampled by area. Any other shape is sampled in the cone of
//! its bounding sphere, so that the shadow ray may miss it. BSDF sampling hits the same lights; the power heuristic weights both strategies
//! (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").

use crate::intersect::ray::Ray;
use crate::sampling::ONE_MINUS_EPSILON;
use crate::sampling::basis::{basis, renormalized};
use crate::scene::light::{BoxLight, Light, LightShape, PointLight, SheetLight, SphereLight, SunLight, TrianglesLight};
use crate::scene::mesh_light::PointOnMesh;
use crate::scene::sky::EnvironmentSample;
use crate::scene::{LightTree, RenderScene, SkyLight, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::{Real, unit_circle};
use pathmarch_scene::DirectLighting;
use pathmarch_scene::textures::{MeshAttributes, Spot};
use std::f32::consts::{PI, TAU};

/// Sample of a light, before visibility.
pub(crate) struct LightSample {
    /// Unit vector towards the light, in world space.
    pub(crate) direction: Vec3,
    /// Largest distance of an occluder, metres; infinite for suns, the environment and lights with a
    /// [`target`](Self::target).
    pub(crate) distance: f32,
    /// Monte Carlo estimate of the irradiance on a surface that faces the light: radiance divided by pdf, W/m².
    pub(crate) irradiance: Vec3,
    /// Pdf of the sample over solid angle; zero for lights that no ray hits.
    pub(crate) pdf: f32,
    /// Leaf that the shadow ray must hit, for a light that it may miss.
    pub(crate) target: Option<u32>,
    /// Sharpness of shadows from near misses; 0 for exact shadows.
    pub(crate) penumbra: f32,
}

/// Light with the probability of choosing it at a point, or for a segment in a medium.
pub(super) struct ChosenLight<'a> {
    /// Index among the lights of the scene.
    pub(super) index: usize,
    pub(super) shape: &'a LightShape,
    pub(super) pmf: f32,
    /// One over `pmf`.
    pub(super) inverse_pmf: f32,
}

/// Random numbers of light sample `k` of `count` at a surface: for the choice, each in a stratum of its own, and for the position.
#[inline(always)]
pub(super) fn nth_light_sample<N: Real>(k: u32, count: u32, choice: N, [x, y]: [N; 2]) -> (N, [N; 2]) {
    let shifted = |number: N, step: f32| {
        let shifted = number + N::constant((k as f32 * step).fract());
        shifted - shifted.floor()
    };
    let choice = (choice + N::constant(k as f32)) * N::constant(1.0 / count as f32);
    (choice.min(N::constant(ONE_MINUS_EPSILON)), [shifted(x, LIGHT_STEP_X), shifted(y, LIGHT_STEP_Y)])
}

/// Chooses a light for a point with a uniform number. `normal` is the unit normal of a surface that is lit on this side only;
/// `None` for surfaces that transmit and for points in a medium. Returns `None` if no light contributes.
#[inline]
pub(super) fn choose_light<'a>(
    ctx: &TraceContext<'a>,
    p: Vec3,
    normal: Option<Vec3>,
    choice: f32,
) -> Option<ChosenLight<'a>> {
    choose_light_of(ctx, choice, |tree, choice| tree.sample(p, normal, choice))
}

/// Chooses a light for the medium on a segment of this length, metres, with a uniform number. Returns `None` without lights.
pub(super) fn choose_light_along<'a>(
    ctx: &TraceContext<'a>,
    ray: &Ray,
    length: f32,
    choice: f32,
) -> Option<ChosenLight<'a>> {
    choose_light_of(ctx, choice, |tree, choice| tree.sample_along(ray, length, choice))
}

/// Chooses a light with a uniform number, in the tree by this walk.
#[inline(always)]
fn choose_light_of<'a>(
    ctx: &TraceContext<'a>,
    choice: f32,
    walk: impl Fn(&LightTree, f32) -> Option<(usize, f32)>,
) -> Option<ChosenLight<'a>> {
    if let Some(tree) = ctx.scene.light_tree.as_ref().filter(|tree| choice < tree.share) {
        let (leaf, probability) = walk(tree, choice / tree.share)?;
        let (index, pmf) = (tree.first + leaf, tree.share * probability);
        return Some(ChosenLight { index, shape: &ctx.scene.lights[index].shape, pmf, inverse_pmf: 1.0 / pmf });
    }
    choose_light_outside_tree(ctx, choice)
}

/// Chooses one of the lights that are not in the light tree, with a number that chooses none in the tree.
#[inline]
pub(super) fn choose_light_outside_tree<'a>(ctx: &TraceContext<'a>, mut choice: f32) -> Option<ChosenLight<'a>> {
    let lights = &ctx.scene.lights;
    let mut in_table = lights.len();
    if let Some(tree) = &ctx.scene.light_tree {
        choice = (choice - tree.share) / (1.0 - tree.share);
        in_table = tree.first;
    }
    let cell = choice * in_table as f32;
    let mut index = (cell as usize).min(in_table.checked_sub(1)?);
    if cell - index as f32 >= lights[index].threshold {
        index = lights[index].alias as usize;
    }
    let Light { shape, pmf, inverse_pmf, .. } = &lights[index];
    Some(ChosenLight { index, shape, pmf: *pmf, inverse_pmf: *inverse_pmf })
}

/// Probability that a light is chosen at a point with this normal, as for [`choose_light`].
pub(crate) fn light_pmf(scene: &RenderScene, light: usize, p: Vec3, normal: Option<Vec3>) -> f32 {
    match &scene.light_tree {
        Some(tree) if light >= tree.first => tree.share * tree.probability(light - tree.first, p, normal),
        _ => scene.lights[light].pmf,
    }
}

/// Samples a direction from `p` to a chosen light.
#[inline]
pub(super) fn sample_direction(
    ctx: &TraceContext,
    light: &ChosenLight,
    p: Vec3,
    position: [f32; 2],
) -> Option<LightSample> {
    let sample = |direction, distance, irradiance, pdf| {
        let (pdf, target, penumbra) = (pdf * light.pmf, light.shape.target(), light.shape.penumbra());
        Some(LightSample { direction, distance, irradiance, pdf, target, penumbra })
    };
    match light.shape {
        LightShape::Point(PointLight { position, radiant_intensity, .. }) => {
            let offset = *position - p;
            let distance = offset.length();
            let inverse = 1.0 / distance;
            let intensity = *radiant_intensity * light.inverse_pmf;
            sample(offset * inverse, distance, intensity * (inverse * inverse), 0.0)
        }
        LightShape::Spot(spot) => {
            let offset = spot.point.position - p;
            let distance = offset.length();
            let inverse = 1.0 / distance;
            let direction = offset * inverse;
            let intensity = spot.radiant_intensity_towards(-direction) * light.inverse_pmf;
            if intensity == Vec3::ZERO {
                return None;
            }
            sample(direction, distance, intensity * (inverse * inverse), 0.0)
        }
        LightShape::Sun(SunLight { direction, irradiance, one_minus_cos, .. }) => {
            let sampled_direction = cone_direction(*direction, *one_minus_cos, position);
            // Radiance times solid angle: the irradiance divided by the mean cosine over the disc.
            let pdf = if *one_minus_cos > 0.0 { 1.0 / (TAU * one_minus_cos) } else { 0.0 };
            let irradiance = *irradiance * light.inverse_pmf;
            sample(sampled_direction, f32::INFINITY, irradiance * (2.0 / (2.0 - one_minus_cos)), pdf)
        }
        LightShape::Environment => {
            let EnvironmentSample { direction, radiance, pdf } = ctx.scene.sky.sample(position)?;
            // This pdf includes the choice of the light.
            sample(direction, f32::INFINITY, radiance / pdf, pdf / light.pmf)
        }
        LightShape::Sphere(sphere) => {
            let (direction, one_minus_cos, offset) = sample_sphere_cone(sphere, p, position);
            let distance = sphere_entry(offset, direction, sphere.radius);
            let irradiance = sphere.radiance * light.inverse_pmf * (TAU * one_minus_cos);
            sample(direction, distance * SHADOW_RAY_SHARE, irradiance, 1.0 / (TAU * one_minus_cos))
        }
        LightShape::Bounded(sphere) => {
            let (direction, one_minus_cos, _) = sample_sphere_cone(sphere, p, position);
            let irradiance = sphere.radiance * light.inverse_pmf * (TAU * one_minus_cos);
            sample(direction, f32::INFINITY, irradiance, 1.0 / (TAU * one_minus_cos))
        }
        LightShape::Triangles(triangles) => {
            let mesh = &ctx.scene.mesh_lights[triangles.mesh];
            let PointOnMesh { p: point, normal, attributes } = mesh.point(position);
            let offset = point - p;
            let square = offset.length_squared();
            let distance = square.sqrt();
            let direction = offset * (1.0 / distance);
            let cosine = -normal.dot(direction);
            if cosine == 0.0 || (cosine < 0.0 && mesh.is_single_sided) {
                return None;
            }
            let radiance = mesh_radiance(ctx.scene, triangles, attributes);
            let solid_angle = triangles.area * cosine.abs() / square;
            let irradiance = radiance * light.inverse_pmf * solid_angle;
            sample(direction, distance * SHADOW_RAY_SHARE, irradiance, 1.0 / solid_angle)
        }
        LightShape::Rect(_) | LightShape::Disc(_) | LightShape::Box(_) => {
            let (point, normal, area) = sample_area(light.shape, p, position);
            let offset = point - p;
            let square = offset.length_squared();
            let distance = square.sqrt();
            let direction = offset * (1.0 / distance);
            let cosine = normal.dot(direction);
            let (cosine, radiance) = match light.shape {
                LightShape::Box(light) => (cosine.abs(), light.radiance),
                LightShape::Rect(light) | LightShape::Disc(light) => (-cosine, light.radiance),
                _ => return None,
            };
            if cosine <= 0.0 {
                return None;
            }
            let solid_angle = area * cosine / square;
            let irradiance = radiance * light.inverse_pmf * solid_angle;
            sample(direction, distance * SHADOW_RAY_SHARE, irradiance, 1.0 / solid_angle)
        }
    }
}

shared_constants! {
    /// Length of a shadow ray divided by the distance of the light's surface, so that the ray does not hit the light
    /// itself.
    pub(super) const SHADOW_RAY_SHARE: f32 = 0.9999;
    /// Step of the position on a light from one light sample of a surface to the next (the R2 sequence; Roberts 2018).
    const LIGHT_STEP_X: f32 = 0.754_877_7;
    const LIGHT_STEP_Y: f32 = 0.569_840_3;
}

/// Samples a direction from `p` in the cone that a sphere subtends. Returns it, 1 - cosine of the cone's half angle,
/// and the offset of the sphere's centre.
fn sample_sphere_cone(sphere: &SphereLight, p: Vec3, position: [f32; 2]) -> (Vec3, f32, Vec3) {
    let offset = sphere.centre - p;
    let one_minus_cos = subtended_cone(offset.length_squared(), sphere.radius);
    (cone_direction(offset.normalize_or(Vec3::Y), one_minus_cos, position), one_minus_cos, offset)
}

/// 1 - cosine of the half angle of the cone that a sphere subtends at this squared distance from its centre. Inside the
/// sphere it is 2, all directions.
#[inline]
pub(super) fn subtended_cone(square: f32, radius: f32) -> f32 {
    let sine_square = radius * radius / square.max(1e-30);
    if sine_square >= 1.0 { 2.0 } else { sine_square / (1.0 + (1.0 - sine_square).sqrt()) }
}

/// Uniform direction in the cone around `axis` with this 1 - cosine of its half angle.
#[inline]
pub(super) fn cone_direction(axis: Vec3, one_minus_cos: f32, position: [f32; 2]) -> Vec3 {
    let one_minus_cos_theta = one_minus_cos * position[0];
    let sine = (one_minus_cos_theta * (2.0 - one_minus_cos_theta)).max(0.0).sqrt();
    let [cos_phi, sin_phi] = unit_circle(position[1]);
    renormalized(basis(axis) * Vec3::new(sine * cos_phi, sine * sin_phi, 1.0 - one_minus_cos_theta))
}

/// Distance at which a ray enters a sphere with its centre at `offset`, metres. Inside the sphere, the distance at
/// which it leaves.
#[inline]
fn sphere_entry(offset: Vec3, direction: Vec3, radius: f32) -> f32 {
    let along = offset.dot(direction);
    let across = offset - direction * along;
    let half_chord = (radius * radius - across.length_squared()).max(0.0).sqrt();
    if along > half_chord { along - half_chord } else { along + half_chord }
}

/// Radiance of an emitting mesh at a point with these vertex attributes, W/(m² sr).
pub(super) fn mesh_radiance(scene: &RenderScene, triangles: &TrianglesLight, attributes: MeshAttributes) -> Vec3 {
    let material = scene.leaves[triangles.bounds.leaf as usize].material as usize;
    let spot = Spot { p: Vec3::ZERO, normal: Vec3::Y, footprint: 0.0, attributes };
    let texture = scene.textured_materials[material].emission.as_ref();
    texture.map_or(triangles.bounds.radiance, |texture| texture.colour(&spot))
}

/// Samples a point by area on the part of a rectangle, disc or box that may be visible from `p`. Returns the point, its
/// normal and the area of that part, square metres.
pub(super) fn sample_area(shape: &LightShape, p: Vec3, [u, v]: [f32; 2]) -> (Vec3, Vec3, f32) {
    match shape {
        LightShape::Rect(SheetLight { centre, axes: [x, z], normal, area, .. }) => {
            let point = *centre + *x * (2.0 * u - 1.0) + *z * (2.0 * v - 1.0);
            (point, *normal, *area)
        }
        LightShape::Disc(SheetLight { centre, axes: [x, z], normal, radius, area, .. }) => {
            let radius = radius * u.sqrt();
            let [cos_phi, sin_phi] = unit_circle(v);
            (*centre + *x * (radius * cos_phi) + *z * (radius * sin_phi), *normal, *area)
        }
        LightShape::Box(light) => {
            let (areas, total) = visible_areas(light, p);
            let offset = p - light.centre;
            let mut u = u * (areas[0] + areas[1] + areas[2]);
            let k = if u < areas[0] {
                0
            } else if u < areas[0] + areas[1] {
                1
            } else {
                2
            };
            u = ((u - areas[..k].iter().sum::<f32>()) / areas[k].max(1e-30)).clamp(0.0, 1.0);
            let axes = light.axes;
            let (axis, a, b) = (axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]);
            let along = offset.dot(axis) / axis.length_squared();
            // Outside the box, the visible side; inside, both sides.
            let mut side = if along < 0.0 { -1.0 } else { 1.0 };
            if along.abs() < 1.0 {
                side = if u < 0.5 { -1.0 } else { 1.0 };
                u = (2.0 * u).fract();
            }
            (light.centre + axis * side + a * (2.0 * u - 1.0) + b * (2.0 * v - 1.0), axis.normalize() * side, total)
        }
        _ => (p, Vec3::ZERO, 0.0),
    }
}

/// Area of a face of a box across each axis, square metres.
pub(super) fn face_areas(light: &BoxLight) -> [f32; 3] {
    let [x, y, z] = light.axes.map(Vec3::length);
    [4.0 * y * z, 4.0 * z * x, 4.0 * x * y]
}

/// Area of a face of a box across each axis, zero where none is visible from `p`, and the area of all visible faces.
fn visible_areas(light: &BoxLight, p: Vec3) -> ([f32; 3], f32) {
    let [x, y, z] = light.axes;
    let offset = p - light.centre;
    let areas = face_areas(light);
    let visible = [x, y, z].map(|axis| offset.dot(axis).abs() > axis.length_squared());
    if !visible.contains(&true) {
        return (areas, 2.0 * (areas[0] + areas[1] + areas[2]));
    }
    let areas: [f32; 3] = std::array::from_fn(|k| if visible[k] { areas[k] } else { 0.0 });
    (areas, areas[0] + areas[1] + areas[2])
}

/// Pdf over solid angle of a sampled light for the direction from `p` to the point `hit` on the light, the choice of
/// the light by `pmf` included; `cosine` is that of the angle at the light's normal.
pub(crate) fn light_pdf(shape: &LightShape, pmf: f32, p: Vec3, hit: Vec3, cosine: f32) -> f32 {
    let t = p.distance(hit);
    let area = match shape {
        LightShape::Sphere(sphere) => {
            return pmf / (TAU * subtended_cone((sphere.centre - p).length_squared(), sphere.radius));
        }
        LightShape::Bounded(sphere) => {
            let offset = sphere.centre - p;
            let one_minus_cos = subtended_cone(offset.length_squared(), sphere.radius);
            // A blend may extend the light beyond its bounding sphere.
            let outside = (hit - p).dot(offset) < (1.0 - one_minus_cos) * t * offset.length();
            return if outside { 0.0 } else { pmf / (TAU * one_minus_cos) };
        }
        LightShape::Rect(sheet) | LightShape::Disc(sheet) => sheet.area,
        LightShape::Box(light) => visible_areas(light, p).1,
        LightShape::Triangles(triangles) => triangles.area,
        LightShape::Point(_) | LightShape::Spot(_) | LightShape::Sun(_) | LightShape::Environment => return 0.0,
    };
    pmf * t * t / (area * cosine.max(1e-6))
}

/// Power heuristic: weight of a sample with pdf `a`, where another strategy has pdf `b`.
#[inline]
pub(super) fn power_heuristic<N: Real>(a: N, b: N) -> N {
    let ratio = b / N::constant(1e-30).max(a);
    N::one() / (N::one() + ratio * ratio)
}

/// MIS weight of BSDF sampling: a ray with pdf `scatter_pdf` hit a light that light sampling chooses with `light_pdf`.
/// 1 after a delta distribution, for which no light is sampled.
#[inline]
pub(crate) fn hit_weight(search: DirectLighting, scatter_pdf: f32, light_pdf: f32) -> f32 {
    match search {
        _ if scatter_pdf <= 0.0 => 1.0,
        DirectLighting::Mis => power_heuristic(scatter_pdf, light_pdf),
        DirectLighting::LightSampling => 0.0,
        DirectLighting::BsdfSampling => 1.0,
    }
}

/// MIS weight of light sampling with pdf `light_pdf`, where BSDF sampling has `scatter_pdf`. 1 for lights that no ray
/// hits.
#[inline]
pub(crate) fn sample_weight(search: DirectLighting, light_pdf: f32, scatter_pdf: f32) -> f32 {
    match search {
        _ if light_pdf <= 0.0 => 1.0,
        DirectLighting::Mis => power_heuristic(light_pdf, scatter_pdf),
        DirectLighting::LightSampling => 1.0,
        DirectLighting::BsdfSampling => 0.0,
    }
}

/// Radiance of the sky in the direction of a ray with pdf `scatter_pdf`, times its MIS weight.
#[inline]
pub(crate) fn sky_radiance(sky: &SkyLight, search: DirectLighting, direction: Vec3, scatter_pdf: f32) -> Vec3 {
    match sky.radiance(direction) {
        (radiance, Some(pdf)) => radiance * hit_weight(search, scatter_pdf, pdf),
        (radiance, None) => radiance,
    }
}

/// Radiance of the suns in the direction of a ray with pdf `scatter_pdf`, times its MIS weight.
#[inline]
pub(crate) fn sun_radiance(ctx: &TraceContext, direction: Vec3, scatter_pdf: f32) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    for light in &ctx.scene.lights[..ctx.frame.sun_count as usize] {
        let LightShape::Sun(sun) = &light.shape else { continue };
        let x = sun.one_minus_cos;
        // |a - b|²/2 = 1 - cosine of the angle between unit vectors, without cancellation.
        if 0.5 * (direction - sun.direction).length_squared() < x {
            let weight = hit_weight(ctx.config.direct_lighting, scatter_pdf, light.pmf / (TAU * x));
            // Radiance of the disc: irradiance / (π sin²), with sin² = x(2 - x).
            radiance += sun.irradiance * (weight / (PI * x * (2.0 - x)));
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::sampling::sobol::PixelSampler;
    use pathmarch_scene::Scene;

    fn input(lights: &str) -> RenderInput {
        let text = format!("pathmarch 1\ncamera {{ position 0 0 4; target 0 0 0 }}\n{lights}");
        let scene = Scene::parse("test.kdl", &text).expect("a valid scene");
        RenderInput::new(&scene, &crate::Settings::of(&scene))
    }

    /// Tests every kind of emitting surface from near, far and from the side.
    /// Samples a light, and a direction from `p` to it.
    fn sample_light(
        ctx: &TraceContext,
        p: Vec3,
        normal: Option<Vec3>,
        choice: f32,
        position: [f32; 2],
    ) -> Option<LightSample> {
        sample_direction(ctx, &choose_light(ctx, p, normal, choice)?, p, position)
    }

    #[test]
    fn light_pdf_is_that_of_the_samples() {
        let shapes = ["sphere 0.5", "rect 1 0.6", "disc 0.4", "box 0.5 0.8 0.3", "torus 0.4 0.1"];
        for shape in shapes {
            let input = input(&format!(
                "material \"lamp\" {{ emit 1 }}\nobject \"lamp\" material=\"lamp\" {{ {shape} {{ rotate 20 30 40; scale 1.3; at 0.2 0.1 0 }} }}"
            ));
            let [light] = input.scene.lights.as_slice() else { panic!("one light") };
            for p in [Vec3::new(0.0, 2.0, 0.3), Vec3::new(-1.0, 0.4, 0.9), Vec3::new(20.0, 30.0, 1.0)] {
                let mut weight = 0.0;
                let n = 4000;
                for k in 0..n {
                    let u = PixelSampler::new(0, 0, k, 1).sample_2d(0);
                    let Some(sample) = sample_light(&input.context(None), p, None, 0.5, u) else { continue };
                    let direction =
                        pathmarch_field::number::Vec3::new(sample.direction.x, sample.direction.y, sample.direction.z);
                    let origin = pathmarch_field::number::Vec3::new(p.x, p.y, p.z);
                    let (t, _) = input.scene.field.analytic_hit(origin, direction);
                    if sample.target.is_none() {
                        assert!(
                            (t * SHADOW_RAY_SHARE / sample.distance - 1.0).abs() < 2e-3,
                            "{shape}: {t} {}",
                            sample.distance
                        );
                        let hit = p + sample.direction * t;
                        let surface = input
                            .scene
                            .field
                            .surface(pathmarch_field::number::Vec3::new(hit.x, hit.y, hit.z), 0)
                            .field
                            .gradient;
                        let normal = Vec3::new(surface.x, surface.y, surface.z).normalize();
                        let cosine = normal.dot(sample.direction).abs();
                        if cosine > 0.05 && !matches!(light.shape, LightShape::Box(_)) {
                            let pdf = light_pdf(&light.shape, light.pmf, p, hit, cosine);
                            assert!((pdf / sample.pdf - 1.0).abs() < 0.02, "{shape}: {pdf} {}", sample.pdf);
                        }
                    }
                    weight += 1.0 / (sample.pdf * n as f32);
                }
                // The mean of 1/pdf is the solid angle, at most all directions.
                assert!(weight > 0.0 && weight < 4.0 * PI, "{shape}: {weight}");
            }
        }
    }

    #[test]
    fn lights_are_chosen_by_their_power() {
        let points = [1.0, 2.0, 5.0, 0.0, 12.0].map(|i| format!("point {{ at 0 10 0; intensity {i} }}\n"));
        let input = input(&points.concat());
        assert_eq!(input.scene.lights.len(), 4, "a light without power is left out");
        let mut chosen = vec![0.0f32; 13];
        let n = 20_000;
        for k in 0..n {
            let choice = (k as f32 + 0.5) / n as f32;
            let ctx = input.context(None);
            let sample = sample_light(&ctx, Vec3::ZERO, None, choice, [0.5; 2]).expect("there are lights");
            // The quotient of power and probability is the same for every choice.
            assert!((sample.irradiance.x * 100.0 - 20.0).abs() < 1e-3);
            let light = choose_light(&ctx, Vec3::ZERO, None, choice).expect("there are lights");
            let LightShape::Point(point) = light.shape else { panic!("points only") };
            chosen[point.radiant_intensity.x as usize] += 1.0 / n as f32;
        }
        for (intensity, expected) in [(1, 0.05), (2, 0.1), (5, 0.25), (12, 0.6)] {
            assert!((chosen[intensity] - expected).abs() < 1e-3, "{chosen:?}");
        }
    }

    #[test]
    fn suns_the_environment_and_lamps_share_the_choice() {
        let lamps = (0..20).map(|k| format!("point {{ at {k} 2 0; intensity {} }}\n", 1 + k % 3));
        let text = format!(
            "sky \"day\" elevation=20\nsun {{ direction 0 1 0; irradiance 2; angle 3 }}\nmaterial \"lamp\" {{ emit 5 }}\n\
             object \"lamp\" material=\"lamp\" {{ box 0.2 {{ at 3 1 2 }} }}\n{}",
            lamps.collect::<String>()
        );
        let input = input(&text);
        let (ctx, lights) = (input.context(None), &input.scene.lights);
        let tree = input.scene.light_tree.as_ref().expect("many lamps");
        assert!(lights[0].shape.is_sun() && tree.count == 21 && tree.first + tree.count == lights.len());
        assert!(lights[..tree.first].iter().any(|light| matches!(light.shape, LightShape::Environment)));
        for p in [Vec3::new(2.0, 0.0, 1.0), Vec3::new(15.0, 1.0, -4.0), Vec3::new(-300.0, 20.0, 0.0)] {
            let expected: Vec<f32> = (0..lights.len()).map(|light| light_pmf(ctx.scene, light, p, None)).collect();
            let sum: f32 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 1e-4, "{sum}");
            let n = 50_000;
            let mut counts = vec![0.0f32; lights.len()];
            for k in 0..n {
                let light = choose_light(&ctx, p, None, (k as f32 + 0.5) / n as f32).expect("no normal");
                let index = lights.iter().position(|other| std::ptr::eq(&raw const other.shape, light.shape));
                let index = index.expect("a light of the scene");
                assert_eq!(light.pmf, expected[index]);
                counts[index] += 1.0;
            }
            for (counted, expected) in counts.iter().zip(&expected) {
                assert!((counted - expected * n as f32).abs() < 3.0, "{counted} {expected}");
            }
        }
    }

    #[test]
    fn the_radiance_of_a_sun_integrates_to_its_irradiance() {
        let input = input("sun { direction 0 1 0; irradiance 3; angle 10 }");
        // Directions are cosine-distributed, so that the mean of π L estimates the irradiance.
        let n = 400_000;
        let mut sum = 0.0;
        for k in 0..n {
            let [u, v] = PixelSampler::new(0, 0, k, 1).sample_2d(0);
            let (sine, cosine) = (TAU * v).sin_cos();
            let direction = Vec3::new(u.sqrt() * sine, (1.0 - u).sqrt(), u.sqrt() * cosine);
            sum += PI * sun_radiance(&input.context(None), direction, 0.0).x / n as f32;
        }
        assert!((sum - 3.0).abs() < 0.05, "{sum}");
    }
}
