//! Random numbers, discrete distributions and bases. Code for both backends is a pair of files: `x.rs` for the CPU,
//! `x.wgsl` for kernels.

pub(crate) mod alias_table;
pub(crate) mod basis;
pub(crate) mod r2_sequence;
pub(crate) mod sobol;

use crate::wgsl::shared_constants;

shared_constants! {
    /// Largest number below one.
    pub(crate) const ONE_MINUS_EPSILON: f32 = 1.0 - 0.5 * f32::EPSILON;
}
