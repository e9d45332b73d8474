//! Lamps: shapes of unions and of counted copies are leaves of their own, and surfaces stay where they are.

use crate::sampling::Random;
use pathmarch_field::graph::Kind;
use pathmarch_field::registry::{modifiers, operator, shape};
use pathmarch_field::{Aabb, Field, Node, Placement};

const LAMP: u32 = 1;

fn leaf(name: &str, params: &[f32], tag: u32, at: [f32; 3]) -> Node {
    let shape = shape(name).expect("registered");
    let placement = Placement { at: Some(at), ..Placement::default() };
    Node { kind: Kind::Shape { shape: shape.into(), params: params.to_vec(), tag }, placement }
}

fn union(children: Vec<Node>) -> Node {
    let operator = operator("union").expect("registered");
    Node { kind: Kind::Operator { operator, smooth: None, children }, placement: Placement::default() }
}

fn modified(name: &str, params: &[f32], placement: Placement, child: Node) -> Node {
    let found = modifiers().iter().copied().find(|modifier| modifier.info().name == name);
    let modifier = found.expect("registered");
    let params = params.iter().copied().chain(modifier.params()[params.len()..].iter().map(|param| param.default));
    Node { kind: Kind::Modifier { modifier, params: params.collect(), children: vec![child] }, placement }
}

/// Rings of five spheres, a disc and a box in each ring, three by four by two times; turned, moved and scaled.
fn rings(tag: u32) -> Node {
    let ring = modified("polar", &[5.0], Placement::default(), leaf("sphere", &[0.05], tag, [0.4, 0.0, 0.0]));
    let chandelier = union(vec![
        ring,
        leaf("disc", &[0.1], tag, [0.0, -0.1, 0.0]),
        leaf("box", &[0.1, 0.2, 0.15], tag, [0.0, 0.2, 0.1]),
    ]);
    let placement = Placement {
        at: Some([1.0, 2.0, -0.5]),
        rotate: Some([20.0, 30.0, 40.0]),
        scale: Some(1.4),
        ..Placement::default()
    };
    modified("repeat", &[1.2, 1.1, 1.3, 0.0, 3.0, 4.0, 2.0], placement, chandelier)
}

#[test]
fn copies_of_lamps_have_the_surface_of_the_repetition() {
    let objects = [rings(LAMP), leaf("sphere", &[0.5], 0, [0.0, -3.0, 0.0])];
    let (lamps, whole) = (Field::with_lamps(&objects, |tag| tag == LAMP), Field::new(&objects));
    assert_eq!((lamps.leaves().len(), whole.leaves().len()), (3 * 4 * 2 * 7 + 1, 4));
    assert!(!whole.is_analytic_leaf(0) && (0..lamps.leaves().len()).all(|leaf| lamps.is_analytic_object(leaf)));
    // The ball is the last declared leaf.
    assert_eq!((lamps.declared_leaf(3), lamps.leaves()[3].object), (3, 1));
    assert!((4..lamps.leaves().len()).all(|leaf| lamps.declared_leaf(leaf) < 3 && lamps.leaves()[leaf].object == 0));
    let all = (0..3).map(|leaf| lamps.declared_bounds(leaf)).fold(Aabb::NOTHING, Aabb::union);
    let mut random = Random::new(5);
    for _ in 0..4000 {
        let p = random.point(lamps.bounds());
        let [a, b] = [&lamps, &whole].map(|field| field.distance(p));
        // Inside overlapping shapes distances are bounds.
        assert!((a.max(0.0) - b.max(0.0)).abs() < 1e-4, "{p:?}: {a} {b}");
    }
    let mut hits = 0;
    for _ in 0..4000 {
        let (origin, target) = (random.point(Aabb::centred(9.0, 9.0, 9.0)), random.point(lamps.bounds()));
        let offset = target - origin;
        let direction = offset * (1.0 / offset.length());
        let (t, hit) = lamps.analytic_hit(origin, direction);
        if hit < 0.0 || lamps.leaves()[hit as usize].tag != LAMP || whole.distance(origin) < 0.0 {
            continue;
        }
        let p = origin + direction * t;
        assert!(whole.distance(p).abs() < 1e-4, "{p:?}");
        let bounds = lamps.leaf_bounds(hit as usize).expanded(1e-4);
        let inside = |v: f32, k: usize| bounds.min[k] <= v && v <= bounds.max[k] && all.min[k] - 1e-4 <= v;
        assert!(inside(p.x, 0) && inside(p.y, 1) && inside(p.z, 2), "the hit is on its own copy");
        hits += 1;
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn only_lamps_are_taken_apart() {
    let apart = |object: Node| {
        let field = Field::with_lamps(&[object], |tag| tag == LAMP);
        (field.leaves().len(), field.is_analytic_leaf(0))
    };
    let ball = |tag| leaf("sphere", &[0.1], tag, [0.0; 3]);
    let repeat = |count: f32, child| modified("repeat", &[1.0, 0.0, 1.0, count], Placement::default(), child);
    assert_eq!(apart(repeat(3.0, ball(LAMP))), (9, true));
    // Other materials, endless and too many copies, shapes without an analytic intersection, and bent space.
    for object in [
        repeat(3.0, ball(0)),
        repeat(0.0, ball(LAMP)),
        repeat(1000.0, ball(LAMP)),
        repeat(3.0, leaf("torus", &[0.2, 0.05], LAMP, [0.0; 3])),
        modified("twist", &[], Placement::default(), ball(LAMP)),
    ] {
        assert_eq!(apart(object), (1, false));
    }
    assert_eq!(apart(repeat(3.0, union(vec![ball(LAMP), ball(0)]))), (2, false));
}
