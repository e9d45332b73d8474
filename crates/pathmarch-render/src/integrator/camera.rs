//! Camera rays: a thin lens (Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model"), or a pinhole if its
//! radius is zero. The pixel filter is a box: positions are uniformly distributed in the pixel.

use crate::intersect::ray::Ray;
use crate::sampling::sobol::{PixelSampler, pair, place_by_group};
use crate::scene::{FrameUniforms, TraceContext};
use glam::Vec3;
use pathmarch_field::number::unit_circle;
use pathmarch_scene::Sampler;

/// Random numbers of sample `sample` of the pixel (`x`, `y`), with the seed and the sampler of the frame.
pub(crate) fn pixel_sampler(ctx: &TraceContext, x: u32, y: u32, sample: u32) -> PixelSampler {
    let independent = ctx.frame.sampler == Sampler::Independent as u32;
    let [x, y] = if ctx.config.path_reuse { place_by_group(x, y) } else { [x, y] };
    PixelSampler::new(x, y, sample, ctx.frame.seed).independent(independent)
}

/// Camera ray of one sample of each of these pixels (x, y); row 0 is at the top.
pub(crate) fn camera_rays(frame: &FrameUniforms, pixels: &[(u32, u32)], samplers: &[PixelSampler]) -> Vec<Ray> {
    let position = Vec3::from(frame.position);
    let pixel_offsets = PixelSampler::samples_2d(samplers, pair::PAIR_PIXEL);
    let view_vectors =
        pixels.iter().zip(pixel_offsets).map(|(&(x, y), [dx, dy])| view_vector(frame, x as f32 + dx, y as f32 + dy));
    if frame.lens_radius == 0.0 {
        return view_vectors.map(|view_vector| Ray { origin: position, direction: view_vector.normalize() }).collect();
    }
    let [right, up] = [frame.right, frame.up].map(|axis| Vec3::from(axis).normalize() * frame.lens_radius);
    let lens_ray = |(view_vector, [u, v]): (Vec3, [f32; 2])| {
        let [cosine, sine] = unit_circle(v);
        let offset = (right * cosine + up * sine) * u.sqrt();
        Ray { origin: position + offset, direction: (view_vector * frame.focus - offset).normalize() }
    };
    view_vectors.zip(PixelSampler::samples_2d(samplers, pair::PAIR_LENS)).map(lens_ray).collect()
}

/// Ray through the centre of the lens and a position in the picture, in pixels from its top left corner.
pub(crate) fn central_ray(frame: &FrameUniforms, x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::from(frame.position), direction: view_vector(frame, x, y).normalize() }
}

/// Point on the ray through the centre of the lens and the place in the picture of a camera ray, at the depth of a point `p`.
pub(crate) fn central_point(frame: &FrameUniforms, ray: &Ray, p: Vec3) -> Vec3 {
    if frame.lens_radius == 0.0 {
        return p;
    }
    let (position, forward) = (Vec3::from(frame.position), Vec3::from(frame.forward));
    let in_focus = ray.origin + ray.direction * (frame.focus / ray.direction.dot(forward));
    position + (in_focus - position) * ((p - position).dot(forward) / frame.focus)
}

/// Vector from the lens to a position in the picture, in the plane at distance one.
fn view_vector(frame: &FrameUniforms, x: f32, y: f32) -> Vec3 {
    let across = 2.0 * x / frame.width as f32 - 1.0;
    let up = 1.0 - 2.0 * y / frame.height as f32;
    Vec3::from(frame.forward) + Vec3::from(frame.right) * across + Vec3::from(frame.up) * up
}
