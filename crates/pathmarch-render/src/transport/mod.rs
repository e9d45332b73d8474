//! How light travels, written twice on purpose.
//!
//! Each part is a pair of one name: `x.wgsl` runs in the GPU kernel, `x.rs` in the CPU renderer, which is an independent
//! path tracer in plain Rust and the oracle the kernel is tested against. Both draw the same random numbers in the same
//! order, so pictures of one seed differ only by rounding.

pub(crate) mod alias;
pub(crate) mod basis;
pub(crate) mod camera;
mod irradiance;
pub(crate) mod lights;
pub(crate) mod march;
pub(crate) mod paint;
pub(crate) mod path;
pub(crate) mod preview;
mod probe;
pub(crate) mod random;
mod shadow;
pub(crate) mod sky;
mod soft_shadow;
pub(crate) mod splitting;
pub(crate) mod steady;
mod variance;
pub(crate) mod views;
pub(crate) mod visible;

use crate::frame::Prepared;
use crate::mode::Mode;
use glam::Vec3;

/// So many samples from this one on of each of these pixels on the CPU, those of a pixel in a row; more than one only where
/// they share a ray of the camera.
pub(crate) fn samples_of(prepared: &Prepared, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
    match prepared.mode {
        Mode::Path => path::trace(prepared, pixels, first, samples),
        Mode::Preview => preview::trace(prepared, pixels, first),
        Mode::Variance => variance::moments(prepared, pixels, first),
        _ => views::view(prepared, pixels, first),
    }
}

/// The name of what computes a sample on the GPU: `NAME(camera: Ray, random: Random) -> vec3f`.
fn trace_wgsl(mode: Mode) -> &'static str {
    match mode {
        Mode::Path => PATH_WGSL,
        Mode::Preview => "preview_along",
        Mode::Variance => "moments_along",
        _ => "view_along",
    }
}

/// The function of [`Mode::Path`].
const PATH_WGSL: &str = "radiance_along";

/// The entry point of the kernel.
pub(crate) const TRACE: &str = include_str!("trace.wgsl");

/// What the entry point computes: `samples_of(x: u32, y: u32) -> vec4f`.
pub(crate) fn samples_wgsl(mode: Mode, splitting: u32, loops_are_limited: bool) -> String {
    let checks = match loops_are_limited {
        true => include_str!("loop_limit.wgsl"),
        false => include_str!("loops_unlimited.wgsl"),
    };
    let samples = match splitting {
        1 if loops_are_limited && mode.traces_paths() => include_str!("sample_resumed.wgsl").to_owned(),
        1 => include_str!("sample.wgsl").replace(PATH_WGSL, trace_wgsl(mode)),
        _ => include_str!("splitting.wgsl").to_owned(),
    };
    format!("{checks}\n{samples}")
}

/// The kernel's WGSL but for the scene's field and the entry point; declarations may stand in any order.
pub(crate) fn kernel(mode: Mode) -> &'static [&'static str] {
    const BASIS: &str = include_str!("basis.wgsl");
    const CAMERA: &str = include_str!("camera.wgsl");
    const FRAME: &str = include_str!("frame.wgsl");
    const LIGHTS: &str = include_str!("lights.wgsl");
    const MARCH: &str = include_str!("march.wgsl");
    const PATH: &str = include_str!("path.wgsl");
    const RANDOM: &str = include_str!("random.wgsl");
    const SHADOW: &str = include_str!("shadow.wgsl");
    const SKY: &str = include_str!("sky.wgsl");
    const STEADY: &str = include_str!("steady.wgsl");
    const VISIBLE: &str = include_str!("visible.wgsl");
    match mode {
        Mode::Path => &[BASIS, CAMERA, LIGHTS, MARCH, FRAME, PATH, RANDOM, SHADOW, SKY, include_str!("radiance.wgsl")],
        Mode::Variance => {
            &[BASIS, CAMERA, LIGHTS, MARCH, FRAME, PATH, RANDOM, SHADOW, SKY, include_str!("variance.wgsl")]
        }
        Mode::Preview => &[
            BASIS,
            CAMERA,
            LIGHTS,
            MARCH,
            FRAME,
            SKY,
            STEADY,
            VISIBLE,
            include_str!("irradiance.wgsl"),
            include_str!("preview.wgsl"),
            include_str!("soft_shadow.wgsl"),
        ],
        _ => &[CAMERA, MARCH, FRAME, STEADY, VISIBLE, include_str!("views.wgsl")],
    }
}

/// Only for scenes whose shadows are softened by near misses.
pub(crate) const PENUMBRA: &str = include_str!("penumbra.wgsl");
/// The WGSL of what varies along surfaces, for scenes that have such; what it changes depends on the mode.
pub(crate) fn paint(mode: Mode) -> [&'static str; 2] {
    let changes = match mode {
        Mode::Path | Mode::Variance => include_str!("paint_numbers.wgsl"),
        Mode::Preview => include_str!("paint_look.wgsl"),
        _ => include_str!("paint_colour.wgsl"),
    };
    [include_str!("paint.wgsl"), changes]
}
