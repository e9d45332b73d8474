//! Render scene: flat tables for the integrators, on the CPU, shared and immutable.
//!
//! [`RenderScene`] does not depend on the size or the settings of the picture. [`FrameUniforms`] change with the
//! camera. [`KernelConfig`] lists the features of the estimator that the scene uses. Each backend encodes the tables
//! for its memory.

mod context;
pub(crate) mod frame;
pub(crate) mod kernel_config;
pub(crate) mod leaf;
pub(crate) mod light;
pub(crate) mod light_tree;
pub(crate) mod material;
pub(crate) mod medium;
pub(crate) mod mesh_light;
pub(crate) mod nested_dielectrics;
pub(crate) mod photon_map;
pub(crate) mod preview_material;
pub(crate) mod sky;
pub(crate) mod textured_material;

pub(crate) use context::TraceContext;
pub(crate) use frame::FrameUniforms;
pub(crate) use kernel_config::KernelConfig;
pub(crate) use leaf::LeafRecord;
pub(crate) use light::{Light, LightShape};
pub(crate) use light_tree::{LightNode, LightTree};
pub(crate) use material::MaterialRecord;
pub(crate) use medium::{Media, Medium};
pub(crate) use mesh_light::MeshLight;
pub(crate) use photon_map::PhotonMap;
pub(crate) use sky::SkyLight;
pub(crate) use textured_material::TexturedMaterial;

use glam::Vec3;
use light::{SceneLights, SpotLight, TrianglesLight};
use material::TRANSMITS;
use pathmarch_field::{Aabb, Field};
use pathmarch_scene::materials::{Bsdf, BsdfParameters, KindInLanes};
use pathmarch_scene::{Camera, Material, Scene};

/// This flag where the condition holds, else 0.
fn flag_if(flag: u32, condition: bool) -> u32 {
    if condition { flag } else { 0 }
}

/// Tables of a scene.
#[derive(Clone, Debug)]
pub(crate) struct RenderScene {
    pub(crate) field: Field,
    pub(crate) leaves: Vec<LeafRecord>,
    pub(crate) materials: Vec<MaterialRecord>,
    /// Base colour of each material, see [`base_colour`].
    pub(crate) base_colours: Vec<[f32; 3]>,
    /// BSDF of each material; `None` for emitters.
    pub(crate) bsdfs: Vec<Option<&'static Bsdf>>,
    /// Kinds of the materials whose scattering functions exist in lanes.
    pub(crate) kinds_in_lanes: Vec<Option<KindInLanes>>,
    /// Textures, bump map and orbit trap of each material.
    pub(crate) textured_materials: Vec<TexturedMaterial>,
    /// Lights that can be sampled, suns first. The lights of the tree come last.
    pub(crate) lights: Vec<Light>,
    /// Choice among the lights with a position; `None` if there are few.
    pub(crate) light_tree: Option<LightTree>,
    /// Triangles of lights that are meshes.
    pub(crate) mesh_lights: Vec<MeshLight>,
    /// For each mesh of several lights, the light of each of its triangles, or [`NO_LIGHT`](light::NO_LIGHT).
    pub(crate) mesh_parts: Vec<Vec<u32>>,
    pub(crate) sky: SkyLight,
    pub(crate) media: Media,
}

impl RenderScene {
    /// Builds the tables of a scene. The camera sets the extent of a scene without finite objects.
    pub(crate) fn new(scene: &Scene, camera: &Camera) -> Self {
        Self::choosing_lights(scene, camera, true)
    }

    /// Tables of a scene that choose lights by place, or by one table for all places.
    pub(crate) fn choosing_lights(scene: &Scene, camera: &Camera, by_place: bool) -> Self {
        let mut sky = SkyLight::new(scene);
        let extent = Extent::new(scene, camera);
        let media = Media::new(scene);
        let SceneLights { lights, meshes, mesh_parts, tree } =
            light::lights(scene, sky.sampled_power(), &extent, by_place);
        let environment = lights.iter().find(|light| matches!(light.shape, LightShape::Environment));
        if let Some(environment) = environment {
            sky.set_probability(environment.pmf);
        }
        let textured_materials: Vec<_> = scene.materials.iter().map(TexturedMaterial::new).collect();
        let materials = scene.materials.iter().zip(&textured_materials);
        let materials: Vec<MaterialRecord> =
            materials.map(|(material, textured)| MaterialRecord::new(material, textured)).collect();
        let bsdfs: Vec<Option<&'static Bsdf>> = scene.materials.iter().map(|material| material.kind.bsdf).collect();
        let kind_in_lanes = |(record, bsdf): (&MaterialRecord, &Option<&'static Bsdf>)| {
            (*bsdf)?.in_lanes.filter(|_| !record.has(TRANSMITS))
        };
        Self {
            field: scene.field.clone(),
            leaves: leaf::records(scene, &lights),
            kinds_in_lanes: materials.iter().zip(&bsdfs).map(kind_in_lanes).collect(),
            materials,
            base_colours: scene.materials.iter().map(base_colour).collect(),
            bsdfs,
            textured_materials,
            lights,
            light_tree: tree,
            mesh_lights: meshes,
            mesh_parts,
            sky,
            media,
        }
    }

    /// Light of a leaf, or of its `triangle` if a ray has hit one.
    pub(crate) fn light_of(&self, leaf: usize, triangle: Option<u32>) -> Option<usize> {
        let any = self.leaves[leaf].light()?;
        let LightShape::Triangles(TrianglesLight { parts: Some(parts), .. }) = self.lights[any].shape else {
            return Some(any);
        };
        let light = triangle.map_or(any as u32, |triangle| self.mesh_parts[parts][triangle as usize]);
        (light != light::NO_LIGHT).then_some(light as usize)
    }

    /// Reports whether any object is sphere-traced.
    pub(crate) fn is_sphere_traced(&self) -> bool {
        !self.field.sphere_traced_bounds().is_empty()
    }

    /// Reports whether a property is true of the BSDF and the parameters of some material.
    pub(crate) fn any_bsdf(&self, property: fn(&Bsdf) -> fn(&BsdfParameters) -> bool) -> bool {
        let mut bsdfs = self.bsdfs.iter().zip(&self.materials);
        bsdfs.any(|(bsdf, material)| bsdf.is_some_and(|bsdf| property(bsdf)(&material.parameters)))
    }

    /// Material of a leaf.
    #[inline]
    pub(crate) fn material_of(&self, leaf: usize) -> &MaterialRecord {
        &self.materials[self.leaves[leaf].material as usize]
    }

    /// Reports whether a leaf emits on the side of this normal: sheets emit on one side only.
    #[inline]
    pub(crate) fn emits_towards(&self, leaf: usize, normal: Vec3) -> bool {
        let leaf = &self.leaves[leaf];
        !leaf.has(leaf::SHEET) || normal.dot(Vec3::from(leaf.facing)) > 0.0
    }

    /// Reports whether all objects with a transmissive surface are finite.
    fn has_bounded_media(&self) -> bool {
        let mut leaves = self.field.leaves().iter().zip(&self.leaves).filter(|(_, record)| record.has(leaf::IN_GLASS));
        leaves.all(|(leaf, _)| self.field.object_bounds()[leaf.object as usize].is_finite())
    }

    /// Reports whether some solid that transmits has a priority other than the default.
    pub(crate) fn has_nested_dielectrics(&self) -> bool {
        let mut dielectrics = self.materials.iter().zip(&self.media.dielectrics);
        dielectrics.any(|(material, inside)| material.has(TRANSMITS) && !inside.is_thin && inside.priority != 0)
    }

    /// Reports whether some light may be inside a solid with a transmissive surface, judged by their bounds.
    fn has_lights_in_solids(&self) -> bool {
        let mut solids = vec![false; self.field.object_bounds().len()];
        for (leaf, record) in self.field.leaves().iter().zip(&self.leaves) {
            solids[leaf.object as usize] |=
                record.has(leaf::IN_GLASS) && self.media.of_materials[leaf.tag as usize].is_displaced();
        }
        let solids = self.field.object_bounds().iter().zip(solids).filter(|(_, is_solid)| *is_solid);
        let bounds_of_light = |light: &Light| match (&light.shape, light.leaf()) {
            (LightShape::Point(point) | LightShape::Spot(SpotLight { point, .. }), _) => {
                Some(Aabb { min: point.position.into(), max: point.position.into() })
            }
            (_, Some(leaf)) => Some(self.field.leaf_bounds(leaf as usize)),
            _ => None,
        };
        let mut lights = self.lights.iter().filter_map(bounds_of_light);
        lights.any(|light| {
            let mut solids = solids.clone();
            solids.any(|(solid, _)| (0..3).all(|k| light.min[k] <= solid.max[k] && light.max[k] >= solid.min[k]))
        })
    }

    /// Reports whether some sphere-traced object emits and none is a fractal.
    fn has_sphere_traced_emitter(&self) -> bool {
        let leaves = self.field.leaves().iter().enumerate();
        let mut traced = leaves.filter(|(index, _)| !self.field.is_analytic_leaf(*index)).map(|(_, leaf)| leaf);
        let emits = |tag: u32| self.materials[tag as usize].flags & (material::EMITS | material::GLOWS) != 0;
        traced.clone().any(|leaf| emits(leaf.tag)) && traced.all(|leaf| !leaf.shape.has_orbit())
    }
}

/// Albedo of a material; of a lamp, its radiance.
pub(crate) fn base_colour(material: &Material) -> [f32; 3] {
    if material.is_lamp() { material.emission() } else { material.albedo() }
}

/// Bounding sphere of the finite objects. Without any, it is centred at the camera's target and passes through the
/// camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Centre in world space, metres.
    pub(crate) centre: Vec3,
    /// Radius, metres.
    pub(crate) radius: f32,
}

impl Extent {
    pub(crate) fn new(scene: &Scene, camera: &Camera) -> Self {
        let bounds = finite_bounds(scene);
        if bounds.is_finite() {
            let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
            Self { centre: (min + max) * 0.5, radius: ((max - min).length() * 0.5).max(1e-6) }
        } else {
            let (position, target) = (Vec3::from(camera.position), Vec3::from(camera.target));
            Self { centre: target, radius: position.distance(target) }
        }
    }
}

/// Bounds of all finite objects, in world space.
pub(crate) fn finite_bounds(scene: &Scene) -> Aabb {
    let bounds = scene.field.object_bounds().iter().filter(|bounds| bounds.is_finite());
    bounds.fold(Aabb::NOTHING, |all, bounds| all.union(*bounds))
}
