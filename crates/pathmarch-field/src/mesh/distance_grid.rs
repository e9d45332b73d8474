//! Signed distances at the points of a grid.

use super::solid::{Solid, in_lanes};
use super::{Fineness, MeshError, grid};
use crate::bounds::Aabb;
use crate::graph::Field;
use rayon::prelude::*;

/// Largest number of values: four gigabytes.
pub(super) const MAX_VALUES: u64 = 1_000_000_000;

/// Grid of points around the union of a field's objects, clipped to a box if given, with at least one cell of space on every side.
///
/// Its values are those of the field: exact near most surfaces, elsewhere bounds that are no larger than the distance times the
/// field's Lipschitz constant; their sign is always right.
///
/// ```
/// use pathmarch_field::mesh::{DistanceGrid, Fineness};
/// use pathmarch_field::{Field, Node, Placement, graph::Kind, registry};
///
/// let shape = registry::shape("sphere").expect("registered");
/// let ball = Kind::Shape { shape: shape.into(), params: vec![1.0], tag: 0 };
/// let field = Field::new(&[Node { kind: ball, placement: Placement::default() }]);
/// let grid = DistanceGrid::new(&field, Fineness::Cell(0.1), None)?;
/// let [_, height, depth] = grid.size();
/// let plane = grid.plane(0);
/// assert_eq!(plane.len(), height * depth);
/// assert!(plane.iter().all(|distance| *distance > 0.0));
/// # Ok::<(), pathmarch_field::mesh::MeshError>(())
/// ```
pub struct DistanceGrid<'a> {
    solid: Solid<'a>,
}

impl<'a> DistanceGrid<'a> {
    /// Chooses the points.
    ///
    /// # Errors
    /// [`MeshError`]: a solid without bounds, without inside the box, or too many points.
    pub fn new(field: &'a Field, fineness: Fineness, cut: Option<Aabb>) -> Result<Self, MeshError> {
        let grid = Self { solid: grid(field, fineness, cut)? };
        let count: u64 = grid.size().map(|side| side as u64).iter().product();
        if count > MAX_VALUES { Err(MeshError::TooManyPoints) } else { Ok(grid) }
    }

    /// Number of points along x, y and z.
    pub fn size(&self) -> [usize; 3] {
        self.solid.counts.map(|cells| cells as usize + 1)
    }
    /// Position of the first point, metres.
    pub fn origin(&self) -> [f64; 3] {
        self.solid.origin
    }
    /// Distance between neighbours, metres.
    pub fn cell(&self) -> f64 {
        self.solid.cell
    }

    /// Signed distances at the points of one x, metres: y after y, and in each the points along z. Computed on all cores.
    pub fn plane(&self, x: usize) -> Vec<f32> {
        let [_, height, depth] = self.size();
        let row = |y: usize| {
            let points: Vec<_> = (0..depth).map(|z| self.solid.corner([x, y, z].map(|v| v as i32))).collect();
            let mut values = vec![0.0; depth];
            in_lanes(&points, |first, p| {
                let lanes = self.solid.distance(p).to_array();
                let chunk = &mut values[first..depth.min(first + lanes.len())];
                chunk.copy_from_slice(&lanes[..chunk.len()]);
            });
            values
        };
        (0..height).into_par_iter().flat_map_iter(row).collect()
    }
}
