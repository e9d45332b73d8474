//! Block of 4³ cells: its crossings, patches and vertices, independent of all other blocks.

use super::patches::{Patches, corners, is_crossed, pinched};
use super::solid::{Points, Solid, in_lanes};
use super::{Paint, qef};
use crate::number::{Real, Vec3};
use glam::DVec3;
use wide::f32x8;

/// Cells along an edge of a block.
pub(super) const SIDE: i32 = 4;
/// Corners along an edge of a block.
const CORNERS: usize = SIDE as usize + 1;
/// Largest distance to the surface of a vertex that is not between crossings, in cells.
const ON_SURFACE: f32 = 0.02;
/// Largest difference of a corner's distance and that to the plane for a flat cell, in cells.
const FLAT: f64 = 0.05;

/// Cell that the surface passes through.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    /// Index along each axis, packed by [`key`].
    pub key: u64,
    /// A bit for each corner inside, and above them two for each edge: its patch.
    patches: u32,
    /// Index of the vertex of its first patch.
    first: u32,
}

impl Cell {
    fn new(at: [i32; 3], mask: u8, patches: &Patches, first: u32) -> Self {
        let of_edges = (0..12).fold(0, |bits, edge| bits | u32::from(patches.of_edge[edge]) << (2 * edge));
        Self { key: key(at), patches: u32::from(mask) | of_edges << 8, first }
    }
    /// Offsets its vertices by the index of the block's first one.
    pub fn moved(self, first: u32) -> Self {
        Self { first: self.first + first, ..self }
    }
    /// A bit for each corner inside.
    pub fn mask(&self) -> u8 {
        self.patches as u8
    }
    /// Vertex of the patch that crosses an edge.
    pub fn vertex(&self, edge: usize) -> u32 {
        self.first + (self.patches >> (8 + 2 * edge) & 3)
    }
}

/// Bits of a packed index along one axis.
const BITS: u32 = 21;
/// Offset that makes it positive.
const BIAS: i32 = 1 << (BITS - 1);
/// Largest index along an axis; its negative is the least.
pub(super) const FARTHEST: i32 = BIAS - 2 * SIDE;

/// Packs three indices to one number, ordered by z, then y, then x.
pub(super) fn key(at: [i32; 3]) -> u64 {
    let [x, y, z] = at.map(|v| (v + BIAS) as u64);
    x | y << BITS | z << (2 * BITS)
}

/// Indices of a [`key`].
pub(super) fn unpacked(key: u64) -> [i32; 3] {
    [0, 1, 2].map(|axis| (key >> (axis * BITS) & ((1 << BITS) - 1)) as i32 - BIAS)
}

/// Vertex of the mesh.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub colour: [f32; 3],
}

/// Contoured block.
#[derive(Default)]
pub(super) struct Block {
    pub cells: Vec<Cell>,
    pub vertices: Vec<Vertex>,
    /// Neighbours into which the surface continues: bit `x + 3 y + 9 z`, each 0 to 2.
    pub continues: u32,
}

/// Crossing of the surface with a grid edge, and the unit normal there; zero if undefined.
#[derive(Clone, Copy, Default)]
struct Crossing {
    point: [f32; 3],
    normal: [f32; 3],
}

impl Block {
    /// Contours the block whose first cell is `low`, with colours from `paint`.
    pub fn new(solid: &Solid, low: [i32; 3], paint: Paint) -> Self {
        let corner_at = |index: usize| {
            let along = along(index);
            [0, 1, 2].map(|k| low[k] + along[k] as i32)
        };
        let corner_points: [[f32; 3]; CORNERS * CORNERS * CORNERS] =
            std::array::from_fn(|index| solid.corner(corner_at(index)));
        let mut distances = [0.0; CORNERS * CORNERS * CORNERS];
        in_lanes(&corner_points, |first, p| {
            for (slot, distance) in distances[first..].iter_mut().zip(solid.distance(p).to_array()) {
                *slot = distance;
            }
        });
        let is_inside = |index: usize| distances[index] < 0.0;
        if (1..distances.len()).all(|index| is_inside(index) == is_inside(0)) {
            return Self::default();
        }

        let mut block = Self::default();
        let mut edges = Vec::new();
        let mut number_of = [[u16::MAX; CORNERS * CORNERS * CORNERS]; 3];
        for (axis, numbers) in number_of.iter_mut().enumerate() {
            for (index, number) in numbers.iter_mut().enumerate() {
                let at = along(index);
                if at[axis] + 1 < CORNERS && is_inside(index) != is_inside(index + STEPS[axis]) {
                    *number = edges.len() as u16;
                    edges.push((index, axis));
                    block.continues |= around(at, axis);
                }
            }
        }
        let crossings = crossings(solid, &edges, &corner_points, &distances);

        let mut planes: Vec<(DVec3, DVec3)> = Vec::with_capacity(12);
        for z in 0..CORNERS - 1 {
            for y in 0..CORNERS - 1 {
                for x in 0..CORNERS - 1 {
                    let base = x + CORNERS * (y + CORNERS * z);
                    let index =
                        |corner: usize| base + (0..3).map(|axis| (corner >> axis & 1) * STEPS[axis]).sum::<usize>();
                    let mask = (0..8).fold(0, |bits, corner| bits | u8::from(is_inside(index(corner))) << corner);
                    if mask == 0 || mask == 255 {
                        continue;
                    }
                    let at = corner_at(base);
                    let patches = Patches::new(mask, turned(solid, at, mask));
                    block.cells.push(Cell::new(at, mask, &patches, block.vertices.len() as u32));
                    let corner_distances = std::array::from_fn(|corner| distances[index(corner)]);
                    let place = CellContext { solid, at, is_alone: patches.count == 1, corner_distances };
                    for patch in 0..patches.count {
                        planes.clear();
                        let of_patch = (0..12).filter(|&e| is_crossed(mask, e) && patches.of_edge[e] == patch);
                        planes.extend(of_patch.map(|edge| {
                            let crossing = &crossings[number_of[edge / 4][index(corners(edge)[0])] as usize];
                            (place.local(crossing.point), glam::Vec3::from(crossing.normal).as_dvec3())
                        }));
                        block.vertices.push(place.vertex(&mut planes, paint));
                    }
                }
            }
        }
        block
    }
}

/// Position of a corner in its block.
fn along(index: usize) -> [usize; 3] {
    [index % CORNERS, index / CORNERS % CORNERS, index / (CORNERS * CORNERS)]
}

/// Stride of the list of corners along each axis.
const STEPS: [usize; 3] = [1, CORNERS, CORNERS * CORNERS];

/// Blocks that share an edge of a block's grid: bits as of [`Block::continues`].
fn around(at: [usize; 3], axis: usize) -> u32 {
    let beside = |k: usize| {
        let low = k != axis && at[k] == 0;
        let high = k != axis && at[k] + 1 == CORNERS;
        (if low { 0 } else { 1 })..=(if high { 2 } else { 1 })
    };
    let mut bits = 0;
    for z in beside(2) {
        for y in beside(1) {
            for x in beside(0) {
                bits |= 1 << (x + 3 * y + 9 * z);
            }
        }
    }
    bits
}

/// Faces of a cell that are joined the other way, because both cells there are pinched.
fn turned(solid: &Solid, at: [i32; 3], mask: u8) -> u8 {
    let open = pinched(mask);
    (0..6).filter(|face| open >> face & 1 == 1).fold(0, |bits, face: usize| {
        let mut beyond = at;
        beyond[face / 2] += if face & 1 == 1 { 1 } else { -1 };
        bits | (pinched(mask_of(solid, beyond)) >> (face ^ 1) & 1) << face
    })
}

/// Corners of a cell.
fn corners_of(solid: &Solid, at: [i32; 3]) -> Points {
    let corner = |corner: usize| solid.corner([0, 1, 2].map(|k| at[k] + (corner >> k & 1) as i32));
    let corners: [_; 8] = std::array::from_fn(corner);
    let along = |axis: usize| f32x8::from(corners.map(|corner| corner[axis]));
    Vec3::new(along(0), along(1), along(2))
}

/// A bit for each corner of a cell that is inside.
fn mask_of(solid: &Solid, at: [i32; 3]) -> u8 {
    let distances = solid.distance(corners_of(solid, at)).to_array();
    (0..8).fold(0, |bits, corner| bits | u8::from(distances[corner] < 0.0) << corner)
}

/// Finds the crossing of each edge by the Illinois variant of false position (Dowell and Jarratt 1971), which is exact at once for
/// a linear field and always brackets the crossing.
fn crossings(solid: &Solid, edges: &[(usize, usize)], corner_points: &[[f32; 3]], distances: &[f32]) -> Vec<Crossing> {
    let cell = f32x8::splat(solid.cell as f32);
    let starts: Vec<_> = edges.iter().map(|&(index, _)| corner_points[index]).collect();
    let mut crossings = vec![Crossing::default(); edges.len()];
    in_lanes(&starts, |first, start| {
        let group = &edges[first..edges.len().min(first + 8)];
        let of_lane = |of: &dyn Fn((usize, usize)) -> f32| {
            f32x8::from(std::array::from_fn(|lane| of(group[lane.min(group.len() - 1)])))
        };
        let along = |k: usize| of_lane(&|(_, axis)| f32::from(u8::from(axis == k))) * cell;
        let along = Vec3::new(along(0), along(1), along(2));
        let point = |t: f32x8| start + along * t;
        let (zero, one, half) = (f32x8::splat(0.0), f32x8::splat(1.0), f32x8::splat(0.5));
        let (mut low, mut high, mut last) = (zero, one, zero);
        let mut at_low = of_lane(&|(index, _)| distances[index]);
        let mut at_high = of_lane(&|(index, axis)| distances[index + STEPS[axis]]);
        let is_rising = at_low.lt(at_high);
        let mut t = half;
        for _ in 0..10 {
            t = (low * at_high - high * at_low) / (at_high - at_low);
            let here = solid.distance(point(t));
            if !(cell * f32x8::splat(1e-6)).lt(here.abs()).0.any() {
                break;
            }
            // Positive if the crossing is above t.
            let above =
                Real::select(is_rising, Real::select(here.lt(zero), one, -one), Real::select(here.lt(zero), -one, one));
            let is_above = zero.lt(above);
            let again = zero.lt(above * last);
            (low, high) = (Real::select(is_above, t, low), Real::select(is_above, high, t));
            at_low = Real::select(is_above, here, Real::select(again, at_low * half, at_low));
            at_high = Real::select(is_above, Real::select(again, at_high * half, at_high), here);
            last = above;
        }
        let p = point(t);
        let gradient = solid.surface(p, &|_| half).field.gradient;
        for (lane, crossing) in crossings[first..].iter_mut().take(group.len()).enumerate() {
            let of = |v: Points| glam::Vec3::from([v.x, v.y, v.z].map(|v| v.to_array()[lane]));
            let (point, start) = (of(p), of(start));
            let point = if point.is_finite() { point } else { start };
            *crossing =
                Crossing { point: point.into(), normal: of(gradient).try_normalize().unwrap_or_default().into() };
        }
    });
    crossings
}

/// Cell whose vertices are computed. Local coordinates are in cells, from its centre.
struct CellContext<'a> {
    solid: &'a Solid<'a>,
    at: [i32; 3],
    /// True if the surface passes through it in one patch.
    is_alone: bool,
    corner_distances: [f32; 8],
}

impl CellContext<'_> {
    fn centre(&self) -> DVec3 {
        DVec3::from([0, 1, 2].map(|k| self.solid.origin[k] + self.solid.cell * (f64::from(self.at[k]) + 0.5)))
    }
    fn local(&self, point: [f32; 3]) -> DVec3 {
        (glam::Vec3::from(point).as_dvec3() - self.centre()) / self.solid.cell
    }
    fn in_world(&self, local: DVec3) -> [f32; 3] {
        (self.centre() + local * self.solid.cell).as_vec3().into()
    }

    /// Vertex of a patch, from the tangent planes at its crossings.
    fn vertex(&self, planes: &mut Vec<(DVec3, DVec3)>, paint: Paint) -> Vertex {
        let normal: DVec3 = planes.iter().map(|(_, normal)| normal).sum();
        let normal = normal.try_normalize().unwrap_or(DVec3::Y);
        let (meeting, rank) = qef::solve(planes.iter().copied());
        let mut kept = None;
        if self.is_alone && !self.is_flat(meeting, normal) {
            self.look_around(planes);
            let (sharper, more) = qef::solve(planes.iter().copied());
            kept = Some(sharper).filter(|&sharper| more > rank && self.may_be_at(sharper, true));
        }
        let kept = kept.or_else(|| Some(meeting).filter(|&meeting| self.may_be_at(meeting, false)));
        let kept = kept.unwrap_or(meeting.clamp(DVec3::splat(-0.5), DVec3::splat(0.5)));
        let position = self.in_world(kept);
        let normal = normal.as_vec3().into();
        let colour = blended(self.solid, position, &|leaf| paint(leaf, position, normal));
        Vertex { position, normal, colour }
    }

    /// Reports whether distances at the corners are those to one plane.
    fn is_flat(&self, point: DVec3, normal: DVec3) -> bool {
        (0..8).all(|corner| {
            let side = |axis: usize| (corner >> axis & 1) as f64 - 0.5;
            let height = (DVec3::new(side(0), side(1), side(2)) - point).dot(normal);
            (height - f64::from(self.corner_distances[corner]) / self.solid.cell).abs() < FLAT
        })
    }

    /// Adds the tangent planes at the surface points nearest to the cell's corners, for faces that cross no edge of the cell.
    fn look_around(&self, planes: &mut Vec<(DVec3, DVec3)>) {
        let mut p = corners_of(self.solid, self.at);
        let half = |_| f32x8::splat(0.5);
        let mut field = self.solid.surface(p, &half).field;
        for _ in 0..2 {
            p = p - field.gradient * (field.value / field.gradient.dot(field.gradient).divisor());
            field = self.solid.surface(p, &half).field;
        }
        for lane in 0..8 {
            let of = |v: Points| [v.x, v.y, v.z].map(|v| v.to_array()[lane]);
            let (point, normal) = (self.local(of(p)), glam::Vec3::from(of(field.gradient)).try_normalize());
            let is_near = point.abs().max_element() < 1.0 && self.is_close(field.value.to_array()[lane]);
            planes.extend(normal.filter(|_| is_near).map(|normal| (point, normal.as_dvec3())));
        }
    }

    fn is_close(&self, distance: f32) -> bool {
        distance.abs() <= ON_SURFACE * self.solid.cell as f32
    }

    /// Reports whether the vertex may be at a position: in the cell; or on the surface up to half a cell beyond it, or up to a
    /// whole one in a cell without a vertex of its own. This keeps edges and corners that reach into a cell without crossing
    /// its edges. A position from [`look_around`](Self::look_around) must be on the surface and leaves a corner to its own cell.
    fn may_be_at(&self, local: DVec3, is_sharper: bool) -> bool {
        let is_on_surface = || {
            let distance = self.solid.distance(Vec3::constant(self.in_world(local)));
            self.is_close(distance.to_array()[0])
        };
        let past = local.abs().max_element() - 0.5;
        if past <= 0.0 {
            return !is_sharper || is_on_surface();
        }
        let is_free = || {
            let beyond = [0, 1, 2].map(|axis| self.at[axis] + (local[axis] + 0.5).floor() as i32);
            [0, 255].contains(&mask_of(self.solid, beyond))
        };
        (past <= 0.5 && !is_sharper || past <= 1.0 && is_free()) && is_on_surface()
    }
}

/// Colour at a position: the mean over eight thresholds of each blend between materials.
fn blended(solid: &Solid, at: [f32; 3], colour: &dyn Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let threshold = |blend: u32| {
        let odd = 2 * blend + 1;
        f32x8::from(std::array::from_fn(|lane| ((lane as u32).wrapping_mul(odd) % 8) as f32 / 8.0 + 0.0625))
    };
    let leaves = solid.surface(Vec3::constant(at), &threshold).leaf.to_array();
    if leaves.iter().all(|leaf| *leaf == leaves[0]) {
        return colour(leaves[0] as usize);
    }
    let sum: glam::Vec3 = leaves.iter().map(|&leaf| glam::Vec3::from(colour(leaf as usize))).sum();
    (sum / 8.0).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hold_their_numbers() {
        for at in [[0, 0, 0], [-1, 5, 1000], [FARTHEST, -FARTHEST, 3]] {
            assert_eq!(unpacked(key(at)), at);
        }
        assert!(key([5, 0, 0]) < key([-5, 1, 0]) && key([0, 7, 0]) < key([0, -7, 1]));
    }
}
