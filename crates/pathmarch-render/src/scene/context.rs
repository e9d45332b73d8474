//! What the functions of the CPU integrators read.

use super::{FrameUniforms, KernelConfig, RenderScene};
use crate::ray_stats::RayCounters;

/// Scene, frame and configuration of a picture, and where its rays are counted.
#[derive(Clone, Copy)]
pub(crate) struct TraceContext<'a> {
    pub(crate) scene: &'a RenderScene,
    pub(crate) frame: &'a FrameUniforms,
    pub(crate) config: &'a KernelConfig,
    /// Counters of rays and field evaluations, if they are wanted.
    pub(crate) stats: Option<&'a RayCounters>,
}
