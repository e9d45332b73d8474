//! Viewport: camera movement, selection, focus.

use super::*;
use pathmarch_render::pathmarch_scene::Camera;
use pathmarch_render::pathmarch_scene::navigation;
use pathmarch_render::pick;

/// Window point of a world-space point.
pub(super) fn place(camera: &Camera, picture: Rect, point: [f32; 3]) -> Pos2 {
    let axes = navigation::axes(camera);
    let from = glam::Vec3::from(point) - glam::Vec3::from(camera.position);
    let scale = 0.5 * picture.height() / (0.5 * camera.fov.to_radians()).tan() / from.dot(axes.forward);
    picture.center() + Vec2::new(from.dot(axes.right), -from.dot(axes.up)) * scale
}

fn position(person: &Person) -> glam::Vec3 {
    person.open().view.camera.position.into()
}
fn target(person: &Person) -> glam::Vec3 {
    person.open().view.camera.target.into()
}

/// A point of the viewport without handles.
fn free(person: &Person) -> Pos2 {
    person.point(0.2, 0.2)
}

#[test]
fn dragging_and_the_wheel_move_the_camera_and_home_resets_it() {
    let mut person = Person::at_scene();
    let start = person.open().view.camera.clone();
    let (from, by) = (free(&person), Vec2::new(60.0, 30.0));
    let away = position(&person).distance(target(&person));
    person.drag(from, from + by, PointerButton::Primary, Modifiers::NONE);
    assert_ne!(person.open().view.camera.position, start.position);
    assert_eq!(person.open().view.camera.target, start.target, "around what it looks at");
    assert!((position(&person).distance(target(&person)) - away).abs() < 1e-3);
    person.until("the message appears", |person| person.has("Free view"));
    person.hover(from);
    person.key(Key::Home);
    assert_eq!(person.open().view.camera, start);
    assert!(!person.has("Free view"));
    person.drag(from, from + by, PointerButton::Secondary, Modifiers::NONE);
    assert_eq!(person.open().view.camera.position, start.position, "it looks around");
    assert_ne!(person.open().view.camera.target, start.target);
    person.key(Key::Home);
    for (button, modifiers) in [(PointerButton::Middle, Modifiers::NONE), (PointerButton::Primary, Modifiers::SHIFT)] {
        person.drag(from, from + by, button, modifiers);
        let moved =
            (position(&person) - glam::Vec3::from(start.position), target(&person) - glam::Vec3::from(start.target));
        assert!(moved.0.length() > 0.1 && moved.0.distance(moved.1) < 1e-4, "both move: {moved:?}");
        person.key(Key::Home);
    }
    person.hover(from);
    person.harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    person.wait(20);
    assert!(position(&person).distance(target(&person)) < away - 0.05, "up is nearer");
    assert_eq!(person.open().view.camera.target, start.target);
    assert_eq!(person.text(), SCENE, "none of that changes the scene");
}

#[test]
fn keys_fly() {
    let mut person = Person::at_scene();
    let at = free(&person);
    let (ahead, right, up) = {
        let axes = navigation::axes(&person.open().view.camera);
        (axes.forward, axes.right, axes.up)
    };
    for (key, towards) in
        [(Key::W, ahead), (Key::S, -ahead), (Key::D, right), (Key::A, -right), (Key::E, up), (Key::Q, -up)]
    {
        person.hover(at);
        let before = position(&person);
        person.harness.key_down(key);
        person.wait(4);
        person.harness.key_up(key);
        person.wait(2);
        let went = position(&person) - before;
        assert!(went.length() > 0.01 && went.normalize().dot(towards) > 0.999, "{key:?}: {went}");
        let after = position(&person);
        person.wait(3);
        assert_eq!(position(&person), after, "released");
        person.key(Key::Home);
    }
    // Not while text is typed, nor with Ctrl.
    person.ctrl(Key::D);
    assert_eq!(person.open().view.camera.position, [0.0, 1.2, 4.5]);
}

#[test]
fn the_camera_is_written_to_the_scene_and_the_picture_keeps_its_size() {
    let mut person = Person::at_scene();
    person.rest();
    let size = person.open().view.picture.as_ref().expect("a picture").2;
    let from = free(&person);
    person.drag(from, from + Vec2::new(40.0, 0.0), PointerButton::Primary, Modifiers::NONE);
    let camera = person.open().view.camera.clone();
    person.ctrl(Key::K);
    let changed = changed_lines(SCENE, person.text());
    assert_eq!(changed.len(), 1, "{changed:?}");
    assert!(changed[0].1.starts_with("camera \"main\" {"), "{changed:?}");
    let written = person.scene().cameras[0].clone();
    assert!(glam::Vec3::from(written.position).distance(camera.position.into()) < 1e-3, "{written:?} for {camera:?}");
    assert!(!person.open().view.is_camera_modified());
    assert_eq!(person.scene().render.size, (64, 48));
    person.rest();
    assert_eq!(person.open().view.picture.as_ref().expect("a picture").2, size);
    person.ctrl(Key::Z);
    assert_eq!(person.text(), SCENE);
    assert_eq!(person.open().view.camera.position, [0.0, 1.2, 4.5], "the view follows");
}

#[test]
fn cameras_are_changed() {
    let mut person = Person::at_scene();
    person.key(Key::C);
    assert_eq!(person.open().view.camera_name(), "other");
    assert_eq!(person.open().view.camera, person.scene().cameras[1]);
    person.menu("Camera", "Next camera");
    assert_eq!(person.open().view.camera_name(), "main");
}

#[test]
fn a_click_selects_what_is_there() {
    let mut person = Person::at_scene();
    let mut titles = std::collections::BTreeSet::new();
    for (x, y) in [(0.5, 0.6), (0.5, 0.95), (0.5, 0.05), (0.8, 0.62), (0.1, 0.9), (0.77, 0.7)] {
        person.key(Key::Escape);
        let at = person.point(x, y);
        let expected = {
            let settings = App::settings(person.open(), person.scene());
            let [width, height] = settings.size.map(|side| side as f32);
            let picked = pick(person.scene(), &settings, [x * width, y * height]);
            picked.and_then(|picked| person.document().path_of_leaf(picked.leaf))
        };
        person.click_at(at, Modifiers::NONE);
        assert_eq!(person.open().view.selection.active().cloned(), expected, "at {x} {y}");
        titles.insert(person.selected().unwrap_or_default());
    }
    assert!(titles.len() >= 3, "too little was seen: {titles:?}");
}

#[test]
fn alt_and_click_or_the_key_set_the_focus() {
    let mut person = Person::at_scene();
    let at = person.point(0.5, 0.6);
    let depth = {
        let settings = App::settings(person.open(), person.scene());
        let [width, height] = settings.size.map(|side| side as f32);
        pick(person.scene(), &settings, [0.5 * width, 0.6 * height]).expect("the ball").depth
    };
    assert_eq!(person.open().view.camera.focus, None);
    person.click_at(at, Modifiers::ALT);
    let focus = person.open().view.camera.focus.expect("set");
    assert!((focus - depth).abs() < 1e-3, "{focus} for {depth}");
    assert_eq!(person.selected(), None, "and selects nothing");
    person.assert_said("Focus distance");
    person.key(Key::Home);
    person.key(Key::X);
    assert!(person.open().view.focus_click);
    person.click_at(at, Modifiers::NONE);
    assert!(person.open().view.camera.focus.is_some() && !person.open().view.focus_click);
    person.click_at(person.point(0.5, 0.02), Modifiers::ALT);
    person.assert_said("nothing to focus on");
}

#[test]
fn a_double_click_aims_the_camera_and_f_frames_the_selection() {
    let mut person = Person::at_scene();
    let at = person.point(0.3, 0.9);
    person.hover(at);
    for pressed in [true, false, true, false] {
        person.button(at, PointerButton::Primary, pressed, Modifiers::NONE);
    }
    person.wait(PAUSE);
    let [x, y, _] = person.open().view.camera.target;
    assert!(x < -0.1 && y.abs() < 0.01, "a point of the floor: {x} {y}");
    assert_eq!(person.open().view.camera.position, [0.0, 1.2, 4.5]);
    person.select("sphere");
    person.key(Key::F);
    assert!(target(&person).distance(glam::Vec3::new(0.0, 0.7, 0.0)) < 1e-3);
    person.select("plane");
    person.key(Key::F);
    person.assert_said("no finite size");
}

#[test]
fn non_finite_camera_values_are_rejected() {
    let mut person = Person::at_scene();
    let camera = person.open().view.camera.clone();
    for label in ["field of view", "exposure", "lens radius"] {
        for text in ["nan", "inf", "-inf"] {
            person.type_number(label, text);
            assert_eq!(person.open().view.camera, camera, "{label} {text}");
        }
    }
    person.type_number("exposure", "1e9");
    assert_eq!(person.open().view.camera.exposure, 100.0);
}
