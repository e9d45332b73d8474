//! Guides of reconstruction: for each pixel, the first surface on a path that scatters light instead of mirroring it.
//!
//! **Idea.** Recorded with the path itself, so that they cost no rays. Through mirrors, position and normal are those of
//! the mirror image: of a plane mirror, a world behind it that stands still when the camera moves. Position and normal of
//! glass are its own, since a path takes one of its two ways by chance. The surface is that of the first sample of a
//! pixel; the albedo is a mean over all of them, so that edges and textures are as smooth as the film.

use super::camera::central_point;
use super::first_mirror::FirstMirror;
use super::medium_light::{MEDIUM_ALPHA, MediumLightRecorder};
use super::path_state::Path;
use super::reflected_light::{ReflectedLight, ReflectionRecorder};
use super::shadow::ShadowTest;
use crate::intersect::ray::Ray;
use crate::scene::TraceContext;
use crate::scene::leaf::FRACTAL;
use crate::scene::light::luminance;
use crate::scene::material::{DELTA, GLOSSY, TRANSMITS};
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::{Mat3, Vec3};

/// Number of samples of a still picture from which on it is shown as it is, without guides.
pub(crate) const FILM_SAMPLES: u32 = 128;

shared_constants! {
    /// Largest number of mirrors and glass surfaces that guides look through.
    const MAX_DELTA_SURFACES: u32 = 8;
    /// Least albedo to divide by.
    pub(crate) const MIN_ALBEDO: f32 = 0.04;
    /// Least cosine between normals of samples that show one surface.
    const MIN_COMMON_COSINE: f32 = 0.8;
    /// Largest channel of light in one word.
    const MAX_PACKED_LIGHT: f32 = 65408.0;
    /// No leaf.
    pub(crate) const NO_LEAF: u32 = u32::MAX;
    /// Class of the sky.
    const GUIDE_SKY: u32 = GuideClass::Sky as u32;
    /// Class of emitters.
    const GUIDE_EMITTER: u32 = GuideClass::Emitter as u32;
    /// Class of smooth glass.
    const GUIDE_GLASS: u32 = GuideClass::Glass as u32;
    /// Class of surfaces that scatter light.
    const GUIDE_SURFACE: u32 = GuideClass::Surface as u32;
}

/// Object of the sky, unless a mirror shows it. Small enough for numbers of surfaces ([`Guide::object`] and some bits) to be
/// exact as floats.
pub(crate) const NO_OBJECT: u32 = (1 << 20) - 1;

/// Class of a guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GuideClass {
    /// No surface.
    Sky,
    /// Emitter, which has no noise.
    Emitter,
    /// Smooth glass.
    Glass,
    /// Surface that scatters light.
    Surface,
}

/// Guide of a pixel. The order is that in memory: vector instructions read the number behind a vector as well, and are slow where
/// it is an integer, as which they take it for a subnormal number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct Guide {
    /// Position in world space, or that of the mirror image; far away for the sky. With a lens, the point at this depth that a
    /// pinhole would show.
    pub(crate) position: Vec3,
    /// Distance of the position from the camera, metres: the length of the path.
    pub(crate) length: f32,
    /// Unit normal on the side of the camera, mirrored as the position is. For the sky, the negative of the direction in which
    /// the last segment of the path leaves the scene.
    pub(crate) normal: Vec3,
    /// Unit normal of the surface that is seen through glass; elsewhere the normal itself.
    pub(crate) seen_normal: Vec3,
    /// Albedo of the surface times the reflectance of mirrors in front of it; the radiance of an emitter; 1 for the sky and
    /// for glass. Mean over the samples.
    pub(crate) albedo: Vec3,
    /// Mean square of the luminance of the samples, each divided by its albedo.
    pub(crate) square: f32,
    /// Light that other surfaces have scattered to one that scatters light, without that of facets; 0 elsewhere, and on
    /// fractals. Mean over the samples.
    pub(crate) indirect: Vec3,
    /// Light that media in front of the surface scatter or emit; else that which the facets of a glossy surface reflect or
    /// refract; 0 elsewhere.
    pub(crate) reflected: ReflectedLight,
    /// Index of the object: for the sky, that of the first mirror which shows it, or [`NO_OBJECT`].
    pub(crate) object: u32,
    /// Index of the object that is seen through glass; elsewhere the object itself.
    pub(crate) seen_object: u32,
    /// Index of the leaf of `position`; [`NO_LEAF`] for the sky and for mirror images.
    pub(crate) leaf: u32,
    /// Mirror in front of the surface.
    pub(crate) mirror: FirstMirror,
    pub(crate) class: GuideClass,
    /// True if the samples show several surfaces.
    pub(crate) is_mixed: bool,
    /// True if the surface looks different from other directions.
    pub(crate) is_glossy: bool,
}

impl Guide {
    /// Guide of a pixel without a sample.
    pub(crate) const NONE: Self = Self {
        position: Vec3::ZERO,
        normal: Vec3::ZERO,
        seen_normal: Vec3::ZERO,
        albedo: Vec3::ONE,
        square: 0.0,
        length: 0.0,
        class: GuideClass::Sky,
        is_mixed: false,
        is_glossy: false,
        reflected: ReflectedLight::NONE,
        indirect: Vec3::ZERO,
        object: NO_OBJECT,
        seen_object: NO_OBJECT,
        leaf: NO_LEAF,
        mirror: FirstMirror::NONE,
    };
}

impl Guide {
    /// Factor between radiance and irradiance.
    pub(crate) fn divisor(&self) -> Vec3 {
        match self.class {
            GuideClass::Sky | GuideClass::Glass => Vec3::ONE,
            GuideClass::Emitter | GuideClass::Surface => self.albedo.max(Vec3::splat(MIN_ALBEDO)),
        }
    }

    /// Guide of a sample with this radiance.
    pub(crate) fn of_sample(self, radiance: Vec3) -> Self {
        // Rejected samples have no light at all.
        let [reflected, indirect] = [self.reflected.radiance, self.indirect]
            .map(|light| if radiance == Vec3::ZERO { Vec3::ZERO } else { light });
        let [all, of_facets] =
            [radiance / self.divisor(), reflected / self.reflection_divisor()].map(|light| luminance(light.into()));
        let reflected = ReflectedLight { radiance: reflected, square: of_facets * of_facets, ..self.reflected };
        Self { square: all * all, reflected, indirect: rounded(indirect), ..self }
    }

    /// Adds the guide of the sample of this index, from 1 on: the means change, the surface stays that of the first one.
    pub(crate) fn add(&mut self, sample: &Self, index: u32) {
        let share = 1.0 / (index + 1) as f32;
        let turned = self.normal.dot(sample.normal) < MIN_COMMON_COSINE && self.class != GuideClass::Sky;
        self.is_mixed |= self.class != sample.class || self.object != sample.object || turned;
        self.albedo = self.albedo.lerp(sample.albedo, share);
        self.square += (sample.square - self.square) * share;
        self.reflected.add(&sample.reflected, share);
        if self.class == GuideClass::Surface {
            // Rounded to the nearest, the mean does not fall from sample to sample.
            let mean = self.indirect.lerp(sample.indirect, share);
            self.indirect = rounded(mean + 0.5 * packed_step(mean));
        }
    }

    /// True if light that other surfaces scatter to one that the camera sees is recorded apart.
    fn has_indirect(&self, ctx: &TraceContext) -> bool {
        self.class == GuideClass::Surface && self.leaf != NO_LEAF && !ctx.scene.leaves[self.leaf as usize].has(FRACTAL)
    }

    /// True if the camera sees an emitter itself, not its mirror image.
    pub(crate) fn is_seen_emitter(&self) -> bool {
        self.class == GuideClass::Emitter && self.leaf != NO_LEAF
    }

    /// True if light is recorded apart that does not move with the surface.
    pub(crate) fn has_layer(&self) -> bool {
        self.reflected.alpha > 0.0
    }

    /// True if this light is that of media in front of the surface.
    pub(crate) fn has_medium(&self) -> bool {
        self.reflected.alpha == MEDIUM_ALPHA
    }

    /// True if it is that of facets of the surface.
    pub(crate) fn has_facets(&self) -> bool {
        self.has_layer() && !self.has_medium()
    }

    /// Factor between the radiance that the facets reflect and what is filtered.
    pub(crate) fn reflection_divisor(&self) -> Vec3 {
        if self.reflected.is_coloured { self.divisor() } else { Vec3::ONE }
    }
}

/// True if the largest difference between the channels of two colours, in their largest channel, is above this contrast.
pub(crate) fn colours_differ(a: Vec3, b: Vec3, contrast: f32) -> bool {
    (a - b).abs().max_element() > contrast * a.max(b).max_element()
}

/// Light as one word of memory has it: nine bits for each channel and a common exponent (Ward 1991). It is smaller by up to
/// 1/256 of its largest channel.
fn rounded(light: Vec3) -> Vec3 {
    let (kept, step) = (light.clamp(Vec3::ZERO, Vec3::splat(MAX_PACKED_LIGHT)), packed_step(light));
    (kept / step).trunc() * step
}

/// Difference between neighbouring numbers of a word of light.
fn packed_step(light: Vec3) -> f32 {
    let largest = light.max_element().clamp(0.0, MAX_PACKED_LIGHT);
    // The largest channel is below two to the power of the exponent.
    let exponent = ((largest.to_bits() >> 23) as i32 - 126).clamp(-15, 16);
    f32::from_bits(((exponent - 9 + 127) as u32) << 23)
}

/// Guides being recorded, one for each path.
pub(crate) struct GuideRecorder {
    camera_rays: Vec<Ray>,
    guides: Vec<Guide>,
    states: Vec<State>,
    /// Radiance of each path before the first light that another surface scatters to that of the guide.
    direct: Vec<Option<Vec3>>,
    /// Light of the facets of each guide's surface.
    pub(super) reflections: ReflectionRecorder,
    /// Light of the media in front of each guide's surface.
    pub(super) media: MediumLightRecorder,
}

/// State of the recording of a path: the surface that it waits for.
#[derive(Clone, Copy)]
enum State {
    /// The first surface that is no mirror; product of the mirror reflections so far.
    Mirrored(Mat3),
    /// The first surface that scatters light, seen through glass.
    BehindGlass,
    /// The next surface that scatters light, to which the guide's has sent the path.
    Scattered,
    /// Nothing.
    Done,
}

impl GuideRecorder {
    /// Guides of the sky, for these camera rays.
    pub(crate) fn new(ctx: &TraceContext, camera_rays: Vec<Ray>) -> Self {
        let sky = |ray: &Ray| Guide {
            position: central_point(ctx.frame, ray, ray.origin + ray.direction * ctx.frame.far),
            normal: -ray.direction,
            seen_normal: -ray.direction,
            length: ctx.frame.far,
            ..Guide::NONE
        };
        let guides = camera_rays.iter().map(sky).collect();
        let states = vec![State::Mirrored(Mat3::IDENTITY); camera_rays.len()];
        let (reflections, direct) = (ReflectionRecorder::new(camera_rays.len()), vec![None; camera_rays.len()]);
        let media = MediumLightRecorder::new(if ctx.config.media { camera_rays.len() } else { 0 });
        Self { reflections, media, camera_rays, guides, states, direct }
    }

    /// Reports whether the path in a slot waits for a surface.
    pub(super) fn waits(&self, slot: usize) -> bool {
        !matches!(self.states[slot], State::Done)
    }

    /// Ends the recording of the path in a slot.
    pub(crate) fn end(&mut self, slot: usize) {
        self.states[slot] = State::Done;
    }

    /// Distance of a point from the origin of a camera ray, metres.
    fn distance(&self, slot: usize, p: Vec3) -> f32 {
        p.distance(self.camera_rays[slot].origin)
    }

    /// Records that a path passes through a medium on its first segments, which emits this light around a point.
    pub(super) fn record_medium(&mut self, slot: usize, p: Vec3, emitted: Vec3) {
        self.media.pass(slot, emitted, self.distance(slot, p));
    }

    /// Records where light that media scatter is sampled.
    pub(super) fn sample_lights_in_media(&mut self, tests: &[ShadowTest]) {
        for test in tests {
            self.media.sample_light(test.slot, self.distance(test.slot, test.ray.origin));
        }
    }

    /// Records that a path of this radiance scatters at a point in a medium. What follows is light of the medium before the
    /// first surface, and indirect light behind one that scatters light.
    pub(super) fn record_event(&mut self, slot: usize, p: Vec3, surface_index: u32, radiance: Vec3) {
        if surface_index == 0 {
            self.media.scatter(slot, self.distance(slot, p), radiance);
        } else if matches!(self.states[slot], State::Scattered) {
            self.direct[slot] = Some(radiance);
            self.states[slot] = State::Done;
        }
    }

    /// Records the surface that a path of this radiance has reached with this throughput.
    pub(super) fn record(
        &mut self,
        ctx: &TraceContext,
        path: &Path,
        throughput: Vec3,
        interaction: &SurfaceInteraction,
        surface_index: u32,
        radiance: Vec3,
    ) {
        let slot = path.slot;
        let leaf = &ctx.scene.leaves[interaction.leaf];
        let material = &ctx.scene.materials[leaf.material as usize];
        let is_end = surface_index > ctx.frame.bounces && !material.emits();
        if is_end || !self.waits(slot) {
            return;
        }
        let object = ctx.scene.field.leaves()[interaction.leaf].object;
        let is_delta = material.has(DELTA) && surface_index < MAX_DELTA_SURFACES;
        let is_glass = is_delta && material.has(TRANSMITS);
        if matches!(self.states[slot], State::Scattered) {
            if !is_delta {
                // An emitter is no part of the indirect light.
                self.direct[slot] = (!material.emits()).then_some(radiance);
                self.states[slot] = State::Done;
            }
            return;
        }
        let guide = &mut self.guides[slot];
        let State::Mirrored(mirrors) = self.states[slot] else {
            if !is_delta {
                (guide.seen_normal, guide.seen_object) = (interaction.normal, object);
                self.states[slot] = State::Done;
            }
            return;
        };
        if is_delta && !is_glass {
            let n = interaction.normal;
            if surface_index == 0 {
                guide.mirror = FirstMirror::new(interaction.p.distance(self.camera_rays[slot].origin), n);
                (guide.object, guide.seen_object) = (object, object);
            }
            // For the sky, if no surface follows.
            guide.normal = guide.normal.reflect(n);
            guide.seen_normal = guide.normal;
            let reflection = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis - 2.0 * axis.dot(n) * n);
            self.states[slot] = State::Mirrored(mirrors * Mat3::from_cols(reflection[0], reflection[1], reflection[2]));
            return;
        }
        let (class, state) = match () {
            () if material.emits() => (GuideClass::Emitter, State::Done),
            () if is_glass => (GuideClass::Glass, State::BehindGlass),
            // Nothing is smooth there at half the resolution.
            () if leaf.has(FRACTAL) => (GuideClass::Surface, State::Done),
            () => (GuideClass::Surface, State::Scattered),
        };
        self.states[slot] = state;
        let albedo = if is_glass {
            Vec3::ONE
        } else {
            let textured = TexturedPoint::new(ctx, interaction, interaction.length);
            let plain = Vec3::from(ctx.scene.base_colours[leaf.material as usize]);
            throughput * textured.and_then(|textured| textured.colour()).unwrap_or(plain)
        };
        let ray = self.camera_rays[slot];
        let normal = mirrors * interaction.normal;
        // The length of a path starts anew at the boundaries of media.
        let starts_anew = ctx.config.boundaries && surface_index == 0;
        let length = if starts_anew { interaction.p.distance(ray.origin) } else { interaction.length };
        let position = central_point(ctx.frame, &ray, ray.origin + ray.direction * length);
        *guide = Guide {
            position,
            normal,
            seen_normal: normal,
            albedo,
            square: 0.0,
            length: position.distance(ctx.frame.position.into()),
            class,
            is_mixed: false,
            is_glossy: is_glass || material.has(GLOSSY),
            reflected: ReflectedLight::NONE,
            indirect: Vec3::ZERO,
            object,
            seen_object: object,
            leaf: if surface_index == 0 { interaction.leaf as u32 } else { NO_LEAF },
            mirror: guide.mirror,
        };
        if class == GuideClass::Surface && material.has(GLOSSY) && !self.media.has_passed(slot) {
            self.reflections.begin(ctx, path, interaction);
        }
    }

    /// Guides of all paths, which have these radiances, and of which each has this light of the second surfaces of a group.
    pub(super) fn into_guides(self, ctx: &TraceContext, radiance: &[Vec3], shared: Option<&[Vec3]>) -> Vec<Guide> {
        let Self { mut guides, reflections, media, direct, .. } = self;
        for (slot, direct) in direct.into_iter().enumerate() {
            // Other paths of the group bring light to one without a second surface.
            let shared = || shared.filter(|_| guides[slot].has_indirect(ctx)).map_or(Vec3::ZERO, |shared| shared[slot]);
            let indirect = direct.map_or_else(shared, |direct| radiance[slot] - direct);
            guides[slot].indirect = indirect * (1.0 - reflections.share_of_rest(slot));
        }
        for (slot, reflected) in reflections.into_lights(radiance).chain(media.into_lights(radiance, ctx.frame.far)) {
            guides[slot].reflected = reflected;
        }
        guides
    }
}
