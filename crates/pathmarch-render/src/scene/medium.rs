//! Participating media of a scene: those of its solids, the fog between them, and the medium around the camera.

use super::{RenderScene, flag_if};
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_scene::materials::{Dielectric, Material};
use pathmarch_scene::{Medium as SceneMedium, Scene};

/// Solids around a point: one more than the leaf of each, or 0.
pub(crate) type SolidsAround = [u32; MAX_SOLIDS];

/// A solid in the count of solids around a point.
const SOLID: u32 = 1;
/// A solid that displaces the fog, in the same count.
const DISPLACES: u32 = 1 << 16;

/// Medium, or the sum of the media of overlapping solids. Coefficients are per metre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Medium {
    pub(crate) absorption: Vec3,
    pub(crate) scattering: Vec3,
    /// Anisotropy times the mean of the channels of `scattering`. In a sum, the anisotropy is the mean of the media,
    /// weighted by their scattering.
    pub(crate) forward: f32,
    /// Emitted radiance, W/(m³ sr).
    pub(crate) emission: Vec3,
    /// Number of solids in the lower half, number of solids that displace the fog in the upper half.
    pub(crate) solids: u32,
    /// Those solids, in scenes with nested dielectrics.
    pub(crate) around: SolidsAround,
}

impl Medium {
    /// Number of words of [`words`](Self::words).
    pub(crate) const WORDS: usize = 11;

    fn new(medium: &SceneMedium) -> Self {
        let scattering = Vec3::from(medium.scattering);
        Self {
            absorption: Vec3::from(medium.absorption),
            scattering,
            forward: mean(scattering) * medium.anisotropy,
            emission: Vec3::from(medium.emission),
            solids: 0,
            around: SolidsAround::default(),
        }
    }

    /// Medium of the solids of a material. Surfaces displace the fog, boundaries of media do not.
    fn of_material(material: &Material) -> Self {
        if material.dielectric().is_thin {
            // A sheet has no inside.
            return Self::default();
        }
        let solids = SOLID + flag_if(DISPLACES, material.kind.has_surface);
        let medium = if material.transmits() { material.medium() } else { SceneMedium::VACUUM };
        Self { solids, ..Self::new(&medium) }
    }

    /// True if it changes any light.
    fn acts(&self) -> bool {
        [self.absorption, self.scattering, self.emission].iter().any(|channels| *channels != Vec3::ZERO)
    }

    /// Sum of two media.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            absorption: self.absorption + other.absorption,
            scattering: self.scattering + other.scattering,
            forward: self.forward + other.forward,
            emission: self.emission + other.emission,
            solids: self.solids + other.solids,
            around: self.around,
        }
    }

    /// Solids around a path after it crosses the surface of one. None are left when it has left all that it entered, so
    /// that rounding errors do not remain.
    #[inline]
    pub(crate) fn beyond(&self, solid: &Self, inside: bool) -> Self {
        if solid.solids == 0 {
            return *self;
        }
        if !inside {
            return self.plus(solid);
        }
        if self.solids & (DISPLACES - 1) <= SOLID {
            return Self::default();
        }
        let displacing = (self.solids / DISPLACES).saturating_sub(solid.solids / DISPLACES);
        Self {
            absorption: (self.absorption - solid.absorption).max(Vec3::ZERO),
            scattering: (self.scattering - solid.scattering).max(Vec3::ZERO),
            forward: self.forward - solid.forward,
            emission: (self.emission - solid.emission).max(Vec3::ZERO),
            solids: (self.solids & (DISPLACES - 1)) - SOLID + DISPLACES * displacing,
            around: self.around,
        }
    }

    /// True within solids that displace the fog.
    #[inline]
    pub(crate) fn is_displaced(&self) -> bool {
        self.solids >= DISPLACES
    }

    /// Medium around a path within these solids.
    #[inline]
    pub(crate) fn with_fog(&self, fog: &Self) -> Self {
        if self.is_displaced() { *self } else { self.plus(fog) }
    }

    /// Extinction coefficient: what is absorbed and what is scattered.
    #[inline]
    pub(crate) fn extinction(&self) -> Vec3 {
        self.absorption + self.scattering
    }

    #[inline]
    pub(crate) fn scatters(&self) -> bool {
        self.scattering != Vec3::ZERO
    }

    #[inline]
    pub(crate) fn emits(&self) -> bool {
        self.emission != Vec3::ZERO
    }

    /// Mean cosine of scattering angles.
    #[inline]
    pub(crate) fn anisotropy(&self) -> f32 {
        (self.forward / mean(self.scattering).max(1e-30)).clamp(-MAX_ANISOTROPY, MAX_ANISOTROPY)
    }

    /// Words for the kernel, which `stored_medium` of participating_media.wgsl reads.
    pub(crate) fn words(&self) -> [u32; Self::WORDS] {
        let [a, s, e] = [self.absorption, self.scattering, self.emission].map(|v| v.to_array().map(f32::to_bits));
        [a[0], a[1], a[2], s[0], s[1], s[2], e[0], e[1], e[2], self.forward.to_bits(), self.solids]
    }
}

crate::wgsl::shared_constants! {
    /// Largest number of solids that a path remembers in scenes with nested dielectrics.
    pub(crate) const MAX_SOLIDS: usize = 4;
    /// Largest absolute value of the anisotropy, for which the phase function is finite.
    const MAX_ANISOTROPY: f32 = 0.9999;
}

/// Mean of three channels.
fn mean(channels: Vec3) -> f32 {
    (channels.x + channels.y + channels.z) * (1.0 / 3.0)
}

/// Media of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Media {
    /// Medium between the solids.
    pub(crate) fog: Medium,
    /// Medium in the solids of each material.
    pub(crate) of_materials: Vec<Medium>,
    /// Dielectric in the solids of each material.
    pub(crate) dielectrics: Vec<Dielectric>,
}

impl Media {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            fog: Medium::new(&scene.fog),
            of_materials: scene.materials.iter().map(Medium::of_material).collect(),
            dielectrics: scene.materials.iter().map(Material::dielectric).collect(),
        }
    }

    /// True if some medium scatters or emits light, or is anywhere but in solids with a surface.
    pub(crate) fn participate(&self) -> bool {
        let more_than_absorbs = |medium: &Medium| medium.scatters() || medium.emits();
        let is_boundary = |medium: &Medium| medium.solids != 0 && !medium.is_displaced();
        self.fog.acts() || self.of_materials.iter().any(|medium| more_than_absorbs(medium) || is_boundary(medium))
    }

    /// True if some surface is a sheet of glass.
    pub(crate) fn has_thin_glass(&self) -> bool {
        self.dielectrics.iter().any(|dielectric| dielectric.is_thin)
    }
}

/// Sum of the media of the solids around a point.
pub(crate) fn medium_at(scene: &Scene, tables: &RenderScene, p: [f32; 3]) -> Medium {
    let p = pathmarch_field::number::Vec3::new(p[0], p[1], p[2]);
    let is_nested = tables.has_nested_dielectrics();
    if !is_nested
        && scene.materials.iter().all(|material| material.medium() == SceneMedium::VACUUM)
        && scene.fog == SceneMedium::VACUUM
    {
        return Medium::default();
    }
    let enclosing = scene.objects.iter().enumerate().filter(|(index, _)| scene.field.contains(*index, p));
    let leaves = enclosing.map(|(index, object)| {
        let object_field = Field::new(std::slice::from_ref(&object.root));
        let leaf = object_field.surface(p, 0).leaf as usize;
        (index, leaf, &scene.materials[object_field.leaves()[leaf].tag as usize])
    });
    // Opaque solids around a camera are rooms.
    let solids = leaves.filter(|(.., material)| material.transmits() && !material.dielectric().is_thin);
    if is_nested {
        let leaf_in_scene = |index: usize, leaf: usize| {
            let mut leaves = (0..).zip(scene.field.leaves()).filter(|(_, leaf)| leaf.object as usize == index);
            leaves.nth(leaf).map(|(leaf, _)| leaf)
        };
        let around = solids.filter_map(|(index, leaf, _)| leaf_in_scene(index, leaf));
        return tables.medium_within(around.fold(SolidsAround::default(), |all, leaf| tables.with_solid(&all, leaf)));
    }
    let media = solids.map(|(.., material)| Medium::of_material(material));
    media.fold(Medium::default(), |sum, medium| sum.plus(&medium))
}
