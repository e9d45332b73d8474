//! View of the open scene: camera, selection, mode and size of the picture.

use egui::TextureHandle;
use pathmarch_render::Mode;
use pathmarch_render::pathmarch_scene::document::Path as NodePath;
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use std::time::{Duration, Instant};

/// A live picture has at most this many pixels: those of a screen of 3840 by 2160.
const MOST_PIXELS: f64 = 3840.0 * 2160.0;

/// For so long after the last movement the picture counts as moving.
const STILL_AFTER: Duration = Duration::from_millis(160);

/// Which handles the picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handles {
    Move,
    Turn,
    Scale,
}

/// How large the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resolution {
    /// As large as there is room.
    Fit,
    /// Half of that.
    Half,
    /// As the scene says.
    Scene,
}

impl Resolution {
    pub(crate) const ALL: [Self; 3] = [Self::Fit, Self::Half, Self::Scene];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fit => "Fit the window",
            Self::Half => "Half of it",
            Self::Scene => "As rendered",
        }
    }
}

/// A picture that was kept to compare others with.
pub(crate) struct Kept {
    pub(crate) texture: TextureHandle,
    pub(crate) label: String,
    /// Where the line stands, 0 to 1 from the left.
    pub(crate) split: f32,
    pub(crate) shown: bool,
}

/// How a scene is looked at.
pub(crate) struct View {
    /// Where it is seen from: at first as the scene says.
    pub(crate) camera: Camera,
    /// The scene's camera that it comes from, as it was then.
    followed: Option<Camera>,
    pub(crate) selection: Option<NodePath>,
    pub(crate) mode: Mode,
    pub(crate) resolution: Resolution,
    pub(crate) handles: Handles,
    /// The next click sets the focus.
    pub(crate) focus_click: bool,
    pub(crate) kept: Option<Kept>,
    /// When something last moved.
    moved: Option<Instant>,
    /// Pixels that there are for the picture.
    pub(crate) room: [u32; 2],
    /// The picture on the screen, its number and size.
    pub(crate) picture: Option<(TextureHandle, u64, [u32; 2])>,
}

impl Default for View {
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
        };
        Self {
            camera,
            followed: None,
            selection: None,
            mode: Mode::Path,
            resolution: Resolution::Fit,
            handles: Handles::Move,
            focus_click: false,
            kept: None,
            moved: None,
            room: [0; 2],
            picture: None,
        }
    }
}

impl View {
    /// Takes on changes of the scene's camera; one's own movements stay otherwise.
    pub(crate) fn follow(&mut self, scene: &Scene) {
        let name = self.followed.as_ref().map(|followed| followed.name.as_str());
        let camera = scene.cameras.iter().find(|camera| Some(camera.name.as_str()) == name);
        let camera = camera.unwrap_or(&scene.cameras[0]);
        if self.followed.as_ref() != Some(camera) {
            self.look_through(camera);
        }
    }

    /// Looks through a camera of the scene.
    pub(crate) fn look_through(&mut self, camera: &Camera) {
        self.camera = camera.clone();
        self.followed = Some(camera.clone());
        self.touch();
    }

    /// Whether it is not where the scene's camera is.
    pub(crate) fn has_moved_away(&self) -> bool {
        self.followed.as_ref().is_some_and(|followed| *followed != self.camera)
    }

    /// The name of the scene's camera that it comes from.
    pub(crate) fn camera_name(&self) -> &str {
        self.followed.as_ref().map_or("main", |followed| &followed.name)
    }

    /// Says that the camera is now as the scene has it.
    pub(crate) fn written(&mut self, camera: &Camera) {
        self.followed = Some(camera.clone());
        self.camera = camera.clone();
    }

    /// Something moves.
    pub(crate) fn touch(&mut self) {
        self.moved = Some(Instant::now());
    }

    /// Whether something moves, and if so for how long it still counts as moving.
    pub(crate) fn moving(&mut self) -> Option<Duration> {
        let left = STILL_AFTER.checked_sub(self.moved?.elapsed());
        if left.is_none() {
            self.moved = None;
        }
        left
    }

    /// The size of the picture, pixels.
    pub(crate) fn size(&self, scene: &Scene) -> [u32; 2] {
        let (width, height) = scene.render.size;
        let [room_x, room_y] = self.room.map(|side| f64::from(side.max(1)));
        let fit = (room_x / f64::from(width)).min(room_y / f64::from(height));
        let factor = match self.resolution {
            Resolution::Fit => fit,
            Resolution::Half => 0.5 * fit,
            Resolution::Scene => 1.0,
        };
        // More than a screen shows is for files.
        let most = (MOST_PIXELS / (f64::from(width) * f64::from(height))).sqrt();
        let factor = factor.min(most);
        [width, height].map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, 16_384))
    }
}
