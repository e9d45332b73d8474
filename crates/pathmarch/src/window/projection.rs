//! Projection of world space to window points, and back to rays.

use egui::{Pos2, Rect, Vec2};
use glam::DVec3;
use pathmarch_render::pathmarch_scene::Camera;
use pathmarch_render::pathmarch_scene::navigation::{Axes, axes};

/// Near plane, metres.
const NEAR: f64 = 1e-4;

/// Perspective projection of a camera onto a rectangle of the window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// Position of the camera in world space, metres.
    pub(crate) position: DVec3,
    /// Unit vectors of the camera in world space.
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
    /// Window points per metre of height at a depth of 1 m.
    pub(crate) scale: f64,
    middle: Pos2,
}

/// A world-space ray from the camera through a window point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: DVec3,
    /// Not normalised: its component along the camera's axis is 1, so that the ray parameter is the depth.
    pub(crate) direction: DVec3,
}

impl Projection {
    pub(crate) fn new(camera: &Camera, picture: Rect) -> Self {
        let Axes { right, up, forward } = axes(camera);
        Self {
            position: DVec3::from_array(camera.position.map(f64::from)),
            right: right.as_dvec3(),
            up: up.as_dvec3(),
            forward: forward.as_dvec3(),
            scale: 0.5 * f64::from(picture.height()) / (0.5 * f64::from(camera.fov).to_radians()).tan(),
            middle: picture.center(),
        }
    }

    /// Depth of a point along the camera's axis, metres; `None` behind the near plane.
    pub(crate) fn depth(&self, point: DVec3) -> Option<f64> {
        let depth = (point - self.position).dot(self.forward);
        (depth > NEAR).then_some(depth)
    }

    /// Projects a world-space point to a window point; `None` behind the near plane.
    pub(crate) fn project(&self, point: DVec3) -> Option<Pos2> {
        let scale = self.scale / self.depth(point)?;
        let from = point - self.position;
        let offset = Vec2::new((from.dot(self.right) * scale) as f32, (-from.dot(self.up) * scale) as f32);
        offset.is_finite().then(|| self.middle + offset)
    }

    /// Ray through a window point.
    pub(crate) fn ray_through(&self, at: Pos2) -> Ray {
        let [x, y] = [at.x - self.middle.x, self.middle.y - at.y].map(|side| f64::from(side) / self.scale);
        Ray { origin: self.position, direction: self.forward + self.right * x + self.up * y }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_a_projected_point_hits_it() {
        let camera = Camera {
            name: "main".to_owned(),
            position: [3.0, 2.0, -1.0],
            target: [0.0, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            fov: 50.0,
            lens_radius: 0.0,
            focus: None,
            exposure: 0.0,
            auto_exposure: false,
        };
        let picture = Rect::from_min_max(Pos2::new(20.0, 10.0), Pos2::new(660.0, 370.0));
        let projection = Projection::new(&camera, picture);
        let target = DVec3::new(0.0, 0.5, 0.0);
        assert!(projection.project(target).expect("before it").distance(picture.center()) < 1e-3);
        let point = DVec3::new(-0.4, 1.1, 0.7);
        let ray = projection.ray_through(projection.project(point).expect("before it"));
        let depth = projection.depth(point).expect("before it");
        assert!((ray.origin + ray.direction * depth).distance(point) < 1e-5);
        // Half the field of view above the centre is the upper edge.
        let height = (25_f64).to_radians().tan() * depth;
        let edge = projection.position + projection.forward * depth + projection.up * height;
        assert!((projection.project(edge).expect("before it").y - picture.min.y).abs() < 1e-3);
        let behind = projection.position - projection.forward;
        assert_eq!((projection.project(behind), projection.project(projection.position)), (None, None));
    }
}
