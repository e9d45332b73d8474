//! A scene and its settings in the form both backends read.

use crate::census::Counter;
use crate::mode::Mode;
use crate::settings::{LightSearch, Settings};
use crate::transport::lights::{self, LightRecord};
use crate::transport::march::RELAXATION;
use crate::transport::paint::{self, Paint};
use crate::transport::preview::Preview;
use crate::transport::sky::Sky;
use crate::transport::views;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pathmarch_field::graph::Leaf;
use pathmarch_field::{Aabb, Field};
use pathmarch_scene::materials::{self, Bsdf, BsdfParameters, albedo};
use pathmarch_scene::sky::GROUND_EDGE;
use pathmarch_scene::{Camera, Caustics, Material, Scene, Sky as Source};
use std::collections::HashMap;
use std::sync::Arc;

/// What every ray of a picture shares; the layout is that of `Frame` in `transport/frame.wgsl`.
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
    /// What the camera stands in absorbs, per metre.
    pub(crate) medium: [f32; 3],
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
    /// The largest contribution of light that bounced, W/(m² sr); 1e30 where none is set.
    pub(crate) clamp: f32,
    /// Lights that are suns; they come first.
    pub(crate) sun_count: u32,
    /// The number of the sampler.
    pub(crate) sampler: u32,
    /// Of the sky's picture, texels.
    pub(crate) sky_width: u32,
    /// Straight up, or everywhere, W/(m² sr).
    pub(crate) sky_zenith: [f32; 3],
    pub(crate) sky_height: u32,
    pub(crate) sky_horizon: [f32; 3],
    /// Density of a direction of the picture over the mean luminance of the texels around it.
    pub(crate) sky_density: f32,
    pub(crate) sky_ground: [f32; 3],
    /// Sine of the depth at which the ground has its own colour.
    pub(crate) sky_edge: f32,
    /// Of the picture's turn.
    pub(crate) sky_sine: f32,
    pub(crate) sky_cosine: f32,
    /// What a pixel covers at the end of a path of one metre, metres.
    pub(crate) pixel: f32,
    padding: u32,
}

/// What is known of a leaf of the field; the layout is that of `LeafRecord` in `transport/frame.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LeafRecord {
    /// Where a sheet faces, a unit vector.
    pub(crate) facing: [f32; 3],
    pub(crate) material: u32,
    /// Origin of its local coordinates.
    pub(crate) at: [f32; 3],
    /// [`SHEET`], [`DIRECT`] and [`IN_GLASS`], and from [`LIGHT_SHIFT`] on one more than the index of its light, or zero.
    pub(crate) flags: u32,
}

/// A surface without thickness, which emits on one side.
pub(crate) const SHEET: u32 = 1;
/// Rays meet it in closed form.
pub(crate) const DIRECT: u32 = 2;
/// Where the light's number starts in the flags.
pub(crate) const LIGHT_SHIFT: u32 = 3;
/// The leaf is in one solid with a material that transmits, so that paths come to it from inside.
pub(crate) const IN_GLASS: u32 = 4;

/// A material as both backends read it; the layout is that of `Material` in `transport/frame.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MaterialRecord {
    pub(crate) emission: [f32; 3],
    /// [`EMITS`], [`DELTA`], [`TRANSMITS`].
    pub(crate) flags: u32,
    /// What its inside absorbs, per metre.
    pub(crate) absorption: [f32; 3],
    /// Index into [`materials::kinds`].
    pub(crate) kind: u32,
    pub(crate) numbers: BsdfParameters,
}

/// Emits, and reflects nothing.
pub(crate) const EMITS: u32 = 1;
/// Scatters in single directions only: no light is sampled there.
pub(crate) const DELTA: u32 = 2;
/// Light passes to the other side.
pub(crate) const TRANSMITS: u32 = 4;
/// Clear glass, which shadow rays may pass.
pub(crate) const CLEAR: u32 = DELTA | TRANSMITS;

impl MaterialRecord {
    fn new(material: &Material, paint: &Paint) -> Self {
        let kind = materials::kinds().iter().position(|kind| std::ptr::eq(*kind, material.kind)).unwrap_or_default();
        let mut flags = EMITS * u32::from(material.emits());
        let mut numbers = BsdfParameters::default();
        if let Some(bsdf) = material.kind.bsdf {
            numbers = (bsdf.pack)(&material.values);
            let mut all = paint.extremes(&numbers);
            if all.is_empty() {
                all.push(numbers);
            }
            let flag = |flag: u32, set: bool| if set { flag } else { 0 };
            flags |= flag(DELTA, all.iter().all(bsdf.is_delta)) | flag(TRANSMITS, all.iter().any(bsdf.transmits));
        }
        Self { emission: material.emission(), flags, absorption: material.absorption(), kind: kind as u32, numbers }
    }
}

/// What clear glass of these numbers lets through straight on, at this cosine outside it.
pub(crate) fn passes_straight(numbers: &BsdfParameters, cosine: f32) -> Vec3 {
    let [r, g, b, _, ior, ..] = *numbers;
    Vec3::new(r, g, b) * (1.0 - materials::fresnel(cosine, ior))
}

/// What a scene needs of the estimator; on the GPU, constants of its kernel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Features {
    /// Some inside absorbs.
    pub(crate) absorption: bool,
    /// Some material transmits.
    pub(crate) transmission: bool,
    /// Some material draws a third random number.
    pub(crate) chooses_lobes: bool,
    /// Shadow rays pass clear glass.
    pub(crate) fast_caustics: bool,
    /// Some light's shadows are softened by near misses.
    pub(crate) penumbra: bool,
    /// Some material varies along surfaces.
    pub(crate) paint: bool,
    /// Some material's colour depends on a fractal's orbit.
    pub(crate) orbits: bool,
    /// Some material has a relief.
    pub(crate) bump: bool,
    /// How lights are found.
    pub(crate) light_search: LightSearch,
    /// How far steps go beyond the distance: [`RELAXATION`], or 0 where tests do without.
    pub(crate) relaxation: f32,
    /// Paths that share a ray of the camera.
    pub(crate) splitting: u32,
    /// Some sphere-traced object emits and none is a fractal: rays that graze a surface end closer to it, because the
    /// tolerance would make every lamp larger than it is.
    pub(crate) refined_grazing: bool,
}

/// Everything a backend needs to trace a picture.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub(crate) frame: Frame,
    pub(crate) features: Features,
    pub(crate) field: Field,
    pub(crate) leaves: Vec<LeafRecord>,
    pub(crate) materials: Vec<MaterialRecord>,
    /// How each material scatters.
    pub(crate) bsdfs: Vec<Option<&'static Bsdf>>,
    pub(crate) lights: Vec<LightRecord>,
    pub(crate) sky: Sky,
    /// Tables of numbers that the kernel reads.
    pub(crate) tables: Vec<u32>,
    /// Where the alias tables of the sky's picture start in the tables.
    pub(crate) sky_table: usize,
    /// Where the albedos of GGX surfaces start in the tables.
    pub(crate) ggx_table: usize,
    /// Where what varies of materials starts in the tables.
    pub(crate) paint_table: usize,
    /// What varies of each material.
    pub(crate) paints: Vec<Paint>,
    pub(crate) mode: Mode,
    /// Numbers of the mode, for those that are views.
    pub(crate) mode_numbers: Vec<f32>,
    /// What a preview needs.
    pub(crate) preview: Option<Preview>,
    /// Where the numbers of the mode or of the preview start in the tables.
    pub(crate) mode_table: usize,
    /// What counts evaluations on the CPU, if anything does.
    pub(crate) counter: Option<Arc<Counter>>,
}

/// About four times the rounding of an `f32` coordinate.
const ROUNDING: f32 = 4e-7;
/// More than any contribution that is kept.
const NO_CLAMP: f32 = 1e30;
/// Rays end this many scene sizes away; an endless plane ends there.
const FAR_SIZES: f32 = 2000.0;
/// Stands for infinity in the scene's box, so that no product with it is undefined.
const UNLIMITED: f32 = 1e18;

impl Frame {
    fn new(scene: &Scene, settings: &Settings, sky: &Sky, lights: &[LightRecord]) -> Self {
        let camera = settings.camera_of(scene);
        let bounds = scene.field.marched_bounds();
        let (centre, radius) = extent(scene, camera);
        let [width, height] = settings.size;
        let position = Vec3::from(camera.position);
        let forward = (Vec3::from(camera.target) - position).normalize();
        let half_height = (0.5 * camera.fov.to_radians()).tan();
        let right = forward.cross(Vec3::from(camera.up)).normalize();
        let up = right.cross(forward);
        let tolerance = settings.detail * 2.0 * half_height / height as f32;
        let margin = 0.01 * radius;
        // Where nothing is marched, a box of one point that no ray comes to.
        let bounds =
            if bounds.min[0] > bounds.max[0] { Aabb { min: [UNLIMITED; 3], max: [UNLIMITED; 3] } } else { bounds };
        let limited = |v: f32, margin: f32| (v + margin).clamp(-UNLIMITED, UNLIMITED);
        let [zenith, horizon, ground] = match scene.sky {
            Source::Constant(radiance) => [radiance; 3],
            Source::Gradient { zenith, horizon, ground } => [zenith, horizon, ground],
            Source::Map(_) => [[0.0; 3]; 3],
        };
        let (texels, turn) = match &scene.sky {
            Source::Map(picture) => ((picture.width, picture.height), picture.rotate.rem_euclid(360.0).to_radians()),
            _ => ((0, 0), 0.0),
        };
        Self {
            position: camera.position,
            // Modes without noise have nothing to spread rays over a lens by.
            lens_radius: if settings.mode.traces_paths() { camera.lens_radius } else { 0.0 },
            right: (right * half_height * width as f32 / height as f32).into(),
            focus: camera.focus.unwrap_or_else(|| position.distance(Vec3::from(camera.target))),
            up: (up * half_height).into(),
            tolerance,
            forward: forward.into(),
            rounding: ROUNDING,
            medium: medium_at(scene, camera.position),
            step_factor: 1.0 / scene.field.lipschitz(),
            bounds_min: bounds.min.map(|v| limited(v, -margin)),
            far: FAR_SIZES * (radius + position.distance(centre)),
            bounds_max: bounds.max.map(|v| limited(v, margin)),
            light_count: lights.len() as u32,
            width,
            height,
            bounces: settings.bounces,
            seed: settings.seed,
            clamp: settings.clamp.unwrap_or(NO_CLAMP),
            sun_count: lights.iter().filter(|light| light.is_sun()).count() as u32,
            sampler: settings.sampler as u32,
            sky_width: texels.0,
            sky_zenith: zenith,
            sky_height: texels.1,
            sky_horizon: horizon,
            sky_density: sky.density(),
            sky_ground: ground,
            sky_edge: GROUND_EDGE,
            sky_sine: turn.sin(),
            sky_cosine: turn.cos(),
            pixel: 2.0 * half_height / height as f32,
            padding: 0,
        }
    }
}

impl Prepared {
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let mut sky = Sky::new(scene);
        let (centre, radius) = extent(scene, settings.camera_of(scene));
        let lights = lights::records(scene, &mut sky, centre, radius);
        let frame = Frame::new(scene, settings, &sky, &lights);
        let light_of_leaf: HashMap<u32, u32> =
            (0..).zip(&lights).filter_map(|(index, light)| Some((light.emitting_leaf()?, index))).collect();
        let mut in_glass = vec![false; scene.objects.len()];
        for leaf in scene.field.leaves() {
            in_glass[leaf.object as usize] |= scene.materials[leaf.tag as usize].transmits();
        }
        let flags = |index: usize, sheet: bool| {
            let in_glass = IN_GLASS * u32::from(in_glass[scene.field.leaves()[index].object as usize]);
            let is_direct = scene.field.is_met_directly(index);
            let light = light_of_leaf.get(&(index as u32)).map_or(0, |light| light + 1);
            (SHEET * u32::from(sheet)) | (DIRECT * u32::from(is_direct)) | in_glass | (light << LIGHT_SHIFT)
        };
        let record = |(index, leaf): (usize, &Leaf)| LeafRecord {
            facing: leaf.pose.axes[1],
            material: leaf.tag,
            // A modifier holds it in a space of its own: there a sheet faces nowhere in the world.
            at: if leaf.modified { [0.0; 3] } else { leaf.pose.at },
            flags: flags(index, leaf.shape.info().sheet && !leaf.modified),
        };
        let leaves = scene.field.leaves().iter().enumerate().map(record).collect();
        let paints: Vec<Paint> = scene.materials.iter().map(Paint::new).collect();
        let materials: Vec<_> =
            scene.materials.iter().zip(&paints).map(|(material, paint)| MaterialRecord::new(material, paint)).collect();
        let bsdfs: Vec<_> = scene.materials.iter().map(|material| material.kind.bsdf).collect();
        let any = |flag: u32| materials.iter().any(|material| material.flags & flag != 0);
        let features = Features {
            absorption: materials.iter().any(|material| material.absorption != [0.0; 3]),
            transmission: any(TRANSMITS),
            chooses_lobes: bsdfs.iter().flatten().any(|bsdf| bsdf.chooses_lobes),
            fast_caustics: settings.caustics == Caustics::Fast && any(TRANSMITS),
            penumbra: lights.iter().any(|light| light.penumbra > 0.0),
            paint: paints.iter().any(|paint| !paint.is_plain()),
            orbits: paints.iter().any(Paint::has_orbit),
            bump: paints.iter().any(Paint::has_bump),
            light_search: settings.light_search,
            relaxation: RELAXATION,
            splitting: if settings.mode == Mode::Path { settings.splitting.unwrap_or(1) } else { 1 },
            refined_grazing: has_traced_emitter(&scene.field, &materials),
        };
        let mut tables: Vec<u32> = Vec::new();
        let sky_table = tables.len();
        tables.extend(sky.tables());
        let ggx_table = tables.len();
        if bsdfs.iter().flatten().any(|bsdf| bsdf.reads_albedos) {
            tables.extend(albedo::table().iter().flatten().map(|value| value.to_bits()));
        }
        let paint_table = tables.len();
        if features.paint {
            tables.extend(paint::words(&scene.field, &paints, paint_table));
        }
        let mode_table = tables.len();
        let mode_numbers = views::numbers(settings.mode, scene, settings.camera_of(scene), radius);
        tables.extend(mode_numbers.iter().map(|number| number.to_bits()));
        let mut prepared = Self {
            frame,
            features,
            field: scene.field.clone(),
            leaves,
            materials,
            bsdfs,
            lights,
            sky,
            tables,
            sky_table,
            ggx_table,
            paint_table,
            paints,
            mode: settings.mode,
            mode_numbers,
            preview: None,
            mode_table,
            counter: None,
        };
        if settings.mode == Mode::Preview {
            let preview = Preview::new(scene, &mut prepared);
            prepared.tables.extend(preview.words());
            prepared.preview = Some(preview);
        }
        prepared
    }

    /// Whether anything of the scene has no closed form.
    pub(crate) fn marches(&self) -> bool {
        !self.field.marched_bounds().is_empty()
    }

    /// The same scene with another camera, size, seed, number of bounces or limit; other settings stay as they were.
    /// False where more depends on the camera, so that everything must be prepared anew.
    pub(crate) fn reframe(&mut self, scene: &Scene, settings: &Settings) -> bool {
        let only_the_frame = limited_bounds(scene).is_finite() && settings.mode != Mode::Depth;
        if only_the_frame {
            self.frame = Frame::new(scene, settings, &self.sky, &self.lights);
        }
        only_the_frame
    }
}

/// Reports whether an object that is sphere-traced emits and no sphere-traced object is a fractal, whose surface is where
/// rays end.
fn has_traced_emitter(field: &Field, materials: &[MaterialRecord]) -> bool {
    let mut traced = field.leaves().iter().enumerate().filter(|(index, _)| !field.is_met_directly(*index));
    let emits = |leaf: &Leaf| materials[leaf.tag as usize].flags & EMITS != 0;
    traced.clone().any(|(_, leaf)| emits(leaf)) && traced.all(|(_, leaf)| !leaf.shape.has_orbit())
}

/// What the solids that hold the camera absorb together, per metre.
fn medium_at(scene: &Scene, p: [f32; 3]) -> [f32; 3] {
    let p = pathmarch_field::number::Vec3::new(p[0], p[1], p[2]);
    let holding = scene.objects.iter().zip(scene.field.object_distances(p)).filter(|(_, distance)| *distance < 0.0);
    let absorption = holding.map(|(object, _)| {
        let alone = Field::new(std::slice::from_ref(&object.root));
        let leaf = &alone.leaves()[alone.surface(p, 0).leaf as usize];
        Vec3::from(scene.materials[leaf.tag as usize].absorption())
    });
    absorption.fold(Vec3::ZERO, |sum, absorption| sum + absorption).into()
}

/// The box of what of the scene is limited.
fn limited_bounds(scene: &Scene) -> Aabb {
    let bounds = scene.field.object_bounds().iter().filter(|bounds| bounds.is_finite());
    bounds.fold(Aabb::NOTHING, |all, bounds| all.union(*bounds))
}

/// Middle and radius of what of the scene is limited; of the camera's view where nothing is.
fn extent(scene: &Scene, camera: &Camera) -> (Vec3, f32) {
    let limited = limited_bounds(scene);
    if limited.is_finite() {
        let (min, max) = (Vec3::from(limited.min), Vec3::from(limited.max));
        ((min + max) * 0.5, ((max - min).length() * 0.5).max(1e-6))
    } else {
        let (position, target) = (Vec3::from(camera.position), Vec3::from(camera.target));
        (target, position.distance(target))
    }
}
