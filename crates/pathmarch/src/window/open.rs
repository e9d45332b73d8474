//! The scene that is open: its text, its file, and how it is looked at.

use super::app::Waker;
use super::timeline::Timeline;
use super::watch::Watch;
use egui::TextureHandle;
use pathmarch_render::Mode;
use pathmarch_render::pathmarch_scene::document::{Document, Path as NodePath};
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A live picture has at most this many pixels: those of a screen of 3840 by 2160.
const MOST_PIXELS: f64 = 3840.0 * 2160.0;
/// The most included files that are followed: each has a thread.
const MOST_PARTS: usize = 32;
/// For so long after the last movement the picture counts as moving.
const STILL_AFTER: Duration = Duration::from_millis(160);

/// A scene, its file, and how it is looked at.
pub(super) struct Open {
    pub(super) document: Document,
    /// Its file; none before it is saved for the first time.
    pub(super) path: Option<PathBuf>,
    /// The version of the file that the document is based on: what the file held when it was last read or written, or when
    /// somebody decided between it and the document. None where it is not known or there is no file.
    disk: Option<String>,
    watch: Option<Watch>,
    /// The files that the scene includes.
    parts: Vec<(PathBuf, Watch)>,
    /// The other version, where someone else has changed the file while there were unsaved changes here: what the file
    /// holds now, or why it cannot be read.
    pub(super) conflict: Option<Result<String, String>>,
    pub(super) view: View,
    pub(super) timeline: Timeline,
    /// Nodes whose children the tree does not show.
    pub(super) folded: Vec<NodePath>,
}

/// What became of a change of the file.
pub(super) enum Reload {
    /// The document is now what the file says.
    Taken,
    /// Both have changed: somebody must decide.
    Conflict,
    /// Both are the same now: nothing is unsaved, and there is nothing to decide.
    Same,
    /// The file can no longer be read, and why.
    Unreadable(String),
}

impl Open {
    /// A scene of this text. `name` says where pictures of the sky are looked for; `path` is its file, where it has one.
    pub(super) fn new(name: &str, text: String, path: Option<PathBuf>) -> Self {
        let disk = path.is_some().then(|| text.clone());
        let document = Document::new(name, text);
        let mut view = View::default();
        if let Some(scene) = document.last_good() {
            view.follow(scene);
        }
        Self {
            document,
            path,
            disk,
            watch: None,
            parts: Vec::new(),
            conflict: None,
            view,
            timeline: Timeline::default(),
            folded: Vec::new(),
        }
    }

    /// Work that was not saved when the program ended, as unsaved changes of its file. `theirs` is what the file holds now,
    /// or why it cannot be read; unless the work `is_based_on` that, somebody must decide between the two.
    pub(super) fn recovered(path: PathBuf, work: String, theirs: Result<String, String>, is_based_on: bool) -> Self {
        let name = path.display().to_string();
        let mut this = Self::new(&name, theirs.clone().unwrap_or_default(), Some(path));
        let is_same = theirs.as_ref() == Ok(&work);
        this.document.replace_text(work, "Recovery", None);
        if !is_based_on && !is_same {
            // Which version the work is based on is not known, and stays so until somebody decides.
            (this.disk, this.conflict) = (None, Some(theirs));
        }
        this
    }

    /// Notes that the file holds something that nobody here has seen; returns whether somebody must decide. To be asked
    /// before the file is replaced.
    pub(super) fn is_overtaken(&mut self, now: &str) -> bool {
        let known = self.disk.as_deref() == Some(now) || now == self.document.text();
        if !known {
            self.conflict = Some(Ok(now.to_owned()));
        }
        !known
    }

    /// Follows changes of the file by others.
    pub(super) fn watch(&mut self, waker: &Waker) {
        let waker = waker.clone();
        self.watch = self.path.as_deref().map(|path| Watch::new(path, move || waker()));
        self.tell_watch();
    }

    /// What was read or written here is no change by others.
    fn tell_watch(&mut self) {
        if let (Some(watch), Some(disk)) = (&mut self.watch, &self.disk) {
            watch.known(disk);
        }
    }

    /// What the title says.
    pub(super) fn name(&self) -> String {
        let name = self.path.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        name.unwrap_or_else(|| "unsaved scene".to_owned())
    }

    /// Whether something would be lost with it.
    pub(super) fn has_unsaved_work(&self) -> bool {
        !self.document.is_saved()
    }

    /// What the file held when it was last read or written.
    pub(super) fn disk(&self) -> Option<&str> {
        self.disk.as_deref()
    }

    /// Takes on what became of the file, if anything did.
    pub(super) fn reload(&mut self) -> Option<Reload> {
        let text = match self.watch.as_mut()?.changed()? {
            Ok(text) => text,
            Err(why) => return Some(Reload::Unreadable(why)),
        };
        if self.disk.as_deref() == Some(text.as_str()) && self.conflict.is_none() {
            return None;
        }
        if text == self.document.text() {
            // The same change on both sides.
            (self.disk, self.conflict) = (Some(text), None);
            self.document.mark_saved();
            return Some(Reload::Same);
        }
        if self.has_unsaved_work() {
            self.conflict = Some(Ok(text));
            return Some(Reload::Conflict);
        }
        self.take_from_disk(text);
        Some(Reload::Taken)
    }

    /// Follows the files that the scene includes, and reads them again where one has changed; says whether one has.
    pub(super) fn follow_parts(&mut self, waker: &Waker) -> bool {
        let includes = match (self.document.last_good(), &self.path) {
            (Some(scene), Some(_)) => &scene.includes[..],
            _ => &[],
        };
        let includes = &includes[..includes.len().min(MOST_PARTS)];
        if !self.parts.iter().map(|(path, _)| path).eq(includes) {
            let watched = |path: &PathBuf| {
                let waker = waker.clone();
                (path.clone(), Watch::new(path, move || waker()))
            };
            self.parts = includes.iter().map(watched).collect();
        }
        let news: Vec<_> = self.parts.iter_mut().filter_map(|(_, watch)| watch.changed()).collect();
        if !news.is_empty() {
            // One that can no longer be read is told as a mistake of the scene.
            self.document.refresh();
        }
        !news.is_empty()
    }

    /// Makes the document what the file says. What was here can be had again by undoing.
    pub(super) fn take_from_disk(&mut self, text: String) {
        self.document.replace_text(text.clone(), "Change of the file", None);
        self.document.mark_saved();
        (self.disk, self.conflict) = (Some(text), None);
    }

    /// Keeps what is here; the file stays as it is until the next save.
    pub(super) fn keep_mine(&mut self) {
        if let Some(theirs) = self.conflict.take() {
            self.disk = theirs.ok();
        }
    }

    /// The document has been written to this file.
    pub(super) fn saved(&mut self, path: &Path) -> bool {
        self.disk = Some(self.document.text().to_owned());
        self.conflict = None;
        let moved = self.path.as_deref() != Some(path);
        if moved {
            self.path = Some(path.to_owned());
            self.document.set_name(path.display().to_string());
        }
        self.document.mark_saved();
        self.tell_watch();
        moved
    }
}

/// Which handles the picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handles {
    Move,
    Turn,
    Scale,
}

/// How large the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Resolution {
    /// As large as there is room.
    Fit,
    /// Half of that.
    Half,
    /// As the scene says.
    Scene,
}

impl Resolution {
    pub(super) const ALL: [Self; 3] = [Self::Fit, Self::Half, Self::Scene];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Fit => "Fit the window",
            Self::Half => "Half of it",
            Self::Scene => "As rendered",
        }
    }
}

/// A picture that was kept to compare others with.
pub(super) struct Kept {
    pub(super) texture: TextureHandle,
    pub(super) label: String,
    /// Where the line stands, 0 to 1 from the left.
    pub(super) split: f32,
    pub(super) shown: bool,
}

/// How a scene is looked at.
pub(super) struct View {
    /// Where it is seen from: at first as the scene says.
    pub(super) camera: Camera,
    /// The scene's camera that it comes from, as it was then.
    followed: Option<Camera>,
    pub(super) selection: Option<NodePath>,
    pub(super) mode: Mode,
    pub(super) resolution: Resolution,
    pub(super) handles: Handles,
    /// The next click sets the focus.
    pub(super) focus_click: bool,
    pub(super) kept: Option<Kept>,
    /// When something last moved.
    moved: Option<Instant>,
    /// Pixels that there are for the picture.
    pub(super) room: [u32; 2],
    /// The picture on the screen, its number and size.
    pub(super) picture: Option<(TextureHandle, u64, [u32; 2])>,
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
    pub(super) fn follow(&mut self, scene: &Scene) {
        let name = self.followed.as_ref().map(|followed| followed.name.as_str());
        let camera = scene.cameras.iter().find(|camera| Some(camera.name.as_str()) == name);
        let camera = camera.unwrap_or(&scene.cameras[0]);
        if self.followed.as_ref() != Some(camera) {
            self.look_through(camera);
        }
    }

    /// Looks through a camera of the scene.
    pub(super) fn look_through(&mut self, camera: &Camera) {
        self.camera = camera.clone();
        self.followed = Some(camera.clone());
        self.touch();
    }

    /// Whether it is not where the scene's camera is.
    pub(super) fn has_moved_away(&self) -> bool {
        self.followed.as_ref().is_some_and(|followed| *followed != self.camera)
    }

    /// The name of the scene's camera that it comes from.
    pub(super) fn camera_name(&self) -> &str {
        self.followed.as_ref().map_or("main", |followed| &followed.name)
    }

    /// Says that the camera is now as the scene has it.
    pub(super) fn written(&mut self, camera: &Camera) {
        self.followed = Some(camera.clone());
        self.camera = camera.clone();
    }

    /// Something moves.
    pub(super) fn touch(&mut self) {
        self.moved = Some(Instant::now());
    }

    /// Whether something moves, and if so for how long it still counts as moving.
    pub(super) fn moving(&mut self) -> Option<Duration> {
        let left = STILL_AFTER.checked_sub(self.moved?.elapsed());
        if left.is_none() {
            self.moved = None;
        }
        left
    }

    /// The size of the picture, pixels.
    pub(super) fn size(&self, scene: &Scene) -> [u32; 2] {
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
