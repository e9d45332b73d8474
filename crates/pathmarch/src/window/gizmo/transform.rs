//! Placements of nodes in the world, and back to what the text of the scene says.

use glam::{DQuat, DVec3, EulerRot};
use pathmarch_render::pathmarch_scene::document::{Document, Path, Value, key};

/// Placement of a node: uniform scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) scale: f64,
    pub(super) turn: DQuat,
    pub(super) at: DVec3,
}

impl Placed {
    /// At the origin, not turned, of its own size.
    pub(super) const IDENTITY: Self = Self { scale: 1.0, turn: DQuat::IDENTITY, at: DVec3::ZERO };

    /// World placement of `inner`, which is relative to this one.
    pub(super) fn around(self, inner: Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            turn: self.turn * inner.turn,
            at: self.at + self.turn * (self.scale * inner.at),
        }
    }

    /// Placement relative to this one of what has the placement `world` in the world.
    pub(super) fn inside(self, world: Self) -> Self {
        let back = self.turn.inverse();
        Self { scale: world.scale / self.scale, turn: back * world.turn, at: back * (world.at - self.at) / self.scale }
    }

    /// Degrees about the fixed x, then y, then z axis.
    pub(super) fn degrees(self) -> [f32; 3] {
        let (z, y, x) = self.turn.to_euler(EulerRot::ZYX);
        [x, y, z].map(|angle| tidy(angle.to_degrees(), 1e-3))
    }
}

/// Rounds to a multiple of `step`.
pub(super) fn tidy(value: f64, step: f64) -> f32 {
    let value = (value / step).round() * step;
    // Not -0, and not 0.30000000000000004.
    (value + 0.0) as f32
}

/// Present value of a key of a node.
pub(super) fn given(document: &Document, path: &Path, key: &str) -> Option<Value> {
    document.control(path, key).map(|control| control.present)
}

/// Placement that a node itself gives, relative to the operators around it.
pub(super) fn own_placement(document: &Document, path: &Path) -> Placed {
    let mut placed = Placed::IDENTITY;
    if let Some(Value::Triple(at)) = given(document, path, key::AT) {
        placed.at = at.map(f64::from).into();
    }
    if let Some(Value::Triple(turn)) = given(document, path, key::ROTATE) {
        let [x, y, z] = turn.map(|angle| f64::from(angle).to_radians());
        placed.turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
    }
    if let Some(Value::Number(scale)) = given(document, path, key::SCALE) {
        placed.scale = f64::from(scale);
    }
    placed
}

/// Placement of the operators around a node, from the outside in.
pub(super) fn placement_around(document: &Document, path: &Path) -> Placed {
    let mut ancestors = Vec::new();
    let mut at = path.parent();
    while let Some(path) = at {
        at = path.parent();
        ancestors.push(path);
    }
    ancestors.iter().rev().fold(Placed::IDENTITY, |outer, path| outer.around(own_placement(document, path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_through_an_operator_comes_back() {
        let outer = Placed {
            scale: 2.0,
            turn: DQuat::from_euler(EulerRot::ZYX, 0.3, -0.7, 1.1),
            at: DVec3::new(1.0, 2.0, 3.0),
        };
        let inner = Placed {
            scale: 0.5,
            turn: DQuat::from_euler(EulerRot::ZYX, -1.3, 0.2, 0.4),
            at: DVec3::new(-4.0, 0.0, 1.0),
        };
        let back = outer.inside(outer.around(inner));
        assert!(back.at.distance(inner.at) < 1e-12 && (back.scale - inner.scale).abs() < 1e-12);
        assert!(back.turn.dot(inner.turn).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn degrees_turn_about_fixed_axes() {
        let [x, y, z] = [20.0_f64, -35.0, 70.0].map(f64::to_radians);
        let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
        assert_eq!(Placed { turn, ..Placed::IDENTITY }.degrees(), [20.0, -35.0, 70.0]);
        assert_eq!(tidy(-1e-9, 1e-3).to_bits(), 0.0_f32.to_bits());
    }

    #[test]
    fn handles_are_where_the_field_is() {
        let text = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" {\n union {\n  at 1 2 3\n  \
                    rotate 10 20 30\n  scale 2\n  sphere 1 { at 0.5 0 0; rotate 0 90 0 }\n box 1 } }\n\
                    point { at 4 5 6; intensity 1 }";
        let document = Document::new("test.kdl", text);
        let scene = document.scene().expect("a scene");
        let path = document.path_of_leaf(0).expect("the sphere");
        let world = placement_around(&document, &path).around(own_placement(&document, &path));
        let leaf = &scene.field.leaves()[0];
        assert!(world.at.as_vec3().distance(leaf.pose.at.into()) < 1e-5, "{world:?} {leaf:?}");
        assert!((world.scale as f32 - leaf.pose.scale).abs() < 1e-6);
        for (axis, expected) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(leaf.pose.axes) {
            assert!((world.turn * axis).as_vec3().distance(expected.into()) < 1e-5);
        }
    }
}
