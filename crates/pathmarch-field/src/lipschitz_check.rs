//! Check of a field's Lipschitz constant: searches for points at which a surface is nearer than the distance claims.
//!
//! Sphere tracing steps by the distance over the Lipschitz constant because the ball of that radius contains no surface
//! (Hart 1996, section 2.2). The check samples points in and around an object and random directions from each. If the field
//! changes its sign within the ball, bisection finds the surface; its distance over the radius is the factor by which steps
//! would have to be shorter. The check also reports the largest slope found, which is one for exact distances; `round`,
//! `shell` and blends are as safe as that slope. The result is evidence, not proof. Cost: about twenty evaluations a point.

use crate::bounds::Aabb;
use crate::graph::{Batch, Field};
use crate::number::Vec3;

/// Result of the check of one object.
#[derive(Clone, Copy, Debug)]
pub struct LipschitzReport {
    /// Largest length of the gradient found.
    pub slope: f32,
    /// Safe fraction of a step of the distance over the Lipschitz constant; 1 if no step passed a surface.
    pub safe_factor: f32,
    /// World position at which the factor was found, metres.
    pub at: [f32; 3],
    /// Leaf whose material shows there.
    pub leaf: u32,
}

/// Directions sampled from each point.
const DIRECTIONS: u32 = 8;
/// Bisection steps.
const HALVINGS: u32 = 20;
/// Fraction of the object's size below which distances are lost in rounding.
const ROUNDING: f32 = 1e-5;
/// Half edge of the box in which unbounded objects are checked, metres.
const LIMIT: f32 = 20.0;

/// Checks a field of one object at this many points; the same points every time.
pub fn check_lipschitz(field: &Field, points: u32) -> LipschitzReport {
    let limits = Aabb::centred(LIMIT, LIMIT, LIMIT);
    let bounds = Some(field.bounds().intersection(limits)).filter(|bounds| !bounds.is_empty()).unwrap_or(limits);
    let size = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max).max(1e-3);
    let around = bounds.expanded(0.5 * size);
    let lipschitz = field.lipschitz();
    let mut report = LipschitzReport { slope: 0.0, safe_factor: 1.0, at: [0.0; 3], leaf: 0 };
    let mut next = {
        let mut index = 0;
        move || {
            index += 1;
            f32::choice(0x5eed, index)
        }
    };
    for _ in 0..points {
        let [x, y, z] = std::array::from_fn(|k| around.min[k] + (around.max[k] - around.min[k]) * next());
        let p = Vec3::new(x, y, z);
        let surface = field.surface(p, 0);
        let distance = field.distance(p);
        report.slope = report.slope.max(surface.field.gradient.length());
        let radius = distance.abs() / lipschitz;
        if radius.is_nan() || radius < ROUNDING * size {
            continue;
        }
        // There is no surface beyond the box.
        let reach = radius.min(3.0 * size);
        for _ in 0..DIRECTIONS {
            let direction = direction(next(), next());
            let share = 0.25 + 0.749 * next();
            let crosses = |length: f32| field.distance(p + direction * length) * distance < 0.0;
            if !crosses(share * reach) {
                continue;
            }
            let (mut free, mut beyond) = (0.0, share * reach);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (free + beyond);
                if crosses(middle) { beyond = middle } else { free = middle }
            }
            let factor = beyond / radius;
            if beyond < radius - ROUNDING * size && factor < report.safe_factor {
                let there = p + direction * beyond;
                let leaf = field.surface(there, 0).leaf as u32;
                report = LipschitzReport { safe_factor: factor, at: [there.x, there.y, there.z], leaf, ..report };
            }
        }
    }
    report
}

/// Uniform direction from two uniform numbers.
fn direction(u: f32, v: f32) -> Vec3<f32> {
    let up = 1.0 - 2.0 * u;
    let around = (1.0 - up * up).max(0.0).sqrt();
    let (sine, cosine) = (std::f32::consts::TAU * v).sin_cos();
    Vec3::new(around * cosine, up, around * sine)
}
