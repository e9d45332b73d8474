//! Light transport, written twice on purpose.
//!
//! Each part is a pair of one name: `x.wgsl` runs in the kernel, `x.rs` in the CPU backend, which is an independent
//! path tracer in plain Rust and the oracle that the kernels are tested against. Both draw the same random numbers in the same
//! order, so pictures of one seed differ only by rounding.

pub(crate) mod camera;
pub(crate) mod light_sampling;
pub(crate) mod medium;
pub(crate) mod moments;
pub(crate) mod path;
pub(crate) mod shadow;
pub(crate) mod splitting;
pub(crate) mod splitting_choice;
