//! Transforms of nodes: from the scene text to world space, and back.

use glam::{DQuat, DVec3, EulerRot};
use pathmarch_render::pathmarch_scene::document::{Document, Path, Value, key};

/// Transform of a node: uniform scale, then rotation, then translation (metres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    pub(super) scale: f64,
    pub(super) rotation: DQuat,
    pub(super) translation: DVec3,
}

impl Transform {
    /// The identity.
    pub(super) const IDENTITY: Self = Self { scale: 1.0, rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// World transform of `inner`, which is relative to this one.
    pub(super) fn then_local(self, inner: Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.translation + self.rotation * (self.scale * inner.translation),
        }
    }

    /// Transform relative to this one of a node with world transform `world`.
    pub(super) fn to_local(self, world: Self) -> Self {
        let back = self.rotation.inverse();
        Self {
            scale: world.scale / self.scale,
            rotation: back * world.rotation,
            translation: back * (world.translation - self.translation) / self.scale,
        }
    }

    /// Rotation as degrees about the fixed x, then y, then z axis.
    pub(super) fn degrees(self) -> [f32; 3] {
        let (z, y, x) = self.rotation.to_euler(EulerRot::ZYX);
        [x, y, z].map(|angle| round_to(angle.to_degrees(), 1e-3))
    }
}

/// Rounds to a multiple of `step`.
pub(super) fn round_to(value: f64, step: f64) -> f32 {
    let value = (value / step).round() * step;
    // Avoids -0 and 0.30000000000000004.
    (value + 0.0) as f32
}

/// Present value of a property.
pub(super) fn present_value(document: &Document, path: &Path, key: &str) -> Option<Value> {
    document.control(path, key).map(|control| control.present)
}

/// Present value of a property that is a number.
pub(super) fn present_number(document: &Document, path: &Path, key: &str) -> Option<f64> {
    match present_value(document, path, key) {
        Some(Value::Number(value)) => Some(f64::from(value)),
        _ => None,
    }
}

/// Transform that the node itself gives, relative to its parent.
pub(super) fn local_transform(document: &Document, path: &Path) -> Transform {
    let mut transform = Transform::IDENTITY;
    if let Some(Value::Triple(at)) = present_value(document, path, key::AT) {
        transform.translation = at.map(f64::from).into();
    }
    if let Some(Value::Triple(turn)) = present_value(document, path, key::ROTATE) {
        let [x, y, z] = turn.map(|angle| f64::from(angle).to_radians());
        transform.rotation = DQuat::from_euler(EulerRot::ZYX, z, y, x);
    }
    if let Some(scale) = present_number(document, path, key::SCALE) {
        transform.scale = scale;
    }
    transform
}

/// Combined transform of all ancestors.
pub(super) fn parent_transform(document: &Document, path: &Path) -> Transform {
    let mut ancestors = Vec::new();
    let mut at = path.parent();
    while let Some(path) = at {
        at = path.parent();
        ancestors.push(path);
    }
    ancestors.iter().rev().fold(Transform::IDENTITY, |outer, path| outer.then_local(local_transform(document, path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn world_and_local_transforms_are_inverse() {
        let outer = Transform {
            scale: 2.0,
            rotation: DQuat::from_euler(EulerRot::ZYX, 0.3, -0.7, 1.1),
            translation: DVec3::new(1.0, 2.0, 3.0),
        };
        let inner = Transform {
            scale: 0.5,
            rotation: DQuat::from_euler(EulerRot::ZYX, -1.3, 0.2, 0.4),
            translation: DVec3::new(-4.0, 0.0, 1.0),
        };
        let back = outer.to_local(outer.then_local(inner));
        assert!(back.translation.distance(inner.translation) < 1e-12 && (back.scale - inner.scale).abs() < 1e-12);
        assert!(back.rotation.dot(inner.rotation).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn degrees_turn_about_fixed_axes() {
        let [x, y, z] = [20.0_f64, -35.0, 70.0].map(f64::to_radians);
        let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
        assert_eq!(Transform { rotation: turn, ..Transform::IDENTITY }.degrees(), [20.0, -35.0, 70.0]);
        assert_eq!(round_to(-1e-9, 1e-3).to_bits(), 0.0_f32.to_bits());
    }

    #[test]
    fn handles_are_where_the_field_is() {
        let text = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" {\n union {\n  at 1 2 3\n  \
                    rotate 10 20 30\n  scale 2\n  sphere 1 { at 0.5 0 0; rotate 0 90 0 }\n box 1 } }\n\
                    point { at 4 5 6; intensity 1 }";
        let document = Document::new("test.kdl", text);
        let scene = document.scene().expect("a scene");
        let path = document.path_of_leaf(0).expect("the sphere");
        let world = parent_transform(&document, &path).then_local(local_transform(&document, &path));
        let leaf = &scene.field.leaves()[0];
        assert!(world.translation.as_vec3().distance(leaf.pose.at.into()) < 1e-5, "{world:?} {leaf:?}");
        assert!((world.scale as f32 - leaf.pose.scale).abs() < 1e-6);
        for (axis, expected) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(leaf.pose.axes) {
            assert!((world.rotation * axis).as_vec3().distance(expected.into()) < 1e-5);
        }
    }
}
