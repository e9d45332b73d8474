//! Counters of rays and field evaluations.
//!
//! The CPU backend counts while it renders. It traces the same paths as the kernels, so its counts apply to a GPU, too.

use std::sync::atomic::{AtomicU64, Ordering};

/// Rays and field evaluations of one sample of every pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayStats {
    /// Camera rays, path segments and shadow rays.
    pub rays: u64,
    /// Sphere-traced rays: those that enter the bounds of the sphere-traced objects.
    pub sphere_traced_rays: u64,
    /// Field evaluations of these rays, excluding those for normals: one for each hit.
    pub evaluations: u64,
}

impl RayStats {
    /// Mean number of evaluations for each ray.
    pub fn evaluations_per_ray(&self) -> f64 {
        self.evaluations as f64 / self.rays.max(1) as f64
    }
}

/// Statistics of one sphere-traced ray.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MarchStats {
    /// Evaluations of the field.
    pub(crate) evaluations: u32,
    /// Largest slope of the field between two evaluations, relative to its Lipschitz constant.
    pub(crate) steepest: f32,
}

/// Counters that all threads share.
#[derive(Debug, Default)]
pub(crate) struct RayCounters {
    rays: AtomicU64,
    sphere_traced_rays: AtomicU64,
    evaluations: AtomicU64,
}

impl RayCounters {
    /// Adds the statistics of some rays.
    pub(crate) fn add(&self, stats: &[MarchStats]) {
        let sphere_traced = stats.iter().filter(|ray| ray.evaluations > 0).count() as u64;
        let evaluations = stats.iter().map(|ray| u64::from(ray.evaluations)).sum();
        self.rays.fetch_add(stats.len() as u64, Ordering::Relaxed);
        self.sphere_traced_rays.fetch_add(sphere_traced, Ordering::Relaxed);
        self.evaluations.fetch_add(evaluations, Ordering::Relaxed);
    }

    /// Sums so far.
    pub(crate) fn total(&self) -> RayStats {
        RayStats {
            rays: self.rays.load(Ordering::Relaxed),
            sphere_traced_rays: self.sphere_traced_rays.load(Ordering::Relaxed),
            evaluations: self.evaluations.load(Ordering::Relaxed),
        }
    }
}
