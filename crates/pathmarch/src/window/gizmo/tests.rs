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
    let change = |mode: GizmoMode, new: Transform| light.change(light.mode(mode), new);
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

/// Dot of this meaning in a view from a corner, and where it is in the window.
fn dot_of(dots: &[Dot], id: DotId) -> (Dot, Pos2) {
    let dot = dots.iter().find(|dot| dot.id == id).unwrap_or_else(|| panic!("no {id:?}"));
    let at = from_corner().project(dot.at).expect("before the camera");
    assert_eq!(dots::pick(dots, &from_corner(), at).map(|dot| dot.id), Some(id));
    (*dot, at)
}

/// The place of a dot that is dragged by so many points.
fn dot_dragged(dot: Dot, at: Pos2, by: Vec2) -> DVec3 {
    let mut drag = DotDrag::begin(Path::top(0), 1, dot, &from_corner(), at).expect("caught");
    assert_eq!(drag.to(&from_corner(), at), None, "a press is no change");
    drag.to(&from_corner(), at + by).expect("a place")
}

fn scene_with(text: &str) -> Document {
    let document = Document::new("a.kdl", format!("pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0 }}\n{text}"));
    assert!(document.scene().is_ok(), "{text}");
    document
}

#[test]
fn points_of_a_turned_profile_are_on_its_silhouette() {
    let text = "object \"a\" { revolve 0.1 { curve 0.02 { point 0.4 0; point 0.2 0.3; point 0.5 0.6; at 0.1 0.2 0; scale 2 }; at 0 1 0 } }";
    let document = scene_with(text);
    let view = from_corner();
    let profile = Profile::of(&document, &Path::top(2), view.position).expect("a profile");
    let dots = profile.dots();
    assert_eq!(dots.len(), 3);
    let (dot, at) = dot_of(&dots, DotId::ControlPoint(1));
    // 0.1 m of the modifier, 0.1 m and twice 0.2 m of the curve.
    assert!((dot.at.x.hypot(dot.at.z) - 0.6).abs() < 1e-6 && (dot.at.y - 1.8).abs() < 1e-6, "{dot:?}");
    assert!(dot.at.dot(view.right) > 0.5 && dot.at.dot(view.position.with_y(0.0)).abs() < 1e-6, "{dot:?}");
    assert_eq!(profile.coordinates(dot.at, &view, false), [0.2, 0.3]);
    // A drag by its projection to the point (0.3, 0.35).
    let goal = profile.dot(1, [0.3, 0.35]).at;
    let moved = dot_dragged(dot, at, view.project(goal).expect("seen") - at);
    assert_eq!(profile.coordinates(moved, &view, false), [0.3, 0.35]);
    let [x, y] = profile.coordinates(moved, &view, true);
    assert!([x, y].iter().all(|v| (v * 10.0 - (v * 10.0).round()).abs() < 1e-5), "{x} {y}");
    // Beyond the axis is nothing.
    let left = dot_dragged(dot, at, Vec2::new(-400.0, 0.0));
    assert_eq!(profile.coordinates(left, &view, false)[0], -0.1);
}

#[test]
fn a_point_is_added_where_the_outline_is_pressed() {
    let text = "object \"a\" { extrude 0.5 { polygon { point 0 0; point 1 0; point 1 1 } } }";
    let document = scene_with(text);
    let view = from_corner();
    let profile = Profile::of(&document, &Path::top(2), view.position).expect("a profile");
    // On the end that faces the camera.
    assert!(profile.dots().iter().all(|dot| (dot.at.z - 0.25).abs() < 1e-9));
    for (index, middle) in [(1, [0.5, 0.0]), (2, [1.0, 0.5]), (3, [0.5, 0.5])] {
        let at = view.project(profile.dot(0, middle).at).expect("seen");
        let (found, place, shown) = profile.on_outline(&view, at + Vec2::new(1.0, -1.0)).expect("on the outline");
        assert_eq!(found, index);
        assert!((place[0] - middle[0]).abs() < 0.01 && (place[1] - middle[1]).abs() < 0.01, "{place:?}");
        assert!(shown.distance(at) < 2.0);
        assert!(profile.on_outline(&view, at + Vec2::new(40.0, -300.0)).is_none());
    }
    assert!(Profile::of(&scene_with("object \"a\" { sphere }"), &Path::top(2), view.position).is_none());
}

#[test]
fn an_open_line_has_no_piece_from_its_end_to_its_start() {
    let view = from_corner();
    for (width, pieces) in [("0.1", 3), ("0", 4)] {
        let text = format!(
            "object \"a\" {{ extrude {{ curve {width} {{ point 0 0; point 1 0; point 1 0; point 1 1; point 0 1 }} }} }}"
        );
        let profile = Profile::of(&scene_with(&text), &Path::top(2), view.position).expect("a profile");
        assert_eq!(profile.dots().len(), 5);
        let outline: Vec<_> = [[1.0, 0.5], [0.0, 0.5]]
            .map(|at| view.project(profile.dot(0, at).at).expect("seen"))
            .map(|at| (0..60).find_map(|k| profile.on_outline(&view, at + Vec2::new(k as f32 - 30.0, 0.0))))
            .to_vec();
        // The repeated point counts.
        assert_eq!(outline[0].map(|(index, ..)| index), Some(3));
        assert_eq!(outline[1].is_some(), pieces == 4, "width {width}");
    }
}

#[test]
fn sizes_of_shapes_follow_their_dots() {
    for (shape, sizes) in [
        ("sphere 0.5", &[("radius", 1.0)][..]),
        ("box 1 0.6 0.8", &[("x", 2.0), ("y", 2.0), ("z", 2.0)]),
        ("disc 0.4 { normal 1 2 3 }", &[("radius", 1.0)]),
        ("cylinder 0.3 1", &[("radius", 1.0), ("height", 2.0)]),
        ("torus 0.5 0.1", &[("major", 1.0), ("minor", 1.0)]),
    ] {
        let document = scene_with(&format!("object \"a\" {{ {shape} }}"));
        let scene = document.scene().expect("a scene");
        let path = document.path_of_leaf(0).expect("a shape");
        let found = Sizes::of(&document, scene, &path).unwrap_or_else(|| panic!("sizes of {shape}"));
        let dots = found.dots();
        assert_eq!(dots.len(), sizes.len(), "{shape}");
        for (index, (name, rate)) in sizes.iter().enumerate() {
            let dot = dots[index];
            let dots::Way::Line(axis) = dot.way else { panic!("a line") };
            let Some(Value::Number(before)) = transform::present_value(&document, &path, name) else {
                panic!("{name}")
            };
            let (key, value) = found.change(index, dot.at + axis * 0.1, false).expect("a change");
            let Value::Number(value) = value else { panic!("a number") };
            assert_eq!(key, *name);
            assert!((f64::from(value - before) - 0.1 * rate).abs() < 2e-3, "{shape} {name}: {before} {value}");
            // Never to nothing.
            let (_, least) = found.change(index, dot.at - axis * 9.0, false).expect("a change");
            assert!(matches!(least, Value::Number(least) if (0.0..0.01).contains(&least)), "{least:?}");
        }
    }
    let document = scene_with("object \"a\" { plane }");
    let path = document.path_of_leaf(0).expect("a shape");
    assert!(Sizes::of(&document, document.scene().expect("a scene"), &path).is_none(), "a plane has no end");
}

#[test]
fn target_cone_and_soft_edge_of_a_spot_light_follow_their_dots() {
    let document = scene_with("spot { at 0 2 0; target 0 0 0; intensity 1; cone 40; blend 0.5 }");
    let path = document.outline().iter().find(|item| item.kind == ItemKind::Spot).expect("a spot").path.clone();
    let Some((LightHandles::Spot(cone), _)) = LightHandles::of(&document, &path) else { panic!("a spot") };
    let view = from_corner();
    let dots = cone.dots(&view);
    // Where the dots are, they change nothing.
    let value = |id: DotId, by: DVec3| cone.change(id, dot_of(&dots, id).0.at + by, &view, false);
    assert_eq!(value(DotId::Target, DVec3::ZERO), ("target", Value::Triple([0.0; 3])));
    assert_eq!(value(DotId::Cone, DVec3::ZERO), ("cone", Value::Number(40.0)));
    assert_eq!(value(DotId::Blend, DVec3::ZERO), ("blend", Value::Number(0.5)));
    assert_eq!(value(DotId::Target, DVec3::new(0.5, 0.0, -0.25)), ("target", Value::Triple([0.5, 0.0, -0.25])));
    // Half the angle has the tangent of the radius, 2 m away.
    let dots::Way::Line(across) = dots[1].way else { panic!("a line") };
    let (_, wider) = value(DotId::Cone, across * (2.0 - 2.0 * 20_f64.to_radians().tan()));
    assert_eq!(wider, Value::Number(90.0));
    assert_eq!(value(DotId::Blend, across * 9.0), ("blend", Value::Number(1.0)));
    assert_eq!(value(DotId::Blend, across * -9.0), ("blend", Value::Number(0.0)));
}
