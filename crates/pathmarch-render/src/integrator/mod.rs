//! Light transport, written twice on purpose.
//!
//! Each part is a pair of files: `x.wgsl` for the kernel and `x.rs` for the CPU backend. The CPU backend is an
//! independent path tracer in plain Rust; tests compare the kernels with it. Both use the same random numbers in the
//! same order, so pictures of one seed differ only by rounding.

pub(crate) mod camera;
pub(crate) mod emitter_coverage;
pub(crate) mod emitter_edges;
pub(crate) mod first_mirror;
pub(crate) mod guides;
pub(crate) mod lens_targets;
pub(crate) mod light_sampling;
mod light_sampling_lanes;
pub(crate) mod media_segment;
pub(crate) mod medium;
pub(crate) mod medium_light;
pub(crate) mod moments;
mod nested_dielectrics;
mod opaque_surfaces;
pub(crate) mod packets;
pub(crate) mod participating_media;
pub(crate) mod path;
pub(crate) mod path_reuse;
pub(crate) mod path_reuse_choice;
pub(crate) mod path_state;
pub(crate) mod photons;
pub(crate) mod pixel_albedo;
mod probe;
pub(crate) mod reflected_light;
pub(crate) mod sample_counts_choice;
pub(crate) mod shadow;
pub(crate) mod splitting;
pub(crate) mod splitting_choice;
mod surface_samples;
