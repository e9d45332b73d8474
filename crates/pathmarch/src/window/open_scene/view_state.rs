//! View of the open scene: camera, selection, mode and resolution.

use super::selection::Selection;
use egui::TextureHandle;
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use pathmarch_render::{Mode, PreviewSteps};
use std::time::{Duration, Instant};

/// Maximum number of pixels of the live picture: those of a 3840 x 2160 screen.
const MAX_PIXELS: f64 = 3840.0 * 2160.0;

/// Time after the last movement until the view counts as still.
const STILL_AFTER: Duration = Duration::from_millis(160);

/// Tool of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GizmoMode {
    Move,
    Rotate,
    Scale,
}

/// Resolution of the live picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resolution {
    /// Fit to the viewport.
    Fit,
    /// Half of `Fit` on each side.
    Half,
    /// Size given by the scene.
    Scene,
}

impl Resolution {
    pub(crate) const ALL: [Self; 3] = [Self::Fit, Self::Half, Self::Scene];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fit => "Fit window",
            Self::Half => "Half size",
            Self::Scene => "Scene size",
        }
    }
}

/// A stored picture for comparison.
pub(crate) struct ComparisonPicture {
    pub(crate) texture: TextureHandle,
    pub(crate) label: String,
    /// Position of the dividing line, 0 (left) to 1 (right).
    pub(crate) split: f32,
    pub(crate) shown: bool,
}

/// View of a scene.
pub(crate) struct ViewState {
    /// Current camera; starts as the scene's.
    pub(crate) camera: Camera,
    /// The scene's camera that the view started from, as it was then.
    scene_camera: Option<Camera>,
    pub(crate) selection: Selection,
    pub(crate) mode: Mode,
    /// Steps of the mode "preview".
    pub(crate) preview_steps: PreviewSteps,
    pub(crate) resolution: Resolution,
    pub(crate) gizmo_mode: GizmoMode,
    /// The next click sets the focus distance.
    pub(crate) focus_click: bool,
    pub(crate) comparison: Option<ComparisonPicture>,
    /// Time of the last movement.
    last_moved: Option<Instant>,
    /// Size that the picture has to fit into, pixels: that of the viewport, or larger.
    pub(crate) available_pixels: [u32; 2],
    /// Size of the window for which that was set, pixels.
    window_pixels: [u32; 2],
    /// The displayed picture: texture, serial number, size in pixels.
    pub(crate) picture: Option<(TextureHandle, u64, [u32; 2])>,
}

impl Default for ViewState {
    fn default() -> Self {
        let camera = Camera {
            name: "main".to_owned(),
            position: [0.0, 1.5, 6.0],
            target: [0.0, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            fov: 40.0,
            lens_radius: 0.0,
            focus: None,
            exposure: 0.0,
            auto_exposure: false,
        };
        Self {
            camera,
            scene_camera: None,
            selection: Selection::default(),
            mode: Mode::Path,
            preview_steps: PreviewSteps::default(),
            resolution: Resolution::Fit,
            gizmo_mode: GizmoMode::Move,
            focus_click: false,
            comparison: None,
            last_moved: None,
            available_pixels: [0; 2],
            window_pixels: [0; 2],
            picture: None,
        }
    }
}

impl ViewState {
    /// Adopts changes of the scene's camera. Otherwise the user's own camera movement is kept.
    pub(crate) fn sync_camera(&mut self, scene: &Scene) {
        let name = self.scene_camera.as_ref().map(|scene_camera| scene_camera.name.as_str());
        let camera = scene.cameras.iter().find(|camera| Some(camera.name.as_str()) == name);
        let camera = camera.unwrap_or(&scene.cameras[0]);
        if self.scene_camera.as_ref() != Some(camera) {
            self.use_camera(camera);
        }
    }

    /// Switches to a camera of the scene.
    pub(crate) fn use_camera(&mut self, camera: &Camera) {
        self.camera = camera.clone();
        self.scene_camera = Some(camera.clone());
        self.mark_moving();
    }

    /// Returns true if the view differs from the scene's camera.
    pub(crate) fn is_camera_modified(&self) -> bool {
        self.scene_camera.as_ref().is_some_and(|scene_camera| *scene_camera != self.camera)
    }

    /// Name of the scene's camera that the view started from.
    pub(crate) fn camera_name(&self) -> &str {
        self.scene_camera.as_ref().map_or("main", |scene_camera| &scene_camera.name)
    }

    /// Records that the view was written to the scene's camera.
    pub(crate) fn set_scene_camera(&mut self, camera: &Camera) {
        self.scene_camera = Some(camera.clone());
        self.camera = camera.clone();
    }

    /// Marks the view as moving.
    pub(crate) fn mark_moving(&mut self) {
        self.last_moved = Some(Instant::now());
    }

    /// Time until the view counts as still; `None` if it does already.
    pub(crate) fn time_until_still(&mut self) -> Option<Duration> {
        let left = STILL_AFTER.checked_sub(self.last_moved?.elapsed());
        if left.is_none() {
            self.last_moved = None;
        }
        left
    }

    /// Adapts to the size of the viewport. A viewport that becomes smaller because a panel has opened shows the picture
    /// smaller; the picture itself stays and goes on accumulating samples.
    pub(crate) fn set_available(&mut self, viewport: [u32; 2], window: [u32; 2]) {
        let known = self.available_pixels;
        let fits = (0..2).all(|axis| viewport[axis] <= known[axis] && viewport[axis] * 3 >= known[axis]);
        if !(fits && window == self.window_pixels) {
            (self.available_pixels, self.window_pixels) = (viewport, window);
        }
    }

    /// Size of the live picture, pixels.
    pub(crate) fn picture_size(&self, scene: &Scene) -> [u32; 2] {
        let (width, height) = scene.render.size;
        let [available_x, available_y] = self.available_pixels.map(|side| f64::from(side.max(1)));
        let fit = (available_x / f64::from(width)).min(available_y / f64::from(height));
        let factor = match self.resolution {
            Resolution::Fit => fit,
            Resolution::Half => 0.5 * fit,
            Resolution::Scene => 1.0,
        };
        // Higher resolutions are for final renders.
        let most = (MAX_PIXELS / (f64::from(width) * f64::from(height))).sqrt();
        let factor = factor.min(most);
        [width, height].map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, 16_384))
    }
}
