//! Tests of picking and dragging handles.

use super::drag::Drag;
use super::shape::{Axis, Gizmo, Handle, OUTER_RADIUS, SIZE};
use super::transform::Transform;
use super::*;
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
        auto_exposure: false,
    };
    Projection::new(&camera, PICTURE)
}

/// View from a corner, in which every axis and plane is visible.
fn from_corner() -> Projection {
    seen_from([3.0, 2.5, 4.0], [0.1, 0.3, 0.0], [0.0, 1.0, 0.0])
}

fn start() -> Transform {
    Transform { scale: 1.5, rotation: DQuat::from_rotation_x(0.4), translation: DVec3::new(0.2, 0.4, -0.3) }
}

fn gizmo(projection: Projection) -> Gizmo {
    Gizmo::new(projection, start().translation).expect("before the camera")
}

fn all_parts() -> Vec<Handle> {
    [GizmoMode::Move, GizmoMode::Rotate, GizmoMode::Scale]
        .iter()
        .flat_map(|kind| Handle::of(*kind).iter().copied())
        .collect()
}

/// A world-space point at which a handle can be grabbed.
fn grip(gizmo: &Gizmo, handle: Handle) -> DVec3 {
    let outer = gizmo.origin + gizmo.projection.right * (OUTER_RADIUS * gizmo.metres_per_point);
    match handle {
        Handle::Arrow(axis) => gizmo.arrow(axis).iter().sum::<DVec3>() / 2.0,
        Handle::PlaneSquare(axis) => gizmo.square(axis).iter().sum::<DVec3>() / 4.0,
        Handle::Disc => gizmo.origin + gizmo.projection.up * (5.0 * gizmo.metres_per_point),
        Handle::Ring(axis) => {
            let ring = gizmo.ring(axis, false);
            ring[ring.len() / 3][0]
        }
        Handle::ViewRing | Handle::ScaleRing => outer,
    }
}

fn place(gizmo: &Gizmo, point: DVec3) -> Pos2 {
    gizmo.projection.project(point).expect("before the camera")
}

/// Drags a handle through world-space points.
#[track_caller]
fn dragged(gizmo: &Gizmo, handle: Handle, through: &[DVec3], snapping: bool) -> Transform {
    let mut drag = Drag::begin(gizmo, handle, start(), place(gizmo, grip(gizmo, handle))).expect("caught");
    let mut result = None;
    for to in through {
        result = drag.to(&gizmo.projection, place(gizmo, *to), snapping);
    }
    result.expect("a result")
}

#[track_caller]
fn assert_moved(new: Transform, by: DVec3) {
    let expected = Transform { translation: start().translation + by, ..start() };
    assert!(new.translation.distance(expected.translation) < 1e-4, "{new:?} for {expected:?}");
    assert_eq!((new.scale, new.rotation), (expected.scale, expected.rotation), "nothing else changes");
}

#[track_caller]
fn assert_turned(new: Transform, axis: DVec3, degrees: f64) {
    let expected = DQuat::from_axis_angle(axis, degrees.to_radians()) * start().rotation;
    let apart = new.rotation.angle_between(expected).to_degrees();
    assert!(apart < 0.05, "{apart}° from {degrees}°");
    assert_eq!((new.scale, new.translation), (start().scale, start().translation), "nothing else changes");
}

#[test]
fn arrows_squares_and_the_disc_move_by_what_the_pointer_moves() {
    let gizmo = gizmo(from_corner());
    for axis in AXES {
        let handle = Handle::Arrow(axis);
        for metres in [0.37, -1.2] {
            let by = axis.unit() * metres;
            assert_moved(dragged(&gizmo, handle, &[grip(&gizmo, handle) + by], false), by);
        }
        // Beside the arrow, it follows the closest point of its axis.
        let by = axis.unit() * 0.25;
        let [from, to] = [grip(&gizmo, handle), grip(&gizmo, handle) + by];
        let beside = axis.unit().cross(gizmo.to_camera).normalize() * 0.3;
        let new = dragged(&gizmo, handle, &[to + beside], false);
        assert!(new.translation.distance(start().translation + (to - from)) < 0.1, "{new:?}");
        let [u, v] = axis.others();
        let (handle, by) = (Handle::PlaneSquare(axis), u * 0.31 - v * 0.18);
        assert_moved(dragged(&gizmo, handle, &[grip(&gizmo, handle) + by], false), by);
    }
    let by = gizmo.projection.right * 0.4 - gizmo.projection.up * 0.1;
    assert_moved(dragged(&gizmo, Handle::Disc, &[grip(&gizmo, Handle::Disc) + by], false), by);
}

/// A point that moves around an axis through the node.
fn round(gizmo: &Gizmo, handle: Handle, axis: DVec3, degrees: f64) -> DVec3 {
    let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
    gizmo.origin + turn * (grip(gizmo, handle) - gizmo.origin)
}

#[test]
fn rings_turn_by_the_angle_that_the_pointer_goes_round() {
    let gizmo = gizmo(from_corner());
    let rings = AXES.map(|axis| (Handle::Ring(axis), axis.unit()));
    for (handle, axis) in rings.into_iter().chain([(Handle::ViewRing, -gizmo.projection.forward)]) {
        for degrees in [25.0, -70.0] {
            assert_turned(dragged(&gizmo, handle, &[round(&gizmo, handle, axis, degrees)], false), axis, degrees);
        }
        // Full turns are counted.
        let through: Vec<_> = (1..=10).map(|k| round(&gizmo, handle, axis, 40.0 * f64::from(k))).collect();
        assert_turned(dragged(&gizmo, handle, &through, false), axis, 400.0);
        let mut drag = Drag::begin(&gizmo, handle, start(), place(&gizmo, grip(&gizmo, handle))).expect("caught");
        for to in through {
            drag.to(&gizmo.projection, place(&gizmo, to), false);
        }
        let (_, _, total) = drag.sector().expect("a sector");
        assert!((total.to_degrees() - 400.0).abs() < 0.1, "{total}");
    }
}

#[test]
fn a_ring_seen_from_its_edge_rolls_with_the_pointer() {
    let at = start().translation.as_vec3();
    let projection = seen_from([at.x, at.y, at.z + 5.0], at.to_array(), [0.0, 1.0, 0.0]);
    let gizmo = gizmo(projection);
    let handle = Handle::Ring(Axis::Y);
    let from = gizmo.middle;
    assert_eq!(gizmo.pick(Handle::of(GizmoMode::Rotate), from + Vec2::new(20.0, 0.0)), Some(handle));
    let mut drag = Drag::begin(&gizmo, handle, start(), from).expect("caught");
    let new = drag.to(&projection, from + Vec2::new(SIZE as f32, 0.0), false).expect("a result");
    assert_turned(new, DVec3::Y, 1_f64.to_degrees());
    // Movement across the line does not rotate.
    let new = drag.to(&projection, from + Vec2::new(0.0, 60.0), false).expect("a result");
    assert_turned(new, DVec3::Y, 0.0);
}

#[test]
fn the_ring_of_scale_scales_by_the_distance_from_the_middle() {
    let gizmo = gizmo(from_corner());
    let out = |factor: f64| gizmo.origin + (grip(&gizmo, Handle::ScaleRing) - gizmo.origin) * factor;
    for factor in [0.5, 1.0, 2.5] {
        let new = dragged(&gizmo, Handle::ScaleRing, &[out(1.3), out(factor)], false);
        assert!((new.scale / start().scale - factor).abs() < 1e-4, "{new:?}");
        assert_eq!((new.rotation, new.translation), (start().rotation, start().translation));
    }
    let none = dragged(&gizmo, Handle::ScaleRing, &[gizmo.origin], false);
    assert!(none.scale > 0.0, "a node never vanishes");
}

#[test]
fn ctrl_snaps_to_round_steps() {
    let gizmo = gizmo(from_corner());
    let handle = Handle::Arrow(Axis::Y);
    assert_moved(dragged(&gizmo, handle, &[grip(&gizmo, handle) + DVec3::Y * 0.37], true), DVec3::Y * 0.4);
    let handle = Handle::PlaneSquare(Axis::Y);
    let to = grip(&gizmo, handle) + DVec3::new(0.13, 0.0, -0.26);
    assert_moved(dragged(&gizmo, handle, &[to], true), DVec3::new(0.1, 0.0, -0.3));
    let handle = Handle::Ring(Axis::Z);
    let to = round(&gizmo, handle, DVec3::Z, 42.0);
    assert_turned(dragged(&gizmo, handle, &[to], true), DVec3::Z, 40.0);
    let out = |factor: f64| gizmo.origin + (grip(&gizmo, Handle::ScaleRing) - gizmo.origin) * factor;
    for (factor, expected) in [(1.27, 1.3), (0.01, 0.1)] {
        let new = dragged(&gizmo, Handle::ScaleRing, &[out(factor)], true);
        assert!((new.scale / start().scale - expected).abs() < 1e-9, "{new:?}");
    }
}

#[test]
fn nothing_jumps_when_a_drag_starts() {
    let gizmo = gizmo(from_corner());
    for handle in all_parts() {
        // The same for a grab beside the line.
        for off in [Vec2::ZERO, Vec2::new(4.0, -3.0), Vec2::new(-3.0, 4.0)] {
            let at = place(&gizmo, grip(&gizmo, handle)) + off;
            let mut drag = Drag::begin(&gizmo, handle, start(), at).expect("caught");
            assert!(drag.to(&gizmo.projection, at, false).is_none(), "{handle:?}: a press is no change");
            let new = drag.to(&gizmo.projection, at + Vec2::new(0.01, 0.0), false).expect("a result");
            assert!(
                new.translation.distance(start().translation) < 1e-3 && (new.scale - start().scale).abs() < 1e-3,
                "{handle:?}: {new:?}"
            );
            assert!(new.rotation.angle_between(start().rotation) < 1e-2, "{handle:?}: {new:?}");
            // Dragged back, it is where it was.
            let new = drag.to(&gizmo.projection, at, false).expect("a result");
            assert!(
                new.translation.distance(start().translation) < 1e-9 && (new.scale - start().scale).abs() < 1e-9,
                "{handle:?}: {new:?}"
            );
        }
    }
}

#[test]
fn every_handle_is_picked_where_it_is_and_not_far_from_it() {
    let gizmo = gizmo(from_corner());
    for kind in [GizmoMode::Move, GizmoMode::Rotate, GizmoMode::Scale] {
        for handle in Handle::of(kind) {
            let at = place(&gizmo, grip(&gizmo, *handle));
            assert_eq!(gizmo.pick(Handle::of(kind), at), Some(*handle));
            assert_eq!(gizmo.pick(&[*handle], at + Vec2::splat(150.0)), None);
        }
    }
    // A few points beside a line, and no more.
    let [start, end] = gizmo.arrow(Axis::X).map(|end| place(&gizmo, end));
    let across = (end - start).normalized().rot90();
    let pick = |points: f32| gizmo.pick(&[Handle::Arrow(Axis::X)], start.lerp(end, 0.5) + across * points);
    assert_eq!((pick(6.5), pick(-6.5)), (Some(Handle::Arrow(Axis::X)), Some(Handle::Arrow(Axis::X))));
    assert_eq!((pick(7.5), pick(-7.5)), (None, None));
}

#[test]
fn of_overlapping_handles_the_front_one_is_picked() {
    let at = start().translation.as_vec3();
    for (sign, front) in [(1.0, Axis::X), (-1.0, Axis::Y)] {
        // From this view, x and y are one line.
        let position = (at + glam::Vec3::new(4.0, -4.0, 0.0) * sign).to_array();
        let gizmo = gizmo(seen_from([position[0], position[1], position[2] + 0.3], at.to_array(), [0.0, 0.0, 1.0]));
        let [x, y] = [Axis::X, Axis::Y].map(|axis| place(&gizmo, grip(&gizmo, Handle::Arrow(axis))));
        assert!(x.distance(y) < 8.0, "{x:?} {y:?}");
        let middle = gizmo.pick(Handle::of(GizmoMode::Move), x.lerp(y, 0.5));
        assert_eq!(middle, Some(Handle::Arrow(front)));
    }
    // The far half of a ring is neither drawn nor picked.
    let gizmo = gizmo(from_corner());
    let whole = gizmo.ring(Axis::Y, true);
    let behind = whole.iter().min_by(|a, b| {
        let depth = |ends: &[DVec3; 2]| (ends[0] - gizmo.origin).dot(gizmo.to_camera);
        depth(a).total_cmp(&depth(b))
    });
    let behind = place(&gizmo, behind.expect("a ring")[0]);
    assert_eq!(gizmo.pick(&[Handle::Ring(Axis::Y)], behind), None);
    assert!(gizmo.ring(Axis::Y, false).len() < whole.len());
}

#[test]
fn handles_seen_end_on_or_edge_on_are_not_picked() {
    let at = start().translation.as_vec3();
    let projection = seen_from([at.x, at.y, at.z + 5.0], at.to_array(), [0.0, 1.0, 0.0]);
    let gizmo = gizmo(projection);
    let hidden = [Handle::Arrow(Axis::Z), Handle::PlaneSquare(Axis::X), Handle::PlaneSquare(Axis::Y)];
    for handle in Handle::of(GizmoMode::Move) {
        assert_eq!(gizmo.opacity(*handle) == 0.0, hidden.contains(handle), "{handle:?}");
    }
    for handle in hidden {
        let grip = place(&gizmo, grip(&gizmo, handle));
        assert_eq!(gizmo.pick(&[handle], grip), None, "{handle:?}");
    }
    assert_eq!(gizmo.pick(Handle::of(GizmoMode::Move), gizmo.middle), Some(Handle::Disc));
    // A handle that becomes hidden during a drag stays where it is.
    let side = super::tests::gizmo(from_corner());
    let mut drag =
        Drag::begin(&side, hidden[0], start(), place(&side, super::tests::grip(&side, hidden[0]))).expect("caught");
    assert_eq!(drag.to(&projection, gizmo.middle, false), None);
}

#[test]
fn handles_behind_the_camera_are_neither_drawn_nor_picked() {
    let at = start().translation.as_vec3();
    let away = seen_from([at.x, at.y, at.z + 1.0], [at.x, at.y, at.z + 2.0], [0.0, 1.0, 0.0]);
    assert!(Gizmo::new(away, start().translation).is_none());
    // Nor does a dragged handle follow the pointer once the camera has passed it.
    let gizmo = gizmo(from_corner());
    for handle in all_parts() {
        let from = place(&gizmo, grip(&gizmo, handle));
        let mut drag = Drag::begin(&gizmo, handle, start(), from).expect("caught");
        assert_eq!(drag.to(&away, PICTURE.center() + Vec2::new(80.0, 30.0), false), None, "{handle:?}");
    }
    // Handles that reach behind a wide-angle camera are left out; the others remain.
    let camera = Camera {
        name: "wide".to_owned(),
        position: [at.x, at.y + 0.5, at.z + 0.5],
        target: at.to_array(),
        up: [0.0, 1.0, 0.0],
        fov: 172.0,
        lens_radius: 0.0,
        focus: None,
        exposure: 0.0,
        auto_exposure: false,
    };
    let wide = super::tests::gizmo(Projection::new(&camera, PICTURE));
    assert_eq!(wide.projection.project(wide.arrow(Axis::Z)[1]), None);
    assert_eq!(wide.pick(&[Handle::Arrow(Axis::Z)], wide.middle + Vec2::new(0.0, 30.0)), None);
    assert_eq!(wide.pick(Handle::of(GizmoMode::Move), wide.middle), Some(Handle::Disc));
}

#[test]
fn the_pointer_grabs_drags_and_releases_a_handle() {
    let document =
        Document::new("a.kdl", "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" { sphere }");
    let path = document.path_of_leaf(0).expect("the sphere");
    let handles = Handle::of(GizmoMode::Move);
    let gizmo = gizmo(from_corner());
    let at = place(&gizmo, grip(&gizmo, Handle::Arrow(Axis::X)));
    let mut handle = GizmoState::default();
    let over = Pointer { position: at, hovered: true, pressed_at: None, down: false };
    assert_eq!(handle.follow(handles, Some(&gizmo), &path, start(), Some(over)), Some(Handle::Arrow(Axis::X)));
    assert!(handle.held.is_none());
    // A press counts where it happened, even if the pointer moves on within the frame.
    let far = at + Vec2::splat(90.0);
    let press = Pointer { position: far, pressed_at: Some(at), down: true, ..over };
    handle.follow(handles, Some(&gizmo), &path, start(), Some(press));
    let holds = |handle: &GizmoState| handle.held.as_ref().map(|(_, drag)| drag.handle);
    assert_eq!(holds(&handle), Some(Handle::Arrow(Axis::X)));
    let hold = Pointer { position: far, hovered: false, pressed_at: None, down: true };
    handle.follow(handles, Some(&gizmo), &path, start(), Some(hold));
    assert_eq!(holds(&handle), Some(Handle::Arrow(Axis::X)));
    handle.follow(handles, Some(&gizmo), &path, start(), Some(Pointer { down: false, ..hold }));
    assert_eq!(holds(&handle), None);
    // A button that is pressed elsewhere grabs nothing on its way over a handle.
    handle.follow(handles, Some(&gizmo), &path, start(), Some(Pointer { position: at, ..hold }));
    assert_eq!(holds(&handle), None);
    // Nothing is grabbed when the node is behind the camera.
    let press = Pointer { position: at, ..press };
    assert_eq!(handle.follow(handles, None, &path, start(), Some(press)), None);
    assert_eq!(holds(&handle), None);
}

#[test]
fn a_spot_light_is_moved_turned_and_its_cone_scaled() {
    let text =
        "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nspot { at 0 2 0; target 0 0 0; intensity 1; cone 40 }";
    let document = Document::new("a.kdl", text);
    let path = document.outline().iter().find(|item| item.kind == ItemKind::Spot).expect("a spot").path.clone();
    assert_eq!(target_node(&document, &path).as_ref(), Some(&path));
    let (light, start) = LightHandles::of(&document, &path).expect("a light");
    let change = |mode: GizmoMode, new: Transform| {
        let (_, key, value) = light.change(path.clone(), light.mode(mode), new);
        (key, value)
    };
    let moved = Transform { translation: start.translation + DVec3::X, ..start };
    assert_eq!(change(GizmoMode::Move, moved), ("at", Value::Triple([1.0, 2.0, 0.0])));
    // A quarter turn about z takes its direction from -y to +x.
    let turned = Transform { rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * start.rotation, ..start };
    assert_eq!(change(GizmoMode::Rotate, turned), ("target", Value::Triple([2.0, 2.0, 0.0])));
    for (factor, cone) in [(1.5, 60.0), (20.0, 180.0), (0.0, 0.1)] {
        let scaled = Transform { scale: start.scale * factor, ..start };
        assert_eq!(change(GizmoMode::Scale, scaled), ("cone", Value::Number(cone)));
    }
}
