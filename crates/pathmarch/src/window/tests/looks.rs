//! Snapshot tests of the window, against the pictures in `tests/snapshots`.
//!
//! They draw with a GPU adapter, which may be a software one. These tests cannot detect a missing adapter at run time
//! and report themselves as ignored; so they are ignored unless requested with `--include-ignored`, as in CI.
//! `UPDATE_SNAPSHOTS=1` writes new pictures.

use super::*;
use egui_kittest::SnapshotOptions;

/// A scene with few samples.
pub(super) const STILL: &str = r#"pathmarch 1
camera "main" { position 3.1 2.6 4.5; target 0.05 0.5 0; fov 27 }
render { size 320 200; samples 16; bounces 3 }
sky 0.22 0.3 0.45
sun { direction 0.9 0.8 0.1; irradiance 2.4 2 1.5; angle 2 }
material "clay" { diffuse 0.7 0.22 0.08 }
material "slate" { diffuse 0.12 0.2 0.3 }
object "block" material="clay" { subtract smooth=0.12 { box 1.6 1.3 1.6; sphere 0.85 { at 0.5 0.45 0.5 }; at 0 0.65 0 } }
object "ball" material="slate" { sphere 0.3 { at 0.5 0.55 0.5 } }
object "floor" material="slate" { plane }
"#;

impl Start {
    pub(super) fn drawn(self, dark: bool) -> Self {
        let home = self.directory.path().join("home");
        std::fs::create_dir_all(&home).expect("made");
        std::fs::write(home.join("preferences.json"), format!("{{\"dark\": {dark}}}")).expect("written");
        Self { wgpu: true, ..self }
    }
}

impl Person {
    /// Compares the window with its snapshot. Edges of letters and lines differ slightly between adapters, as may the
    /// last bit of the rendered pixels between CPUs.
    #[track_caller]
    fn looks_like(&mut self, name: &str) {
        self.harness.remove_cursor();
        // Toasts disappear at a time of their own.
        self.app_mut().toasts.clear();
        self.wait(3);
        // New panels may have resized the viewport.
        if self.app().open.is_some() {
            self.rest();
            self.until("the balls are rendered", |person| {
                let [shown, all] = person.app().material_balls.counts();
                shown == all
            });
            self.wait(2);
        }
        // The number of threads depends on the machine.
        let threads = self.harness.query_by_label_contains(" threads)").map(|node| node.rect());
        if let Some(rect) = threads {
            let screen = self.harness.ctx.content_rect();
            self.harness.mask(Rect::from_min_max(rect.min, Pos2::new(screen.max.x, rect.max.y)));
        }
        let options = SnapshotOptions::new().threshold(1.2).max_failed_pixels(60).output_path("tests/snapshots");
        self.harness.snapshot_options(name, &options);
    }
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn the_gallery() {
    let mut person = Start::new().drawn(true).size(620.0, 420.0).go();
    person.wait(12);
    person.looks_like("gallery");
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn a_scene_with_its_properties() {
    let mut person = Start::with(STILL).drawn(true).size(900.0, 600.0).go();
    person.select("sphere");
    person.select("ball");
    person.click_role(Role::TreeItem, "subtract");
    person.looks_like("scene-dark");
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn a_scene_in_light_colours() {
    let mut person = Start::with(STILL).drawn(false).size(900.0, 600.0).go();
    person.select("clay");
    person.looks_like("scene-light");
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn errors_with_the_source() {
    let mut person = Start::with(STILL).drawn(true).size(800.0, 540.0).go();
    person.rest();
    let text = STILL
        .replace("sphere 0.85", "sfere 0.85")
        .replace("material=\"slate\" { plane }", "material=\"moss\" { plane }");
    person.app_mut().edit(|open| {
        open.document.replace_text(text, "Test", None);
        Ok(())
    });
    person.key(Key::F4);
    person.looks_like("mistakes");
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn the_help_page() {
    let mut person = Start::new().drawn(true).size(680.0, 470.0).go();
    person.wait(12);
    person.key(Key::F1);
    person.looks_like("help");
}

#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn twice_as_many_pixels() {
    let start = Start { scale: 2.0, ..Start::with(STILL).drawn(false).size(480.0, 320.0) };
    let mut person = start.go();
    person.looks_like("scale-2");
}
