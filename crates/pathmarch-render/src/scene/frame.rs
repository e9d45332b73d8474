//! Uniforms of a frame: camera, picture size and limits, shared by all rays of the picture.

use super::medium::{Medium, medium_at};
use super::{Extent, RenderScene};
use crate::settings::Settings;
use crate::wgsl::shared_struct;
use glam::Vec3;
use pathmarch_field::Aabb;
use pathmarch_scene::sky::GROUND_EDGE;
use pathmarch_scene::{Scene, Sky};

shared_struct! {
    /// Uniforms of a frame.
    pub(crate) struct FrameUniforms as Frame {
        /// Centre of the lens in world space, metres.
        pub(crate) position: [f32; 3],
        /// Radius of the lens, metres; 0 for a pinhole.
        pub(crate) lens_radius: f32,
        /// Vector to the right in world space; its length is half the width of the picture at distance one.
        pub(crate) right: [f32; 3],
        /// Focus distance along `forward`, metres.
        pub(crate) focus: f32,
        /// Vector upwards in world space; its length is half the height of the picture at distance one.
        pub(crate) up: [f32; 3],
        /// Hit tolerance divided by the length of the path.
        pub(crate) tolerance: f32,
        /// Unit view direction in world space.
        pub(crate) forward: [f32; 3],
        /// Rounding error of a point divided by its largest coordinate.
        pub(crate) rounding: f32,
        /// Absorption coefficient of the solids around the camera, per metre.
        pub(crate) medium: [f32; 3],
        /// Safe step divided by the value of the field: the inverse of its Lipschitz constant.
        pub(crate) step_factor: f32,
        /// Bounds of all sphere-traced objects in world space, metres.
        pub(crate) bounds_min: [f32; 3],
        /// Largest distance along a ray, metres.
        pub(crate) far: f32,
        pub(crate) bounds_max: [f32; 3],
        pub(crate) light_count: u32,
        /// Size of the picture, pixels.
        pub(crate) width: u32,
        pub(crate) height: u32,
        /// Largest number of scattering events after the first hit.
        pub(crate) bounces: u32,
        pub(crate) seed: u32,
        /// Largest contribution of indirect light, W/(m² sr); 1e30 without a limit.
        pub(crate) clamp: f32,
        /// Number of suns; they are the first lights.
        pub(crate) sun_count: u32,
        /// Index of the sampler, see [`pathmarch_scene::Sampler`].
        pub(crate) sampler: u32,
        /// Size of the environment map, texels.
        pub(crate) sky_width: u32,
        /// Radiance of the zenith, or of a constant sky, W/(m² sr).
        pub(crate) sky_zenith: [f32; 3],
        pub(crate) sky_height: u32,
        /// Radiance at the horizon, W/(m² sr).
        pub(crate) sky_horizon: [f32; 3],
        /// Pdf of a direction of the environment map divided by the mean luminance of the four texels around it.
        pub(crate) sky_pdf_scale: f32,
        /// Radiance of the ground, W/(m² sr).
        pub(crate) sky_ground: [f32; 3],
        /// Sine of the depression angle at which the gradient reaches the colour of the ground.
        pub(crate) sky_edge: f32,
        /// Sine and cosine of the environment map's rotation.
        pub(crate) sky_sine: f32,
        pub(crate) sky_cosine: f32,
        /// Side of a pixel at distance one, metres.
        pub(crate) pixel: f32,
        /// Bits of the steps of the preview, see [`crate::preview_steps`].
        pub(crate) preview_steps: u32,
        /// Number of lights that are not in the light tree; its lights follow them.
        pub(crate) table_lights: u32,
        /// Probability of choosing a light of the light tree.
        pub(crate) tree_share: f32,
        pub(crate) padding: [u32; 2],
        /// Scattering coefficient of the solids around the camera, per metre.
        pub(crate) medium_scattering: [f32; 3],
        /// See [`Medium::forward`](super::Medium::forward), of the same solids.
        pub(crate) medium_forward: f32,
        /// Radiance that the same solids emit, W/(m³ sr).
        pub(crate) medium_emission: [f32; 3],
        /// See [`Medium::solids`](super::Medium::solids).
        pub(crate) medium_solids: u32,
        /// See [`Medium::around`](super::Medium::around).
        pub(crate) medium_around: [u32; 4],
    }
}

/// About four times the relative rounding error of an `f32` coordinate.
const ROUNDING: f32 = 4e-7;
/// Larger than any contribution that the film accepts.
pub(crate) const NO_CLAMP: f32 = 1e30;
/// Largest distance along a ray, in radii of the scene. Infinite planes are cut off there.
const FAR_RADII: f32 = 2000.0;
/// Finite substitute for infinity in the bounds: its product with zero is defined.
const UNLIMITED: f32 = 1e18;

impl FrameUniforms {
    pub(crate) fn new(scene: &Scene, settings: &Settings, tables: &RenderScene) -> Self {
        let RenderScene { sky, lights, light_tree, .. } = tables;
        let camera = settings.camera_of(scene);
        let bounds = scene.field.sphere_traced_bounds();
        let Extent { centre, radius } = Extent::new(scene, camera);
        let [width, height] = settings.size;
        let position = Vec3::from(camera.position);
        let forward = (Vec3::from(camera.target) - position).normalize();
        let half_height = (0.5 * camera.fov.to_radians()).tan();
        let right = forward.cross(Vec3::from(camera.up)).normalize();
        let up = right.cross(forward);
        let tolerance = settings.detail * 2.0 * half_height / height as f32;
        let margin = 0.01 * radius;
        // Without sphere-traced objects, the bounds are one point beyond the reach of every ray.
        let bounds =
            if bounds.min[0] > bounds.max[0] { Aabb { min: [UNLIMITED; 3], max: [UNLIMITED; 3] } } else { bounds };
        let with_margin = |v: f32, margin: f32| (v + margin).clamp(-UNLIMITED, UNLIMITED);
        let [zenith, horizon, ground] = match scene.sky {
            Sky::Constant(radiance) => [radiance; 3],
            Sky::Gradient { zenith, horizon, ground } => [zenith, horizon, ground],
            Sky::Map(_) => [[0.0; 3]; 3],
        };
        let (map_size, rotation) = match &scene.sky {
            Sky::Map(picture) => ((picture.width, picture.height), picture.rotate.rem_euclid(360.0).to_radians()),
            _ => ((0, 0), 0.0),
        };
        let medium = medium_at(scene, tables, camera.position);
        Self {
            position: camera.position,
            // Modes without noise use a pinhole: they have no random numbers for the lens.
            lens_radius: if settings.mode.traces_paths() { camera.lens_radius } else { 0.0 },
            right: (right * half_height * width as f32 / height as f32).into(),
            focus: camera.focus.unwrap_or_else(|| position.distance(Vec3::from(camera.target))),
            up: (up * half_height).into(),
            tolerance,
            forward: forward.into(),
            rounding: ROUNDING,
            medium: medium.absorption.into(),
            step_factor: 1.0 / scene.field.lipschitz(),
            bounds_min: bounds.min.map(|v| with_margin(v, -margin)),
            far: FAR_RADII * (radius + position.distance(centre)),
            bounds_max: bounds.max.map(|v| with_margin(v, margin)),
            light_count: lights.len() as u32,
            width,
            height,
            bounces: settings.bounces,
            seed: settings.seed,
            clamp: settings.clamp.unwrap_or(NO_CLAMP),
            sun_count: lights.iter().filter(|light| light.shape.is_sun()).count() as u32,
            sampler: settings.sampler as u32,
            sky_width: map_size.0,
            sky_zenith: zenith,
            sky_height: map_size.1,
            sky_horizon: horizon,
            sky_pdf_scale: sky.pdf_scale(),
            sky_ground: ground,
            sky_edge: GROUND_EDGE,
            sky_sine: rotation.sin(),
            sky_cosine: rotation.cos(),
            pixel: 2.0 * half_height / height as f32,
            preview_steps: settings.preview_steps.bits(),
            table_lights: light_tree.as_ref().map_or(lights.len(), |tree| tree.first) as u32,
            tree_share: light_tree.as_ref().map_or(0.0, |tree| tree.share),
            padding: [0; 2],
            medium_scattering: medium.scattering.into(),
            medium_forward: medium.forward,
            medium_emission: medium.emission.into(),
            medium_solids: medium.solids,
            medium_around: medium.around,
        }
    }

    /// Media of the solids around the camera.
    pub(crate) fn camera_medium(&self) -> Medium {
        Medium {
            absorption: self.medium.into(),
            scattering: self.medium_scattering.into(),
            forward: self.medium_forward,
            emission: self.medium_emission.into(),
            solids: self.medium_solids,
            around: self.medium_around,
        }
    }

    /// Size of the picture, pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }
}
