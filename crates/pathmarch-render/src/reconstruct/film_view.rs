//! Film that is reconstructed on the CPU.

use crate::backend::RenderInput;
use crate::integrator::guides::Guide;
use glam::Vec3;
use std::sync::Arc;

/// Film of a sequence, as reconstruction reads it.
pub(super) struct FilmView<'a> {
    pub(super) input: &'a RenderInput,
    pub(super) guides: &'a Arc<Vec<Guide>>,
    pub(super) means: &'a [Vec3],
    /// Number of samples in each mean.
    pub(super) samples: u32,
    /// Index of the first sample.
    pub(super) first_sample: u32,
    /// Weight of the means themselves, 0 to 1.
    pub(super) weight: f32,
}
