//! Motion of rigid objects between two scenes: the last pose of each leaf against the present one.
//!
//! Leaves below modifiers, and what mirrors show of moving objects, count as still; their pixels go on only where the
//! point is on the surface of the last picture by chance, and start anew elsewhere.

use crate::integrator::guides::{Guide, NO_LEAF};
use crate::scene::RenderScene;
use crate::wgsl::shared_struct;
use glam::{Mat3, Vec3};
use pathmarch_field::graph::{Leaf, Pose};

/// Poses of the leaves of a scene; `None` below modifiers.
pub(super) struct Poses(Vec<Option<Pose>>);

/// Map from present positions in the world to earlier ones.
#[derive(Clone, Copy)]
struct Displacement {
    rotation: Mat3,
    scale: f32,
    offset: Vec3,
}

shared_struct! {
    /// Object of a leaf, and its motion since an earlier scene: the rows of its rotation, its scale and its offset.
    pub(super) struct LeafMotion as LeafMotion {
        x: [f32; 3],
        offset_x: f32,
        y: [f32; 3],
        offset_y: f32,
        z: [f32; 3],
        offset_z: f32,
        scale: f32,
        /// Not 0 if the leaf has moved.
        moves: u32,
        /// Index of the object.
        object: u32,
        padding: u32,
    }
}

/// Motion since an earlier scene; `None` for leaves that stand still.
#[derive(Default)]
pub(super) struct Motion(Vec<Option<Displacement>>);

impl Poses {
    pub(super) fn new(scene: &RenderScene) -> Self {
        Self(scene.field.leaves().iter().map(|leaf| (!leaf.modified).then_some(leaf.pose)).collect())
    }
}

impl Motion {
    /// Motion between two scenes. Without the same number of leaves in both, nothing moves.
    pub(super) fn new(earlier: &Poses, present: &Poses) -> Self {
        if earlier.0.len() != present.0.len() {
            return Self::default();
        }
        let of = |(earlier, present): (&Option<Pose>, &Option<Pose>)| {
            let (earlier, present) = ((*earlier)?, (*present)?);
            let is_still = (earlier.at, earlier.axes, earlier.scale) == (present.at, present.axes, present.scale);
            let world_from_local = |pose: &Pose| Mat3::from_cols_array_2d(&pose.axes);
            let rotation = world_from_local(&earlier) * world_from_local(&present).transpose();
            let scale = earlier.scale / present.scale;
            let offset = Vec3::from(earlier.at) - rotation * Vec3::from(present.at) * scale;
            (!is_still).then_some(Displacement { rotation, scale, offset })
        };
        Self(earlier.0.iter().zip(&present.0).map(of).collect())
    }

    /// Records of all leaves of the present scene.
    pub(super) fn records(&self, scene: &RenderScene) -> Vec<LeafMotion> {
        let record = |(index, leaf): (usize, &Leaf)| {
            let moved = self.0.get(index).copied().flatten();
            let Displacement { rotation, scale, offset } =
                moved.unwrap_or(Displacement { rotation: Mat3::IDENTITY, scale: 1.0, offset: Vec3::ZERO });
            let row = |k: usize| rotation.row(k).into();
            let (moves, object) = (u32::from(moved.is_some()), leaf.object);
            let [x, y, z] = [row(0), row(1), row(2)];
            let Vec3 { x: offset_x, y: offset_y, z: offset_z } = offset;
            LeafMotion { x, offset_x, y, offset_y, z, offset_z, scale, moves, object, padding: 0 }
        };
        scene.field.leaves().iter().enumerate().map(record).collect()
    }

    /// Position and normal of the point of a guide in the earlier scene.
    #[inline]
    pub(super) fn earlier(&self, guide: &Guide) -> (Vec3, Vec3) {
        let &Guide { position, normal, leaf, .. } = guide;
        match self.0.get(leaf as usize) {
            Some(Some(Displacement { rotation, scale, offset })) if leaf != NO_LEAF => {
                (*rotation * position * *scale + *offset, *rotation * normal)
            }
            _ => (position, normal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_scene::Scene;

    fn poses(placement: &str) -> Poses {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 1 5; target 0 0 0 }}\nsky 1\nobject \"floor\" {{ plane }}\n\
             object \"box\" {{ box 1 2 3 {{ {placement} }} }}"
        );
        let scene = Scene::parse("test.kdl", &text).expect("a scene");
        Poses::new(&RenderScene::new(&scene, &scene.cameras[0]))
    }

    #[test]
    fn points_of_a_moved_object_are_found_where_they_were() {
        let motion = Motion::new(&poses("at 1 2 3; scale 2"), &poses("at -1 0 4; rotate 0 90 0"));
        // A corner of the box: (0.5, 1, 1.5) in its own coordinates.
        let present = Vec3::new(-1.0 + 1.5, 1.0, 4.0 - 0.5);
        let guide = Guide { position: present, normal: Vec3::X, leaf: 1, ..Guide::NONE };
        let (position, normal) = motion.earlier(&guide);
        assert!((position - Vec3::new(2.0, 4.0, 6.0)).length() < 1e-5, "{position}");
        assert!((normal - Vec3::Z).length() < 1e-6, "{normal}");
        // The floor stands still, and so does what mirrors show.
        for leaf in [0, NO_LEAF] {
            let guide = Guide { leaf, ..guide };
            assert_eq!(motion.earlier(&guide), (guide.position, guide.normal));
        }
    }

    #[test]
    fn nothing_moves_between_different_structures() {
        let motion = Motion::new(&Poses(Vec::new()), &poses("at 1 2 3"));
        let guide = Guide { position: Vec3::ONE, leaf: 1, ..Guide::NONE };
        assert_eq!(motion.earlier(&guide), (guide.position, guide.normal));
    }
}
