//! Comparison, final renders, help, and unusual window sizes.

use super::*;
use crate::window::app::actions::{ACTIONS, POINTER};
use crate::window::app::dialog::Dialog;
use pathmarch_render::{Mode, Renderer, Settings};

#[test]
fn a_stored_picture_is_compared_along_a_dragged_line() {
    let mut person = Person::at_scene();
    person.rest();
    person.ctrl(Key::B);
    let split =
        |person: &Person| person.open().view.comparison.as_ref().filter(|kept| kept.shown).map(|kept| kept.split);
    assert_eq!(split(&person), Some(0.5));
    person.assert_said("Picture stored");
    let camera = person.open().view.camera.clone();
    person.drag(person.point(0.5, 0.1), person.point(0.25, 0.1), PointerButton::Primary, Modifiers::NONE);
    let moved = split(&person).expect("shown");
    assert!((moved - 0.25).abs() < 0.02, "{moved}");
    assert_eq!(person.open().view.camera, camera, "the camera stays");
    person.drag(
        person.point(0.25, 0.1),
        person.picture().left_top() - Vec2::splat(50.0),
        PointerButton::Primary,
        Modifiers::NONE,
    );
    assert_eq!(split(&person), Some(0.0), "not out of the picture");
    person.key(Key::B);
    assert_eq!(split(&person), None);
    person.key(Key::B);
    assert_eq!(split(&person), Some(0.0));
}

#[test]
fn the_help_lists_every_action() {
    let mut person = Start::new().size(1000.0, 1500.0).go();
    person.key(Key::F1);
    person.wait(3);
    for entry in ACTIONS {
        assert!(person.has(entry.doc), "{}", entry.name);
        if let Some(shortcut) = &entry.shortcut {
            assert!(person.has(&person.harness.ctx.format_shortcut(shortcut)), "{}", entry.name);
        }
    }
    for (what, does) in POINTER {
        assert!(person.has(what) && person.has(does), "{what}");
    }
    person.key(Key::F1);
    assert!(!person.has(ACTIONS[0].doc));
}

#[test]
fn every_action_is_in_its_menu_and_harmless_without_a_scene() {
    let mut person = Start::new().go();
    for entry in ACTIONS {
        person.click_role(Role::Button, entry.menu.name());
        let starts = |node: &egui_kittest::kittest::AccessKitNode<'_>| {
            node.label().is_some_and(|label| label.starts_with(entry.name))
        };
        assert!(person.harness.query_all_by(starts).next().is_some(), "{}", entry.name);
        person.key(Key::Escape);
        if entry.needs_scene {
            let ctx = person.harness.ctx.clone();
            person.app_mut().run_action(&ctx, entry.action);
            person.wait(1);
            assert!(person.app().open.is_none());
            person.app_mut().file_dialog = None;
            person.app_mut().dialog = None;
        }
    }
}

#[test]
fn modes_are_shown() {
    let mut person = Person::at_scene();
    person.rest();
    let codes = |person: &Person| person.app().live.picture().expect("a picture").codes.clone();
    let light = codes(&person);
    person.key(Key::P);
    assert_eq!(person.open().view.mode, Mode::Preview);
    person.rest();
    assert!(codes(&person) != light);
    person.key(Key::P);
    person.rest();
    assert!(codes(&person) == light, "the CPU renders the same twice");
}

#[test]
fn a_final_render_is_that_of_the_renderer() {
    let mut person = Person::at_scene();
    person.rest();
    person.ctrl(Key::R);
    assert!(person.has("Render to file"));
    let output = person.file().with_file_name("final.exr");
    person.fill(Role::TextInput, "file", &output.display().to_string());
    person.click("Start");
    assert!(person.app().dialog.is_none());
    person.until("it is written", |person| person.messages().iter().any(|message| message.contains("Wrote")));
    let settings = Settings::of(person.scene());
    let film = Renderer::open(Backend::Cpu, None).expect("a CPU").render(person.scene(), &settings).expect("rendered");
    let written = pathmarch_render::image::load(&output).expect("read");
    let expected = film.mean();
    assert_eq!((written.picture.width, written.picture.height), (64, 48));
    assert!(written.picture.pixels == expected.pixels, "bit for bit");
}

#[test]
fn a_render_with_a_bad_name_does_not_start() {
    let mut person = Person::at_scene();
    person.ctrl(Key::R);
    person.fill(Role::TextInput, "file", "/nowhere/at/all.png");
    person.click("Start");
    assert!(person.app().renders.is_empty() && matches!(person.app().dialog, Some(Dialog::Render(_))));
    person.assert_said("does not exist");
    person.fill(Role::TextInput, "file", "a.txt");
    person.click("Start");
    assert!(person.app().renders.is_empty());
    person.key(Key::Escape);
    assert!(person.app().dialog.is_none());
}

#[test]
fn the_displayed_picture_is_saved() {
    let mut person = Person::at_scene();
    // At the size of the final render.
    person.app_mut().open.as_mut().expect("open").view.resolution =
        crate::window::open_scene::view_state::Resolution::Scene;
    person.wait(2);
    person.rest();
    person.ctrl(Key::E);
    person.fill(Role::TextInput, "Name", "shown.exr");
    person.assert_said("Wrote");
    let written = pathmarch_render::image::load(&person.file().with_file_name("shown.exr")).expect("read");
    let settings = Settings::of(person.scene());
    let film = Renderer::open(Backend::Cpu, None).expect("a CPU").render(person.scene(), &settings).expect("rendered");
    assert!(written.picture.pixels == film.mean().pixels, "bit for bit");
}

#[test]
fn windows_of_odd_sizes_and_scales_hold() {
    let mut person = Person::at_scene();
    person.select("sphere");
    for key in [Key::F4, Key::F5, Key::F1] {
        person.key(key);
    }
    person.rest();
    person.ctrl(Key::B);
    for (width, height) in [
        (1.0, 1.0),
        (2.0, 900.0),
        (900.0, 2.0),
        (60.0, 40.0),
        (200.0, 120.0),
        (480.0, 320.0),
        (0.0, 0.0),
        (3000.0, 90.0),
        (1000.0, 700.0),
    ] {
        for scale in [1.0, 2.0, 0.5, 1.25] {
            person.harness.set_size(Vec2::new(width, height)).set_pixels_per_point(scale);
            person.wait(3);
            person.hover(Pos2::new(0.5 * width, 0.5 * height));
            person.click_at(Pos2::new(0.6 * width, 0.6 * height), Modifiers::NONE);
        }
    }
    let sharp = Start { scale: 2.0, ..Start::with(SCENE) }.go();
    assert_eq!(sharp.harness.ctx.pixels_per_point(), 2.0);
    let [width, height] = sharp.open().view.picture_size(sharp.scene());
    let points = sharp.picture().size();
    assert!((width as f32 - 2.0 * points.x).abs() <= 2.0 && (height as f32 - 2.0 * points.y).abs() <= 2.0);
}

#[test]
fn restarting_the_graphics_asks_for_a_new_device_once() {
    let mut person = Person::at_scene();
    person.rest();
    person.ctrl_shift(Key::F12);
    assert!(person.app_mut().take_device_reset());
    assert!(!person.app_mut().take_device_reset());
    person.rest();
}

#[test]
fn panels_selection_and_comments_leave_the_picture_alone() {
    let mut person = Person::at_scene();
    person.rest();
    let serial = |person: &Person| person.open().view.picture.as_ref().map(|(_, serial, size)| (*serial, *size));
    let before = serial(&person);
    person.select("sphere");
    person.key(Key::F4);
    person.wait(3);
    person.app_mut().edit(|open| {
        let text = format!("// A comment.\n\n{}", open.document.text());
        open.document.replace_text(text, "Test", None);
        Ok(())
    });
    person.wait(3);
    assert!(person.app().live.status().resting);
    assert_eq!(serial(&person), before, "the same picture");
    // A mistake covers the picture, and does not resize it.
    let area = |person: &Person| person.harness.get_by_role_and_label(Role::Image, "Viewport").rect();
    let before_mistake = area(&person);
    person.app_mut().edit(|open| {
        let text = format!("{}\nobject \"x\" {{ sfere }}\n", open.document.text());
        open.document.replace_text(text, "Test", None);
        Ok(())
    });
    person.wait(3);
    assert!(person.has("1 error"));
    assert_eq!((serial(&person), area(&person)), (before, before_mistake));
}

#[test]
fn the_picture_fills_the_window_until_escape() {
    let mut person = Person::at_scene();
    person.key(Key::F11);
    assert!(!person.has("Scene") && person.picture().width() > 850.0, "{:?}", person.picture());
    person.key(Key::Escape);
    assert!(person.has("Scene"));
    person.key(Key::F1);
    assert!(person.app().help);
    person.key(Key::Escape);
    assert!(!person.app().help, "Escape closes the help");
}
