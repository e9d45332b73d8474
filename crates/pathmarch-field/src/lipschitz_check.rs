//! Looks for places where a field lies: where a surface is nearer than the distance says.
//!
//! A march may step by the distance over the Lipschitz constant because the ball of that radius holds no surface (Hart
//! 1996, section 2.2). A survey takes points in and around an object, looks into the ball around each in random directions,
//! and where the field has the other sign there, finds the surface between by bisection. The share of the radius that was
//! free is the factor by which steps would have to be shorter. It also tells the largest slope found, which is one for
//! exact distances; what is made of a field by `round`, `shell` or a blend is as safe as its slope.
//! What is not found may still be there: a survey is evidence, no proof. Cost: about twenty evaluations for each point.

use crate::bounds::Aabb;
use crate::graph::{Batch, Field};
use crate::number::Vec3;

/// What a survey found of an object.
#[derive(Clone, Copy, Debug)]
pub struct LipschitzReport {
    /// Largest length of the gradient.
    pub slope: f32,
    /// Steps of the distance over the Lipschitz constant, times this, met no surface; 1 where none was met at all.
    pub safe_factor: f32,
    /// Where the factor was found.
    pub at: [f32; 3],
    /// The leaf that shows there.
    pub leaf: u32,
}

/// Directions looked into from each point.
const DIRECTIONS: u32 = 8;
/// Halvings of the way to a surface.
const HALVINGS: u32 = 20;
/// Below this share of the object's size distances are lost in rounding.
const ROUNDING: f32 = 1e-5;
/// Metres to which endless objects are looked at.
const LIMIT: f32 = 20.0;

/// Surveys a field of one object at this many points; the same points every time.
pub fn check_lipschitz(field: &Field, points: u32) -> LipschitzReport {
    let limits = Aabb::centred(LIMIT, LIMIT, LIMIT);
    let bounds = Some(field.bounds().intersection(limits)).filter(|bounds| !bounds.is_empty()).unwrap_or(limits);
    let size = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max).max(1e-3);
    let around = bounds.expanded(0.5 * size);
    let lipschitz = field.lipschitz();
    let mut finding = LipschitzReport { slope: 0.0, safe_factor: 1.0, at: [0.0; 3], leaf: 0 };
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
        finding.slope = finding.slope.max(surface.field.gradient.length());
        let radius = distance.abs() / lipschitz;
        if radius.is_nan() || radius < ROUNDING * size {
            continue;
        }
        // Beyond the box there is nothing to be met.
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
            if beyond < radius - ROUNDING * size && factor < finding.safe_factor {
                let there = p + direction * beyond;
                let leaf = field.surface(there, 0).leaf as u32;
                finding = LipschitzReport { safe_factor: factor, at: [there.x, there.y, there.z], leaf, ..finding };
            }
        }
    }
    finding
}

/// A unit vector of two uniform numbers.
fn direction(u: f32, v: f32) -> Vec3<f32> {
    let up = 1.0 - 2.0 * u;
    let around = (1.0 - up * up).max(0.0).sqrt();
    let (sine, cosine) = (std::f32::consts::TAU * v).sin_cos();
    Vec3::new(around * cosine, up, around * sine)
}
