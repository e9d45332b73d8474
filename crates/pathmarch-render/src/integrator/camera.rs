//! Camera rays: a thin lens (Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model"),
//! a pinhole when its radius is zero. A pixel is the mean over uniformly distributed positions inside it (box filter).

use crate::intersect::ray::Ray;
use crate::sampling::sobol::{PixelSampler, pair};
use crate::scene::FrameUniforms;
use glam::Vec3;
use pathmarch_scene::Sampler;
use std::f32::consts::TAU;

/// Random numbers of sample `sample` of the pixel (`x`, `y`), of the frame's seed and sampler.
pub(crate) fn pixel_sampler(frame: &FrameUniforms, x: u32, y: u32, sample: u32) -> PixelSampler {
    let independent = frame.sampler == Sampler::Independent as u32;
    PixelSampler::new(x, y, sample, frame.seed).independent(independent)
}

/// Camera ray of one sample of each of these pixels (x, y); row 0 is the top.
pub(crate) fn camera_rays(frame: &FrameUniforms, pixels: &[(u32, u32)], samplers: &[PixelSampler]) -> Vec<Ray> {
    let position = Vec3::from(frame.position);
    let jitters = PixelSampler::samples_2d(samplers, pair::PAIR_PIXEL);
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
    views.zip(PixelSampler::samples_2d(samplers, pair::PAIR_LENS)).map(through).collect()
}

/// Ray through the middle of the lens and a position in the picture, in pixels from its top left corner.
pub(crate) fn central_ray(frame: &FrameUniforms, x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::from(frame.position), direction: view(frame, x, y).normalize() }
}

/// Vector from the lens to a position in the picture, at distance one from the lens.
fn view(frame: &FrameUniforms, x: f32, y: f32) -> Vec3 {
    let across = 2.0 * x / frame.width as f32 - 1.0;
    let up = 1.0 - 2.0 * y / frame.height as f32;
    Vec3::from(frame.forward) + Vec3::from(frame.right) * across + Vec3::from(frame.up) * up
}
