//! The sky: radiance of the surroundings.

use crate::environment::Environment;
use glam::Vec3;
use std::sync::Arc;

/// Radiance of the surroundings, which are infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same in every direction, W/(m² sr).
    Constant([f32; 3]),
    /// A vertical gradient; with y the upward component of a direction of length one,
    /// - y >= 0: mix(horizon, zenith, 1 - (1 - y)³), steep near the horizon as in a clear sky;
    /// - y < 0: mix(horizon, ground, smoothstep(0, 0.02, -y)), an edge of about one degree.
    Gradient {
        /// Straight up, W/(m² sr).
        zenith: [f32; 3],
        /// At the height of the eye, W/(m² sr).
        horizon: [f32; 3],
        /// Below the horizon, W/(m² sr).
        ground: [f32; 3],
    },
    /// A picture of radiance in every direction.
    Map(Arc<Environment>),
}

impl Default for Sky {
    fn default() -> Self {
        Self::Constant([0.0; 3])
    }
}

/// Sine of the depth below the horizon at which the ground of a gradient has its own colour.
pub const GROUND_EDGE: f32 = 0.02;

impl Sky {
    /// Radiance that comes from `direction`, which is of length one, W/(m² sr).
    pub fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Gradient { zenith, horizon, ground } => {
                let y = direction[1].clamp(-1.0, 1.0);
                let (far, share) = if y >= 0.0 {
                    (zenith, 1.0 - (1.0 - y).powi(3))
                } else {
                    let t = (-y / GROUND_EDGE).min(1.0);
                    (ground, t * t * (3.0 - 2.0 * t))
                };
                Vec3::from(*horizon).lerp(Vec3::from(*far), share).into()
            }
            Self::Map(environment) => environment.radiance(direction),
        }
    }
    /// True if no light comes from any direction.
    pub fn is_black(&self) -> bool {
        let black = |radiance: &[f32; 3]| radiance.iter().all(|&v| v <= 0.0);
        match self {
            Self::Constant(radiance) => black(radiance),
            Self::Gradient { zenith, horizon, ground } => [zenith, horizon, ground].into_iter().all(black),
            Self::Map(environment) => environment.texels.iter().all(black),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{GROUND_EDGE, Sky};

    #[test]
    fn gradient() {
        let sky = Sky::Gradient { zenith: [0.0, 0.2, 1.0], horizon: [1.0; 3], ground: [0.5, 0.25, 0.0] };
        let at = |y: f32| sky.radiance([(1.0 - y * y).sqrt(), y, 0.0]);
        assert_eq!(at(1.0), [0.0, 0.2, 1.0]);
        assert_eq!(at(0.0), [1.0; 3]);
        assert_eq!(at(0.5)[0], 0.125);
        assert_eq!(at(-GROUND_EDGE), [0.5, 0.25, 0.0]);
        assert_eq!(at(-1.0), [0.5, 0.25, 0.0]);
        assert!((at(-0.5 * GROUND_EDGE)[2] - 0.5).abs() < 1e-6);
    }

    #[test]
    fn black() {
        assert!(Sky::default().is_black());
        let (zero, dim) = ([0.0; 3], [0.0, 0.0, 1e-6]);
        assert!(Sky::Gradient { zenith: zero, horizon: zero, ground: zero }.is_black());
        assert!(!Sky::Gradient { zenith: zero, horizon: zero, ground: dim }.is_black());
    }
}
