//! Random trees of placed shapes and operators.

use crate::sampling::{Random, declared, lanes, random_params, validate};
use pathmarch_field::graph::Kind;
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{modifiers, operators, shapes};
use pathmarch_field::wgsl::Program;
use pathmarch_field::{Aabb, Blend, BlendProfile, Field, Node, Operator, Placement};
use proptest::prelude::*;

fn triple(range: std::ops::Range<f32>) -> impl Strategy<Value = [f32; 3]> {
    [range.clone(), range.clone(), range]
}

fn placement() -> impl Strategy<Value = Placement> {
    let parts = (
        proptest::option::of(0.2f32..3.0),
        proptest::option::of(triple(-180.0..180.0)),
        proptest::option::of(triple(-2.0..2.0)),
    );
    parts.prop_map(|(scale, rotate, at)| Placement { normal: None, scale, rotate, at })
}

fn shape() -> impl Strategy<Value = Node> {
    (0..shapes().len(), any::<u64>(), placement(), proptest::option::of(triple(0.1..1.0))).prop_map(
        |(index, seed, placement, normal)| {
            let shape = shapes()[index];
            let params = random_params(shape, &mut Random::new(seed));
            let normal = normal.filter(|_| shape.info().facing);
            Node {
                kind: Kind::Shape { shape: shape.into(), params, tag: seed as u32 % 10 },
                placement: Placement { normal, ..placement },
            }
        },
    )
}

/// Sharp, or blended by any profile.
fn blend() -> impl Strategy<Value = Option<Blend>> {
    let blend = (0.0f32..1.0, proptest::sample::select(BlendProfile::ALL.to_vec()), 1u32..6);
    proptest::option::of(blend.prop_map(|(amount, profile, steps)| Blend { amount, profile, steps: steps as f32 }))
}

fn combined(operator: &'static dyn Operator, smooth: Option<Blend>, children: Vec<Node>) -> Kind {
    // What does not blend has an amount in the place of a width.
    let soft = Blend::from(smooth.map_or(0.5, |blend| blend.amount));
    Kind::Operator { operator, smooth: if operator.blends() { smooth } else { Some(soft) }, children }
}

fn node() -> impl Strategy<Value = Node> {
    shape().prop_recursive(3, 12, 4, |child| {
        let children = proptest::collection::vec(child, 0..4);
        (0..operators().len(), blend(), children, placement()).prop_map(|(operator, smooth, children, placement)| {
            Node { kind: combined(operators()[operator], smooth, children), placement }
        })
    })
}

/// Trees with modifiers, of solids that have an end.
fn modified() -> impl Strategy<Value = Node> {
    let solid = shape().prop_filter("an end", |node| match &node.kind {
        Kind::Shape { shape, params, .. } => shape.bounds(params).is_finite(),
        _ => false,
    });
    solid.prop_recursive(4, 12, 3, |child| {
        let children = proptest::collection::vec(child, 1..3);
        let kinds = operators().len() + 2 * modifiers().len();
        (0..kinds, blend(), children, placement()).prop_map(|(index, smooth, children, placement)| {
            let kind = match operators().get(index) {
                Some(operator) => combined(*operator, smooth, children),
                None => {
                    let modifier = modifiers()[(index - operators().len()) / 2];
                    let params = modifier.params().iter().map(|param| match &*param.name {
                        // What is endless cannot be held by those that need an end.
                        "count" => 3.0,
                        _ => param.default,
                    });
                    Kind::Modifier { modifier, params: params.collect(), children }
                }
            };
            Node { kind, placement }
        })
    })
}

fn objects() -> impl Strategy<Value = Vec<Node>> {
    proptest::collection::vec(node(), 0..4)
}

fn points(seed: u64) -> Vec<Vec3<f32>> {
    let mut random = Random::new(seed);
    (0..64).map(|_| random.point(Aabb::centred(5.0, 5.0, 5.0))).collect()
}

/// Other numbers in the same places.
fn altered(node: &Node) -> Node {
    let placement = Placement {
        normal: node.placement.normal.map(|[x, y, z]| [x, y + 0.5, z]),
        scale: node.placement.scale.map(|s| s * 1.5),
        rotate: node.placement.rotate.map(|v| v.map(|v| v + 10.0)),
        at: node.placement.at.map(|v| v.map(|v| v - 0.25)),
    };
    let kind = match &node.kind {
        Kind::Shape { shape, params, tag } => {
            // A number that is fixed in the code is structure.
            let fixed = usize::from(shape.variant(params).is_some());
            let factor = |k: usize| if k < fixed { 1.0 } else { 1.25 };
            let params = params.iter().enumerate().map(|(k, v)| v * factor(k)).collect();
            Kind::Shape { shape: shape.clone(), params, tag: *tag }
        }
        Kind::Operator { operator, smooth, children } => Kind::Operator {
            operator: *operator,
            smooth: smooth.map(|blend| Blend { amount: blend.amount + 0.1, ..blend }),
            children: children.iter().map(altered).collect(),
        },
        Kind::Modifier { .. } => node.kind.clone(),
    };
    Node { kind, placement }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn eight_lanes_equal_one(
        objects in objects(),
        modified in proptest::collection::vec(modified(), 0..3),
        seed in any::<u64>(),
    ) {
        let objects = [objects, modified].concat();
        let field = Field::new(&objects);
        for points in points(seed).chunks(8) {
            let seeds = [1, 2, 3, 4, 5, 6, 7, 8];
            let distances = field.distance(lanes(points)).to_array();
            let surfaces = field.surface(lanes(points), seeds);
            for (k, &p) in points.iter().enumerate() {
                let distance = field.distance(p);
                let surface = field.surface(p, seeds[k]);
                prop_assert!(distance == distances[k] || (distance - distances[k]).abs() < 1e-4);
                // Of the objects, the one whose surface is nearest shows, whether the point lies in it or not.
                let nearest = field.object_distances(p).map(f32::abs).fold(f32::INFINITY, f32::min);
                for shown in [surface.field.value, surfaces.field.value.to_array()[k]] {
                    prop_assert!(nearest == shown.abs() || (nearest - shown.abs()).abs() < 1e-4);
                    let of_an_object = field.object_distances(p).any(|d| d == shown || (d - shown).abs() < 1e-4);
                    prop_assert!(of_an_object || objects.is_empty() || !shown.is_finite());
                }
            }
        }
    }

    #[test]
    fn surfaces_have_short_gradients_and_a_leaf(objects in objects(), seed in any::<u64>()) {
        let field = Field::new(&objects);
        for p in points(seed) {
            let surface = field.surface(p, seed as u32);
            let length = surface.field.gradient.length();
            prop_assert!(length.is_finite() && length <= field.lipschitz() * 1.002, "{p:?}: {surface:?}");
            prop_assert!(field.leaves().is_empty() || (surface.leaf as usize) < field.leaves().len());
            prop_assert_eq!(surface.leaf.fract(), 0.0);
        }
    }

    #[test]
    fn distances_keep_the_lipschitz_constant(objects in objects(), seed in any::<u64>()) {
        let field = Field::new(&objects);
        let mut random = Random::new(seed ^ 1);
        for a in points(seed) {
            let b = a + random.direction() * 10f32.powf(random.within(-3.0, 0.5));
            let (at_a, at_b) = (field.distance(a), field.distance(b));
            prop_assert!(at_a == at_b || (at_a - at_b).abs() <= field.lipschitz() * (a - b).length() + 1e-4);
        }
    }

    #[test]
    fn bounds_hold_the_solids(objects in objects(), seed in any::<u64>()) {
        let field = Field::new(&objects);
        for p in points(seed) {
            prop_assert!(field.distance(p) > 0.0 || field.bounds().contains(p, 1e-4), "{p:?} {:?}", field.bounds());
        }
        for (k, object) in objects.iter().enumerate() {
            let alone = Field::new(std::slice::from_ref(object));
            prop_assert!(alone.object_bounds().is_empty() || field.object_bounds().contains(&alone.bounds()), "object {k}");
        }
    }

    #[test]
    fn modifiers_hold_in_their_bounds_and_print_valid_code(
        objects in proptest::collection::vec(modified(), 1..3),
        seed in any::<u64>(),
    ) {
        let field = Field::new(&objects);
        let mut random = Random::new(seed);
        for p in points(seed) {
            let distance = field.distance(p);
            prop_assert!(distance > 0.0 || field.bounds().contains(p, 1e-4), "{p:?} {:?}", field.bounds());
            // The ball around a point is on its side of the surface.
            let near = p + random.direction() * (0.999 * (distance.abs() / field.lipschitz() - 1e-4).max(0.0));
            let there = field.distance(near);
            prop_assert!(there * distance >= 0.0 || there.abs() < 1e-3, "{p:?} {distance}: {near:?} {there}");
        }
        let program = Program::new(&field);
        validate(&format!("{}{}\n{}", declared(&program), program.code, program.estimated_distance));
    }

    #[test]
    fn code_depends_on_structure_only(objects in objects()) {
        let program = Program::new(&Field::new(&objects));
        let others: Vec<Node> = objects.iter().map(altered).collect();
        let other = Program::new(&Field::new(&others));
        prop_assert_eq!(&program.code, &other.code);
        prop_assert!(program.has_tables || program.parameters.len() == other.parameters.len());
        validate(&(declared(&program) + &program.code));
    }
}

#[test]
fn a_placement_scales_then_turns_then_moves() {
    let shape = pathmarch_field::registry::shape("box").expect("registered");
    let kind = Kind::Shape { shape: shape.into(), params: vec![2.0, 1.0, 1.0], tag: 0 };
    let placement =
        Placement { normal: None, scale: Some(2.0), rotate: Some([0.0, 0.0, 90.0]), at: Some([1.0, 0.0, 0.0]) };
    let field = Field::new(&[Node { kind, placement }]);
    // Two by one by one, doubled, upright, one metre to the right.
    for (p, distance) in
        [([1.0, 3.0, 0.0], 1.0), ([3.0, 0.0, 0.0], 1.0), ([1.0, 0.0, -2.0], 1.0), ([1.0, 0.0, 0.0], -1.0)]
    {
        let found = field.distance(Vec3::new(p[0], p[1], p[2]));
        assert!((found - distance).abs() < 1e-5, "{p:?}: {found}");
    }
}

/// Two balls and a block, of which some count; the same printed for the GPU.
#[test]
fn the_distance_to_some_objects_leaves_the_others_out() {
    let shape = |name: &str, params: &[f32], at: [f32; 3]| Node {
        kind: Kind::Shape {
            shape: shapes().iter().copied().find(|shape| &*shape.info().name == name).expect("a shape").into(),
            params: params.to_vec(),
            tag: 0,
        },
        placement: Placement { at: Some(at), ..Placement::default() },
    };
    let torus = shape("torus", &[1.0, 0.25], [0.0, 0.0, 9.0]);
    let field = Field::new(&[shape("sphere", &[1.0], [0.0; 3]), shape("sphere", &[1.0], [4.0, 0.0, 0.0]), torus]);
    let (p, none) = (Vec3::new(0.5, 0.0, 0.0), 99.0);
    let distance = |included: [bool; 3], ignored: f32| field.distance_to(p, &included, ignored);
    assert!((distance([true; 3], none) - 0.5).abs() < 1e-6, "from inside, too");
    assert!((distance([true; 3], 0.0) - 2.5).abs() < 1e-6, "its own ball does not count");
    assert!((distance([false, true, true], none) - 2.5).abs() < 1e-6);
    assert!((distance([false, false, true], 2.0) - distance([false, false, true], none)).abs() < 1e-6, "a ring does");
    assert_eq!(distance([false; 3], none), f32::INFINITY);
    let program = Program::new(&field);
    let text = Program::distances_to(&field, &[("some", &[false, true, true]), ("all", &[true; 3])]);
    assert!(
        text.contains("fn some(p: vec3f, ignored_leaf: u32) -> f32") && text.contains("ignored_leaf == 1u"),
        "{text}"
    );
    validate(&(declared(&program) + &program.code + "\n" + &text));
}
