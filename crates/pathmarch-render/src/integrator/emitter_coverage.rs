//! Coverage of pixels of live pictures by emitters that the camera sees.
//!
//! **Idea.** The samples of a film tell where emitters begin: there, a few camera rays find which share of a pixel an emitter
//! covers. [`emitter_edges`](super::emitter_edges) does so for pictures at rest, whose film it corrects.
//!
//! Emitters far [out of focus](super::lens_targets) may be seen in all of their discs, whatever the samples there show.
//!
//! **Limits.** An emitter of which the samples around a pixel show but one may be too small to be found in every picture; it
//! has no edges.

use super::emitter_edges::{Seen, seen_by_further_rays};
use super::guides::{Guide, colours_differ};
use super::lens_targets::LensTargets;
use crate::output::film::kept;
use crate::scene::TraceContext;
use crate::wgsl::shared_constants;
use glam::Vec4;

shared_constants! {
    /// Number of camera rays that find the coverage of a pixel.
    pub(crate) const COVERAGE_RAYS: u32 = 8;
    /// Number of pixels whose rays a workgroup traces.
    pub(crate) const COVERAGES_PER_GROUP: u32 = 64 / COVERAGE_RAYS;
    /// Share of emitters in a pixel within one, whose light is that of the film.
    pub(crate) const FULL_COVERAGE: f32 = 2.0;
    /// Share of emitters at an edge where no ray finds one: the number tells that it is an edge.
    pub(crate) const LEAST_COVERAGE: f32 = 1e-30;
    /// Least share of a pixel that emitters leave to the rest of the picture.
    pub(crate) const LEAST_REST: f32 = 0.05;
    /// Least number of samples of an emitter in 3x3 pixels at its edge.
    pub(crate) const MIN_EMITTER_SAMPLES: u32 = 2;
    /// Difference between the radiances of two emitters, in the larger one, above which there is an edge between them.
    const EMITTER_CONTRAST: f32 = 0.02;
    /// Places, see [`EmitterPlace`].
    const OUTSIDE_EMITTERS: u32 = EmitterPlace::Outside as u32;
    const AT_EMITTER_EDGE: u32 = EmitterPlace::Edge as u32;
    const IN_LENS_TARGET: u32 = EmitterPlace::OutOfFocus as u32;
    const WITHIN_EMITTERS: u32 = EmitterPlace::Within as u32;
}

/// Light of the emitters that a pixel sees, W/(m² sr), and the share of the pixel that they cover; [`FULL_COVERAGE`] instead
/// of both within an emitter. Where an emitter far out of focus may be seen, the share has a negative sign.
pub(crate) type Coverage = Vec4;

/// Where a sample is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum EmitterPlace {
    /// No emitter is beside it.
    Outside,
    /// At the edge of an emitter, or of another one.
    Edge,
    /// Where an emitter far out of focus may be seen.
    OutOfFocus,
    /// All around it is one emitter.
    Within,
}

/// Place of a sample among those of the square of 3x3 pixels around it, itself included.
pub(crate) fn emitter_place<'a>(here: &Guide, square: impl Iterator<Item = &'a Guide>) -> EmitterPlace {
    let (mut emitters, mut has_edge) = (0, false);
    for there in square {
        emitters += u32::from(there.is_seen_emitter());
        has_edge |= !there.is_seen_emitter() || colours_differ(there.albedo, here.albedo, EMITTER_CONTRAST);
    }
    match () {
        () if emitters < MIN_EMITTER_SAMPLES => EmitterPlace::Outside,
        () if has_edge || here.is_mixed => EmitterPlace::Edge,
        () => EmitterPlace::Within,
    }
}

/// Coverage of these pixels, from camera rays of their own; `sample` is the index of the film's first sample.
pub(crate) fn coverages(
    ctx: &TraceContext,
    targets: &LensTargets,
    pixels: &[(u32, u32)],
    sample: u32,
) -> Vec<Coverage> {
    if pixels.is_empty() {
        return Vec::new();
    }
    let seen = seen_by_further_rays(ctx, targets, pixels, sample.wrapping_mul(COVERAGE_RAYS), COVERAGE_RAYS);
    let coverage = |seen: &[Seen]| {
        let emitters = seen.iter().filter(|seen| seen.emission.is_emitter);
        emitters.map(|seen| kept(seen.emission.radiance).extend(1.0) * seen.weight).sum::<Vec4>() / COVERAGE_RAYS as f32
    };
    seen.chunks(COVERAGE_RAYS as usize).map(coverage).collect()
}
