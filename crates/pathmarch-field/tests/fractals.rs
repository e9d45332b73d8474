//! What only fractals have: the slope of their estimates, found by search; marches that do not pass through; orbits.

use crate::sampling::{Case, Random, cases, lanes, validate};
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{shape, shapes};
use pathmarch_field::{Aabb, Param, Shape, Unit};

fn fractals() -> impl Iterator<Item = &'static dyn Shape> {
    shapes().iter().copied().filter(|shape| shape.has_orbit())
}

fn defaults(shape: &'static dyn Shape) -> Case {
    Case::new(shape, shape.params().iter().map(|p| p.default).collect())
}

/// Parameters anywhere in their range.
fn any_params(shape: &dyn Shape, random: &mut Random) -> Vec<f32> {
    let any = |param: &Param, random: &mut Random| match param.unit {
        Unit::Degrees => random.within(-180.0, 180.0),
        Unit::Count => random.within(param.range.min, param.range.max + 1.0).floor().min(param.range.max),
        _ => random.within(param.range.min, param.range.max),
    };
    shape.params().iter().map(|param| any(param, random)).collect()
}

fn slope(case: &Case, p: Vec3<f32>) -> f32 {
    case.gradient(p).gradient.length()
}

/// Random points, and from the steepest of them a climb by ever smaller random steps.
#[test]
fn slopes_of_fractals_stay_below_their_constant() {
    for shape in fractals() {
        let mut random = Random::named(&shape.info().name, 100);
        // By random points and by climbing from them; with the defaults and with any parameters.
        let mut steepest = [[0f32; 2]; 2];
        for set in 0..300 {
            let usual = set == 0;
            let case = if usual { defaults(shape) } else { Case::new(shape, any_params(shape, &mut random)) };
            let points = case.points(if usual { 40_000 } else { 800 }, &mut random);
            let mut points: Vec<_> = points.into_iter().map(|p| (slope(&case, p), p)).collect();
            points.sort_by(|a, b| b.0.total_cmp(&a.0));
            for &(start, mut p) in &points[..8] {
                let mut here = start;
                let mut reach = 0.05 * case.size;
                while reach > 1e-6 * case.size {
                    for _ in 0..12 {
                        let q = p + random.direction() * (reach * random.within(0.0, 1.0));
                        let there = slope(&case, q);
                        if there > here {
                            (here, p) = (there, q);
                        }
                    }
                    reach *= 0.7;
                }
                assert!(here <= case.lipschitz() * 1.001, "{} {p:?}: |gradient| = {here}", case.name());
                let kind = &mut steepest[usize::from(!usual)];
                *kind = [kind[0].max(start), kind[1].max(here)];
            }
        }
        let [[usual, usual_climbed], [any, any_climbed]] = steepest;
        println!(
            "{:12} |gradient| with defaults {usual:.3}, climbed {usual_climbed:.3}; any {any:.3}, climbed {any_climbed:.3}",
            &*shape.info().name
        );
    }
}

/// The gradient does not see a jump, such as one where an orbit is left an iteration earlier.
#[test]
fn fractals_have_no_jumps() {
    let mut random = Random::new(250);
    for shape in fractals() {
        for _ in 0..200 {
            let case = Case::new(shape, any_params(shape, &mut random));
            for a in case.points(400, &mut random) {
                let b = a + random.direction() * (case.size * 10f32.powf(random.within(-5.0, 0.0)));
                let difference = (case.distance(a) - case.distance(b)).abs();
                let allowed = case.lipschitz() * (a - b).length() + 2e-6 * (a.length() + b.length() + case.size);
                assert!(difference <= allowed, "{} {a:?} {b:?}: {difference} > {allowed}", case.name());
            }
        }
    }
}

/// Between the points of a march there must be nothing of the solid: each step is looked at in 20 places.
#[test]
fn marches_do_not_pass_through_fractals() {
    const LOOKS: u32 = 20;
    for case in cases(4).iter().filter(|case| case.shape.has_orbit()) {
        let mut random = case.random(300);
        let (mut hits, mut total, mut most) = (0, 0, 0);
        for _ in 0..300 {
            let origin = random.direction() * (2.0 * case.size);
            let towards = random.point(case.bounds) - origin;
            let direction = towards / towards.length();
            let field = |t: f32| case.distance(origin + direction * t);
            let (mut t, mut steps) = (0.0, 0);
            while t < 6.0 * case.size {
                let step = field(t) / case.lipschitz();
                if step < 1e-4 * case.size {
                    hits += 1;
                    break;
                }
                for look in 1..LOOKS {
                    let between = t + step * look as f32 / LOOKS as f32;
                    let distance = field(between);
                    assert!(
                        distance > -1e-6 * case.size,
                        "{} {origin:?} {direction:?} {between}: {distance}",
                        case.name()
                    );
                }
                t += step;
                steps += 1;
            }
            total += steps;
            most = most.max(steps);
        }
        println!("{:70} {hits} of 300 rays hit, {:.1} steps each, {most} at most", case.name(), total as f32 / 300.0);
        assert!(hits > 0, "{}: no ray hits", case.name());
    }
}

/// Iterations magnify the rounding by which lanes and single points differ, so that points a few roundings away set the
/// tolerance.
#[test]
fn orbits_of_eight_lanes_equal_one_and_print_valid_wgsl() {
    for shape in fractals() {
        validate(&shape.wgsl_orbit());
    }
    for case in cases(4).iter().filter(|case| case.shape.has_orbit()) {
        let mut random = case.random(200);
        let centre = Vec3::new(0.25, -0.5, 0.125);
        for points in case.points(256, &mut random).chunks(8) {
            let side_by_side =
                case.shape.orbit(lanes(points), lanes(&[centre; 8]), &case.params).map(|trap| trap.to_array());
            for (k, &p) in points.iter().enumerate() {
                let alone = case.shape.orbit(p, centre, &case.params);
                let nearby = [-1.0, 1.0].map(|sign| case.shape.orbit(p * (1.0 + sign * 5e-7), centre, &case.params));
                for (trap, value) in alone.iter().enumerate() {
                    let other = side_by_side[trap][k];
                    let change = nearby.iter().map(|orbit| (orbit[trap] - value).abs()).fold(0.0, f32::max);
                    let tolerance = 1e-5 * value.abs().max(1.0) + 2.0 * change;
                    assert!(
                        value.is_finite() && (value - other).abs() <= tolerance,
                        "{} {p:?}: {value} {other}",
                        case.name()
                    );
                }
                let [nearest, _, _, _, farthest, iterations] = alone;
                assert!(
                    farthest >= nearest && iterations > 0.0 && iterations <= 1.0,
                    "{} {p:?}: {alone:?}",
                    case.name()
                );
            }
        }
    }
}

/// A power that is fixed in the code gives what the code for any power gives.
#[test]
fn variants_are_the_shape_that_they_stand_for() {
    let any = shape("mandelbulb").expect("registered");
    let mut random = Random::new(16);
    for power in 2..=16 {
        let params = [power as f32, 6.0];
        let variant = any.variant(&params).expect("there is one");
        assert_eq!(variant.wgsl_name(), format!("mandelbulb_{power}"));
        validate(&(variant.wgsl_distance() + &variant.wgsl_gradient() + &variant.wgsl_orbit()));
        for _ in 0..500 {
            let p = random.point(Aabb::centred(1.5, 1.5, 1.5));
            let [a, b] = [any, variant].map(|shape| shape.distance(p, &params));
            assert!((a - b).abs() < 2e-4 * (1.0 + a.abs()), "power {power} at {p:?}: {a} {b}");
        }
    }
    assert!(any.variant(&[8.0, 6.0]).is_some_and(|shape| shape.variant(&[8.0, 6.0]).is_none()));
}
