//! Nested dielectrics: which of the overlapping solids around a point fills the space (Schmidt and Budge 2002, "Simple
//! Nested Dielectrics in Ray Traced Images").
//!
//! Solids of the highest priority fill the space. The surface of another one inside them is a *false intersection*:
//! light passes it unchanged. At any other surface, the relative index is that of the two sides. The index of a space
//! is the product of the indices of the solids that fill it, so that solids of equal priority look as in scenes without
//! priorities: each surface has its own index against what is around it, and media add up.
//!
//! A path remembers the solids around it by the leaf through which it entered each object. A surface settles whether
//! the path is in its object: a path that missed a surface is corrected by the next one of that object. Where the
//! materials of an object blend, a surface has the index of its own material on both sides of the walk.
//!
//! **Limit.** At most [`MAX_SOLIDS`](super::medium::MAX_SOLIDS) are remembered. Of more, those of the lowest priority
//! are forgotten, which do not fill the space: light is wrong only where the path leaves the others and one of them
//! would fill it again.

use super::material::{BOUNDARY, TRANSMITS};
use super::medium::SolidsAround;
use super::{Medium, RenderScene};
use crate::wgsl::shared_constants;
use pathmarch_scene::materials::Dielectric;

shared_constants! {
    /// Rank of boundaries of media, which fill no space. A solid with a surface has a rank of its priority plus 128.
    const BOUNDARY_RANK: u32 = 1;
    /// Number of words of the dielectric of a leaf: key, index, difference between the lines F and C.
    const DIELECTRIC_WORDS: usize = 3;
}

impl RenderScene {
    #[inline]
    fn dielectric(&self, leaf: usize) -> &Dielectric {
        &self.media.dielectrics[self.leaves[leaf].material as usize]
    }

    /// Rank of the solid of a leaf among those that overlap; above that of no solid, which is 0.
    fn rank(&self, leaf: usize) -> u32 {
        if self.material_of(leaf).has(BOUNDARY) {
            return BOUNDARY_RANK;
        }
        self.dielectric(leaf).priority.wrapping_add(128).clamp(2, 255) as u32
    }

    /// Words of the dielectric of a leaf for the kernel. The key is 0 if light does not enter a solid there.
    pub(crate) fn dielectric_words(&self, leaf: usize) -> [u32; DIELECTRIC_WORDS] {
        let Dielectric { ior, index_difference, is_thin, .. } = *self.dielectric(leaf);
        let has_inside = self.material_of(leaf).has(TRANSMITS) && !is_thin;
        let key = self.rank(leaf) << 24 | (self.field.leaves()[leaf].object + 1);
        [if has_inside { key } else { 0 }, ior.to_bits(), index_difference.to_bits()]
    }

    /// Solids other than that of a leaf.
    fn without_solid(&self, around: &SolidsAround, leaf: usize) -> SolidsAround {
        let object = |leaf: usize| self.field.leaves()[leaf].object;
        around.map(|entry| if entry > 0 && object(entry as usize - 1) == object(leaf) { 0 } else { entry })
    }

    /// These solids and that of a leaf.
    pub(super) fn with_solid(&self, around: &SolidsAround, leaf: usize) -> SolidsAround {
        let mut all = self.without_solid(around, leaf);
        let rank = |entry: u32| if entry == 0 { 0 } else { self.rank(entry as usize - 1) };
        if let Some(lowest) = all.iter_mut().min_by_key(|entry| rank(**entry))
            && rank(*lowest) < self.rank(leaf)
        {
            *lowest = leaf as u32 + 1;
        }
        all
    }

    /// Leaves of these solids.
    fn solids(around: &SolidsAround) -> impl Iterator<Item = usize> {
        around.iter().filter(|entry| **entry > 0).map(|entry| *entry as usize - 1)
    }

    /// Highest rank of these solids.
    fn highest_rank(&self, around: &SolidsAround) -> u32 {
        Self::solids(around).map(|leaf| self.rank(leaf)).max().unwrap_or(0)
    }

    /// Refractive index within these solids, at an [offset](pathmarch_scene::materials::dispersion::index_offset).
    pub(crate) fn index_within(&self, around: &SolidsAround, offset: f32) -> f32 {
        let rank = self.highest_rank(around);
        let filling = Self::solids(around).filter(|leaf| self.rank(*leaf) == rank);
        filling.map(|leaf| self.dielectric(leaf).index_at(offset)).product()
    }

    /// Sum of the media of the solids that fill the space, and of media without a surface.
    pub(super) fn medium_within(&self, around: SolidsAround) -> Medium {
        let rank = self.highest_rank(&around);
        let solids = Self::solids(&around).filter(|leaf| [rank, BOUNDARY_RANK].contains(&self.rank(*leaf)));
        let media = solids.map(|leaf| &self.media.of_materials[self.leaves[leaf].material as usize]);
        Medium { around, ..media.fold(Medium::default(), |sum, medium| sum.plus(medium)) }
    }

    /// Medium beyond a surface that a path crosses.
    pub(crate) fn medium_across(&self, medium: &Medium, leaf: usize, inside: bool) -> Medium {
        if self.dielectric(leaf).is_thin {
            return *medium;
        }
        let around = &medium.around;
        self.medium_within(if inside { self.without_solid(around, leaf) } else { self.with_solid(around, leaf) })
    }

    /// Reports whether the surface of a leaf is a false intersection: a solid of higher priority fills both its sides.
    pub(crate) fn is_skipped(&self, medium: &Medium, leaf: usize) -> bool {
        self.refracts(leaf)
            && !self.dielectric(leaf).is_thin
            && self.highest_rank(&self.without_solid(&medium.around, leaf)) > self.rank(leaf)
    }

    /// Refractive index of the solid of a leaf at its surface, relative to what is outside.
    pub(crate) fn index_at_surface(&self, medium: &Medium, leaf: usize, offset: f32) -> f32 {
        let (outside, dielectric) = (self.without_solid(&medium.around, leaf), self.dielectric(leaf));
        let index = dielectric.index_at(offset);
        let replaces = dielectric.is_thin || self.rank(leaf) > self.highest_rank(&outside);
        if replaces { index / self.index_within(&outside, offset) } else { index }
    }

    /// Reports whether the index at the surface of a leaf depends on the wavelength.
    pub(crate) fn disperses_at(&self, medium: &Medium, leaf: usize) -> bool {
        let disperses = |leaf: usize| self.dielectric(leaf).index_difference != 0.0;
        disperses(leaf) || Self::solids(&medium.around).any(disperses)
    }

    /// Reports whether a leaf is a surface that transmits.
    pub(crate) fn refracts(&self, leaf: usize) -> bool {
        let material = self.material_of(leaf);
        material.has(TRANSMITS) && !material.has(BOUNDARY)
    }
}
