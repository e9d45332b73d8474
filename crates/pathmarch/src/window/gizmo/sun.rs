//! Handle of a sun: a map of all directions in the middle of the picture, on which the sun is dragged.
//!
//! **Idea.** A sun has a direction and no place. The map is the azimuthal equidistant projection of the sphere around the
//! camera's target: its centre is the direction towards the camera, the inner circle has the directions across the view, and
//! the rim is the direction away from the camera, for light from behind.

use super::transform::{present_value, round_to};
use crate::window::projection::Projection;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Vec2};
use glam::DVec3;
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Radius of the inner circle, points, and largest fraction of the picture's smaller side.
const RADIUS: (f32, f32) = (75.0, 0.22);
/// Radius of the sun that is drawn, and within which the pointer grabs it, points.
const SUN_RADIUS: f32 = 9.0;
/// Step of height and azimuth with Ctrl, radians.
const SNAP: f64 = PI / 36.0;
/// Segments of the horizon.
const SEGMENTS: u32 = 96;

/// The text's way to give a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// `direction` of a sun.
    Direction,
    /// `elevation` and `azimuth` of a `sky "day"`.
    Angles,
}

/// Keys of a day's sun.
const ELEVATION: &str = "elevation";
const AZIMUTH: &str = "azimuth";
const DIRECTION: &str = "direction";

/// Direction towards the sun of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    form: Form,
    pub(super) direction: DVec3,
}

impl Sun {
    /// The sun of a node: a `sun`, or a `sky "day"`.
    pub(super) fn of(document: &Document, path: &Path) -> Option<Self> {
        let number = |key: &str| match present_value(document, path, key) {
            Some(Value::Number(value)) => Some(f64::from(value).to_radians()),
            _ => None,
        };
        match document.item(path)?.kind {
            ItemKind::Sun => {
                let Some(Value::Triple(direction)) = present_value(document, path, DIRECTION) else { return None };
                let direction = DVec3::from_array(direction.map(f64::from)).try_normalize()?;
                Some(Self { form: Form::Direction, direction })
            }
            ItemKind::Sky => {
                let direction = from_angles(number(ELEVATION)?, number(AZIMUTH)?);
                Some(Self { form: Form::Angles, direction })
            }
            _ => None,
        }
    }

    /// Properties that give the sun this direction.
    pub(super) fn changes(self, path: &Path, direction: DVec3) -> Vec<(Path, &'static str, Value)> {
        match self.form {
            Form::Direction => {
                let direction = Value::Triple(direction.to_array().map(|v| round_to(v, 1e-3)));
                vec![(path.clone(), DIRECTION, direction)]
            }
            Form::Angles => {
                let (elevation, azimuth) = angles(direction);
                // The sky of a day is known down to the night.
                let elevation = round_to(elevation.to_degrees(), 0.1).clamp(-20.0, 90.0);
                let azimuth = round_to(azimuth.to_degrees().rem_euclid(360.0), 0.1);
                [(ELEVATION, elevation), (AZIMUTH, azimuth)]
                    .map(|(key, value)| (path.clone(), key, Value::Number(value)))
                    .to_vec()
            }
        }
    }
}

/// Height above the horizon, and azimuth clockwise from -z, radians.
fn angles(direction: DVec3) -> (f64, f64) {
    (direction.y.clamp(-1.0, 1.0).asin(), direction.x.atan2(-direction.z))
}

fn from_angles(elevation: f64, azimuth: f64) -> DVec3 {
    DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos())
}

/// The map of directions in the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyMap {
    middle: Pos2,
    radius: f32,
    right: DVec3,
    up: DVec3,
    to_camera: DVec3,
}

impl SkyMap {
    pub(super) fn new(projection: &Projection, picture: Rect) -> Self {
        let radius = RADIUS.0.min(RADIUS.1 * picture.width().min(picture.height())).max(1.0);
        let Projection { right, up, forward, .. } = *projection;
        Self { middle: picture.center(), radius, right, up, to_camera: -forward }
    }

    /// Point of a direction.
    pub(super) fn place(&self, direction: DVec3) -> Pos2 {
        let across = Vec2::new(direction.dot(self.right) as f32, -direction.dot(self.up) as f32);
        let angle = direction.dot(self.to_camera).clamp(-1.0, 1.0).acos();
        self.middle + across.normalized() * self.radius * (angle / FRAC_PI_2) as f32
    }

    /// Direction of a point; outside of the map that of the nearest one within. With `snapping`, height and azimuth are
    /// multiples of 5 degrees.
    pub(super) fn direction(&self, at: Pos2, snapping: bool) -> DVec3 {
        let from = at - self.middle;
        let angle = (f64::from(from.length() / self.radius) * FRAC_PI_2).min(PI);
        let across = from.normalized();
        let across = self.right * f64::from(across.x) - self.up * f64::from(across.y);
        let direction = (self.to_camera * angle.cos() + across * angle.sin()).normalize_or(self.to_camera);
        if !snapping {
            return direction;
        }
        let (elevation, azimuth) = angles(direction);
        from_angles((elevation / SNAP).round() * SNAP, (azimuth / SNAP).round() * SNAP)
    }

    /// True if the pointer is on the sun.
    pub(super) fn is_on(&self, direction: DVec3, at: Pos2) -> bool {
        self.place(direction).distance(at) <= SUN_RADIUS
    }

    /// Draws the map, its horizon, and the sun.
    pub(super) fn draw(&self, painter: &Painter, direction: DVec3, strong: bool) {
        let weak = Color32::WHITE.gamma_multiply(0.25);
        painter.circle_filled(self.middle, 2.0 * self.radius, Color32::from_black_alpha(60));
        for factor in [1.0, 2.0] {
            painter.circle_stroke(self.middle, factor * self.radius, Stroke::new(1.0, weak));
        }
        // The rim is one direction: the horizon leaves the map there and returns elsewhere.
        let horizon = |k: u32| self.place(from_angles(0.0, f64::from(k) / f64::from(SEGMENTS) * TAU));
        for k in 0..SEGMENTS {
            let (from, to) = (horizon(k), horizon(k + 1));
            if from.distance(to) < 0.5 * self.radius {
                painter
                    .line_segment([from, to], Stroke::new(1.5, Color32::from_rgb(120, 170, 255).gamma_multiply(0.6)));
            }
        }
        let (at, colour) = (self.place(direction), Color32::from_rgb(255, 200, 60));
        let colour = if strong { colour } else { colour.gamma_multiply(0.8) };
        painter.line_segment([self.middle, at], Stroke::new(1.5, colour.gamma_multiply(0.6)));
        painter.circle(at, SUN_RADIUS - 3.0, colour, Stroke::new(1.0, Color32::BLACK));
        for ray in 0..8 {
            let out = Vec2::angled(ray as f32 * std::f32::consts::FRAC_PI_4);
            let ends = [at + out * (SUN_RADIUS - 1.0), at + out * (SUN_RADIUS + 3.0)];
            painter.add(Shape::line_segment(ends, Stroke::new(1.5, colour)));
        }
        if strong {
            let (elevation, azimuth) = angles(direction);
            let azimuth = azimuth.to_degrees().rem_euclid(360.0);
            let words = format!("elevation {:.0}°, azimuth {azimuth:.0}°", elevation.to_degrees());
            let below = self.middle + Vec2::new(0.0, 2.0 * self.radius + 4.0);
            painter.text(below, Align2::CENTER_TOP, words, FontId::proportional(13.0), Color32::WHITE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> SkyMap {
        let camera = pathmarch_render::pathmarch_scene::parts::camera([3.0, 2.0, 5.0], [0.0, 0.5, 0.0]);
        let picture = Rect::from_min_max(Pos2::new(10.0, 20.0), Pos2::new(810.0, 620.0));
        SkyMap::new(&Projection::new(&camera, picture), picture)
    }

    #[test]
    fn a_place_on_the_map_gives_its_direction_back() {
        let map = map();
        for direction in [DVec3::Y, DVec3::X, DVec3::new(0.3, -0.5, 0.8), DVec3::new(-3.0, 0.4, -5.0), map.to_camera] {
            let direction = direction.normalize();
            let back = map.direction(map.place(direction), false);
            assert!(back.distance(direction) < 1e-5, "{direction} {back}");
        }
        // Light from behind is at the rim, and what is outside of the map is there, too.
        assert!(map.direction(map.middle + Vec2::new(500.0, 0.0), false).distance(-map.to_camera) < 1e-6);
        assert!(
            (map.place(-map.to_camera * 0.999 + map.up * 0.04).distance(map.middle) - 2.0 * map.radius).abs() < 8.0
        );
    }

    #[test]
    fn angles_are_those_of_a_day() {
        for (elevation, azimuth) in [(40.0_f64, 135.0_f64), (-10.0, 200.0), (5.0, -90.0)] {
            let direction = from_angles(elevation.to_radians(), azimuth.to_radians());
            let day = pathmarch_render::pathmarch_scene::Day {
                elevation: elevation as f32,
                azimuth: azimuth as f32,
                ..pathmarch_render::pathmarch_scene::Day::DEFAULT
            };
            assert!(direction.as_vec3().distance(day.direction().into()) < 1e-6);
            let (high, round) = angles(direction);
            assert!((high.to_degrees() - elevation).abs() < 1e-9);
            let turn = (round.to_degrees() - azimuth).rem_euclid(360.0);
            assert!(turn.min(360.0 - turn) < 1e-9);
        }
    }
}
