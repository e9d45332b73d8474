//! The window: a live path-traced view of a scene, with editing.
//!
//! [`app`] contains all state and runs without window or graphics device, so that tests can drive it. [`panels`] draw it;
//! [`event_loop`] and [`painter`] connect it to the system.

mod app;
mod background_render;
mod event_loop;
mod exposure;
mod file_dialog;
mod files;
mod gallery;
mod gizmo;
mod material_balls;
mod open_scene;
mod painter;
mod panels;
mod projection;
mod source_editor;
mod surface_snap;
#[cfg(test)]
mod tests;
mod waker;

pub use app::Options;
pub use event_loop::run;
pub use painter::Drawing;
