//! A block of four by four by four cells: its crossings, patches and vertices, found without a look at any other.

use super::patches::{Patches, corners, is_crossed, pinched};
use super::qef;
use super::solid::{Points, Solid, in_lanes};
use crate::number::{Real, Vec3};
use glam::DVec3;
use wide::f32x8;

/// Cells along an edge of a block.
pub(super) const SIDE: i32 = 4;
/// Corners along an edge of a block.
const CORNERS: usize = SIDE as usize + 1;
/// How far a vertex may leave its cell, in cells, if it is on the surface there: so that sharp edges are kept where they
/// reach into a cell none of whose edges they cross.
const REACH: f64 = 0.5;
/// How close to the surface it must be for that, in cells.
const CLOSE: f32 = 0.02;

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
    /// The block whose first cell is `low`. `paints` has a colour for each leaf.
    pub fn new(solid: &Solid, low: [i32; 3], paints: &[[f32; 3]]) -> Self {
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
        let mut drafts = Vec::new();
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
                    block.cells.push(Cell::new(at, mask, &patches, drafts.len() as u32));
                    let centre =
                        DVec3::from(std::array::from_fn(|k| solid.origin[k] + solid.cell * (f64::from(at[k]) + 0.5)));
                    for patch in 0..patches.count {
                        planes.clear();
                        let of_patch = (0..12).filter(|&e| is_crossed(mask, e) && patches.of_edge[e] == patch);
                        planes.extend(of_patch.map(|edge| {
                            let crossing = &crossings[number_of[edge / 4][index(corners(edge)[0])] as usize];
                            let point = (glam::Vec3::from(crossing.point).as_dvec3() - centre) / solid.cell;
                            (point, glam::Vec3::from(crossing.normal).as_dvec3())
                        }));
                        drafts.push(Draft::new(solid, centre, &planes));
                    }
                }
            }
        }
        block.vertices = finished(solid, drafts, paints);
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
        let corners: [_; 8] =
            std::array::from_fn(|corner| solid.corner([0, 1, 2].map(|k| beyond[k] + (corner >> k & 1) as i32)));
        let mut mask = 0;
        in_lanes(&corners, |_, p| {
            let distances = solid.distance(p).to_array();
            mask = (0..8).fold(0, |bits, corner| bits | u8::from(distances[corner] < 0.0) << corner);
        });
        bits | (pinched(mask) >> (face ^ 1) & 1) << face
    })
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

/// A vertex whose place is not decided yet.
struct Draft {
    /// Where the planes meet, if that is outside of the cell and within reach.
    outside: Option<[f32; 3]>,
    /// The place nearest to it in the cell.
    inside: [f32; 3],
    normal: [f32; 3],
}

impl Draft {
    /// Of planes in cells, as seen from the centre of the cell.
    fn new(solid: &Solid, centre: DVec3, planes: &[(DVec3, DVec3)]) -> Self {
        let met = qef::solve(planes.iter().copied());
        let kept = met.clamp(DVec3::splat(-0.5), DVec3::splat(0.5));
        let past = (met - kept).abs().max_element();
        let in_world = |v: DVec3| (centre + v * solid.cell).as_vec3().into();
        let normal: DVec3 = planes.iter().map(|(_, normal)| normal).sum();
        Self {
            outside: (past > 0.0 && past <= REACH).then(|| in_world(met)),
            inside: in_world(kept),
            normal: normal.as_vec3().try_normalize().unwrap_or(glam::Vec3::Y).into(),
        }
    }
}

fn finished(solid: &Solid, drafts: Vec<Draft>, paints: &[[f32; 3]]) -> Vec<Vertex> {
    let vertex = |draft: &Draft| Vertex { position: draft.inside, normal: draft.normal, colour: paints[0] };
    let mut vertices: Vec<_> = drafts.iter().map(vertex).collect();
    let outside = drafts.iter().enumerate().filter_map(|(number, draft)| Some((number, draft.outside?)));
    let (numbers, points): (Vec<_>, Vec<_>) = outside.unzip();
    in_lanes(&points, |first, p| {
        for (lane, distance) in solid.distance(p).to_array().into_iter().enumerate().take(points.len() - first) {
            if distance.abs() <= CLOSE * solid.cell as f32 {
                vertices[numbers[first + lane]].position = points[first + lane];
            }
        }
    });
    if paints.iter().any(|paint| paint != &paints[0]) {
        for vertex in &mut vertices {
            vertex.colour = blended(solid, vertex.position, paints);
        }
    }
    vertices
}

/// The colour at a place: the mean over eight choices between blended materials, an eighth apart for each blend.
fn blended(solid: &Solid, at: [f32; 3], paints: &[[f32; 3]]) -> [f32; 3] {
    let threshold = |blend: u32| {
        let odd = 2 * blend + 1;
        f32x8::from(std::array::from_fn(|lane| ((lane as u32).wrapping_mul(odd) % 8) as f32 / 8.0 + 0.0625))
    };
    let leaves = solid.surface(Vec3::constant(at), &threshold).leaf.to_array();
    let sum: glam::Vec3 = leaves.iter().map(|&leaf| glam::Vec3::from(paints[leaf as usize])).sum();
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
