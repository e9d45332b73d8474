//! Camera rays: a thin lens (Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model"), or a pinhole if its
//! radius is zero. The pixel filter is a box: positions are uniformly distributed in the pixel.

use crate::intersect::ray::{Ray, Rays8, lanes};
use crate::sampling::sobol::{PixelSampler, PixelSampler8, pair, place_by_group};
use crate::scene::{FrameUniforms, TraceContext};
use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3, unit_circle};
use pathmarch_scene::Sampler;
use wide::f32x8;

/// Random numbers of sample `sample` of the pixel (`x`, `y`), with the seed and the sampler of the frame.
pub(crate) fn pixel_sampler(ctx: &TraceContext, x: u32, y: u32, sample: u32) -> PixelSampler {
    let independent = ctx.frame.sampler == Sampler::Independent as u32;
    let [x, y] = if ctx.config.path_reuse { place_by_group(x, y) } else { [x, y] };
    PixelSampler::new(x, y, sample, ctx.frame.seed).independent(independent)
}

/// Camera ray of one sample of each of these pixels (x, y); row 0 is at the top.
pub(crate) fn camera_rays(frame: &FrameUniforms, pixels: &[(u32, u32)], samplers: &[PixelSampler]) -> Vec<Ray> {
    let offsets = PixelSampler::samples_2d(samplers, pair::PAIR_PIXEL);
    let positions = pixels.iter().zip(offsets).map(|(&(x, y), [dx, dy])| [x as f32 + dx, y as f32 + dy]);
    let ray = |(position, lens): ([f32; 2], [f32; 2])| {
        let (origin, direction) = camera_ray(frame, position, lens);
        Ray { origin: origin.into(), direction: direction.into() }
    };
    if frame.lens_radius == 0.0 {
        return positions.map(|position| ray((position, [0.0; 2]))).collect();
    }
    positions.zip(PixelSampler::samples_2d(samplers, pair::PAIR_LENS)).map(ray).collect()
}

/// [`camera_rays`] of up to eight pixels, in lanes.
pub(super) fn camera_rays_in_lanes(frame: &FrameUniforms, pixels: &[(u32, u32)], samplers: &PixelSampler8) -> Rays8 {
    let [dx, dy] = samplers.sample_2d(pair::PAIR_PIXEL);
    let pixel = |lane: usize| pixels[lane.min(pixels.len() - 1)];
    let position = [lanes(|lane| pixel(lane).0 as f32) + dx, lanes(|lane| pixel(lane).1 as f32) + dy];
    let lens = if frame.lens_radius == 0.0 { [f32x8::ZERO; 2] } else { samplers.sample_2d(pair::PAIR_LENS) };
    let (origin, direction) = camera_ray(frame, position, lens);
    Rays8 { origin, direction, limit: f32x8::splat(frame.far) }
}

/// Origin and direction of the camera ray through a position in the picture, in pixels from its top left corner, and a random
/// point of the lens.
#[inline(always)]
pub(super) fn camera_ray<N: Real>(
    frame: &FrameUniforms,
    [x, y]: [N; 2],
    [u, v]: [N; 2],
) -> (FieldVec3<N>, FieldVec3<N>) {
    let [position, right, up, forward] =
        [frame.position, frame.right, frame.up, frame.forward].map(FieldVec3::<N>::constant);
    let across = N::constant(2.0) * x / N::constant(frame.width as f32) - N::one();
    let upwards = N::one() - N::constant(2.0) * y / N::constant(frame.height as f32);
    let view_vector = forward + right * across + up * upwards;
    if frame.lens_radius == 0.0 {
        return (position, view_vector.normalized());
    }
    let radius = N::constant(frame.lens_radius) * u.sqrt();
    let [cosine, sine] = unit_circle(v);
    let offset = right.normalized() * (cosine * radius) + up.normalized() * (sine * radius);
    (position + offset, (view_vector * N::constant(frame.focus) - offset).normalized())
}

/// Ray through the centre of the lens and a position in the picture, in pixels from its top left corner.
pub(crate) fn central_ray(frame: &FrameUniforms, x: f32, y: f32) -> Ray {
    let frame = FrameUniforms { lens_radius: 0.0, ..*frame };
    let (origin, direction) = camera_ray(&frame, [x, y], [0.0; 2]);
    Ray { origin: origin.into(), direction: direction.into() }
}

/// Index of the sample at a pixel of a picture of this size, which may be larger than its samples.
pub(crate) fn sample_at(pixel: [u32; 2], size: [u32; 2], samples: [u32; 2]) -> usize {
    let [x, y]: [u32; 2] = std::array::from_fn(|k| {
        let factor = size[k] as f32 / samples[k] as f32;
        (((pixel[k] as f32 + 0.5) / factor) as u32).min(samples[k] - 1)
    });
    (y * samples[0] + x) as usize
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
