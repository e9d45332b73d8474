//! A block of four by four by four cells: its crossings, patches and vertices, found without a look at any other.

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
/// How close to the surface a vertex must be that was not simply found between crossings, in cells.
const CLOSE: f32 = 0.02;
/// How far distances at a cell's corners may be from those to its plane, in cells, for the surface to count as flat there.
const FLAT: f64 = 0.05;

/// A cell that the surface passes through.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    /// Its number along each axis, packed by [`key`].
    pub key: u64,
    /// A bit for each corner inside, and above them two for each edge: the patch it belongs to.
    patches: u32,
    /// Number of the vertex of its first patch.
    first: u32,
}

impl Cell {
    fn new(at: [i32; 3], mask: u8, patches: &Patches, first: u32) -> Self {
        let of_edges = (0..12).fold(0, |bits, edge| bits | u32::from(patches.of_edge[edge]) << (2 * edge));
        Self { key: key(at), patches: u32::from(mask) | of_edges << 8, first }
    }
    /// The same cell where its block's vertices are numbered from `first`.
    pub fn moved(self, first: u32) -> Self {
        Self { first: self.first + first, ..self }
    }
    /// A bit for each corner inside.
    pub fn mask(&self) -> u8 {
        self.patches as u8
    }
    /// The vertex of the patch that crosses an edge.
    pub fn vertex(&self, edge: usize) -> u32 {
        self.first + (self.patches >> (8 + 2 * edge) & 3)
    }
}

/// Bits of a packed number along one axis.
const BITS: u32 = 21;
/// What is added to make it positive.
const BIAS: i32 = 1 << (BITS - 1);
/// The largest number along an axis, and its negative the smallest.
pub(super) const FARTHEST: i32 = BIAS - 2 * SIDE;

/// Three numbers along the axes as one, which orders them by z, then y, then x.
pub(super) fn key(at: [i32; 3]) -> u64 {
    let [x, y, z] = at.map(|v| (v + BIAS) as u64);
    x | y << BITS | z << (2 * BITS)
}

/// The three numbers of a [`key`].
pub(super) fn unpacked(key: u64) -> [i32; 3] {
    [0, 1, 2].map(|axis| (key >> (axis * BITS) & ((1 << BITS) - 1)) as i32 - BIAS)
}

/// A vertex of the mesh.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub colour: [f32; 3],
}

/// What is in a block.
#[derive(Default)]
pub(super) struct Block {
    pub cells: Vec<Cell>,
    pub vertices: Vec<Vertex>,
    /// The blocks around it that the surface goes on into: bit `x + 3 y + 9 z`, each 0 to 2.
    pub goes_on: u32,
}

/// Where the surface crosses an edge of the grid, and its unit normal there; zero where it has none.
#[derive(Clone, Copy, Default)]
struct Crossing {
    point: [f32; 3],
    normal: [f32; 3],
}

impl Block {
    /// The block whose first cell is `low`. `paint` gives colours.
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
                    block.goes_on |= around(at, axis);
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
                    let place = Place { solid, at, is_alone: patches.count == 1, corner_distances };
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

/// Where in its block a corner of the list is.
fn along(index: usize) -> [usize; 3] {
    [index % CORNERS, index / CORNERS % CORNERS, index / (CORNERS * CORNERS)]
}

/// How far apart neighbouring corners are in the list, along each axis.
const STEPS: [usize; 3] = [1, CORNERS, CORNERS * CORNERS];

/// The blocks that share an edge of a block's grid: bits as of [`Block::goes_on`].
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

/// The faces of a cell that are joined the other way than usual, because both cells there are pinched.
fn turned(solid: &Solid, at: [i32; 3], mask: u8) -> u8 {
    let open = pinched(mask);
    (0..6).filter(|face| open >> face & 1 == 1).fold(0, |bits, face: usize| {
        let mut beyond = at;
        beyond[face / 2] += if face & 1 == 1 { 1 } else { -1 };
        bits | (pinched(mask_of(solid, beyond)) >> (face ^ 1) & 1) << face
    })
}

/// The corners of a cell.
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

/// Where the surface crosses each of the edges: the Illinois variant of false position (Dowell and Jarratt 1971), which is
/// exact at once where the field is linear and always keeps the crossing between its two ends.
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
            // Whether the crossing lies above t.
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

/// A cell, for finding its vertices. Local coordinates are in cells, from its centre.
struct Place<'a> {
    solid: &'a Solid<'a>,
    at: [i32; 3],
    /// Whether the surface passes through it in one patch.
    is_alone: bool,
    corner_distances: [f32; 8],
}

impl Place<'_> {
    fn centre(&self) -> DVec3 {
        DVec3::from([0, 1, 2].map(|k| self.solid.origin[k] + self.solid.cell * (f64::from(self.at[k]) + 0.5)))
    }
    fn local(&self, point: [f32; 3]) -> DVec3 {
        (glam::Vec3::from(point).as_dvec3() - self.centre()) / self.solid.cell
    }
    fn in_world(&self, local: DVec3) -> [f32; 3] {
        (self.centre() + local * self.solid.cell).as_vec3().into()
    }

    /// The vertex of a patch, of the tangent planes at its crossings.
    fn vertex(&self, planes: &mut Vec<(DVec3, DVec3)>, paint: Paint) -> Vertex {
        let normal: DVec3 = planes.iter().map(|(_, normal)| normal).sum();
        let normal = normal.try_normalize().unwrap_or(DVec3::Y);
        let (met, told) = qef::solve(planes.iter().copied());
        let mut kept = None;
        if self.is_alone && !self.is_flat(met, normal) {
            self.look_around(planes);
            let (sharper, more) = qef::solve(planes.iter().copied());
            kept = Some(sharper).filter(|&sharper| more > told && self.may_hold(sharper, true));
        }
        let kept = kept.or_else(|| Some(met).filter(|&met| self.may_hold(met, false)));
        let kept = kept.unwrap_or(met.clamp(DVec3::splat(-0.5), DVec3::splat(0.5)));
        let position = self.in_world(kept);
        let normal = normal.as_vec3().into();
        let colour = blended(self.solid, position, &|leaf| paint(leaf, position, normal));
        Vertex { position, normal, colour }
    }

    /// Whether distances at the corners are those to one plane.
    fn is_flat(&self, point: DVec3, normal: DVec3) -> bool {
        (0..8).all(|corner| {
            let side = |axis: usize| (corner >> axis & 1) as f64 - 0.5;
            let height = (DVec3::new(side(0), side(1), side(2)) - point).dot(normal);
            (height - f64::from(self.corner_distances[corner]) / self.solid.cell).abs() < FLAT
        })
    }

    /// Adds the tangent planes where the surface is nearest to the cell's corners: what no edge of the cell crosses is met, too.
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
        distance.abs() <= CLOSE * self.solid.cell as f32
    }

    /// Whether the vertex may be at a place: in the cell; or on the surface up to half a cell beyond it, or up to a whole one in
    /// a cell that has no vertex of its own. So edges and corners are kept that reach into a cell none of whose edges they
    /// cross. What was found by looking around must be on the surface, and leaves a corner to the cell that has it.
    fn may_hold(&self, local: DVec3, is_sharper: bool) -> bool {
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

/// The colour at a place: the mean over eight choices between blended materials, an eighth apart for each blend.
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
