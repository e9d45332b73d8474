//! Light that the facets of a glossy surface reflect or refract, recorded apart with the guide of the path.
//!
//! **Idea.** At the surface of the guide, a light sample and the light that the rest of the path brings are each split by
//! the [share](pathmarch_scene::materials::Facets) of the facets in the BSDF. Their distance is that of what is mirrored,
//! weighted by its luminance: where facets are smooth, its image is so far behind the surface.

use super::path_state::Path;
use super::shadow::ShadowTest;
use crate::sampling::basis::{basis, local_viewer};
use crate::scene::TraceContext;
use crate::scene::leaf::FRACTAL;
use crate::scene::light::luminance;
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use crate::wgsl::shared_constants;
use glam::{Mat3, Vec3};
use pathmarch_scene::materials::{BsdfParameters, Facets};

shared_constants! {
    /// Largest alpha of facets whose light is recorded: that of others, turned to all sides, hardly moves.
    const MAX_FACET_ALPHA: f32 = 0.36;
    /// The same for fractals, on which no image is smooth.
    const MAX_FACET_ALPHA_OF_FRACTALS: f32 = 0.15;
    /// Least alpha of facets which half of the paths follow. It is proportional to the relative standard deviation of one sample
    /// of even light.
    const CHOSEN_ALPHA: f32 = 0.03;
}

/// Light of the facets of a surface, or of the media in front of it. The order is that in memory, as for guides.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct ReflectedLight {
    /// Mean radiance.
    pub(crate) radiance: Vec3,
    /// Mean square of the luminance of the samples, divided as the radiance is filtered.
    pub(crate) square: f32,
    /// Distance d from the surface to what is mirrored, as d / (d + l) with the length l of the path to the surface: 0 at the
    /// surface, 1 at infinity. For media, the distance from the camera, see `medium_light`.
    pub(crate) depth: f32,
    /// Width of the distribution of the facets' normals; `MEDIUM_ALPHA` for media, 0 if there are neither.
    pub(crate) alpha: f32,
    /// True if they reflect in the colour of the surface.
    pub(crate) is_coloured: bool,
}

impl ReflectedLight {
    /// No facets.
    pub(crate) const NONE: Self =
        Self { radiance: Vec3::ZERO, square: 0.0, depth: 0.0, alpha: 0.0, is_coloured: false };

    /// Adds the light of a sample, which has this share in the mean.
    pub(super) fn add(&mut self, sample: &Self, share: f32) {
        let before = luminance(self.radiance.into()) * (1.0 - share);
        self.radiance = self.radiance.lerp(sample.radiance, share);
        self.square += (sample.square - self.square) * share;
        let new = luminance(sample.radiance.into()) * share + 1e-9;
        self.depth += (sample.depth - self.depth) * (new / (before + new));
    }
}

/// Light being recorded.
pub(super) struct ReflectionRecorder {
    /// Number of paths.
    paths: usize,
    /// One for each path; empty before the first facets.
    slots: Vec<Option<Reflection>>,
    /// Far end of all rays.
    far: f32,
}

/// An alpha as the word of a guide has it on GPUs: its root in eight bits, 0 only if it is 0.
fn rounded_alpha(alpha: f32) -> f32 {
    let root = (alpha.sqrt() * 255.0).round().max(1.0) / 255.0;
    if alpha > 0.0 { root * root } else { 0.0 }
}

/// Light of the facets at the surface of a path.
struct Reflection {
    /// True if the surface waits for its samples.
    waits: bool,
    surface: FacetedSurface,
    alpha: f32,
    is_coloured: bool,
    /// Length of the path at the surface, metres.
    length: f32,
    /// Share of the facets in the light sample, its distance, and its light.
    sampled_share: Vec3,
    sampled_distance: f32,
    sampled: Vec3,
    /// Radiance of the path before it went on, and the share of the facets in the rest.
    before: Vec3,
    share: Vec3,
    /// Distance to the next vertex.
    distance: f32,
}

/// Surface with facets.
struct FacetedSurface {
    facets: &'static Facets,
    parameters: BsdfParameters,
    local_from_world: Mat3,
    wo: Vec3,
    inside: bool,
}

impl Reflection {
    /// Share of the facets in light from a direction in world space.
    fn share(&self, direction: Vec3) -> Vec3 {
        let FacetedSurface { facets, parameters, local_from_world, wo, inside } = &self.surface;
        (facets.share)(parameters, *wo, (*local_from_world * direction).normalize(), *inside)
    }

    /// Least alpha with which the light is filtered: the fewer paths follow the facets, the more noise it has.
    fn least_alpha(&self) -> f32 {
        let FacetedSurface { facets, parameters, wo, inside, .. } = &self.surface;
        let chance = (facets.chance)(parameters, *wo, *inside);
        let deviation = ((1.0 - chance).max(0.0) / chance.max(1e-6)).sqrt();
        (CHOSEN_ALPHA * deviation).min(MAX_FACET_ALPHA)
    }
}

impl ReflectionRecorder {
    pub(super) fn new(paths: usize) -> Self {
        Self { paths, slots: Vec::new(), far: 0.0 }
    }

    /// Starts with the surface of a path.
    pub(super) fn begin(&mut self, ctx: &TraceContext, path: &Path, interaction: &SurfaceInteraction) {
        self.far = ctx.frame.far;
        let leaf = &ctx.scene.leaves[interaction.leaf];
        let material = &ctx.scene.materials[leaf.material as usize];
        let Some(facets) = ctx.scene.bsdfs[leaf.material as usize].and_then(|bsdf| bsdf.facets) else { return };
        let textured = TexturedPoint::new(ctx, interaction, path.length);
        let parameters =
            textured.as_ref().map_or(material.parameters, |textured| textured.parameters(&material.parameters));
        let alpha = (facets.alpha)(&parameters);
        let max_alpha = if leaf.has(FRACTAL) { MAX_FACET_ALPHA_OF_FRACTALS } else { MAX_FACET_ALPHA };
        if alpha > max_alpha {
            return;
        }
        let ns = shading_normal(ctx.config, textured.as_ref(), interaction, -path.ray.direction);
        let local_from_world = basis(ns).transpose();
        let wo = local_viewer(local_from_world, -path.ray.direction);
        self.slots.resize_with(self.paths, || None);
        self.slots[path.slot] = Some(Reflection {
            waits: true,
            alpha: rounded_alpha(alpha),
            is_coloured: (facets.are_coloured)(&parameters),
            surface: FacetedSurface { facets, parameters, local_from_world, wo, inside: interaction.inside },
            length: path.length,
            sampled_share: Vec3::ZERO,
            sampled_distance: 0.0,
            sampled: Vec3::ZERO,
            before: Vec3::ZERO,
            share: Vec3::ZERO,
            distance: self.far,
        });
    }

    /// Light at the surface of a path, if it waits.
    fn waiting(&mut self, slot: usize) -> Option<&mut Reflection> {
        self.slots.get_mut(slot)?.as_mut().filter(|reflection| reflection.waits)
    }

    /// Records a light sample of a path, in this direction and at this distance.
    pub(super) fn sample_light(&mut self, slot: usize, direction: Vec3, distance: f32) {
        if let Some(reflection) = self.waiting(slot) {
            reflection.sampled_share = reflection.share(direction);
            reflection.sampled_distance = distance;
        }
    }

    /// Records the light samples of paths in these slots.
    pub(super) fn sample_lights(&mut self, tests: &[ShadowTest], slot_of: impl Fn(&ShadowTest) -> usize) {
        for test in tests {
            self.sample_light(slot_of(test), test.ray.direction, test.distance);
        }
    }

    /// Adds light that a sampled light contributed.
    pub(super) fn add_sampled(&mut self, slot: usize, light: Vec3) {
        if let Some(reflection) = self.waiting(slot) {
            reflection.sampled += light * reflection.sampled_share;
        }
    }

    /// Records that a path, which has this radiance, goes on in this direction.
    pub(super) fn go_on(&mut self, slot: usize, direction: Vec3, radiance: Vec3) {
        if let Some(reflection) = self.waiting(slot) {
            reflection.share = reflection.share(direction);
            reflection.alpha = rounded_alpha(reflection.alpha.max(reflection.least_alpha()));
            reflection.before = radiance;
        }
    }

    /// Records the next vertex of a path, which has this length there.
    pub(super) fn arrive(&mut self, slot: usize, length: f32) {
        if let Some(reflection) = self.waiting(slot) {
            // A vertex in a medium has no length from the camera.
            let distance = length - reflection.length;
            reflection.distance = if distance > 0.0 { distance } else { reflection.distance };
            reflection.waits = false;
        }
    }

    /// Share of the facets in the light that the rest of a path brings; 0 without facets.
    pub(super) fn share_of_rest(&self, slot: usize) -> Vec3 {
        self.slots.get(slot).and_then(Option::as_ref).map_or(Vec3::ZERO, |reflection| reflection.share)
    }

    /// Lights of all paths that have facets, and whose radiances these are.
    pub(super) fn into_lights(self, radiance: &[Vec3]) -> impl Iterator<Item = (usize, ReflectedLight)> {
        let far = self.far;
        let of = move |(slot, reflection): (usize, Option<Reflection>)| {
            let Reflection { alpha, is_coloured, length, sampled, sampled_distance, before, share, distance, .. } =
                reflection?;
            let rest = (radiance[slot] - before) * share;
            let [near, farther] = [sampled, rest].map(|light| luminance(light.into()).max(0.0));
            let depths = [sampled_distance, distance].map(|distance| distance.min(far) / (distance.min(far) + length));
            let depth = if near + farther > 0.0 {
                (depths[0] * near + depths[1] * farther) / (near + farther)
            } else {
                depths[1]
            };
            Some((slot, ReflectedLight { radiance: sampled + rest, square: 0.0, depth, alpha, is_coloured }))
        };
        self.slots.into_iter().enumerate().filter_map(of)
    }
}
