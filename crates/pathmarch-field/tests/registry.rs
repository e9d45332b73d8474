//! Every registered shape, tested over the registry with its defaults and random parameters.

use crate::sampling::{self, Case, Random, cases, validate};
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::shapes;

/// Shapes whose distance inside is only a bound.
const BOUND_INSIDE: [&str; 2] = ["ellipsoid", "menger"];

fn exact_at(case: &Case, distance: f32) -> bool {
    let info = case.shape.info();
    info.exact && (distance > 0.0 || !BOUND_INSIDE.contains(&&*info.name))
}

#[test]
fn names_and_parameters_are_sound() {
    let mut names: Vec<_> = shapes().iter().map(|shape| &*shape.info().name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), shapes().len(), "two shapes of one name");
    for shape in shapes() {
        let info = shape.info();
        assert!(info.size_params <= shape.params().len(), "{}", &*info.name);
        assert!(!info.doc.is_empty() && !info.source.is_empty(), "{}", &*info.name);
        for param in shape.params() {
            assert!(param.accepts(param.default) && !param.doc.is_empty(), "{} {}", &*info.name, &*param.name);
        }
    }
}

#[test]
fn every_shape_prints_valid_wgsl() {
    for shape in shapes() {
        let table = if shape.reads_table() { sampling::table() } else { String::new() };
        validate(&(table + &shape.wgsl_distance() + &shape.wgsl_gradient() + &shape.wgsl_hit_gradient()));
    }
}

#[test]
fn eight_lanes_equal_one() {
    for case in cases(6) {
        let mut random = case.random(1);
        case.assert_lanes_equal_one(512, &mut random);
    }
}

#[test]
fn gradients_are_finite_everywhere_and_within_the_lipschitz_constant() {
    for case in cases(6) {
        let mut random = case.random(2);
        let mut points = case.special_points();
        points.extend(case.points(1000, &mut random));
        points.extend(case.surface_points(300, &mut random));
        for p in points {
            let (distance, field) = (case.distance(p), case.gradient(p));
            let length = field.gradient.length();
            assert!(distance.is_finite() && length.is_finite(), "{} {p:?}: {distance}, {field:?}", case.name());
            assert!((distance - field.value).abs() <= 1e-6 * (p.length() + case.size), "{} {p:?}", case.name());
            assert!(length <= case.lipschitz() * 1.001, "{} {p:?}: |gradient| = {length}", case.name());
        }
    }
}

#[test]
fn gradients_of_exact_shapes_have_length_one() {
    for case in cases(6) {
        let mut random = case.random(3);
        for p in case.points(2000, &mut random) {
            let field = case.gradient(p);
            let length = field.gradient.length();
            if exact_at(&case, field.value) {
                assert!((length - 1.0).abs() < 1e-3, "{} {p:?}: |gradient| = {length}", case.name());
            }
        }
    }
}

#[test]
fn gradients_agree_with_central_differences() {
    for case in cases(6) {
        let mut random = case.random(4);
        let step = 2e-3 * case.size;
        // Fractals curve within a step.
        let tolerance = if case.shape.has_orbit() { 5e-2 } else { 2e-2 };
        let mut compared = 0;
        for p in case.points(400, &mut random).into_iter().filter(|p| p.length() < 3.0 * case.size) {
            let axes = [Vec3::new(step, 0.0, 0.0), Vec3::new(0.0, step, 0.0), Vec3::new(0.0, 0.0, step)];
            let here = case.gradient(p).gradient;
            let kink = axes.iter().flat_map(|&axis| [p + axis, p - axis]).any(|q| {
                let there = case.gradient(q).gradient;
                (there - here).length() > 0.02
            });
            if kink {
                continue;
            }
            let [x, y, z] = axes.map(|axis| (case.distance(p + axis) - case.distance(p - axis)) / (2.0 * step));
            let apart = (Vec3::new(x, y, z) - here).length();
            assert!(apart < tolerance, "{} {p:?}: {apart} apart", case.name());
            compared += 1;
        }
        assert!(compared > 100, "{}: only {compared} smooth points", case.name());
    }
}

#[test]
fn distances_keep_their_lipschitz_constant() {
    for case in cases(6) {
        let mut random = case.random(5);
        for a in case.points(2000, &mut random) {
            let step = case.size * 10f32.powf(random.within(-4.0, 1.0));
            let b = a + random.direction() * step;
            let difference = (case.distance(a) - case.distance(b)).abs();
            let allowed = case.lipschitz() * (a - b).length() + 2e-6 * (a.length() + b.length() + case.size);
            assert!(difference <= allowed, "{} {a:?} {b:?}: {difference} > {allowed}", case.name());
        }
    }
}

#[test]
fn bounds_hold_the_solid() {
    for case in cases(6) {
        let mut random = case.random(6);
        let bounds = case.shape.bounds(&case.params);
        for p in case.points(2000, &mut random) {
            assert!(
                case.distance(p) > 0.0 || bounds.contains(p, 1e-5 * case.size),
                "{} {p:?} is outside {bounds:?}",
                case.name()
            );
        }
    }
}

#[test]
fn bounds_of_exact_shapes_touch_the_surface() {
    const STEPS: usize = 32;
    for case in cases(6).iter().filter(|case| case.shape.info().exact) {
        let bounds = case.shape.bounds(&case.params);
        for (axis, face) in (0..3).flat_map(|axis| [(axis, bounds.min[axis]), (axis, bounds.max[axis])]) {
            if !face.is_finite() {
                continue;
            }
            let nearest = (0..=STEPS)
                .flat_map(|i| (0..=STEPS).map(move |j| [i, j].map(|k| k as f32 / STEPS as f32)))
                .map(|[u, v]| {
                    let mut p = [face; 3];
                    for (k, t) in [((axis + 1) % 3, u), ((axis + 2) % 3, v)] {
                        p[k] = case.bounds.min[k] + t * (case.bounds.max[k] - case.bounds.min[k]);
                    }
                    case.distance(Vec3::new(p[0], p[1], p[2]))
                })
                .fold(f32::INFINITY, f32::min);
            assert!(nearest < 0.01 * case.size, "{}: {nearest} m of air at axis {axis}, {face}", case.name());
        }
    }
}

#[test]
fn exact_distances_are_those_to_the_nearest_surface_point() {
    for case in cases(4).iter().filter(|case| case.shape.info().exact) {
        let mut random = case.random(7);
        let surface = case.surface_points(2000, &mut random);
        assert!(surface.len() > 500, "{}: {} surface points", case.name(), surface.len());
        for p in case.points(400, &mut random) {
            let field = case.gradient(p);
            if !exact_at(case, field.value) {
                continue;
            }
            let tolerance = 2e-5 * (p.length() + case.size);
            let foot = p - field.gradient * field.value;
            let missed = case.distance(foot).abs();
            // Where two features are equally near to within rounding, the direction is known to its root only.
            assert!(
                missed <= tolerance + 5e-4 * field.value.abs(),
                "{} {p:?}: {foot:?} is {missed} off the surface",
                case.name()
            );
            let nearest = surface.iter().map(|q| (p - *q).length()).fold(f32::INFINITY, f32::min);
            assert!(
                nearest >= field.value.abs() - tolerance,
                "{} {p:?}: distance {}, but a surface point at {nearest}",
                case.name(),
                field.value
            );
        }
    }
}

#[test]
fn solids_are_negative_inside_and_sheets_nowhere() {
    for case in cases(6) {
        let mut random = case.random(8);
        let points = case.points(2000, &mut random);
        let negative = points.iter().filter(|p| case.distance(**p) < 0.0).count();
        if case.shape.info().sheet {
            assert_eq!(negative, 0, "{}", case.name());
            for k in 0..100 {
                let t = k as f32 / 99.0;
                let on = Vec3::new(case.bounds.min[0] * 0.7 * t, 0.0, case.bounds.max[2] * 0.7 * (1.0 - t));
                assert_eq!(case.distance(on), 0.0, "{} {on:?}", case.name());
                assert_eq!(case.gradient(on).gradient, Vec3::new(0.0, 1.0, 0.0), "{} {on:?}", case.name());
            }
        } else {
            // The parts of a fractal are too small to be met by chance: below the surface, then.
            let below =
                case.surface_points(if case.shape.has_orbit() { 2000 } else { 0 }, &mut random).into_iter().any(|p| {
                    let gradient = case.gradient(p).gradient;
                    case.distance(p - gradient * (1e-5 * case.size / gradient.length().max(0.1))) < 0.0
                });
            assert!(negative > 0 || below, "{}: {negative} of {} points inside", case.name(), points.len());
        }
        if case.shape.bounds(&case.params).is_finite() {
            for _ in 0..100 {
                let far = random.direction() * (10.0 * case.size);
                assert!(case.distance(far) > 5.0 * case.size, "{} {far:?}", case.name());
            }
        }
    }
}

/// Whether a point is in the solid, straight from its definition; none for shapes not listed.
fn inside(name: &str, p: Vec3<f32>, k: &[f32]) -> Option<bool> {
    let (x, y, z) = (p.x.abs(), p.y.abs(), p.z.abs());
    let from_axis = p.x.hypot(p.z);
    let root = 3f32.sqrt();
    Some(match name {
        "sphere" => p.length() < k[0],
        "box" => x < k[0] / 2.0 && y < k[1] / 2.0 && z < k[2] / 2.0,
        "plane" => p.y < 0.0,
        "torus" => (from_axis - k[0]).hypot(p.y) < k[1],
        "cylinder" => from_axis < k[0] && y < k[1] / 2.0,
        "cone" => p.y > -k[1] / 2.0 && from_axis / k[0] < 0.5 - p.y / k[1],
        "capsule" => from_axis < k[0] && y < k[1] / 2.0 || from_axis.hypot(y - k[1] / 2.0) < k[0],
        "ellipsoid" => (p.x / k[0]).powi(2) + (p.y / k[1]).powi(2) + (p.z / k[2]).powi(2) < 1.0,
        "prism" => {
            let inner = k[0] / (2.0 * root);
            z < k[1] / 2.0 && p.y > -inner && root * x + p.y < 2.0 * inner
        }
        "hexprism" => y < k[1] / 2.0 && z < k[0] * root / 2.0 && root * x + z < k[0] * root,
        "pyramid" => p.y > 0.0 && x.max(z) / (k[0] / 2.0) < 1.0 - p.y / k[1],
        "octahedron" => x + y + z < k[0],
        "rounded-box" => {
            let radius = k[3].min(k[0].min(k[1]).min(k[2]) / 2.0);
            let [a, b, c] = [(x, k[0]), (y, k[1]), (z, k[2])].map(|(v, size)| (v - size / 2.0 + radius).max(0.0));
            (a * a + b * b + c * c).sqrt() < radius || a == 0.0 && b == 0.0 && c == 0.0
        }
        "link" => {
            let straight = y < k[0] / 2.0 && (x - k[1]).hypot(z) < k[2];
            straight || y >= k[0] / 2.0 && (x.hypot(y - k[0] / 2.0) - k[1]).hypot(z) < k[2]
        }
        _ => return None,
    })
}

#[test]
fn signs_follow_the_definition() {
    for case in cases(10) {
        let mut random = case.random(9);
        for p in case.points(2000, &mut random) {
            let distance = case.distance(p);
            if distance.abs() < 1e-5 * (case.size + p.length()) {
                continue;
            }
            if let Some(inside) = inside(&case.shape.info().name, p, &case.params) {
                assert_eq!(distance < 0.0, inside, "{} {p:?}: {distance}", case.name());
            }
        }
    }
}

#[test]
fn flat_and_thin_ellipsoids_stay_safe() {
    let shape = pathmarch_field::registry::shape("ellipsoid").expect("registered");
    let mut random = Random::new(10);
    for radii in [[1.0, 0.05, 1.0], [1.0, 0.05, 0.05], [1.0, 0.2, 0.05], [0.02, 1.0, 0.3], [1.0, 0.01, 1.0]] {
        let case = Case::new(shape, radii.to_vec());
        assert_eq!(case.lipschitz(), 1.0);
        let surface = case.surface_points(4000, &mut random);
        for p in case.points(2000, &mut random) {
            let field = case.gradient(p);
            assert!(field.gradient.length() < 1.001, "{radii:?} {p:?}: {field:?}");
            let nearest = surface.iter().map(|q| (p - *q).length()).fold(f32::INFINITY, f32::min);
            assert!(field.value.abs() <= nearest + 1e-5 * p.length(), "{radii:?} {p:?}: {} {nearest}", field.value);
            // On the way in, one step of the distance must arrive.
            if field.value > 0.0 {
                let foot = p - field.gradient * field.value;
                assert!(case.distance(foot).abs() < 1e-4 * (1.0 + p.length()), "{radii:?} {p:?} {foot:?}");
            }
        }
    }
}
