//! Outlines: against the distance to all segments and the definition of inside, at random points.

use crate::sampling::{self, Random, lanes};
use pathmarch_field::graph::Kind;
use pathmarch_field::number::{Dual, Vec3};
use pathmarch_field::outline::{Cubic, Fill, SplinePoint, arcs, contour, has_area, smooth, through};
use pathmarch_field::registry::shape;
use pathmarch_field::wgsl::Program;
use pathmarch_field::{Aabb, Field, Node, Placement, Shape};
use std::time::Instant;

fn drawn(fill: Fill) -> &'static dyn Shape {
    shape(if fill == Fill::EvenOdd { "polygon" } else { "text" }).expect("registered")
}

fn table(segments: &[f32], fill: Fill) -> Vec<f32> {
    let shape = drawn(fill);
    let params: Vec<f32> = shape.params().iter().map(|_| 1.0).chain(segments.iter().copied()).collect();
    shape.coefficients(&params)
}

fn to_segment(p: [f64; 2], s: &[f32]) -> f64 {
    let [ax, ay, bx, by] = [0, 1, 2, 3].map(|k| f64::from(s[k]));
    let (x, y, dx, dy) = (p[0] - ax, p[1] - ay, bx - ax, by - ay);
    let t = ((x * dx + y * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (x - t * dx).hypot(y - t * dy)
}

/// How often the segments go around a point, and how many a way to +x crosses.
fn around(p: [f64; 2], segments: &[f32]) -> (i32, u32) {
    let (mut turns, mut crossed) = (0, 0);
    for s in segments.chunks_exact(4) {
        let [ax, ay, bx, by] = [0, 1, 2, 3].map(|k| f64::from(s[k]));
        if (ay <= p[1]) != (by <= p[1]) && ax + (p[1] - ay) / (by - ay) * (bx - ax) > p[0] {
            crossed += 1;
            turns += if ay <= p[1] { 1 } else { -1 };
        }
    }
    (turns, crossed)
}

fn is_inside(p: [f64; 2], segments: &[f32], fill: Fill) -> bool {
    let (turns, crossed) = around(p, segments);
    match fill {
        Fill::EvenOdd => crossed % 2 == 1,
        Fill::NonZero => turns != 0,
    }
}

/// Simple, concave, crossing itself, with holes, overlapping, touching, degenerate.
fn outlines() -> Vec<(&'static str, Vec<f32>)> {
    let square = |x: f32, y: f32, half: f32, back: bool| {
        let mut points = [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]];
        if back {
            points.reverse();
        }
        contour(&points).collect::<Vec<f32>>()
    };
    let mut random = Random::new(11);
    let mut any = |count: usize| -> Vec<f32> {
        let points: Vec<[f32; 2]> = (0..count).map(|_| [random.within(-1.0, 1.0), random.within(-0.6, 0.6)]).collect();
        contour(&points).collect()
    };
    let gear: Vec<[f32; 2]> = (0..96)
        .map(|k| {
            let (sine, cosine) = (k as f32 * std::f32::consts::TAU / 96.0).sin_cos();
            let radius = if k % 4 < 2 { 1.0 } else { 0.8 };
            [radius * cosine, radius * sine]
        })
        .collect();
    vec![
        ("triangle", contour(&[[0.0, 0.0], [1.0, 0.0], [0.2, 0.9]]).collect()),
        ("backwards", contour(&[[0.0, 0.0], [0.2, 0.9], [1.0, 0.0]]).collect()),
        (
            "horseshoe",
            contour(&[
                [-1.0, -1.0],
                [1.0, -1.0],
                [1.0, 1.0],
                [0.6, 1.0],
                [0.6, -0.6],
                [-0.6, -0.6],
                [-0.6, 1.0],
                [-1.0, 1.0],
            ])
            .collect(),
        ),
        ("bow", contour(&[[-1.0, -0.5], [1.0, 0.5], [1.0, -0.5], [-1.0, 0.5]]).collect()),
        ("pentagram", {
            let point = |k: usize| {
                let (sine, cosine) = (k as f32 * 0.8 * std::f32::consts::PI).sin_cos();
                [sine, cosine]
            };
            contour(&[0, 1, 2, 3, 4].map(point)).collect()
        }),
        ("gear", contour(&gear).collect()),
        ("square with a hole", [square(0.0, 0.0, 1.0, false), square(0.1, 0.0, 0.5, true)].concat()),
        ("overlap", [square(0.0, 0.0, 0.6, false), square(0.5, 0.4, 0.6, false)].concat()),
        ("twice", [square(0.0, 0.0, 0.6, false), square(0.0, 0.0, 0.6, false)].concat()),
        ("two that touch", [square(-0.5, 0.0, 0.5, false), square(0.5, 0.2, 0.5, false)].concat()),
        (
            "corner on a side",
            [square(0.0, 0.0, 0.5, false), contour(&[[0.5, 0.0], [1.2, -0.3], [1.2, 0.4]]).collect()].concat(),
        ),
        ("any 9", any(9)),
        ("any 40", any(40)),
        ("any 256", any(256)),
    ]
}

#[test]
fn distances_are_those_to_the_edge_of_what_is_inside() {
    for (name, segments) in outlines() {
        for fill in [Fill::EvenOdd, Fill::NonZero] {
            if has_area(&segments, fill) == Some(false) {
                continue;
            }
            let (shape, table) = (drawn(fill), table(&segments, fill));
            let mut random = Random::new(3);
            let (mut inside, mut exact) = (0, 0);
            for k in 0..4000 {
                let reach = if k % 2 == 0 { 1.2 } else { 4.0 };
                let p = random.point(Aabb::centred(reach, reach, 9.0));
                let at = [f64::from(p.x), f64::from(p.y)];
                let field = shape.gradient(Dual::variables(p), &table);
                let distance = shape.distance(p, &table);
                assert!((distance - field.value).abs() < 1e-5);
                let to_any = segments.chunks_exact(4).map(|s| to_segment(at, s)).fold(f64::INFINITY, f64::min) as f32;
                if to_any > 1e-5 {
                    assert_eq!(distance < 0.0, is_inside(at, &segments, fill), "{name} {fill:?} {p:?}: {distance}");
                }
                inside += u32::from(distance < 0.0);
                // Segments that divide nothing do not count, and far away it is a bound.
                assert!(distance.abs() > 0.7 * to_any - 1e-5, "{name} {fill:?} {p:?}: {distance} for {to_any}");
                if reach < 2.0 && (distance.abs() - to_any).abs() < 1e-5 {
                    exact += 1;
                }
                let length = field.gradient.length();
                assert!(length < 1.0 + 1e-3, "{name} {p:?}: {length}");
                // The ball around a point is on its side: the sign changes nowhere in it.
                for _ in 0..4 {
                    let way = random.direction();
                    let flat = way.x.hypot(way.y).max(1e-3);
                    let step = distance.abs() * random.within(0.3, 0.9999) / flat;
                    let q = [at[0] + f64::from(way.x * step), at[1] + f64::from(way.y * step)];
                    let near_edge = segments.chunks_exact(4).any(|s| to_segment(q, s) < 1e-5);
                    assert!(
                        near_edge || is_inside(q, &segments, fill) == (distance < 0.0),
                        "{name} {fill:?} {p:?}: {distance}, {q:?}"
                    );
                }
            }
            assert!(inside > 0 && exact > 200, "{name} {fill:?}: {inside} inside, {exact} exact");
        }
    }
}

/// What is exact near the outline: a simple polygon, in and around its box.
#[test]
fn polygons_are_exact_near_by_and_bounds_far_away() {
    for (name, segments) in outlines().into_iter().take(6) {
        let (shape, table) = (drawn(Fill::NonZero), table(&segments, Fill::NonZero));
        let bounds = shape.bounds(&table);
        let mut random = Random::new(4);
        let mut least = 1.0_f32;
        for k in 0..4000 {
            let wide = if k % 2 == 0 { 0.0 } else { 10.0 };
            let p = random.point(Aabb {
                min: [bounds.min[0] - wide, bounds.min[1] - wide, 0.0],
                max: [bounds.max[0] + wide, bounds.max[1] + wide, 0.0],
            });
            let at = [f64::from(p.x), f64::from(p.y)];
            let to_any = segments.chunks_exact(4).map(|s| to_segment(at, s)).fold(f64::INFINITY, f64::min) as f32;
            let distance = shape.distance(p, &table).abs();
            if wide == 0.0 && name != "bow" && name != "pentagram" {
                assert!((distance - to_any).abs() < 1e-5 * (1.0 + to_any), "{name} {p:?}: {distance} for {to_any}");
            } else {
                assert!(
                    distance <= to_any.max(distance - 1.0) + 1e-4 || name == "pentagram",
                    "{name} {p:?}: {distance} for {to_any}"
                );
                least = least.min(distance / to_any);
            }
        }
        println!("{name}: far away at least {least} of the distance");
        assert!(least > 0.7 || name == "pentagram", "{name}: {least}");
    }
}

#[test]
fn normals_are_right_on_the_edge_itself() {
    let (_, segments) = outlines().remove(5);
    let (shape, table) = (drawn(Fill::NonZero), table(&segments, Fill::NonZero));
    let mut random = Random::new(5);
    for s in segments.chunks_exact(4) {
        for _ in 0..20 {
            let t = random.within(0.02, 0.98);
            let p = Vec3::new(s[0] + t * (s[2] - s[0]), s[1] + t * (s[3] - s[1]), 0.3);
            let field = shape.gradient(Dual::variables(p), &table);
            let (x, y) = (s[2] - s[0], s[3] - s[1]);
            let outwards = Vec3::new(y, -x, 0.0) / x.hypot(y);
            assert!(field.value.abs() < 1e-6 && (field.gradient - outwards).length() < 1e-4, "{p:?}: {field:?}");
        }
    }
}

#[test]
fn what_has_no_area_is_nowhere() {
    let flat: Vec<f32> = contour(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).collect();
    let point: Vec<f32> = contour(&[[1.0, 0.0]; 3]).collect();
    for segments in [flat, point, vec![0.0; 8], Vec::new()] {
        assert_eq!([Fill::EvenOdd, Fill::NonZero].map(|fill| has_area(&segments, fill)), [Some(false); 2]);
        if !segments.is_empty() {
            let table = table(&segments, Fill::EvenOdd);
            assert!(drawn(Fill::EvenOdd).distance(Vec3::new(0.5, 0.25, 0.0), &table) > 0.0);
        }
    }
    assert_eq!(has_area(&outlines()[0].1, Fill::EvenOdd), Some(true));
    let twice = outlines().into_iter().find(|(name, _)| *name == "twice").expect("there").1;
    assert_eq!([Fill::EvenOdd, Fill::NonZero].map(|fill| has_area(&twice, fill)), [Some(false), Some(true)]);
}

#[test]
fn other_points_and_more_of_them_have_the_same_code() {
    let node = |segments: &[f32]| {
        let shape = drawn(Fill::EvenOdd).into();
        let child =
            Node { kind: Kind::Shape { shape, params: segments.to_vec(), tag: 0 }, placement: Placement::default() };
        let Some(pathmarch_field::Solid::Modifier(extrude)) = pathmarch_field::registry::solid("extrude") else {
            panic!()
        };
        Node {
            kind: Kind::Modifier { modifier: extrude, params: vec![0.5], children: vec![child] },
            placement: Placement::default(),
        }
    };
    let all = outlines();
    let programs: Vec<Program> = [&all[0], &all[5], &all[13]]
        .map(|(_, segments)| Program::new(&Field::new(&[node(segments), node(&all[2].1)])))
        .into();
    assert!(programs.iter().all(|program| program.code == programs[0].code && !program.is_uniform()));
    assert!(programs[0].parameters.len() < programs[2].parameters.len());
    sampling::validate(&(sampling::declared(&programs[0]) + &programs[0].code));
}

/// How large tables are, how long they take to make, and how many segments an evaluation looks at.
#[test]
fn cost_does_not_grow_with_the_outline() {
    for letters in [1, 10, 100, 160] {
        // Rings in a row, like letters.
        let ring = |letter: usize, radius: f32, back: f32| -> Vec<[f32; 2]> {
            let point = |k: usize| {
                let (sine, cosine) = (back * k as f32 / 60.0 * std::f32::consts::TAU).sin_cos();
                [letter as f32 + radius * cosine, 1.4 * radius * sine]
            };
            (0..60).map(point).collect()
        };
        let rings = (0..letters).flat_map(|letter| [ring(letter, 0.4, 1.0), ring(letter, 0.3, -1.0)]);
        let segments: Vec<f32> = rings.flat_map(|points| contour(&points).collect::<Vec<_>>()).collect();
        let count = segments.len() / 4;
        let start = Instant::now();
        let table = table(&segments, Fill::NonZero);
        let made = start.elapsed();
        let cells = (table[8] * table[9]) as usize;
        let lists: f32 = (0..cells).map(|k| table[12 + 4 * k + 1]).sum();
        let longest = (0..cells).map(|k| table[12 + 4 * k + 1]).fold(0.0, f32::max);
        let mean = lists / cells as f32;
        println!(
            "{count} segments: {cells} cells, {mean:.2} segments each, at most {longest}; {} kB in {made:?}",
            table.len() / 256
        );
        assert!(mean < 16.0 && longest < 64.0 && table.len() * 4 < 1200 * count);
        let shape = drawn(Fill::NonZero);
        let mut random = Random::new(6);
        let points: Vec<Vec3<f32>> = (0..8).map(|_| random.point(Aabb::centred(1.0, 0.6, 1.0))).collect();
        let packed = shape.distance(lanes(&points), &table).to_array();
        for (k, p) in points.iter().enumerate() {
            assert!((packed[k] - shape.distance(*p, &table)).abs() < 1e-6);
        }
    }
}

fn curve_shape(name: &str, width: f32, curves: &[Cubic]) -> (&'static dyn Shape, Vec<f32>) {
    let shape = shape(name).expect("registered");
    let table = shape.coefficients(&[&[width][..], &arcs(curves)].concat());
    (shape, table)
}

/// Points along Bézier curves, so near to each other that the chords between them are within a millionth.
fn sampled(curves: &[Cubic]) -> Vec<f32> {
    let at = |Cubic(points): &Cubic, t: f32| {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        [0, 1].map(|k| weights.iter().zip(points).map(|(weight, point)| weight * point[k]).sum::<f32>())
    };
    let parts = |curve: &Cubic| (0..=400).map(|k| at(curve, k as f32 / 400.0)).collect::<Vec<_>>();
    curves
        .iter()
        .flat_map(|curve| {
            parts(curve).windows(2).flat_map(|p| [p[0][0], p[0][1], p[1][0], p[1][1]]).collect::<Vec<_>>()
        })
        .collect()
}

/// A drop, a curve with corners, one that crosses itself, a ring of four Bézier arcs with a hole.
fn curves() -> Vec<(&'static str, Vec<Cubic>)> {
    let corner = |x: f32, y: f32, is_corner: bool| SplinePoint { at: [x, y], is_corner };
    let kappa = 0.552_284_8;
    let ring = |r: f32, back: bool| {
        let quarter = |[ax, ay]: [f32; 2], [bx, by]: [f32; 2]| {
            let toward = |p: [f32; 2], q: [f32; 2]| [p[0] + kappa * q[0], p[1] + kappa * q[1]];
            let points = [[ax, ay], toward([ax, ay], [bx, by]), toward([bx, by], [ax, ay]), [bx, by]];
            Cubic(points.map(|p| p.map(|v| v * r)))
        };
        let ends = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let all = (0..4)
            .map(|k| if back { quarter(ends[(k + 1) % 4], ends[k]) } else { quarter(ends[k], ends[(k + 1) % 4]) });
        if back { all.rev().collect::<Vec<_>>() } else { all.collect() }
    };
    vec![
        ("drop", smooth(&[[0.0, -0.5], [0.4, -0.1], [0.1, 0.3], [0.0, 0.6], [-0.1, 0.3], [-0.4, -0.1]], true)),
        (
            "corners",
            through(
                &[
                    corner(-0.5, -0.5, true),
                    corner(0.6, -0.4, true),
                    corner(0.1, 0.0, false),
                    corner(0.5, 0.5, true),
                    corner(-0.4, 0.6, false),
                ],
                true,
            ),
        ),
        ("eight", smooth(&[[-0.6, -0.4], [0.6, 0.4], [0.6, -0.4], [-0.6, 0.4]], true)),
        ("ring", [ring(0.8, false), ring(0.4, true)].concat()),
    ]
}

#[test]
fn curves_have_the_distance_of_finely_sampled_ones() {
    for (name, curves) in curves() {
        let segments = sampled(&curves);
        let nearest =
            |at: [f64; 2]| segments.chunks_exact(4).map(|s| to_segment(at, s)).fold(f64::INFINITY, f64::min) as f32;
        for (shape_name, fill) in [("curve", Fill::EvenOdd), ("path", Fill::NonZero)] {
            let (shape, filled) = curve_shape(shape_name, 0.0, &curves);
            let (_, line) = curve_shape(shape_name, 0.1, &curves);
            let bounds = shape.bounds(&filled);
            let mut random = Random::new(7);
            let mut inside = 0;
            for _ in 0..3000 {
                let p = random.point(Aabb::centred(1.2, 1.2, 1.0));
                let at = [f64::from(p.x), f64::from(p.y)];
                let (distance, to_line) = (shape.distance(p, &filled), shape.distance(p, &line));
                let exact = nearest(at);
                let is_inside = is_inside(at, &segments, fill);
                if exact > 1e-4 {
                    assert_eq!(distance < 0.0, is_inside, "{name} {fill:?} {p:?}: {distance}, {exact}");
                }
                // A part of an outline that crosses itself may be no border of an area.
                let in_cells = p.x.abs().max(p.y.abs()) < 0.6;
                if in_cells && (name != "eight" || fill == Fill::EvenOdd) {
                    assert!((distance.abs() - exact).abs() < 1e-5, "{name} {fill:?} {p:?}: {distance} for {exact}");
                    assert!((to_line - (exact - 0.05)).abs() < 1e-5, "{name} {p:?}: {to_line} for {exact} less 0.05");
                }
                assert!(distance <= exact + 1e-5 || fill == Fill::NonZero, "{name} {p:?}: {distance} for {exact}");
                if is_inside && exact > 1e-4 {
                    assert!(
                        (0..2).all(|k| [p.x, p.y][k] >= bounds.min[k] && [p.x, p.y][k] <= bounds.max[k]),
                        "{name} {p:?}"
                    );
                }
                inside += u32::from(distance < 0.0);
                let field = shape.gradient(Dual::variables(p), &filled);
                assert!(
                    (field.value - distance).abs() < 1e-5 && field.gradient.length() < 1.0 + 1e-3,
                    "{name} {p:?}: {field:?}"
                );
            }
            assert!(inside > 100, "{name}: {inside} inside");
        }
    }
}

/// A polygon of as many chords has steps of degrees.
#[test]
fn normals_of_curves_have_no_steps() {
    let circle: Vec<[f32; 2]> =
        (0..8).map(|k| (k as f32 * std::f32::consts::FRAC_PI_4).sin_cos()).map(|(y, x)| [x, y]).collect();
    let (shape, table) = curve_shape("curve", 0.0, &smooth(&circle, true));
    let count = 20_000;
    let normal = |k: i32| {
        let (y, x) = (k as f32 / count as f32 * std::f32::consts::TAU).sin_cos();
        // On the surface: the distance is followed along its gradient.
        let mut p = Vec3::new(x, y, 0.0);
        for _ in 0..4 {
            let field = shape.gradient(Dual::variables(p), &table);
            p = p - field.gradient * field.value;
        }
        shape.gradient(Dual::variables(p), &table).gradient
    };
    let steps = (0..count).map(|k| (normal(k + 1) - normal(k)).length()).fold(0.0, f32::max);
    // Evenly spread, a step is 0.0003.
    assert!(steps < 0.0015, "{steps}");
}

#[test]
fn splines_go_through_their_points_and_lines_have_round_ends() {
    let points = [[0.04, 0.003], [0.004, 0.02], [0.004, 0.09], [0.045, 0.14], [0.036, 0.22]];
    let (shape, table) = curve_shape("curve", 0.006, &smooth(&points, false));
    for [x, y] in points {
        assert!((shape.distance(Vec3::new(x, y, 0.0), &table) + 0.003).abs() < 1e-6);
    }
    // Above the last point the nearest one is that point.
    let end: f32 = shape.distance(Vec3::new(0.036, 0.24, 0.0), &table);
    assert!((end - 0.017).abs() < 1e-6, "{end}");
    // A corner stays one: the ends of two lines.
    let corner = |is_corner| {
        let at = |x: f32, y: f32, is_corner| SplinePoint { at: [x, y], is_corner };
        let curves = through(&[at(0.0, 0.0, false), at(1.0, 0.0, is_corner), at(1.0, 1.0, false)], false);
        let (shape, table) = curve_shape("curve", 0.02, &curves);
        shape.distance(Vec3::new(0.5, 0.0, 0.0), &table)
    };
    assert!((corner(true) + 0.01_f32).abs() < 1e-6 && corner(false) > 0.0_f32);
}
