//! Repetition on a lattice, limited or endless (Quilez 2008, "Domain repetition").
//!
//! Copies are at integer multiples of the spacing; if limited, `count` of them around the origin. The nearest copy of the
//! child's point `c` is that whose number is nearest to (p - c) / spacing, so the copies to evaluate are those from
//! (p - max) / spacing to (p - min) / spacing, rounded, with the child's bounding box: two along an axis if it fits in its
//! cell, more if it does not. The distance is the least of them and continuous across cells.
//! Cost: one evaluation for each of those copies, 2 to 8 for a child that fits in its cell.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::{ModifierDef, Motion};
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use super::bounding_box::ENDLESS;

pub(crate) struct Op;

/// Spacing and number of copies along an axis; 0 copies are endless. A child that is unbounded along the axis, as a profile
/// along z, has no copies there.
fn axis(params: &[f32], inside: Aabb, k: usize) -> (f32, f32) {
    let spacing = if inside.min[k].is_finite() && inside.max[k].is_finite() { params[k] } else { 0.0 };
    (spacing, if params[4 + k] > 0.0 { params[4 + k] } else { params[3] })
}

/// Number of copies to evaluate along an axis.
fn nearby(params: &[f32], inside: Aabb, k: usize) -> f32 {
    let (spacing, count) = axis(params, inside, k);
    if spacing <= 0.0 || count == 1.0 {
        return 1.0;
    }
    let across = ((inside.max[k] - inside.min[k]).max(0.0) / spacing * 0.9999).ceil() + 1.0;
    // Copies beyond this are left out.
    let across = across.min(MAX_COPIES);
    if count > 0.0 { across.min(count) } else { across }
}

/// Largest number of copies to evaluate along an axis.
const MAX_COPIES: f32 = 5.0;

impl ModifierDef for Op {
    const INFO: Info = Info::new(
            "repeat",
            "Copies of its child on a lattice around the origin, endless unless counted.",
            "Quilez 2008, domain repetition",
        ).size_params(3);
    const PARAMS: &'static [Param] = &[
        Param::length_or_zero("x", 2.0, "Distance of the copies along x; 0 for none."),
        Param::length_or_zero("y", 0.0, "Distance of the copies along y; 0 for none."),
        Param::length_or_zero("z", 2.0, "Distance of the copies along z; 0 for none."),
        Param::count("count", 0.0, 0.0, 1e6, "Copies along each axis; 0 is endless."),
        Param::count("count-x", 0.0, 0.0, 1e6, "Copies along x; 0 for as many as `count`."),
        Param::count("count-y", 0.0, 0.0, 1e6, "Copies along y; 0 for as many as `count`."),
        Param::count("count-z", 0.0, 0.0, 1e6, "Copies along z; 0 for as many as `count`."),
    ];
    /// For each axis: spacing, middle of the copies, last copy, number of copies to evaluate, and end of the box.
    type Coefficients<N: Real> = [N; 15];
    const NEEDS_BOUNDS: bool = true;

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 15] {
        let mut coefficients = [0.0; 15];
        for k in 0..3 {
            let (spacing, count) = axis(params, inside, k);
            // Endless copies are numbered from the one at the origin.
            let (middle, last) = if count > 0.0 { (0.5 * (count - 1.0), count - 1.0) } else { (0.0, ENDLESS) };
            let used = spacing > 0.0;
            coefficients[5 * k..5 * k + 5].copy_from_slice(&[
                if used { spacing } else { 0.0 },
                if used { middle } else { 0.0 },
                if used { last } else { 0.0 },
                nearby(params, inside, k),
                inside.max[k].clamp(-ENDLESS, ENDLESS),
            ]);
        }
        coefficients
    }
    fn copies(params: &[f32], inside: Aabb) -> u32 {
        (0..3).map(|k| nearby(params, inside, k) as u32).product()
    }
    fn motions(params: &[f32], inside: Aabb, most: usize) -> Option<Vec<Motion>> {
        let mut motions = vec![Motion { turn: 0.0, offset: [0.0; 3] }];
        for k in 0..3 {
            let (spacing, count) = axis(params, inside, k);
            if spacing <= 0.0 {
                continue;
            }
            // Endless copies have no number.
            if count < 1.0 || motions.len() as f64 * f64::from(count) > most as f64 {
                return None;
            }
            let copies = |motion: Motion| {
                (0..count as u32).map(move |number| {
                    let mut copy = motion;
                    copy.offset[k] += (number as f32 - 0.5 * (count - 1.0)) * spacing;
                    copy
                })
            };
            motions = motions.into_iter().flat_map(copies).collect();
        }
        Some(motions)
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, copy: N, coefficients: [N; 15]) -> Vec3<N> {
        let half = N::constant(0.5);
        let [xs, xm, xl, xn, xe, ys, ym, yl, yn, ye, zs, zm, zl, zn, ze] = coefficients;
        // Index of the copy along each axis.
        let over_x = ((copy + half) / xn).floor().named("over_x");
        let over_y = ((over_x + half) / yn).floor().named("over_y");
        let digits = [copy - over_x * xn, over_x - over_y * yn, over_y];
        let moved = |v: N, digit: N, [spacing, middle, last, nearby, end]: [N; 5]| {
            let step = spacing.max(N::constant(1e-20));
            let first = ((v - end) / step + middle + half).floor();
            // Endless copies have no first one.
            let low = N::select(last.lt(N::constant(0.5 * ENDLESS)), N::zero(), N::constant(-ENDLESS));
            let number = first.clamp(low, (last - nearby + N::one()).max(low)) + digit;
            v - (number - middle) * spacing
        };
        Vec3::new(
            moved(p.x, digits[0], [xs, xm, xl, xn, xe]),
            moved(p.y, digits[1], [ys, ym, yl, yn, ye]),
            moved(p.z, digits[2], [zs, zm, zl, zn, ze]),
        )
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        let mut bounds = inside;
        for k in 0..3 {
            let (spacing, count) = axis(params, inside, k);
            let reach = match (spacing > 0.0, count) {
                (false, _) => 0.0,
                (true, 0.0) => f32::INFINITY,
                (true, count) => 0.5 * (count - 1.0) * spacing,
            };
            bounds.min[k] -= reach;
            bounds.max[k] += reach;
        }
        bounds
    }
}
