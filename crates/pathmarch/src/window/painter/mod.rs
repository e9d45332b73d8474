//! Painter: draws egui's meshes into the window, on a GPU ([`gpu`]) or on the CPU ([`software`]). The CPU is used if
//! there is no adapter, or only a software one, which is slower.
//!
//! The painter shares nothing with the renderer: a scene that takes long to compile or trace does not block the window,
//! and a lost device affects only one of them. Copies of egui's textures are kept, so that a new painter can replace
//! one that was lost.

mod gpu;
mod raster;
mod software;

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ImageData, ImageDelta};
use egui::{ClippedPrimitive, TextureId};
use gpu::{GpuPainter, OpenError};
use software::SoftwarePainter;
use std::collections::HashMap;
use std::sync::Arc;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

/// Copies of egui's textures.
#[derive(Default)]
pub(super) struct Textures(HashMap<TextureId, ImageDelta>);

impl Textures {
    /// Applies updates of a frame that is not drawn.
    pub(super) fn apply_all(&mut self, changes: &mut TexturesDelta) {
        self.set(changes);
        self.free(changes);
    }

    fn set(&mut self, changes: &mut TexturesDelta) {
        for (id, deltas) in changes.set.drain() {
            deltas.iter().for_each(|delta| self.apply(id, delta));
        }
    }

    fn free(&mut self, changes: &mut TexturesDelta) {
        for id in changes.free.drain() {
            self.0.remove(&id);
        }
    }

    fn apply(&mut self, id: TextureId, delta: &ImageDelta) {
        let Some([x, y]) = delta.pos else {
            self.0.insert(id, delta.clone());
            return;
        };
        let Some(ImageDelta { image: ImageData::Color(whole), .. }) = self.0.get_mut(&id) else { return };
        let ImageData::Color(patch) = &delta.image;
        let whole = Arc::make_mut(whole);
        let [width, height] = patch.size;
        for row in 0..height {
            let (to, from) = ((y + row) * whole.size[0] + x, row * width);
            whole.pixels[to..to + width].copy_from_slice(&patch.pixels[from..from + width]);
        }
    }
}

/// Failure to draw a frame.
#[derive(Debug)]
pub(super) enum PaintError {
    /// The surface or device is lost; a new painter is needed.
    Lost(String),
}

/// Backend that draws the window itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Drawing {
    /// A hardware GPU if there is one, otherwise the CPU
    #[default]
    Auto,
    Gpu,
    Cpu,
}

pub(super) struct Painter {
    kind: Kind,
    /// Name of the adapter, for messages.
    pub(super) adapter: String,
}

enum Kind {
    Gpu(Box<GpuPainter>),
    Software(SoftwarePainter),
}

/// Largest side of a texture in memory, pixels: larger than any picture.
const MAX_SIDE: usize = 1 << 15;

impl Painter {
    /// Creates a painter for the window.
    pub(super) fn new(
        drawing: Drawing,
        window: &Arc<Window>,
        display: OwnedDisplayHandle,
        textures: &Textures,
    ) -> Result<Self, String> {
        let software = |display| {
            let kind = Kind::Software(SoftwarePainter::new(window, display)?);
            Ok::<_, String>(Self { kind, adapter: "CPU".to_owned() })
        };
        let gpu = |display, accept_software| {
            let (painter, adapter) = GpuPainter::new(window, display, textures, accept_software)?;
            Ok::<_, OpenError>(Self { kind: Kind::Gpu(Box::new(painter)), adapter })
        };
        match drawing {
            Drawing::Cpu => software(display),
            Drawing::Gpu => gpu(display, true).map_err(|OpenError(why)| why),
            Drawing::Auto => match gpu(display.clone(), false) {
                Ok(painter) => Ok(painter),
                Err(OpenError(why)) => software(display.clone()).or_else(|_| gpu(display, true).map_err(|_| why)),
            },
        }
    }

    /// Largest side of a texture, pixels.
    pub(super) fn max_texture_side(&self) -> usize {
        match &self.kind {
            Kind::Gpu(painter) => painter.max_texture_side(),
            Kind::Software(_) => MAX_SIDE,
        }
    }

    /// Destroys the device as a driver restart would; used to test recovery.
    pub(super) fn lose_device(&self) {
        match &self.kind {
            Kind::Gpu(painter) => painter.lose_device(),
            Kind::Software(_) => {}
        }
    }

    /// Draws a frame at the size of the window. Texture updates are applied in any case.
    pub(super) fn paint(
        &mut self,
        window: &Window,
        primitives: &[ClippedPrimitive],
        mut changes: TexturesDelta,
        pixels_per_point: f32,
        kept: &mut Textures,
    ) -> Result<(), PaintError> {
        match &mut self.kind {
            Kind::Gpu(painter) => painter.paint(window, primitives, changes, pixels_per_point, kept),
            Kind::Software(painter) => {
                kept.set(&mut changes);
                let result = painter.paint(window, primitives, pixels_per_point, kept);
                kept.free(&mut changes);
                result
            }
        }
    }
}
