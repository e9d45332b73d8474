//! Solid to be meshed and its grid: the union of a field's objects, clipped to a box if given.

use crate::bounds::Aabb;
use crate::graph::{Field, Surface};
use crate::number::{Dual, Real, Vec3};
use wide::f32x8;

/// Eight points.
pub(super) type Points = Vec3<f32x8>;

/// Solid and its grid. The grid is unbounded; `counts` cells of it contain the solid.
pub(super) struct Solid<'a> {
    pub field: &'a Field,
    pub cut: Option<Aabb>,
    /// World position of corner 0 0 0.
    pub origin: [f64; 3],
    /// Edge of a cell, metres.
    pub cell: f64,
    /// Cells along each axis.
    pub counts: [i32; 3],
}

impl Solid<'_> {
    /// World position of grid coordinates, which are in cells.
    pub fn place(&self, at: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|k| (self.origin[k] + self.cell * at[k]) as f32)
    }
    /// World position of a grid corner.
    pub fn corner(&self, at: [i32; 3]) -> [f32; 3] {
        self.place(at.map(f64::from))
    }
    /// Lipschitz constant of [`distance`](Self::distance).
    pub fn lipschitz(&self) -> f32 {
        self.field.lipschitz()
    }

    /// Signed distance, metres, negative inside.
    pub fn distance(&self, p: Points) -> f32x8 {
        let distance = self.field.distance(p);
        match self.cut {
            Some(cut) => Real::max(distance, past(cut, p)),
            None => distance,
        }
    }

    /// Distance, gradient, and the leaf whose material shows; `threshold` chooses between blended materials.
    pub fn surface(&self, p: Points, threshold: &dyn Fn(u32) -> f32x8) -> Surface<f32x8> {
        let surface = self.field.union_surface(p, threshold);
        match self.cut {
            Some(cut) => {
                let past = past(cut, Dual::variables(p));
                let is_cut = surface.field.value.lt(past.value);
                Surface { field: Real::select(is_cut, past, surface.field), leaf: surface.leaf }
            }
            None => surface,
        }
    }
}

/// Distance beyond the faces of a box, the largest of all, so that faces are flat and edges sharp; metres.
fn past<N: Real>(cut: Aabb, p: Vec3<N>) -> N {
    let half = std::array::from_fn(|k| 0.5 * (cut.max[k] - cut.min[k]));
    let centre = std::array::from_fn(|k| 0.5 * (cut.max[k] + cut.min[k]));
    ((p - Vec3::constant(centre)).abs() - Vec3::constant(half)).largest()
}

/// Runs `of` on all points, eight at a time; the last lanes repeat the last point.
pub(super) fn in_lanes(points: &[[f32; 3]], mut of: impl FnMut(usize, Points)) {
    for (group, chunk) in points.chunks(8).enumerate() {
        let at = |axis: usize| f32x8::from(std::array::from_fn(|lane| chunk[lane.min(chunk.len() - 1)][axis]));
        of(8 * group, Vec3::new(at(0), at(1), at(2)));
    }
}
