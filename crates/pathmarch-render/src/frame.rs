//! A scene and its settings in the form both backends read.

use crate::settings::Settings;
use crate::transport::lights::{self, LightRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pathmarch_field::graph::Leaf;
use pathmarch_field::{Aabb, Field};
use pathmarch_scene::{Camera, Scene};
use std::collections::HashMap;

/// What every ray of a picture shares; the layout is that of `Frame` in `transport/path.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Frame {
    pub(crate) position: [f32; 3],
    pub(crate) lens_radius: f32,
    /// Half the picture's width at distance one, to the right.
    pub(crate) right: [f32; 3],
    /// Distance of what is sharp, metres along `forward`.
    pub(crate) focus: f32,
    /// Half the picture's height at distance one, upwards.
    pub(crate) up: [f32; 3],
    /// What is negligible, as a fraction of the path's length.
    pub(crate) tolerance: f32,
    /// Unit vector into the picture.
    pub(crate) forward: [f32; 3],
    /// What is negligible, as a fraction of a point's largest coordinate.
    pub(crate) rounding: f32,
    pub(crate) sky: [f32; 3],
    /// Share of the field's value that is safe to step: one over its Lipschitz constant.
    pub(crate) step_factor: f32,
    /// The box of what must be marched.
    pub(crate) bounds_min: [f32; 3],
    /// Where rays end at the latest, metres.
    pub(crate) far: f32,
    pub(crate) bounds_max: [f32; 3],
    pub(crate) light_count: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) bounces: u32,
    pub(crate) seed: u32,
    /// A [`Sampler`](crate::Sampler).
    pub(crate) sampler: u32,
    padding: [u32; 3],
}

/// What is known of a leaf of the field; the layout is that of `LeafRecord` in `transport/path.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LeafRecord {
    /// Where a sheet faces, a unit vector.
    pub(crate) facing: [f32; 3],
    pub(crate) material: u32,
    /// Origin of its local coordinates.
    pub(crate) at: [f32; 3],
    /// [`SHEET`] and [`DIRECT`], and from [`LIGHT_SHIFT`] on one more than the index of its light, or zero.
    pub(crate) flags: u32,
}

/// A surface without thickness, which emits on one side.
pub(crate) const SHEET: u32 = 1;
/// Rays meet it in closed form.
pub(crate) const DIRECT: u32 = 2;
/// Where the light's number starts in the flags.
pub(crate) const LIGHT_SHIFT: u32 = 2;

/// A material as both backends read it; the layout is that of `Material` in `transport/path.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MaterialRecord {
    pub(crate) albedo: [f32; 3],
    /// 1 for a surface that emits and reflects nothing.
    pub(crate) emits: u32,
    pub(crate) emission: [f32; 3],
    padding: u32,
}

/// Everything a backend needs to trace a picture.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub(crate) frame: Frame,
    pub(crate) field: Field,
    pub(crate) leaves: Vec<LeafRecord>,
    pub(crate) materials: Vec<MaterialRecord>,
    pub(crate) lights: Vec<LightRecord>,
}

/// What is negligible, in pixels: small against the half pixel by which an edge may be off unnoticed.
const TOLERANCE_PIXELS: f32 = 0.1;
/// About four times the rounding of an `f32` coordinate.
const ROUNDING: f32 = 4e-7;
/// Rays end this many scene sizes away; an endless plane ends there.
const FAR_SIZES: f32 = 2000.0;
/// Stands for infinity in the scene's box, so that no product with it is undefined.
const UNLIMITED: f32 = 1e18;

impl Prepared {
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let camera = &scene.cameras[settings.camera];
        let bounds = scene.field.marched_bounds();
        let (centre, radius) = extent(scene, camera);
        let [width, height] = settings.size;
        let position = Vec3::from(camera.position);
        let forward = (Vec3::from(camera.target) - position).normalize();
        let half_height = (0.5 * camera.fov.to_radians()).tan();
        let right = forward.cross(Vec3::from(camera.up)).normalize();
        let up = right.cross(forward);
        let tolerance = TOLERANCE_PIXELS * 2.0 * half_height / height as f32;
        let margin = 0.01 * radius;
        // Where nothing is marched, a box of one point that no ray comes to.
        let bounds =
            if bounds.min[0] > bounds.max[0] { Aabb { min: [UNLIMITED; 3], max: [UNLIMITED; 3] } } else { bounds };
        let limited = |v: f32, margin: f32| (v + margin).clamp(-UNLIMITED, UNLIMITED);
        let lights = lights::records(scene, centre, radius);
        let frame = Frame {
            position: camera.position,
            lens_radius: camera.lens_radius,
            right: (right * half_height * width as f32 / height as f32).into(),
            focus: camera.focus.unwrap_or_else(|| position.distance(Vec3::from(camera.target))),
            up: (up * half_height).into(),
            tolerance,
            forward: forward.into(),
            rounding: ROUNDING,
            sky: scene.sky,
            step_factor: 1.0 / scene.field.lipschitz(),
            bounds_min: bounds.min.map(|v| limited(v, -margin)),
            far: FAR_SIZES * (radius + position.distance(centre)),
            bounds_max: bounds.max.map(|v| limited(v, margin)),
            light_count: lights.len() as u32,
            width,
            height,
            bounces: settings.bounces,
            seed: settings.seed,
            sampler: settings.sampler as u32,
            padding: [0; 3],
        };
        let light_of_leaf: HashMap<u32, u32> =
            (0..).zip(&lights).filter_map(|(index, light)| Some((light.emitting_leaf()?, index))).collect();
        let direct: Vec<u32> = scene.field.direct_leaves().collect();
        let flags = |index: usize, sheet: bool| {
            let is_direct = direct.binary_search(&(index as u32)).is_ok();
            let light = light_of_leaf.get(&(index as u32)).map_or(0, |light| light + 1);
            (SHEET * u32::from(sheet)) | (DIRECT * u32::from(is_direct)) | (light << LIGHT_SHIFT)
        };
        let record = |(index, leaf): (usize, &Leaf)| LeafRecord {
            facing: leaf.axes[1],
            material: leaf.tag,
            at: leaf.at,
            flags: flags(index, leaf.shape.info().sheet),
        };
        let leaves = scene.field.leaves().iter().enumerate().map(record).collect();
        let materials = scene
            .materials
            .iter()
            .map(|material| MaterialRecord {
                albedo: material.albedo(),
                emits: u32::from(material.emits()),
                emission: material.emission(),
                padding: 0,
            })
            .collect();
        Self { frame, field: scene.field.clone(), leaves, materials, lights }
    }
}

/// Middle and radius of what of the scene is limited; of the camera's view where nothing is.
fn extent(scene: &Scene, camera: &Camera) -> (Vec3, f32) {
    let limited = scene
        .field
        .object_bounds()
        .iter()
        .filter(|bounds| bounds.is_finite())
        .fold(Aabb::NOTHING, |all, bounds| all.union(*bounds));
    if limited.is_finite() {
        let (min, max) = (Vec3::from(limited.min), Vec3::from(limited.max));
        ((min + max) * 0.5, ((max - min).length() * 0.5).max(1e-6))
    } else {
        let (position, target) = (Vec3::from(camera.position), Vec3::from(camera.target));
        (target, position.distance(target))
    }
}
