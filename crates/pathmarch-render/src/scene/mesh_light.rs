//! Emitting triangles of a mesh, and their choice.
//!
//! An alias table chooses a triangle in proportion to its area, and two more numbers a point on it (Turk 1990, "Generating Random
//! Points in Triangles"), so that points are distributed uniformly over the surface.
//!
//! **Parts.** A mesh may hold many lamps, or a long one. [`MeshLight::parts`] divides its triangles, and each part is a light of its
//! own, which the light tree chooses by place. Triangles are halved again and again in the middle of their longest side. From the
//! single triangles up, halves are parts if the squares of their radii sum to less than that of the whole, by a margin: far apart
//! lamps are, and pieces of a tube, but the halves of a ball or a panel are not.

use super::light_tree::NormalCone;
use crate::sampling::alias_table;
use glam::Vec3;
use pathmarch_field::{Field, MeshAttributes, MeshSurface};
use std::sync::Arc;

/// Largest number of parts of a mesh, about.
const MAX_PARTS: usize = 8192;
/// Largest number of times that triangles are halved.
const MAX_DEPTH: u32 = 40;
/// Cost of halves as parts, relative to that of the whole if it is as large: more lights make the choice slower.
const COST_OF_HALVES: f32 = 1.05;

/// Triangles of one material of a placed mesh, or a part of these.
#[derive(Clone, Debug)]
pub(crate) struct MeshLight {
    surface: Arc<MeshSurface>,
    /// Number of each triangle of the mesh in kernels.
    kernel_numbers: Arc<[u32]>,
    /// Emitting triangles of the mesh.
    pub(crate) triangles: Vec<u32>,
    /// Alias table over them.
    pub(crate) cells: Vec<alias_table::Cell>,
    /// Rays pass through the backs of the triangles.
    pub(crate) is_single_sided: bool,
    /// Area of all, square metres.
    pub(crate) area: f32,
    /// From the mesh's coordinates to the world.
    at: Vec3,
    axes: [Vec3; 3],
}

/// Point on an emitting triangle.
pub(crate) struct PointOnMesh {
    pub(crate) p: Vec3,
    /// Unit normal on the front of the triangle.
    pub(crate) normal: Vec3,
    pub(crate) attributes: MeshAttributes,
}

impl MeshLight {
    /// Light of a leaf, if it is triangles that no ray passes from their front.
    pub(crate) fn new(field: &Field, leaf: usize) -> Option<Self> {
        use pathmarch_field::mesh_shape::AlphaTest;
        let source = &field.leaves()[leaf];
        let mesh = source.shape.mesh().filter(|_| source.is_triangles())?;
        let opacity = mesh.opacity().and_then(|opacity| opacity.materials.get(source.slot as usize));
        if opacity.is_some_and(|opacity| opacity.test != AlphaTest::Opaque) {
            return None;
        }
        let count = mesh.surface().mesh().triangles.len() as u32;
        let whole = Self {
            surface: Arc::clone(mesh.surface()),
            kernel_numbers: mesh.surface().kernel_triangles().into(),
            triangles: Vec::new(),
            cells: Vec::new(),
            is_single_sided: opacity.is_some_and(|opacity| opacity.is_single_sided),
            area: 0.0,
            at: Vec3::from(source.pose.at),
            axes: source.pose.axes.map(|axis| Vec3::from(axis) * source.pose.scale),
        };
        whole.with_triangles((0..count).filter(|&triangle| mesh.slot(triangle) == source.slot).collect())
    }

    /// Light of these triangles of the mesh; `None` if they have no area.
    fn with_triangles(&self, triangles: Vec<u32>) -> Option<Self> {
        let double_area = |&triangle: &u32| {
            let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
            (b - a).cross(c - a).length()
        };
        let areas: Vec<f64> = triangles.iter().map(double_area).collect();
        let scale = self.axes[0].length();
        let area = (0.5 * areas.iter().sum::<f64>()) as f32 * scale * scale;
        (area > 0.0).then(|| Self { cells: alias_table::table(&areas), triangles, area, ..self.clone() })
    }

    /// Corners of a triangle in the mesh's coordinates.
    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.surface.mesh().corners(triangle as usize)
    }

    /// Parts whose lights are chosen apart; only this one if it is compact.
    pub(super) fn parts(self) -> Vec<Self> {
        let sizes = self.triangles.iter().map(|&triangle| TriangleBounds::new(triangle, self.corners(triangle)));
        let mut sizes: Vec<TriangleBounds> = sizes.collect();
        let smallest = sizes.len() / MAX_PARTS;
        let parts = partition(&mut sizes, smallest, 0).parts;
        if parts.len() < 2 {
            return vec![self];
        }
        let part = |mut triangles: Vec<u32>| {
            triangles.sort_unstable();
            self.with_triangles(triangles)
        };
        parts.into_iter().filter_map(part).collect()
    }

    /// Centre and radius of a sphere around the triangles, in world space, metres.
    pub(super) fn bounds(&self) -> (Vec3, f32) {
        let corners = || self.triangles.iter().flat_map(|&triangle| self.corners(triangle));
        let (min, max) = corners().fold((Vec3::MAX, Vec3::MIN), |(min, max), p| (min.min(p), max.max(p)));
        let centre = min.midpoint(max);
        let radius = corners().map(|p| p.distance(centre)).fold(0.0, f32::max);
        (self.at + self.world(centre), radius * self.axes[0].length() * 1.001)
    }

    /// Vector of the mesh's coordinates in world space.
    fn world(&self, v: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        x * v.x + y * v.y + z * v.z
    }

    /// Cone of the normals of all emitting sides, in world space.
    pub(super) fn normals(&self) -> NormalCone {
        if !self.is_single_sided {
            return NormalCone::ALL;
        }
        let normal = |&triangle: &u32| {
            let [a, b, c] = self.corners(triangle);
            let (b, c) = (b - a, c - a);
            let scale = b.abs().max(c.abs()).max_element().max(f32::MIN_POSITIVE);
            self.world((b / scale).cross(c / scale)).try_normalize()
        };
        let cones = self.triangles.iter().filter_map(normal).map(NormalCone::of);
        cones.reduce(NormalCone::union).unwrap_or(NormalCone::ALL)
    }

    /// Point for two uniform numbers.
    pub(crate) fn point(&self, [u, v]: [f32; 2]) -> PointOnMesh {
        let (index, u) = alias_table::sample(&self.cells, u);
        let triangle = self.triangles[index];
        let root = u.sqrt();
        let weights = [root * (1.0 - v), root * v];
        let [a, b, c] = self.corners(triangle);
        let (b, c) = (b - a, c - a);
        let scale = b.abs().max(c.abs()).max_element().max(f32::MIN_POSITIVE);
        PointOnMesh {
            p: self.at + self.world(a + b * weights[0] + c * weights[1]),
            normal: self.world((b / scale).cross(c / scale)).normalize_or(Vec3::Y),
            attributes: self.surface.attributes(triangle, weights),
        }
    }

    /// Number of triangles of the mesh, with those that do not emit.
    pub(super) fn mesh_triangles(&self) -> usize {
        self.kernel_numbers.len()
    }

    /// Number of each emitting triangle in kernels.
    pub(crate) fn kernel_triangles(&self) -> impl Iterator<Item = u32> {
        self.triangles.iter().map(|&triangle| self.kernel_numbers[triangle as usize])
    }
}

/// Triangle with its bounding box, in the mesh's coordinates.
#[derive(Clone, Copy)]
struct TriangleBounds {
    triangle: u32,
    min: Vec3,
    max: Vec3,
}

impl TriangleBounds {
    fn new(triangle: u32, [a, b, c]: [Vec3; 3]) -> Self {
        Self { triangle, min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    fn centre(&self) -> Vec3 {
        self.min.midpoint(self.max)
    }
}

/// Best partition of some triangles.
struct Partition {
    parts: Vec<Vec<u32>>,
    /// Sum of the squares of their radii, with [`COST_OF_HALVES`].
    cost: f32,
}

/// Best partition of these triangles, at least one, which were halved `depth` times. No more than `smallest` are not halved.
fn partition(triangles: &mut [TriangleBounds], smallest: usize, depth: u32) -> Partition {
    let bounds = |values: &mut dyn Iterator<Item = (Vec3, Vec3)>| {
        values.fold((Vec3::MAX, Vec3::MIN), |(min, max), (low, high)| (min.min(low), max.max(high)))
    };
    let (min, max) = bounds(&mut triangles.iter().map(|triangle| (triangle.min, triangle.max)));
    let whole = |triangles: &[TriangleBounds]| Partition {
        parts: vec![triangles.iter().map(|bounds| bounds.triangle).collect()],
        cost: 0.25 * (max - min).length_squared(),
    };
    let (low, high) = bounds(&mut triangles.iter().map(|triangle| (triangle.centre(), triangle.centre())));
    let axis = (high - low).max_position();
    let middle = 0.5 * (low[axis] + high[axis]);
    let is_low = |triangle: &TriangleBounds| triangle.centre()[axis] < middle;
    triangles.sort_unstable_by_key(|triangle| !is_low(triangle));
    let half = triangles.partition_point(is_low);
    if triangles.len() <= smallest || depth == MAX_DEPTH || half == 0 {
        return whole(triangles);
    }
    let (first, second) = triangles.split_at_mut(half);
    let halves = [first, second].map(|half| partition(half, smallest, depth + 1));
    let cost = COST_OF_HALVES * (halves[0].cost + halves[1].cost);
    let whole = whole(triangles);
    if cost < whole.cost {
        Partition { parts: halves.into_iter().flat_map(|half| half.parts).collect(), cost }
    } else {
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of a grid of squares of this edge, one metre apart or their edge if that is more.
    fn squares(columns: u32, rows: u32, edge: f32) -> Vec<TriangleBounds> {
        let square = |k: u32| {
            let corner = Vec3::new((k % columns) as f32, 0.0, (k / columns) as f32) * edge.max(1.0);
            let [x, z] = [Vec3::X, Vec3::Z].map(|axis| corner + axis * edge);
            let opposite = x + Vec3::Z * edge;
            [TriangleBounds::new(2 * k, [corner, x, opposite]), TriangleBounds::new(2 * k + 1, [corner, z, opposite])]
        };
        (0..columns * rows).flat_map(square).collect()
    }

    fn parts(mut triangles: Vec<TriangleBounds>) -> Vec<Vec<u32>> {
        partition(&mut triangles, 0, 0).parts
    }

    #[test]
    fn lamps_that_are_apart_are_parts() {
        for (columns, rows) in [(2, 1), (8, 8), (31, 3)] {
            let mut parts = parts(squares(columns, rows, 0.2));
            parts.iter_mut().for_each(|part| part.sort_unstable());
            parts.sort_unstable();
            let expected: Vec<Vec<u32>> = (0..columns * rows).map(|k| vec![2 * k, 2 * k + 1]).collect();
            assert_eq!(parts, expected);
        }
    }

    #[test]
    fn panels_and_balls_are_whole_and_strips_are_pieces() {
        assert_eq!(parts(squares(1, 1, 1.0)).len(), 1);
        assert_eq!(parts(squares(40, 40, 1.0)).len(), 1);
        let pieces = parts(squares(100, 1, 1.0)).len();
        assert!((50..=100).contains(&pieces), "{pieces}");
        let mut ball = Vec::new();
        for k in 0..2000_u16 {
            // Points of a spiral, each the corner of a small triangle.
            let (y, angle) = (1.0 - f32::from(2 * k + 1) / 2000.0, 2.4 * f32::from(k));
            let p = Vec3::new((1.0 - y * y).sqrt() * angle.cos(), y, (1.0 - y * y).sqrt() * angle.sin());
            let side = p.any_orthonormal_vector() * 0.05;
            ball.push(TriangleBounds::new(k.into(), [p, p + side, p + p.cross(side)]));
        }
        assert_eq!(parts(ball).len(), 1);
    }

    #[test]
    fn equal_triangles_are_one_part() {
        let triangle = TriangleBounds::new(0, [Vec3::X, Vec3::Y, Vec3::Z]);
        assert_eq!(parts(vec![triangle; 1000]).len(), 1);
    }
}
