//! Lens targets: emitters far out of focus, at which further camera rays of a pixel aim.
//!
//! **Idea.** A small lamp out of focus fills a disc of the picture as large as the circle of confusion. In all of it, camera
//! rays hit the lamp from a small part of the lens only, so that single bright samples show it. But the part of the lens is
//! known: seen from the point in focus, it is the shadow of the lamp's bounding sphere. So half of the further camera rays of
//! a pixel start there: the later ones, which are as evenly distributed as the others. The power heuristic weights all rays of
//! a pixel, as samples of one integral over the lens; no light is lost, whatever the rays hit.
//!
//! **Source.** Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering".
//!
//! **Limits.** Emitters that cover more than [`MAX_LENS_SHARE`] of the lens are left to rays from all of it, and so are those
//! behind the [`MAX_LENS_TARGETS`] first lights.

use super::camera::{camera_ray, central_ray};
use crate::intersect::ray::Ray;
use crate::scene::{FrameUniforms, TraceContext};
use crate::wgsl::shared_constants;
use glam::{Vec2, Vec3};
use pathmarch_field::number::unit_circle;

shared_constants! {
    /// Number of lights, from the first one, that may be targets.
    const MAX_LENS_TARGETS: u32 = 256;
    /// Largest radius of a target's part of the lens, in radii of the lens.
    const MAX_LENS_SHARE: f32 = 0.5;
    /// Least cosine between the view direction and rays at the edge of a target's part.
    const MIN_LENS_COSINE: f32 = 0.1;
    /// Least radius of a target's part of the lens, in radii of the lens.
    const MIN_LENS_PART: f32 = 1e-3;
    /// Distance from the disc of an emitter in the picture within which pixels may show it, pixels.
    const EMITTER_MARGIN: f32 = 1.0;
}

/// Emitters of a picture that are far out of focus.
#[derive(Clone, Debug, Default)]
pub(crate) struct LensTargets(Vec<Target>);

/// Emitter far out of focus.
#[derive(Clone, Copy, Debug)]
struct Target {
    /// Sphere around it, in world space, metres.
    centre: Vec3,
    radius: f32,
    disc: Disc,
}

/// Disc in the picture in which an emitter may be seen, pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    centre: Vec2,
    pub(super) radius: f32,
}

/// Part of the lens from which a target is seen, a disc, in radii of the lens.
#[derive(Clone, Copy, Debug)]
struct LensPart {
    centre: Vec2,
    radius: f32,
}

impl LensPart {
    /// Part from which the point in focus sees a target; `None` if it lies beside the lens.
    fn new(frame: &FrameUniforms, in_focus: Vec3, target: &Target) -> Option<Self> {
        let [position, forward, right, up] = [frame.position, frame.forward, frame.right, frame.up].map(Vec3::from);
        let apart = target.centre - in_focus;
        let distance = apart.length();
        let beyond = (target.centre - position).dot(forward) - frame.focus;
        let on_lens = in_focus - apart * (frame.focus / beyond) - position;
        let centre = Vec2::new(on_lens.dot(right.normalize()), on_lens.dot(up.normalize())) / frame.lens_radius;
        // The shadow of a sphere is an ellipse: its farthest point is that of the cone's most oblique ray.
        let (sine, oblique) = (target.radius / distance, beyond.abs() / distance);
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let least_cosine = oblique * cosine - (1.0 - oblique * oblique).max(0.0).sqrt() * sine;
        let length = distance * (frame.focus / beyond).abs();
        let radius = length * sine / (least_cosine.max(MIN_LENS_COSINE) * frame.lens_radius);
        let radius = radius.max(MIN_LENS_PART);
        (centre.length() < 1.0 + radius).then_some(Self { centre, radius })
    }

    /// True if a point of the lens belongs to it.
    fn contains(&self, point: Vec2) -> bool {
        point.distance_squared(self.centre) <= self.radius * self.radius
    }
}

/// Position of a ray among the further camera rays of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct FurtherRay {
    pub(super) index: u32,
    /// Number of these rays.
    pub(super) count: u32,
}

impl LensTargets {
    /// Targets of a picture; none with a pinhole.
    pub(crate) fn new(ctx: &TraceContext) -> Self {
        if ctx.frame.lens_radius == 0.0 {
            return Self::default();
        }
        let lights = ctx.scene.lights.iter().take(MAX_LENS_TARGETS as usize);
        let bounds = lights.filter_map(|light| light.shape.emitting_bounds());
        let target = |(centre, radius)| {
            let disc = Disc::new(ctx.frame, centre, radius).filter(|_| is_target(ctx.frame, centre, radius))?;
            Some(Target { centre, radius, disc })
        };
        Self(bounds.filter_map(target).collect())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Discs of all targets.
    pub(crate) fn discs(&self) -> impl Iterator<Item = Disc> {
        self.0.iter().map(|target| target.disc)
    }

    /// Further camera ray through a position in the picture, in pixels from its top left corner, and the weight of what it
    /// sees. `random` are uniform numbers.
    pub(super) fn ray(
        &self,
        frame: &FrameUniforms,
        position: [f32; 2],
        random: [f32; 2],
        FurtherRay { index, count }: FurtherRay,
    ) -> (Ray, f32) {
        if self.0.is_empty() {
            let (origin, direction) = camera_ray(frame, position, random);
            return (Ray { origin: origin.into(), direction: direction.into() }, 1.0);
        }
        let central = central_ray(frame, position[0], position[1]).direction;
        let in_focus = Vec3::from(frame.position) + central * (frame.focus / central.dot(frame.forward.into()));
        let near = self.0.iter().filter(|target| target.disc.is_near(position.into()));
        let parts: Vec<LensPart> = near.filter_map(|target| LensPart::new(frame, in_focus, target)).collect();
        let aimed = count / 2;
        let number = parts.len() as u32;
        let [u, v] = random;
        let [cosine, sine] = unit_circle(v);
        let on_disc = Vec2::new(cosine, sine) * u.sqrt();
        // Aimed rays take turns.
        let chosen = index.checked_sub(count - aimed).filter(|_| number > 0).map(|turn| turn % number);
        let point = match chosen.map(|chosen| parts[chosen as usize]) {
            Some(part) => part.centre + on_disc * part.radius,
            None => on_disc,
        };
        // Densities of the rays of all kinds, in those of rays from all of the lens.
        let from_all = (count - if number > 0 { aimed } else { 0 }) as f32;
        let (mut own, mut squares) = (from_all, from_all * from_all);
        for (k, part) in (0..).zip(&parts).filter(|(k, part)| chosen == Some(*k) || part.contains(point)) {
            let rays = aimed / number + u32::from(k < aimed % number);
            let density = rays as f32 / (part.radius * part.radius);
            squares += density * density;
            own = if chosen == Some(k) { density } else { own };
        }
        let weight = if point.length_squared() > 1.0 { 0.0 } else { count as f32 * own / squares };
        let [right, up] = [frame.right, frame.up].map(|axis| Vec3::from(axis).normalize());
        let origin = Vec3::from(frame.position) + (right * point.x + up * point.y) * frame.lens_radius;
        (Ray { origin, direction: (in_focus - origin).normalize() }, weight)
    }
}

/// True if an emitter within a sphere is seen from a small part of the lens only.
fn is_target(frame: &FrameUniforms, centre: Vec3, radius: f32) -> bool {
    let depth = (centre - Vec3::from(frame.position)).dot(frame.forward.into());
    radius > 0.0
        && depth > 2.0 * radius
        && radius * frame.focus <= MAX_LENS_SHARE * frame.lens_radius * (depth - frame.focus).abs()
}

impl Disc {
    /// Disc of an emitter within a sphere; `None` behind the camera. It is infinite if the camera may be inside.
    pub(super) fn new(frame: &FrameUniforms, centre: Vec3, radius: f32) -> Option<Self> {
        let [position, forward, right, up] = [frame.position, frame.forward, frame.right, frame.up].map(Vec3::from);
        let offset = centre - position;
        let depth = offset.dot(forward);
        let nearest = depth - radius;
        if depth <= -radius {
            return None;
        }
        let half_size = 0.5 * Vec2::new(frame.width as f32, frame.height as f32);
        if nearest <= 0.0 {
            return Some(Self { centre: half_size, radius: f32::INFINITY });
        }
        let across =
            Vec2::new(offset.dot(right) / right.length_squared(), offset.dot(up) / up.length_squared()) / depth;
        // The outline is an ellipse, which is longer the farther it is from the axis.
        let stretch = offset.length_squared() / (depth * depth);
        let blur = frame.lens_radius * (1.0 / frame.focus - 1.0 / depth).abs();
        let pixels_at_distance_one = half_size.y / up.length();
        Some(Self {
            centre: half_size * (1.0 + across * Vec2::new(1.0, -1.0)),
            radius: (radius / nearest * stretch + blur) * pixels_at_distance_one,
        })
    }

    /// True if a position is within the disc, or next to it.
    fn is_near(&self, position: Vec2) -> bool {
        position.distance(self.centre) <= self.radius + EMITTER_MARGIN
    }

    /// Visits the pixels of a picture whose middles are within the disc, or next to it.
    pub(crate) fn visit(&self, [width, height]: [u32; 2], mut visit: impl FnMut(usize)) {
        let reach = self.radius + EMITTER_MARGIN;
        let range = |at: f32, length: u32| {
            let end = (at + reach).ceil().clamp(0.0, length as f32) as u32;
            (at - reach).floor().clamp(0.0, end as f32) as u32..end
        };
        for y in range(self.centre.y, height) {
            for x in range(self.centre.x, width) {
                if self.is_near(Vec2::new(x as f32, y as f32) + 0.5) {
                    visit((y * width + x) as usize);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    const LAMPS: [(Vec3, f32); 3] =
        [(Vec3::new(0.3, 0.2, -3.0), 0.05), (Vec3::new(0.5, 0.1, -2.5), 0.08), (Vec3::new(-0.9, 0.4, 0.9), 0.02)];

    /// Input of 64x48 pixels: three lamps, of which two overlap in the picture, before and behind the focus.
    fn input() -> RenderInput {
        let lamp = |(at, radius): (Vec3, f32)| {
            format!("object \"{radius}\" material=\"lamp\" {{ sphere {radius} {{ at {} {} {} }} }}\n", at.x, at.y, at.z)
        };
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 3; target 0 0 0; fov 45; lens radius=0.5 focus=3 }}\n\
             material \"lamp\" {{ emit 5 }}\n{}",
            LAMPS.map(lamp).concat()
        );
        let scene = Scene::parse("test.kdl", &text).expect("valid");
        RenderInput::new(&scene, &Settings { size: [64, 48], ..Settings::of(&scene) })
    }

    /// True if a ray hits one of the lamps.
    fn hits(ray: &Ray) -> bool {
        LAMPS.iter().any(|(centre, radius)| (*centre - ray.origin).cross(ray.direction).length() < *radius)
    }

    /// Grid of random numbers, `side` a dimension.
    fn numbers(side: u32) -> impl Iterator<Item = [f32; 2]> {
        let at = move |k: u32| (k as f32 + 0.5) / side as f32;
        (0..side * side).map(move |k| [at(k % side), at(k / side)])
    }

    #[test]
    fn weights_leave_the_light_as_it_is() {
        let input = input();
        let ctx = input.context(None);
        let targets = LensTargets::new(&ctx);
        assert_eq!(targets.0.len(), 3);
        let (mut lit, mut beside) = (0, 0);
        for pixel in (0..64 * 48).step_by(5) {
            let position = [(pixel % 64) as f32 + 0.3, (pixel / 64) as f32 + 0.8];
            let from_all = numbers(200).filter(|random| {
                let (origin, direction) = camera_ray(&input.frame, position, *random);
                hits(&Ray { origin: origin.into(), direction: direction.into() })
            });
            let expected = from_all.count() as f32 / 4e4;
            for count in [8, 15] {
                let seen = |index: u32| {
                    let ray = |random| targets.ray(&input.frame, position, random, FurtherRay { index, count });
                    numbers(40).map(ray).filter(|(ray, _)| hits(ray)).map(|(_, weight)| weight).sum::<f32>() / 1600.0
                };
                let mean = (0..count).map(seen).sum::<f32>() / count as f32;
                assert!((mean - expected).abs() < 0.1 * expected + 1e-3, "{position:?}: {mean}, from all {expected}");
            }
            (lit, beside) = (lit + u32::from(expected > 0.01), beside + u32::from(expected == 0.0));
        }
        assert!(lit > 20 && beside > 100, "{lit} pixels see lamps, {beside} none");
    }

    #[test]
    fn aimed_rays_have_little_noise() {
        let input = input();
        let targets = LensTargets::new(&input.context(None));
        // In the middle of the smallest lamp's disc.
        let position = targets.0[2].disc.centre.to_array();
        let means = numbers(8).map(|[u, v]| {
            let seen = |index: u32| {
                let random = [(u + 0.618 * index as f32).fract(), (v + 0.414 * index as f32).fract()];
                targets.ray(&input.frame, position, random, FurtherRay { index, count: 8 })
            };
            (0..8).map(seen).filter(|(ray, _)| hits(ray)).map(|(_, weight)| weight).sum::<f32>() / 8.0
        });
        let (least, most) = means.fold((f32::MAX, 0.0f32), |(least, most), mean| (least.min(mean), most.max(mean)));
        assert!(least > 0.0 && most < 1.5 * least, "{least} to {most}");
    }

    #[test]
    fn large_and_sharp_emitters_are_no_targets() {
        let frame = input().frame;
        assert!(is_target(&frame, Vec3::new(0.0, 0.0, -3.0), 0.1));
        assert!(!is_target(&frame, Vec3::new(0.0, 0.0, -3.0), 0.3), "it covers most of the lens");
        assert!(!is_target(&frame, Vec3::new(0.0, 0.0, 0.01), 0.02), "it is in focus");
        assert!(!is_target(&frame, Vec3::new(0.0, 0.0, 4.0), 0.02), "it is behind the camera");
    }
}
