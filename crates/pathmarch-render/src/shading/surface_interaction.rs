//! Surface interactions: position, normal, side and leaf of hits, eight at a time.

use crate::intersect::march::{rounding_at, start_offset};
use crate::intersect::ray::{Hit, RaySegment, Rays8, lane_of, lanes, transposed};
use crate::scene::TraceContext;
use crate::scene::leaf::{ANALYTIC, MESH_FIELD, TWO_SIDED};
use glam::Vec3;
use pathmarch_field::graph::{MeshInteraction, Surface};
use pathmarch_field::number::{Dual, Mask8, Real, Vec3 as FieldVec3};
use pathmarch_scene::textures::MeshAttributes;
use wide::f32x8;

/// Interaction of a ray with a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceInteraction {
    /// Position on the surface, in world space.
    pub(crate) p: Vec3,
    /// Leaf of the field; where leaves blend, the chosen one.
    pub(crate) leaf: usize,
    /// Unit geometric normal on the side of the ray's origin.
    pub(crate) normal: Vec3,
    /// Unit shading normal that points out of the solid: interpolated on meshes, else the geometric one.
    pub(crate) shading_outward: Vec3,
    /// True if that side is the inside of the solid.
    pub(crate) inside: bool,
    /// Triangle of a mesh that the ray hit.
    pub(crate) triangle: Option<u32>,
    /// Vertex attributes of a mesh.
    pub(crate) attributes: MeshAttributes,
    /// Offset from `p` to the origin of rays that leave on this side, metres.
    pub(crate) normal_offset: Vec3,
    /// Length of the path up to `p`, metres.
    pub(crate) length: f32,
}

impl SurfaceInteraction {
    /// Unit normal that points out of the solid.
    #[inline]
    pub(crate) fn outward(&self) -> Vec3 {
        if self.inside { -self.normal } else { self.normal }
    }
}

/// Surfaces at the hits of eight rays.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces8 {
    /// Positions on the surfaces, in world space.
    pub(crate) p: FieldVec3<f32x8>,
    /// Leaves of the field.
    pub(crate) leaf: [usize; 8],
    /// Unit geometric normals on the side of the rays' origins.
    pub(crate) normal: FieldVec3<f32x8>,
    /// Lanes where that side is the inside of the solid, a bit for each.
    pub(crate) inside: u32,
    /// Offsets from `p` to the origins of rays that leave on this side, metres.
    pub(crate) normal_offset: FieldVec3<f32x8>,
    /// Lengths of the rays, metres.
    length: f32x8,
}

impl Surfaces8 {
    /// Surfaces from hits (rays, distances along them, points), the field there, and what meshes add to the offsets.
    #[inline(always)]
    fn new(
        ctx: &TraceContext,
        (rays, t, hit_point): (&Rays8, f32x8, FieldVec3<f32x8>),
        field: &Dual<f32x8>,
        leaf: [usize; 8],
        clearance: f32x8,
    ) -> Self {
        let records = leaf.map(|leaf| ctx.scene.leaves[leaf]);
        let [_, _, _, _, x, y, z, flags] = transposed(records.map(bytemuck::cast));
        let origin = FieldVec3::new(x, y, z);
        let flags = flags.to_array().map(f32::to_bits);
        let is_analytic = lanes(|lane| (flags[lane] & ANALYTIC) as f32);

        let inverse = f32x8::ONE / field.gradient.length().fast_max(f32x8::splat(1e-6));
        let outward = field.gradient * inverse;
        let residual = field.value * inverse;
        let rounding = rounding_at(ctx.frame, hit_point, origin);
        // Within rounding of the surface, the direction of the ray decides the side; elsewhere the sign of the field
        // does.
        let side_tolerance = rounding + f32x8::splat(ctx.frame.rounding) * t;
        let on_surface = Mask8(f32x8::ZERO.simd_lt(is_analytic)) | Mask8(field.value.abs().simd_le(side_tolerance));
        let inside = Real::select(on_surface, -outward.dot(rays.direction), field.value).simd_lt(f32x8::ZERO);
        let normal = outward * Real::select(Mask8(inside), f32x8::splat(-1.0), f32x8::ONE);
        Self {
            p: hit_point - outward * residual,
            leaf,
            normal,
            inside: inside.to_bitmask(),
            normal_offset: normal * (start_offset(rounding, residual) + clearance),
            length: t,
        }
    }

    /// Surfaces at analytic hits of these rays: distances along them, and leaves that are no meshes.
    #[inline(always)]
    pub(crate) fn at_analytic_hits(ctx: &TraceContext, rays: &Rays8, t: f32x8, leaf: f32x8) -> Self {
        let hit_point = rays.origin + rays.direction * t;
        let Surface { field, leaf } = ctx.scene.field.surface_at_hit(hit_point, leaf, &|_| f32x8::ZERO);
        let leaf = leaf.to_array().map(|leaf| leaf as usize);
        Self::new(ctx, (rays, t, hit_point), &field, leaf, f32x8::ZERO)
    }

    /// Interaction of a lane, without the attributes of a mesh; its length is that of the ray.
    #[inline(always)]
    pub(crate) fn interaction(&self, lane: usize) -> SurfaceInteraction {
        let normal = lane_of(self.normal, lane);
        let inside = self.inside >> lane & 1 == 1;
        SurfaceInteraction {
            p: lane_of(self.p, lane),
            leaf: self.leaf[lane],
            normal,
            shading_outward: if inside { -normal } else { normal },
            inside,
            triangle: None,
            attributes: MeshAttributes::default(),
            normal_offset: lane_of(self.normal_offset, lane),
            length: self.length.as_array()[lane],
        }
    }
}

/// Surface interactions of hits. Where materials blend, the second one is chosen if its weight exceeds `threshold`, a
/// function of the hit's index and the blend's index.
pub(crate) fn surface_interactions(
    ctx: &TraceContext,
    hits: &[(RaySegment, Hit)],
    threshold: impl Fn(usize, u32) -> f32,
) -> Vec<SurfaceInteraction> {
    let mut result = Vec::with_capacity(hits.len());
    for (chunk_index, chunk) in hits.chunks(8).enumerate() {
        let hit_index = |lane: usize| lane.min(chunk.len() - 1);
        let rays = Rays8::new(chunk.iter().map(|(segment, _)| segment));
        let t = lanes(|lane| chunk[hit_index(lane)].1.t);
        let hit_point = rays.origin + rays.direction * t;
        let analytic = lanes(|lane| Hit::encoded(chunk[hit_index(lane)].1.analytic));
        let threshold = |blend| lanes(|lane| threshold(8 * chunk_index + hit_index(lane), blend));
        let surface = ctx.scene.field.surface_at_hit(hit_point, analytic, &threshold);
        let meshes = mesh_interactions(ctx, chunk);
        let Surface { field, leaf } = with_meshes(surface, &meshes, |lane| chunk[hit_index(lane)].1.analytic);
        let (leaf, attributes) = with_nearest_triangles(ctx, leaf, hit_point, &meshes);
        let leaf: [usize; 8] = leaf.to_array().map(|leaf| leaf as usize);
        let clearance = lanes(|lane| meshes[lane].map_or(0.0, |mesh| mesh.clearance));
        let surfaces = Surfaces8::new(ctx, (&rays, t, hit_point), &field, leaf, clearance);
        result.extend(chunk.iter().enumerate().map(|(lane, (segment, hit))| {
            let interaction = surfaces.interaction(lane);
            let is_turned = interaction.inside && ctx.scene.leaves[leaf[lane]].has(TWO_SIDED);
            let shading_outward = meshes[lane].map_or(interaction.shading_outward, |mesh| mesh.shading_normal);
            SurfaceInteraction {
                shading_outward: if is_turned { -shading_outward } else { shading_outward },
                triangle: hit.triangle,
                attributes: attributes[lane],
                inside: interaction.inside && !is_turned,
                length: segment.path_length + hit.t,
                ..interaction
            }
        }));
    }
    result
}

/// Geometry of up to eight hits with meshes.
fn mesh_interactions(ctx: &TraceContext, hits: &[(RaySegment, Hit)]) -> [Option<MeshInteraction>; 8] {
    if !ctx.scene.field.has_triangles() {
        return [None; 8];
    }
    let interaction = |(RaySegment { ray, .. }, hit): &(RaySegment, Hit)| {
        let (leaf, triangle) = (hit.analytic?, hit.triangle?);
        ctx.scene.field.mesh_interaction(leaf, triangle, ray.origin + ray.direction * hit.t)
    };
    std::array::from_fn(|lane| hits.get(lane).and_then(interaction))
}

/// Surfaces in which those of meshes replace the lanes that hit one.
fn with_meshes(
    surface: Surface<f32x8>,
    meshes: &[Option<MeshInteraction>; 8],
    hit_leaf: impl Fn(usize) -> Option<u32>,
) -> Surface<f32x8> {
    if meshes.iter().all(Option::is_none) {
        return surface;
    }
    let replaced = |old: f32x8, new: fn(&MeshInteraction) -> f32| {
        let old = old.to_array();
        lanes(|lane| meshes[lane].as_ref().map_or(old[lane], new))
    };
    let Surface { field, leaf } = surface;
    let gradient = FieldVec3::new(
        replaced(field.gradient.x, |mesh| mesh.normal.x),
        replaced(field.gradient.y, |mesh| mesh.normal.y),
        replaced(field.gradient.z, |mesh| mesh.normal.z),
    );
    let leaves = leaf.to_array();
    let leaf = lanes(|lane| match (meshes[lane], hit_leaf(lane)) {
        (Some(_), Some(leaf)) => leaf as f32,
        _ => leaves[lane],
    });
    Surface { field: Dual { value: replaced(field.value, |mesh| mesh.distance), gradient }, leaf }
}

/// Leaves and vertex attributes of hits; on fields of meshes, those of the closest triangle.
fn with_nearest_triangles(
    ctx: &TraceContext,
    leaf: f32x8,
    p: FieldVec3<f32x8>,
    meshes: &[Option<MeshInteraction>; 8],
) -> (f32x8, [MeshAttributes; 8]) {
    let mut attributes = meshes.map(|mesh| mesh.map_or_else(MeshAttributes::default, |mesh| mesh.attributes));
    if !ctx.config.mesh_fields {
        return (leaf, attributes);
    }
    let mut leaves = leaf.to_array();
    let [x, y, z] = [p.x, p.y, p.z].map(f32x8::to_array);
    for lane in 0..8 {
        let leaf = leaves[lane] as usize;
        let is_field = meshes[lane].is_none() && ctx.scene.leaves[leaf].has(MESH_FIELD);
        let at = FieldVec3::new(x[lane], y[lane], z[lane]);
        if let Some(nearest) = is_field.then(|| ctx.scene.field.nearest_triangle(leaf, at)).flatten() {
            leaves[lane] = nearest.leaf as f32;
            attributes[lane] = nearest.attributes;
        }
    }
    (f32x8::from(leaves), attributes)
}
