//! Worker that traces samples on the CPU.

use crate::view::View;
use pathmarch_render::parts::Rect;
use pathmarch_render::pathmarch_scene::{Document, Moment};
use pathmarch_render::{Mode, TileTracer};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use wasm_bindgen::prelude::*;

/// Tracer of rectangles of samples.
#[wasm_bindgen]
pub struct Tracer {
    /// Text of the scene; it keeps pictures and meshes from one text to the next.
    document: Document,
    /// Tracers of the path-traced picture and of the preview, of the present text.
    tiles: HashMap<Mode, TileTracer>,
    /// Mode of the latest view.
    mode: Mode,
}

#[wasm_bindgen]
impl Tracer {
    /// Tracer of a text, which came from `name`.
    #[wasm_bindgen(constructor)]
    pub fn new(name: &str, text: &str) -> Self {
        Self { document: Document::new(name, text), tiles: HashMap::new(), mode: Mode::Path }
    }

    /// Replaces the text, and sets the moment in seconds.
    pub fn set_text(&mut self, text: String, seconds: f64) {
        self.tiles.clear();
        self.document.replace_text(text, "", None);
        let fps = self.document.last_good().map_or(24.0, |scene| scene.render.fps);
        self.document.set_moment(Moment::of_seconds(seconds, fps));
    }

    /// Sets camera, size and mode from JSON.
    ///
    /// # Errors
    /// If the text has mistakes, of which the editor has a list, or settings are out of range.
    pub fn set_view(&mut self, json: &str) -> Result<(), JsError> {
        let scene = self.document.scene().map_err(|error| JsError::new(&error.to_string()))?;
        let settings = serde_json::from_str::<View>(json)?.settings(scene)?;
        self.mode = settings.mode;
        match self.tiles.entry(settings.mode) {
            Entry::Occupied(mut tiles) => tiles.get_mut().set_settings(settings)?,
            Entry::Vacant(place) => drop(place.insert(TileTracer::new(scene.clone(), settings)?)),
        }
        Ok(())
    }

    /// Sums of radiance of `samples` samples from index `first` on, of some rows of the picture: red, green and blue of each
    /// pixel.
    ///
    /// # Errors
    /// If there is no view, or there are no such rows.
    pub fn trace(&self, first_row: u32, rows: u32, first: u32, samples: u32) -> Result<Vec<f32>, JsError> {
        let tiles = self.tiles.get(&self.mode).ok_or_else(|| JsError::new("set a view first"))?;
        let rect = Rect { x: 0, y: first_row, width: tiles.settings().size[0], height: rows };
        let film = tiles.trace(rect, first, samples)?;
        Ok(film.sums.into_flattened())
    }
}
