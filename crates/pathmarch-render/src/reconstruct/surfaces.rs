//! Surfaces that the pixels of a picture show, in planes.

use super::planes::{Grid, Place, Planes};
use crate::integrator::first_mirror::FirstMirror;
use crate::integrator::guides::{Guide, GuideClass};
#[cfg(doc)]
use crate::integrator::medium_light::MEDIUM_ALPHA;
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use std::sync::atomic::{AtomicBool, Ordering};
use wide::f32x8;

shared_constants! {
    /// Least cosine between the normals of pixels beside each other on a smooth surface.
    const MIN_SMOOTH_COSINE: f32 = 0.9;
    /// Least number of such pixels beside one that is on a smooth surface.
    const SMOOTH_NEIGHBOURS: u32 = 2;
    /// Least cosine between normals of one surface.
    pub(super) const MIN_NORMAL_COSINE: f32 = 0.8;
    /// Least cosine between the normals of pixels of one face of a mirror.
    const MIN_MIRROR_COSINE: f32 = 0.9;
}

/// Offsets to the pixels beside one.
const BESIDE: [(i32, i32); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// Vectors of eight pixels.
pub(super) type Vectors = FieldVec3<f32x8>;

/// Surface of pixels that are not filtered, and of those beyond the picture.
const NONE: f32 = -1.0;

/// Number of planes.
const PLANES: usize = 11;

/// Surfaces of all pixels of a picture.
pub(super) struct SurfacePlanes {
    pub(super) grid: Grid,
    /// Side of a pixel at distance one, metres.
    pixel: f32,
    planes: Planes<PLANES>,
    /// Normals of what is seen through glass, if there is any.
    seen_normals: Option<Planes<3>>,
    /// Alphas of light that is recorded apart, if there is any.
    alphas: Option<Planes<1>>,
    /// Mirrors that the camera sees, if there are any.
    pub(super) mirrors: Option<MirrorPlanes>,
    /// True if other surfaces have scattered light to some of them.
    pub(super) have_indirect_light: bool,
}

/// Distances of mirrors from the camera in metres, 0 without one, and their normals.
pub(super) struct MirrorPlanes(Planes<4>);

/// Mirrors of eight pixels.
pub(super) struct Mirrors {
    /// Distances from the camera, metres; 0 without a mirror.
    pub(super) distance: f32x8,
    normal: Vectors,
}

impl MirrorPlanes {
    #[inline(always)]
    pub(super) fn at(&self, place: Place) -> Mirrors {
        let [distance, x, y, z] = std::array::from_fn(|k| self.0.load(k, place));
        Mirrors { distance, normal: Vectors::new(x, y, z) }
    }
}

impl Mirrors {
    #[inline(always)]
    pub(super) fn are_mirrors(&self) -> f32x8 {
        self.distance.simd_gt(f32x8::ZERO)
    }

    /// Mask of the pixels where one is a mirror and the other is none, or where they are different faces of mirrors.
    #[inline(always)]
    pub(super) fn differ(&self, other: &Self) -> f32x8 {
        let (a, b) = (self.are_mirrors(), other.are_mirrors());
        (a ^ b) | (a & b & self.normal.dot(other.normal).simd_lt(f32x8::splat(MIN_MIRROR_COSINE)))
    }
}

/// Surfaces of eight adjoining pixels, as filters compare them.
pub(super) struct Surfaces {
    pub(super) position: Vectors,
    /// Sides of a pixel at their distances, metres.
    pub(super) pixel: f32x8,
    pub(super) normal: Vectors,
    pub(super) seen_normal: Vectors,
    /// Equal on pixels that may share their light; below 0 for those without noise.
    pub(super) filtered: f32x8,
}

/// Points that eight pixels show.
pub(super) struct Points {
    pub(super) position: Vectors,
    /// Distances from the camera, metres.
    pub(super) length: f32x8,
    pub(super) normal: Vectors,
    /// See [`surface_of`].
    pub(super) surface: f32x8,
}

impl Points {
    /// Largest squared difference between directions to one point of the sky; below 0 for surfaces. In mirrors, the difference
    /// is at most `mirrored`: what curved ones show of the sky moves over them.
    #[inline(always)]
    pub(super) fn sky_tolerance(&self, mirrored: f32) -> f32x8 {
        let part = ((self.surface - f32x8::ONE) * 0.5).floor();
        let mirrored = f32x8::splat(mirrored * mirrored);
        let tolerance =
            part.simd_eq(f32x8::splat(part_of(&Guide::NONE) as f32)).select(f32x8::splat(f32::MAX), mirrored);
        are_of(part, GuideClass::Sky).select(tolerance, f32x8::splat(-1.0))
    }
}

/// Surface of a guide, as a number from 1 on that is equal on points of one surface: a medium in front of it takes light from
/// it. It is no integer, which vector instructions would read as a subnormal number, and be slow.
fn surface_of(guide: &Guide) -> f32 {
    (2 * part_of(guide) + u32::from(guide.has_medium()) + 1) as f32
}

/// Object and class of a guide, as a number.
fn part_of(guide: &Guide) -> u32 {
    4 * guide.object + guide.class as u32
}

impl SurfacePlanes {
    /// Surfaces of the guides of a frame; `settles` if its film has samples enough to show edges.
    pub(super) fn new(frame: &FrameUniforms, guides: &[Guide], settles: bool) -> Self {
        let grid = Grid::new(frame.size());
        let mut margin = [0.0; PLANES];
        (margin[7], margin[8]) = (NONE, NONE);
        let [has_glass, has_layers, has_indirect_light, has_mirrors] = [const { AtomicBool::new(false) }; 4];
        let planes = Planes::new(grid, margin, |index| {
            let guide = &guides[index];
            if guide.class == GuideClass::Glass {
                has_glass.store(true, Ordering::Relaxed);
            }
            if guide.has_layer() {
                has_layers.store(true, Ordering::Relaxed);
            }
            if guide.indirect != Vec3::ZERO {
                has_indirect_light.store(true, Ordering::Relaxed);
            }
            if guide.mirror != FirstMirror::NONE {
                has_mirrors.store(true, Ordering::Relaxed);
            }
            let behind_medium = u32::from(guide.has_medium());
            let filtered = match guide.class {
                GuideClass::Sky | GuideClass::Emitter => NONE,
                // The mean of several surfaces is that of none.
                _ if settles && guide.is_mixed => NONE,
                GuideClass::Surface => (4 * guide.object + behind_medium) as f32,
                // Pixels of glass share light if they show one object.
                GuideClass::Glass => (4 * guide.seen_object + 2 + behind_medium) as f32,
            };
            let ([px, py, pz], [nx, ny, nz]) = (guide.position.to_array(), guide.normal.to_array());
            let (length, part) = (guide.length, part_of(guide) as f32);
            let surface = if guide.is_mixed { -surface_of(guide) } else { surface_of(guide) };
            let glossy = f32::from(guide.is_glossy && !guide.has_facets());
            [px, py, pz, length, nx, ny, nz, filtered, part, surface, glossy]
        });
        let seen_normals = || Planes::new(grid, [0.0; 3], |index| guides[index].seen_normal.to_array());
        let alphas = || Planes::new(grid, [0.0], |index| [guides[index].reflected.alpha]);
        let mirrors = || {
            MirrorPlanes(Planes::new(grid, [0.0; 4], |index| {
                let mirror = guides[index].mirror;
                let [x, y, z] = mirror.normal().to_array();
                [mirror.distance(), x, y, z]
            }))
        };
        Self {
            grid,
            pixel: frame.pixel,
            planes,
            seen_normals: has_glass.into_inner().then(seen_normals),
            alphas: has_layers.into_inner().then(alphas),
            mirrors: has_mirrors.into_inner().then(mirrors),
            have_indirect_light: has_indirect_light.into_inner(),
        }
    }

    /// True if light of some pixel is recorded apart.
    pub(super) fn have_layers(&self) -> bool {
        self.alphas.is_some()
    }

    #[inline(always)]
    fn vectors(&self, first: usize, place: Place) -> Vectors {
        let [x, y, z] = [first, first + 1, first + 2].map(|k| self.planes.load(k, place));
        Vectors::new(x, y, z)
    }

    #[inline(always)]
    pub(super) fn position(&self, place: Place) -> Vectors {
        self.vectors(0, place)
    }

    /// Distances from the camera, metres.
    #[inline(always)]
    pub(super) fn length(&self, place: Place) -> f32x8 {
        self.planes.load(3, place)
    }

    /// Sides of a pixel at these distances, metres.
    #[inline(always)]
    pub(super) fn pixel(&self, place: Place) -> f32x8 {
        self.length(place) * self.pixel
    }

    #[inline(always)]
    pub(super) fn points(&self, place: Place) -> Points {
        let (position, normal, surface) = (self.position(place), self.normal(place), self.surface(place).abs());
        Points { position, length: self.length(place), normal, surface }
    }

    #[inline(always)]
    pub(super) fn normal(&self, place: Place) -> Vectors {
        self.vectors(4, place)
    }

    /// Normals of what is seen through glass.
    #[inline(always)]
    pub(super) fn seen_normal(&self, place: Place) -> Vectors {
        match &self.seen_normals {
            Some(normals) => Vectors::new(normals.load(0, place), normals.load(1, place), normals.load(2, place)),
            None => self.normal(place),
        }
    }

    /// Objects and classes, as a number; below 0 beyond the picture.
    #[inline(always)]
    pub(super) fn part(&self, place: Place) -> f32x8 {
        self.planes.load(8, place)
    }

    /// See [`surface_of`]; negative where a pixel shows several surfaces, 0 beyond the picture.
    #[inline(always)]
    pub(super) fn surface(&self, place: Place) -> f32x8 {
        self.planes.load(9, place)
    }

    /// Mask of the pixels that look different from other directions and have no facets apart.
    #[inline(always)]
    pub(super) fn are_glossy(&self, place: Place) -> f32x8 {
        self.planes.load(10, place).simd_gt(f32x8::ZERO)
    }

    /// Alphas of facets, 0 of pixels without light apart, [`MEDIUM_ALPHA`] of those behind media.
    #[inline(always)]
    pub(super) fn alpha(&self, place: Place) -> f32x8 {
        self.alphas.as_ref().map_or(f32x8::ZERO, |alphas| alphas.load(0, place))
    }

    #[inline(always)]
    pub(super) fn at(&self, place: Place) -> Surfaces {
        Surfaces {
            position: self.position(place),
            pixel: self.pixel(place),
            normal: self.normal(place),
            seen_normal: self.seen_normal(place),
            filtered: self.planes.load(7, place),
        }
    }

    /// Mask of the pixels that show one side of an object at both places: their normals differ by at most the angle of this cosine.
    #[inline(always)]
    pub(super) fn show_one_side(&self, here: Place, there: Place, min_cosine: f32) -> f32x8 {
        let cosine = self.normal(here).dot(self.normal(there));
        self.part(here).simd_eq(self.part(there)) & cosine.simd_ge(f32x8::splat(min_cosine))
    }

    /// Calls a function with the places beside one and the masks of the pixels there that are parts of one smooth surface; gives
    /// the mask of the pixels that show such a surface.
    #[inline(always)]
    pub(super) fn smooth_neighbours(&self, place: Place, mut visit: impl FnMut(Place, f32x8)) -> f32x8 {
        let mut count = f32x8::ZERO;
        for (dx, dy) in BESIDE {
            let Some(there) = place.moved(self.grid, dx, dy) else { continue };
            let are_smooth = self.show_one_side(place, there, MIN_SMOOTH_COSINE);
            count += are_smooth & f32x8::ONE;
            visit(there, are_smooth);
        }
        count.simd_ge(f32x8::splat(SMOOTH_NEIGHBOURS as f32))
    }
}

/// Class of parts, see [`SurfacePlanes::part`].
#[inline(always)]
pub(super) fn class_of(part: f32x8) -> f32x8 {
    part - (part * 0.25).floor() * 4.0
}

/// Mask of the parts of a class.
#[inline(always)]
pub(super) fn are_of(part: f32x8, class: GuideClass) -> f32x8 {
    class_of(part).simd_eq(f32x8::splat(class as u32 as f32))
}
