//! The GPU backend, through wgpu: Vulkan, Metal, Direct3D 12, OpenGL, and software adapters.

mod compiled;
mod device;
mod display;
mod job;
mod kernel;
#[cfg(test)]
mod kernel_tests;
mod loop_limit;
mod memory;
mod stopwatch;

pub(crate) use compiled::Printed;
pub(crate) use device::Device;
pub use device::{AdapterDescription, adapters};
pub(crate) use job::{GpuJob, LIVE, WHOLE};
pub(crate) use memory::{FRAME, LEAVES};
