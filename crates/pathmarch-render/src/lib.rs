#![doc = include_str!("../README.md")]
//!
//! Rays find the scene by sphere tracing (*path marching*; Carvalho, "Combining the Ray Marching and Rasterization
//! rendering models", University of Porto, 2020), light is carried by Monte Carlo path tracing with next-event estimation,
//! and samples accumulate in a [`film::Film`].

pub mod aov;
pub mod film;
pub mod image;
pub mod live;
pub mod mesh_file;
pub mod metrics;
pub mod tonemap;

mod census;
mod cpu;
mod error;
mod frame;
mod gpu;
mod mode;
mod motion;
mod pick;
mod renderer;
mod settings;
#[doc(hidden)]
pub mod testing;
mod tracer;
mod transport;
mod whole;

pub use census::{Census, census};
pub use error::RenderError;
pub use gpu::{AdapterDescription, adapters};
pub use mode::{Mode, relative_error};
pub use motion::{MotionError, MovingJob, Shutter};
pub use pathmarch_field;
pub use pathmarch_scene;
pub use pick::{Picked, clearance, pick};
pub use renderer::{Backend, Job, Renderer};
pub use settings::{LightSearch, MAX_BOUNCES, MAX_SPLITTING, Settings};

/// SHA-256 of the scene's text and of its sky's picture, in hexadecimal: which scene a picture shows.
pub fn scene_hash(scene: &pathmarch_scene::Scene) -> String {
    use sha2::{Digest, Sha256};
    let mut hash = Sha256::new();
    hash.update(scene.source_text.as_bytes());
    if let pathmarch_scene::Sky::Map(picture) = &scene.sky {
        hash.update(bytemuck::cast_slice(&picture.texels));
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
