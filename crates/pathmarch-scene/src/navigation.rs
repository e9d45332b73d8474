//! Camera navigation: orbit, look, pan, dolly and fly.
//!
//! It changes a camera of the scene language, which can be written to the scene as it is. The horizon stays level up to
//! the poles of `up`.

use crate::scene::Camera;
use glam::{Quat, Vec3};

/// Minimum angle between view direction and `up`, radians.
const POLE: f32 = 0.02;
/// Fly speed: share of the distance to the nearest surface, per second.
const FLY_RATE: f32 = 1.2;

/// Unit vectors of a camera in world space.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// To the right of the picture.
    pub right: Vec3,
    /// To its top.
    pub up: Vec3,
    /// Into the picture.
    pub forward: Vec3,
}

/// Axes of a camera.
pub fn axes(camera: &Camera) -> Axes {
    let forward = (Vec3::from(camera.target) - Vec3::from(camera.position)).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(Vec3::from(camera.up)).normalize_or(Vec3::X);
    Axes { right, up: right.cross(forward), forward }
}

fn distance(camera: &Camera) -> f32 {
    Vec3::from(camera.position).distance(Vec3::from(camera.target)).max(1e-6)
}

/// Rotates a direction about the camera's up (`yaw`) and right (`pitch`) axes, radians; stops at the poles.
fn turned(camera: &Camera, direction: Vec3, yaw: f32, pitch: f32) -> Vec3 {
    let up = Vec3::from(camera.up).normalize_or(Vec3::Y);
    let height = direction.angle_between(up);
    let pitch = pitch.clamp(height - std::f32::consts::PI + POLE, height - POLE);
    let right = direction.cross(up).normalize_or(axes(camera).right);
    Quat::from_axis_angle(up, yaw) * Quat::from_axis_angle(right, pitch) * direction
}

/// Orbits about the target by radians left and up, as seen from it; zero angles change nothing, not even by rounding.
pub fn orbit(camera: &mut Camera, yaw: f32, pitch: f32) {
    if [yaw, pitch] == [0.0; 2] {
        return;
    }
    let away = distance(camera);
    let forward = turned(camera, axes(camera).forward, yaw, pitch);
    camera.position = (Vec3::from(camera.target) - forward * away).into();
}

/// Turns the view direction by radians left and up; the position stays. Zero angles change nothing, not even by rounding.
pub fn look(camera: &mut Camera, yaw: f32, pitch: f32) {
    if [yaw, pitch] == [0.0; 2] {
        return;
    }
    let away = distance(camera);
    let forward = turned(camera, axes(camera).forward, yaw, pitch);
    camera.target = (Vec3::from(camera.position) + forward * away).into();
}

/// Pans by a fraction of the picture's height.
pub fn pan(camera: &mut Camera, x: f32, y: f32) {
    let Axes { right, up, .. } = axes(camera);
    let height = 2.0 * (0.5 * camera.fov.to_radians()).tan() * distance(camera);
    shift(camera, (up * y - right * x) * height);
}

/// Scales the distance to the target; a factor of 1 changes nothing, not even by rounding.
pub fn dolly(camera: &mut Camera, factor: f32) {
    if factor == 1.0 {
        return;
    }
    let target = Vec3::from(camera.target);
    let away = (Vec3::from(camera.position) - target) * factor.clamp(0.05, 20.0);
    let away = away.clamp_length(1e-4, 1e6);
    camera.position = (target + away).into();
}

/// Moves position and target.
fn shift(camera: &mut Camera, by: Vec3) {
    let moved = |point: [f32; 3]| (Vec3::from(point) + by).clamp_length_max(1e7);
    (camera.position, camera.target) = (moved(camera.position).into(), moved(camera.target).into());
}

/// Flies for `seconds`. `towards`: right, up and forward, each -1 to 1. `clearance`: distance to the nearest surface,
/// which sets the speed, so that details are passed slowly and empty space is crossed fast.
pub fn fly(camera: &mut Camera, towards: Vec3, seconds: f32, clearance: f32) {
    let Axes { right, up, forward } = axes(camera);
    let speed = FLY_RATE * clearance.abs().clamp(0.02, 1000.0);
    shift(camera, (right * towards.x + up * towards.y + forward * towards.z).clamp_length_max(4.0) * speed * seconds);
}

/// Frames a sphere without changing the view direction.
pub fn frame(camera: &mut Camera, centre: Vec3, radius: f32) {
    let forward = axes(camera).forward;
    let away = radius.max(1e-3) / (0.5 * camera.fov.to_radians()).sin() * 1.15;
    camera.target = centre.into();
    camera.position = (centre - forward * away).into();
}

/// Turns towards a point without moving. Without an explicit focus distance, the focus follows the target.
pub fn look_at(camera: &mut Camera, point: Vec3) {
    let position = Vec3::from(camera.position);
    let direction = (point - position).normalize_or(axes(camera).forward);
    let up = Vec3::from(camera.up).normalize_or(Vec3::Y);
    if direction.cross(up).length() > POLE {
        camera.target = point.into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "main".to_owned(),
            position: [0.0, 1.0, 4.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov: 40.0,
            lens_radius: 0.0,
            focus: None,
            exposure: 0.0,
            auto_exposure: false,
        }
    }

    fn assert_near(a: [f32; 3], b: [f32; 3]) {
        assert!(Vec3::from(a).distance(Vec3::from(b)) < 1e-4, "{a:?} for {b:?}");
    }

    #[test]
    fn a_quarter_turn_ends_beside_the_target() {
        let mut turned = camera();
        orbit(&mut turned, std::f32::consts::FRAC_PI_2, 0.0);
        assert_near(turned.position, [4.0, 1.0, 0.0]);
        assert_near(turned.target, camera().target);
        let mut looked = camera();
        look(&mut looked, std::f32::consts::FRAC_PI_2, 0.0);
        assert_near(looked.position, camera().position);
        assert_near(looked.target, [-4.0, 1.0, 4.0]);
    }

    #[test]
    fn a_drag_that_stands_still_does_not_move_the_camera() {
        let mut turned = camera();
        for step in 0..200 {
            orbit(&mut turned, 0.1, 0.01);
            look(&mut turned, 0.02, 0.0);
            let before = turned.clone();
            orbit(&mut turned, 0.0, 0.0);
            look(&mut turned, 0.0, -0.0);
            pan(&mut turned, 0.0, 0.0);
            dolly(&mut turned, 1.0);
            fly(&mut turned, Vec3::ZERO, 0.1, 1.0);
            assert_eq!(turned, before, "after {step} steps");
        }
    }

    #[test]
    fn no_turn_passes_the_poles() {
        for pitch in [10.0, -10.0, 1.5, -1.5] {
            let mut turned = camera();
            for _ in 0..20 {
                orbit(&mut turned, 0.3, pitch);
                let axes = axes(&turned);
                assert!(axes.forward.cross(Vec3::Y).length() > 0.9 * POLE.sin(), "{axes:?}");
                assert!((distance(&turned) - 4.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_pan_by_the_height_of_the_picture_moves_all_of_it_out() {
        let mut panned = camera();
        pan(&mut panned, 0.0, 1.0);
        let height = 2.0 * (20_f32).to_radians().tan() * 4.0;
        assert_near(panned.position, [0.0, 1.0 + height, 4.0]);
        assert_near(panned.target, [0.0, 1.0 + height, 0.0]);
    }

    #[test]
    fn speed_follows_the_distance_to_surfaces() {
        let (mut near, mut far) = (camera(), camera());
        fly(&mut near, Vec3::Z, 0.1, 0.5);
        fly(&mut far, Vec3::Z, 0.1, 5.0);
        let went = |camera: &Camera| 4.0 - camera.position[2];
        assert!((went(&far) / went(&near) - 10.0).abs() < 1e-2);
        assert!(went(&near) > 0.0);
    }

    #[test]
    fn a_framed_ball_is_within_the_picture() {
        let mut framed = camera();
        frame(&mut framed, Vec3::new(3.0, 0.0, 0.0), 2.0);
        let away = distance(&framed);
        assert!((2.0 / away).asin() < 20_f32.to_radians());
        dolly(&mut framed, 0.5);
        assert!((distance(&framed) - 0.5 * away).abs() < 1e-3);
    }
}
