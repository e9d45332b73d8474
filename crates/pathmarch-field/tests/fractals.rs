//! What only fractals have: the slope of their estimates, found by search; marches that do not pass through; orbits.

mod sampling;

use pathmarch_field::number::Vec3;
use pathmarch_field::registry::shapes;
use pathmarch_field::{Shape, Unit};
use sampling::{Case, Random, cases, lanes, validate};

fn fractals() -> impl Iterator<Item = &'static dyn Shape> {
    shapes().iter().copied().filter(|shape| shape.has_orbit())
}

/// Parameters anywhere in their range.
fn any_params(shape: &dyn Shape, random: &mut Random) -> Vec<f32> {
    let any = |param: &pathmarch_field::Param, random: &mut Random| match param.unit {
        Unit::Degrees => random.within(-180.0, 180.0),
        Unit::Count => random.within(param.min, param.max + 1.0).floor().min(param.max),
        _ => random.within(param.min, param.max),
    };
    shape.params().iter().map(|param| any(param, random)).collect()
}

fn slope(case: &Case, p: Vec3<f32>) -> f32 {
    case.gradient(p).gradient.length()
}

/// Random points, and from the steepest of them a climb by ever smaller random steps.
#[test]
fn slopes_of_fractals_stay_below_their_constant() {
    for (k, shape) in fractals().enumerate() {
        let mut random = Random::new(100 + k as u64);
        let defaults: Vec<f32> = shape.params().iter().map(|p| p.default).collect();
        let mut steepest = [0f32; 4];
        let mut worst = String::new();
        for set in 0..200 {
            let params = if set == 0 { defaults.clone() } else { any_params(shape, &mut random) };
            let case = Case::new(shape, params);
            let count = if set == 0 { 40_000 } else { 800 };
            let mut points: Vec<_> = case.points(count, &mut random).into_iter().map(|p| (slope(&case, p), p)).collect();
            points.sort_by(|a, b| b.0.total_cmp(&a.0));
            let column = if set == 0 { 0 } else { 2 };
            steepest[column] = steepest[column].max(points[0].0);
            for (mut here, mut p) in points.into_iter().take(8) {
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
                if here > steepest[column + 1] {
                    steepest[column + 1] = here;
                    worst = format!("{} {p:?} {}", case.name(), case.distance(p));
                }
                assert!(here <= case.lipschitz() * 1.001 || std::env::var("MEASURE").is_ok(), "{} {p:?}: {here}", case.name());
            }
        }
        println!("{:12} defaults {:.4} climbed {:.4}, any {:.4} climbed {:.4} {worst}", shape.info().name, steepest[0], steepest[1], steepest[2], steepest[3]);
    }
}

#[test]
fn orbits_of_eight_lanes_equal_one_and_print_valid_wgsl() {
    let mut random = Random::new(200);
    for shape in fractals() {
        validate(&shape.wgsl_orbit());
    }
    for case in cases(4).iter().filter(|case| case.shape.has_orbit()) {
        for points in case.points(256, &mut random).chunks(8) {
            let side_by_side = case.shape.orbit_lanes(lanes(points), &case.params).map(|trap| trap.to_array());
            for (k, &p) in points.iter().enumerate() {
                let alone = case.shape.orbit(p, &case.params);
                for (trap, value) in alone.iter().enumerate() {
                    let other = side_by_side[trap][k];
                    assert!(value.is_finite() && (value - other).abs() <= 1e-5 * value.abs().max(1.0), "{} {p:?}: {value} {other}", case.name());
                }
                assert!(alone[4] > 0.0 && alone[4] <= 1.0, "{} {p:?}: {alone:?}", case.name());
            }
        }
    }
}
