//! Lights that can be sampled: points, suns, emitting objects and environment maps.

use super::Extent;
use super::light_tree::{LightBounds, LightTree, NormalCone};
use super::mesh_light::MeshLight;
use crate::sampling::alias_table;
use crate::wgsl::shared_constants;
use glam::{DVec3, Vec3};
use pathmarch_field::{Emitter, Field};
use pathmarch_scene::light::spot_cosines;
use pathmarch_scene::{Light as SceneLight, Scene};
use std::f32::consts::PI;

/// Light and the probability of choosing it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    pub(crate) shape: LightShape,
    /// Position in the order of the scene: suns, points, emitting objects, the environment.
    pub(crate) declaration: u32,
    /// Probability of choosing the light by the table of all lights.
    pub(crate) pmf: f32,
    /// One over `pmf`.
    pub(crate) inverse_pmf: f32,
    /// Alias table: the cell of this light chooses it if the remapped random number is below this.
    pub(crate) threshold: f32,
    /// Alias table: index of the light that the cell chooses otherwise.
    pub(crate) alias: u32,
}

/// Position, size and emission of a light, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightShape {
    Point(PointLight),
    Sun(SunLight),
    /// Ball.
    Sphere(SphereLight),
    /// Rectangle that emits on one side.
    Rect(SheetLight),
    /// Disc that emits on one side.
    Disc(SheetLight),
    Box(BoxLight),
    /// Any other emitting object, sampled by its bounding sphere.
    Bounded(SphereLight),
    /// Triangles of a mesh.
    Triangles(TrianglesLight),
    /// Environment map.
    Environment,
    Spot(SpotLight),
}

/// Point light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointLight {
    pub(crate) position: Vec3,
    /// Radiant intensity, W/sr.
    pub(crate) radiant_intensity: Vec3,
    /// Sharpness of shadows from near misses; 0 for exact shadows.
    pub(crate) penumbra: f32,
}

/// Point light in a cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotLight {
    /// Point light with the intensity on the axis.
    pub(crate) point: PointLight,
    /// Unit vector of the axis, away from the light.
    pub(crate) axis: Vec3,
    /// Cosine of the angle from the axis at which the light ends.
    pub(crate) cos_outer: f32,
    /// One over the difference of cosines between the ends of the falloff.
    pub(crate) inverse_falloff: f32,
}

impl SpotLight {
    /// Radiant intensity in a direction away from the light, a unit vector, W/sr: a smoothstep of its cosine to the axis (Pharr,
    /// Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section 12.2.1).
    #[inline]
    pub(crate) fn radiant_intensity_towards(&self, direction: Vec3) -> Vec3 {
        let t = ((direction.dot(self.axis) - self.cos_outer) * self.inverse_falloff).clamp(0.0, 1.0);
        self.point.radiant_intensity * (t * t * (3.0 - 2.0 * t))
    }
}

/// Light from a disc at infinity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SunLight {
    /// Unit vector towards the sun.
    pub(crate) direction: Vec3,
    /// Irradiance on a surface that faces the sun, W/m².
    pub(crate) irradiance: Vec3,
    /// 1 - cosine of the angular radius.
    pub(crate) one_minus_cos: f32,
    /// Sharpness of shadows from near misses; 0 for exact shadows.
    pub(crate) penumbra: f32,
}

/// Emitting ball, or bounding sphere of an emitting object.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SphereLight {
    pub(crate) centre: Vec3,
    /// Radius, metres.
    pub(crate) radius: f32,
    /// Emitted radiance, W/(m² sr).
    pub(crate) radiance: Vec3,
    /// Leaf of the field.
    pub(crate) leaf: u32,
}

/// Emitting triangles of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglesLight {
    /// Bounding sphere, with the mean radiance.
    pub(crate) bounds: SphereLight,
    /// Index among the [mesh lights](super::RenderScene::mesh_lights).
    pub(crate) mesh: usize,
    /// Normals of the emitting sides.
    pub(super) normals: NormalCone,
    /// Area, square metres.
    pub(crate) area: f32,
    /// Index among the [tables of parts](super::RenderScene::mesh_parts), if it is a part of a mesh.
    pub(crate) parts: Option<usize>,
}

/// Emitting rectangle or disc, a sheet without thickness.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SheetLight {
    pub(crate) centre: Vec3,
    /// Half edges of a rectangle, metres; unit axes of a disc.
    pub(crate) axes: [Vec3; 2],
    /// Unit normal of the emitting side.
    pub(crate) normal: Vec3,
    /// Area, square metres.
    pub(crate) area: f32,
    /// Emitted radiance, W/(m² sr).
    pub(crate) radiance: Vec3,
    /// Radius of a disc, metres; 0 for a rectangle.
    pub(crate) radius: f32,
    /// Leaf of the field.
    pub(crate) leaf: u32,
}

/// Emitting box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxLight {
    pub(crate) centre: Vec3,
    /// Half edges, metres.
    pub(crate) axes: [Vec3; 3],
    /// Emitted radiance, W/(m² sr).
    pub(crate) radiance: Vec3,
    /// Leaf of the field.
    pub(crate) leaf: u32,
}

impl Light {
    /// Emitting leaf of the field, for a light that is an object.
    pub(crate) fn leaf(&self) -> Option<u32> {
        self.shape.leaf()
    }
}

impl LightShape {
    /// Emitting leaf of the field, for a light that is an object.
    pub(crate) fn leaf(&self) -> Option<u32> {
        match self {
            Self::Sphere(light) | Self::Bounded(light) => Some(light.leaf),
            Self::Rect(light) | Self::Disc(light) => Some(light.leaf),
            Self::Box(light) => Some(light.leaf),
            Self::Triangles(light) => Some(light.bounds.leaf),
            Self::Point(_) | Self::Spot(_) | Self::Sun(_) | Self::Environment => None,
        }
    }

    /// Number of kinds of lights.
    pub(crate) const KINDS: usize = 10;

    /// Index of the kind, below [`KINDS`](Self::KINDS).
    pub(crate) fn kind(&self) -> u32 {
        match self {
            Self::Point(_) => 0,
            Self::Sun(_) => 1,
            Self::Sphere(_) => 2,
            Self::Rect(_) => 3,
            Self::Disc(_) => 4,
            Self::Box(_) => 5,
            Self::Bounded(_) => 6,
            Self::Environment => 7,
            Self::Triangles(_) => 8,
            Self::Spot(_) => 9,
        }
    }

    /// Centre and radius around which light that media scatter is concentrated, metres; `None` for lights at infinity.
    #[inline]
    pub(crate) fn extent(&self) -> Option<(Vec3, f32)> {
        match self {
            Self::Point(light) | Self::Spot(SpotLight { point: light, .. }) => Some((light.position, 0.0)),
            Self::Sphere(light) | Self::Bounded(light) => Some((light.centre, light.radius)),
            Self::Triangles(light) => Some((light.bounds.centre, light.bounds.radius)),
            Self::Rect(light) | Self::Disc(light) => Some((light.centre, RADIUS_OF_AREA * light.area.sqrt())),
            Self::Box(light) => {
                let [x, y, z] = light.axes.map(Vec3::length_squared);
                Some((light.centre, (x + y + z).sqrt()))
            }
            Self::Sun(_) | Self::Environment => None,
        }
    }

    /// Leaf that the shadow ray must hit, for a light that it may miss.
    #[inline]
    pub(crate) fn target(&self) -> Option<u32> {
        if let Self::Bounded(sphere) = self { Some(sphere.leaf) } else { None }
    }

    #[inline]
    pub(crate) fn is_sun(&self) -> bool {
        matches!(self, Self::Sun(_))
    }

    /// Sharpness of shadows from near misses; 0 for exact shadows.
    #[inline]
    pub(crate) fn penumbra(&self) -> f32 {
        match self {
            Self::Point(light) | Self::Spot(SpotLight { point: light, .. }) => light.penumbra,
            Self::Sun(light) => light.penumbra,
            _ => 0.0,
        }
    }

    /// Approximate irradiance at the centre of the scene, W/m². Zero for the environment.
    fn irradiance(&self, extent: &Extent) -> Vec3 {
        let falloff =
            |position: Vec3| position.distance_squared(extent.centre).max(extent.radius * extent.radius).max(1e-12);
        match (self, self.bounds()) {
            (Self::Sun(light), _) => light.irradiance,
            (_, Some(bounds)) => bounds.intensity / falloff(bounds.centre),
            (_, None) => Vec3::ZERO,
        }
    }

    /// Centre and radius of a sphere around an emitting object, in world space, metres; `None` for other lights.
    pub(crate) fn emitting_bounds(&self) -> Option<(Vec3, f32)> {
        let bounds = self.bounds().filter(|_| self.leaf().is_some());
        bounds.map(|bounds| (bounds.centre, bounds.radius))
    }

    /// Bounds of a light with a position, with its intensity in W/sr; `None` for suns and the environment.
    fn bounds(&self) -> Option<LightBounds> {
        let everywhere =
            |centre, radius, intensity| LightBounds { centre, radius, normals: NormalCone::ALL, intensity };
        let sheet = |light: &SheetLight, radius| LightBounds {
            centre: light.centre,
            radius,
            normals: NormalCone::of(light.normal),
            intensity: light.radiance * light.area,
        };
        Some(match self {
            Self::Point(light) => everywhere(light.position, 0.0, light.radiant_intensity),
            // It emits into the hemisphere around its axis, as a surface does.
            Self::Spot(SpotLight { point, axis, .. }) => LightBounds {
                normals: NormalCone::of(*axis),
                ..everywhere(point.position, 0.0, point.radiant_intensity)
            },
            Self::Sphere(light) | Self::Bounded(light) => {
                let cross_section = PI * light.radius * light.radius;
                everywhere(light.centre, light.radius, light.radiance * cross_section)
            }
            Self::Rect(light) => sheet(light, light.axes[0].length().hypot(light.axes[1].length())),
            Self::Disc(light) => sheet(light, light.radius),
            Self::Box(light) => {
                let [a, b, c] = light.axes.map(Vec3::length);
                let cross_section = 2.0 * (a * b + b * c + c * a);
                let radius = Vec3::new(a, b, c).length();
                everywhere(light.centre, radius, light.radiance * cross_section)
            }
            // Half of the surface or less is seen from a point.
            Self::Triangles(light) => LightBounds {
                normals: light.normals,
                ..everywhere(light.bounds.centre, light.bounds.radius, light.bounds.radiance * (0.5 * light.area))
            },
            Self::Sun(_) | Self::Environment => return None,
        })
    }
}

shared_constants! {
    /// Radius of a disc of area 1.
    const RADIUS_OF_AREA: f32 = 0.564_189_6;
}

/// Weights of the channels of a linear Rec. 709 colour in its luminance.
pub(crate) const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance of a linear Rec. 709 colour.
#[inline]
pub(crate) fn luminance([r, g, b]: [f32; 3]) -> f32 {
    let [wr, wg, wb] = LUMINANCE_WEIGHTS;
    wr * r + wg * g + wb * b
}

/// 1 - cosine of half an apparent diameter in degrees, without cancellation.
fn one_minus_cosine(diameter_degrees: f32) -> f32 {
    let half = 0.25 * diameter_degrees.to_radians();
    2.0 * half.sin() * half.sin()
}

/// Strength of colours, by which lights are chosen.
///
/// The noise of a channel by the choice of a light is Σ E²/p, where E is what a light contributes to this channel and p its
/// probability. Relative to the squares of the channels' sums S, the mean over the channels is least for p in proportion to the
/// root of Σ (E/S)². Luminance would rarely choose a blue lamp, whose light is half of a purple room.
struct ColourScale {
    /// One over the sum of each channel.
    inverse: Vec3,
}

impl ColourScale {
    fn new(lights: &[LightShape], sky_power: f32, extent: &Extent) -> Self {
        let sum: DVec3 = lights.iter().map(|light| light.irradiance(extent).as_dvec3()).sum();
        let sums = sum.as_vec3() + sky_power;
        // A channel with hardly any light counts for less.
        let least = (MIN_CHANNEL_SHARE * sums.max_element()).max(f32::MIN_POSITIVE);
        Self { inverse: sums.max(Vec3::splat(least)).recip() }
    }

    /// Colour relative to these sums; its length is its strength.
    fn relative(&self, colour: Vec3) -> Vec3 {
        colour * self.inverse
    }
}

/// Smallest light of a channel in the choice of lights, as a share of that of the strongest one.
const MIN_CHANNEL_SHARE: f32 = 0.1;

/// Number of lights with a position from which a tree pays: with three, a sample in a closed room has a quarter less
/// variance but takes a quarter longer.
const MIN_TREE_LIGHTS: usize = 4;

/// Lights of a scene, and the ways to choose one.
pub(super) struct SceneLights {
    /// Lights with power above zero: suns, then the others in the order of the scene. With a tree, its lights come last, in
    /// the order of its leaves.
    pub(super) lights: Vec<Light>,
    /// Meshes and parts of meshes among them.
    pub(super) meshes: Vec<MeshLight>,
    /// For each mesh of several parts, the light of each of its triangles.
    pub(super) mesh_parts: Vec<Vec<u32>>,
    /// Tree over the lights with a position, if there are [`MIN_TREE_LIGHTS`] or more.
    pub(super) tree: Option<LightTree>,
}

/// Lights of a scene. `sky_power` is the mean irradiance of the environment map, W/m². A tree is built only if `by_place`.
pub(super) fn lights(scene: &Scene, sky_power: f32, extent: &Extent, by_place: bool) -> SceneLights {
    let declared = scene.lights.iter().map(declared_light);
    let leaves = scene.field.leaves().iter().enumerate();
    let mut meshes = Vec::new();
    let mut mesh_parts = Vec::new();
    let emitters = leaves.flat_map(|(index, leaf)| {
        let material = &scene.materials[leaf.tag as usize];
        let radiance = Vec3::from(material.emission());
        if !material.emits() {
            return Vec::new();
        }
        let mesh = MeshLight::new(&scene.field, index);
        // Only BSDF sampling finds an emission that varies over anything but triangles.
        if mesh.is_none() && material.emission_texture.is_some() {
            return Vec::new();
        }
        match (leaf_light(&scene.field, index, radiance), mesh) {
            (Some(LightShape::Bounded(bounds)), Some(mesh)) => mesh_lights(mesh, &bounds, &mut meshes, &mut mesh_parts),
            (shape, _) => shape.into_iter().collect(),
        }
    });
    let shapes: Vec<LightShape> = declared.chain(emitters).collect();
    let scale = ColourScale::new(&shapes, sky_power, extent);
    let mut weighted: Vec<(LightShape, f32)> =
        shapes.into_iter().map(|shape| (shape, scale.relative(shape.irradiance(extent)).length())).collect();
    weighted.push((LightShape::Environment, scale.relative(Vec3::splat(sky_power)).length()));
    weighted.retain(|(_, weight)| *weight > 0.0);
    // Suns come first: every ray that leaves the scene tests all of them.
    weighted.sort_by_key(|(shape, _)| !shape.is_sun());
    let weights: Vec<f64> = weighted.iter().map(|(_, weight)| f64::from(*weight)).collect();
    let total: f64 = weights.iter().sum();
    let light = |(declaration, (shape, weight)): (u32, (LightShape, f32))| Light {
        shape,
        declaration,
        pmf: (f64::from(weight) / total) as f32,
        inverse_pmf: (total / f64::from(weight)) as f32,
        threshold: 1.0,
        alias: 0,
    };
    let mut lights: Vec<Light> = (0..).zip(weighted).map(light).collect();
    let weight_of = |light: &Light| weights[light.declaration as usize];
    let relative = |bounds: LightBounds| LightBounds { intensity: scale.relative(bounds.intensity), ..bounds };
    let bounds: Vec<LightBounds> = lights.iter().filter_map(|light| light.shape.bounds().map(relative)).collect();
    let mut tree = None;
    let mut in_tree = Vec::new();
    if by_place && bounds.len() >= MIN_TREE_LIGHTS {
        let (placed, others): (Vec<Light>, _) = lights.into_iter().partition(|light| light.shape.extent().is_some());
        let share = placed.iter().map(weight_of).sum::<f64>() / total;
        let (built, order) = LightTree::new(&bounds, others.len(), share as f32);
        in_tree = order.iter().map(|&index| placed[index as usize]).collect();
        tree = Some(built);
        lights = others;
    }
    // The table chooses the lights that are not in the tree.
    let table = alias_table::table(&lights.iter().map(weight_of).collect::<Vec<_>>());
    for (light, cell) in lights.iter_mut().zip(table) {
        (light.threshold, light.alias) = cell;
    }
    lights.extend(in_tree);
    for (index, light) in (0..).zip(&lights) {
        if let LightShape::Triangles(TrianglesLight { mesh, parts: Some(parts), .. }) = light.shape {
            meshes[mesh].triangles.iter().for_each(|&triangle| mesh_parts[parts][triangle as usize] = index);
        }
    }
    SceneLights { lights, meshes, mesh_parts, tree }
}

/// Lights of the parts of a mesh within these bounds, which are added to `meshes`, and the table of several parts to `mesh_parts`.
fn mesh_lights(
    mesh: MeshLight,
    bounds: &SphereLight,
    meshes: &mut Vec<MeshLight>,
    mesh_parts: &mut Vec<Vec<u32>>,
) -> Vec<LightShape> {
    let triangles = mesh.mesh_triangles();
    let parts = mesh.parts();
    let table = (parts.len() > 1).then_some(mesh_parts.len());
    mesh_parts.extend(table.map(|_| vec![NO_LIGHT; triangles]));
    let light = |part: MeshLight| {
        let (centre, radius) = if table.is_some() { part.bounds() } else { (bounds.centre, bounds.radius) };
        let bounds = SphereLight { centre, radius, ..*bounds };
        let (normals, area) = (part.normals(), part.area);
        meshes.push(part);
        LightShape::Triangles(TrianglesLight { bounds, mesh: meshes.len() - 1, normals, area, parts: table })
    };
    parts.into_iter().map(light).collect()
}

/// Light of a triangle that does not emit.
pub(crate) const NO_LIGHT: u32 = u32::MAX;

/// Smallest difference of cosines over which the light of a spot falls off; a hard edge has it.
const MIN_FALLOFF: f32 = 1e-6;

/// Light that the scene file declares.
fn declared_light(light: &SceneLight) -> LightShape {
    match *light {
        SceneLight::Point { at, intensity, penumbra } => LightShape::Point(PointLight {
            position: at.into(),
            radiant_intensity: intensity.into(),
            penumbra: penumbra.unwrap_or(0.0),
        }),
        SceneLight::Spot { at, direction, intensity, cone, blend, penumbra } => {
            let [cos_outer, cos_inner] = spot_cosines(cone, blend);
            LightShape::Spot(SpotLight {
                point: PointLight {
                    position: at.into(),
                    radiant_intensity: intensity.into(),
                    penumbra: penumbra.unwrap_or(0.0),
                },
                axis: Vec3::from(direction).normalize_or(Vec3::NEG_Y),
                cos_outer,
                inverse_falloff: 1.0 / (cos_inner - cos_outer).max(MIN_FALLOFF),
            })
        }
        SceneLight::Sun { direction, irradiance, angle, penumbra } => LightShape::Sun(SunLight {
            direction: Vec3::from(direction).normalize_or(Vec3::Y),
            irradiance: irradiance.into(),
            // Near misses replace the size of the disc.
            one_minus_cos: if penumbra.is_some() { 0.0 } else { one_minus_cosine(angle) },
            penumbra: penumbra.unwrap_or(0.0),
        }),
    }
}

/// Light of an emitting leaf; `None` if the leaf is infinite.
fn leaf_light(field: &Field, index: usize, radiance: Vec3) -> Option<LightShape> {
    let source = &field.leaves()[index];
    let (centre, leaf, scale) = (Vec3::from(source.pose.at), index as u32, source.pose.scale);
    let units = source.pose.axes.map(Vec3::from);
    let [x, y, z] = units.map(|axis| axis * (0.5 * scale));
    // A combined shape may lack parts of its surface, so its bounding sphere is sampled.
    let emitter = if field.is_analytic_object(index) { source.shape.emitter(&source.params) } else { Emitter::Bounded };
    let normal = units[1];
    Some(match emitter {
        Emitter::Sphere(radius) => LightShape::Sphere(SphereLight { centre, radius: radius * scale, radiance, leaf }),
        Emitter::Rect([a, b]) => {
            let axes = [x * a, z * b];
            let area = 4.0 * axes[0].length() * axes[1].length();
            LightShape::Rect(SheetLight { centre, axes, normal, radius: 0.0, area, radiance, leaf })
        }
        Emitter::Disc(radius) => {
            let radius = radius * scale;
            let (axes, area) = ([units[0], units[2]], PI * radius * radius);
            LightShape::Disc(SheetLight { centre, axes, normal, radius, area, radiance, leaf })
        }
        Emitter::Box([a, b, c]) => LightShape::Box(BoxLight { centre, axes: [x * a, y * b, z * c], radiance, leaf }),
        Emitter::Bounded => {
            let bounds = field.leaf_bounds(index);
            if !bounds.is_finite() {
                return None;
            }
            let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
            // Only BSDF sampling hits the parts of blends beyond this sphere.
            let radius = 0.5 * (max - min).length() * 1.001;
            LightShape::Bounded(SphereLight { centre: (min + max) * 0.5, radius, radiance, leaf })
        }
    })
}
