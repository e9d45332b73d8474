//! PixelSampler numbers, distributions and warps. Each sequence is a pair of one name: `x.rs` for the CPU, `x.wgsl` for kernels.

pub(crate) mod alias_table;
pub(crate) mod basis;
pub(crate) mod r2_sequence;
pub(crate) mod sobol;
