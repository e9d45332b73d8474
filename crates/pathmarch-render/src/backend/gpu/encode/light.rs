//! Lights as records of one layout.

use crate::scene::RenderScene;
use crate::scene::light::{BoxLight, Light, LightShape, SheetLight, SphereLight, SpotLight, TrianglesLight};
use crate::wgsl::{declaration, shared_struct, write_constant};
use bytemuck::Zeroable;
use glam::Vec3;
use pathmarch_scene::DirectLighting;

shared_struct! {
    /// Light. A field that a kind of light lacks is zero.
    pub(crate) struct LightRecord as Light {
        /// Centre in world space, metres; of a sun the unit vector towards it.
        pub(super) position: [f32; 3],
        /// Index of the kind, see [`LightShape::kind`].
        pub(super) kind: u32,
        /// Radiant intensity of a point and on the axis of a spot, W/sr; irradiance of a sun, W/m²; radiance of an object, W/(m² sr).
        pub(super) emission: [f32; 3],
        /// Probability of being chosen.
        pub(super) pmf: f32,
        /// Alias table: probability to keep this light in its cell, and the light chosen otherwise.
        pub(super) threshold: f32,
        pub(super) alias_light: u32,
        /// Leaf of the field that emits.
        pub(super) leaf: u32,
        /// Radius of a sphere, a disc or a bounding sphere, metres; of a sun 1 - cosine of its angular radius.
        pub(super) radius: f32,
        /// Half edges, metres; of a spot y is the axis, and x has the cosine at which it ends and the inverse width of its
        /// falloff; of a sheet y is the unit normal of the emitting side, of a disc x and z are unit axes.
        pub(super) x: [f32; 3],
        /// Sharpness of shadows from near misses; 0 for exact shadows.
        pub(super) penumbra: f32,
        pub(super) y: [f32; 3],
        /// Area of a rectangle, a disc or triangles, square metres.
        pub(super) area: f32,
        pub(super) z: [f32; 3],
        /// One over `pmf`.
        pub(super) inverse_pmf: f32,
    }
}

/// Names of the kinds of lights in constants of the kernel, by index.
pub(crate) const KIND_NAMES: [&str; LightShape::KINDS] =
    ["POINT", "SUN", "SPHERE", "RECT", "DISC", "BOX", "BOUNDED", "ENVIRONMENT", "TRIANGLES", "SPOT"];

/// Declarations of lights and their kinds in WGSL.
pub(crate) fn shared_wgsl() -> String {
    let mut code = declaration::<LightRecord>();
    for (kind, name) in (0u32..).zip(KIND_NAMES) {
        write_constant(&mut code, &[], name, &kind);
    }
    code
}

/// Values of `DIRECT_LIGHTING` in WGSL.
pub(crate) fn direct_lighting_wgsl() -> String {
    let mut code = String::new();
    write_constant(&mut code, &[], "LIGHT_SAMPLING", &(DirectLighting::LightSampling as u32));
    write_constant(&mut code, &[], "BSDF_SAMPLING", &(DirectLighting::BsdfSampling as u32));
    code
}

/// Encodes the emitting triangles of meshes. Two offsets for each index come first: that of the table of the mesh light with this
/// index, and that of the table of the mesh of several parts with this index. The table of a light has a word for whether it is
/// single-sided, the number of triangles, and the cells of its alias table with the triangle of each. The table of a mesh of several
/// parts has the light of each triangle plus one, or zero.
pub(in crate::backend::gpu) fn encode_mesh_lights(scene: &RenderScene, start: usize) -> Vec<u32> {
    if scene.mesh_lights.is_empty() {
        return Vec::new();
    }
    // There are fewer meshes of several parts than parts.
    let mut words = vec![0; 2 * scene.mesh_lights.len()];
    for (index, mesh) in scene.mesh_lights.iter().enumerate() {
        words[2 * index] = (start + words.len()) as u32;
        words.extend([u32::from(mesh.is_single_sided), mesh.cells.len() as u32]);
        // Cells of two words, as in all alias tables.
        words.extend(mesh.cells.iter().flat_map(|&(threshold, alias)| [threshold.to_bits(), alias]));
        words.extend(mesh.kernel_triangles());
    }
    for (index, lights) in scene.mesh_parts.iter().enumerate() {
        words[2 * index + 1] = (start + words.len()) as u32;
        words.resize(words.len() + lights.len(), 0);
    }
    for (number, light) in (1..).zip(&scene.lights) {
        if let LightShape::Triangles(TrianglesLight { mesh, parts: Some(parts), .. }) = light.shape {
            let first = words[2 * parts + 1] as usize - start;
            let triangles = scene.mesh_lights[mesh].kernel_triangles();
            triangles.for_each(|triangle| words[first + triangle as usize] = number);
        }
    }
    words
}

impl LightRecord {
    /// Record of a light.
    pub(crate) fn new(light: &Light) -> Self {
        let shape = match &light.shape {
            LightShape::Point(point) => {
                Self { position: point.position.into(), ..Self::emitting(point.radiant_intensity) }
            }
            LightShape::Spot(SpotLight { point, axis, cos_outer, inverse_falloff }) => Self {
                position: point.position.into(),
                x: [*cos_outer, *inverse_falloff, 0.0],
                y: (*axis).into(),
                ..Self::emitting(point.radiant_intensity)
            },
            LightShape::Sun(sun) => {
                Self { position: sun.direction.into(), radius: sun.one_minus_cos, ..Self::emitting(sun.irradiance) }
            }
            LightShape::Sphere(sphere) | LightShape::Bounded(sphere) => Self::sphere(sphere),
            LightShape::Rect(sheet) | LightShape::Disc(sheet) => Self::sheet(sheet),
            LightShape::Box(light) => Self::cuboid(light),
            LightShape::Triangles(light) => {
                let parts = light.parts.map_or(-1.0, |parts| parts as f32);
                Self { area: light.area, x: [light.mesh as f32, parts, 0.0], ..Self::sphere(&light.bounds) }
            }
            LightShape::Environment => Self::zeroed(),
        };
        Self {
            kind: light.shape.kind(),
            pmf: light.pmf,
            inverse_pmf: light.inverse_pmf,
            threshold: light.threshold,
            alias_light: light.alias,
            penumbra: light.shape.penumbra(),
            ..shape
        }
    }

    fn emitting(emission: Vec3) -> Self {
        Self { emission: emission.into(), ..Self::zeroed() }
    }

    fn sphere(sphere: &SphereLight) -> Self {
        let &SphereLight { centre, radius, radiance, leaf } = sphere;
        Self { position: centre.into(), radius, leaf, ..Self::emitting(radiance) }
    }

    fn sheet(sheet: &SheetLight) -> Self {
        let &SheetLight { centre, axes: [x, z], normal, radius, area, radiance, leaf } = sheet;
        let (x, y, z) = (x.into(), normal.into(), z.into());
        Self { position: centre.into(), radius, area, leaf, x, y, z, ..Self::emitting(radiance) }
    }

    fn cuboid(light: &BoxLight) -> Self {
        let [x, y, z] = light.axes.map(<[f32; 3]>::from);
        Self { position: light.centre.into(), leaf: light.leaf, x, y, z, ..Self::emitting(light.radiance) }
    }
}
