//! Draws egui's shapes into the window: on a graphics adapter ([`gpu`]), or on the processor ([`software`]) where there is
//! none, or one that is software and therefore slower than that.
//!
//! Nothing is shared with the renderer: a scene that takes long to compile or to trace does not hold up the window, and a
//! device that is lost takes only its own half with it. What egui has handed over of textures is kept, so that a new
//! painter can take over from one that was lost.

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
    /// Takes changes on that nobody paints.
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

/// Why nothing was drawn.
#[derive(Debug)]
pub(super) enum PaintError {
    /// A new painter is needed.
    Lost(String),
}

/// What the window is drawn on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Drawing {
    /// A graphics adapter where there is one that is not software, otherwise the processor
    #[default]
    Auto,
    Gpu,
    Cpu,
}

pub(super) struct Painter {
    kind: Kind,
    /// What it draws on, for people.
    pub(super) adapter: String,
}

enum Kind {
    Gpu(Box<GpuPainter>),
    Software(SoftwarePainter),
}

/// The largest side of a texture that is drawn from memory: more than any picture has.
const MAX_SIDE: usize = 1 << 15;

impl Painter {
    /// A painter for the window, or why there can be none.
    pub(super) fn new(
        drawing: Drawing,
        window: &Arc<Window>,
        display: OwnedDisplayHandle,
        textures: &Textures,
    ) -> Result<Self, String> {
        let software = |display| {
            let kind = Kind::Software(SoftwarePainter::new(window, display)?);
            Ok::<_, String>(Self { kind, adapter: "the processor".to_owned() })
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

    /// The largest side of a texture.
    pub(super) fn max_texture_side(&self) -> usize {
        match &self.kind {
            Kind::Gpu(painter) => painter.max_texture_side(),
            Kind::Software(_) => MAX_SIDE,
        }
    }

    /// Loses the device, as happens when a driver is restarted: to try what comes then.
    pub(super) fn lose_device(&self) {
        match &self.kind {
            Kind::Gpu(painter) => painter.lose_device(),
            Kind::Software(_) => {}
        }
    }

    /// Draws a frame of the size of the window. Textures are taken on whatever happens.
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
