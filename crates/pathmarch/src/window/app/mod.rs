//! State of the application and its update for each frame, without window or graphics device: tests drive it as it is.

mod action_handlers;
pub(crate) mod actions;
pub(crate) mod dialog;
mod dialog_handlers;
mod edit_handlers;
mod file_handlers;
mod live_picture;
pub(crate) mod performance;
mod playback_handlers;
pub(crate) mod requests;
mod timings;
pub(crate) mod toasts;

use super::background_render::BackgroundRender;
use super::exposure::Histogram;
use super::file_dialog::FileDialog;
use super::files::preferences::Preferences;
use super::files::recovery::{Recovery, find_abandoned_work};
use super::gallery::Gallery;
use super::gizmo::GizmoState;
use super::material_balls::MaterialBalls;
use super::open_scene::{FileChange, OpenScene};
use super::source_editor::SourceEditor;
use super::waker::Waker;
use dialog::Dialog;
use egui::{Context, Ui};
use pathmarch_cli::AppDirs;
use pathmarch_render::Backend;
use pathmarch_render::live::{Live, RenderRequest};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::{EditError, Path as NodePath};
use pathmarch_render::reconstruct::ReconstructOptions;
use performance::PerformanceHistory;
use requests::{FileRequest, PendingAction};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use toasts::Toast;

/// Start-up options of the window.
#[derive(Clone, Debug)]
pub struct Options {
    /// Scene file to open; without one the window opens the gallery.
    pub scene: Option<PathBuf>,
    /// Backend that renders the scene.
    pub backend: Backend,
    /// Part of the GPU adapter's name.
    pub adapter: Option<String>,
    /// Allow scenes to read files outside their folder.
    pub allow_files: bool,
    /// Print timings to standard error.
    pub timings: bool,
}

/// The application: open scene, panels, dialogs and background work.
pub(crate) struct App {
    pub(crate) options: Options,
    pub(crate) waker: Waker,
    pub(crate) live: Live,
    pub(crate) open: Option<OpenScene>,
    pub(crate) gallery: Gallery,
    pub(crate) preferences: Preferences,
    /// Stages of reconstruction, and the buffer that is shown.
    pub(crate) reconstruct_options: ReconstructOptions,
    pub(crate) recovery: Recovery,
    recovery_dir: PathBuf,
    pub(crate) file_dialog: Option<(FileDialog, FileRequest)>,
    pub(crate) dialog: Option<Dialog>,
    pub(crate) renders: Vec<BackgroundRender>,
    pub(crate) toasts: Vec<Toast>,
    pub(crate) performance: PerformanceHistory,
    pub(crate) gizmo: GizmoState,
    /// Dragged nodes go to the surface under the pointer.
    pub(crate) snap_to_surfaces: bool,
    /// Control point whose menu is open.
    pub(crate) clicked_point: Option<(NodePath, usize)>,
    /// Scene without the node that is dragged onto surfaces, and that node.
    pub(crate) surroundings: Option<(NodePath, Option<Arc<Scene>>)>,
    pub(crate) source: SourceEditor,
    /// Histogram of the picture, while it is shown.
    pub(crate) histogram: Option<Histogram>,
    pub(crate) help: bool,
    /// The palette of materials is shown.
    pub(crate) palette: bool,
    pub(crate) material_balls: MaterialBalls,
    /// The picture fills the window.
    pub(crate) picture_only: bool,
    /// Undo group of the current interaction. Edits between two pointer presses, or by the keyboard in one widget, form
    /// one undo step.
    pub(crate) undo_group: u64,
    focus: Option<egui::Id>,
    /// Time of the last edit in the source editor, seconds.
    pub(crate) last_typed_at: f64,
    /// A text field had the keyboard focus at the end of the last frame.
    pub(crate) typing: bool,
    ordered: Option<RenderRequest>,
    /// Revision of the scene that was ordered.
    ordered_revision: u64,
    /// Number of the first order for the open scene. Pictures of earlier orders show another scene.
    first_order: Option<u64>,
    started: Instant,
    milestones: Vec<&'static str>,
    /// Times of the window's frames, milliseconds; recorded only with `--timings`.
    frame_times: Vec<f64>,
    quitting: bool,
    reset_window_device: bool,
}

impl App {
    pub(crate) fn new(ctx: &Context, options: Options, waker: Waker) -> Self {
        Self::with_dirs(ctx, options, waker, AppDirs::of_user())
    }

    /// Creates the application as [`Self::new`] does, with its own directories for preferences and recovery.
    pub(crate) fn with_dirs(ctx: &Context, options: Options, waker: Waker, dirs: Option<AppDirs>) -> Self {
        let started = Instant::now();
        let wake = waker.clone();
        let live = Live::new(options.backend, options.adapter.clone(), move || wake());
        let preferences =
            dirs.as_ref().map_or_else(Preferences::default, |dirs| Preferences::load_from(&dirs.preferences));
        let recovery_dir = dirs.map_or_else(|| std::env::temp_dir().join("pathmarch-recovery"), |dirs| dirs.recovery);
        let recovery = Recovery::new(&recovery_dir);
        ctx.set_theme(match preferences.dark {
            Some(true) => egui::ThemePreference::Dark,
            Some(false) => egui::ThemePreference::Light,
            None => egui::ThemePreference::System,
        });
        ctx.set_zoom_factor(preferences.scale);
        // A blinking cursor would redraw the window twice a second.
        ctx.all_styles_mut(|style| style.visuals.text_cursor.blink = false);
        let mut app = Self {
            live,
            open: None,
            gallery: Gallery::default(),
            preferences,
            reconstruct_options: ReconstructOptions::default(),
            recovery,
            recovery_dir: recovery_dir.clone(),
            file_dialog: None,
            dialog: None,
            renders: Vec::new(),
            toasts: Vec::new(),
            performance: PerformanceHistory::default(),
            gizmo: GizmoState::default(),
            snap_to_surfaces: false,
            clicked_point: None,
            surroundings: None,
            source: SourceEditor::default(),
            histogram: None,
            help: false,
            palette: false,
            material_balls: MaterialBalls::default(),
            picture_only: false,
            undo_group: 0,
            last_typed_at: 0.0,
            focus: None,
            typing: false,
            ordered: None,
            ordered_revision: 0,
            first_order: None,
            started,
            milestones: Vec::new(),
            frame_times: Vec::new(),
            quitting: false,
            reset_window_device: false,
            waker,
            options,
        };
        let left = find_abandoned_work(&recovery_dir);
        let wanted = app.options.scene.as_deref().map(|path| std::path::absolute(path).unwrap_or(path.to_owned()));
        if wanted.is_none() || left.iter().any(|one| one.scene_path == wanted) {
            app.dialog = (!left.is_empty()).then_some(Dialog::Recovered(left));
        } else if !left.is_empty() {
            // Work on another scene does not stand in the way of this one.
            app.show_message("There is unsaved work on another scene: File, Recover unsaved work.");
        }
        for problem in [app.recovery.problem(), app.preferences.notice().map(str::to_owned)].into_iter().flatten() {
            app.show_error(&problem);
        }
        if let Some(path) = app.options.scene.clone() {
            app.open_file(&path);
        }
        app
    }

    /// Title of the window.
    pub(crate) fn title(&self) -> String {
        match &self.open {
            Some(open) => {
                let changed = if open.has_unsaved_work() { "• " } else { "" };
                format!("{changed}{} - pathmarch", open.file_name())
            }
            None => "pathmarch".to_owned(),
        }
    }

    /// Runs one frame: background results, shortcuts, panels, dialogs, and the order for the next picture.
    pub(crate) fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.poll_background(&ctx);
        self.advance_playback(&ctx);
        let blocked = self.dialog.is_some() || self.file_dialog.is_some();
        let focus = ctx.memory(|memory| memory.focused());
        let (pressed, down) = ctx.input(|input| (input.pointer.any_pressed(), input.pointer.any_down()));
        if pressed || focus != self.focus && !down {
            self.undo_group += 1;
        }
        self.focus = focus;
        let typed = self.typing;
        if !blocked {
            if let Some(action) = actions::pressed(&ctx, self.open.is_some(), typed) {
                self.run_action(&ctx, action);
            }
            self.open_dropped_file(&ctx);
        }
        if self.picture_only && self.open.is_some() {
            self.viewport(ui);
        } else {
            self.panels(ui);
        }
        self.help_window(&ctx);
        self.material_palette(&ctx);
        self.show_dialog(&ctx);
        self.show_file_dialog(&ctx);
        self.show_toasts(&ctx);
        self.order_picture(&ctx);
        // Ctrl with plus or minus changes the zoom factor.
        self.preferences.scale = ctx.zoom_factor();
        self.save_preferences();
        self.typing = ctx.text_edit_focused();
    }

    /// Draws the menu bar, the status bar, and the open scene with its panels or the gallery.
    fn panels(&mut self, ui: &mut Ui) {
        self.menu_bar(ui);
        self.status_bar(ui);
        if self.open.is_some() {
            self.timeline_panel(ui);
            if self.preferences.show_plots {
                self.plots_panel(ui);
            }
            if self.preferences.show_source {
                self.source_panel(ui);
            }
            if self.preferences.left_open {
                self.tree_panel(ui);
            }
            if self.preferences.right_open {
                self.inspector_panel(ui);
            }
            self.viewport(ui);
        } else {
            self.gallery_page(ui);
        }
    }

    /// Saves the preferences. A failure is not reported: it would appear in every frame.
    fn save_preferences(&mut self) {
        let _ = self.preferences.save();
    }

    /// Collects results of background work: pictures, file changes, finished renders.
    fn poll_background(&mut self, ctx: &Context) {
        self.upload_picture(ctx);
        let reload = self.open.as_mut().and_then(OpenScene::poll_file);
        match reload {
            Some(FileChange::Reloaded) => {
                self.document_changed();
                self.show_message("Reloaded: the file changed on disk.");
            }
            Some(FileChange::Conflict) => self.dialog = Some(Dialog::Conflict),
            Some(FileChange::InSync) => {
                if matches!(self.dialog, Some(Dialog::Conflict)) {
                    self.dialog = None;
                }
                self.document_changed();
            }
            Some(FileChange::Unreadable(why)) => self.show_error(&why),
            None => {}
        }
        if self.open.as_mut().is_some_and(|open| open.poll_includes(&self.waker)) {
            self.document_changed();
            self.show_message("Reloaded: an included file changed on disk.");
        }
        let mut said = Vec::new();
        self.renders.retain(|export| match export.finished() {
            Some(result) => {
                said.push(result);
                false
            }
            None => true,
        });
        for result in said {
            match result {
                Ok(words) => self.show_message(&words),
                Err(words) => self.show_error(&words),
            }
        }
        if !self.renders.is_empty() {
            ctx.request_repaint_after(Duration::from_millis(200));
        }
    }

    /// Updates everything that depends on the document, after an edit.
    pub(crate) fn document_changed(&mut self) {
        let Some(open) = &mut self.open else { return };
        if let Some(scene) = open.document.last_good().cloned() {
            open.view.sync_camera(&scene);
        }
        open.view.selection.restore(&open.document);
        if self.ordered_revision != open.document.scene_revision() {
            open.view.mark_moving();
        }
        if open.has_unsaved_work() {
            self.recovery.keep(open.path.as_deref(), open.document.text(), open.base_text());
        } else {
            self.recovery.clear();
        }
    }

    /// Edits the document; shows the reason if the edit is refused.
    pub(crate) fn edit<T>(&mut self, edit: impl FnOnce(&mut OpenScene) -> Result<T, EditError>) -> Option<T> {
        let open = self.open.as_mut()?;
        let before = open.document.revision();
        let result = edit(open);
        let has_changed = open.document.revision() != before;
        if has_changed {
            self.document_changed();
        }
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.show_error(&error.to_string());
                None
            }
        }
    }

    // Shutdown.

    pub(crate) fn request_quit(&mut self) {
        if self.renders.is_empty() {
            self.guard_unsaved(PendingAction::Quit);
        } else {
            self.dialog = Some(Dialog::Busy);
        }
    }
    /// Quits: nothing needs confirmation any more.
    pub(crate) fn confirm_quit(&mut self) {
        self.quitting = true;
    }
    pub(crate) fn should_quit(&self) -> bool {
        self.quitting
    }
    /// Writes unsaved work to the recovery file now.
    pub(crate) fn flush_recovery(&mut self) {
        self.recovery.flush();
    }
    /// End of a sentence: a note that unsaved changes are kept, if there are any.
    pub(crate) fn recovery_note(&self) -> String {
        let unsaved = self.open.as_ref().is_some_and(OpenScene::has_unsaved_work);
        if unsaved { "; your changes are kept and will be offered at the next start".to_owned() } else { String::new() }
    }
    /// Saves preferences and removes the recovery file, if the user quit properly.
    pub(crate) fn shut_down(&mut self) {
        if self.quitting {
            self.recovery.clear();
        } else {
            self.recovery.flush();
        }
        self.save_preferences();
        self.report_frame_times();
    }
    /// Reopens both graphics devices.
    pub(crate) fn restart_graphics(&mut self) {
        self.reset_window_device = true;
        self.live.lose_device();
    }
    /// Returns and clears the request to reopen the window's graphics device.
    pub(crate) fn take_device_reset(&mut self) -> bool {
        std::mem::take(&mut self.reset_window_device)
    }
}
