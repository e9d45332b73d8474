//! Sphere tracing: step along the ray by the distance to the nearest surface until that distance is negligible
//! (Hart 1996, "Sphere tracing: a geometric method for the antialiased ray tracing of implicit surfaces").
//!
//! Negligible means a tenth of what a pixel covers at the length of the path so far, and never less than what `f32`
//! resolves at the point. A ray starts three such lengths off its surface, so that it is outside it by the field's own
//! word. The magnitude of the field is marched, so that the inside of a solid can be seen. A ray starts where it enters
//! the scene's box and ends where it leaves it. One that has used up its steps close to a surface (under a hundredth of
//! its length, as towards a horizon) hits it there, else it is lost.
//!
//! On the CPU, eight rays march side by side; a lane whose ray has ended takes the next one.

use super::camera::Ray;
use crate::frame::Frame;
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

/// Steps after which a march gives up.
pub(crate) const MAX_STEPS: u32 = 256;

/// How far off a surface a ray starts, in tolerances.
pub(crate) const START_OFFSET: f32 = 3.0;

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
    (frame.tolerance * path_length).max(frame.precision * p.abs().max_element())
}

/// The part of a ray within the scene's box, metres from the origin; empty when the first is larger.
pub(crate) fn span(frame: &Frame, ray: &Ray) -> (f32, f32) {
    let inverse = ray.direction.recip();
    let a = (Vec3::from(frame.bounds_min) - ray.origin) * inverse;
    let b = (Vec3::from(frame.bounds_max) - ray.origin) * inverse;
    // A direction component of zero gives infinities, or not a number on a face: min and max drop the latter.
    let (near, far) = (a.min(b), a.max(b));
    (near.max_element().max(0.0), far.min_element().min(frame.far))
}

/// Marches every ray; gives for each the metres to its hit, or `None`.
pub(crate) fn march(field: &Field, frame: &Frame, rays: &[March]) -> Vec<Option<f32>> {
    const IDLE: usize = usize::MAX;
    let mut hits = vec![None; rays.len()];
    let mut next = 0;
    let mut lane_ray = [IDLE; 8];
    let mut steps = [0u32; 8];
    // Per lane: origin, direction, t, limit, length before.
    let mut state = [[0.0f32; 8]; 9];
    let mut refill = |lane: usize, lane_ray: &mut [usize; 8], state: &mut [[f32; 8]; 9], steps: &mut [u32; 8]| {
        lane_ray[lane] = IDLE;
        while next < rays.len() {
            let march = &rays[next];
            let (start, end) = span(frame, &march.ray);
            next += 1;
            let end = end.min(march.limit);
            if start < end {
                let (o, d) = (march.ray.origin, march.ray.direction);
                for (slot, value) in state.iter_mut().zip([o.x, o.y, o.z, d.x, d.y, d.z, start, end, march.before]) {
                    slot[lane] = value;
                }
                steps[lane] = 0;
                lane_ray[lane] = next - 1;
                return;
            }
        }
        // An idle lane is past its end at once, every time.
        state[7][lane] = -1.0;
    };
    for lane in 0..8 {
        refill(lane, &mut lane_ray, &mut state, &mut steps);
    }
    let (coefficient, precision) = (f32x8::splat(frame.tolerance), f32x8::splat(frame.precision));
    let factor = f32x8::splat(frame.step_factor);
    while lane_ray.iter().any(|&ray| ray != IDLE) {
        let [ox, oy, oz, dx, dy, dz, mut t, limit, before] = state.map(f32x8::from);
        // March until some lane ends.
        let (ended, was_hit) = loop {
            let p = FieldVec3::new(ox + dx * t, oy + dy * t, oz + dz * t);
            let distance = field.distance(p).abs() * factor;
            let extent = p.x.abs().fast_max(p.y.abs().fast_max(p.z.abs()));
            let tolerance = (coefficient * (before + t)).fast_max(precision * extent);
            let hit = distance.simd_lt(tolerance);
            let stepped = t + distance;
            t = Real::select(Mask8(hit), t, stepped);
            let beyond = limit.simd_lt(t);
            let mut ended = (hit | beyond).to_bitmask();
            for step in &mut steps {
                *step += 1;
            }
            let mut was_hit = hit.to_bitmask() & !beyond.to_bitmask();
            for lane in 0..8 {
                if steps[lane] >= MAX_STEPS && ended >> lane & 1 == 0 {
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
        for lane in 0..8 {
            if ended >> lane & 1 == 1 {
                if was_hit >> lane & 1 == 1 {
                    hits[lane_ray[lane]] = Some(state[6][lane]);
                }
                refill(lane, &mut lane_ray, &mut state, &mut steps);
            }
        }
    }
    hits
}
