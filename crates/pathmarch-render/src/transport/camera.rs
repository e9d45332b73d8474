//! The camera as a generator of rays: a thin lens (Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model"),
//! a pinhole when its radius is zero. A pixel is the mean over uniformly distributed positions inside it (box filter).

use super::random::{Random, pair};
use crate::frame::Frame;
use glam::Vec3;
use std::f32::consts::TAU;

/// A ray in world space with a direction of length one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
}

/// The ray of one sample of the pixel (`x`, `y`), row 0 the top.
pub(crate) fn camera_ray(frame: &Frame, x: u32, y: u32, random: Random) -> Ray {
    let [jitter_x, jitter_y] = random.pair(pair::PIXEL);
    let position = Vec3::from(frame.position);
    let view = view(frame, x as f32 + jitter_x, y as f32 + jitter_y);
    if frame.lens_radius == 0.0 {
        return Ray { origin: position, direction: view.normalize() };
    }
    let [u, v] = random.pair(pair::LENS);
    let radius = frame.lens_radius * u.sqrt();
    let (sine, cosine) = (TAU * v).sin_cos();
    let offset =
        Vec3::from(frame.right).normalize() * (radius * cosine) + Vec3::from(frame.up).normalize() * (radius * sine);
    Ray { origin: position + offset, direction: (view * frame.focus - offset).normalize() }
}

/// The ray through the middle of the lens and a position in the picture, in pixels from its top left corner.
pub(crate) fn central_ray(frame: &Frame, x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::from(frame.position), direction: view(frame, x, y).normalize() }
}

/// From the lens to a position in the picture, at distance one from the lens.
fn view(frame: &Frame, x: f32, y: f32) -> Vec3 {
    let across = 2.0 * x / frame.width as f32 - 1.0;
    let up = 1.0 - 2.0 * y / frame.height as f32;
    Vec3::from(frame.forward) + Vec3::from(frame.right) * across + Vec3::from(frame.up) * up
}
