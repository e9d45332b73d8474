//! Closed surface of a mesh that may have holes.
//!
//! **Idea.** The boundary of a mesh, counted with orientation, consists of closed loops. Each gets a fan about its centroid. Then
//! the winding number is an integer everywhere, it changes only where the distance is zero, and the distance field is continuous.
//! For a planar loop the fan is exactly where the generalised winding number of the open mesh is one half (Jacobson et al. 2013).
//! A flipped triangle is a boundary counted twice, which two fans cancel.
//!
//! **Cost.** That of sorting the edges.

use crate::topology::{Edge, Welded};
use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;
use std::collections::BTreeMap;

/// Mesh of positions with all loops of its boundary closed.
pub(super) fn close(mesh: &TriangleMesh) -> TriangleMesh {
    let mut welded = Welded::new(mesh);
    for cycle in boundary_cycles(&welded.edges()) {
        fan(&cycle, &mut welded);
    }
    TriangleMesh { positions: welded.positions, triangles: welded.triangles, ..TriangleMesh::default() }
}

/// Simple cycles of half-edges that the mesh lacks to be closed.
fn boundary_cycles(edges: &[Edge]) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for edge in edges {
        let [low, high] = edge.ends;
        let (from, to) = if edge.forward > edge.backward { (high, low) } else { (low, high) };
        let missing = edge.forward.abs_diff(edge.backward) as usize;
        if missing > 0 {
            next.entry(from).or_default().extend(std::iter::repeat_n(to, missing));
        }
    }
    let mut cycles = Vec::new();
    let mut place: BTreeMap<u32, usize> = BTreeMap::new();
    while let Some((&start, _)) = next.first_key_value() {
        let mut trail: Vec<u32> = Vec::new();
        place.clear();
        let mut at = start;
        // Every vertex has as many missing half-edges to it as from it, so that the walk ends where it began.
        while let Some(targets) = next.get_mut(&at) {
            let Some(to) = targets.pop() else { break };
            if targets.is_empty() {
                next.remove(&at);
            }
            place.insert(at, trail.len());
            trail.push(at);
            if let Some(&first) = place.get(&to) {
                let cycle = trail.split_off(first);
                for vertex in &cycle {
                    place.remove(vertex);
                }
                cycles.push(cycle);
            }
            at = to;
        }
    }
    cycles
}

/// Adds triangles with the half-edges of a cycle.
fn fan(cycle: &[u32], welded: &mut Welded) {
    match *cycle {
        [a, b, c] => welded.triangles.push([a, b, c]),
        // There and back.
        [_, _] | [_] | [] => {}
        _ => {
            let centroid =
                cycle.iter().map(|&vertex| welded.positions[vertex as usize] / cycle.len() as f32).sum::<Vec3>();
            let middle = welded.positions.len() as u32;
            welded.positions.push(centroid);
            let ends = cycle.iter().zip(cycle.iter().cycle().skip(1));
            welded.triangles.extend(ends.map(|(&from, &to)| [from, to, middle]));
        }
    }
}
