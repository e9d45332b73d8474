//! Connectivity of triangles by position.
//!
//! **Idea.** Vertices at the same position count as one, as mesh files duplicate them along seams. Half-edges are sorted by their
//! ends, so that all that share an edge are neighbours. **Cost.** That of sorting three half-edges a triangle.

use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Triangles whose corners are positions, each of which is there once.
pub(crate) struct Welded {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Welded {
    /// Welds the vertices of a mesh at equal positions.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let mut positions = Vec::new();
        let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.positions.len());
        let weld = |p: &Vec3| {
            // Adding zero makes -0 equal 0.
            let key = (*p + Vec3::ZERO).to_array().map(f32::to_bits);
            *first.entry(key).or_insert_with(|| {
                positions.push(*p);
                positions.len() as u32 - 1
            })
        };
        let welded: Vec<u32> = mesh.positions.iter().map(weld).collect();
        let triangles = mesh.triangles.par_iter().map(|triangle| triangle.map(|vertex| welded[vertex as usize]));
        let triangles = triangles.collect();
        Self { positions, triangles }
    }

    /// Edges, each with the number of triangles in either direction. Triangles with two equal corners have none.
    pub fn edges(&self) -> Vec<Edge> {
        let sides =
            |&[a, b, c]: &[u32; 3]| if a == b || b == c || c == a { None } else { Some([(a, b), (b, c), (c, a)]) };
        let mut halves: Vec<(u32, u32, bool)> = self
            .triangles
            .par_iter()
            .filter_map(sides)
            .flat_map_iter(|sides| sides.into_iter().map(|(from, to)| (from.min(to), from.max(to), from < to)))
            .collect();
        halves.par_sort_unstable();
        let same_edge = |a: &(u32, u32, bool), b: &(u32, u32, bool)| (a.0, a.1) == (b.0, b.1);
        let edge = |halves: &[(u32, u32, bool)]| {
            let forward = halves.iter().filter(|half| half.2).count() as u32;
            Edge { ends: [halves[0].0, halves[0].1], forward, backward: halves.len() as u32 - forward }
        };
        halves.chunk_by(same_edge).map(edge).collect()
    }
}

/// Edge of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    /// Its positions, the lower index first.
    pub ends: [u32; 2],
    /// Triangles that run from the first end to the second.
    pub forward: u32,
    /// Triangles that run from the second end to the first.
    pub backward: u32,
}
