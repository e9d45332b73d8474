//! Preview: a quick approximation without noise, as ray marchers rendered before path tracing.
//!
//! **Idea.** One camera ray a sample. At its hit: unoccluded direct light of every light, soft shadows of the strongest
//! [`MAX_SHADOWS`], one glossy highlight for each light, ambient light times ambient occlusion, and one mirror
//! reflection that is shaded in the same way. Rays refract through clear surfaces by Snell's law. There are no random
//! numbers: a sample is the same for every seed, and the first one goes through the centre of the pixel.
//!
//! **Sources.** Carvalho 2020, section 3.3. Soft shadows: [`soft_shadow`], as wide as the angle that the light
//! subtends. Ambient occlusion from a few evaluations of the field along the normal: Quilez 2008, "Rendering Worlds
//! with Two Triangles". Highlights: Blinn 1977 with a normalised exponent that follows roughness, widened by the angle
//! that the light subtends (Karis 2013, "Real Shading in Unreal Engine 4"). Schlick 1994 for Fresnel reflectance.
//! Ambient light: [`ambient_sh`].
//!
//! **Limits.** Ambient light is one function of the normal for the whole picture, and its occlusion is an estimate.
//! Emitters and glass cast no shadows. Near misses darken only the outside of a shadow's edge. Within clear solids,
//! rays reflect only by total internal reflection. A rough reflection is a mixture of a sharp one and of ambient light.
//! Only the strongest lights at a point have shadows there, and at most [`MAX_LIGHTS`] lights count. An environment map
//! contributes ambient light without shadows.
//!
//! **Cost.** Up to [`MAX_SURFACES`] + [`MAX_REFLECTED_SURFACES`] rays, and for each shaded surface [`MAX_SHADOWS`]
//! shadow rays and five evaluations of the field.

pub(crate) mod ambient_sh;
mod light_irradiance;
pub(crate) mod soft_shadow;

use self::light_irradiance::{UnoccludedLight, bounding_radius, unoccluded_light};
use self::soft_shadow::{ShadowRay, soft_shadows};
use crate::integrator::camera::central_ray;
use crate::integrator::light_sampling;
use crate::integrator::medium::{medium_beyond, transmittance};
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment, lanes};
use crate::preview_steps::{GREY_ALBEDO, PreviewStep, PreviewSteps};
use crate::sampling::r2_sequence;
use crate::scene::material::GLOWS;
use crate::scene::preview_material::{self, PreviewParameters};
use crate::scene::{Light, LightShape, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::DirectLighting;
use pathmarch_scene::Scene;
use std::f32::consts::PI;
use wide::f32x8;

shared_constants! {
    /// Largest number of surfaces along the reflected ray.
    const MAX_REFLECTED_SURFACES: u32 = 3;
    /// Largest number of surfaces along the camera ray, which passes through clear surfaces.
    const MAX_SURFACES: u32 = 6;
    /// Largest number of lights with shadows at a point.
    const MAX_SHADOWS: usize = 3;
    /// Smallest weight of a reflection that is traced.
    const MIN_REFLECTION_WEIGHT: f32 = 0.02;
    /// Smallest brightness of a light with shadows, relative to the strongest light at the point.
    const MIN_SHADOWED_LIGHT: f32 = 0.1;
    /// Largest sharpness of a shadow: one over the sine of half the angle that its light subtends.
    const MAX_SHARPNESS: f32 = 64.0;
    /// Largest ambient occlusion by each of the five evaluations of the field.
    const OCCLUSION_PER_EVALUATION: f32 = 0.15;
}

/// Largest number of lights of a preview.
const MAX_LIGHTS: usize = 64;

/// Data that only previews need.
#[derive(Clone, Debug)]
pub(crate) struct Preview {
    /// Ambient irradiance: coefficients of [`ambient_sh::sh_basis`], W/m².
    pub(crate) ambient: [Vec3; 9],
    /// Largest distance of occluders of ambient light, metres.
    pub(crate) occlusion_distance: f32,
    /// Indices of the lights, and the radius of the sphere that approximates each, metres.
    pub(crate) lights: Vec<(u32, f32)>,
    /// Preview material of each material.
    pub(crate) materials: Vec<PreviewParameters>,
    /// For each object: it casts shadows.
    pub(crate) occluders: Vec<bool>,
    /// For each object: it occludes ambient light.
    pub(crate) neighbours: Vec<bool>,
}

impl Preview {
    /// Computes the preview data of a scene. Traces the paths of [`ambient_sh`].
    pub(crate) fn new(scene: &Scene, ctx: &TraceContext) -> Self {
        let lights = &ctx.scene.lights;
        let is_local = |k: &u32| !matches!(lights[*k as usize].shape, LightShape::Environment);
        let mut order: Vec<u32> = (0..lights.len() as u32).filter(is_local).collect();
        // Lights of the same power keep their order in the scene file.
        let by_power = |a: &Light, b: &Light| b.pmf.total_cmp(&a.pmf).then(a.declaration.cmp(&b.declaration));
        order.sort_by(|&a, &b| by_power(&lights[a as usize], &lights[b as usize]));
        order.truncate(MAX_LIGHTS);
        let radius = |index: u32| {
            let shape = &lights[index as usize].shape;
            let share = match shape {
                LightShape::Bounded(sphere) => ambient_sh::visible_share(ctx, sphere),
                LightShape::Triangles(light) => ambient_sh::visible_share(ctx, &light.bounds),
                _ => 1.0,
            };
            (index, bounding_radius(shape) * share.sqrt())
        };
        let lights: Vec<(u32, f32)> = order.into_iter().map(radius).collect();
        let objects = scene.field.object_bounds().len();
        let (mut occluders, mut neighbours) = (vec![true; objects], vec![true; objects]);
        for leaf in scene.field.leaves() {
            let (material, object) = (&scene.materials[leaf.tag as usize], leaf.object as usize);
            neighbours[object] &= !material.emits();
            occluders[object] &= !material.emits() && !material.transmits();
        }
        let indices: Vec<u32> = lights.iter().map(|(index, _)| *index).collect();
        let ambient = ambient_sh::ambient_sh(ctx, &indices);
        let materials = scene.materials.iter().map(|material| preview_material::encode(&material.preview())).collect();
        Self { ambient, occlusion_distance: occlusion_distance(scene), lights, materials, occluders, neighbours }
    }

    /// Names of the distance functions of `preview.wgsl`, and the objects that each includes.
    pub(crate) fn distance_functions(&self) -> [(&str, &[bool]); 2] {
        [("occluder_distance", &self.occluders), ("neighbour_distance", &self.neighbours)]
    }

    /// Reports whether any material reflects specularly.
    pub(crate) fn has_reflections(&self) -> bool {
        let reflects = |material: &PreviewParameters| {
            preview_material::decode(material).specular.as_flattened().iter().any(|&share| share > 0.0)
        };
        self.materials.iter().any(reflects)
    }

    /// Ambient irradiance on a surface with this normal, W/m².
    fn ambient_irradiance(&self, n: Vec3) -> Vec3 {
        let sum: Vec3 =
            self.ambient.iter().zip(ambient_sh::sh_basis(n)).map(|(coefficient, value)| *coefficient * value).sum();
        sum.max(Vec3::ZERO)
    }

    /// Radiance of ambient light from around a direction, W/(m² sr), for rough reflections.
    fn ambient_radiance(&self, direction: Vec3) -> Vec3 {
        self.ambient_irradiance(direction) / PI
    }
}

/// Largest distance of occluders of ambient light, metres: a fraction of the median radius of the finite objects.
fn occlusion_distance(scene: &Scene) -> f32 {
    let mut radii: Vec<f32> = scene
        .field
        .object_bounds()
        .iter()
        .filter(|bounds| bounds.is_finite())
        .map(|bounds| 0.5 * Vec3::from(bounds.min).distance(Vec3::from(bounds.max)))
        .collect();
    radii.sort_by(f32::total_cmp);
    0.35 * radii.get(radii.len() / 2).copied().unwrap_or(1.0)
}

/// Camera ray or reflected ray, with its weight.
#[derive(Clone, Copy)]
struct PreviewRay {
    /// Index of the pixel.
    slot: usize,
    ray: Ray,
    /// Length of the path before the ray, metres.
    path_length: f32,
    /// Share of the ray's radiance that the pixel receives.
    weight: Vec3,
    /// Absorption coefficient around the ray, per metre.
    medium: Vec3,
}

/// Specular reflection of a surface.
struct Specular {
    /// Reflectance at normal incidence.
    f0: Vec3,
    /// Reflectance at grazing angles.
    f90: Vec3,
    roughness: f32,
    /// Share of the reflection that the reflected ray does not trace.
    untraced: f32,
}

/// Light of a pixel that a shadow may dim.
#[derive(Clone, Copy)]
struct ShadowTest {
    /// Index of the pixel.
    slot: usize,
    /// Radiance without shadow, W/(m² sr).
    radiance: Vec3,
    shadow_ray: ShadowRay,
}

/// Radiance of one sample of each of these pixels, W/(m² sr).
pub(crate) fn trace(ctx: &TraceContext, preview: &Preview, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let mut radiances = vec![Vec3::ZERO; pixels.len()];
    let [dx, dy] = r2_sequence::sample_2d(sample);
    let frame = ctx.frame;
    let preview_rays: Vec<PreviewRay> = pixels
        .iter()
        .enumerate()
        .map(|(slot, &(x, y))| PreviewRay {
            slot,
            ray: central_ray(frame, x as f32 + dx, y as f32 + dy),
            path_length: 0.0,
            weight: Vec3::ONE,
            medium: Vec3::from(frame.medium),
        })
        .collect();
    let mut tracer = PreviewTracer { ctx, preview, sample, radiances: &mut radiances, reflections: Vec::new() };
    tracer.trace_rays(preview_rays, MAX_SURFACES, true);
    let reflections = std::mem::take(&mut tracer.reflections);
    tracer.trace_rays(reflections, MAX_REFLECTED_SURFACES, false);
    radiances
}

/// Tracer of the rays of some pixels.
struct PreviewTracer<'a> {
    ctx: &'a TraceContext<'a>,
    preview: &'a Preview,
    sample: u32,
    radiances: &'a mut [Vec3],
    /// Reflected rays, at most one for each pixel.
    reflections: Vec<PreviewRay>,
}

impl PreviewTracer<'_> {
    /// Traces rays along at most `surfaces` surfaces. With `is_camera_ray`, collects a reflected ray for each pixel.
    fn trace_rays(&mut self, mut preview_rays: Vec<PreviewRay>, surfaces: u32, is_camera_ray: bool) {
        let ctx = self.ctx;
        let mut has_reflection = vec![!is_camera_ray; self.radiances.len()];
        for surface in 0..surfaces {
            if preview_rays.is_empty() {
                return;
            }
            let segments: Vec<RaySegment> = preview_rays
                .iter()
                .map(|preview_ray| RaySegment {
                    ray: preview_ray.ray,
                    path_length: preview_ray.path_length,
                    limit: f32::INFINITY,
                })
                .collect();
            let mut hits = Vec::with_capacity(preview_rays.len());
            let mut hit_rays = Vec::with_capacity(preview_rays.len());
            for ((mut preview_ray, hit), segment) in preview_rays.into_iter().zip(march(ctx, &segments)).zip(&segments)
            {
                if ctx.config.absorption {
                    preview_ray.weight *= transmittance(preview_ray.medium, hit.map_or(f32::INFINITY, |hit| hit.t));
                }
                match hit {
                    Some(hit) => {
                        preview_ray.path_length += hit.t;
                        hits.push((*segment, hit));
                        hit_rays.push(preview_ray);
                    }
                    None => {
                        let direction = preview_ray.ray.direction;
                        let sky_light =
                            light_sampling::sky_radiance(&ctx.scene.sky, DirectLighting::BsdfSampling, direction, 0.0)
                                + light_sampling::sun_radiance(ctx, direction, 0.0);
                        self.radiances[preview_ray.slot] += preview_ray.weight * sky_light;
                    }
                }
            }
            let interactions = surface_interactions(ctx, &hits, |_, blend| r2_sequence::choice(self.sample, blend));
            let visibilities = self.ambient_visibility(&interactions);
            // By rank of the light, so that most shadow rays of a chunk go to the same light.
            let mut shadow_tests = std::array::from_fn(|_| Vec::new());
            preview_rays = Vec::new();
            for ((preview_ray, interaction), visibility) in hit_rays.iter().zip(&interactions).zip(visibilities) {
                let next = self.shade(
                    preview_ray,
                    interaction,
                    visibility,
                    !is_camera_ray,
                    &mut has_reflection[preview_ray.slot],
                    &mut shadow_tests,
                );
                match next {
                    Some(next) if surface + 1 == surfaces => {
                        self.radiances[next.slot] += next.weight * self.preview.ambient_radiance(next.ray.direction);
                    }
                    Some(next) => preview_rays.push(next),
                    None => {}
                }
            }
            shadow_tests.iter().for_each(|shadow_tests| self.cast_shadows(shadow_tests));
        }
    }

    /// Shades a surface, but for light that a shadow may dim. Returns the ray behind a clear surface.
    fn shade(
        &mut self,
        preview_ray: &PreviewRay,
        interaction: &SurfaceInteraction,
        visibility: f32,
        is_reflection: bool,
        has_reflection: &mut bool,
        shadow_tests: &mut [Vec<ShadowTest>; MAX_SHADOWS],
    ) -> Option<PreviewRay> {
        let (ctx, preview) = (self.ctx, self.preview);
        let m = ctx.scene.leaves[interaction.leaf].material as usize;
        let material = &ctx.scene.materials[m];
        if material.emits() {
            if ctx.scene.emits_towards(interaction.leaf, interaction.normal) {
                self.radiances[preview_ray.slot] += preview_ray.weight * Vec3::from(material.emission);
            }
            return None;
        }
        let direction = preview_ray.ray.direction;
        let textured = TexturedPoint::new(ctx, interaction, preview_ray.path_length);
        let surface_material = match &textured {
            Some(textured) => preview_material::decode(&textured.preview(preview.materials[m])),
            None => preview_material::decode(&preview.materials[m]),
        };
        if material.has(GLOWS) && ctx.scene.emits_towards(interaction.leaf, interaction.normal) {
            let emission = textured.as_ref().and_then(TexturedPoint::emission);
            self.radiances[preview_ray.slot] += preview_ray.weight * emission.unwrap_or(material.emission.into());
        }
        let n = shading_normal(ctx.config, textured.as_ref(), interaction, -direction);
        let has = |step| PreviewSteps::from_bits(ctx.frame.preview_steps).has(step);
        let mut albedo = Vec3::from(surface_material.diffuse);
        if !has(PreviewStep::Albedo) && albedo.max_element() > 0.0 {
            albedo = Vec3::splat(GREY_ALBEDO);
        }
        let transmitted = Vec3::from(surface_material.transmission);
        let clear = transmitted.max_element() > 0.0;
        let cosine = (-direction.dot(n)).clamp(0.0, 1.0);
        let f0 = Vec3::from(surface_material.specular[0]);
        let f90 = (Vec3::from(surface_material.specular[1]) * (1.0 - surface_material.roughness)).max(f0);
        // Reflection within a clear solid is left out.
        let reflectance =
            if clear && interaction.inside { Vec3::ZERO } else { f0 + (f90 - f0) * (1.0 - cosine).powi(5) };
        let sharp_share = 1.0 - smoothstep(0.05, 0.45, surface_material.roughness);
        let reflection = direction + n * (2.0 * cosine);
        let mut untraced = 1.0;
        if !*has_reflection
            && has(PreviewStep::Reflection)
            && (preview_ray.weight * reflectance).max_element() * sharp_share > MIN_REFLECTION_WEIGHT
        {
            *has_reflection = true;
            untraced = 1.0 - sharp_share;
            self.reflections.push(PreviewRay {
                ray: Ray { origin: interaction.p + interaction.normal_offset, direction: reflection.normalize() },
                weight: preview_ray.weight * reflectance * sharp_share,
                ..*preview_ray
            });
        }
        let mut diffuse = albedo * (Vec3::ONE - reflectance) / PI;
        if !has(PreviewStep::Diffuse) {
            let flat = if albedo.max_element() > 0.0 { albedo } else { f0 };
            self.radiances[preview_ray.slot] += preview_ray.weight * flat;
            diffuse = Vec3::ZERO;
        }
        let mut ambient_light = diffuse * preview.ambient_irradiance(n);
        let mut highlight_f90 = Vec3::ZERO;
        if has(PreviewStep::Specular) {
            ambient_light += reflectance * preview.ambient_radiance(reflection) * untraced;
            highlight_f90 = f90;
        }
        let max_shadows = if has(PreviewStep::Shadows) { MAX_SHADOWS } else { 0 };
        let shaded = SurfaceInteraction { normal: n, ..*interaction };
        if !clear {
            let visibility = if has(PreviewStep::Occlusion) { visibility } else { 1.0 };
            let visibility = Vec3::splat(visibility) / (Vec3::ONE - albedo * (1.0 - visibility));
            let specular = Specular { f0, f90: highlight_f90, roughness: surface_material.roughness, untraced };
            self.radiances[preview_ray.slot] += preview_ray.weight * ambient_light * visibility;
            self.add_direct_light(
                preview_ray,
                &shaded,
                diffuse,
                &specular,
                if is_reflection { max_shadows.min(1) } else { max_shadows },
                shadow_tests,
            );
            return None;
        }
        self.radiances[preview_ray.slot] += preview_ray.weight * ambient_light;
        if !interaction.inside {
            let specular = Specular { f0, f90: highlight_f90, roughness: surface_material.roughness, untraced };
            self.add_direct_light(preview_ray, &shaded, diffuse, &specular, 0, shadow_tests);
        }
        let eta = if interaction.inside { surface_material.ior } else { 1.0 / surface_material.ior };
        let Some(refracted) = refract(direction, n, eta) else {
            // Total internal reflection.
            let ray = Ray { origin: interaction.p + interaction.normal_offset, direction: reflection.normalize() };
            return Some(PreviewRay { ray, ..*preview_ray });
        };
        let transmitted_weight = preview_ray.weight * transmitted * (Vec3::ONE - reflectance);
        self.radiances[preview_ray.slot] +=
            transmitted_weight * preview.ambient_radiance(refracted) * (1.0 - sharp_share);
        Some(PreviewRay {
            ray: Ray { origin: interaction.p - interaction.normal_offset, direction: refracted.normalize() },
            weight: transmitted_weight * sharp_share,
            medium: medium_beyond(preview_ray.medium, Vec3::from(material.absorption), interaction.inside),
            ..*preview_ray
        })
    }

    /// Adds direct light. That of the `shadows` strongest lights goes to `shadow_tests`, that of the others to the
    /// pixel.
    fn add_direct_light(
        &mut self,
        preview_ray: &PreviewRay,
        interaction: &SurfaceInteraction,
        diffuse: Vec3,
        specular: &Specular,
        shadows: usize,
        shadow_tests: &mut [Vec<ShadowTest>; MAX_SHADOWS],
    ) {
        let ctx = self.ctx;
        // A pixel's width off the surface, so that the first step of the shadow ray is not too short.
        let origin = interaction.p
            + interaction.normal_offset
            + interaction.normal * (10.0 * ctx.frame.tolerance * preview_ray.path_length);
        let unoccluded_light_of = |(index, radius): (u32, f32)| {
            let light = &ctx.scene.lights[index as usize];
            (light, unoccluded_light(&light.shape, radius, interaction.p, interaction.normal))
        };
        let mut strongest = [(Vec3::ZERO, 0); MAX_SHADOWS];
        for (k, &light_and_radius) in self.preview.lights.iter().enumerate() {
            let (light, unoccluded) = unoccluded_light_of(light_and_radius);
            if unoccluded.irradiance.max_element() <= 0.0 {
                continue;
            }
            let mut scattered = diffuse;
            if specular.f90.max_element() > 0.0 {
                // A light with a surface is visible in the traced reflection and needs no highlight there.
                let has_surface =
                    !matches!(light.shape, LightShape::Point(_) | LightShape::Spot(_) | LightShape::Sun(_));
                let is_reflected = has_surface || unoccluded.sine > 0.0;
                let highlight = highlight(&unoccluded, -preview_ray.ray.direction, interaction.normal, specular);
                scattered += highlight * if is_reflected { specular.untraced } else { 1.0 };
            }
            let mut contribution = (preview_ray.weight * scattered * unoccluded.irradiance, k);
            for entry in &mut strongest {
                if contribution.0.max_element() > entry.0.max_element() {
                    std::mem::swap(entry, &mut contribution);
                }
            }
            self.radiances[preview_ray.slot] += contribution.0;
        }
        for (rank, &(radiance, k)) in strongest.iter().enumerate() {
            if radiance.max_element() <= MIN_SHADOWED_LIGHT * strongest[0].0.max_element() || rank >= shadows {
                self.radiances[preview_ray.slot] += radiance;
                continue;
            }
            let (light, unoccluded) = unoccluded_light_of(self.preview.lights[k]);
            let shadow_ray = ShadowRay {
                ray: Ray { origin, direction: lifted(unoccluded.direction, interaction.normal) },
                leaf: interaction.leaf,
                limit: unoccluded.distance,
                sharpness: shadow_sharpness(&unoccluded, light.shape.penumbra(), interaction.normal),
            };
            shadow_tests[rank].push(ShadowTest { slot: preview_ray.slot, radiance, shadow_ray });
        }
    }

    /// Ambient visibility of surfaces, from a few distances along their normals.
    fn ambient_visibility(&self, interactions: &[SurfaceInteraction]) -> Vec<f32> {
        let mut result = Vec::with_capacity(interactions.len());
        for chunk in interactions.chunks(8) {
            let lane = |k: usize| chunk.get(k).unwrap_or(&chunk[0]);
            let vector = |value: fn(&SurfaceInteraction) -> Vec3| {
                let component = |k: usize| lanes(|lane_index| value(lane(lane_index))[k]);
                FieldVec3::new(component(0), component(1), component(2))
            };
            let (p, n) = (vector(|interaction| interaction.p), vector(|interaction| interaction.normal));
            let leaf = lanes(|k| lane(k).leaf as f32);
            let mut occlusion = f32x8::ZERO;
            let mut height = self.preview.occlusion_distance;
            for _ in 0..5 {
                let distance =
                    self.ctx.scene.field.distance_to(p + n * f32x8::splat(height), &self.preview.neighbours, leaf);
                occlusion += (f32x8::ONE - distance * f32x8::splat(1.0 / height)).fast_max(f32x8::ZERO);
                height *= 0.5;
            }
            result.extend(
                occlusion
                    .to_array()
                    .into_iter()
                    .take(chunk.len())
                    .map(|occlusion| 1.0 - OCCLUSION_PER_EVALUATION * occlusion),
            );
        }
        result
    }

    /// Adds light dimmed by shadows, eight rays at a time.
    fn cast_shadows(&mut self, shadow_tests: &[ShadowTest]) {
        let (ctx, preview) = (self.ctx, self.preview);
        for chunk in shadow_tests.chunks(8) {
            let lane = |k: usize| chunk.get(k).unwrap_or(&chunk[0]);
            let visibilities = soft_shadows(ctx, &preview.occluders, std::array::from_fn(|k| lane(k).shadow_ray));
            for (test, visibility) in chunk.iter().zip(visibilities) {
                self.radiances[test.slot] += test.radiance * visibility;
            }
        }
    }
}

/// Smooth step from 0 at `low` to 1 at `high`.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Refracted direction; `eta` is the index of refraction before the surface divided by that behind it. `None` for total
/// internal reflection.
fn refract(direction: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cosine = direction.dot(n);
    let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (square > 0.0).then(|| direction * eta - n * (eta * cosine + square.sqrt()))
}

/// Direction lifted above the surface, for a light that is partly below the horizon.
fn lifted(direction: Vec3, n: Vec3) -> Vec3 {
    (direction + n * (0.1 - direction.dot(n)).max(0.0)).normalize()
}

/// Sharpness of the shadow of a light, limited so that the surface itself is no near miss.
fn shadow_sharpness(unoccluded: &UnoccludedLight, penumbra: f32, n: Vec3) -> f32 {
    let cone_sharpness =
        (1.0 - unoccluded.sine * unoccluded.sine).max(0.0).sqrt() / unoccluded.sine.max(1.0 / MAX_SHARPNESS);
    let sharpness = if penumbra > 0.0 { penumbra } else { cone_sharpness };
    sharpness.max(1.0 / unoccluded.direction.dot(n).max(0.1)).min(MAX_SHARPNESS)
}

/// BRDF of the highlight of a light, 1/sr; `view` is the unit vector towards the viewer.
fn highlight(unoccluded: &UnoccludedLight, view: Vec3, n: Vec3, specular: &Specular) -> Vec3 {
    let alpha = (specular.roughness * specular.roughness).max(0.02);
    // Representative point: the direction to the part of the light that is nearest to the reflection.
    let reflection = n * (2.0 * n.dot(view)) - view;
    let offset = reflection * unoccluded.direction.dot(reflection) - unoccluded.direction;
    let nearest = unoccluded.direction + offset * (unoccluded.sine / offset.length().max(1e-6)).min(1.0);
    let half = (nearest.normalize() + view).normalize_or(n);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    let cosine = n.dot(half).max(0.0);
    // The highlight is negligible here.
    if exponent * (1.0 - cosine) > 12.0 {
        return Vec3::ZERO;
    }
    let widening = alpha / (alpha + 0.5 * unoccluded.sine).min(1.0);
    let peak = (exponent + 8.0) / (8.0 * PI) * widening * widening;
    let fresnel = specular.f0 + (specular.f90 - specular.f0) * (1.0 - half.dot(view).clamp(0.0, 1.0)).powi(5);
    fresnel * (peak * cosine.powf(exponent))
}
