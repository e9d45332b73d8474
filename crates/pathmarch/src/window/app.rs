//! Everything a person sees and does, without window or graphics device: tests drive it as they are.

use super::actions;
use super::chooser::Chooser;
use super::dialogs::Dialog;
use super::export::Export;
use super::files::{After, For};
use super::gallery::Gallery;
use super::gizmo::Handle;
use super::open::{Open, Reload};
use super::panels::Plots;
use super::preferences::Preferences;
use super::recovery::{Recovery, left_behind};
use egui::{ColorImage, Context, TextureOptions, Ui};
use pathmarch_cli::AppDirs;
use pathmarch_render::live::{Live, Order};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::EditError;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Settings};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What the window is started with.
#[derive(Clone, Debug)]
pub struct Options {
    /// The scene to open; the gallery without one.
    pub scene: Option<PathBuf>,
    /// What to render on.
    pub backend: Backend,
    /// Part of the name of the adapter.
    pub adapter: Option<String>,
    /// Whether to say on standard error how long things took.
    pub timings: bool,
}

/// Wakes the window from other threads.
pub(super) type Waker = Arc<dyn Fn() + Send + Sync>;

/// Messages stay for so long; in tests until they are closed, for no test may depend on how fast it runs.
const MESSAGE_SECONDS: f32 = if cfg!(test) { 1e5 } else { 4.0 };
/// Complaints stay longer, for there is more to read.
const COMPLAINT_SECONDS: f32 = if cfg!(test) { 1e5 } else { 10.0 };

/// A message that goes away by itself.
pub(super) struct Toast {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) until: Instant,
}

/// The program as a person sees it.
pub(super) struct App {
    pub(super) options: Options,
    pub(super) waker: Waker,
    pub(super) live: Live,
    pub(super) open: Option<Open>,
    pub(super) gallery: Gallery,
    pub(super) preferences: Preferences,
    pub(super) recovery: Recovery,
    pub(super) chooser: Option<(Chooser, For)>,
    pub(super) dialog: Option<Dialog>,
    pub(super) exports: Vec<Export>,
    pub(super) toasts: Vec<Toast>,
    pub(super) plots: Plots,
    pub(super) handle: Handle,
    pub(super) help: bool,
    /// Changes between two presses of the pointer, or from the keyboard in one widget, are one step of undoing.
    pub(super) gesture: u64,
    focus: Option<egui::Id>,
    /// When the text of the scene was last typed in, seconds.
    pub(super) typed_at: f64,
    /// Text was being typed at the end of the last frame.
    typing: bool,
    ordered: Option<Order>,
    /// The first order of the scene that is open; earlier pictures are of another.
    first_order: Option<u64>,
    started: Instant,
    milestones: Vec<&'static str>,
    /// How long frames of the window took, milliseconds; kept only if asked for.
    frames: Vec<f64>,
    leaving: bool,
    lose_window_device: bool,
}

impl App {
    pub(super) fn new(ctx: &Context, options: Options, waker: Waker) -> Self {
        Self::in_places(ctx, options, waker, AppDirs::of_user())
    }

    /// As [`Self::new`], with directories of its own for what it keeps.
    pub(super) fn in_places(ctx: &Context, options: Options, waker: Waker, places: Option<AppDirs>) -> Self {
        let started = Instant::now();
        let wake = waker.clone();
        let live = Live::new(options.backend, options.adapter.clone(), move || wake());
        let preferences =
            places.as_ref().map_or_else(Preferences::default, |places| Preferences::load_from(&places.preferences));
        let kept_in = places.map_or_else(|| std::env::temp_dir().join("pathmarch-recovery"), |places| places.recovery);
        let recovery = Recovery::new(&kept_in);
        ctx.set_theme(match preferences.dark {
            Some(true) => egui::ThemePreference::Dark,
            Some(false) => egui::ThemePreference::Light,
            None => egui::ThemePreference::System,
        });
        ctx.set_zoom_factor(preferences.scale);
        // A cursor that blinks draws the window twice a second for ever.
        ctx.all_styles_mut(|style| style.visuals.text_cursor.blink = false);
        let mut app = Self {
            live,
            open: None,
            gallery: Gallery::default(),
            preferences,
            recovery,
            chooser: None,
            dialog: None,
            exports: Vec::new(),
            toasts: Vec::new(),
            plots: Plots::default(),
            handle: Handle::default(),
            help: false,
            gesture: 0,
            typed_at: 0.0,
            focus: None,
            typing: false,
            ordered: None,
            first_order: None,
            started,
            milestones: Vec::new(),
            frames: Vec::new(),
            leaving: false,
            lose_window_device: false,
            waker,
            options,
        };
        let left = left_behind(&kept_in);
        if !left.is_empty() {
            app.dialog = Some(Dialog::Recovered(left));
        }
        for problem in [app.recovery.problem(), app.preferences.notice().map(str::to_owned)].into_iter().flatten() {
            app.complain(&problem);
        }
        if let Some(path) = app.options.scene.clone() {
            app.open_file(&path);
        }
        app
    }

    /// What the window's title says.
    pub(super) fn title(&self) -> String {
        match &self.open {
            Some(open) => {
                let changed = if open.has_unsaved_work() { "• " } else { "" };
                format!("{changed}{} - pathmarch", open.name())
            }
            None => "pathmarch".to_owned(),
        }
    }

    /// Says how long it took from the start to something that happens once.
    pub(super) fn milestone(&mut self, what: &'static str, detail: &str) {
        if self.options.timings && !self.milestones.contains(&what) {
            self.milestones.push(what);
            eprintln!("{:8.1} ms  {what} {detail}", self.started.elapsed().as_secs_f64() * 1e3);
        }
    }

    /// A frame is on the screen, after this long.
    pub(super) fn painted(&mut self, took: Duration) {
        if !self.options.timings {
            return;
        }
        self.frames.push(took.as_secs_f64() * 1e3);
        self.milestone("window drawn", "");
        let whole = self.ordered.as_ref().map(|order| order.settings.size);
        if let Some((_, _, size)) = self.open.as_ref().and_then(|open| open.view.picture.as_ref()) {
            let size = *size;
            self.milestone("first picture", &format!("of {}x{} pixels", size[0], size[1]));
            if Some(size) == whole {
                self.milestone("whole picture", &format!("of {}x{} pixels", size[0], size[1]));
                if self.live.status().resting {
                    self.milestone("all samples", "");
                }
            }
        }
    }

    /// Says how long frames of the window took.
    fn report_frames(&mut self) {
        self.frames.sort_by(f64::total_cmp);
        if let (Some(longest), count) = (self.frames.last(), self.frames.len()) {
            let at = |share: f64| self.frames[((count - 1) as f64 * share) as usize];
            eprintln!(
                "{count} frames of the window: median {:.1} ms, 95 % below {:.1} ms, longest {longest:.1} ms",
                at(0.5),
                at(0.95)
            );
        }
    }

    /// Everything of one frame.
    pub(super) fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.poll(&ctx);
        self.keep_time(&ctx);
        let blocked = self.dialog.is_some() || self.chooser.is_some();
        let focus = ctx.memory(|memory| memory.focused());
        let (pressed, down) = ctx.input(|input| (input.pointer.any_pressed(), input.pointer.any_down()));
        if pressed || focus != self.focus && !down {
            self.gesture += 1;
        }
        self.focus = focus;
        let typed = self.typing;
        if !blocked {
            if let Some(action) = actions::pressed(&ctx, self.open.is_some(), typed) {
                self.act(&ctx, action);
            }
            self.take_dropped(&ctx);
        }
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
            self.mistakes_panel(ui);
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
        self.help_window(&ctx);
        self.dialogs(&ctx);
        self.choosing(&ctx);
        self.show_toasts(&ctx);
        self.order(&ctx);
        // Ctrl with plus and minus changes it.
        self.preferences.scale = ctx.zoom_factor();
        self.save_preferences();
        self.typing = ctx.text_edit_focused();
    }

    /// What cannot be remembered is not worth a word each time.
    fn save_preferences(&mut self) {
        let _ = self.preferences.save();
    }

    /// Takes on what happened elsewhere: pictures, files, renders.
    fn poll(&mut self, ctx: &Context) {
        self.take_picture(ctx);
        let reload = self.open.as_mut().and_then(Open::reload);
        match reload {
            Some(Reload::Taken) => {
                self.changed();
                if let Some(open) = &mut self.open {
                    open.view.selection = None;
                }
                self.say("The file has changed: this is what it says now.");
            }
            Some(Reload::Conflict) => self.dialog = Some(Dialog::Conflict),
            Some(Reload::Same) => {
                if matches!(self.dialog, Some(Dialog::Conflict)) {
                    self.dialog = None;
                }
                self.changed();
            }
            Some(Reload::Unreadable(why)) => self.complain(&why),
            None => {}
        }
        if self.open.as_mut().is_some_and(|open| open.follow_parts(&self.waker)) {
            self.changed();
            self.say("A file that the scene includes has changed.");
        }
        let mut said = Vec::new();
        self.exports.retain(|export| match export.finished() {
            Some(result) => {
                said.push(result);
                false
            }
            None => true,
        });
        for result in said {
            match result {
                Ok(words) => self.say(&words),
                Err(words) => self.complain(&words),
            }
        }
        if !self.exports.is_empty() {
            ctx.request_repaint_after(Duration::from_millis(200));
        }
    }

    /// Brings a new picture to the screen.
    fn take_picture(&mut self, ctx: &Context) {
        let (Some(open), Some(shown)) = (&mut self.open, self.live.picture()) else { return };
        let is_other_scene = self.first_order.is_none_or(|first| shown.order < first);
        if is_other_scene || open.view.picture.as_ref().is_some_and(|(_, serial, _)| *serial == shown.serial) {
            return;
        }
        let size = shown.size.map(|side| side as usize);
        let image = ColorImage::from_rgba_premultiplied(size, &shown.codes);
        match &mut open.view.picture {
            Some((texture, serial, old)) => {
                texture.set(image, TextureOptions::LINEAR);
                (*serial, *old) = (shown.serial, shown.size);
            }
            slot => {
                let texture = ctx.load_texture("picture", image, TextureOptions::LINEAR);
                *slot = Some((texture, shown.serial, shown.size));
            }
        }
        self.plots.picture(&shown, self.live.status().samples_per_second);
    }

    /// Tells the renderer what to show, if that has changed.
    fn order(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let moving = open.view.moving();
        if open.view.room.contains(&0) {
            return;
        }
        let order = Order {
            settings: Self::settings(open, &scene),
            display: Self::display(open, &scene),
            scene,
            moving: moving.is_some(),
            frame_time: Duration::from_secs_f32(1.0 / self.preferences.frame_rate.clamp(1.0, 240.0)),
        };
        let same = self.ordered.as_ref().is_some_and(|old| {
            Arc::ptr_eq(&old.scene, &order.scene)
                && old.settings == order.settings
                && old.display == order.display
                && old.moving == order.moving
                && old.frame_time == order.frame_time
        });
        if !same {
            let number = self.live.show(order.clone());
            self.first_order.get_or_insert(number);
            self.ordered = Some(order);
        }
        if let Some(left) = moving {
            ctx.request_repaint_after(left + Duration::from_millis(5));
        }
    }

    /// Another scene comes: no picture of the one before is shown for it.
    pub(super) fn forget_picture(&mut self) {
        (self.ordered, self.first_order) = (None, None);
    }

    /// What is rendered live.
    pub(super) fn settings(open: &Open, scene: &Scene) -> Settings {
        let asked = Settings::of(scene);
        let mode = open.view.mode;
        Settings {
            size: open.view.size(scene),
            samples: mode.samples(asked.samples),
            viewpoint: Some(open.view.camera.clone()),
            mode,
            ..asked
        }
    }

    pub(super) fn display(open: &Open, scene: &Scene) -> Display {
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: open.view.camera.exposure };
        open.view.mode.display(display)
    }

    /// The document was changed: everything that depends on it follows.
    pub(super) fn changed(&mut self) {
        let Some(open) = &mut self.open else { return };
        if let Some(scene) = open.document.last_good().cloned() {
            open.view.follow(&scene);
        }
        if open.view.selection.as_ref().is_some_and(|path| open.document.item(path).is_none()) {
            open.view.selection = None;
        }
        open.view.touch();
        if open.has_unsaved_work() {
            self.recovery.keep(open.path.as_deref(), open.document.text(), open.disk());
        } else {
            self.recovery.clear();
        }
    }

    /// Makes a change of the document; says why where it is refused.
    pub(super) fn edit<T>(&mut self, edit: impl FnOnce(&mut Open) -> Result<T, EditError>) -> Option<T> {
        let open = self.open.as_mut()?;
        let before = open.document.revision();
        let result = edit(open);
        let has_changed = open.document.revision() != before;
        if has_changed {
            self.changed();
        }
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.complain(&error.to_string());
                None
            }
        }
    }

    pub(super) fn say(&mut self, text: &str) {
        self.toast(text, false, MESSAGE_SECONDS);
    }
    pub(super) fn complain(&mut self, text: &str) {
        self.toast(text, true, COMPLAINT_SECONDS);
    }
    fn toast(&mut self, text: &str, is_error: bool, seconds: f32) {
        let until = Instant::now() + Duration::from_secs_f32(seconds);
        self.toasts.retain(|toast| toast.text != text);
        self.toasts.push(Toast { text: text.to_owned(), is_error, until });
        let extra = self.toasts.len().saturating_sub(4);
        self.toasts.drain(..extra);
    }

    // The end.

    pub(super) fn ask_to_leave(&mut self) {
        if self.exports.is_empty() {
            self.unless_unsaved(After::Leave);
        } else {
            self.dialog = Some(Dialog::Busy);
        }
    }
    /// Nothing is in the way of the end.
    pub(super) fn end(&mut self) {
        self.leaving = true;
    }
    pub(super) fn wants_to_leave(&self) -> bool {
        self.leaving
    }
    /// Writes what is not saved to the recovery file now.
    pub(super) fn keep_safe(&mut self) {
        self.recovery.flush();
    }
    /// Where what is not saved is kept, as the end of a sentence.
    pub(super) fn where_kept(&self) -> String {
        let unsaved = self.open.as_ref().is_some_and(Open::has_unsaved_work);
        if unsaved { "; your changes are kept and will be offered at the next start".to_owned() } else { String::new() }
    }
    /// The window is closed in order.
    pub(super) fn leave(&mut self) {
        if self.leaving {
            self.recovery.clear();
        } else {
            self.recovery.flush();
        }
        self.save_preferences();
        self.report_frames();
    }
    /// Opens both graphics devices anew.
    pub(super) fn restart_graphics(&mut self) {
        self.lose_window_device = true;
        self.live.lose_device();
    }
    /// Whether the window's graphics device is to be opened anew.
    pub(super) fn take_lose_device(&mut self) -> bool {
        std::mem::take(&mut self.lose_window_device)
    }
}
