//! Bend about z (Barr 1984, "Global and local deformations of solid primitives", section 4, with all of x bent): the x
//! axis becomes a circle through the origin whose centre is above it, at the radius R = 1 / (2π turns).
//!
//! A point at the angle θ and the distance ρ from the centre was at (R θ, R - ρ). Two points in those coordinates are
//! D² = Δρ² + R² Δθ² apart, in space at least Δρ² + 4 ρ ρ' sin²(Δθ/2), and sin(t/2) ≥ t/π up to t = π, sin(t/2) ≥ 0.15 t up to
//! 3π/2. So the distance, times 2/π (0.3 behind the centre) √(ρ ρ') / R, is a bound, with the least ρ' of the solid. The
//! smaller of ρ and ρ' instead of the root of their product keeps the slope near the solid below one, so that modifiers of
//! the result (`round`, `shell`) are safe, too. Solids longer than half a circle are cut there. Far from the solid the distance
//! to its bounding box is the better bound; the larger of the two is used.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, TAU};
use super::bounding_box::{ENDLESS, box_distance, corners};

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new("bend", "Bends the x axis of its child upwards into a circle.", "Barr 1984, section 4").inexact();
    const PARAMS: &'static [Param] = &[Param::between("turns-per-metre", 0.1, 1e-4, 100.0, "Turns over a metre of the x axis; at most half a turn of it is kept.")];
    type Coefficients<N: Real> = [N; 8];
    const NEEDS_BOUNDS: bool = true;

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 8] {
        let radius = 1.0 / (TAU * params[0]);
        let [a, b, c, d, e, f] = corners(Self::bounds(params, inside));
        [radius, (radius - inside.max[1]).clamp(0.02 * radius, ENDLESS), a, b, c, d, e, f]
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, _place: N, coefficients: [N; 8]) -> Vec3<N> {
        let radius = coefficients[0];
        let up = (radius - p.y).named("up");
        Vec3::new(p.x.atan2(up) * radius, radius - p.x.hypot(up), p.z)
    }
    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, inside: N, [radius, least, a, b, c, d, e, f]: [N; 8]) -> N {
        let up = radius - p.y;
        let (away, turn) = (p.x.hypot(up).named("away"), p.x.atan2(up).abs());
        let factor = N::select(turn.lt(N::constant(FRAC_PI_2)), N::constant(FRAC_2_PI), N::constant(0.3));
        let squeeze = (factor * away.min(least) / radius).min(N::one());
        // Everything beyond a quarter of a turn on either side is cut.
        let cut = (turn - N::constant(FRAC_PI_2)) * radius;
        (inside.max(cut) * squeeze).max(box_distance(p, [a, b, c, d, e, f]))
    }
    fn inner_margin(_params: &[f32], _inside: Aabb, margin: f32) -> Option<f32> {
        // Distances shrink without limit towards the axis.
        (margin == 0.0).then_some(0.0)
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        let radius = 1.0 / (TAU * params[0]);
        let turns = |x: f32| (x / radius).clamp(-FRAC_PI_2, FRAC_PI_2);
        let (from, to) = (turns(inside.min[0]), turns(inside.max[0]));
        let (near, far) = ((radius - inside.max[1]).max(0.0), (radius - inside.min[1]).max(0.0));
        let mut bounds = Aabb { min: [f32::INFINITY, f32::INFINITY, inside.min[2]], max: [f32::NEG_INFINITY, f32::NEG_INFINITY, inside.max[2]] };
        for turn in [from, to, 0.0_f32.clamp(from, to)] {
            for away in [near, far] {
                let point = [away * turn.sin(), radius - away * turn.cos()];
                for (k, at) in point.into_iter().enumerate() {
                    bounds.min[k] = bounds.min[k].min(at);
                    bounds.max[k] = bounds.max[k].max(at);
                }
            }
        }
        bounds
    }
}
