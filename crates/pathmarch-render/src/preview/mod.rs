//! A quick look without noise: what ray marching showed before it traced paths.
//!
//! **Idea.** One ray through the pixel; at what it meets, direct light of every light as if nothing were in its way, shadows
//! of the strongest [`SHADOWED`] by near misses of the march, one glossy highlight, light from all around times ambient
//! occlusion, and one mirror reflection that is shaded in the same way. Clear surfaces bend the ray by Snell's law and let it go on. Nothing is
//! drawn at random: a sample is the same for every seed, and the first one goes through the middle of the pixel.
//!
//! **Sources.** Carvalho 2020, section 3.3. Penumbrae: [`soft_shadow`], as wide as the
//! light is seen. Ambient occlusion from a few evaluations of the field along the normal: Quilez 2008, "Rendering Worlds
//! with Two Triangles". Highlights: Blinn 1977 with a normalised exponent that follows roughness, widened by what the light
//! fills (Karis 2013, "Real Shading in Unreal Engine 4"). Schlick 1994 for Fresnel's law. Light from all around:
//! [`ambient_sh`].
//!
//! **What it is not.** Light from all around is one function of the normal for the whole picture; what hides it is guessed.
//! Lamps and glass cast no shadows. Near misses darken outwards from the edge of the shadow only. Within clear solids only
//! total reflection is followed.
//! Rough reflections are a mixture of a sharp one and of light from all around. Only the strongest lights of a point have
//! shadows there, and at most [`MAX_LIGHTS`] are known. A picture of the sky lights from all around, without shadows.
//!
//! **Cost.** Up to [`MAX_SURFACES`] + [`MAX_REFLECTED`] marches, and for each surface that is shaded [`SHADOWED`] more and five
//! evaluations of the field.

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
use crate::sampling::r2_sequence;
use crate::scene::preview_material::{self, PreviewParameters};
use crate::scene::{LightShape, TraceContext};
use crate::settings::LightSearch;
use crate::shading::surface_interaction::{SurfaceInteraction, interactions};
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::Scene;
use std::f32::consts::PI;
use wide::f32x8;

shared_constants! {
    /// Surfaces along the reflection.
    const MAX_REFLECTED: u32 = 3;
    /// Surfaces along the camera's ray at most: it passes clear ones.
    const MAX_SURFACES: u32 = 6;
    /// Lights that have shadows at a point.
    const SHADOWED: usize = 3;
    /// Reflections that add less than this are left out.
    const FAINT: f32 = 0.02;
    /// Lights that are weaker than this part of the strongest one cast none.
    const WEAK: f32 = 0.1;
    /// The hardest shadow: one over the sine of half the angle that its light fills.
    const HARDEST: f32 = 64.0;
    /// How much each of the five distances of ambient occlusion hides at most.
    const HIDES: f32 = 0.15;
}

/// Lights that are known.
const MAX_LIGHTS: usize = 64;

/// Data of a preview beyond that of paths.
#[derive(Clone, Debug)]
pub(crate) struct Preview {
    /// Ambient irradiance: coefficients of the nine polynomials of [`ambient_sh::basis`].
    pub(crate) ambient: [Vec3; 9],
    /// Distance of ambient occlusion, metres.
    pub(crate) reach: f32,
    /// Indices of lights, and the radius of the sphere that stands for each, metres.
    pub(crate) lights: Vec<(u32, f32)>,
    /// Preview material of each material.
    pub(crate) materials: Vec<PreviewParameters>,
    /// Objects that cast shadows.
    pub(crate) occluders: Vec<bool>,
    /// Objects that count for ambient occlusion.
    pub(crate) neighbours: Vec<bool>,
}

impl Preview {
    /// Preview data of a scene. Traces the paths of [`ambient_sh`].
    pub(crate) fn new(scene: &Scene, ctx: &TraceContext) -> Self {
        let lights = &ctx.scene.lights;
        let is_local = |k: &u32| !matches!(lights[*k as usize].shape, LightShape::Environment);
        let mut order: Vec<u32> = (0..lights.len() as u32).filter(is_local).collect();
        // The sort is stable: lights of the same power keep the order of the file.
        order.sort_by(|&a, &b| lights[b as usize].pmf.total_cmp(&lights[a as usize].pmf));
        order.truncate(MAX_LIGHTS);
        let radius = |index: u32| {
            let shape = &lights[index as usize].shape;
            let share = match shape {
                LightShape::Bounded(sphere) => ambient_sh::visible_share(ctx, sphere),
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
        let known: Vec<u32> = lights.iter().map(|(index, _)| *index).collect();
        let ambient = ambient_sh::ambient_sh(ctx, &known);
        let materials = scene.materials.iter().map(|material| preview_material::encode(&material.look())).collect();
        Self { ambient, reach: reach(scene), lights, materials, occluders, neighbours }
    }

    /// Objects that count in each distance function of `preview.wgsl`.
    pub(crate) fn distance_functions(&self) -> [(&str, &[bool]); 2] {
        [("occluder_distance", &self.occluders), ("neighbour_distance", &self.neighbours)]
    }

    /// Whether any material reflects specularly.
    pub(crate) fn has_reflections(&self) -> bool {
        let reflects = |material: &PreviewParameters| {
            preview_material::decode(material).mirrored.as_flattened().iter().any(|&share| share > 0.0)
        };
        self.materials.iter().any(reflects)
    }

    /// Ambient irradiance on a surface with this normal, W/m².
    fn irradiance(&self, n: Vec3) -> Vec3 {
        let sum: Vec3 = self.ambient.iter().zip(ambient_sh::basis(n)).map(|(factor, value)| *factor * value).sum();
        sum.max(Vec3::ZERO)
    }

    /// Blurred radiance of a rough reflection into this direction, W/(m² sr).
    fn blurred(&self, direction: Vec3) -> Vec3 {
        self.irradiance(direction) / PI
    }
}

/// Distance of ambient occlusion, metres: a part of the size of the object in the middle of all sizes.
fn reach(scene: &Scene) -> f32 {
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

/// Ray that is being traced, and what it carries.
#[derive(Clone, Copy)]
struct Walk {
    slot: usize,
    ray: Ray,
    /// Length of the path before it, metres.
    path_length: f32,
    weight: Vec3,
    medium: Vec3,
}

/// What a surface mirrors.
struct Gloss {
    straight: Vec3,
    grazing: Vec3,
    roughness: f32,
    /// Share of lamps that the reflection does not show.
    blurred: f32,
}

/// Light that a shadow may hide.
#[derive(Clone, Copy)]
struct Hidable {
    slot: usize,
    colour: Vec3,
    towards: ShadowRay,
}

/// One sample of each of these pixels.
pub(crate) fn trace(ctx: &TraceContext, preview: &Preview, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let mut colours = vec![Vec3::ZERO; pixels.len()];
    let [dx, dy] = r2_sequence::sample_2d(sample);
    let frame = ctx.frame;
    let walks: Vec<Walk> = pixels
        .iter()
        .enumerate()
        .map(|(slot, &(x, y))| Walk {
            slot,
            ray: central_ray(frame, x as f32 + dx, y as f32 + dy),
            path_length: 0.0,
            weight: Vec3::ONE,
            medium: Vec3::from(frame.medium),
        })
        .collect();
    let mut follower = Follower { ctx, preview, sample, colours: &mut colours, reflections: Vec::new() };
    follower.follow(walks, MAX_SURFACES, true);
    let reflections = std::mem::take(&mut follower.reflections);
    follower.follow(reflections, MAX_REFLECTED, false);
    colours
}

struct Follower<'a> {
    ctx: &'a TraceContext<'a>,
    preview: &'a Preview,
    sample: u32,
    colours: &'a mut [Vec3],
    /// At most one for each slot.
    reflections: Vec<Walk>,
}

impl Follower<'_> {
    /// Follows rays to the last of `surfaces`; those that may be mirrored leave their reflections.
    fn follow(&mut self, mut walks: Vec<Walk>, surfaces: u32, mirrored: bool) {
        let ctx = self.ctx;
        let mut has_reflection = vec![!mirrored; self.colours.len()];
        for surface in 0..surfaces {
            if walks.is_empty() {
                return;
            }
            let marches: Vec<RaySegment> = walks
                .iter()
                .map(|walk| RaySegment { ray: walk.ray, path_length: walk.path_length, limit: f32::INFINITY })
                .collect();
            let mut met = Vec::with_capacity(walks.len());
            let mut reached = Vec::with_capacity(walks.len());
            for ((mut walk, hit), march) in walks.into_iter().zip(march(ctx, &marches)).zip(&marches) {
                if ctx.config.absorption {
                    walk.weight *= transmittance(walk.medium, hit.map_or(f32::INFINITY, |hit| hit.t));
                }
                match hit {
                    Some(hit) => {
                        walk.path_length += hit.t;
                        met.push((*march, hit));
                        reached.push(walk);
                    }
                    None => {
                        let direction = walk.ray.direction;
                        let beyond = light_sampling::sky_radiance(&ctx.scene.sky, LightSearch::Met, direction, 0.0)
                            + light_sampling::sun_radiance(ctx, direction, 0.0);
                        self.colours[walk.slot] += walk.weight * beyond;
                    }
                }
            }
            let seen = interactions(ctx, &met, |_, blend| r2_sequence::choice(self.sample, blend));
            let open = self.unoccluded(&seen);
            // By rank, so that the rays of a chunk go towards one light.
            let mut hidable = std::array::from_fn(|_| Vec::new());
            walks = Vec::new();
            for ((walk, seen), open) in reached.iter().zip(&seen).zip(open) {
                let goes_on = self.shade(walk, seen, open, !mirrored, &mut has_reflection[walk.slot], &mut hidable);
                match goes_on {
                    Some(next) if surface + 1 == surfaces => {
                        self.colours[next.slot] += next.weight * self.preview.blurred(next.ray.direction);
                    }
                    Some(next) => walks.push(next),
                    None => {}
                }
            }
            hidable.iter().for_each(|hidable| self.cast_shadows(hidable));
        }
    }

    /// Adds what a surface shows but for light that may be hidden; gives the ray beyond it, if it is clear.
    fn shade(
        &mut self,
        walk: &Walk,
        seen: &SurfaceInteraction,
        open: f32,
        is_reflection: bool,
        has_reflection: &mut bool,
        hidable: &mut [Vec<Hidable>; SHADOWED],
    ) -> Option<Walk> {
        let (ctx, preview) = (self.ctx, self.preview);
        let m = ctx.scene.leaves[seen.leaf].material as usize;
        let material = &ctx.scene.materials[m];
        if material.emits() {
            if ctx.scene.emits_towards(seen.leaf, seen.normal) {
                self.colours[walk.slot] += walk.weight * Vec3::from(material.emission);
            }
            return None;
        }
        let direction = walk.ray.direction;
        let textured = TexturedPoint::new(ctx, seen.leaf, seen.p, seen.outward(), walk.path_length);
        let look = match &textured {
            Some(textured) => preview_material::decode(&textured.preview(preview.materials[m])),
            None => preview_material::decode(&preview.materials[m]),
        };
        let n = textured.map_or(seen.normal, |textured| textured.normal(seen.outward(), seen.normal, -direction));
        let transmitted = Vec3::from(look.transmitted);
        let clear = transmitted.max_element() > 0.0;
        let cosine = (-direction.dot(n)).clamp(0.0, 1.0);
        let straight = Vec3::from(look.mirrored[0]);
        let grazing = (Vec3::from(look.mirrored[1]) * (1.0 - look.roughness)).max(straight);
        // What is mirrored within a clear solid is left out.
        let mirrored =
            if clear && seen.inside { Vec3::ZERO } else { straight + (grazing - straight) * (1.0 - cosine).powi(5) };
        let sharp = 1.0 - smoothstep(0.05, 0.45, look.roughness);
        let reflection = direction + n * (2.0 * cosine);
        let mut blurred = 1.0;
        if !*has_reflection && (walk.weight * mirrored).max_element() * sharp > FAINT {
            *has_reflection = true;
            blurred = 1.0 - sharp;
            self.reflections.push(Walk {
                ray: Ray { origin: seen.p + seen.normal_offset, direction: reflection.normalize() },
                weight: walk.weight * mirrored * sharp,
                ..*walk
            });
        }
        let diffuse = Vec3::from(look.diffuse) * (Vec3::ONE - mirrored) / PI;
        let around = diffuse * preview.irradiance(n) + mirrored * preview.blurred(reflection) * blurred;
        let lit = SurfaceInteraction { normal: n, ..*seen };
        if !clear {
            let open = Vec3::splat(open) / (Vec3::ONE - Vec3::from(look.diffuse) * (1.0 - open));
            let gloss = Gloss { straight, grazing, roughness: look.roughness, blurred };
            self.colours[walk.slot] += walk.weight * around * open;
            self.light(walk, &lit, diffuse, &gloss, if is_reflection { 1 } else { SHADOWED }, hidable);
            return None;
        }
        self.colours[walk.slot] += walk.weight * around;
        if !seen.inside {
            let gloss = Gloss { straight, grazing, roughness: look.roughness, blurred };
            self.light(walk, &lit, diffuse, &gloss, 0, hidable);
        }
        let eta = if seen.inside { look.ior } else { 1.0 / look.ior };
        let Some(bent) = refract(direction, n, eta) else {
            // Total reflection.
            let ray = Ray { origin: seen.p + seen.normal_offset, direction: reflection.normalize() };
            return Some(Walk { ray, ..*walk });
        };
        let passes = walk.weight * transmitted * (Vec3::ONE - mirrored);
        self.colours[walk.slot] += passes * preview.blurred(bent) * (1.0 - sharp);
        Some(Walk {
            ray: Ray { origin: seen.p - seen.normal_offset, direction: bent.normalize() },
            weight: passes * sharp,
            medium: medium_beyond(walk.medium, Vec3::from(material.absorption), seen.inside),
            ..*walk
        })
    }

    /// Adds the light of all lights: the strongest, `shadows` of them, to `hidable`, the others at once.
    fn light(
        &mut self,
        walk: &Walk,
        seen: &SurfaceInteraction,
        diffuse: Vec3,
        gloss: &Gloss,
        shadows: usize,
        hidable: &mut [Vec<Hidable>; SHADOWED],
    ) {
        let ctx = self.ctx;
        // Off the surface by a pixel, so that the march has a start.
        let origin = seen.p + seen.normal_offset + seen.normal * (10.0 * ctx.frame.tolerance * walk.path_length);
        let falls = |(index, radius): (u32, f32)| {
            let light = &ctx.scene.lights[index as usize];
            (light, unoccluded_light(&light.shape, radius, seen.p, seen.normal))
        };
        let mut strongest = [(Vec3::ZERO, 0); SHADOWED];
        for (k, &known) in self.preview.lights.iter().enumerate() {
            let (light, falls) = falls(known);
            if falls.irradiance.max_element() <= 0.0 {
                continue;
            }
            let mut scattered = diffuse;
            if gloss.grazing.max_element() > 0.0 {
                // A lamp that the reflection shows needs no highlight.
                let has_surface = !matches!(light.shape, LightShape::Point(_) | LightShape::Sun(_));
                let shown = has_surface || falls.sine > 0.0;
                let highlight = highlight(&falls, -walk.ray.direction, seen.normal, gloss);
                scattered += highlight * if shown { gloss.blurred } else { 1.0 };
            }
            let mut lit = (walk.weight * scattered * falls.irradiance, k);
            for place in &mut strongest {
                if lit.0.max_element() > place.0.max_element() {
                    std::mem::swap(place, &mut lit);
                }
            }
            self.colours[walk.slot] += lit.0;
        }
        for (rank, &(colour, k)) in strongest.iter().enumerate() {
            if colour.max_element() <= WEAK * strongest[0].0.max_element() || rank >= shadows {
                self.colours[walk.slot] += colour;
                continue;
            }
            let (light, falls) = falls(self.preview.lights[k]);
            let towards = ShadowRay {
                ray: Ray { origin, direction: above(falls.direction, seen.normal) },
                own: seen.leaf,
                limit: falls.distance,
                sharpness: sharpness(&falls, light.shape.penumbra(), seen.normal),
            };
            hidable[rank].push(Hidable { slot: walk.slot, colour, towards });
        }
    }

    /// How much of all directions is open before each surface, from a few distances along its normal.
    fn unoccluded(&self, seen: &[SurfaceInteraction]) -> Vec<f32> {
        let mut result = Vec::with_capacity(seen.len());
        for chunk in seen.chunks(8) {
            let lane = |k: usize| chunk.get(k).unwrap_or(&chunk[0]);
            let vector = |value: fn(&SurfaceInteraction) -> Vec3| {
                let part = |k: usize| lanes(|lane_index| value(lane(lane_index))[k]);
                FieldVec3::new(part(0), part(1), part(2))
            };
            let (p, n) = (vector(|seen| seen.p), vector(|seen| seen.normal));
            let own = lanes(|k| lane(k).leaf as f32);
            let mut hidden = f32x8::ZERO;
            let mut height = self.preview.reach;
            for _ in 0..5 {
                let distance =
                    self.ctx.scene.field.distance_to(p + n * f32x8::splat(height), &self.preview.neighbours, own);
                hidden += (f32x8::ONE - distance * f32x8::splat(1.0 / height)).fast_max(f32x8::ZERO);
                height *= 0.5;
            }
            result.extend(hidden.to_array().into_iter().take(chunk.len()).map(|hidden| 1.0 - HIDES * hidden));
        }
        result
    }

    /// Adds what shadows leave, eight rays at a time.
    fn cast_shadows(&mut self, hidable: &[Hidable]) {
        let (ctx, preview) = (self.ctx, self.preview);
        for chunk in hidable.chunks(8) {
            let lane = |k: usize| chunk.get(k).unwrap_or(&chunk[0]);
            let left = soft_shadows(ctx, &preview.occluders, std::array::from_fn(|k| lane(k).towards));
            for (lit, left) in chunk.iter().zip(left) {
                self.colours[lit.slot] += lit.colour * left;
            }
        }
    }
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A direction bent by a surface, `eta` being the index before it over that beyond; `None` where all is mirrored.
fn refract(direction: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cosine = direction.dot(n);
    let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (square > 0.0).then(|| direction * eta - n * (eta * cosine + square.sqrt()))
}

/// A direction lifted above the surface, where part of a light is below its horizon.
fn above(direction: Vec3, n: Vec3) -> Vec3 {
    (direction + n * (0.1 - direction.dot(n)).max(0.0)).normalize()
}

/// How hard the edge of a shadow is. The surface itself is not taken for a near miss.
fn sharpness(falls: &UnoccludedLight, penumbra: f32, n: Vec3) -> f32 {
    let seen = (1.0 - falls.sine * falls.sine).max(0.0).sqrt() / falls.sine.max(1.0 / HARDEST);
    let sharpness = if penumbra > 0.0 { penumbra } else { seen };
    sharpness.max(1.0 / falls.direction.dot(n).max(0.1)).min(HARDEST)
}

/// BRDF of the highlight of a light, 1/sr; `view` is towards the eye.
fn highlight(falls: &UnoccludedLight, view: Vec3, n: Vec3, gloss: &Gloss) -> Vec3 {
    let alpha = (gloss.roughness * gloss.roughness).max(0.02);
    // The direction to the part of the light that is nearest to the reflection.
    let reflection = n * (2.0 * n.dot(view)) - view;
    let across = reflection * falls.direction.dot(reflection) - falls.direction;
    let nearest = falls.direction + across * (falls.sine / across.length().max(1e-6)).min(1.0);
    let half = (nearest.normalize() + view).normalize_or(n);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    let cosine = n.dot(half).max(0.0);
    // Far from the highlight there is none.
    if exponent * (1.0 - cosine) > 12.0 {
        return Vec3::ZERO;
    }
    let widened = alpha / (alpha + 0.5 * falls.sine).min(1.0);
    let peak = (exponent + 8.0) / (8.0 * PI) * widened * widened;
    let fresnel = gloss.straight + (gloss.grazing - gloss.straight) * (1.0 - half.dot(view).clamp(0.0, 1.0)).powi(5);
    fresnel * (peak * cosine.powf(exponent))
}
