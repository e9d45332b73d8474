//! Every registered operator, sharp and smooth.

use crate::sampling::{Random, validate};
use pathmarch_field::number::{Dual, Vec3};
use pathmarch_field::registry::{operator, operators};
use pathmarch_field::{Aabb, Blend, BlendProfile, Operator};
use wide::f32x8;

/// Sharp, and in every profile barely blended, blended over tens of centimetres, blended over everything.
fn blends() -> Vec<Option<Blend>> {
    let mut blends = vec![None];
    for profile in BlendProfile::ALL {
        for amount in [0.0, 0.01, 0.3, 5.0] {
            let steps: &[f32] = if profile == BlendProfile::Stairs { &[1.0, 2.0, 5.0] } else { &[4.0] };
            blends.extend(steps.iter().map(|&steps| Some(Blend { amount, profile, steps })));
        }
    }
    blends
}

fn each(mut test: impl FnMut(&'static dyn Operator, Option<Blend>, &mut Random)) {
    for operator in operators().iter().filter(|operator| operator.blends()) {
        for blend in blends() {
            test(*operator, blend, &mut Random::named(&operator.info().name, 0));
        }
    }
}

fn width(blend: Option<Blend>) -> f32 {
    blend.map_or(0.0, |blend| blend.amount)
}

/// The `b` at which the two children show alike beside this `a`, by bisection of the sharp weight.
fn tie(operator: &'static dyn Operator, a: f32) -> f32 {
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
        for profile in BlendProfile::ALL.map(Some).into_iter().chain([None]) {
            validate(
                &(operator.wgsl_distance(profile) + &operator.wgsl_gradient(profile) + &operator.wgsl_weight(profile)),
            );
        }
    }
}

#[test]
fn eight_lanes_equal_one() {
    each(|operator, blend, random| {
        for _ in 0..100 {
            let a: [f32; 8] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let b: [f32; 8] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let distances = operator.distance(f32x8::from(a), f32x8::from(b), blend).to_array();
            let weights = operator.weight(f32x8::from(a), f32x8::from(b), blend).to_array();
            for k in 0..8 {
                assert!((distances[k] - operator.distance(a[k], b[k], blend)).abs() < 1e-6, "{operator:?} {blend:?}");
                assert!((weights[k] - operator.weight(a[k], b[k], blend)).abs() < 1e-5, "{operator:?} {blend:?}");
            }
        }
    });
}

#[test]
fn the_lipschitz_constant_of_the_children_is_kept() {
    each(|operator, blend, random| {
        for _ in 0..5000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let step = 10f32.powf(random.within(-3.0, 0.0));
            let [da, db] = std::array::from_fn(|_| random.within(-step, step));
            let difference = operator.distance(a + da, b + db, blend) - operator.distance(a, b, blend);
            assert!(
                difference.abs() <= da.abs().max(db.abs()) + 1e-6 * (1.0 + width(blend)),
                "{operator:?} {blend:?} {a} {b} {da} {db}"
            );
        }
    });
}

#[test]
fn gradients_agree_with_differences_and_stay_short_at_ties() {
    each(|operator, blend, random| {
        let mut compared = 0;
        for k in 0..2000 {
            let a = random.within(-1.0, 1.0);
            let b = if k % 4 == 0 { tie(operator, a) } else { random.within(-1.0, 1.0) };
            let dual = |value, gradient| Dual { value, gradient };
            let (ga, gb) = (random.direction(), random.direction());
            let field = operator.gradient(dual(a, ga), dual(b, gb), blend);
            assert!((field.value - operator.distance(a, b, blend)).abs() < 1e-6);
            let length = field.gradient.length();
            assert!(length < 1.0 + 1e-4, "{operator:?} {blend:?} {a} {b}: |gradient| = {length}");
            let step = 1e-3;
            // Away from kinks, where derivatives jump.
            let slopes = |da: f32, db: f32| {
                let axis = |k: usize| Vec3::new((k == 0) as u32 as f32, (k == 1) as u32 as f32, 0.0);
                operator.gradient(dual(a + da * step, axis(0)), dual(b + db * step, axis(1)), blend).gradient
            };
            let here = slopes(0.0, 0.0);
            let around = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (2.0, -2.0), (-2.0, 2.0)];
            if around.iter().all(|&(da, db)| (slopes(da, db) - here).length() < 0.02) {
                compared += 1;
                let slope = |da: f32, db: f32| {
                    let ahead = operator.distance(a + da * step, b + db * step, blend);
                    (ahead - operator.distance(a - da * step, b - db * step, blend)) / (2.0 * step)
                };
                let expected = ga * slope(1.0, 0.0) + gb * slope(0.0, 1.0);
                let apart = (expected - field.gradient).length();
                assert!(apart < 1e-2, "{operator:?} {blend:?} {a} {b}: {apart} apart");
            }
        }
        assert!(compared > 200, "{operator:?} {blend:?}: {compared} compared");
    });
}

#[test]
fn a_narrow_blend_is_sharp_and_a_wide_one_bounded() {
    each(|operator, blend, random| {
        for _ in 0..1000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let apart = (operator.distance(a, b, blend) - operator.distance(a, b, None)).abs();
            let share = match blend {
                Some(Blend { profile: BlendProfile::Round, .. }) => 0.2929,
                Some(Blend { profile: BlendProfile::Chamfer, .. }) => 0.5,
                Some(Blend { profile: BlendProfile::Stairs, steps, .. }) => 0.5 + 0.5 / steps,
                _ => 0.25,
            };
            assert!(apart <= share * width(blend) + 1e-6, "{operator:?} {blend:?} {a} {b}: {apart}");
        }
    });
}

#[test]
fn weights_are_shares_and_blend_continuously() {
    each(|operator, blend, random| {
        for _ in 0..1000 {
            let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
            let weight = operator.weight(a, b, blend);
            assert!((0.0..=1.0).contains(&weight), "{operator:?} {blend:?} {a} {b}: {weight}");
            let width = width(blend);
            if width == 0.0 {
                continue;
            }
            let tie = tie(operator, a);
            let at_tie = operator.weight(a, tie, blend);
            assert!((at_tie - 0.5).abs() < 1e-3, "{operator:?} {width} {a} {tie}: {at_tie}");
            let near = b + random.within(-0.1, 0.1) * width;
            let step = (operator.weight(a, near, blend) - weight).abs();
            assert!(step <= 0.5 * (near - b).abs() / width + 1e-4, "{operator:?} {width} {a} {b} {near}: {step}");
            let far = tie + 1.01 * width * if b < tie { -1.0 } else { 1.0 };
            assert_eq!(operator.weight(a, far, blend), operator.weight(a, far, None), "{operator:?} {width}");
        }
    });
}

#[test]
fn bounds_hold_the_result() {
    each(|operator, blend, random| {
        for _ in 0..200 {
            let centres = [random.direction(), random.direction()].map(|v| v * 0.6);
            let radii = [random.within(0.2, 0.7), random.within(0.2, 0.7)];
            let bounds = |k: usize| {
                let c = [centres[k].x, centres[k].y, centres[k].z];
                Aabb { min: c.map(|v| v - radii[k]), max: c.map(|v| v + radii[k]) }
            };
            let result = operator.bounds(bounds(0), bounds(1), blend);
            for _ in 0..200 {
                let p: Vec3<f32> = random.point(Aabb::centred(3.0, 3.0, 3.0));
                let [a, b] = std::array::from_fn(|k| (p - centres[k]).length() - radii[k]);
                let inside = operator.distance(a, b, blend) <= 0.0;
                assert!(!inside || result.contains(p, 1e-5), "{operator:?} {blend:?} {p:?} {result:?}");
            }
        }
    });
}

/// The surfaces between the planes of two walls are those of Mercury's library, at a right angle.
#[test]
fn seams_are_what_they_are_called() {
    let union = operator("union").expect("registered");
    let at = |profile, steps, a: f32, b: f32| union.distance(a, b, Some(Blend { amount: 1.0, profile, steps }));
    for k in 0..=100 {
        let t = k as f32 / 100.0;
        let (sine, cosine) = (t * std::f32::consts::FRAC_PI_2).sin_cos();
        assert!(at(BlendProfile::Round, 4.0, 1.0 - sine, 1.0 - cosine).abs() < 1e-6, "a circle about (1, 1), {t}");
        assert!(at(BlendProfile::Chamfer, 4.0, t, 1.0 - t).abs() < 1e-6, "a line, {t}");
        // Each step goes a fifth along one wall and then along the other.
        let whole = (5.0 * t).floor().min(4.0) / 5.0;
        assert!(at(BlendProfile::Stairs, 5.0, t, 1.0 - whole).abs() < 1e-6 || k == 100, "a tread, {t}");
        assert!(at(BlendProfile::Stairs, 5.0, whole + 0.2, 1.0 - t).abs() < 1e-6 || k == 100, "a riser, {t}");
    }
    for (k, &profile) in BlendProfile::ALL.iter().enumerate() {
        for (a, b) in [(0.0, 1.0), (1.0, 0.0), (0.0, 2.0), (-0.5, 3.0)] {
            assert!((at(profile, 4.0, a, b) - a.min(b)).abs() < 1e-6, "{k}: sharp a width away");
        }
    }
}

#[test]
fn a_morph_goes_from_one_to_the_other() {
    let morph = operator("morph").expect("registered");
    assert!(!morph.blends() && morph.params()[0].name == "amount");
    let mut random = Random::new(7);
    for _ in 0..1000 {
        let [a, b] = std::array::from_fn(|_| random.within(-1.0, 1.0));
        let amount = random.within(0.0, 1.0);
        let at = |amount: f32| morph.distance(a, b, Some(amount.into()));
        assert!((at(0.0) - a).abs() < 1e-6 && (at(1.0) - b).abs() < 1e-6);
        assert!((at(amount) - (a + (b - a) * amount)).abs() < 1e-6);
        assert!((morph.weight(a, b, Some(amount.into())) - amount).abs() < 1e-6);
        let step = random.within(-0.1, 0.1);
        let moved = morph.distance(a + step, b - step, Some(amount.into()));
        assert!((moved - at(amount)).abs() <= step.abs() + 1e-6);
    }
}
