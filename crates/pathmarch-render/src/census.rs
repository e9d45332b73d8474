//! What a picture costs in evaluations of the field.
//!
//! The CPU backend counts while it renders. It follows the same paths as the kernels, so that its numbers are those of a
//! GPU, too.

use crate::cpu::CpuJob;
use crate::error::RenderError;
use crate::frame::Prepared;
use crate::renderer::check;
use crate::settings::Settings;
use crate::transport::march::Trail;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What one sample of every pixel took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Rays of the camera, of paths, and to lights.
    pub rays: u64,
    /// Those of them that came into the box of what must be marched.
    pub marched_rays: u64,
    /// Evaluations of the marched field by all of them; normals, one for each surface that is met, are not counted.
    pub evaluations: u64,
}

impl Census {
    /// Evaluations for each ray.
    pub fn evaluations_per_ray(&self) -> f64 {
        self.evaluations as f64 / self.rays.max(1) as f64
    }
}

/// Counts one sample of every pixel of a picture, on the CPU.
///
/// # Errors
/// [`RenderError::Settings`] where settings are out of range.
pub fn census(scene: &Scene, settings: &Settings) -> Result<Census, RenderError> {
    check(scene, settings)?;
    let counter = Arc::new(Counter::default());
    let mut prepared = Prepared::new(scene, settings);
    prepared.counter = Some(counter.clone());
    CpuJob::new(prepared, settings.first_sample).advance(1);
    Ok(counter.total())
}

/// A census that all threads write.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    rays: AtomicU64,
    marched_rays: AtomicU64,
    evaluations: AtomicU64,
}

impl Counter {
    /// Adds what some rays saw.
    pub(crate) fn add(&self, trails: &[Trail]) {
        let marched = trails.iter().filter(|trail| trail.evaluations > 0).count() as u64;
        let evaluations = trails.iter().map(|trail| u64::from(trail.evaluations)).sum();
        self.rays.fetch_add(trails.len() as u64, Ordering::Relaxed);
        self.marched_rays.fetch_add(marched, Ordering::Relaxed);
        self.evaluations.fetch_add(evaluations, Ordering::Relaxed);
    }
    /// What all of them saw.
    pub(crate) fn total(&self) -> Census {
        Census {
            rays: self.rays.load(Ordering::Relaxed),
            marched_rays: self.marched_rays.load(Ordering::Relaxed),
            evaluations: self.evaluations.load(Ordering::Relaxed),
        }
    }
}
