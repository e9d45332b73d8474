//! GPU backend, through wgpu: Vulkan, Metal, Direct3D 12, OpenGL, and software adapters.

mod adapter;
mod bindings;
mod compose;
mod context;
mod device;
mod display;
mod encode;
mod job;
mod kernel_cache;
#[cfg(test)]
mod kernel_tests;
mod loop_limit;
mod pixel_pass;
pub(crate) mod shaders;
mod slice;
mod table_memory;
mod tables;
mod timer;

pub use adapter::{AdapterDescription, adapters};
pub(crate) use bindings::{FRAME, LEAVES, LIGHT_TREE};
pub(crate) use context::GpuContext;
pub(crate) use device::{Device, KernelTarget};
pub(crate) use job::{FilmCopy, GpuJob, LIVE, OFFLINE, ReconstructedFilm};
pub(crate) use kernel_cache::KernelSource;
pub(crate) use timer::GpuTimer;
