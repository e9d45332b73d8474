//! Rays that meet solids in closed form: the first surface that they find is where the distance first is zero.

use crate::sampling::{Random, lanes};
use pathmarch_field::T_MAX;
use pathmarch_field::graph::Kind;
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{operator, shapes};
use pathmarch_field::{Field, Node, Placement};

/// A point of a ray.
fn at(o: [f32; 3], d: [f32; 3], t: f32) -> Vec3<f32> {
    Vec3::new(o[0] + d[0] * t, o[1] + d[1] * t, o[2] + d[2] * t)
}

/// Cosine of the angle between two vectors.
fn cosine(a: Vec3<f32>, b: Vec3<f32>) -> f32 {
    a.dot(b) / (a.length() * b.length())
}

fn unit(random: &mut Random) -> [f32; 3] {
    loop {
        let v: [f32; 3] = std::array::from_fn(|_| random.within(-1.0, 1.0));
        let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
        if (0.1..1.0).contains(&length) {
            // Some are along the axes, where quotients are of zero.
            let axis = (random.within(0.0, 12.0)) as usize;
            return match axis {
                0..3 => std::array::from_fn(|k| if k == axis { v[0].signum() } else { 0.0 }),
                _ => v.map(|x| x / length),
            };
        }
    }
}

/// Follows rays through a field of objects that are met in closed form, and compares.
fn check(field: &Field, random: &mut Random, what: &str) -> u32 {
    assert!(field.sphere_traced_bounds().is_empty(), "{what}: nothing is left to march");
    const FAR: f32 = 8.0;
    let (mut hits, mut outwards, mut agree) = (0, 0, 0);
    for _ in 0..25 {
        let rays: [([f32; 3], [f32; 3]); 8] =
            std::array::from_fn(|_| (std::array::from_fn(|_| random.within(-2.0, 2.0)), unit(random)));
        let eight = field
            .analytic_hit(
                lanes(&rays.map(|(o, _)| at(o, [0.0; 3], 0.0))),
                lanes(&rays.map(|(_, d)| at([0.0; 3], d, 1.0))),
            )
            .0
            .to_array();
        for ((o, d), lane) in rays.into_iter().zip(eight) {
            let (t, leaf) = field.analytic_hit(at(o, [0.0; 3], 0.0), at([0.0; 3], d, 1.0));
            assert!((t - lane).abs() <= 1e-4 * t.abs() || t > FAR && lane > FAR, "{what}: {t} alone, {lane} of eight");
            assert!(t > 0.0 && t <= T_MAX, "{what}: {t}");
            if t < FAR {
                hits += 1;
                let p = at(o, d, t);
                let there = field.distance(p);
                assert!(there.abs() < 2e-4, "{what}: {there} from the surface at {t} along {d:?} from {o:?}");
                let met = field.surface_at_hit(p, leaf, &|_| 0.5).field;
                assert!(met.value.abs() < 2e-4, "{what}: {} from the leaf that was met", met.value);
                let [within, without] = [-2e-3, 2e-3].map(|off| field.distance(p + met.gradient * off));
                outwards += u32::from(within < without);
                agree += u32::from(cosine(met.gradient, field.surface(p, 0).field.gradient) > 0.9999);
            }
            // On the way there it is on one side.
            let starts_inside = field.distance(at(o, d, 0.0)) < 0.0;
            for k in 1..400 {
                let s = t.min(FAR) * k as f32 / 400.0;
                let there = field.distance(at(o, d, s));
                let changed = if starts_inside { there > 5e-4 } else { there < -5e-4 };
                assert!(!changed || k == 1, "{what}: {there} at {s}, before {t}, along {d:?} from {o:?}");
            }
        }
    }
    assert!(outwards + 2 >= hits - hits / 50, "{what}: {outwards} of {hits} gradients point outwards");
    assert!(agree + 2 >= hits - hits / 50, "{what}: {agree} of {hits} normals are those of the distance");
    hits
}

fn placed(random: &mut Random) -> Placement {
    Placement {
        at: Some(std::array::from_fn(|_| random.within(-0.6, 0.6))),
        rotate: (random.within(0.0, 1.0) < 0.6).then(|| std::array::from_fn(|_| random.within(-180.0, 180.0))),
        scale: (random.within(0.0, 1.0) < 0.6).then(|| random.within(0.5, 1.5)),
        normal: None,
    }
}

fn convex(random: &mut Random) -> Node {
    let all: Vec<_> = shapes().iter().filter(|shape| shape.is_convex()).collect();
    let shape = *all[random.within(0.0, all.len() as f32 - 0.01) as usize];
    let params = shape.params().iter().map(|_| random.within(0.3, 1.5)).collect();
    Node { kind: Kind::Shape { shape: shape.into(), params, tag: 0 }, placement: placed(random) }
}

#[test]
fn every_convex_shape_is_met_where_its_distance_is_zero() {
    let mut random = Random::new(7);
    let mut count = 0;
    for shape in shapes().iter().filter(|shape| shape.is_convex()) {
        let mut hits = 0;
        for _ in 0..40 {
            let params = shape.params().iter().map(|_| random.within(0.3, 1.5)).collect();
            let node =
                Node { kind: Kind::Shape { shape: (*shape).into(), params, tag: 0 }, placement: placed(&mut random) };
            hits += check(&Field::new(&[node]), &mut random, &shape.info().name);
        }
        println!("{}: {hits} of 8000 rays hit", shape.info().name);
        assert!(hits > 200);
        count += 1;
    }
    assert!(count >= 11);
}

#[test]
fn normals_where_rays_meet_sheets_are_those_of_the_distance() {
    let mut random = Random::new(11);
    for shape in shapes().iter().filter(|shape| shape.info().sheet) {
        let (mut hits, mut agree) = (0, 0);
        for _ in 0..4000 {
            let params = shape.params().iter().map(|_| random.within(0.5, 3.0)).collect();
            let node =
                Node { kind: Kind::Shape { shape: (*shape).into(), params, tag: 0 }, placement: placed(&mut random) };
            let field = Field::new(&[node]);
            let (origin, direction) = (std::array::from_fn(|_| random.within(-2.0, 2.0)), unit(&mut random));
            let (t, leaf) = field.analytic_hit(at(origin, [0.0; 3], 0.0), at([0.0; 3], direction, 1.0));
            if t < 100.0 {
                hits += 1;
                let p = at(origin, direction, t);
                let met = field.surface_at_hit(p, leaf, &|_| 0.5).field;
                assert!(met.value.abs() < 1e-5, "{}: {}", shape.info().name, met.value);
                // Rounding decides on which of its sides the point is.
                agree += u32::from(cosine(met.gradient, field.surface(p, 0).field.gradient).abs() > 0.9999);
            }
        }
        assert!(hits > 40 && agree + 1 >= hits, "{}: {agree} of {hits}", shape.info().name);
    }
}

#[test]
fn sharp_combinations_are_met_where_their_distance_is_zero() {
    fn tree(random: &mut Random, depth: u32) -> Node {
        if depth == 0 || random.within(0.0, 1.0) < 0.2 {
            return convex(random);
        }
        let name = ["union", "intersect", "subtract"][random.within(0.0, 2.99) as usize];
        let operator = operator(name).expect("registered");
        let children = (0..2 + u32::from(random.within(0.0, 1.0) < 0.3)).map(|_| tree(random, depth - 1)).collect();
        Node { kind: Kind::Operator { operator, smooth: None, children }, placement: Placement::default() }
    }
    let mut random = Random::new(8);
    let mut hits = 0;
    for k in 0..300 {
        let node = tree(&mut random, 1 + k % 2);
        hits += check(&Field::new(&[node]), &mut random, &format!("tree {k}"));
    }
    println!("{hits} of 60000 rays hit");
    assert!(hits > 6000);
}

/// Faces in common: of the union nothing shows within, of the difference nothing is left.
#[test]
fn faces_in_common_need_no_margin() {
    let cube = |x: f32, z: f32, size: [f32; 3]| Node {
        kind: Kind::Shape {
            shape: pathmarch_field::registry::shape("box").expect("registered").into(),
            params: size.into(),
            tag: 0,
        },
        placement: Placement { at: Some([x, 0.0, z]), ..Placement::default() },
    };
    let combined = |name: &str, children: Vec<Node>| {
        let kind = Kind::Operator { operator: operator(name).expect("registered"), smooth: None, children };
        Field::new(&[Node { kind, placement: Placement::default() }])
    };
    let hit = |field: &Field, o: [f32; 3], d: [f32; 3]| field.analytic_hit(at(o, d, 0.0), at([0.0; 3], d, 1.0)).0;
    // Side by side: a ray from within leaves at the far end; one from above meets the top they have in common.
    let beside = combined("union", vec![cube(0.0, 0.0, [1.0; 3]), cube(1.0, 0.0, [1.0; 3])]);
    assert_eq!(hit(&beside, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 1.5);
    assert_eq!(hit(&beside, [0.25, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.5);
    // One within the other, with the top in common.
    let within = combined("union", vec![cube(0.0, 0.0, [1.0; 3]), cube(0.0, 0.0, [0.5, 1.0, 0.5])]);
    assert_eq!(hit(&within, [0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.5);
    // A hole through both faces.
    let hole = combined("subtract", vec![cube(0.0, 0.0, [1.0; 3]), cube(0.0, 0.0, [0.5, 1.0, 0.5])]);
    assert_eq!(hit(&hole, [0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), T_MAX);
    assert_eq!(hit(&hole, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.25);
    // A bar across a post, with faces in one plane: the ray that meets the bar beside the post meets the bar.
    let crossed = combined("union", vec![cube(0.0, 0.0, [0.1, 1.0, 0.1]), cube(0.0, 0.0, [0.1, 0.1, 1.0])]);
    let (origin, direction) = (at([1.0, 0.0, 0.0], [0.0; 3], 0.0), at([0.0; 3], [-0.95, 0.0, -0.3], 1.0));
    assert_eq!(crossed.analytic_hit(origin, direction), (1.0, 1.0));
}
