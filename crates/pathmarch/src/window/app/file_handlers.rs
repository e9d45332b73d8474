//! File commands: open and save scenes, and confirm before unsaved work is lost.

use super::App;
use super::dialog::Dialog;
use super::performance::PerformanceHistory;
use super::requests::{FileRequest, PendingAction, file_dialog_options};
use crate::atomic_file::write_atomically;
use crate::commands::import::path_from;
use crate::window::file_dialog::{Choice, FileDialog};
use crate::window::open_scene::OpenScene;
use egui::Context;
use pathmarch_render::pathmarch_field::MESH_EXTENSIONS;
use pathmarch_render::pathmarch_scene::SceneError;
use pathmarch_render::pathmarch_scene::document::mesh_import::{ImportedNode, import_mesh, mesh_on_ground};
use pathmarch_render::pathmarch_scene::read_text;
use std::path::{Path, PathBuf};

/// Scene of the command *New*: a sphere on a floor.
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

/// Reason why a file cannot be read, as part of a sentence.
pub(crate) fn reason(error: &SceneError) -> String {
    match error {
        SceneError::Unreadable { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}

impl App {
    /// Runs the action; asks first if it would discard unsaved work.
    pub(crate) fn guard_unsaved(&mut self, after: PendingAction) {
        if self.open.as_ref().is_some_and(OpenScene::has_unsaved_work) {
            self.dialog = Some(Dialog::Unsaved(after));
        } else {
            self.run_pending(after);
        }
    }

    pub(crate) fn run_pending(&mut self, after: PendingAction) {
        match after {
            PendingAction::Quit => self.confirm_quit(),
            PendingAction::New => self.show_scene(OpenScene::new("scene.kdl", NEW_SCENE.to_owned(), None)),
            PendingAction::Open => {
                let options = file_dialog_options("Open a scene", &["kdl"]);
                self.file_dialog =
                    Some((self.with_bookmarks(FileDialog::open(&self.directory(), options)), FileRequest::Open));
            }
            PendingAction::Gallery => {
                self.recovery.clear();
                self.open = None;
            }
            PendingAction::Example(index) => {
                if let Some((name, text)) = self.gallery.scene(index) {
                    self.show_scene(OpenScene::new(&name, text, None));
                }
            }
            PendingAction::OpenFile(path) => self.open_file(&path),
        }
    }

    /// Directory where file dialogs start.
    pub(crate) fn directory(&self) -> PathBuf {
        let of = |path: &Path| path.parent().filter(|parent| parent.is_dir()).map(Path::to_owned);
        let open = self.open.as_ref().and_then(|open| of(open.path.as_deref()?));
        let recent = || self.preferences.recent.first().and_then(|path| of(path));
        open.or_else(recent).or_else(|| std::env::current_dir().ok()).unwrap_or_else(|| PathBuf::from("."))
    }

    /// Adds bookmarks for the directories of the scene and of recent files.
    pub(crate) fn with_bookmarks(&self, file_dialog: FileDialog) -> FileDialog {
        let folder = self.open.as_ref().and_then(|open| open.path.as_deref()?.parent());
        file_dialog.with_bookmarks(folder, &self.preferences.recent)
    }

    /// Opens a scene file, or shows why it cannot be read.
    pub(crate) fn open_file(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        match read_text(&path) {
            Ok(text) => {
                self.preferences.opened(&path);
                let mut open = OpenScene::of_file(path, text, self.options.allow_files);
                open.start_watching(&self.waker);
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
                self.show_error(&format!("{} cannot be opened: {why}", path.display()));
            }
        }
    }

    pub(crate) fn show_scene(&mut self, open: OpenScene) {
        self.recovery.clear();
        self.open = Some(open);
        self.discard_picture();
        self.performance = PerformanceHistory::default();
        self.log_milestone("scene read", "");
        if self.open.as_ref().is_some_and(OpenScene::has_unsaved_work) {
            self.document_changed();
        }
    }

    /// Saves the scene, or asks for a file name. Returns true if the scene was written.
    pub(crate) fn save(&mut self, then: Option<PendingAction>) -> bool {
        let Some(path) = self.open.as_ref().and_then(|open| open.path.clone()) else {
            self.choose_save_path(then.map_or(FileRequest::SaveAs, FileRequest::SaveThen));
            return false;
        };
        // Do not overwrite what another program has just written, even if the file watcher has not reported it yet.
        let now = read_text(&path).ok();
        if self.open.as_mut().zip(now).is_some_and(|(open, now)| open.is_newer_on_disk(&now)) {
            self.dialog = Some(Dialog::Conflict);
            return false;
        }
        self.save_to(&path)
    }

    fn save_to(&mut self, path: &Path) -> bool {
        let Some(open) = &mut self.open else { return false };
        if let Err(error) = write_atomically(path, open.document.text().as_bytes()) {
            self.show_error(&format!("Not saved: {error}. Your changes are still open, and in the recovery file."));
            self.recovery.flush();
            return false;
        }
        let mut path = path.to_owned();
        if let Ok(absolute) = std::path::absolute(&path) {
            path = absolute;
        }
        if open.mark_saved_to(&path) {
            open.start_watching(&self.waker);
        }
        self.preferences.opened(&path);
        self.recovery.clear();
        self.show_message(&format!("Saved {}.", path.display()));
        true
    }

    pub(crate) fn choose_save_path(&mut self, what: FileRequest) {
        let name = self.open.as_ref().and_then(|open| open.path.clone());
        let name = name.as_deref().and_then(Path::file_name).map_or("scene.kdl".into(), |name| name.to_string_lossy());
        let options = file_dialog_options("Save the scene", &["kdl"]);
        self.file_dialog = Some((self.with_bookmarks(FileDialog::save(&self.directory(), &name, options)), what));
    }

    pub(crate) fn choose_picture_path(&mut self) {
        let options = file_dialog_options("Save the displayed picture", &["png", "exr", "jpg"]);
        let name = self.picture_file_name();
        self.file_dialog =
            Some((self.with_bookmarks(FileDialog::save(&self.directory(), &name, options)), FileRequest::Picture));
    }

    /// Suggested file name for a picture of the open scene.
    pub(crate) fn picture_file_name(&self) -> String {
        let stem = self.open.as_ref().and_then(|open| open.path.as_deref()?.file_stem().map(|stem| stem.to_owned()));
        format!("{}.png", stem.map_or("picture".into(), |stem| stem.to_string_lossy().into_owned()))
    }

    pub(crate) fn show_file_dialog(&mut self, ctx: &Context) {
        let Some((file_dialog, _)) = &mut self.file_dialog else { return };
        let Some(choice) = file_dialog.show(ctx) else { return };
        let Some((_, what)) = self.file_dialog.take() else { return };
        let Choice::Chosen(path) = choice else {
            if self.open.as_ref().is_some_and(|open| open.conflict.is_some()) {
                // The user cancelled *Save mine as*: the conflict is still unresolved.
                self.dialog = Some(Dialog::Conflict);
            }
            return;
        };
        match what {
            FileRequest::Open => self.open_file(&path),
            FileRequest::SaveAs => drop(self.save_to(&path)),
            FileRequest::SaveThen(after) => {
                if self.save_to(&path) {
                    self.run_pending(after);
                }
            }
            FileRequest::Import => self.import_mesh(&path),
            FileRequest::Picture => self.save_picture(&path),
            FileRequest::Render => {
                if let Some(Dialog::Render(dialog)) = &mut self.dialog {
                    dialog.output = path.display().to_string();
                }
            }
        }
    }

    pub(crate) fn open_dropped_file(&mut self, ctx: &Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        let Some(path) = dropped else { return };
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let is_mesh = extension.is_some_and(|extension| MESH_EXTENSIONS.contains(&extension.as_str()));
        match is_mesh && self.open.is_some() {
            true => self.put_mesh_on_ground(&path),
            false => self.guard_unsaved(PendingAction::OpenFile(path)),
        }
    }

    /// Path of a mesh file as the open scene names it.
    fn path_in_scene(&self, file: &Path) -> String {
        let folder = self.open.as_ref().and_then(|open| open.path.as_deref()?.parent());
        match folder {
            Some(folder) => path_from(folder, file),
            None => std::path::absolute(file).unwrap_or_else(|_| file.to_owned()).to_string_lossy().into_owned(),
        }
    }

    /// Adds a mesh file as an object on the ground, and selects it.
    fn put_mesh_on_ground(&mut self, file: &Path) {
        match mesh_on_ground(file, &self.path_in_scene(file)) {
            Ok(node) => {
                let label = format!("Add {}", node.name.as_deref().unwrap_or("mesh"));
                self.add_imported(&label, &[node]);
            }
            Err(error) => self.show_error(&error.to_string()),
        }
    }

    /// Adds the objects, lights and cameras of a mesh file, and selects them.
    fn import_mesh(&mut self, file: &Path) {
        match import_mesh(file, &self.path_in_scene(file)) {
            Ok(import) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                self.add_imported(&format!("Import {name}"), &import.nodes);
                if let Some(first) = import.warnings.first() {
                    let others = import.warnings.len() - 1;
                    let others = if others > 0 { format!(" (and {others} more)") } else { String::new() };
                    self.show_message(&format!("Not all of {name} is imported: {first}{others}"));
                }
            }
            Err(error) => self.show_error(&error.to_string()),
        }
    }

    fn add_imported(&mut self, label: &str, nodes: &[ImportedNode]) {
        if let Some(paths) = self.edit(|open| open.document.add_imported(label, nodes)) {
            self.select_all(paths);
        }
    }
}
