//! Context of the CPU integrators: everything they read, and the counters they write.

use super::{FrameUniforms, KernelConfig, PhotonMap, RenderScene};
use crate::ray_stats::RayCounters;

/// Scene, frame and configuration of a picture, and the counters of its rays.
#[derive(Clone, Copy)]
pub(crate) struct TraceContext<'a> {
    pub(crate) scene: &'a RenderScene,
    pub(crate) frame: &'a FrameUniforms,
    pub(crate) config: &'a KernelConfig,
    /// Photons of the sample, with traced caustics.
    pub(crate) photons: Option<&'a PhotonMap>,
    /// Counters of rays and field evaluations; none where nobody asks for statistics.
    pub(crate) stats: Option<&'a RayCounters>,
}
