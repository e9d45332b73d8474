#![doc = include_str!("../README.md")]
//!
//! Rays intersect the scene by sphere tracing (*path marching*; Carvalho, "Combining the Ray Marching and Rasterization
//! rendering models to provide real-time high-fidelity graphics", University of Porto, 2020). Light transport is Monte Carlo path tracing with next-event estimation.
//! Samples accumulate in a [`film::Film`].

// Live pictures need threads; without them, what only they use is dead.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_imports))]

pub mod denoise;
#[cfg(not(target_family = "wasm"))]
pub mod live;
pub mod mesh_file;
pub mod metrics;
pub mod reconstruct;
#[doc(hidden)]
pub mod testing;
pub mod volume_file;

mod backend;
mod error;
mod integrator;
mod intersect;
mod job;
mod mode;
mod output;
mod preview;
mod preview_steps;
mod ray_stats;
mod sampling;
mod scene;
mod settings;
mod shading;
mod views;
mod wgsl;

pub use backend::gpu::{AdapterDescription, adapters};
pub use error::RenderError;
pub use job::{AdaptiveJob, AdaptiveTile, MAX_NOISE, MIN_NOISE};
pub use job::{Backend, BackendInfo, Job, Renderer, Shutter, TileTracer, kernel_wgsl, ray_stats};
#[cfg(target_family = "wasm")]
pub use job::{WebGpu, WebGpuJob};
pub use mode::{Mode, relative_error};
pub use output::{atomic_file, exposure, film, image, parts, tonemap};
pub use pathmarch_field;
pub use pathmarch_mesh::files::mount as mount_file;
pub use pathmarch_scene;
pub use preview_steps::{PreviewStep, PreviewSteps};
pub use ray_stats::RayStats;
pub use settings::{MAX_BOUNCES, MAX_INDIRECT_SAMPLES, MAX_LIGHT_PATHS, MAX_LIGHT_SAMPLES, MAX_SPLITTING, Settings};
pub use views::aov;
pub use views::pick::{Picked, clearance, pick};

/// SHA-256 of the scene's text and of its environment map, in hexadecimal. It identifies the scene of a picture.
pub fn scene_hash(scene: &pathmarch_scene::Scene) -> String {
    use sha2::{Digest, Sha256};
    let mut hash = Sha256::new();
    hash.update(scene.source_text.as_bytes());
    if let pathmarch_scene::Sky::Map(picture) = &scene.sky {
        hash.update(bytemuck::cast_slice(&picture.texels));
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
