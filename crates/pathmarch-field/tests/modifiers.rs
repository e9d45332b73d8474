//! Operators that change what they hold: against unions written out, and at random points.

use crate::sampling::Random;
use pathmarch_field::graph::Kind;
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{modifiers, operator, solid};
use pathmarch_field::{Aabb, Field, Node, Placement, Solid};

fn shape(name: &str, params: &[f32], placement: Placement) -> Node {
    let Some(Solid::Shape(shape)) = solid(name) else { panic!("no shape {name}") };
    Node { kind: Kind::Shape { shape: shape.into(), params: params.to_vec(), tag: 0 }, placement }
}

fn modified(name: &str, params: &[f32], children: Vec<Node>) -> Node {
    let Some(Solid::Modifier(modifier)) = solid(name) else { panic!("no modifier {name}") };
    let all = modifier.params().iter().enumerate();
    let params = all.map(|(k, param)| params.get(k).copied().unwrap_or(param.default)).collect();
    Node { kind: Kind::Modifier { modifier, params, children }, placement: Placement::default() }
}

fn union(children: Vec<Node>) -> Node {
    let operator = operator("union").expect("registered");
    Node { kind: Kind::Operator { operator, smooth: None, children }, placement: Placement::default() }
}

fn at(x: f32, y: f32, z: f32) -> Placement {
    Placement { at: Some([x, y, z]), ..Placement::default() }
}

/// A block off the middle, turned: no symmetry helps it.
fn block(size: f32) -> Node {
    let placement =
        Placement { rotate: Some([20.0, 30.0, 10.0]), at: Some([0.1, 0.05, -0.05]), ..Placement::default() };
    shape("box", &[size, 0.6 * size, 0.4 * size], placement)
}

fn placed(node: &Node, placement: Placement) -> Node {
    Node { placement, ..union(vec![node.clone()]) }
}

/// Solids that modifiers are tried on.
fn solids() -> Vec<Node> {
    vec![
        block(0.8),
        union(vec![block(0.5), shape("torus", &[0.6, 0.1], at(0.3, 0.2, 0.0))]),
        shape("cylinder", &[0.3, 1.5], Placement::default()),
        shape("box", &[1.6, 0.3, 0.5], at(0.0, 0.1, 0.0)),
    ]
}

fn assert_same(ours: &Node, written_out: &Node, within: f32, seed: u64) {
    let (ours, written_out) = (Field::new(std::slice::from_ref(ours)), Field::new(std::slice::from_ref(written_out)));
    let mut random = Random::new(seed);
    for _ in 0..4000 {
        let p = random.point(Aabb::centred(within, within, within));
        let (a, b) = (ours.distance(p), written_out.distance(p));
        assert!((a - b).abs() < 2e-5 * (1.0 + within), "{p:?}: {a}, written out {b}");
        let (a, b) = (ours.surface(p, 0).field, written_out.surface(p, 0).field);
        // On the border between two copies either may show.
        let apart = (a.gradient - b.gradient).length();
        assert!(apart < 1e-3 || (a.value - b.value).abs() < 1e-5, "{p:?}: gradients {apart} apart");
    }
}

#[test]
fn repeated_is_a_union_of_copies() {
    // It fits in its cell, fills it, and reaches far beyond it.
    for (size, spacing) in [(0.5, 1.5), (0.8, 0.9), (1.4, 0.7)] {
        for counts in [[3.0, 1.0, 1.0], [2.0, 3.0, 1.0], [4.0, 2.0, 3.0]] {
            let params = [spacing, 1.2 * spacing, spacing, 0.0, counts[0], counts[1], counts[2]];
            let mut copies = Vec::new();
            for (x, y, z) in (0..4).flat_map(|x| (0..4).flat_map(move |y| (0..4).map(move |z| (x, y, z)))) {
                let number = [x as f32, y as f32, z as f32];
                if (0..3).all(|k| number[k] < counts[k]) {
                    let place = |k: usize| (number[k] - 0.5 * (counts[k] - 1.0)) * params[k];
                    copies.push(placed(&block(size), at(place(0), place(1), place(2))));
                }
            }
            assert_same(&modified("repeat", &params, vec![block(size)]), &union(copies), 4.0, 1);
        }
    }
}

#[test]
fn endless_repetition_has_no_end() {
    let endless = modified("repeat", &[1.1, 0.0, 1.3, 0.0], vec![block(0.7)]);
    let many = modified("repeat", &[1.1, 0.0, 1.3, 41.0], vec![block(0.7)]);
    assert_same(&endless, &many, 10.0, 2);
    let field = Field::new(&[endless]);
    assert!(!field.bounds().is_finite() && field.bounds().max[1] < 1.0);
    let near: f32 = field.distance(Vec3::new(0.3, 0.2, 0.1));
    let far: f32 = field.distance(Vec3::new(0.3 + 1.1 * 512.0, 0.2, 0.1 - 1.3 * 256.0));
    assert!((near - far).abs() < 1e-3);
}

#[test]
fn polar_is_a_union_of_turned_copies() {
    for (count, child) in [
        (5.0, placed(&block(0.6), at(1.5, 0.0, 0.2))),
        (3.0, block(1.0)),
        (7.0, placed(&block(0.9), at(-0.9, 0.0, 0.9))),
    ] {
        let copies = (0..count as u32).map(|k| {
            let rotate = Some([0.0, 360.0 / count * k as f32, 0.0]);
            placed(&child, Placement { rotate, ..Placement::default() })
        });
        assert_same(&modified("polar", &[count], vec![child.clone()]), &union(copies.collect()), 3.0, 3);
    }
}

#[test]
fn mirrored_is_a_union_with_the_image() {
    // A ball's image is a ball.
    for (axis, place) in [(0, [0.3, 0.2, 0.1]), (1, [0.0, 0.9, 0.4]), (2, [-0.5, 0.2, -1.0])] {
        let ball = |place: [f32; 3]| shape("sphere", &[0.4], at(place[0], place[1], place[2]));
        let mut image = place;
        image[axis] = -place[axis];
        let ours = modified("mirror", &[axis as f32], vec![ball(place)]);
        assert_same(&ours, &union(vec![ball(place), ball(image)]), 2.0, 4);
    }
}

#[test]
fn a_rounded_box_a_hollow_ball_and_a_long_one() {
    let sharp = shape("box", &[1.0, 0.8, 0.6], Placement::default());
    let rounded = shape("rounded-box", &[1.2, 1.0, 0.8, 0.1], Placement::default());
    let same_outside = |a: &Node, b: &Node| {
        let (a, b) = (Field::new(std::slice::from_ref(a)), Field::new(std::slice::from_ref(b)));
        let mut random = Random::new(5);
        for _ in 0..2000 {
            let p = random.point(Aabb::centred(2.0, 2.0, 2.0));
            let (a, b): (f32, f32) = (a.distance(p), b.distance(p));
            assert!((a - b).abs() < 1e-5 || a.max(b) < 0.0, "{p:?}: {a} {b}");
        }
    };
    same_outside(&modified("round", &[0.1], vec![sharp]), &rounded);
    let ball = shape("sphere", &[1.0], Placement::default());
    let shell = Field::new(&[modified("shell", &[0.2], vec![ball.clone()])]);
    for (radius, distance) in [(0.0, 0.9), (0.95, -0.05), (1.0, -0.1), (1.5, 0.4)] {
        assert!((shell.distance(Vec3::new(0.0, radius, 0.0)) - distance).abs() < 1e-6);
    }
    let capsule = shape("capsule", &[1.0, 0.8], Placement::default());
    same_outside(&modified("elongate", &[0.0, 0.8, 0.0], vec![ball]), &capsule);
}

/// Profiles drawn out and turned are the shapes that have files of their own.
#[test]
fn extruded_and_turned_profiles_are_known_solids() {
    let plain = Placement::default;
    let upright = Placement { rotate: Some([90.0, 0.0, 0.0]), ..plain() };
    let cylinder = shape("cylinder", &[0.4, 1.4], upright);
    assert_same(&modified("extrude", &[1.4], vec![shape("circle", &[0.4], plain())]), &cylinder, 2.0, 6);
    let boxed = shape("box", &[0.8, 0.5, 1.4], at(0.2, -0.1, 0.0));
    let rectangle = shape("rectangle", &[0.8, 0.5, 0.0], at(0.2, -0.1, 7.0));
    assert_same(&modified("extrude", &[1.4], vec![rectangle]), &boxed, 2.0, 7);
    let torus = shape("torus", &[1.0, 0.3], at(0.0, 0.4, 0.0));
    assert_same(&modified("revolve", &[0.7], vec![shape("circle", &[0.3], at(0.3, 0.4, 0.0))]), &torus, 2.0, 8);
    // Of a solid its slice counts, and what is turned within its plane is still a profile with an end.
    let sliced = modified("extrude", &[1.4], vec![shape("cylinder", &[0.4, 3.0], upright)]);
    assert_same(&sliced, &cylinder, 1.5, 9);
    let turned = Placement { rotate: Some([0.0, 0.0, 30.0]), ..plain() };
    let turned = modified("extrude", &[0.2], vec![shape("rectangle", &[1.0, 0.5, 0.1], turned)]);
    assert!(Field::new(&[turned]).bounds().is_finite());
}

#[test]
fn profiles_are_repeated_in_their_plane() {
    let circle = || shape("circle", &[0.3], Placement::default());
    let row = modified("repeat", &[1.0, 0.0, 2.0, 0.0, 3.0], vec![circle()]);
    let cylinder =
        |x: f32| shape("cylinder", &[0.3, 0.5], Placement { rotate: Some([90.0, 0.0, 0.0]), ..at(x, 0.0, 0.0) });
    let written_out = union(vec![cylinder(-1.0), cylinder(0.0), cylinder(1.0)]);
    assert_same(&modified("extrude", &[0.5], vec![row]), &written_out, 2.5, 10);
    let bent = modified("extrude", &[0.5], vec![modified("bend", &[0.1], vec![circle()])]);
    assert!(Field::new(&[bent]).bounds().is_finite());
}

/// The corners of stars, and points beside them.
#[test]
fn stars_have_their_points_where_they_should_be() {
    for (points, outer, inner) in [(5.0, 1.0, 0.4), (2.0, 1.0, 0.3), (7.0, 0.5, 0.9), (64.0, 1.0, 0.95)] {
        let star = Field::new(&[modified(
            "extrude",
            &[9.0],
            vec![shape("star", &[points, outer, inner], Placement::default())],
        )]);
        for k in 0..2 * points as u32 {
            let (sine, cosine) = (std::f32::consts::PI / points * k as f32).sin_cos();
            let radius = if k % 2 == 0 { outer } else { inner };
            let at = |factor: f32| star.distance(Vec3::new(sine * radius * factor, cosine * radius * factor, 0.0));
            assert!(at(1.0).abs() < 1e-5 && at(1.01) > 0.0 && at(0.99) < 0.0, "{points} {outer} {inner}: corner {k}");
        }
    }
}

/// What is twisted by a whole turn between two heights, and what is bent into a half circle, is where it should be.
#[test]
fn twisted_and_bent_points_are_where_they_should_be() {
    let bar = shape("box", &[2.0, 2.0, 0.1], Placement::default());
    let twisted = Field::new(&[modified("twist", &[0.25], vec![bar])]);
    // At the height of one metre, turned by a quarter, right-handed about y: x goes to -z.
    let at_height = |x: f32, z: f32| twisted.distance(Vec3::new(x, 0.999, z));
    assert!(at_height(0.0, -0.9) < 0.0 && at_height(0.9, 0.0) > 0.0);
    let slightly = |x: f32, z: f32| twisted.distance(Vec3::new(x, 0.4, z));
    let (sine, cosine) = (std::f32::consts::FRAC_PI_2 * 0.4).sin_cos();
    assert!(slightly(0.9 * cosine, -0.9 * sine) < 0.0 && slightly(0.9 * cosine, 0.9 * sine) > 0.0);

    let bar = shape("box", &[4.0, 0.2, 0.2], Placement::default());
    let bent = Field::new(&[modified("bend", &[0.1], vec![bar])]);
    let radius = 1.0 / (0.1 * std::f32::consts::TAU);
    for turn in [-1.2, -0.5, 0.0, 0.7, 1.2_f32] {
        let p = Vec3::new(radius * turn.sin(), radius - radius * turn.cos(), 0.0);
        let inside: f32 = bent.distance(p);
        assert!(inside < 0.0, "{turn}: {inside}");
        let beside: f32 = bent.distance(p + Vec3::new(0.0, 0.0, 0.5));
        assert!(beside > 0.0 && beside <= 0.4 + 1e-5, "{turn}: {beside}");
    }
}

/// The largest ball around a point that its distance promises to be on one side, and how much of it is.
#[test]
fn distances_are_bounds_and_gradients_agree_with_differences() {
    let mut random = Random::new(6);
    for modifier in modifiers() {
        let name = &*modifier.info().name;
        for strength in [0.5_f32, 1.0, 3.0] {
            let mut inside = 0;
            for solid in solids() {
                let params: Vec<f32> = modifier
                    .params()
                    .iter()
                    .map(|param| match (name, &*param.name) {
                        ("mirror", _) | ("polar", _) => param.default,
                        (_, "count") => 3.0,
                        (_, word) if word.starts_with("count") => param.default,
                        _ => param.default * strength,
                    })
                    .collect();
                let node = Node {
                    kind: Kind::Modifier { modifier: *modifier, params: params.clone(), children: vec![solid.clone()] },
                    placement: Placement {
                        scale: Some(1.3),
                        rotate: Some([10.0, 20.0, 30.0]),
                        at: Some([0.2, 0.1, 0.0]),
                        normal: None,
                    },
                };
                let field = Field::new(&[node]);
                let what = format!("{name} {params:?} of {:?}", solid.kind);
                let mut compared = 0;
                for k in 0..1500 {
                    let p = random.point(Aabb::centred(3.0, 3.0, 3.0));
                    let distance: f32 = field.distance(p);
                    inside += u32::from(distance < 0.0);
                    assert!(
                        distance > 0.0 || field.bounds().contains(p, 1e-4),
                        "{what}: {p:?} is outside of its bounds"
                    );
                    for _ in 0..4 {
                        let near = p + random.direction() * (distance.abs() * random.within(0.5, 0.999));
                        let there: f32 = field.distance(near);
                        assert!(
                            there * distance >= 0.0 || there.abs() < 1e-4,
                            "{what}: {distance} at {p:?}, {there} at {near:?}"
                        );
                    }
                    let surface = field.surface(p, k);
                    assert!((surface.field.value - distance).abs() < 1e-4, "{what}");
                    let length = surface.field.gradient.length();
                    assert!(length.is_finite() && length < 3.0, "{what} {p:?}: |gradient| {length}");
                    let step = 1e-3;
                    let axes = [Vec3::new(step, 0.0, 0.0), Vec3::new(0.0, step, 0.0), Vec3::new(0.0, 0.0, step)];
                    let differences =
                        axes.map(|axis| (field.distance(p + axis) - field.distance(p - axis)) / (2.0 * step));
                    let mut around = axes
                        .iter()
                        .flat_map(|&axis| [axis, -axis])
                        .map(|axis| (field.surface(p + axis, k).field.gradient - surface.field.gradient).length());
                    if around.all(|apart| apart < 0.02) {
                        let found = Vec3::new(differences[0], differences[1], differences[2]);
                        let apart = (found - surface.field.gradient).length();
                        assert!(apart < 0.03, "{what} {p:?}: {apart} apart");
                        compared += 1;
                    }
                }
                assert!(compared > 300, "{what}: {compared} compared");
            }
            assert!(inside > 0, "{name} {strength}: nothing is inside");
        }
    }
}

/// Where a point is in a leaf's coordinates: its distance there is that of the field, and the gradients are its slopes.
#[test]
fn coordinates_are_the_leafs_own() {
    let placement =
        Placement { rotate: Some([20.0, 30.0, 10.0]), scale: Some(1.3), at: Some([0.2, 0.1, 0.0]), normal: None };
    let twisted = Node { placement, ..modified("twist", &[0.2], vec![block(0.8)]) };
    let nodes = [
        block(0.8),
        twisted.clone(),
        Node { placement, ..modified("polar", &[3.0], vec![Node { placement: at(0.8, 0.0, 0.0), ..twisted.clone() }]) },
        modified("bend", &[0.08], vec![twisted]),
    ];
    for (k, node) in nodes.iter().enumerate() {
        let field = Field::new(std::slice::from_ref(node));
        let leaf = &field.leaves()[0];
        let mut random = Random::new(k as u64);
        let mut compared = 0;
        for _ in 0..500 {
            let p = random.point(Aabb::centred(1.2, 1.2, 1.2));
            let here = field.coordinates(0, p).expect("a leaf");
            // Every modifier here keeps the sign of what it holds.
            let inside = leaf.shape.distance(here.point, &leaf.params);
            assert!(inside.abs() < 1e-4 || (inside < 0.0) == (field.distance(p) < 0.0), "{k} at {p:?}");
            let step = 1e-3;
            for (axis, offset) in [Vec3::new(step, 0.0, 0.0), Vec3::new(0.0, step, 0.0), Vec3::new(0.0, 0.0, step)]
                .into_iter()
                .enumerate()
            {
                let [a, b] = [p - offset, p + offset].map(|p| field.coordinates(0, p).expect("a leaf").point);
                let slope = (b - a) / (2.0 * step);
                let gradient = here.gradients.map(|g| [g.x, g.y, g.z][axis]);
                let apart = (slope - Vec3::new(gradient[0], gradient[1], gradient[2])).length();
                // On a border between copies the coordinates jump.
                compared += usize::from(apart < 0.01);
            }
        }
        assert!(compared > 1400, "{k}: {compared} of 1500");
    }
}
