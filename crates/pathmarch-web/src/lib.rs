//! WebAssembly module of the web page. The page's threads each have an instance of it, and share nothing:
//!
//! - the page itself turns the [`Viewpoint`] and adds samples to the [`Picture`];
//! - one worker has the [`Editor`]: the text, its mistakes and controls;
//! - one has a `GpuTracer` and traces whole pictures on the GPU, if the browser has one;
//! - otherwise the others have a [`Tracer`] each and trace rectangles of samples.
//!
//! So it needs neither shared memory nor the headers that isolate a page, and any server of static files will do.
//! Objects go to and from JavaScript as JSON, numbers of pixels as typed arrays.

use wasm_bindgen::prelude::wasm_bindgen;

mod controls;
mod editor;
#[cfg(target_family = "wasm")]
mod gpu_tracer;
mod picture;
mod report;
mod tracer;
mod view;
mod viewpoint;

pub use editor::Editor;
#[cfg(target_family = "wasm")]
pub use gpu_tracer::GpuTracer;
pub use picture::Picture;
pub use tracer::Tracer;
pub use viewpoint::Viewpoint;

/// Gives a file to the readers of this instance; scenes name it by its path relative to their own.
#[wasm_bindgen]
pub fn mount(path: &str, bytes: Vec<u8>) {
    pathmarch_render::mount_file(path, bytes);
}

/// Prints panics on the console of the browser.
#[cfg(target_family = "wasm")]
#[wasm_bindgen(start)]
pub fn start() {
    console_error_panic_hook::set_once();
}
