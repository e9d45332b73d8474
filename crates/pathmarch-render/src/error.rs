//! Errors of rendering.

use pathmarch_scene::SceneError;
use thiserror::Error;

/// A failure of a backend; the message says what, where and what to do.
#[derive(Debug, Error)]
pub enum RenderError {
    /// There is no adapter to render on.
    #[error(
        "no usable GPU adapter: {reason}; install a graphics driver (Mesa's software Vulkan will do), or render with the CPU backend"
    )]
    NoAdapter {
        /// What was found instead.
        reason: String,
    },
    /// No adapter has this name.
    #[error("no adapter's name contains \"{name}\"; there is {}", list(.available))]
    NoSuchAdapter {
        /// The name asked for.
        name: String,
        /// The names there are.
        available: Vec<String>,
    },
    /// The adapter refused or failed.
    #[error("{adapter}: {reason}; try another adapter, or the CPU backend")]
    Device {
        /// The adapter.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// The adapter cannot hold this.
    #[error("{adapter} cannot hold {what}; ask for less, or render with the CPU backend")]
    TooLarge {
        /// The adapter.
        adapter: String,
        /// What is too large.
        what: String,
    },
    /// A setting is out of range.
    #[error("{0}")]
    Settings(String),
    /// The text of an animation is no scene at some moment.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
