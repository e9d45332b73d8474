//! What is at a place of the picture, for pointing at it; and how far the next surface is, for moving about.

use super::ViewScene;
use crate::integrator::camera::central_ray;
use crate::intersect::march::march;
use crate::intersect::ray::RaySegment;
use crate::sampling::r2_sequence::EQUAL_WEIGHTS;
use crate::settings::Settings;
use crate::shading::surface_interaction::interactions;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::Scene;

/// The surface that is seen at a place of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Index into [`Scene::objects`].
    pub object: usize,
    /// Index into the leaves of [`Scene::field`]; of blended ones the heaviest.
    pub leaf: usize,
    /// In the world, metres.
    pub position: [f32; 3],
    /// In the world, on the side towards the camera, of length one.
    pub normal: [f32; 3],
    /// Metres from the camera along the ray.
    pub distance: f32,
    /// Metres from the camera along its view axis: the focus distance at which it is sharp.
    pub depth: f32,
}

/// What the ray through the middle of the lens and this place meets; `pixel` is in pixels from the picture's top left corner,
/// so that the middle of the first pixel is at 0.5, 0.5. Of the settings, size and camera count. `None` where nothing is hit,
/// or where settings are out of range.
///
/// Cost: preparing the scene and one march on the CPU, well below a millisecond for what people write.
pub fn pick(scene: &Scene, settings: &Settings, pixel: [f32; 2]) -> Option<Picked> {
    settings.check(scene).ok()?;
    let view = ViewScene::new(scene, settings);
    let ctx = &view.context();
    let ray = central_ray(ctx.frame, pixel[0], pixel[1]);
    let rays = [RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }];
    let hit = march(ctx, &rays)[0]?;
    let seen = &interactions(ctx, &[(rays[0], hit)], |_, _| EQUAL_WEIGHTS)[0];
    let from_camera = seen.p - Vec3::from(ctx.frame.position);
    Some(Picked {
        object: ctx.scene.field.leaves()[seen.leaf].object as usize,
        leaf: seen.leaf,
        position: seen.p.into(),
        normal: seen.normal.into(),
        distance: from_camera.length(),
        depth: from_camera.dot(Vec3::from(ctx.frame.forward)),
    })
}

/// Metres from a point to the nearest surface of any object, from outside or inside; infinite in an empty scene. A lower
/// bound near shapes whose distance is one.
pub fn clearance(scene: &Scene, point: [f32; 3]) -> f32 {
    let [x, y, z] = point;
    scene.field.object_distances(FieldVec3::new(x, y, z)).map(f32::abs).fold(f32::INFINITY, f32::min)
}
