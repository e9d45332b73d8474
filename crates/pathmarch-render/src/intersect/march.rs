//! Sphere tracing: step along the ray by the distance to the nearest surface until that distance is below a tolerance
//! (Hart 1996, "Sphere tracing: a geometric method for the antialiased ray tracing of implicit surfaces"). Objects of a
//! single shape with a closed-form ray intersection are intersected analytically. All others are sphere-traced, within
//! their common bounds and up to the nearest analytic hit.
//!
//! **Tolerance.** The hit tolerance is a fraction (`Settings::detail`, a tenth) of the footprint of a pixel at the
//! length of the path so far, and at least the rounding error of `f32` at the point: far surfaces do not shimmer, near
//! ones keep their detail. A ray starts off its surface by three rounding errors and a twentieth of the distance at the
//! hit. That is far less than the tolerance, so that the ray cannot pass through a surface that touches the first one.
//! While the distance rises from there, a small distance is no hit. The magnitude of the field is traced, so that rays
//! hit solids from inside. A ray that runs out of steps hits the surface if its distance is below a hundredth of the
//! path length, as towards a horizon; else it misses.
//!
//! **Over-relaxation.** When the distance drops by less than the step, step further (Bán and Valasek 2023, "Automatic
//! Step Size Relaxation in Sphere Tracing", after Keinert et al. 2014, section 3.1). As long as the unbounding spheres
//! around two points touch, no surface is between them. If they are disjoint, the ray retreats to the end of the first
//! sphere, so that it never passes through a surface that plain sphere tracing would hit.
//!
//! **Grazing rays.** The tolerance enlarges every surface. That is visible around a sphere-traced emitter: a sphere of
//! 64 pixels lit its surroundings by 0.6 % too much. In scenes with such an emitter, the tolerance of a grazing ray is
//! sixteen times smaller ([`KernelConfig::refined_grazing`]). Scenes with fractals are excluded: their surface *is*
//! where rays end.
//!
//! On the CPU, eight rays are traced side by side. A lane whose ray has ended takes the next one.

use super::ray::{Hit, Ray, RaySegment, Rays8};
use crate::ray_stats::MarchStats;
#[cfg(doc)]
use crate::scene::KernelConfig;
use crate::scene::{FrameUniforms, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::graph::RayKind;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

shared_constants! {
    /// Excess of a change in distance over its Lipschitz bound that is not reported, in rounding errors.
    const TOLERATED_ROUNDING_ERRORS: f32 = 16.0;
    /// Largest number of steps of a ray.
    pub(crate) const MAX_STEPS: u32 = 256;
    /// Smallest estimated slope of the distance along a ray.
    const MIN_SLOPE: f32 = -1.0;
    /// Largest estimated slope of the distance along a ray.
    const MAX_SLOPE: f32 = 0.6;
    /// Slope of the distance along a ray above which the ray is grazing.
    const GRAZING_SLOPE: f32 = -0.5;
    /// Factor of the hit tolerance of grazing rays, see [`KernelConfig::refined_grazing`].
    const GRAZING_TOLERANCE: f32 = 0.0625;
    /// Distance from a surface at which rays start, in rounding errors.
    pub(crate) const START_OFFSET: f32 = 3.0;
}

/// Hit tolerance at a point of a path of this length, metres.
#[inline]
pub(crate) fn tolerance(frame: &FrameUniforms, p: Vec3, path_length: f32) -> f32 {
    (frame.tolerance * path_length).max(frame.rounding * p.abs().max_element())
}

/// Distance from a surface at which rays start, metres, from the rounding error and the distance at the hit.
#[inline]
pub(crate) fn start_offset(rounding: f32x8, distance: f32x8) -> f32x8 {
    f32x8::splat(START_OFFSET) * rounding + f32x8::splat(0.05) * distance.abs()
}

/// Rounding error of a point on a surface, metres; `origin` is that of its coordinates.
#[inline]
pub(crate) fn rounding_at(frame: &FrameUniforms, p: FieldVec3<f32x8>, origin: FieldVec3<f32x8>) -> f32x8 {
    f32x8::splat(frame.rounding) * p.abs().largest().fast_max((p - origin).abs().largest())
}

/// Interval of a ray to sphere-trace, metres from its origin, and the analytic hit at its end.
#[derive(Clone, Copy)]
struct Interval {
    start: f32,
    end: f32,
    analytic_hit: Option<Hit>,
}

/// Intersects eight rays with the analytic shapes and with the bounds of the sphere-traced ones.
fn intervals(field: &Field, frame: &FrameUniforms, rays: &Rays8) -> [Interval; 8] {
    let t_max = rays.limit.fast_min(f32x8::splat(frame.far));
    let (analytic, leaf) = field.analytic_hit_before(t_max, rays.origin, rays.direction);
    let (mut start, mut end) = (f32x8::ZERO, analytic.fast_min(t_max));
    let [min, max] = [frame.bounds_min, frame.bounds_max];
    if (0..3).any(|axis| min[axis] > max[axis]) {
        // Empty bounds: no ray is sphere-traced.
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
    let (analytic, leaf, t_max) = (analytic.to_array(), leaf.to_array(), t_max.to_array());
    std::array::from_fn(|lane| {
        let hit = Hit { t: analytic[lane], analytic: Some(leaf[lane] as u32), triangle: None };
        Interval { start: start[lane], end: end[lane], analytic_hit: (analytic[lane] < t_max[lane]).then_some(hit) }
    })
}

/// Ends an interval at the first hit of its ray with a triangle.
fn intersect_triangles(field: &Field, frame: &FrameUniforms, segment: &RaySegment, interval: Interval) -> Interval {
    let Ray { origin, direction } = segment.ray;
    let t_max = interval.analytic_hit.map_or(segment.limit.min(frame.far), |hit| hit.t);
    let Some(hit) = field.mesh_hit(origin, direction, t_max, segment.kind()) else { return interval };
    let analytic_hit = Some(Hit { t: hit.t, analytic: Some(hit.leaf), triangle: Some(hit.triangle) });
    Interval { end: interval.end.min(hit.t), analytic_hit, ..interval }
}

/// State of eight sphere-traced rays.
#[derive(Clone, Copy, Default)]
struct Lanes {
    origin: FieldVec3<f32x8>,
    direction: FieldVec3<f32x8>,
    t: f32x8,
    /// End of the ray; a lane without a ray is always past it.
    limit: f32x8,
    /// Length of the path before the ray, metres.
    path_length: f32x8,
    /// Evaluations so far.
    steps: f32x8,
    /// Infinite once the ray has left the surface that it starts on.
    last_distance: f32x8,
    /// Radius of the unbounding sphere at the last point.
    radius: f32x8,
    /// Step from the last point.
    stride: f32x8,
}

impl Lanes {
    /// Starts a ray in a lane.
    #[inline(always)]
    fn start(&mut self, lane: usize, segment: &RaySegment, interval: &Interval) {
        let is_lane = single(lane);
        let put = |value: f32, old: f32x8| Real::select(is_lane, f32x8::splat(value), old);
        let put_vector =
            |v: Vec3, old: FieldVec3<f32x8>| FieldVec3::new(put(v.x, old.x), put(v.y, old.y), put(v.z, old.z));
        *self = Self {
            origin: put_vector(segment.ray.origin, self.origin),
            direction: put_vector(segment.ray.direction, self.direction),
            t: put(interval.start, self.t),
            limit: put(interval.end, self.limit),
            path_length: put(segment.path_length, self.path_length),
            steps: put(0.0, self.steps),
            last_distance: put(if interval.start == 0.0 { 0.0 } else { f32::INFINITY }, self.last_distance),
            radius: put(0.0, self.radius),
            stride: put(0.0, self.stride),
        };
    }

    /// Leaves a lane without a ray.
    #[inline(always)]
    fn stop(&mut self, lane: usize) {
        let is_lane = single(lane);
        self.limit = Real::select(is_lane, f32x8::splat(-1.0), self.limit);
        self.radius = Real::select(is_lane, f32x8::ZERO, self.radius);
        self.stride = Real::select(is_lane, f32x8::ZERO, self.stride);
    }
}

/// This lane alone.
#[inline(always)]
fn single(lane: usize) -> Mask8 {
    const LANES: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    Mask8(f32x8::from(LANES).simd_eq(f32x8::splat(lane as f32)))
}

/// First hit of each ray; `None` for a miss. All rays are of one [kind](RaySegment::kind).
pub(crate) fn march(ctx: &TraceContext, rays: &[RaySegment]) -> Vec<Option<Hit>> {
    let Some(counters) = ctx.stats else { return sphere_trace::<false>(ctx, rays, &mut []) };
    let (hits, stats) = march_with_stats(ctx, rays);
    counters.add(&stats);
    hits
}

/// [`march`] with the statistics of each ray.
pub(crate) fn march_with_stats(ctx: &TraceContext, rays: &[RaySegment]) -> (Vec<Option<Hit>>, Vec<MarchStats>) {
    let mut stats = vec![MarchStats::default(); rays.len()];
    (sphere_trace::<true>(ctx, rays, &mut stats), stats)
}

/// [`march`]. With `STATS`, `stats` has an element for each ray.
fn sphere_trace<const STATS: bool>(
    ctx: &TraceContext,
    rays: &[RaySegment],
    stats: &mut [MarchStats],
) -> Vec<Option<Hit>> {
    let (field, frame) = (&ctx.scene.field, ctx.frame);
    let kind = rays.first().map_or(RayKind::Camera, RaySegment::kind);
    debug_assert!(!field.has_meshes_lit_by_field() || rays.iter().all(|segment| segment.kind() == kind));
    let mut hits = Vec::with_capacity(rays.len());
    let mut pending = Vec::new();
    let has_triangles = field.has_triangles();
    for chunk in rays.chunks(8) {
        for (segment, mut interval) in chunk.iter().zip(intervals(field, frame, &Rays8::new(chunk.iter()))) {
            if has_triangles {
                interval = intersect_triangles(field, frame, segment, interval);
            }
            if interval.start < interval.end {
                pending.push((hits.len(), interval));
            }
            hits.push(interval.analytic_hit);
        }
    }
    let mut queue = pending.into_iter();
    let mut lane_ray = [0; 8];
    let mut lanes = Lanes::default();
    // Lanes with a ray.
    let mut busy = 0u32;
    // For the statistics: t and distance of the last evaluation, and the steepest change so far.
    let mut evaluated = [f32x8::ZERO; 3];
    let mut refill = |lane: usize, lanes: &mut Lanes, lane_ray: &mut [usize; 8], busy: &mut u32| {
        if let Some((index, interval)) = queue.next() {
            lanes.start(lane, &rays[index], &interval);
            lane_ray[lane] = index;
            *busy |= 1 << lane;
        } else {
            lanes.stop(lane);
            *busy &= !(1 << lane);
        }
    };
    for lane in 0..8 {
        refill(lane, &mut lanes, &mut lane_ray, &mut busy);
    }
    let (tolerance_factor, rounding) = (f32x8::splat(frame.tolerance), f32x8::splat(frame.rounding));
    let step_factor = f32x8::splat(frame.step_factor);
    let (zero, min_slope) = (f32x8::ZERO, f32x8::splat(MIN_SLOPE));
    while busy != 0 {
        let Lanes { origin, direction, mut t, limit, path_length, steps, mut last_distance, mut radius, mut stride } =
            lanes;
        let p = origin + direction * t;
        let distance = field.sphere_traced_distance(p, kind) * step_factor;
        let extent = p.abs().largest();
        let hit_tolerance = (tolerance_factor * (path_length + t)).fast_max(rounding * extent);
        if STATS {
            let [previous_t, previous_distance, steepest] = evaluated;
            let change =
                (distance - previous_distance).abs() - f32x8::splat(TOLERATED_ROUNDING_ERRORS) * rounding * extent;
            let steepness = change / (t - previous_t).abs().fast_max(f32x8::splat(f32::MIN_POSITIVE));
            let steepest = Real::select(Mask8(steps.simd_eq(zero)), zero, steepness.fast_max(steepest));
            evaluated = [t, distance, steepest];
        }
        // The unbounding spheres of this point and the last are disjoint: retreat to the end of the last one.
        let disjoint = (radius + distance).simd_lt(stride);
        let change = (distance - radius) / stride.fast_max(f32x8::splat(1e-30));
        let change = change.fast_max(min_slope).fast_min(f32x8::splat(MAX_SLOPE));
        let slope = Real::select(Mask8(zero.simd_lt(stride)), change, min_slope);
        let hit_tolerance = if ctx.config.refined_grazing {
            let grazes = f32x8::splat(GRAZING_SLOPE).simd_lt(slope);
            let grazing_tolerance = (hit_tolerance * f32x8::splat(GRAZING_TOLERANCE)).fast_max(rounding * extent);
            Real::select(Mask8(grazes), grazing_tolerance, hit_tolerance)
        } else {
            hit_tolerance
        };
        let is_close = distance.simd_lt(hit_tolerance);
        let hit = is_close & distance.simd_lt(last_distance) & !disjoint;
        let new_radius = distance.fast_max(hit_tolerance);
        let relaxed_stride =
            new_radius * (f32x8::splat(ctx.config.relaxation) / (f32x8::ONE - slope)).fast_max(f32x8::ONE);
        let distance_if_close = Real::select(Mask8(is_close), distance, f32x8::splat(f32::INFINITY));
        let if_disjoint = |then: f32x8, otherwise: f32x8| Real::select(Mask8(disjoint), then, otherwise);
        let advance = if_disjoint(radius - stride, relaxed_stride);
        (last_distance, stride, radius) = (
            if_disjoint(last_distance, distance_if_close),
            if_disjoint(radius, relaxed_stride),
            if_disjoint(radius, new_radius),
        );
        t = Real::select(Mask8(hit), t, t + advance);
        // The ray ends beyond the last unbounding sphere: evaluate the field at the end of that sphere first.
        let overshoots = limit.simd_lt(t) & !hit;
        let retreated = t + radius - stride;
        t = Real::select(Mask8(overshoots), retreated, t);
        stride = Real::select(Mask8(overshoots), radius, stride);
        let steps = steps + f32x8::ONE;
        let past_end = limit.simd_lt(t);
        let stops = steps.simd_ge(f32x8::splat(MAX_STEPS as f32));
        let stops_near = stops & distance.simd_lt(f32x8::splat(0.01) * (path_length + t));
        let was_hit = ((hit | stops_near) & !past_end).to_bitmask();
        let mut ended = (hit | past_end | stops).to_bitmask() & busy;
        lanes = Lanes { t, steps, last_distance, radius, stride, ..lanes };
        if ended == 0 {
            continue;
        }
        let (t, steps, steepest) = (t.to_array(), steps.to_array(), evaluated[2].to_array());
        while ended != 0 {
            let lane = ended.trailing_zeros() as usize;
            ended &= ended - 1;
            let ray = lane_ray[lane];
            if STATS {
                stats[ray] = MarchStats { evaluations: steps[lane] as u32, steepest: steepest[lane] };
            }
            if was_hit >> lane & 1 == 1 {
                hits[ray] = Some(Hit { t: t[lane], analytic: None, triangle: None });
            }
            refill(lane, &mut lanes, &mut lane_ray, &mut busy);
        }
    }
    hits
}
