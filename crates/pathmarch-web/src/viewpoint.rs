//! Camera that the page moves.

use glam::Vec3;
use pathmarch_render::pathmarch_scene::{Camera, navigation};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

/// Camera, as JSON has it.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct CameraRecord {
    name: String,
    position: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov: f32,
    lens_radius: f32,
    focus: Option<f32>,
    exposure: f32,
    #[serde(default)]
    auto_exposure: bool,
}

impl From<&Camera> for CameraRecord {
    fn from(camera: &Camera) -> Self {
        let Camera { name, position, target, up, fov, lens_radius, focus, exposure, auto_exposure } = camera.clone();
        Self { name, position, target, up, fov, lens_radius, focus, exposure, auto_exposure }
    }
}

impl From<CameraRecord> for Camera {
    fn from(record: CameraRecord) -> Self {
        let CameraRecord { name, position, target, up, fov, lens_radius, focus, exposure, auto_exposure } = record;
        Self { name, position, target, up, fov, lens_radius, focus, exposure, auto_exposure }
    }
}

/// Camera that is moved by hand.
#[wasm_bindgen]
pub struct Viewpoint {
    camera: Camera,
}

#[wasm_bindgen]
impl Viewpoint {
    /// Camera from JSON, as the editor gives it.
    ///
    /// # Errors
    /// If it is not that.
    #[wasm_bindgen(constructor)]
    pub fn new(json: &str) -> Result<Self, JsError> {
        let record: CameraRecord = serde_json::from_str(json)?;
        Ok(Self { camera: record.into() })
    }

    /// The camera as JSON.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn json(&self) -> Result<String, JsError> {
        Ok(serde_json::to_string(&CameraRecord::from(&self.camera))?)
    }

    /// Orbits about the target by radians left and up.
    pub fn orbit(&mut self, yaw: f32, pitch: f32) {
        navigation::orbit(&mut self.camera, yaw, pitch);
    }

    /// Turns the view by radians left and up.
    pub fn look(&mut self, yaw: f32, pitch: f32) {
        navigation::look(&mut self.camera, yaw, pitch);
    }

    /// Pans by a fraction of the picture's height.
    pub fn pan(&mut self, x: f32, y: f32) {
        navigation::pan(&mut self.camera, x, y);
    }

    /// Scales the distance to the target.
    pub fn dolly(&mut self, factor: f32) {
        navigation::dolly(&mut self.camera, factor);
    }

    /// Flies for some seconds; each direction is -1 to 1. The distance to the target sets the speed.
    pub fn fly(&mut self, right: f32, up: f32, forward: f32, seconds: f32) {
        let away = Vec3::from(self.camera.position).distance(Vec3::from(self.camera.target));
        navigation::fly(&mut self.camera, Vec3::new(right, up, forward), seconds, away);
    }

    /// Vertical field of view, radians.
    pub fn field_of_view(&self) -> f32 {
        self.camera.fov.to_radians()
    }
}
