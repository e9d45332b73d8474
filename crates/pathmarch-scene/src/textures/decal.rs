//! Decals: pictures that are projected once onto a surface, over its colour.
//!
//! The picture lies in the plane z = 0 of the decal's coordinates, its middle at the origin, its right along +x and its
//! top along +y. It is projected along z, like a slide, onto surfaces that are near enough and face +z enough. Elsewhere,
//! and where its alpha is 0, the colour below remains (Porter and Duff 1984, "Compositing Digital Images": over).
//!
//! **Filter.** That of `picture.rs`, of colours times alpha, so that transparent texels have no colour.

use super::{Picture, Spot, placed};
use glam::{Vec2, Vec3, Vec4};
use pathmarch_field::graph::Pose;
use std::sync::Arc;

/// Coordinates in which a decal is placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DecalSpace {
    /// Those of each shape that has the material.
    #[default]
    Shape,
    /// Those of the scene.
    World,
}

/// Picture that is projected once.
#[derive(Clone, Debug)]
pub struct Decal {
    /// Its texels, with alpha.
    pub picture: Arc<Picture>,
    /// Its width, in the coordinates of the decal.
    pub size: f32,
    /// Extent of the projection along z, half of it on each side of the picture.
    pub depth: f32,
    /// Smallest cosine of the angle between the normal of a surface and +z.
    pub min_cosine: f32,
    /// Factor of the picture's alpha.
    pub opacity: f32,
    /// Pose of its coordinates.
    pub pose: Pose,
    /// Coordinates in which it is placed.
    pub space: DecalSpace,
}

impl Decal {
    /// Colour times alpha, and alpha, at a spot in the coordinates of [`Self::space`].
    pub fn texel(&self, spot: &Spot) -> Vec4 {
        let spot = placed(&self.pose, spot);
        let Picture { width, height, .. } = *self.picture;
        let scale = Vec2::new(1.0, width as f32 / height as f32) / self.size;
        let place = spot.p.truncate() * scale + 0.5;
        let is_outside = place.min_element() < 0.0 || place.max_element() > 1.0;
        if is_outside || spot.p.z.abs() > 0.5 * self.depth || spot.normal.z <= self.min_cosine {
            return Vec4::ZERO;
        }
        self.picture.filtered_with_alpha(spot.footprint * width as f32 / self.size, place) * self.opacity
    }

    /// The decal over a colour, at a spot in the coordinates of [`Self::space`].
    pub fn over(&self, below: Vec3, spot: &Spot) -> Vec3 {
        let texel = self.texel(spot);
        below * (1.0 - texel.w) + texel.truncate()
    }
}
