//! Colour ramps, and dots in the picture: control points of profiles, sizes of shapes, the cone of a spot light; and snapping to surfaces.

use super::*;
use pathmarch_render::pathmarch_scene::document::key;

/// A cup with control points, a lamp with a size, a spot light, and a block on a floor.
const TEXT: &str = r#"pathmarch 1
camera "main" { position 0 1.2 4.5; target 0 0.6 0; fov 40 }
render { size 64 48; samples 2; bounces 2 }
sky 0.6
spot { at -1 2 1; target -1 0.5 0; intensity 20; cone 40 }
material "lamp" { emit 6 }
object "cup" {
    revolve {
        curve 0.05 {
            point 0.3 0 // foot
            point 0.1 0.3
            point 0.4 0.9
        }
    }
}
object "bulb" material="lamp" { sphere 0.2 { at 1.2 1.2 0 } }
object "block" { box 0.8 0.4 0.8 { at 1.2 0.2 0 } }
object "floor" { plane }
"#;

impl Person {
    /// The picture's point of a place in world space.
    fn seen(&self, point: [f32; 3]) -> Pos2 {
        super::camera::place(&self.open().view.camera, self.picture(), point)
    }
    fn drag_dot(&mut self, index: usize, to: Pos2) {
        let from = self.app().gizmo.dot_places[index];
        self.drag(from, to, PointerButton::Primary, Modifiers::NONE);
    }
    fn number(&self, title: &str, key: &str) -> f32 {
        match self.value(title, key) {
            Value::Number(value) => value,
            other => panic!("{key} is {other:?}"),
        }
    }
}

#[test]
fn a_control_point_is_dragged_in_the_picture() {
    let mut person = Start::with(TEXT).go();
    // The object has only this profile.
    person.select("cup");
    assert_eq!(person.app().gizmo.dot_places.len(), 3);
    let to = person.seen([0.25, 0.45, 0.0]);
    person.drag_dot(1, to);
    let changed = changed_lines(TEXT, person.text());
    assert_eq!(changed.len(), 1);
    let points = person.document().control_points(&person.path("curve"));
    let [x, y] = points[1].at;
    assert!((x - 0.25).abs() < 0.02 && (y - 0.45).abs() < 0.02, "{x} {y}");
    assert!(!person.open().view.is_camera_modified(), "the drag was no orbit");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), TEXT);
}

#[test]
fn points_are_added_on_the_outline_and_removed_by_a_menu() {
    let mut person = Start::with(TEXT).go();
    person.select("curve");
    let dots = person.app().gizmo.dot_places.clone();
    // A point of the outline between the last two: found by a sweep across the middle between them.
    let middle = dots[1].lerp(dots[2], 0.5);
    let mut added = false;
    for offset in (-30..30).step_by(4) {
        let from = middle + Vec2::new(offset as f32, 0.0);
        person.hover(from);
        person.drag(from, from + Vec2::new(12.0, 6.0), PointerButton::Primary, Modifiers::NONE);
        added = person.document().control_points(&person.path("curve")).len() == 4;
        if added {
            break;
        }
        // That was an orbit, or a drag of an arrow.
        person.undo_all();
        person.key(Key::Home);
        person.select("curve");
    }
    assert!(added, "no outline was there");
    assert_eq!(person.document().control_points(&person.path("curve")).len(), 4);
    assert_eq!(person.text().lines().count(), TEXT.lines().count() + 1);
    let with_four = person.text().to_owned();
    let at = person.app().gizmo.dot_places[2];
    let menu = |person: &mut Person| {
        person.hover(at);
        person.button(at, PointerButton::Secondary, true, Modifiers::NONE);
        person.button(at, PointerButton::Secondary, false, Modifiers::NONE);
        person.wait(PAUSE);
    };
    menu(&mut person);
    person.click("Corner");
    assert_eq!(person.text().matches("corner=#true").count(), 1);
    person.ctrl(Key::Z);
    assert_eq!(person.text(), with_four);
    menu(&mut person);
    person.click("Remove point");
    assert_eq!(person.text(), TEXT);
    // A right click elsewhere has no such menu.
    let elsewhere = person.point(0.05, 0.05);
    person.hover(elsewhere);
    person.button(elsewhere, PointerButton::Secondary, true, Modifiers::NONE);
    person.button(elsewhere, PointerButton::Secondary, false, Modifiers::NONE);
    person.wait(PAUSE);
    assert!(!person.has("Remove point"));
    assert_eq!(person.undo_all(), 2, "the added point with its drag, and the removal");
}

#[test]
fn the_size_of_a_lamp_is_dragged() {
    let mut person = Start::with(TEXT).go();
    person.select("bulb");
    person.hover(person.point(0.5, 0.1));
    person.key(Key::Num3);
    assert_eq!(person.app().gizmo.dot_places.len(), 1);
    let to = person.seen([1.5, 1.2, 0.0]);
    person.drag_dot(0, to);
    let radius = person.number("sphere", "radius");
    assert!((radius - 0.3).abs() < 0.01, "{radius}");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), TEXT);
}

#[test]
fn a_spot_light_is_aimed_and_its_cone_widened_by_dots() {
    let mut person = Start::with(TEXT).go();
    person.select("spot");
    let cone = person.app().gizmo.dot_places[1];
    person.drag_dot(1, cone + Vec2::new(20.0, 0.0));
    let wider = person.number("spot", "cone");
    assert!(wider > 42.0 && wider < 80.0, "{wider}");
    person.drag_dot(0, cone);
    let Value::Triple([x, ..]) = person.value("spot", "target") else { panic!("a target") };
    assert!(x > -0.9, "{x}");
    let inner = person.app().gizmo.dot_places[2];
    let target = person.app().gizmo.dot_places[0];
    person.drag_dot(2, inner.lerp(target, 0.5));
    let blend = person.number("spot", "blend");
    assert!(blend > 0.3 && blend <= 1.0, "{blend}");
    assert_eq!(person.undo_all(), 3);
    assert_eq!(person.text(), TEXT);
}

#[test]
fn dragged_things_go_to_the_surface_under_the_pointer() {
    let mut person = Start::with(TEXT).go();
    person.select("bulb");
    person.hover(person.point(0.5, 0.1));
    person.key(Key::T);
    person.assert_said("Snap to surfaces");
    let ball = person.seen([1.2, 1.2, 0.0]);
    // The top of the block, then the floor.
    for (goal, height) in [([1.2, 0.4, 0.1], 0.6), ([-0.6, 0.0, 1.0], 0.2)] {
        let to = person.seen(goal);
        person.drag(ball, to, PointerButton::Primary, Modifiers::NONE);
        let Value::Triple([x, y, z]) = person.value("sphere", key::AT) else { panic!("a place") };
        assert!((y - height).abs() < 5e-3, "it touches the surface: {y}, not {height}");
        assert!((x - goal[0]).abs() < 0.02 && (z - goal[2]).abs() < 0.02, "{x} {z}");
        assert_eq!(person.undo_all(), 1);
        person.select("bulb");
    }
    // Arrows stay on their axes, and without the toggle the disc stays in the view plane.
    person.key(Key::T);
    person.drag(ball, person.seen([-0.6, 0.0, 1.0]), PointerButton::Primary, Modifiers::NONE);
    let Value::Triple([_, y, z]) = person.value("sphere", key::AT) else { panic!("a place") };
    assert!(y < 0.9 && z.abs() < 0.5, "{y} {z}");
    // A spot light is aimed at things.
    person.undo_all();
    person.key(Key::T);
    person.select("spot");
    let to = person.seen([1.2, 0.4, 0.1]);
    person.drag_dot(0, to);
    let Value::Triple([x, y, z]) = person.value("spot", "target") else { panic!("a target") };
    assert!((x - 1.2).abs() < 0.02 && (y - 0.4).abs() < 0.01 && (z - 0.1).abs() < 0.03, "{x} {y} {z}");
}

#[test]
fn colours_of_a_ramp_are_added_dragged_and_removed() {
    let ramp = "material \"stone\" { diffuse { marble { colour 1 0 0; colour 0 1 0; colour 0 0 1 } } }";
    let text = format!("{TEXT}{ramp}\n");
    let mut person = Start::with(&text).go();
    person.select("stone");
    let bar = |person: &Person| {
        let nodes: Vec<_> = person.harness.query_all_by_label("albedo ramp").map(|node| node.rect()).collect();
        nodes.into_iter().find(|rect| rect.width() > 100.0).expect("a bar")
    };
    let at = |person: &Person, share: f32| {
        let rect = bar(person).shrink2(Vec2::new(4.5, 0.0));
        Pos2::new(egui::lerp(rect.x_range(), share), rect.max.y - 4.0)
    };
    // The last colour towards the middle one, which stays: one step.
    let (from, to) = (at(&person, 1.0), at(&person, 0.75));
    person.drag(from, to, PointerButton::Primary, Modifiers::NONE);
    assert!(person.text().contains("colour 0 1 0 at=0.5; colour 0 0 1 at=0.7"), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
    let between = at(&person, 0.75);
    person.click_at(between, Modifiers::NONE);
    let (_, line) = changed_lines(&text, person.text())[0];
    assert!(line.contains("colour 0 1 0 at=0.5; colour 0 0.") && line.contains("; colour 0 0 1 }"), "{line}");
    assert_eq!(line.matches("colour").count(), 4);
    let third = at(&person, 0.75);
    person.hover(third);
    person.button(third, PointerButton::Secondary, true, Modifiers::NONE);
    person.button(third, PointerButton::Secondary, false, Modifiers::NONE);
    person.wait(PAUSE);
    assert_eq!(person.text(), text.replace("colour 0 1 0", "colour 0 1 0 at=0.5"));
    assert_eq!(person.undo_all(), 2);
    // A texture without colours starts a ramp.
    let plain = text.replace("marble { colour 1 0 0; colour 0 1 0; colour 0 0 1 }", "marble");
    let mut person = Start::with(&plain).go();
    person.select("stone");
    person.click("albedo colours");
    assert!(person.text().contains("diffuse { marble { colour 0.02; colour 0.9 } }"), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
}
