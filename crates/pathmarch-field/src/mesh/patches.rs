//! Patches of the surface in a cell: the crossed edges that belong together.
//!
//! The corners of a cell are numbered by bits: 1 is the far side along x, 2 along y, 4 along z. An edge is `4 * axis + b + 2 * c`,
//! where `b` and `c` are the sides on which it lies along the next two axes; a face is `2 * axis + side`.
//!
//! **Idea.** On each face the surface's outline joins crossed edges in pairs. What is joined over all faces is a closed
//! loop, the border of one patch (a polygon of marching cubes), and every patch gets a vertex of its own: the mesh is the
//! dual of that of marching cubes (Nielson 2004). Where the four corners of a face alternate there are two ways to join, and
//! the corners inside are kept apart. Both cells of a face see the same corners, so both join alike.
//!
//! **The exception.** If both outlines on such a face belong to one patch in each of the two cells, the two
//! vertices would be joined twice, by one edge in four triangles. There, and only there, both cells join the other way (Wenger
//! 2013).

/// Two corners of an edge, the one of smaller coordinate first.
pub(super) fn corners(edge: usize) -> [usize; 2] {
    let (axis, b, c) = (edge / 4, edge & 1, edge >> 1 & 1);
    let first = b << ((axis + 1) % 3) | c << ((axis + 2) % 3);
    [first, first | 1 << axis]
}

/// Edge between two corners that differ along one axis.
fn between(one: usize, other: usize) -> usize {
    let axis = (one ^ other).trailing_zeros() as usize;
    4 * axis + (one >> ((axis + 1) % 3) & 1) + 2 * (one >> ((axis + 2) % 3) & 1)
}

fn is_inside(mask: u8, corner: usize) -> bool {
    mask >> corner & 1 == 1
}

/// Reports whether the surface crosses an edge of a cell; `mask` has a bit for each corner inside.
pub(super) fn is_crossed(mask: u8, edge: usize) -> bool {
    let [one, other] = corners(edge);
    is_inside(mask, one) != is_inside(mask, other)
}

/// The corners of a face, in order around it.
fn around(face: usize) -> [usize; 4] {
    let (axis, side) = (face / 2, face & 1);
    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(b, c)| side << axis | b << ((axis + 1) % 3) | c << ((axis + 2) % 3))
}

/// Reports whether the corners of a face alternate, so that its edges can be joined in two ways.
fn is_ambiguous(mask: u8, face: usize) -> bool {
    let [a, b, c, d] = around(face).map(|corner| is_inside(mask, corner));
    a == c && b == d && a != b
}

/// Patches of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Patches {
    /// Number of patches, at most four.
    pub count: u8,
    /// Patch of each crossed edge; 0 for the others.
    pub of_edge: [u8; 12],
}

impl Patches {
    /// Finds the patches of a cell whose corners inside are `mask`; the faces in `turned` (a bit for each) are joined the other
    /// way.
    pub fn new(mask: u8, turned: u8) -> Self {
        let mut joined = [[usize::MAX; 2]; 12];
        let mut join = |one: usize, other: usize| {
            for (from, to) in [(one, other), (other, one)] {
                let free = usize::from(joined[from][0] != usize::MAX);
                joined[from][free] = to;
            }
        };
        for face in 0..6 {
            let ring = around(face);
            let edge = |k: usize| between(ring[k % 4], ring[(k + 1) % 4]);
            if is_ambiguous(mask, face) {
                let apart = turned >> face & 1 == 0;
                for k in (0..4).filter(|&k| is_inside(mask, ring[k]) == apart) {
                    join(edge(k + 3), edge(k));
                }
            } else {
                let mut crossed = (0..4).map(edge).filter(|&edge| is_crossed(mask, edge));
                if let (Some(one), Some(other)) = (crossed.next(), crossed.next()) {
                    join(one, other);
                }
            }
        }
        let (mut count, mut of_edge, mut seen) = (0, [0; 12], [false; 12]);
        for start in 0..12 {
            if seen[start] || !is_crossed(mask, start) {
                continue;
            }
            let mut edge = start;
            while !seen[edge] {
                (seen[edge], of_edge[edge]) = (true, count);
                let [one, other] = joined[edge];
                edge = if seen[one] { other } else { one };
            }
            count += 1;
        }
        Self { count, of_edge }
    }

    fn are_all_one(&self, face: usize) -> bool {
        let ring = around(face);
        let patch = |k: usize| self.of_edge[between(ring[k], ring[(k + 1) % 4])];
        (1..4).all(|k| patch(k) == patch(0))
    }
}

/// Ambiguous faces whose two outlines belong to one patch, a bit for each.
pub(super) fn pinched(mask: u8) -> u8 {
    let faces = (0..6).filter(|&face| is_ambiguous(mask, face));
    let patches = Patches::new(mask, 0);
    faces.filter(|&face| patches.are_all_one(face)).fold(0, |bits, face| bits | 1 << face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_corners_agree() {
        for edge in 0..12 {
            let [one, other] = corners(edge);
            assert_eq!(one | 1 << (edge / 4), other);
            assert_eq!((between(one, other), between(other, one)), (edge, edge));
        }
    }

    #[test]
    fn patches_are_loops() {
        for mask in 0..=255 {
            for turned in 0..64 {
                let patches = Patches::new(mask, turned);
                assert!(patches.count <= 4);
                for patch in 0..patches.count {
                    let edges = (0..12).filter(|&e| is_crossed(mask, e) && patches.of_edge[e] == patch).count();
                    assert!(edges >= 3, "{mask:08b} {turned:06b}: a loop of {edges}");
                }
            }
        }
    }

    /// Two vertices of neighbouring cells are joined at most once, for all corners of the cells around them, so that every
    /// edge of the mesh is in two faces.
    #[test]
    fn no_two_vertices_are_joined_twice() {
        for mask in 0..=255 {
            let open = pinched(mask);
            for turned in (0..64).filter(|turned| turned & !open == 0) {
                let patches = Patches::new(mask, turned);
                for face in (0..6).filter(|&face| is_ambiguous(mask, face)) {
                    let one = patches.are_all_one(face);
                    if turned >> face & 1 == 1 {
                        assert!(!one, "{mask:08b}: still pinched at face {face} after turning it");
                    } else if open >> face & 1 == 0 {
                        assert!(!one, "{mask:08b}: turning {turned:06b} pinches face {face}");
                    }
                }
            }
        }
    }
}
