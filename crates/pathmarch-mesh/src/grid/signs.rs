//! Signs of distances at samples of a lattice.
//!
//! **Idea.** If the distances at two samples add up to more than their distance, no surface is between them, and they are on
//! the same side. Samples that such neighbours join form groups; the winding number is needed once for each. Away from
//! the surface there is one group on each side, so that almost all winding numbers are those of samples within a voxel of it.
//! **Cost.** Linear in the samples.

use super::layout::index;
use glam::UVec3;
use rayon::prelude::*;

/// Groups of samples on the same side of a surface.
pub(super) struct Groups {
    /// Representative of each sample's group, which is its least sample.
    roots: Vec<u32>,
    /// Side of each representative, once it is known: true inside.
    sides: Vec<Option<bool>>,
}

impl Groups {
    /// Joins the samples of a lattice with unsigned distances.
    pub fn new(distances: &[f32], size: UVec3, spacing: f32) -> Self {
        let mut groups = Self { roots: (0..distances.len() as u32).collect(), sides: vec![None; distances.len()] };
        // Distances are rounded.
        let apart = spacing * 1.0001;
        for z in 0..size.z {
            for y in 0..size.y {
                for x in 0..size.x {
                    let here = index(UVec3::new(x, y, z), size);
                    for (neighbour, exists) in [
                        (UVec3::new(x + 1, y, z), x + 1 < size.x),
                        (UVec3::new(x, y + 1, z), y + 1 < size.y),
                        (UVec3::new(x, y, z + 1), z + 1 < size.z),
                    ] {
                        let other = if exists { index(neighbour, size) } else { continue };
                        if distances[here] + distances[other] > apart {
                            groups.join(here as u32, other as u32);
                        }
                    }
                }
            }
        }
        for sample in 0..groups.roots.len() as u32 {
            groups.roots[sample as usize] = groups.find(sample);
        }
        groups
    }

    /// Sets the sides of the groups of some samples.
    pub fn know(&mut self, samples: &[(usize, bool)]) {
        for &(sample, is_inside) in samples {
            self.sides[self.roots[sample] as usize] = Some(is_inside);
        }
    }

    /// Decides the sides that are not known yet, by the side of a sample of each group.
    pub fn decide(&mut self, is_inside: impl Fn(usize) -> bool + Sync) {
        let Self { roots, sides } = self;
        let undecided = |sample: &usize| roots[*sample] as usize == *sample && sides[*sample].is_none();
        let decided: Vec<(usize, bool)> = if roots.len() > 10_000 {
            (0..roots.len()).into_par_iter().filter(undecided).map(|sample| (sample, is_inside(sample))).collect()
        } else {
            (0..roots.len()).filter(undecided).map(|sample| (sample, is_inside(sample))).collect()
        };
        for (sample, side) in decided {
            sides[sample] = Some(side);
        }
    }

    /// Makes the distances of samples inside negative.
    pub fn apply(&self, distances: &mut [f32]) {
        for (distance, &root) in distances.iter_mut().zip(&self.roots) {
            if self.sides[root as usize] == Some(true) {
                *distance = -*distance;
            }
        }
    }

    fn find(&mut self, mut sample: u32) -> u32 {
        while self.roots[sample as usize] != sample {
            let above = self.roots[self.roots[sample as usize] as usize];
            self.roots[sample as usize] = above;
            sample = above;
        }
        sample
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.roots[a.max(b) as usize] = a.min(b);
    }
}
