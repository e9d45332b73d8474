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
//! must come sixteen times as close ([`Features::refined_grazing`]); not next to fractals, whose surface *is* where rays end.
//!
//! On the CPU, eight rays march side by side; a lane whose ray has ended takes the next one.

use super::camera::Ray;
#[cfg(doc)]
use crate::frame::Features;
use crate::frame::{Frame, Prepared};
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::graph::SPHERE_TRACED;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

/// Steps after which a march gives up.
pub(crate) const MAX_STEPS: u32 = 256;

/// Distances may be off by this many roundings of their point without a word.
pub(crate) const NOISE: f32 = 16.0;

/// How the distance changes along a ray, at the least and at the most.
const STEEPEST_FALL: f32 = -1.0;
const STEEPEST_RISE: f32 = 0.6;
/// A ray grazes where the distance along it changes by more than this per metre.
const GRAZING_SLOPE: f32 = -0.5;
/// Share of the tolerance at which a ray that grazes hits a surface, see [`Features::refined_grazing`].
const GRAZING_TOLERANCE: f32 = 0.0625;
/// Twice the share of a step from a point that two balls take which touch by the estimate of their slope.
pub(crate) const RELAXATION: f32 = 1.9;

/// How far off a surface a ray starts, in roundings.
const START_OFFSET: f32 = 3.0;

/// The part of a ray to march.
#[derive(Clone, Copy, Debug)]
pub(crate) struct March {
    pub(crate) ray: Ray,
    /// Length of the path before this ray, metres.
    pub(crate) before: f32,
    /// Where to stop, metres along the ray.
    pub(crate) limit: f32,
}

/// What is negligible at a point of a path of this length.
pub(crate) fn tolerance(frame: &Frame, p: Vec3, path_length: f32) -> f32 {
    (frame.tolerance * path_length).max(frame.rounding * p.abs().max_element())
}

/// How far off a surface a ray starts; `off` is the rounding there and `distance` that of the point that was reached.
pub(super) fn start_offset(off: f32x8, distance: f32x8) -> f32x8 {
    f32x8::splat(START_OFFSET) * off + f32x8::splat(0.05) * distance.abs()
}

/// How far from a surface a point on it may be by rounding; `at` is the origin of its coordinates.
pub(super) fn rounding_at(frame: &Frame, p: FieldVec3<f32x8>, at: FieldVec3<f32x8>) -> f32x8 {
    f32x8::splat(frame.rounding) * p.abs().largest().fast_max((p - at).abs().largest())
}

/// A number for each of eight lanes.
#[inline(always)]
pub(super) fn lanes(value: impl Fn(usize) -> f32) -> f32x8 {
    f32x8::from(std::array::from_fn(value))
}

/// Eight rays of which the last may be copies of the first.
pub(super) struct Rays8 {
    pub(super) origin: FieldVec3<f32x8>,
    pub(super) direction: FieldVec3<f32x8>,
    limit: f32x8,
}

impl Rays8 {
    /// Of one to eight rays.
    pub(super) fn new<'a>(rays: impl Iterator<Item = &'a March>) -> Self {
        let mut parts = [[0.0; 8]; 7];
        let mut count = 0;
        for March { ray: Ray { origin, direction }, limit, .. } in rays {
            let values = [origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, *limit];
            for (part, value) in parts.iter_mut().zip(values) {
                part[count] = value;
            }
            count += 1;
        }
        for part in &mut parts {
            let first = part[0];
            part[count..].fill(first);
        }
        let [ox, oy, oz, dx, dy, dz, limit] = parts.map(f32x8::from);
        Self { origin: FieldVec3::new(ox, oy, oz), direction: FieldVec3::new(dx, dy, dz), limit }
    }
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Metres from its origin.
    pub(crate) t: f32,
    /// The leaf, if it has a closed form.
    pub(crate) direct: Option<u32>,
}

impl Hit {
    /// The leaf of closed form as [`Field::surface_at_hit`] is given it.
    pub(crate) fn met(direct: Option<u32>) -> f32 {
        direct.map_or(SPHERE_TRACED, |leaf| leaf as f32)
    }
}

/// What of a ray must be marched, metres from its origin, and its hit if nothing is met there.
#[derive(Clone, Copy)]
struct Span {
    start: f32,
    end: f32,
    otherwise: Option<Hit>,
}

/// Meets eight rays with the shapes that have a closed form, and with the box of the others.
fn spans(field: &Field, frame: &Frame, rays: &Rays8) -> [Span; 8] {
    let (direct, leaf) = field.analytic_hit(rays.origin, rays.direction);
    let last = rays.limit.fast_min(f32x8::splat(frame.far));
    let (mut start, mut end) = (f32x8::ZERO, direct.fast_min(last));
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
    let (direct, leaf, last) = (direct.to_array(), leaf.to_array(), last.to_array());
    std::array::from_fn(|lane| Span {
        start: start[lane],
        end: end[lane],
        otherwise: (direct[lane] < last[lane]).then_some(Hit { t: direct[lane], direct: Some(leaf[lane] as u32) }),
    })
}

/// What a march saw of the field.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Trail {
    /// How often it evaluated the field.
    pub(crate) evaluations: u32,
    /// By how much the distance changed between two evaluations at most, over what its Lipschitz constant allows.
    pub(crate) steepest: f32,
}

/// Follows every ray; gives for each its hit, or `None`.
pub(crate) fn march(prepared: &Prepared, rays: &[March]) -> Vec<Option<Hit>> {
    let Some(counter) = &prepared.counter else { return follow::<false>(prepared, rays, &mut []) };
    let mut trails = vec![Trail::default(); rays.len()];
    let hits = follow::<true>(prepared, rays, &mut trails);
    counter.add(&trails);
    hits
}

/// [`march`], and what each ray saw.
pub(super) fn march_watching(prepared: &Prepared, rays: &[March]) -> (Vec<Option<Hit>>, Vec<Trail>) {
    let mut trails = vec![Trail::default(); rays.len()];
    (follow::<true>(prepared, rays, &mut trails), trails)
}

/// [`march`]; where it is `WATCHED`, `trails` has a place for each ray.
fn follow<const WATCHED: bool>(prepared: &Prepared, rays: &[March], trails: &mut [Trail]) -> Vec<Option<Hit>> {
    let (field, frame) = (&prepared.field, &prepared.frame);
    const IDLE: usize = usize::MAX;
    let mut hits = Vec::with_capacity(rays.len());
    let mut marched = Vec::new();
    for chunk in rays.chunks(8) {
        for span in &spans(field, frame, &Rays8::new(chunk.iter()))[..chunk.len()] {
            if span.start < span.end {
                marched.push((hits.len(), *span));
            }
            hits.push(span.otherwise);
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
        if let Some((index, span)) = queue.next() {
            let March { ray: Ray { origin: o, direction: d }, before, .. } = rays[index];
            let last = if span.start == 0.0 { 0.0 } else { f32::INFINITY };
            let values = [o.x, o.y, o.z, d.x, d.y, d.z, span.start, span.end, before, last, 0.0, 0.0];
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
        let [ox, oy, oz, dx, dy, dz, mut t, limit, before, mut last, mut radius, mut stride] = state.map(f32x8::from);
        // March until some lane ends.
        let (ended, was_hit) = loop {
            let p = FieldVec3::new(ox + dx * t, oy + dy * t, oz + dz * t);
            let distance = field.sphere_traced_distance(p) * factor;
            let extent = p.x.abs().fast_max(p.y.abs().fast_max(p.z.abs()));
            let tolerance = (coefficient * (before + t)).fast_max(precision * extent);
            if WATCHED {
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
            let tolerance = if prepared.features.refined_grazing {
                let grazes = f32x8::splat(GRAZING_SLOPE).simd_lt(slope);
                let fine = (tolerance * f32x8::splat(GRAZING_TOLERANCE)).fast_max(precision * extent);
                Real::select(Mask8(grazes), fine, tolerance)
            } else {
                tolerance
            };
            let close = distance.simd_lt(tolerance);
            let hit = close & distance.simd_lt(last) & !apart;
            let free = distance.fast_max(tolerance);
            let relaxed =
                free * (f32x8::splat(prepared.features.relaxation) / (f32x8::ONE - slope)).fast_max(f32x8::ONE);
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
                    let (d, length) = (distance.to_array()[lane], before.to_array()[lane] + t.to_array()[lane]);
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
                if WATCHED && lane_ray[lane] != IDLE {
                    trails[lane_ray[lane]] = Trail { evaluations: steps[lane], steepest: watched[2].to_array()[lane] };
                }
                if was_hit >> lane & 1 == 1 {
                    hits[lane_ray[lane]] = Some(Hit { t: state[6][lane], direct: None });
                }
                refill(lane, &mut lane_ray, &mut state, &mut steps);
            }
        }
    }
    hits
}
