//! Every registered operator, sharp and smooth.

mod sampling;

use pathmarch_field::number::{Dual, Vec3};
use pathmarch_field::registry::operators;
use pathmarch_field::{Aabb, Combine};
use sampling::{Random, validate};
use wide::f32x8;

/// Sharp, barely blended, blended over tens of centimetres, blended over everything.
const WIDTHS: [Option<f32>; 5] = [None, Some(0.0), Some(0.01), Some(0.3), Some(5.0)];

fn each(mut test: impl FnMut(&'static dyn Combine, Option<f32>, &mut Random)) {
    for (k, operator) in operators().iter().enumerate() {
        for width in WIDTHS {
            test(*operator, width, &mut Random::new(k as u64 + 1));
        }
    }
}

/// The `b` at which the two children show alike beside this `a`, by bisection of the sharp weight.
fn tie(operator: &'static dyn Combine, a: f32) -> f32 {
    let (mut low, mut high) = (-10.0f32, 10.0f32);
    let at_low = operator.weight(a, low, None);
    assert_ne!(at_low, operator.weight(a, high, None), "{operator:?}: one child always shows");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if operator.weight(a, middle, None) == at_low { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn every_operator_prints_valid_wgsl() {
    for operator in operators() {
        for smooth in [false, true] {
            validate(
                &(operator.wgsl_distance(smooth) + &operator.wgsl_gradient(smooth) + &operator.wgsl_weight(smooth)),
            );
        }
    }
}

#[test]
fn eight_lanes_equal_one() {
    each(|operator, width, random| {
        for _ in 0..100 {
            let a: [f32; 8] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let b: [f32; 8] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let distances = operator.distance_lanes(f32x8::from(a), f32x8::from(b), width).to_array();
            let weights = operator.weight_lanes(f32x8::from(a), f32x8::from(b), width).to_array();
            for k in 0..8 {
                assert!((distances[k] - operator.distance(a[k], b[k], width)).abs() < 1e-6, "{operator:?} {width:?}");
                assert!((weights[k] - operator.weight(a[k], b[k], width)).abs() < 1e-5, "{operator:?} {width:?}");
            }
        }
    });
}

#[test]
fn the_lipschitz_constant_of_the_children_is_kept() {
    each(|operator, width, random| {
        for _ in 0..5000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let step = 10f32.powf(random.within(-3.0, 0.0));
            let [da, db] = std::array::from_fn(|_| random.within(-step, step));
            let difference = operator.distance(a + da, b + db, width) - operator.distance(a, b, width);
            assert!(difference.abs() <= da.abs().max(db.abs()) + 1e-6, "{operator:?} {width:?} {a} {b} {da} {db}");
        }
    });
}

#[test]
fn gradients_agree_with_differences_and_stay_short_at_ties() {
    each(|operator, width, random| {
        for k in 0..2000 {
            let a = random.within(-1.0, 1.0);
            let b = if k % 4 == 0 { tie(operator, a) } else { random.within(-1.0, 1.0) };
            let dual = |value, gradient| Dual { value, gradient };
            let (ga, gb) = (random.direction(), random.direction());
            let field = operator.gradient(dual(a, ga), dual(b, gb), width);
            assert!((field.value - operator.distance(a, b, width)).abs() < 1e-6);
            let length = field.gradient.length();
            assert!(length < 1.0 + 1e-4, "{operator:?} {width:?} {a} {b}: |gradient| = {length}");
            let step = 1e-3;
            let smooth_here = width.is_some_and(|width| width > 0.1);
            if smooth_here || (b - tie(operator, a)).abs() > width.unwrap_or(0.0) + 4.0 * step {
                let slope = |da: f32, db: f32| {
                    let ahead = operator.distance(a + da * step, b + db * step, width);
                    (ahead - operator.distance(a - da * step, b - db * step, width)) / (2.0 * step)
                };
                let expected = ga * slope(1.0, 0.0) + gb * slope(0.0, 1.0);
                let apart = (expected - field.gradient).length();
                assert!(apart < 1e-2, "{operator:?} {width:?} {a} {b}: {apart} apart");
            }
        }
    });
}

#[test]
fn a_narrow_blend_is_sharp_and_a_wide_one_bounded() {
    each(|operator, width, random| {
        for _ in 0..1000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let apart = (operator.distance(a, b, width) - operator.distance(a, b, None)).abs();
            assert!(apart <= 0.25 * width.unwrap_or(0.0) + 1e-6, "{operator:?} {width:?} {a} {b}: {apart}");
        }
    });
}

#[test]
fn weights_are_shares_and_blend_continuously() {
    each(|operator, width, random| {
        for _ in 0..1000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let weight = operator.weight(a, b, width);
            assert!((0.0..=1.0).contains(&weight), "{operator:?} {width:?} {a} {b}: {weight}");
            let Some(width) = width.filter(|w| *w > 0.0) else { continue };
            let tie = tie(operator, a);
            let at_tie = operator.weight(a, tie, Some(width));
            assert!((at_tie - 0.5).abs() < 1e-3, "{operator:?} {width} {a} {tie}: {at_tie}");
            let near = b + random.within(-0.1, 0.1) * width;
            let step = (operator.weight(a, near, Some(width)) - weight).abs();
            assert!(step <= 0.5 * (near - b).abs() / width + 1e-4, "{operator:?} {width} {a} {b} {near}: {step}");
            let far = tie + 1.01 * width * if b < tie { -1.0 } else { 1.0 };
            assert_eq!(operator.weight(a, far, Some(width)), operator.weight(a, far, None), "{operator:?} {width}");
        }
    });
}

#[test]
fn bounds_hold_the_result() {
    each(|operator, width, random| {
        for _ in 0..200 {
            let centres = [random.direction(), random.direction()].map(|v| v * 0.6);
            let radii = [random.within(0.2, 0.7), random.within(0.2, 0.7)];
            let bounds = |k: usize| {
                let c = [centres[k].x, centres[k].y, centres[k].z];
                Aabb { min: c.map(|v| v - radii[k]), max: c.map(|v| v + radii[k]) }
            };
            let result = operator.bounds(bounds(0), bounds(1), width.unwrap_or(0.0));
            for _ in 0..200 {
                let p: Vec3<f32> = random.point(Aabb::centred(3.0, 3.0, 3.0));
                let [a, b] = std::array::from_fn(|k| (p - centres[k]).length() - radii[k]);
                let inside = operator.distance(a, b, width) <= 0.0;
                assert!(!inside || result.contains(p, 1e-5), "{operator:?} {width:?} {p:?} {result:?}");
            }
        }
    });
}
