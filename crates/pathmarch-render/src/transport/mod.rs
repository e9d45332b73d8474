//! How light travels, written twice on purpose.
//!
//! Each part is a pair of one name: `x.wgsl` runs in the GPU kernel, `x.rs` in the CPU renderer, which is an independent
//! path tracer in plain Rust and the oracle the kernel is tested against. Both draw the same random numbers in the same
//! order, so pictures of one seed differ only by rounding.

pub(crate) mod alias;
pub(crate) mod basis;
pub(crate) mod camera;
pub(crate) mod lights;
pub(crate) mod march;
pub(crate) mod path;
pub(crate) mod random;
mod shadow;
pub(crate) mod sky;

/// The kernel's WGSL but for the scene's field; declarations may stand in any order.
pub(crate) const KERNEL: [&str; 8] = [
    include_str!("basis.wgsl"),
    include_str!("camera.wgsl"),
    include_str!("lights.wgsl"),
    include_str!("march.wgsl"),
    include_str!("path.wgsl"),
    include_str!("random.wgsl"),
    include_str!("shadow.wgsl"),
    include_str!("sky.wgsl"),
];

/// Only for scenes whose shadows are softened by near misses.
pub(crate) const PENUMBRA: &str = include_str!("penumbra.wgsl");
