//! Random numbers, discrete distributions and bases. Code for both backends is a pair of files: `x.rs` for the CPU,
//! `x.wgsl` for kernels.

pub(crate) mod alias_table;
pub(crate) mod basis;
pub(crate) mod r2_sequence;
pub(crate) mod sobol;
