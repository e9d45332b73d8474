//! Opening, saving, and what comes first when unsaved work stands in the way.

use super::app::App;
use super::chooser::{Choice, Chooser, Purpose};
use super::dialogs::Dialog;
use super::open::Open;
use super::panels::Plots;
use super::saving::write_atomically;
use egui::Context;
use pathmarch_render::pathmarch_scene::SceneError;
use pathmarch_render::pathmarch_scene::read_text;
use std::path::{Path, PathBuf};

/// A ball on a floor: what a new scene is.
const NEW_SCENE: &str = r#"pathmarch 1

camera "main" {
    position 0 1.2 4.5
    target 0 0.6 0
    fov 40
}
render { size 1280 720; samples 256; bounces 4 }
sky "day" elevation=35 azimuth=140

material "red" { principled 0.8 0.12 0.08; roughness 0.3 }
material "grey" { diffuse 0.5 }

object "ball" material="red" { sphere 0.7 { at 0 0.7 0 } }
object "floor" material="grey" { plane }
"#;

/// What a file is chosen for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum For {
    Open,
    SaveAs,
    /// The scene is to be saved, and then this done.
    SaveThen(After),
    /// The picture as it is shown.
    Picture,
    /// The output of the render dialog.
    Render,
}

/// What was asked for when unsaved work stood in its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum After {
    Leave,
    New,
    Open,
    /// This file, of the recent ones or dragged into the window.
    OpenFile(PathBuf),
    Gallery,
    /// The scene of the gallery.
    Example(usize),
}

/// What a file is chosen for.
pub(super) fn purpose(title: &str, extensions: &[&'static str]) -> Purpose {
    Purpose { title: title.to_owned(), extensions: extensions.to_vec() }
}

/// Why a file cannot be read, as a part of a sentence.
pub(super) fn reason(error: &SceneError) -> String {
    match error {
        SceneError::Unreadable { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}

impl App {
    /// Does it, or asks first what is to become of unsaved work.
    pub(super) fn unless_unsaved(&mut self, after: After) {
        if self.open.as_ref().is_some_and(Open::has_unsaved_work) {
            self.dialog = Some(Dialog::Unsaved(after));
        } else {
            self.proceed(after);
        }
    }

    pub(super) fn proceed(&mut self, after: After) {
        match after {
            After::Leave => self.end(),
            After::New => self.show_scene(Open::new("scene.kdl", NEW_SCENE.to_owned(), None)),
            After::Open => {
                let purpose = purpose("Open a scene", &["kdl"]);
                self.chooser = Some((self.with_places(Chooser::open(&self.directory(), purpose)), For::Open));
            }
            After::Gallery => {
                self.recovery.clear();
                self.open = None;
            }
            After::Example(index) => {
                if let Some((name, text)) = self.gallery.scene(index) {
                    self.show_scene(Open::new(&name, text, None));
                }
            }
            After::OpenFile(path) => self.open_file(&path),
        }
    }

    /// Where files are looked for first.
    pub(super) fn directory(&self) -> PathBuf {
        let of = |path: &Path| path.parent().filter(|parent| parent.is_dir()).map(Path::to_owned);
        let open = self.open.as_ref().and_then(|open| of(open.path.as_deref()?));
        let recent = || self.preferences.recent.first().and_then(|path| of(path));
        open.or_else(recent).or_else(|| std::env::current_dir().ok()).unwrap_or_else(|| PathBuf::from("."))
    }

    /// A chooser that offers the folders of what was open before.
    pub(super) fn with_places(&self, chooser: Chooser) -> Chooser {
        let folder = self.open.as_ref().and_then(|open| open.path.as_deref()?.parent());
        chooser.with_places(folder, &self.preferences.recent)
    }

    /// Opens a scene file; says why where it cannot be read.
    pub(super) fn open_file(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        match read_text(&path) {
            Ok(text) => {
                self.preferences.opened(&path);
                let mut open = Open::new(&path.display().to_string(), text, Some(path));
                open.watch(&self.waker);
                self.show_scene(open);
            }
            Err(error) => {
                if !path.exists() {
                    self.preferences.forget(&path);
                }
                let why = match &error {
                    SceneError::Unreadable { help, .. } => format!("{}. {help}", reason(&error)),
                    other => other.to_string(),
                };
                self.complain(&format!("{} cannot be opened: {why}", path.display()));
            }
        }
    }

    pub(super) fn show_scene(&mut self, open: Open) {
        self.recovery.clear();
        self.open = Some(open);
        self.forget_picture();
        self.plots = Plots::default();
        self.milestone("scene read", "");
        if self.open.as_ref().is_some_and(Open::has_unsaved_work) {
            self.changed();
        }
    }

    /// Writes the scene to its file, or asks for one; says whether it is written.
    pub(super) fn save(&mut self, then: Option<After>) -> bool {
        let Some(path) = self.open.as_ref().and_then(|open| open.path.clone()) else {
            self.choose_save(then.map_or(For::SaveAs, For::SaveThen));
            return false;
        };
        // What another program has just written is not replaced unseen, even where the watch has not reported it yet.
        let now = read_text(&path).ok();
        if self.open.as_mut().zip(now).is_some_and(|(open, now)| open.is_overtaken(&now)) {
            self.dialog = Some(Dialog::Conflict);
            return false;
        }
        self.save_to(&path)
    }

    fn save_to(&mut self, path: &Path) -> bool {
        let Some(open) = &mut self.open else { return false };
        if let Err(error) = write_atomically(path, open.document.text().as_bytes()) {
            self.complain(&format!("Not saved: {error} The scene is still here, and kept for recovery."));
            self.recovery.flush();
            return false;
        }
        let mut path = path.to_owned();
        if let Ok(absolute) = std::path::absolute(&path) {
            path = absolute;
        }
        if open.saved(&path) {
            open.watch(&self.waker);
        }
        self.preferences.opened(&path);
        self.recovery.clear();
        self.say(&format!("Saved {}.", path.display()));
        true
    }

    pub(super) fn choose_save(&mut self, what: For) {
        let name = self.open.as_ref().and_then(|open| open.path.clone());
        let name = name.as_deref().and_then(Path::file_name).map_or("scene.kdl".into(), |name| name.to_string_lossy());
        let purpose = purpose("Save the scene", &["kdl"]);
        self.chooser = Some((self.with_places(Chooser::save(&self.directory(), &name, purpose)), what));
    }

    pub(super) fn choose_picture(&mut self) {
        let purpose = purpose("Save the picture as it is shown", &["png", "exr", "jpg"]);
        let name = self.picture_name();
        self.chooser = Some((self.with_places(Chooser::save(&self.directory(), &name, purpose)), For::Picture));
    }

    /// What a picture of the open scene is called.
    pub(super) fn picture_name(&self) -> String {
        let stem = self.open.as_ref().and_then(|open| open.path.as_deref()?.file_stem().map(|stem| stem.to_owned()));
        format!("{}.png", stem.map_or("picture".into(), |stem| stem.to_string_lossy().into_owned()))
    }

    pub(super) fn choosing(&mut self, ctx: &Context) {
        let Some((chooser, _)) = &mut self.chooser else { return };
        let Some(choice) = chooser.show(ctx) else { return };
        let Some((_, what)) = self.chooser.take() else { return };
        let Choice::Chosen(path) = choice else {
            if self.open.as_ref().is_some_and(|open| open.conflict.is_some()) {
                // It was to be saved elsewhere, and now is not.
                self.dialog = Some(Dialog::Conflict);
            }
            return;
        };
        match what {
            For::Open => self.open_file(&path),
            For::SaveAs => drop(self.save_to(&path)),
            For::SaveThen(after) => {
                if self.save_to(&path) {
                    self.proceed(after);
                }
            }
            For::Picture => self.save_picture(&path),
            For::Render => {
                if let Some(Dialog::Render(dialog)) = &mut self.dialog {
                    dialog.output = path.display().to_string();
                }
            }
        }
    }

    pub(super) fn take_dropped(&mut self, ctx: &Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.unless_unsaved(After::OpenFile(path));
        }
    }
}
