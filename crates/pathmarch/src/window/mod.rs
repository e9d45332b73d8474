//! The window: the scene path-traced while one moves through it and changes it.
//!
//! `App` holds everything a person sees and does, and knows neither window nor graphics device, so that tests drive it
//! without them. The event loop and the painter are the shell around it.

mod app;
mod background_render;
mod camera;
mod event_loop;
mod file_dialog;
mod files;
mod gallery;
mod gizmo;
mod open_scene;
mod painter;
mod panels;
#[cfg(test)]
mod tests;
mod waker;

pub use app::Options;
pub use event_loop::run;
pub use painter::Drawing;
