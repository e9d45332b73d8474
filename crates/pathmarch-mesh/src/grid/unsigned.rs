//! Distances to a surface, without sign, at the samples of a lattice.
//!
//! **Idea.** A box of samples is halved until few are left. Each half keeps the part of the hierarchy that its samples need
//! ([`Neighbourhood`]), and each sample starts with the triangle of the one before.

use crate::bounds::Bounds;
use crate::bvh::{Nearest, Neighbourhood};
use glam::{UVec3, Vec3};

/// Most samples along an edge of a box that is not halved.
const MAX_EDGE: u32 = 5;

/// Box of samples: the first, and their number along each axis.
#[derive(Clone, Copy)]
pub(super) struct SampleBox {
    pub first: UVec3,
    pub size: UVec3,
}

impl SampleBox {
    /// Halves along the longest axis, or none if the box is small.
    fn halves(self) -> Option<[Self; 2]> {
        let axis = self.size.max_position();
        let (edge, half) = (self.size[axis], self.size[axis].div_ceil(2));
        let part = |start: u32, edge: u32| {
            let mut part = self;
            part.first[axis] += start;
            part.size[axis] = edge;
            part
        };
        (edge > MAX_EDGE).then(|| [part(0, half), part(half, edge - half)])
    }

    /// Samples in an order in which each is next to the one before.
    fn samples(self) -> impl Iterator<Item = UVec3> {
        let size = self.size;
        let turned = |v: u32, edge: u32, is_turned: bool| if is_turned { edge - 1 - v } else { v };
        (0..size.element_product()).map(move |k| {
            let (z, row) = (k / (size.x * size.y), k / size.x);
            let y = turned(row % size.y, size.y, z % 2 == 1);
            self.first + UVec3::new(turned(k % size.x, size.x, row % 2 == 1), y, z)
        })
    }
}

/// Computes the distances of a box of samples, and passes them on with their place.
pub(super) fn distances(
    near: &Neighbourhood,
    samples: SampleBox,
    position: &impl Fn(UVec3) -> Vec3,
    guess: &mut Option<Nearest>,
    output: &mut impl FnMut(UVec3, f32),
) {
    let bounds = Bounds { min: position(samples.first), max: position(samples.first + samples.size - 1) };
    let near = near.narrowed(bounds, *guess);
    if let Some(halves) = samples.halves() {
        for half in halves {
            distances(&near, half, position, guess, output);
        }
        return;
    }
    for sample in samples.samples() {
        *guess = near.nearest(position(sample), *guess);
        output(sample, guess.map_or(f32::INFINITY, |nearest| nearest.squared_distance.sqrt()));
    }
}
