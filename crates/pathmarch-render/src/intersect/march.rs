//! Sphere tracing: step along the ray by the distance to the nearest surface until that distance is negligible
//! (Hart 1996, "Sphere tracing: a geometric method for the antialiased ray tracing of implicit surfaces"). Objects that
//! are a single shape whose intersection with a ray is known in closed form are met directly; only what blends, subtracts
//! or has no closed form is marched, within its box and up to the nearest direct hit.
//!
//! Negligible means a share (`Settings::detail`, a tenth) of what a pixel covers at the length of the path so far, and never
//! less than what `f32` resolves at the point: far surfaces do not shimmer, near ones keep their detail. A ray starts off its surface by three roundings and a twentieth of what the march left, far less than
//! is negligible, so that it does not pass what touches the surface; while the distance rises from there, closeness is no
//! hit. The magnitude of the field is marched, so that the inside of a solid can be seen. One that has used up its steps
//! close to a surface (under a hundredth of its length, as towards a horizon) hits it there, else it is lost.
//!
//! Steps are longer than the distance where it falls by less than the way that is gone (Bán and Valasek 2023, "Automatic
//! Step Size Relaxation in Sphere Tracing", after Keinert et al. 2014, section 3.1): as long as the balls around two points
//! that are free by their distances still touch, nothing is between them. Where they do not, the march goes back to the end
//! of the first ball, so that it never passes what plain sphere tracing would not.
//!
//! That tolerance makes every surface larger by it, which is seen where a lamp is sphere-traced: a ball of 64 pixels
//! lit its surroundings by 0.6 % too much. In scenes with such a lamp, a ray that passes a surface at a grazing angle
//! must come sixteen times as close ([`KernelConfig::refined_grazing`]); not next to fractals, whose surface *is* where rays end.
//!
//! On the CPU, eight rays march side by side; a lane whose ray has ended takes the next one.

use super::ray::{Hit, Ray, RaySegment, Rays8, lanes};
use crate::ray_stats::MarchStats;
#[cfg(doc)]
use crate::scene::KernelConfig;
use crate::scene::{FrameUniforms, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

shared_constants! {
    /// Rounding errors by which distances may differ from their Lipschitz bound without being reported.
    const NOISE: f32 = 16.0;
    /// Steps after which a march gives up.
    pub(crate) const MAX_STEPS: u32 = 256;
    /// How the distance changes along a ray, at the least and at the most.
    const STEEPEST_FALL: f32 = -1.0;
    const STEEPEST_RISE: f32 = 0.6;
    /// A ray grazes where the distance along it changes by more than this per metre.
    const GRAZING_SLOPE: f32 = -0.5;
    /// Share of the tolerance at which a ray that grazes hits a surface, see [`KernelConfig::refined_grazing`].
    const GRAZING_TOLERANCE: f32 = 0.0625;
    /// How far off a surface a ray starts, in roundings.
    const START_OFFSET: f32 = 3.0;
}

/// What is negligible at a point of a path of this length.
pub(crate) fn tolerance(frame: &FrameUniforms, p: Vec3, path_length: f32) -> f32 {
    (frame.tolerance * path_length).max(frame.rounding * p.abs().max_element())
}

/// How far off a surface a ray starts; `off` is the rounding there and `distance` that of the point that was reached.
pub(crate) fn start_offset(off: f32x8, distance: f32x8) -> f32x8 {
    f32x8::splat(START_OFFSET) * off + f32x8::splat(0.05) * distance.abs()
}

/// How far from a surface a point on it may be by rounding; `at` is the origin of its coordinates.
pub(crate) fn rounding_at(frame: &FrameUniforms, p: FieldVec3<f32x8>, at: FieldVec3<f32x8>) -> f32x8 {
    f32x8::splat(frame.rounding) * p.abs().largest().fast_max((p - at).abs().largest())
}

/// Part of a ray that is sphere-traced, metres from its origin, and the analytic hit behind it.
#[derive(Clone, Copy)]
struct Interval {
    start: f32,
    end: f32,
    otherwise: Option<Hit>,
}

/// Intersects eight rays with the analytic shapes and with the bounds of all others.
fn intervals(field: &Field, frame: &FrameUniforms, rays: &Rays8) -> [Interval; 8] {
    let (analytic, leaf) = field.analytic_hit(rays.origin, rays.direction);
    let last = rays.limit.fast_min(f32x8::splat(frame.far));
    let (mut start, mut end) = (f32x8::ZERO, analytic.fast_min(last));
    let [min, max] = [frame.bounds_min, frame.bounds_max];
    if (0..3).any(|axis| min[axis] > max[axis]) {
        // Nothing is marched.
        end = f32x8::splat(-1.0);
    } else {
        let axes =
            [(rays.origin.x, rays.direction.x), (rays.origin.y, rays.direction.y), (rays.origin.z, rays.direction.z)];
        for (axis, (o, d)) in axes.into_iter().enumerate() {
            let inverse = f32x8::ONE / d.divisor();
            let (a, b) = ((f32x8::splat(min[axis]) - o) * inverse, (f32x8::splat(max[axis]) - o) * inverse);
            start = start.fast_max(a.fast_min(b));
            end = end.fast_min(a.fast_max(b));
        }
    }
    let (start, end) = (start.to_array(), end.to_array());
    let (analytic, leaf, last) = (analytic.to_array(), leaf.to_array(), last.to_array());
    std::array::from_fn(|lane| Interval {
        start: start[lane],
        end: end[lane],
        otherwise: (analytic[lane] < last[lane])
            .then_some(Hit { t: analytic[lane], analytic: Some(leaf[lane] as u32) }),
    })
}

/// First hit of each ray, if it has one.
pub(crate) fn march(ctx: &TraceContext, rays: &[RaySegment]) -> Vec<Option<Hit>> {
    let Some(counters) = ctx.stats else { return trace::<false>(ctx, rays, &mut []) };
    let (hits, stats) = march_with_stats(ctx, rays);
    counters.add(&stats);
    hits
}

/// [`march`], with the statistics of each ray.
pub(crate) fn march_with_stats(ctx: &TraceContext, rays: &[RaySegment]) -> (Vec<Option<Hit>>, Vec<MarchStats>) {
    let mut stats = vec![MarchStats::default(); rays.len()];
    (trace::<true>(ctx, rays, &mut stats), stats)
}

/// [`march`]; with `STATS`, `stats` has a place for each ray.
fn trace<const STATS: bool>(ctx: &TraceContext, rays: &[RaySegment], stats: &mut [MarchStats]) -> Vec<Option<Hit>> {
    let (field, frame) = (&ctx.scene.field, ctx.frame);
    const IDLE: usize = usize::MAX;
    let mut hits = Vec::with_capacity(rays.len());
    let mut marched = Vec::new();
    for chunk in rays.chunks(8) {
        for interval in &intervals(field, frame, &Rays8::new(chunk.iter()))[..chunk.len()] {
            if interval.start < interval.end {
                marched.push((hits.len(), *interval));
            }
            hits.push(interval.otherwise);
        }
    }
    let mut queue = marched.into_iter();
    let mut lane_ray = [IDLE; 8];
    let mut steps = [0u32; 8];
    // Per lane: origin, direction, t, limit, length before; last distance, which is infinite once the ray has left the surface
    // that it starts on; what is free around the last point, and the step from there.
    let mut state = [[0.0f32; 8]; 12];
    // What is watched: last t, the unsigned distance there, and the steepest change so far.
    let mut watched = [f32x8::ZERO; 3];
    let mut refill = |lane: usize, lane_ray: &mut [usize; 8], state: &mut [[f32; 8]; 12], steps: &mut [u32; 8]| {
        lane_ray[lane] = IDLE;
        if let Some((index, interval)) = queue.next() {
            let RaySegment { ray: Ray { origin: o, direction: d }, path_length, .. } = rays[index];
            let last = if interval.start == 0.0 { 0.0 } else { f32::INFINITY };
            let values = [o.x, o.y, o.z, d.x, d.y, d.z, interval.start, interval.end, path_length, last, 0.0, 0.0];
            for (slot, value) in state.iter_mut().zip(values) {
                slot[lane] = value;
            }
            steps[lane] = 0;
            lane_ray[lane] = index;
            return;
        }
        // An idle lane is past its end at once, every time.
        (state[7][lane], state[10][lane], state[11][lane]) = (-1.0, 0.0, 0.0);
    };
    for lane in 0..8 {
        refill(lane, &mut lane_ray, &mut state, &mut steps);
    }
    let (coefficient, precision) = (f32x8::splat(frame.tolerance), f32x8::splat(frame.rounding));
    let factor = f32x8::splat(frame.step_factor);
    let (zero, fall) = (f32x8::ZERO, f32x8::splat(STEEPEST_FALL));
    while lane_ray.iter().any(|&ray| ray != IDLE) {
        let [ox, oy, oz, dx, dy, dz, mut t, limit, path_length, mut last, mut radius, mut stride] =
            state.map(f32x8::from);
        // March until some lane ends.
        let (ended, was_hit) = loop {
            let p = FieldVec3::new(ox + dx * t, oy + dy * t, oz + dz * t);
            let distance = field.sphere_traced_distance(p) * factor;
            let extent = p.x.abs().fast_max(p.y.abs().fast_max(p.z.abs()));
            let tolerance = (coefficient * (path_length + t)).fast_max(precision * extent);
            if STATS {
                let [last_t, last_distance, steepest] = watched;
                let change = (distance - last_distance).abs() - f32x8::splat(NOISE) * precision * extent;
                let steepness = change / (t - last_t).abs().fast_max(f32x8::splat(f32::MIN_POSITIVE));
                let first = lanes(|lane| f32::from(steps[lane] == 0));
                let known = Real::select(Mask8(first.simd_gt(f32x8::ZERO)), f32x8::ZERO, steepness.fast_max(steepest));
                watched = [t, distance, known];
            }
            // What is free around this point and the last does not touch: back to where that around the last one ends.
            let apart = (radius + distance).simd_lt(stride);
            let change = (distance - radius) / stride.fast_max(f32x8::splat(1e-30));
            let change = change.fast_max(fall).fast_min(f32x8::splat(STEEPEST_RISE));
            let slope = Real::select(Mask8(zero.simd_lt(stride)), change, fall);
            let tolerance = if ctx.config.refined_grazing {
                let grazes = f32x8::splat(GRAZING_SLOPE).simd_lt(slope);
                let fine = (tolerance * f32x8::splat(GRAZING_TOLERANCE)).fast_max(precision * extent);
                Real::select(Mask8(grazes), fine, tolerance)
            } else {
                tolerance
            };
            let close = distance.simd_lt(tolerance);
            let hit = close & distance.simd_lt(last) & !apart;
            let free = distance.fast_max(tolerance);
            let relaxed = free * (f32x8::splat(ctx.config.relaxation) / (f32x8::ONE - slope)).fast_max(f32x8::ONE);
            let left = Real::select(Mask8(close), distance, f32x8::splat(f32::INFINITY));
            let kept = |back: f32x8, on: f32x8| Real::select(Mask8(apart), back, on);
            let on = kept(radius - stride, relaxed);
            (last, stride, radius) = (kept(last, left), kept(radius, relaxed), kept(radius, free));
            t = Real::select(Mask8(hit), t, t + on);
            // The way to the end may not be free.
            let doubtful = limit.simd_lt(t) & !hit;
            let back = t + radius - stride;
            t = Real::select(Mask8(doubtful), back, t);
            stride = Real::select(Mask8(doubtful), radius, stride);
            let beyond = limit.simd_lt(t);
            let mut ended = (hit | beyond).to_bitmask();
            let mut was_hit = hit.to_bitmask() & !beyond.to_bitmask();
            for (lane, step) in steps.iter_mut().enumerate() {
                *step += 1;
                if *step >= MAX_STEPS && ended >> lane & 1 == 0 {
                    ended |= 1 << lane;
                    let (d, length) = (distance.to_array()[lane], path_length.to_array()[lane] + t.to_array()[lane]);
                    was_hit |= u32::from(d < 0.01 * length) << lane;
                }
            }
            let busy: u32 = (0..8).map(|lane| u32::from(lane_ray[lane] != IDLE) << lane).sum();
            if ended & busy != 0 {
                break (ended & busy, was_hit);
            }
        };
        state[6] = t.to_array();
        for (slot, value) in state[9..].iter_mut().zip([last, radius, stride]) {
            *slot = value.to_array();
        }
        for lane in 0..8 {
            if ended >> lane & 1 == 1 {
                if STATS && lane_ray[lane] != IDLE {
                    stats[lane_ray[lane]] =
                        MarchStats { evaluations: steps[lane], steepest: watched[2].to_array()[lane] };
                }
                if was_hit >> lane & 1 == 1 {
                    hits[lane_ray[lane]] = Some(Hit { t: state[6][lane], analytic: None });
                }
                refill(lane, &mut lane_ray, &mut state, &mut steps);
            }
        }
    }
    hits
}
