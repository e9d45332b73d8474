//! Errors of rendering.

use pathmarch_scene::SceneError;
use thiserror::Error;

/// Failure of a backend. The message names the failure and its place, and suggests a remedy.
#[derive(Debug, Error)]
pub enum RenderError {
    /// No adapter can render.
    #[error(
        "no usable GPU adapter: {reason}; install a graphics driver (Mesa's software Vulkan is enough), or render with the CPU backend"
    )]
    NoAdapter {
        /// Reason why no adapter can be used.
        reason: String,
    },
    /// No adapter has this name.
    #[error("no adapter's name contains \"{name}\"; available: {}", list(.available))]
    NoSuchAdapter {
        /// Requested name, or a part of one.
        name: String,
        /// Names of all usable adapters.
        available: Vec<String>,
    },
    /// The adapter refused a request, or failed.
    #[error("{adapter}: {reason}; use another adapter or the CPU backend")]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver, or description of the failure.
        reason: String,
    },
    /// The adapter ends the loops of a shader after a number of iterations, so that the picture would be wrong.
    #[error(
        "{adapter}: it ends the loops of a shader after a number of iterations (Mesa: 65,535), and this scene needs more; the \
         picture would be wrong; use another adapter or the CPU backend"
    )]
    LoopLimit {
        /// Name of the adapter.
        adapter: String,
    },
    /// The picture or the scene exceeds a limit of the adapter.
    #[error("{adapter} has no room for {what}; make it smaller, or render with the CPU backend")]
    TooLarge {
        /// Name of the adapter.
        adapter: String,
        /// Description of the object that is too large.
        what: String,
    },
    /// A setting is out of range.
    #[error("{0}")]
    Settings(String),
    /// The text of an animation is not a valid scene at some moment.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
