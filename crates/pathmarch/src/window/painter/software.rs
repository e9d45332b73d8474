//! CPU painter of the window.

use super::raster::Canvas;
use super::{PaintError, Textures};
use egui::ClippedPrimitive;
use softbuffer::{Context, Surface};
use std::num::NonZeroU32;
use std::sync::Arc;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

pub(super) struct SoftwarePainter {
    surface: Surface<OwnedDisplayHandle, Arc<Window>>,
}

impl SoftwarePainter {
    pub(super) fn new(window: &Arc<Window>, display: OwnedDisplayHandle) -> Result<Self, String> {
        let context = Context::new(display).map_err(|error| error.to_string())?;
        let surface = Surface::new(&context, window.clone()).map_err(|error| error.to_string())?;
        Ok(Self { surface })
    }

    pub(super) fn paint(
        &mut self,
        window: &Window,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
        textures: &Textures,
    ) -> Result<(), PaintError> {
        let size = window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else {
            return Ok(());
        };
        let failed = |error: softbuffer::SoftBufferError| PaintError::Lost(error.to_string());
        self.surface.resize(width, height).map_err(failed)?;
        let mut buffer = self.surface.buffer_mut().map_err(failed)?;
        buffer.fill(0);
        Canvas { pixels: &mut buffer, width: width.get() as usize }.paint(primitives, pixels_per_point, textures);
        window.pre_present_notify();
        buffer.present().map_err(failed)
    }
}
