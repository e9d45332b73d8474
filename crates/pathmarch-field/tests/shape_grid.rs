//! Unions of many shapes: what their grids leave out does not matter.

use crate::sampling::{Random, declared, lanes, random_params, validate};
use pathmarch_field::graph::{Kind, RayKind, SPHERE_TRACED};
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{modifiers, operator, shape};
use pathmarch_field::wgsl::Program;
use pathmarch_field::{Aabb, Blend, BlendProfile, Field, Node, Placement};
use wide::f32x8;

const NAMES: [&str; 8] = ["sphere", "box", "torus", "cylinder", "cone", "capsule", "ellipsoid", "octahedron"];

fn place(random: &mut Random, size: f32) -> Placement {
    let p = random.point(Aabb::centred(size, size, size));
    let turn = random.point(Aabb::centred(180.0, 180.0, 180.0));
    let scale = random.point(Aabb { min: [0.2; 3], max: [0.6; 3] });
    Placement { at: Some([p.x, p.y, p.z]), rotate: Some([turn.x, turn.y, turn.z]), scale: Some(scale.x), normal: None }
}

fn shapes(random: &mut Random, count: usize, size: f32) -> Vec<Node> {
    (0..count)
        .map(|k| {
            let shape = shape(NAMES[k % NAMES.len()]).expect("registered");
            let params = random_params(shape, random);
            Node {
                kind: Kind::Shape { shape: shape.into(), params, tag: k as u32 % 3 },
                placement: place(random, size),
            }
        })
        .collect()
}

fn union(children: Vec<Node>, smooth: Option<Blend>) -> Node {
    let operator = operator("union").expect("registered");
    Node { kind: Kind::Operator { operator, smooth, children }, placement: Placement::default() }
}

fn blends() -> Vec<Option<Blend>> {
    let blend = |profile| Some(Blend { amount: 0.15, profile, steps: 3.0 });
    [None].into_iter().chain(BlendProfile::ALL.map(blend)).collect()
}

/// Objects, the number of shapes in each: a smooth union, and shapes apart.
fn grids() -> Vec<Vec<Node>> {
    let mut random = Random::new(7);
    let mut all: Vec<Vec<Node>> =
        blends().into_iter().map(|blend| vec![union(shapes(&mut random, 300, 3.0), blend)]).collect();
    let apart = shapes(&mut random, 200, 3.0).into_iter();
    // Of closed form are only spheres and boxes; what is one object each of the others is a grid.
    all.push(apart.collect());
    all
}

fn single(name: &str, params: Vec<f32>, at: [f32; 3]) -> Node {
    let shape = shape(name).expect("registered");
    Node {
        kind: Kind::Shape { shape: shape.into(), params, tag: 7 },
        placement: Placement { at: Some(at), ..Placement::default() },
    }
}

fn combined(name: &str, smooth: Option<Blend>, children: Vec<Node>) -> Node {
    let operator = operator(name).expect("registered");
    Node { kind: Kind::Operator { operator, smooth, children }, placement: Placement::default() }
}

/// Modifier with its default parameters but for the first ones.
fn modified(name: &str, first: &[f32], children: Vec<Node>) -> Node {
    let modifier = *modifiers().iter().find(|modifier| modifier.info().name == name).expect("registered");
    let mut params: Vec<f32> = modifier.params().iter().map(|param| param.default).collect();
    params[..first.len()].copy_from_slice(first);
    let placement = Placement { at: Some([0.1, 0.2, -0.1]), rotate: Some([0.0, 20.0, 0.0]), ..Placement::default() };
    Node { kind: Kind::Modifier { modifier, params, children }, placement }
}

/// Children that are no plain shapes.
fn odd_children() -> Vec<Node> {
    let sphere = single("sphere", vec![0.9], [1.6, 0.4, 1.5]);
    vec![
        modified("twist", &[0.2], vec![single("box", vec![1.0, 2.0, 0.5], [-1.0, 1.5, 0.0])]),
        combined("subtract", Some(Blend::from(0.1)), vec![single("box", vec![1.5; 3], [1.5, 0.0, 1.0]), sphere]),
        single("mandelbulb", vec![8.0, 8.0], [0.0, 1.0, -1.5]),
        single("plane", vec![], [0.0, -1.5, 0.0]),
    ]
}

/// Unions of many shapes with other children, and many shapes inside of other nodes.
fn mixed_grids() -> Vec<(String, Vec<Node>)> {
    let mut random = Random::new(17);
    let mut all = Vec::new();
    for blend in blends() {
        let name = |what: &str| format!("{what} {blend:?}");
        for (k, odd) in odd_children().into_iter().enumerate() {
            let mut children = shapes(&mut random, 200, 3.0);
            children.insert([200, 0, 77, 150][k], odd);
            all.push((name(&format!("odd child {k}")), vec![union(children, blend)]));
        }
        let mut children = shapes(&mut random, 150, 3.0);
        for (k, odd) in odd_children().into_iter().enumerate() {
            children.insert(40 * k, odd);
        }
        let first = union(shapes(&mut random, 30, 3.0), blend);
        let other = union(shapes(&mut random, 30, 3.0), Some(Blend::from(0.2)));
        children.splice(0..0, [first, other]);
        all.push((name("many odd children"), vec![union(children, blend)]));
        let mut many = || union(shapes(&mut random, 150, 3.0), Some(Blend::from(0.05)));
        let ball = || single("sphere", vec![1.5], [1.0, 1.0, 1.0]);
        for operator in ["union", "subtract", "intersect"] {
            all.push((name(operator), vec![combined(operator, blend, vec![many(), ball()])]));
        }
        all.push((name("subtracted"), vec![combined("subtract", blend, vec![ball(), many()])]));
        let within = ["shell", "round", "displace", "twist", "mirror", "bend", "polar"];
        for name in within.iter().filter(|_| blend.is_none()) {
            all.push(((*name).to_owned(), vec![modified(name, &[], vec![many()])]));
        }
        let twisted = modified("twist", &[0.02], vec![modified("shell", &[0.1], vec![many()])]);
        all.push((name("shell in a twist"), vec![combined("union", blend, vec![ball(), twisted])]));
        let repeated = modified("repeat", &[9.0, 0.0, 9.0, 3.0], vec![many()]);
        all.push((name("repeat"), vec![combined("subtract", blend, vec![repeated, ball()])]));
    }
    all
}

/// Small shapes in a large cube, which seldom touch.
fn small_shapes(random: &mut Random, count: usize) -> Vec<Node> {
    let mut nodes = shapes(random, count, 8.0);
    for node in &mut nodes {
        node.placement.scale = Some(0.3);
    }
    nodes
}

/// Blend of small shapes.
const NARROW: Option<Blend> = Some(Blend { amount: 0.05, profile: BlendProfile::Soft, steps: 3.0 });

/// Distances from points, to the bit.
fn distances(field: &Field, points: &[Vec3<f32>]) -> Vec<u32> {
    points.iter().map(|&p| field.sphere_traced_distance(p, RayKind::Secondary).to_bits()).collect()
}

/// A field whose shape grids are fine, and the same with coarse ones.
fn fine_and_coarse(objects: &[Node]) -> [Field; 2] {
    [Field::new(objects), Field::new(objects).with_coarse_grids()]
}

#[test]
fn the_surface_of_a_grid_is_that_of_the_whole_union() {
    let plain = grids().into_iter().enumerate().map(|(number, objects)| (number.to_string(), objects));
    for (number, (name, objects)) in plain.chain(mixed_grids()).enumerate() {
        let (grids, whole) = (fine_and_coarse(&objects), Field::with_shape_grids_from(&objects, usize::MAX));
        assert!(grids[0].shapes_as_code() < 20, "{name}");
        let mut random = Random::new(number as u64);
        let mut met = 0;
        while met < 300 {
            // Onto the surface along the gradient.
            let mut p = random.point(whole.bounds().intersection(Aabb::centred(12.0, 12.0, 12.0)));
            for _ in 0..8 {
                let near = whole.surface_at_hit(p, SPHERE_TRACED, &|_| 0.5f32).field;
                p = p - near.gradient * (near.value / near.gradient.dot(near.gradient).max(1e-6));
            }
            if whole.sphere_traced_distance(p, RayKind::Secondary) > 1e-3 {
                continue;
            }
            met += 1;
            let seeds: [u32; 8] = std::array::from_fn(|k| (8 * met + k) as u32);
            for ours in &grids {
                let eight = ours.surface_at_hit(lanes(&[p; 8]), f32x8::splat(SPHERE_TRACED), &|index| {
                    <f32x8 as pathmarch_field::graph::Batch>::choice(seeds, index)
                });
                for (lane, &seed) in seeds.iter().enumerate() {
                    let threshold = |index| <f32 as pathmarch_field::graph::Batch>::choice(seed, index);
                    let (a, b) = (
                        ours.surface_at_hit(p, SPHERE_TRACED, &threshold),
                        whole.surface_at_hit(p, SPHERE_TRACED, &threshold),
                    );
                    assert!((a.field.value - b.field.value).abs() < 2e-5, "{name} {p:?} {a:?} {b:?}");
                    assert!((a.field.gradient - b.field.gradient).length() < 1e-3, "{name} {p:?} {a:?} {b:?}");
                    assert_eq!(a.leaf, b.leaf, "{name} at {p:?}");
                    assert_eq!(a.leaf, eight.leaf.to_array()[lane]);
                }
            }
        }
    }
}

#[test]
fn the_code_of_a_grid_does_not_grow_with_it() {
    let program = |count: usize, seed: u64, blend| {
        Program::new(&Field::new(&[union(shapes(&mut Random::new(seed), count, 3.0), blend)]))
    };
    for blend in blends() {
        let (few, many) = (program(40, 1, blend), program(400, 2, blend));
        validate(&format!("{}{}\n{}", declared(&many), many.code, many.estimated_distance));
        assert!(few.code == many.code);
        assert!(!many.is_uniform());
    }
    for odd in odd_children() {
        let program = |count: usize, seed: u64, blend| {
            let mut children = shapes(&mut Random::new(seed), count, 3.0);
            // Code has the numbers of its leaves.
            children.insert(0, odd.clone());
            Program::new(&Field::new(&[union(children, blend)]))
        };
        for blend in blends() {
            assert!(program(40, 1, blend).code == program(400, 2, blend).code);
        }
    }
    for (name, objects) in mixed_grids() {
        println!("{name}");
        let program = Program::new(&Field::new(&objects));
        validate(&format!("{}{}\n{}", declared(&program), program.code, program.estimated_distance));
    }
    let apart = Program::new(&Field::new(&shapes(&mut Random::new(3), 200, 3.0)));
    validate(&format!("{}{}\n{}", declared(&apart), apart.code, apart.estimated_distance));
}

#[test]
fn after_an_edit_a_grid_shares_what_is_unchanged_and_is_that_of_the_new_shapes() {
    let mut random = Random::new(11);
    let mut children = small_shapes(&mut random, 1000);
    let field_of = |children: &[Node]| Field::new(&[union(children.to_vec(), NARROW)]);
    let points: Vec<_> = (0..4000).map(|_| random.point(Aabb::centred(8.0, 8.0, 8.0))).collect();
    let distances = |field: &Field| distances(field, &points);
    let first = field_of(&children);
    let distances_before = distances(&first);
    let whole = first.shape_grid_bytes();
    // A shape in the middle moves, in two edits of which the first is never evaluated.
    let middle = (0..children.len()).min_by(|&a, &b| {
        let offset = |k: usize| children[k].placement.at.unwrap_or_default().map(f32::abs).into_iter().sum::<f32>();
        offset(a).total_cmp(&offset(b))
    });
    let middle = middle.expect("shapes");
    let mut before = first;
    for step in [0.05, 0.3] {
        if let Some(at) = &mut children[middle].placement.at {
            at[0] += step;
        }
        let mut after = field_of(&children);
        after.follow(&before);
        before = after;
    }
    let edited = before;
    edited.sphere_traced_distance(points[0], RayKind::Secondary);
    assert!(edited.shape_grid_bytes() > whole / 2, "{} of {whole}", edited.shape_grid_bytes());
    assert_eq!(distances(&edited), distances(&field_of(&children)));
    assert_ne!(distances(&edited), distances_before);
}

#[test]
fn after_a_row_of_edits_a_grid_is_that_of_the_new_shapes() {
    for blend in [None, NARROW, Some(Blend::from(0.5))] {
        let mut random = Random::new(21);
        let mut children = small_shapes(&mut random, 500);
        let points: Vec<_> = (0..1000).map(|_| random.point(Aabb::centred(8.0, 8.0, 8.0))).collect();
        let mut field = Field::new(&[union(children.clone(), blend)]);
        distances(&field, &points);
        for edit in 0..12 {
            // A nudge, or a jump to another place.
            let moved = 41 * edit % children.len();
            let to = random.point(Aabb::centred(7.0, 7.0, 7.0));
            if let Some(at) = &mut children[moved].placement.at {
                *at = if edit % 3 == 0 { [to.x, to.y, to.z] } else { at.map(|coordinate| 0.97 * coordinate) };
            }
            let mut after = Field::new(&[union(children.clone(), blend)]);
            after.follow(&field);
            assert_eq!(distances(&after, &points), distances(&Field::new(&[union(children.clone(), blend)]), &points));
            field = after;
        }
    }
}

#[test]
fn coarse_cells_are_kept_apart_from_fine_ones() {
    let mut random = Random::new(5);
    let mut children = small_shapes(&mut random, 1000);
    let points: Vec<_> = (0..2000).map(|_| random.point(Aabb::centred(8.0, 8.0, 8.0))).collect();
    let distances = |field: &Field| distances(field, &points);
    let [fine, fresh] = [(); 2].map(|()| Field::new(&[union(children.clone(), NARROW)]));
    let coarse = fine.clone().with_coarse_grids();
    let coarse_distances = distances(&coarse);
    let coarse_bytes = coarse.shape_grid_bytes();
    assert!(coarse.has_coarse_grids() && !fine.has_coarse_grids());
    // What is coarse does not change what is not.
    assert_eq!(distances(&fine), distances(&fresh));
    assert_ne!(coarse_distances, distances(&fresh));
    assert!(coarse_bytes < fresh.shape_grid_bytes(), "{coarse_bytes} and {}", fresh.shape_grid_bytes());
    // Fine cells serve both, also after an edit.
    assert_eq!(distances(&coarse), distances(&fine));
    if let Some(at) = &mut children[500].placement.at {
        at[1] += 0.2;
    }
    let mut edited = Field::new(&[union(children.clone(), NARROW)]);
    edited.follow(&coarse);
    let moved = edited.clone().with_coarse_grids();
    distances(&moved);
    assert_eq!(distances(&edited), distances(&Field::new(&[union(children, NARROW)])));
}

#[test]
fn after_an_edit_of_an_odd_child_a_grid_shares_what_is_unchanged() {
    let mut random = Random::new(12);
    let mut children = small_shapes(&mut random, 600);
    children[17].placement.at = Some([0.0, -1.0, 0.0]);
    let odd = |at: f32, radius: f32| {
        let ball = single("sphere", vec![radius], [at, 0.3, 0.0]);
        modified("twist", &[], vec![combined("subtract", None, vec![single("box", vec![1.5; 3], [0.0; 3]), ball])])
    };
    let field_of = |children: &[Node], odd: Node| {
        let mut children = children.to_vec();
        children.insert(300, odd);
        Field::new(&[modified("shell", &[0.02], vec![union(children, NARROW)])])
    };
    let sizes = (0..4000).map(|k| if k % 4 == 0 { 1.2 } else { 8.0 });
    let points: Vec<_> = sizes.map(|size| random.point(Aabb::centred(size, size, size))).collect();
    let distances = |field: &Field| distances(field, &points);
    let first = field_of(&children, odd(0.0, 0.9));
    let distances_before = distances(&first);
    let whole = first.shape_grid_bytes();
    let mut moved = children.clone();
    if let Some(at) = &mut moved[17].placement.at {
        at[1] += 0.1;
    }
    // Of the odd child: a number and a position. Of a shape beside it: its position.
    for (children, odd) in [(&children, odd(0.0, 0.95)), (&children, odd(0.1, 0.9)), (&moved, odd(0.0, 0.9))] {
        let mut after = field_of(children, odd.clone());
        after.follow(&first);
        after.sphere_traced_distance(points[0], RayKind::Secondary);
        assert!(after.shape_grid_bytes() > whole / 2, "{} of {whole}", after.shape_grid_bytes());
        assert!(distances(&after) == distances(&field_of(children, odd)));
        assert!(distances(&after) != distances_before);
    }
}

#[test]
fn thin_shapes_in_a_grid_are_met() {
    let mut random = Random::new(11);
    let mut children = shapes(&mut random, 200, 3.0);
    let wire = shape("capsule").expect("registered");
    let kind = Kind::Shape { shape: wire.into(), params: vec![0.0005, 4.0], tag: 9 };
    children.push(Node { kind, placement: Placement { at: Some([0.0, 9.0, 0.0]), ..Placement::default() } });
    let sheet = shape("rect").expect("registered");
    let kind = Kind::Shape { shape: sheet.into(), params: vec![1.0, 1.0], tag: 9 };
    children.push(Node {
        kind,
        placement: Placement { at: Some([8.0, 0.0, 0.0]), rotate: Some([0.0, 0.0, 90.0]), ..Placement::default() },
    });
    for blend in [None, Some(Blend::from(1e-4))] {
        let field = Field::new(&[union(children.clone(), blend)]);
        // Rays towards both, from afar: along x to the wire, along -x to the sheet.
        for (origin, direction, ends) in
            [([-9.0, 9.3, 0.0], Vec3::new(1.0f32, 0.0, 0.0), 9.0), ([12.0, 0.1, 0.2], Vec3::new(-1.0, 0.0, 0.0), 4.0)]
        {
            let origin = Vec3::new(origin[0], origin[1], origin[2]);
            let mut t = 0.0f32;
            for _ in 0..256 {
                let distance = field.sphere_traced_distance(origin + direction * t, RayKind::Secondary);
                if distance < 1e-5 {
                    break;
                }
                t += distance;
            }
            assert!((t - ends).abs() < 2e-3, "{t} instead of {ends}");
        }
    }
}

mod slow {
    use super::*;

    #[test]
    fn near_its_surface_a_grid_is_the_whole_union_and_elsewhere_no_farther() {
        let plain = grids().into_iter().enumerate().map(|(number, objects)| (number.to_string(), objects));
        for (number, (name, objects)) in plain.chain(mixed_grids()).enumerate() {
            let whole = Field::with_shape_grids_from(&objects, usize::MAX);
            for ours in fine_and_coarse(&objects) {
                let bounds = whole.bounds().intersection(Aabb::centred(12.0, 12.0, 12.0)).expanded(2.0);
                let mut random = Random::new(number as u64);
                let (mut exact, mut bounded) = (0, 0);
                for _ in 0..2000 {
                    let points: [Vec3<f32>; 8] = std::array::from_fn(|_| random.point(bounds));
                    let at = lanes(&points);
                    let eight = ours.sphere_traced_distance(at, RayKind::Secondary).to_array();
                    let truths = whole.sphere_traced_distance(at, RayKind::Secondary).to_array();
                    let distances = whole.distance(at).to_array();
                    for (lane, p) in points.into_iter().enumerate() {
                        let (one, truth) = (ours.sphere_traced_distance(p, RayKind::Secondary), truths[lane]);
                        assert!((one - eight[lane]).abs() <= 1e-5, "{name}: {one} {} at {p:?}", eight[lane]);
                        assert!(one <= truth + 2e-5, "{name}: {one} is more than {truth} at {p:?}");
                        if (one - truth).abs() <= 2e-5 {
                            exact += 1
                        } else {
                            bounded += 1
                        }
                        // What a march takes for a hit is one.
                        assert!(one > 1e-3 || truth < 1e-2, "{name}: {one} for {truth} at {p:?}");
                        let difference = (ours.distance(p) - distances[lane]).abs();
                        assert!(difference <= 2e-5, "{name}: {difference} at {p:?}");
                    }
                }
                println!("grid {name}: {exact} exact, {bounded} bounded, {} bytes", ours.shape_grid_bytes());
                // Coarse cells are seldom far from every surface.
                assert!(exact > 300 && (bounded > 10 || ours.has_coarse_grids()), "{name}");
            }
        }
    }

    #[test]
    fn chains_and_heaps_of_many_shapes_are_bounded() {
        let sphere = shape("sphere").expect("registered");
        let ball = |at: [f32; 3], radius: f32| Node {
            kind: Kind::Shape { shape: sphere.into(), params: vec![radius], tag: 0 },
            placement: Placement { at: Some(at), ..Placement::default() },
        };
        let mut random = Random::new(5);
        let chain = (0..5000).map(|k| ball([0.02 * k as f32, (0.01 * k as f32).sin(), 0.0], 0.1)).collect();
        let heap = (0..3000).map(|_| ball([0.0; 3], 1.0)).collect();
        let cloud = (0..100_000)
            .map(|_| {
                let p = random.point(Aabb::centred(20.0, 20.0, 20.0));
                ball([p.x, p.y, p.z], 0.2)
            })
            .collect();
        let flat = (0..100).map(|k| ball([k as f32, 0.0, 0.0], 0.3)).collect();
        for (name, children) in [("chain", chain), ("heap", heap), ("cloud", cloud), ("row", flat)] {
            let started = std::time::Instant::now();
            let field = Field::new(&[union(children, Some(Blend::from(0.1)))]);
            let distance = field.sphere_traced_distance(Vec3::new(0.3, 0.2, 0.1f32), RayKind::Secondary);
            println!("{name}: {} bytes in {:?}, {distance}", field.shape_grid_bytes(), started.elapsed());
            assert!(distance.is_finite());
            assert!(field.shape_grid_bytes() < 48 << 20, "{name}: {}", field.shape_grid_bytes());
            assert!(field.bounds().is_finite());
        }
    }
}

#[test]
fn what_has_no_end_is_code_beside_a_grid() {
    let plane = shape("plane").expect("registered");
    let mut children = shapes(&mut Random::new(1), 40, 2.0);
    children.push(Node {
        kind: Kind::Shape { shape: plane.into(), params: vec![], tag: 0 },
        placement: Placement::default(),
    });
    let field = Field::new(&[union(children, None)]);
    assert_eq!(field.shapes_as_code(), 1);
    assert_eq!(field.sphere_traced_distance(Vec3::new(50.0, 30.0, 0.0f32), RayKind::Secondary), 30.0);
}

/// Spheres, boxes, discs and sheets, each an object of its own.
fn apart(count: usize) -> Vec<Node> {
    let mut random = Random::new(21);
    (0..count)
        .map(|k| {
            let shape = shape(["sphere", "box", "disc", "rect"][k % 4]).expect("registered");
            let params = random_params(shape, &mut random);
            Node { kind: Kind::Shape { shape: shape.into(), params, tag: 0 }, placement: place(&mut random, 6.0) }
        })
        .collect()
}

#[test]
fn rays_meet_the_same_of_many_objects_by_way_of_boxes() {
    let objects = apart(400);
    let (ours, whole) = (Field::new(&objects), Field::with_shape_grids_from(&objects, usize::MAX));
    assert_eq!((ours.shapes_as_code(), whole.shapes_as_code()), (0, 400));
    let mut random = Random::new(3);
    let space = Aabb::centred(8.0, 8.0, 8.0);
    let mut hits = 0;
    for _ in 0..1000 {
        let origins: [Vec3<f32>; 8] = std::array::from_fn(|_| random.point(space));
        let directions = origins.map(|origin| {
            let offset = random.point(space) - origin;
            offset * (1.0 / offset.length())
        });
        let (t, leaf) = ours.analytic_hit(lanes(&origins), lanes(&directions));
        for k in 0..8 {
            let (one, expected) =
                (ours.analytic_hit(origins[k], directions[k]), whole.analytic_hit(origins[k], directions[k]));
            // What is missed is far away, farther than any scene.
            let near = |t: f32| (t - expected.0).abs() <= 1e-4 * expected.0 || t.min(expected.0) > 1e20;
            assert!(near(one.0) && near(t.to_array()[k]), "{one:?} {expected:?}");
            if (one.0 - expected.0).abs() == 0.0 {
                assert_eq!((one.1, leaf.to_array()[k]), (expected.1, expected.1));
            }
            hits += usize::from(expected.0 < 1e20);
            let counts: Vec<bool> = (0..400).map(|k| k % 3 != 0).collect();
            let own = (hits % 400) as f32;
            let (a, b) = (ours.distance_to(origins[k], &counts, own), whole.distance_to(origins[k], &counts, own));
            assert!((a - b).abs() < 1e-5, "{a} {b}");
            let surface = |field: &Field| field.surface_at_hit(origins[k], 5.0, &|_| 0.5f32);
            assert_eq!(surface(&ours).field.value, surface(&whole).field.value);
            assert_eq!(surface(&ours).leaf, 5.0);
        }
    }
    assert!(hits > 2000, "{hits}");
}

#[test]
fn the_code_of_many_objects_does_not_grow_with_them() {
    let program = |count: usize| {
        let objects = apart(count);
        let field = Field::new(&objects);
        let mut program = Program::new(&field);
        let counts: Vec<bool> = (0..count).map(|k| k % 2 == 0).collect();
        let sets = [("some", &counts[..])];
        program.write_object_sets(&field, &sets);
        (program, Program::distances_to(&field, &sets))
    };
    let ((few, some), (many, others)) = (program(100), program(300));
    validate(&format!("{}{}\n{}\n{some}", declared(&few), few.code, few.estimated_distance));
    assert!(few.code == many.code && some == others);
}
