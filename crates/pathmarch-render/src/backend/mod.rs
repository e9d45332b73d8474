//! Backends: the same picture by the CPU's cores or by a GPU.

pub(crate) mod cpu;
pub(crate) mod gpu;
pub(crate) mod input;

pub(crate) use input::{ModeData, RenderInput};
