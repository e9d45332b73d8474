//! Tests of catching and dragging handles.

use super::drag::Drag;
use super::shape::{Axis, Gizmo, OUTER, Part, SIZE};
use super::transform::Placed;
use super::*;
use egui::Vec2;
use glam::DQuat;

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const PICTURE: Rect = Rect { min: Pos2::new(10.0, 20.0), max: Pos2::new(810.0, 620.0) };

fn seen_from(position: [f32; 3], target: [f32; 3], up: [f32; 3]) -> Projection {
    let camera = Camera {
        name: "main".to_owned(),
        position,
        target,
        up,
        fov: 40.0,
        lens_radius: 0.0,
        focus: None,
        exposure: 0.0,
    };
    Projection::new(&camera, PICTURE)
}

/// From a corner, so that every axis and plane is seen.
fn from_corner() -> Projection {
    seen_from([3.0, 2.5, 4.0], [0.1, 0.3, 0.0], [0.0, 1.0, 0.0])
}

fn start() -> Placed {
    Placed { scale: 1.5, turn: DQuat::from_rotation_x(0.4), at: DVec3::new(0.2, 0.4, -0.3) }
}

fn gizmo(projection: Projection) -> Gizmo {
    Gizmo::new(projection, start().at).expect("before the camera")
}

fn all_parts() -> Vec<Part> {
    [Handles::Move, Handles::Turn, Handles::Scale].iter().flat_map(|kind| Part::of(*kind).iter().copied()).collect()
}

/// A point of the world at which a handle can be caught.
fn grip(gizmo: &Gizmo, part: Part) -> DVec3 {
    let outer = gizmo.origin + gizmo.projection.right * (OUTER * gizmo.metres);
    match part {
        Part::Arrow(axis) => gizmo.arrow(axis).iter().sum::<DVec3>() / 2.0,
        Part::Square(axis) => gizmo.square(axis).iter().sum::<DVec3>() / 4.0,
        Part::Disc => gizmo.origin + gizmo.projection.up * (5.0 * gizmo.metres),
        Part::Ring(axis) => {
            let ring = gizmo.ring(axis, false);
            ring[ring.len() / 3][0]
        }
        Part::ViewRing | Part::ScaleRing => outer,
    }
}

fn place(gizmo: &Gizmo, point: DVec3) -> Pos2 {
    gizmo.projection.place(point).expect("before the camera")
}

/// Drags a handle from where it can be caught through points of the world.
#[track_caller]
fn dragged(gizmo: &Gizmo, part: Part, through: &[DVec3], snapping: bool) -> Placed {
    let mut drag = Drag::begin(gizmo, part, start(), place(gizmo, grip(gizmo, part))).expect("caught");
    let mut result = None;
    for to in through {
        result = drag.to(&gizmo.projection, place(gizmo, *to), snapping);
    }
    result.expect("a result")
}

#[track_caller]
fn assert_moved(new: Placed, by: DVec3) {
    let expected = Placed { at: start().at + by, ..start() };
    assert!(new.at.distance(expected.at) < 1e-4, "{new:?} for {expected:?}");
    assert_eq!((new.scale, new.turn), (expected.scale, expected.turn), "nothing else changes");
}

#[track_caller]
fn assert_turned(new: Placed, axis: DVec3, degrees: f64) {
    let expected = DQuat::from_axis_angle(axis, degrees.to_radians()) * start().turn;
    let apart = new.turn.angle_between(expected).to_degrees();
    assert!(apart < 0.05, "{apart}° from {degrees}°");
    assert_eq!((new.scale, new.at), (start().scale, start().at), "nothing else changes");
}

#[test]
fn arrows_squares_and_the_disc_move_by_what_the_pointer_moves() {
    let gizmo = gizmo(from_corner());
    for axis in AXES {
        let part = Part::Arrow(axis);
        for metres in [0.37, -1.2] {
            let by = axis.unit() * metres;
            assert_moved(dragged(&gizmo, part, &[grip(&gizmo, part) + by], false), by);
        }
        // Beside the arrow it follows the nearest point of its axis.
        let by = axis.unit() * 0.25;
        let [from, to] = [grip(&gizmo, part), grip(&gizmo, part) + by];
        let beside = axis.unit().cross(gizmo.towards).normalize() * 0.3;
        let new = dragged(&gizmo, part, &[to + beside], false);
        assert!(new.at.distance(start().at + (to - from)) < 0.1, "{new:?}");
        let [u, v] = axis.others();
        let (part, by) = (Part::Square(axis), u * 0.31 - v * 0.18);
        assert_moved(dragged(&gizmo, part, &[grip(&gizmo, part) + by], false), by);
    }
    let by = gizmo.projection.right * 0.4 - gizmo.projection.up * 0.1;
    assert_moved(dragged(&gizmo, Part::Disc, &[grip(&gizmo, Part::Disc) + by], false), by);
}

/// A point that goes round an axis through the node.
fn round(gizmo: &Gizmo, part: Part, axis: DVec3, degrees: f64) -> DVec3 {
    let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
    gizmo.origin + turn * (grip(gizmo, part) - gizmo.origin)
}

#[test]
fn rings_turn_by_the_angle_that_the_pointer_goes_round() {
    let gizmo = gizmo(from_corner());
    let rings = AXES.map(|axis| (Part::Ring(axis), axis.unit()));
    for (part, axis) in rings.into_iter().chain([(Part::ViewRing, -gizmo.projection.forward)]) {
        for degrees in [25.0, -70.0] {
            assert_turned(dragged(&gizmo, part, &[round(&gizmo, part, axis, degrees)], false), axis, degrees);
        }
        // Whole turns are counted.
        let through: Vec<_> = (1..=10).map(|k| round(&gizmo, part, axis, 40.0 * f64::from(k))).collect();
        assert_turned(dragged(&gizmo, part, &through, false), axis, 400.0);
        let mut drag = Drag::begin(&gizmo, part, start(), place(&gizmo, grip(&gizmo, part))).expect("caught");
        for to in through {
            drag.to(&gizmo.projection, place(&gizmo, to), false);
        }
        let (_, _, total) = drag.sector().expect("a sector");
        assert!((total.to_degrees() - 400.0).abs() < 0.1, "{total}");
    }
}

#[test]
fn a_ring_seen_from_its_edge_rolls_with_the_pointer() {
    let at = start().at.as_vec3();
    let projection = seen_from([at.x, at.y, at.z + 5.0], at.to_array(), [0.0, 1.0, 0.0]);
    let gizmo = gizmo(projection);
    let part = Part::Ring(Axis::Y);
    let from = gizmo.middle;
    assert_eq!(gizmo.pick(Part::of(Handles::Turn), from + Vec2::new(20.0, 0.0)), Some(part));
    let mut drag = Drag::begin(&gizmo, part, start(), from).expect("caught");
    let new = drag.to(&projection, from + Vec2::new(SIZE as f32, 0.0), false).expect("a result");
    assert_turned(new, DVec3::Y, 1_f64.to_degrees());
    // Across its line it does not turn.
    let new = drag.to(&projection, from + Vec2::new(0.0, 60.0), false).expect("a result");
    assert_turned(new, DVec3::Y, 0.0);
}

#[test]
fn the_ring_of_scale_scales_by_the_distance_from_the_middle() {
    let gizmo = gizmo(from_corner());
    let out = |factor: f64| gizmo.origin + (grip(&gizmo, Part::ScaleRing) - gizmo.origin) * factor;
    for factor in [0.5, 1.0, 2.5] {
        let new = dragged(&gizmo, Part::ScaleRing, &[out(1.3), out(factor)], false);
        assert!((new.scale / start().scale - factor).abs() < 1e-4, "{new:?}");
        assert_eq!((new.turn, new.at), (start().turn, start().at));
    }
    let none = dragged(&gizmo, Part::ScaleRing, &[gizmo.origin], false);
    assert!(none.scale > 0.0, "a node never vanishes");
}

#[test]
fn with_ctrl_steps_are_round() {
    let gizmo = gizmo(from_corner());
    let part = Part::Arrow(Axis::Y);
    assert_moved(dragged(&gizmo, part, &[grip(&gizmo, part) + DVec3::Y * 0.37], true), DVec3::Y * 0.4);
    let part = Part::Square(Axis::Y);
    let to = grip(&gizmo, part) + DVec3::new(0.13, 0.0, -0.26);
    assert_moved(dragged(&gizmo, part, &[to], true), DVec3::new(0.1, 0.0, -0.3));
    let part = Part::Ring(Axis::Z);
    let to = round(&gizmo, part, DVec3::Z, 42.0);
    assert_turned(dragged(&gizmo, part, &[to], true), DVec3::Z, 40.0);
    let out = |factor: f64| gizmo.origin + (grip(&gizmo, Part::ScaleRing) - gizmo.origin) * factor;
    for (factor, expected) in [(1.27, 1.3), (0.01, 0.1)] {
        let new = dragged(&gizmo, Part::ScaleRing, &[out(factor)], true);
        assert!((new.scale / start().scale - expected).abs() < 1e-9, "{new:?}");
    }
}

#[test]
fn nothing_jumps_when_a_drag_starts() {
    let gizmo = gizmo(from_corner());
    for part in all_parts() {
        // Also where it is caught beside its line.
        for off in [Vec2::ZERO, Vec2::new(4.0, -3.0), Vec2::new(-3.0, 4.0)] {
            let at = place(&gizmo, grip(&gizmo, part)) + off;
            let mut drag = Drag::begin(&gizmo, part, start(), at).expect("caught");
            assert!(drag.to(&gizmo.projection, at, false).is_none(), "{part:?}: a press is no change");
            let new = drag.to(&gizmo.projection, at + Vec2::new(0.01, 0.0), false).expect("a result");
            assert!(
                new.at.distance(start().at) < 1e-3 && (new.scale - start().scale).abs() < 1e-3,
                "{part:?}: {new:?}"
            );
            assert!(new.turn.angle_between(start().turn) < 1e-2, "{part:?}: {new:?}");
            // Back where it was caught, it is where it was.
            let new = drag.to(&gizmo.projection, at, false).expect("a result");
            assert!(
                new.at.distance(start().at) < 1e-9 && (new.scale - start().scale).abs() < 1e-9,
                "{part:?}: {new:?}"
            );
        }
    }
}

#[test]
fn every_handle_is_caught_where_it_is_and_not_far_from_it() {
    let gizmo = gizmo(from_corner());
    for kind in [Handles::Move, Handles::Turn, Handles::Scale] {
        for part in Part::of(kind) {
            let at = place(&gizmo, grip(&gizmo, *part));
            assert_eq!(gizmo.pick(Part::of(kind), at), Some(*part));
            assert_eq!(gizmo.pick(&[*part], at + Vec2::splat(150.0)), None);
        }
    }
    // A few points beside a line, and no more.
    let [start, end] = gizmo.arrow(Axis::X).map(|end| place(&gizmo, end));
    let across = (end - start).normalized().rot90();
    let pick = |points: f32| gizmo.pick(&[Part::Arrow(Axis::X)], start.lerp(end, 0.5) + across * points);
    assert_eq!((pick(6.5), pick(-6.5)), (Some(Part::Arrow(Axis::X)), Some(Part::Arrow(Axis::X))));
    assert_eq!((pick(7.5), pick(-7.5)), (None, None));
}

#[test]
fn of_handles_in_one_place_the_front_one_is_caught() {
    let at = start().at.as_vec3();
    for (sign, front) in [(1.0, Axis::X), (-1.0, Axis::Y)] {
        // Seen from here, x and y are one line.
        let position = (at + glam::Vec3::new(4.0, -4.0, 0.0) * sign).to_array();
        let gizmo = gizmo(seen_from([position[0], position[1], position[2] + 0.3], at.to_array(), [0.0, 0.0, 1.0]));
        let [x, y] = [Axis::X, Axis::Y].map(|axis| place(&gizmo, grip(&gizmo, Part::Arrow(axis))));
        assert!(x.distance(y) < 8.0, "{x:?} {y:?}");
        let middle = gizmo.pick(Part::of(Handles::Move), x.lerp(y, 0.5));
        assert_eq!(middle, Some(Part::Arrow(front)));
    }
    // Behind its middle a ring is neither seen nor caught.
    let gizmo = gizmo(from_corner());
    let whole = gizmo.ring(Axis::Y, true);
    let behind = whole.iter().min_by(|a, b| {
        let depth = |ends: &[DVec3; 2]| (ends[0] - gizmo.origin).dot(gizmo.towards);
        depth(a).total_cmp(&depth(b))
    });
    let behind = place(&gizmo, behind.expect("a ring")[0]);
    assert_eq!(gizmo.pick(&[Part::Ring(Axis::Y)], behind), None);
    assert!(gizmo.ring(Axis::Y, false).len() < whole.len());
}

#[test]
fn what_is_seen_from_its_end_or_edge_is_not_caught() {
    let at = start().at.as_vec3();
    let projection = seen_from([at.x, at.y, at.z + 5.0], at.to_array(), [0.0, 1.0, 0.0]);
    let gizmo = gizmo(projection);
    let hidden = [Part::Arrow(Axis::Z), Part::Square(Axis::X), Part::Square(Axis::Y)];
    for part in Part::of(Handles::Move) {
        assert_eq!(gizmo.opacity(*part) == 0.0, hidden.contains(part), "{part:?}");
    }
    for part in hidden {
        let grip = place(&gizmo, grip(&gizmo, part));
        assert_eq!(gizmo.pick(&[part], grip), None, "{part:?}");
    }
    assert_eq!(gizmo.pick(Part::of(Handles::Move), gizmo.middle), Some(Part::Disc));
    // And what comes to be seen so while it is held stays where it is.
    let side = super::tests::gizmo(from_corner());
    let mut drag =
        Drag::begin(&side, hidden[0], start(), place(&side, super::tests::grip(&side, hidden[0]))).expect("caught");
    assert_eq!(drag.to(&projection, gizmo.middle, false), None);
}

#[test]
fn handles_behind_the_camera_are_neither_drawn_nor_caught() {
    let at = start().at.as_vec3();
    let away = seen_from([at.x, at.y, at.z + 1.0], [at.x, at.y, at.z + 2.0], [0.0, 1.0, 0.0]);
    assert!(Gizmo::new(away, start().at).is_none());
    // Nor does one that is held follow the pointer when the camera has passed it.
    let gizmo = gizmo(from_corner());
    for part in all_parts() {
        let from = place(&gizmo, grip(&gizmo, part));
        let mut drag = Drag::begin(&gizmo, part, start(), from).expect("caught");
        assert_eq!(drag.to(&away, PICTURE.center() + Vec2::new(80.0, 30.0), false), None, "{part:?}");
    }
    // Parts that reach behind a camera with a wide view are left out, and the others are there.
    let camera = Camera {
        name: "wide".to_owned(),
        position: [at.x, at.y + 0.5, at.z + 0.5],
        target: at.to_array(),
        up: [0.0, 1.0, 0.0],
        fov: 172.0,
        lens_radius: 0.0,
        focus: None,
        exposure: 0.0,
    };
    let wide = super::tests::gizmo(Projection::new(&camera, PICTURE));
    assert_eq!(wide.projection.place(wide.arrow(Axis::Z)[1]), None);
    assert_eq!(wide.pick(&[Part::Arrow(Axis::Z)], wide.middle + Vec2::new(0.0, 30.0)), None);
    assert_eq!(wide.pick(Part::of(Handles::Move), wide.middle), Some(Part::Disc));
}

#[test]
fn a_pointer_catches_holds_and_lets_go() {
    let document =
        Document::new("a.kdl", "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" { sphere }");
    let path = document.path_of_leaf(0).expect("the sphere");
    let parts = Part::of(Handles::Move);
    let gizmo = gizmo(from_corner());
    let at = place(&gizmo, grip(&gizmo, Part::Arrow(Axis::X)));
    let mut handle = Handle::default();
    let over = Pointer { position: at, hovered: true, pressed_at: None, down: false };
    assert_eq!(handle.follow(parts, Some(&gizmo), &path, start(), Some(over)), Some(Part::Arrow(Axis::X)));
    assert!(handle.held.is_none());
    // What happens within a frame counts from where the button was pressed.
    let far = at + Vec2::splat(90.0);
    let press = Pointer { position: far, pressed_at: Some(at), down: true, ..over };
    handle.follow(parts, Some(&gizmo), &path, start(), Some(press));
    let holds = |handle: &Handle| handle.held.as_ref().map(|(_, drag)| drag.part);
    assert_eq!(holds(&handle), Some(Part::Arrow(Axis::X)));
    let hold = Pointer { position: far, hovered: false, pressed_at: None, down: true };
    handle.follow(parts, Some(&gizmo), &path, start(), Some(hold));
    assert_eq!(holds(&handle), Some(Part::Arrow(Axis::X)));
    handle.follow(parts, Some(&gizmo), &path, start(), Some(Pointer { down: false, ..hold }));
    assert_eq!(holds(&handle), None);
    // A button that is pressed elsewhere catches nothing on its way over a handle.
    handle.follow(parts, Some(&gizmo), &path, start(), Some(Pointer { position: at, ..hold }));
    assert_eq!(holds(&handle), None);
    // Nothing is caught where nothing is before the camera.
    let press = Pointer { position: at, ..press };
    assert_eq!(handle.follow(parts, None, &path, start(), Some(press)), None);
    assert_eq!(holds(&handle), None);
}
