//! Everything a person sees and does, without window or graphics device: tests drive it as they are.

use super::actions::{self, Action};
use super::chooser::{Choice, Chooser, Purpose};
use super::dialogs::{Dialog, RenderDialog};
use super::export::Export;
use super::gallery::Gallery;
use super::gizmo::Handle;
use super::open::{Handles, Kept, Open, Reload};
use super::panels::Plots;
use super::places::Places;
use super::preferences::Preferences;
use super::recovery::{Recovery, left_behind};
use super::saving::write_atomically;
use super::viewpoint;
use egui::{ColorImage, Context, TextureOptions, Ui};
use pathmarch_render::live::{Live, Order};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::{EditError, ItemKind, Path as NodePath};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Mode, Settings};
use std::path::{Path, PathBuf};
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

/// A message that goes away by itself.
pub(super) struct Toast {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) until: Instant,
}

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

/// What a file is chosen for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    Leave,
    New,
    Open,
    /// The file at this place of the recent ones.
    Recent(usize),
    Gallery,
    /// The scene of the gallery.
    Example(usize),
    Dropped,
}

/// What a file is chosen for.
pub(super) fn purpose(title: &str, extensions: &[&'static str]) -> Purpose {
    Purpose { title: title.to_owned(), extensions: extensions.to_vec() }
}

impl App {
    pub(super) fn new(ctx: &Context, options: Options, waker: Waker) -> Self {
        Self::in_places(ctx, options, waker, Places::of_user())
    }

    /// As [`Self::new`], with directories of its own for what it keeps.
    pub(super) fn in_places(ctx: &Context, options: Options, waker: Waker, places: Option<Places>) -> Self {
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
        if self.options.timings {
            self.frames.push(took.as_secs_f64() * 1e3);
        }
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
            Some(Reload::Unreadable(why)) => self.complain(&why),
            None => {}
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
        self.toast(text, false, 4.0);
    }
    pub(super) fn complain(&mut self, text: &str) {
        self.toast(text, true, 10.0);
    }
    fn toast(&mut self, text: &str, is_error: bool, seconds: f32) {
        let until = Instant::now() + Duration::from_secs_f32(seconds);
        self.toasts.retain(|toast| toast.text != text);
        self.toasts.push(Toast { text: text.to_owned(), is_error, until });
        let extra = self.toasts.len().saturating_sub(4);
        self.toasts.drain(..extra);
    }

    /// Does what a menu or a key asks for.
    pub(super) fn act(&mut self, ctx: &Context, action: Action) {
        let selection = self.open.as_ref().and_then(|open| open.view.selection.clone());
        match action {
            Action::New => self.unless_unsaved(After::New),
            Action::Open => self.unless_unsaved(After::Open),
            Action::Gallery => self.unless_unsaved(After::Gallery),
            Action::Quit => self.ask_to_leave(),
            Action::Save => drop(self.save(None)),
            Action::SaveAs => self.choose_save(For::SaveAs),
            Action::SavePicture => self.choose_picture(),
            Action::Render => self.dialog = self.open.as_ref().and_then(RenderDialog::new).map(Dialog::Render),
            Action::Undo | Action::Redo => self.travel(action == Action::Undo),
            Action::Help => self.help = !self.help,
            Action::RestartGraphics => {
                self.lose_window_device = true;
                self.live.lose_device();
            }
            Action::Tree => self.preferences.left_open = !self.preferences.left_open,
            Action::Inspector => self.preferences.right_open = !self.preferences.right_open,
            Action::Source => self.preferences.show_source = !self.preferences.show_source,
            Action::Plots => self.preferences.show_plots = !self.preferences.show_plots,
            Action::Dark => {
                let dark = ctx.theme() != egui::Theme::Dark;
                self.preferences.dark = Some(dark);
                ctx.set_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light });
            }
            Action::Duplicate => {
                if let Some(path) = selection {
                    let copy = self.edit(|open| open.document.duplicate(&path));
                    self.select(copy);
                }
            }
            Action::Delete => self.delete(selection),
            Action::Group => {
                if let Some(path) = selection {
                    let group = self.edit(|open| open.document.group(&[path], "union"));
                    self.select(group);
                }
            }
            Action::Ungroup => {
                if let Some(path) = selection {
                    let freed = self.edit(|open| open.document.ungroup(&path));
                    self.select(freed.and_then(|paths| paths.into_iter().next()));
                }
            }
            _ => self.act_on_view(ctx, action),
        }
    }

    fn delete(&mut self, selection: Option<NodePath>) {
        let Some(path) = selection else { return };
        if self.edit(|open| open.document.remove(&path)).is_some()
            && let Some(open) = &mut self.open
        {
            open.view.selection = None;
        }
    }

    /// Selects, unless there is nothing to select.
    pub(super) fn select(&mut self, path: Option<NodePath>) {
        if let (Some(open), Some(path)) = (&mut self.open, path) {
            open.view.selection = Some(path);
        }
    }

    fn travel(&mut self, back: bool) {
        let Some(open) = &mut self.open else { return };
        let label = if back { open.document.undo() } else { open.document.redo() };
        if let Some(label) = label {
            self.changed();
            self.say(&format!("{}: {label}", if back { "Undone" } else { "Done again" }));
        }
    }

    fn act_on_view(&mut self, ctx: &Context, action: Action) {
        let Some(open) = &mut self.open else { return };
        let view = &mut open.view;
        match action {
            Action::Deselect => (view.selection, view.focus_click) = (None, false),
            Action::ResetCamera | Action::NextCamera => {
                let Some(scene) = open.document.last_good() else { return };
                let cameras = &scene.cameras;
                let here = cameras.iter().position(|camera| camera.name == view.camera_name()).unwrap_or(0);
                let next = if action == Action::NextCamera { (here + 1) % cameras.len() } else { here };
                view.look_through(&cameras[next]);
                if action == Action::NextCamera {
                    let words = format!("Camera “{}”", cameras[next].name);
                    self.say(&words);
                }
            }
            Action::WriteCamera => self.write_camera(),
            Action::FrameSelection => self.frame_selection(),
            Action::FocusClick => view.focus_click = !view.focus_click,
            Action::GizmoMove => view.handles = Handles::Move,
            Action::GizmoTurn => view.handles = Handles::Turn,
            Action::GizmoScale => view.handles = Handles::Scale,
            Action::Preview => {
                view.mode = if view.mode == Mode::Preview { Mode::Path } else { Mode::Preview };
            }
            Action::KeepForComparison => self.keep_for_comparison(ctx),
            Action::Compare => match &mut view.kept {
                Some(kept) => kept.shown = !kept.shown,
                None => self.keep_for_comparison(ctx),
            },
            _ => {}
        }
    }

    /// Makes the scene's camera the one that is shown.
    pub(super) fn write_camera(&mut self) {
        let written = self.edit(|open| {
            let name = open.view.camera_name().to_owned();
            let is_it = |item: &&pathmarch_render::pathmarch_scene::document::Item| {
                item.kind == ItemKind::Camera && item.name.as_deref().unwrap_or("main") == name
            };
            let path = open.document.outline().iter().find(is_it).map(|item| item.path.clone());
            let camera = open.view.camera.clone();
            open.document.write_camera(&camera, path.as_ref())?;
            let scene = open.document.last_good().cloned();
            if let Some(camera) = scene.iter().flat_map(|scene| &scene.cameras).find(|camera| camera.name == name) {
                open.view.written(camera);
            }
            Ok(name)
        });
        if let Some(name) = written {
            self.say(&format!("Camera “{name}” of the scene is now as shown."));
        }
    }

    fn frame_selection(&mut self) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let leaves = match &open.view.selection {
            Some(path) => open.document.leaves_of(path),
            None => (0..scene.field.leaves().len()).collect(),
        };
        let boxes =
            leaves.into_iter().filter_map(|leaf| scene.field.leaves().get(leaf)).map(|leaf| leaf.world_bounds());
        let bounds = boxes.filter(|bounds| bounds.is_finite()).reduce(|all, bounds| all.union(bounds));
        let Some(bounds) = bounds else {
            self.say("What is selected has no limited size.");
            return;
        };
        let (min, max) = (glam::Vec3::from(bounds.min), glam::Vec3::from(bounds.max));
        viewpoint::frame(&mut open.view.camera, (min + max) * 0.5, (max - min).length() * 0.5);
        open.view.touch();
    }

    fn keep_for_comparison(&mut self, ctx: &Context) {
        let (Some(open), Some(shown)) = (&mut self.open, self.live.picture()) else { return };
        let image = ColorImage::from_rgba_premultiplied(shown.size.map(|side| side as usize), &shown.codes);
        let texture = ctx.load_texture("kept picture", image, TextureOptions::LINEAR);
        let label = format!("{}, {:.0} samples", open.view.mode.name(), shown.samples);
        open.view.kept = Some(Kept { texture, label, split: 0.5, shown: true });
        self.say("Kept for comparison: drag the line in the picture; B hides it.");
    }

    // Files.

    /// Does it, or asks first what is to become of unsaved work.
    pub(super) fn unless_unsaved(&mut self, after: After) {
        let after = match after {
            // Saving moves files in the list: what counts is which one it is now.
            After::Recent(index) => {
                self.gallery.dropped = self.preferences.recent.get(index).cloned();
                After::Dropped
            }
            after => after,
        };
        if self.open.as_ref().is_some_and(Open::has_unsaved_work) {
            self.dialog = Some(Dialog::Unsaved(after));
        } else {
            self.proceed(after);
        }
    }

    pub(super) fn proceed(&mut self, after: After) {
        match after {
            After::Leave => self.leaving = true,
            After::New => self.show_scene(Open::new("scene.kdl", NEW_SCENE.to_owned(), None)),
            After::Open => {
                let purpose = purpose("Open a scene", &["kdl"]);
                self.chooser = Some((self.with_places(Chooser::open(&self.directory(), purpose)), For::Open));
            }
            After::Recent(index) => {
                if let Some(path) = self.preferences.recent.get(index).cloned() {
                    self.open_file(&path);
                }
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
            After::Dropped => {
                if let Some(path) = self.gallery.dropped.take() {
                    self.open_file(&path);
                }
            }
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
        match std::fs::read_to_string(&path) {
            Ok(text) => {
                self.preferences.opened(&path);
                let mut open = Open::new(&path.display().to_string(), text, Some(path.clone()));
                let wake = self.waker.clone();
                open.watch(move || wake());
                self.show_scene(open);
            }
            Err(error) => {
                let why = match error.kind() {
                    std::io::ErrorKind::NotFound => {
                        self.preferences.forget(&path);
                        "there is no such file".to_owned()
                    }
                    std::io::ErrorKind::InvalidData => "it is not UTF-8 text".to_owned(),
                    std::io::ErrorKind::IsADirectory => "it is a directory: name a .kdl file in it".to_owned(),
                    _ => error.to_string(),
                };
                self.complain(&format!("{} cannot be opened: {why}.", path.display()));
            }
        }
    }

    pub(super) fn show_scene(&mut self, open: Open) {
        self.recovery.clear();
        self.open = Some(open);
        (self.ordered, self.first_order) = (None, None);
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
            let wake = self.waker.clone();
            open.watch(move || wake());
        }
        self.preferences.opened(&path);
        self.recovery.clear();
        self.say(&format!("Saved {}.", path.display()));
        true
    }

    fn choose_save(&mut self, what: For) {
        let name = self.open.as_ref().and_then(|open| open.path.clone());
        let name = name.as_deref().and_then(Path::file_name).map_or("scene.kdl".into(), |name| name.to_string_lossy());
        let purpose = purpose("Save the scene", &["kdl"]);
        self.chooser = Some((self.with_places(Chooser::save(&self.directory(), &name, purpose)), what));
    }

    fn choose_picture(&mut self) {
        let purpose = purpose("Save the picture as it is shown", &["png", "exr", "jpg"]);
        let name = self.picture_name();
        self.chooser = Some((self.with_places(Chooser::save(&self.directory(), &name, purpose)), For::Picture));
    }

    /// What a picture of the open scene is called.
    pub(super) fn picture_name(&self) -> String {
        let stem = self.open.as_ref().and_then(|open| open.path.as_deref()?.file_stem().map(|stem| stem.to_owned()));
        format!("{}.png", stem.map_or("picture".into(), |stem| stem.to_string_lossy().into_owned()))
    }

    fn choosing(&mut self, ctx: &Context) {
        let Some((chooser, what)) = &mut self.chooser else { return };
        let what = *what;
        let Some(choice) = chooser.show(ctx) else { return };
        self.chooser = None;
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

    fn take_dropped(&mut self, ctx: &Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.gallery.dropped = Some(path);
            self.unless_unsaved(After::Dropped);
        }
    }

    // The end.

    pub(super) fn ask_to_leave(&mut self) {
        self.unless_unsaved(After::Leave);
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
    /// Whether the window's graphics device is to be opened anew.
    pub(super) fn take_lose_device(&mut self) -> bool {
        std::mem::take(&mut self.lose_window_device)
    }
}
