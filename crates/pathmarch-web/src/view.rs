//! Camera, size and mode of a picture, as the page asks for it.

use crate::viewpoint::CameraRecord;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Mode, Settings};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// View of a scene.
#[derive(Deserialize)]
pub(crate) struct View {
    camera: CameraRecord,
    /// Width and height, pixels.
    size: [u32; 2],
    /// Name of a [`Mode`].
    mode: String,
}

impl View {
    /// Settings of the view.
    pub(crate) fn settings(self, scene: &Scene) -> Result<Settings, JsError> {
        let mode = Mode::from_name(&self.mode).ok_or_else(|| JsError::new(&format!("no mode `{}`", self.mode)))?;
        let viewpoint = Some(self.camera.into());
        Ok(Settings { size: self.size, mode, viewpoint, splitting: Some(1), ..Settings::of(scene) })
    }
}
