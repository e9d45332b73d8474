//! Picking: the surface at a position of the picture, for selection; and the distance to the nearest surface, for
//! navigation.

use super::ViewScene;
use crate::integrator::camera::central_ray;
use crate::intersect::march::march;
use crate::intersect::ray::RaySegment;
use crate::sampling::r2_sequence::EQUAL_WEIGHTS;
use crate::settings::Settings;
use crate::shading::surface_interaction::surface_interactions;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::Scene;

/// Surface at a position of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Index into [`Scene::objects`].
    pub object: usize,
    /// Index into the leaves of [`Scene::field`]; where leaves blend, the one with the largest weight; of copies, the one
    /// that the scene declares.
    pub leaf: usize,
    /// Position in world space, metres.
    pub position: [f32; 3],
    /// Unit normal in world space, on the side of the camera.
    pub normal: [f32; 3],
    /// Distance from the camera along the ray, metres.
    pub distance: f32,
    /// Distance from the camera along its view axis, metres: the focus distance at which the surface is sharp.
    pub depth: f32,
}

/// First hit of the ray through the centre of the lens and a position of the picture. `pixel` is in pixels from the top
/// left corner of the picture, so that the centre of the first pixel is at 0.5, 0.5. Of the settings, only size and
/// camera matter. `None` if the ray hits nothing, or if settings are out of range.
///
/// Cost: the preparation of the scene and one ray on the CPU, well below a millisecond for typical scenes.
pub fn pick(scene: &Scene, settings: &Settings, pixel: [f32; 2]) -> Option<Picked> {
    settings.check(scene).ok()?;
    let view = ViewScene::new(scene, settings);
    let ctx = &view.context();
    let ray = central_ray(ctx.frame, pixel[0], pixel[1]);
    let rays = [RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }];
    let hit = march(ctx, &rays)[0]?;
    let interaction = &surface_interactions(ctx, &[(rays[0], hit)], |_, _| EQUAL_WEIGHTS)[0];
    let from_camera = interaction.p - Vec3::from(ctx.frame.position);
    Some(Picked {
        object: ctx.scene.field.leaves()[interaction.leaf].object as usize,
        leaf: ctx.scene.field.declared_leaf(interaction.leaf),
        position: interaction.p.into(),
        normal: interaction.normal.into(),
        distance: from_camera.length(),
        depth: from_camera.dot(Vec3::from(ctx.frame.forward)),
    })
}

/// Distance from a point to the nearest surface of any object, from outside or inside, metres; infinite in an empty
/// scene. A lower bound near shapes whose distance is a lower bound.
pub fn clearance(scene: &Scene, point: [f32; 3]) -> f32 {
    let [x, y, z] = point;
    scene.field.object_distances(FieldVec3::new(x, y, z)).map(f32::abs).fold(f32::INFINITY, f32::min)
}
