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

/// The ray of one sample of each of these pixels (x, y), row 0 the top, and its random numbers.
pub(crate) fn camera_rays(frame: &Frame, pixels: &[(u32, u32)], randoms: &[Random]) -> Vec<Ray> {
    let position = Vec3::from(frame.position);
    let jitters = Random::pairs(randoms, pair::PIXEL);
    let views = pixels.iter().zip(jitters).map(|(&(x, y), [dx, dy])| view(frame, x as f32 + dx, y as f32 + dy));
    if frame.lens_radius == 0.0 {
        return views.map(|view| Ray { origin: position, direction: view.normalize() }).collect();
    }
    let [right, up] = [frame.right, frame.up].map(|axis| Vec3::from(axis).normalize() * frame.lens_radius);
    let through = |(view, [u, v]): (Vec3, [f32; 2])| {
        let (sine, cosine) = (TAU * v).sin_cos();
        let offset = (right * cosine + up * sine) * u.sqrt();
        Ray { origin: position + offset, direction: (view * frame.focus - offset).normalize() }
    };
    views.zip(Random::pairs(randoms, pair::LENS)).map(through).collect()
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
