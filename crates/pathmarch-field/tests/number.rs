//! The structured loop over every number that computes: one, eight side by side, and duals of both.

use pathmarch_field::number::{Dual, Real, Vec3};
use wide::f32x8;

/// z <- z² + c from zero, at most four times, until |z| passes 2: the last z and the number of steps.
fn orbit<N: Real>(c: N, count: N, limit: u32) -> [N; 2] {
    N::iterate(count, limit, [N::zero(), N::zero()], |[z, steps]| {
        let next = z.squared() + c;
        ([next, steps + N::one()], next.abs().lt(N::constant(2.0)))
    })
}

/// Lanes that stop after four, two, one, three, four, … steps.
const STARTS: [f32; 8] = [0.1, 1.5, 3.0, 0.8, -1.0, -2.5, 0.0, -1.9];

#[test]
fn the_state_is_kept_when_the_loop_stops() {
    assert_eq!(orbit(3.0f32, 4.0, 4), [3.0, 1.0]);
    assert_eq!(orbit(1.5f32, 4.0, 4), [3.75, 2.0]);
    assert_eq!(orbit(1.0f32, 4.0, 4), [2.0, 2.0]);
    assert_eq!(orbit(0.0f32, 4.0, 4), [0.0, 4.0]);
}

#[test]
fn count_and_limit_bound_the_loop() {
    assert_eq!(orbit(0.0f32, 4.0, 3)[1], 3.0);
    assert_eq!(orbit(0.0f32, 2.0, 4)[1], 2.0);
    assert_eq!(orbit(0.5f32, 0.0, 4), [0.0, 0.0]);
    assert_eq!(orbit(0.5f32, -1.0, 4), [0.0, 0.0]);
    let none = orbit(f32x8::splat(0.5), f32x8::splat(0.0), 4);
    assert_eq!(none.map(|lane| lane.to_array()), [[0.0; 8]; 2]);
}

#[test]
fn lanes_that_stop_early_agree_with_single_numbers() {
    let [z, steps] = orbit(f32x8::from(STARTS), f32x8::splat(4.0), 4).map(|lane| lane.to_array());
    for (k, &c) in STARTS.iter().enumerate() {
        assert_eq!([z[k], steps[k]], orbit(c, 4.0, 4), "c = {c}");
    }
    assert!((1..=4).all(|n| steps.contains(&(n as f32))), "{steps:?}");
}

#[test]
fn duals_agree_with_numbers_and_with_central_differences() {
    let variables = |x: f32| Dual::variables(Vec3::new(x, 0.0, 0.0)).x;
    let eight = Dual { value: f32x8::from(STARTS), gradient: Vec3::constant([1.0, 0.0, 0.0]) };
    let [lanes, _] = orbit(eight, Dual::constant(4.0), 4);
    for (k, &c) in STARTS.iter().enumerate() {
        let [z, steps] = orbit(variables(c), Dual::constant(4.0), 4);
        let plain = orbit(c, 4.0, 4);
        assert_eq!([z.value, steps.value], plain);
        assert_eq!([z.gradient.y, z.gradient.z, steps.gradient.x], [0.0; 3]);
        assert_eq!(lanes.value.to_array()[k], z.value);
        assert_eq!(lanes.gradient.x.to_array()[k], z.gradient.x);
        let (more, less) = (orbit(c + 1e-3, 4.0, 4), orbit(c - 1e-3, 4.0, 4));
        assert_eq!(more[1], less[1], "the starts are away from where the number of steps changes");
        let slope = (more[0] - less[0]) / 2e-3;
        assert!((z.gradient.x - slope).abs() < 1e-2 * slope.abs().max(1.0), "c = {c}: {} {slope}", z.gradient.x);
    }
}

#[test]
fn lengths_are_differentiable_at_zero() {
    let p = Dual::variables(Vec3::new(0.0f32, 0.0, 0.0));
    for length in [p.length(), p.x.hypot(p.y), Real::norm([p.x]), p.dot(p).sqrt()] {
        assert_eq!(length.value, 0.0);
        assert_eq!(length.gradient, Vec3::new(0.0, 0.0, 0.0));
    }
    let p = Dual::variables(Vec3::new(2.0f32, -3.0, 6.0));
    assert_eq!(p.length().value, 7.0);
    assert_eq!(p.length().gradient, Vec3::new(2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0));
    assert_eq!(p.y.squared().gradient, Vec3::new(0.0, -6.0, 0.0));
}
