//! Backends: the CPU's cores or a GPU renders the same picture.

pub(crate) mod cpu;
pub(crate) mod gpu;
pub(crate) mod input;

pub(crate) use input::{ModeData, RenderInput};
