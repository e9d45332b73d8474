//! Tests of the window as a user sees it: everything but the system window and its graphics device.

mod camera;
mod controls;
mod files;
mod gallery;
mod handles;
mod kills;
mod looks;
mod monkey;
mod pictures;
mod recovery;
mod time;
mod tree;
mod views;

use super::app::{App, Options};
use super::open_scene::OpenScene;
use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Pos2, Rect, Vec2};
use egui_kittest::kittest::{By, Queryable};
use egui_kittest::{Harness, HarnessBuilder, Node};
use pathmarch_cli::AppDirs;
use pathmarch_render::Backend;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::{Document, Item, Path as NodePath, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Default timeout, seconds, generous for busy machines; `PATHMARCH_TEST_PATIENCE` overrides it.
const DEFAULT_TIMEOUT: u64 = 300;
/// Time per frame: two clicks with a pause between them are no double click.
const FRAME: f32 = 0.05;
/// Frames that separate two single clicks.
const PAUSE: usize = 8;

/// Timeout of any wait.
pub(in crate::window) fn timeout() -> Duration {
    let seconds = std::env::var("PATHMARCH_TEST_PATIENCE").ok().and_then(|seconds| seconds.parse().ok());
    Duration::from_secs(seconds.unwrap_or(DEFAULT_TIMEOUT))
}

/// Ctrl, as the system reports it.
const CTRL: Modifiers = Modifiers { ctrl: true, command: true, ..Modifiers::NONE };

/// A scene with few pixels and samples, with comments and an order of its own.
const SCENE: &str = r#"// A scene to test with.
pathmarch 1

camera "main" { position 0 1.2 4.5; target 0 0.6 0; fov 40 }
camera "other" {
    position 3 2 3 // from the side
    target 0 0.5 0
    fov 30
}
render { size 64 48; samples 4; bounces 2 }
sky 0.6

// What it is made of.
material "red" { diffuse 0.8 0.12 0.08 }
material "grey" { diffuse 0.5 }

object "ball" material="red" { sphere 0.7 { at 0 0.7 0 } } // round
object "carved" material="grey" {
    subtract smooth=0.05 {
        box 0.6 0.6 0.6
        sphere 0.4 { at 0.2 0.2 0.2 }
        at 1.5 0.4 0
    }
}
object "floor" material="grey" { plane }
"#;

/// The application before its first frame.
struct Desk {
    app: Option<App>,
    options: Options,
    dirs: AppDirs,
}

/// A simulated user.
struct Person {
    harness: Harness<'static, Desk>,
    /// Contains the scene, preferences and recovery files; removed at the end.
    directory: Arc<tempfile::TempDir>,
}

/// Start-up options.
struct Start {
    directory: Arc<tempfile::TempDir>,
    scene: Option<PathBuf>,
    size: Vec2,
    scale: f32,
    wgpu: bool,
}

impl Start {
    fn new() -> Self {
        let directory = Arc::new(tempfile::tempdir().expect("a directory"));
        Self { directory, scene: None, size: Vec2::new(1000.0, 700.0), scale: 1.0, wgpu: false }
    }

    /// With this scene in a file of its own.
    fn with(text: &str) -> Self {
        let mut this = Self::new();
        let path = this.directory.path().join("scene.kdl");
        std::fs::write(&path, text).expect("written");
        this.scene = Some(path);
        this
    }

    fn size(self, width: f32, height: f32) -> Self {
        Self { size: Vec2::new(width, height), ..self }
    }

    fn go(self) -> Person {
        let home = self.directory.path().join("home");
        let desk = Desk {
            app: None,
            options: Options {
                scene: self.scene,
                backend: Backend::Cpu,
                adapter: None,
                allow_files: false,
                timings: false,
            },
            dirs: AppDirs {
                recovery: home.join("recovery"),
                references: home.join("references"),
                meshes: home.join("meshes"),
                preferences: home,
            },
        };
        let frame = |ui: &mut egui::Ui, desk: &mut Desk| {
            let Desk { app, options, dirs } = desk;
            let start = || App::with_dirs(ui.ctx(), options.clone(), Arc::new(|| ()), Some(dirs.clone()));
            app.get_or_insert_with(start).ui(ui);
        };
        let builder: HarnessBuilder<Desk> = Harness::builder()
            .with_size(self.size)
            .with_pixels_per_point(self.scale)
            .with_step_dt(FRAME)
            .with_max_steps(6)
            .allow_missing_glyphs();
        let builder = if self.wgpu { builder.wgpu() } else { builder };
        let mut person = Person { harness: builder.build_ui_state(frame, desk), directory: self.directory };
        person.wait(2);
        person
    }
}

impl Person {
    /// Opens the test scene.
    fn at_scene() -> Self {
        Start::with(SCENE).go()
    }

    fn app(&self) -> &App {
        self.harness.state().app.as_ref().expect("it has started")
    }
    fn app_mut(&mut self) -> &mut App {
        self.harness.state_mut().app.as_mut().expect("it has started")
    }
    fn open(&self) -> &OpenScene {
        self.app().open.as_ref().expect("a scene is open")
    }
    fn document(&self) -> &Document {
        &self.open().document
    }
    fn text(&self) -> &str {
        self.document().text()
    }
    fn scene(&self) -> &Scene {
        self.document().scene().expect("a scene")
    }
    /// File of the scene, which may not exist yet.
    fn file(&self) -> PathBuf {
        self.directory.path().join("scene.kdl")
    }
    fn on_disk(&self) -> String {
        std::fs::read_to_string(self.file()).expect("read")
    }
    fn messages(&self) -> Vec<&str> {
        self.app().toasts.iter().map(|toast| toast.text.as_str()).collect()
    }
    #[track_caller]
    fn assert_said(&self, words: &str) {
        let messages = self.messages();
        assert!(messages.iter().any(|message| message.contains(words)), "no “{words}” in {messages:?}");
    }

    /// All items of the scene.
    fn items(&self) -> Vec<Item> {
        fn all(items: &[Item], into: &mut Vec<Item>) {
            for item in items {
                into.push(item.clone());
                all(&item.children, into);
            }
        }
        let mut found = Vec::new();
        all(self.document().outline(), &mut found);
        found
    }
    /// Node with this title.
    #[track_caller]
    fn path(&self, title: &str) -> NodePath {
        let items = self.items();
        items.iter().find(|item| item.title() == title).unwrap_or_else(|| panic!("no {title}")).path.clone()
    }
    #[track_caller]
    fn value(&self, title: &str, key: &str) -> Value {
        self.document().control(&self.path(title), key).unwrap_or_else(|| panic!("no {key} of {title}")).value
    }
    fn selected(&self) -> Option<String> {
        let path = self.open().view.selection.active()?;
        self.document().item(path).map(|item| item.title().to_owned())
    }
    fn select(&mut self, title: &str) {
        let path = self.path(title);
        self.app_mut().select(Some(path));
        self.wait(2);
    }

    /// Runs some frames.
    fn wait(&mut self, frames: usize) {
        self.harness.run_steps(frames);
    }

    /// Waits in real time until a condition holds.
    #[track_caller]
    fn until(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        loop {
            self.harness.step();
            if holds(self) {
                return;
            }
            assert!(start.elapsed() < timeout(), "waited in vain until {what}; {:?}", self.messages());
            std::thread::sleep(Duration::from_millis(4));
        }
    }

    /// Waits until the whole picture has all its samples.
    #[track_caller]
    fn rest(&mut self) {
        self.until("the picture is done", Self::is_at_rest);
    }

    /// Returns true if the picture shows the open scene at full size with all samples.
    fn is_at_rest(&self) -> bool {
        let (app, open) = (self.app(), self.open());
        let Some(scene) = open.document.last_good() else { return false };
        // The answer comes after all earlier orders, with the samples so far.
        let Ok(Ok((_, settings))) = app.live.film().recv() else { return false };
        let shown = open.view.picture.as_ref().map(|(_, serial, _)| *serial);
        settings == App::settings(open, scene)
            && app.live.status().resting
            && shown == app.live.picture().map(|picture| picture.serial)
    }

    #[track_caller]
    fn has(&self, label: &str) -> bool {
        self.harness.query_all_by_label_contains(label).next().is_some()
    }
    #[track_caller]
    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.wait(PAUSE);
    }
    #[track_caller]
    fn click_role(&mut self, role: Role, label: &str) {
        self.harness.get_by_role_and_label(role, label).click();
        self.wait(PAUSE);
    }
    /// Opens a menu and clicks the entry whose label starts with `entry`.
    #[track_caller]
    fn menu(&mut self, menu: &str, entry: &str) {
        self.click_role(Role::Button, menu);
        let starts = |node: &egui_kittest::kittest::AccessKitNode<'_>| {
            node.role() == Role::Button && node.label().is_some_and(|label| label.starts_with(entry))
        };
        // The last match: menus are above everything else.
        let node = self.harness.query_all_by(starts).last().unwrap_or_else(|| panic!("no {entry} in {menu}"));
        node.click();
        self.wait(PAUSE);
    }
    /// Clicks entries of a row's context menu in the scene tree.
    #[track_caller]
    fn context(&mut self, row: &str, entries: &[&str]) {
        self.harness.get_by_role_and_label(Role::TreeItem, row).click_secondary();
        self.wait(PAUSE);
        for entry in entries {
            let node = self.harness.query_all_by_role_and_label(Role::Button, entry).last();
            node.unwrap_or_else(|| panic!("no {entry} for {row}")).click();
            self.wait(PAUSE);
        }
    }
    fn key(&mut self, key: Key) {
        self.harness.key_press(key);
        self.wait(2);
    }
    fn ctrl(&mut self, key: Key) {
        self.harness.key_press_modifiers(CTRL, key);
        self.wait(2);
    }
    fn ctrl_shift(&mut self, key: Key) {
        self.harness.key_press_modifiers(CTRL | Modifiers::SHIFT, key);
        self.wait(2);
    }
    /// Replaces the text of a field and presses Enter.
    #[track_caller]
    fn fill(&mut self, role: Role, label: &str, text: &str) {
        self.field(role, label).focus();
        self.wait(2);
        self.retype(text);
    }
    /// First widget with this label: the selection's controls come before those of its material.
    #[track_caller]
    fn field<'a>(&'a self, role: Role, label: &'a str) -> Node<'a> {
        let node = self.harness.query_all(By::new().role(role).label(label)).next();
        node.unwrap_or_else(|| panic!("no {role:?} {label}"))
    }
    /// Presses the last button with this label: dialogs are above everything else.
    #[track_caller]
    fn answer(&mut self, label: &str) {
        let button = self.harness.query_all_by_role_and_label(Role::Button, label).last();
        button.unwrap_or_else(|| panic!("no {label}")).click();
        self.wait(PAUSE);
    }
    /// Replaces the text of the focused field and presses Enter.
    fn retype(&mut self, text: &str) {
        self.ctrl(Key::A);
        self.harness.event(egui::Event::Text(text.to_owned()));
        self.wait(2);
        self.key(Key::Enter);
    }
    /// Types a number beside a slider.
    #[track_caller]
    fn type_number(&mut self, label: &str, text: &str) {
        let slider = self.harness.get_by_role_and_label(Role::Slider, label).rect();
        let beside = |node: &Node<'_>| {
            let rect = node.rect();
            rect.y_range().contains(slider.center().y) && rect.min.x >= slider.min.x
        };
        let numbers: Vec<_> = self.harness.query_all_by_role(Role::SpinButton).filter(|node| beside(node)).collect();
        let number = numbers.iter().min_by(|a, b| a.rect().min.x.total_cmp(&b.rect().min.x));
        number.unwrap_or_else(|| panic!("no number beside {label}")).click();
        drop(numbers);
        self.wait(PAUSE);
        self.retype(text);
    }

    /// Rectangle of the picture.
    fn picture(&self) -> Rect {
        let room = self.harness.get_by_role_and_label(Role::Image, "Viewport").rect();
        let (width, height) = self.scene().render.size;
        let inner = room.shrink(6.0);
        let fit = (inner.width() / width as f32).min(inner.height() / height as f32);
        Rect::from_center_size(room.center(), Vec2::new(width as f32, height as f32) * fit)
    }
    /// A point of the picture, from 0 to 1.
    fn point(&self, x: f32, y: f32) -> Pos2 {
        self.picture().lerp_inside(Vec2::new(x, y))
    }
    fn hover(&mut self, at: Pos2) {
        self.harness.hover_at(at);
        self.wait(2);
    }
    fn button(&self, pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
        self.harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
    }
    fn click_at(&mut self, at: Pos2, modifiers: Modifiers) {
        self.hover(at);
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        self.button(at, PointerButton::Primary, true, modifiers);
        self.button(at, PointerButton::Primary, false, modifiers);
        self.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.wait(PAUSE);
    }
    /// Drags in steps of one frame each.
    fn drag(&mut self, from: Pos2, to: Pos2, button: PointerButton, modifiers: Modifiers) {
        self.hover(from);
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        self.button(from, button, true, modifiers);
        for step in 1..=5 {
            self.harness.event(egui::Event::PointerMoved(from.lerp(to, step as f32 / 5.0)));
        }
        self.button(to, button, false, modifiers);
        self.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.wait(PAUSE);
    }

    /// Undoes everything; returns the number of steps.
    fn undo_all(&mut self) -> usize {
        let mut steps = 0;
        while self.document().can_undo().is_some() {
            self.ctrl(Key::Z);
            steps += 1;
            assert!(steps < 10_000);
        }
        steps
    }

    /// Ends the program as a crash does, and starts a new one.
    fn crash(self) -> Self {
        let directory = self.directory.clone();
        drop(self);
        Start { directory, ..Start::new() }.go()
    }
}

/// Lines that differ between two texts.
fn changed_lines<'a>(before: &'a str, after: &'a str) -> Vec<(&'a str, &'a str)> {
    assert_eq!(before.lines().count(), after.lines().count(), "{after}");
    before.lines().zip(after.lines()).filter(|(a, b)| a != b).collect()
}

/// Replaces a file as an editor does.
fn replace_file(path: &Path, text: &str) {
    let new = path.with_extension("new");
    std::fs::write(&new, text).expect("written");
    std::fs::rename(&new, path).expect("renamed");
}
