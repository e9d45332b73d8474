//! Mirrors that the camera sees, in one word for each pixel.
//!
//! **Idea.** The guide of a mirror is a point of its image. The edges of the mirror itself move with its surface, so that the
//! distance of that is recorded, too, and its normal, which tells one face of a mirror from another.

use crate::wgsl::shared_constants;
use glam::Vec3;

shared_constants! {
    /// Bit of the word of a mirror, in whose place others are those of a leaf.
    pub(crate) const MIRROR_BIT: u32 = 1 << 31;
    /// Bits of a distance as a float that the word leaves out.
    const DISTANCE_SHIFT: u32 = 12;
    /// Bits of each of the two numbers of a normal.
    const NORMAL_BITS: u32 = 6;
}

/// Bits of the distance in a word, before the normal.
const DISTANCE_MASK: u32 = !MIRROR_BIT & !((1 << DISTANCE_SHIFT) - 1);

/// First surface of a camera ray, if it is a mirror: its distance and its normal, rounded to one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FirstMirror(u32);

impl FirstMirror {
    /// No mirror.
    pub(crate) const NONE: Self = Self(MIRROR_BIT);

    /// Mirror at a distance from the camera in metres, with this unit normal.
    pub(crate) fn new(distance: f32, normal: Vec3) -> Self {
        let most = ((1 << NORMAL_BITS) - 1) as f32;
        let [u, v] = octahedral(normal).map(|number| ((0.5 * number + 0.5) * most + 0.5) as u32);
        Self(MIRROR_BIT | (distance.to_bits() >> DISTANCE_SHIFT << DISTANCE_SHIFT) | u << NORMAL_BITS | v)
    }

    /// Distance from the camera, metres; 0 if there is no mirror.
    pub(crate) fn distance(self) -> f32 {
        f32::from_bits(self.0 & DISTANCE_MASK)
    }

    /// Unit normal, to within five degrees.
    pub(crate) fn normal(self) -> Vec3 {
        let most = (1 << NORMAL_BITS) - 1;
        from_octahedral([self.0 >> NORMAL_BITS, self.0].map(|number| (number & most) as f32 / most as f32 * 2.0 - 1.0))
    }
}

/// Unit vector in two numbers from -1 to 1: an octahedral map (Meyer et al. 2010).
fn octahedral(v: Vec3) -> [f32; 2] {
    let v = v / (v.x.abs() + v.y.abs() + v.z.abs());
    match v.z < 0.0 {
        true => [(1.0 - v.y.abs()).copysign(v.x), (1.0 - v.x.abs()).copysign(v.y)],
        false => [v.x, v.y],
    }
}

/// Inverse of [`octahedral`].
fn from_octahedral([x, y]: [f32; 2]) -> Vec3 {
    let z = 1.0 - x.abs() - y.abs();
    let overhang = f32::max(-z, 0.0);
    Vec3::new(x - overhang.copysign(x), y - overhang.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_keep_distances_and_normals() {
        assert_eq!(FirstMirror::NONE.distance(), 0.0);
        for distance in [1e-3, 0.7, 3.0, 1e5] {
            for normal in
                [Vec3::X, -Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.6, -0.48, -0.64), Vec3::splat(-0.57735)]
            {
                let mirror = FirstMirror::new(distance, normal);
                let error = mirror.distance() / distance - 1.0;
                assert!((-5e-4..=0.0).contains(&error), "{error} at {distance}");
                assert!(mirror.normal().dot(normal) > 5f32.to_radians().cos(), "{} for {normal}", mirror.normal());
            }
        }
    }
}
