//! Photon map: photons in a hash table of cells, and the light that a surface reflects of the photons around it.
//!
//! A photon is spread over a disc with Epanechnikov's kernel. The radius depends on the position of the photon, a few
//! pixels as seen from the camera, so that each photon keeps its power. Cells are a power of two, two to four radii
//! wide: a surface visits those around it, of one size, or of two where the size changes. In a cell with many photons,
//! every n-th is visited, from a random one on, and counts n times.
//!
//! A small bright caustic that indirect light finds by chance is noise. So indirect light uses a grid with larger discs
//! of fewer photons where a disc is smaller than the area over which the scattered ray spreads. The hash table has a
//! slot for each cell that is not empty, found by linear probing.

use super::FrameUniforms;
use crate::sampling::sobol::hash;
use crate::wgsl::shared_constants;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

shared_constants! {
    /// Largest number of photons that are visited in a cell.
    const MAX_VISITS: u32 = 128;
    /// Least cosine between the normals of a photon and of the surface that it lights.
    const LEAST_NORMAL_COSINE: f32 = 0.7;
    /// Least cosine of the angle of incidence of a photon, as a divisor.
    const LEAST_INCIDENCE: f32 = 1e-3;
    /// Headers of an encoded map: that of the sharp grid and that of the blurred one.
    const PHOTON_HEADERS: u32 = 2;
    /// Vectors of an encoded photon.
    const PHOTON_VECTORS: u32 = 2;
    /// Largest code of a component of an encoded direction.
    const DIRECTION_CODES: f32 = 4095.0;
    /// Largest code of a component of an encoded normal.
    const NORMAL_CODES: f32 = 255.0;
}

/// Largest number of focusing surfaces on the way of a photon: four bits of its code.
pub(crate) const MAX_FOCUSING: u32 = 15;
/// Radius of a photon in the first sample, in pixels.
const FIRST_RADIUS: f32 = 2.5;
/// Smallest radius, in pixels.
const LAST_RADIUS: f32 = 0.5;
/// Exponent with which the radius falls with the sample: half of 1 - 2/3 (Knaus and Zwicker 2011, section 5).
const RADIUS_EXPONENT: f32 = -1.0 / 6.0;
/// Smallest radius, in rounding errors of the position.
const SMALLEST_RADIUS: f32 = 16.0;
/// Radius of photons for indirect light, in radii of others. One in the square of this number is used.
const BLUR: u32 = 8;
/// Largest radius, in distances from the camera.
const LARGEST_RADIUS: f32 = 0.25;

/// Photon: power that arrives at a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Photon {
    p: Vec3,
    /// Power, W.
    power: Vec3,
    /// Unit vector to where the light comes from, see [`encode_direction`].
    direction: u32,
    /// Unit geometric normal on that side, encoded.
    normal: u32,
    /// Number of focusing surfaces on its way.
    focusing: u32,
}

/// Unit vector as two integers up to `codes`: an octahedron, unfolded (Meyer et al. 2010, "On Floating-Point Normal
/// Vectors").
fn encode_direction(v: Vec3, codes: f32) -> u32 {
    let scaled = v / (v.x.abs() + v.y.abs() + v.z.abs());
    let (mut x, mut y) = (scaled.x, scaled.y);
    if scaled.z < 0.0 {
        (x, y) = ((1.0 - scaled.y.abs()).copysign(scaled.x), (1.0 - scaled.x.abs()).copysign(scaled.y));
    }
    let code = |v: f32| ((v * 0.5 + 0.5) * codes).round() as u32;
    code(x) + code(y) * (codes as u32 + 1)
}

fn decode_direction(code: u32, codes: f32) -> Vec3 {
    let radix = codes as u32 + 1;
    let component = |code: u32| code as f32 / codes * 2.0 - 1.0;
    let (x, y) = (component(code % radix), component(code / radix));
    let z = 1.0 - x.abs() - y.abs();
    let folded = (-z).max(0.0);
    Vec3::new(x - folded.copysign(x), y - folded.copysign(y), z).normalize()
}

impl Photon {
    pub(crate) fn new(p: Vec3, direction: Vec3, normal: Vec3, power: Vec3, focusing: u32) -> Self {
        let (direction, normal) =
            (encode_direction(direction, DIRECTION_CODES), encode_direction(normal, NORMAL_CODES));
        Self { p, power, direction, normal, focusing }
    }
}

/// Cell of the hash table.
#[derive(Clone, Copy, PartialEq)]
struct Cell {
    place: IVec3,
    /// Binary logarithm of its size in metres.
    level: i32,
}

impl Cell {
    fn of(p: Vec3, level: i32) -> Self {
        Self { place: (p * (-level as f32).exp2()).floor().as_ivec3(), level }
    }

    /// First slot in the table, before the mask, and key of 24 bits.
    fn hash(&self) -> (u32, u32) {
        let [x, y, z] = self.place.to_array().map(|v| v as u32);
        let first = hash(x ^ hash(y ^ hash(z ^ (self.level as u32).wrapping_mul(0x9e37_79b9))));
        (first, hash(first ^ x) >> 8)
    }
}

/// Level of the smallest cells that are wider than two radii.
fn level_of(radius: f32) -> i32 {
    ((2.0 * radius).to_bits() >> 23) as i32 - 126
}

/// Photons of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// Index of the first photon.
    first: u32,
    /// Number of photons; 0 for an empty slot.
    count: u32,
    /// Key of the cell.
    key: u32,
}

/// Index of the first slot from that of a hash on for which `found` is true, by linear probing.
fn probe(slots: &[Slot], hash: u32, found: impl Fn(&Slot) -> bool) -> usize {
    let mask = slots.len() - 1;
    let mut index = hash as usize & mask;
    while !found(&slots[index]) {
        index = (index + 1) & mask;
    }
    index
}

/// Photons in the cells of a hash table.
#[derive(Clone, Debug)]
struct PhotonGrid {
    /// Photons, cell by cell.
    photons: Vec<Photon>,
    /// Hash table of the cells; its length is a power of two.
    slots: Vec<Slot>,
    camera: Vec3,
    /// Radius of a photon divided by its distance from the camera.
    radius_scale: f32,
    /// Smallest radius divided by the largest coordinate.
    rounding: f32,
}

/// Surface that photons light.
pub(crate) struct LitSurface {
    pub(crate) p: Vec3,
    /// Unit geometric normal on the side of the viewer.
    pub(crate) normal: Vec3,
    pub(crate) transmits: bool,
    /// Area from which the surface is seen indirectly, square metres, up to a factor: the square of the distance of the
    /// last surface that is not focusing, divided by the pdf of the direction from there; 0 if it is seen directly,
    /// infinite over focusing surfaces.
    pub(crate) footprint: f32,
    /// Largest number of focusing surfaces on the way of the photons.
    pub(crate) max_focusing: u32,
    /// Seed of the choice among many photons.
    pub(crate) seed: u32,
}

impl PhotonGrid {
    /// Grid of photons whose radius is this number of pixels.
    fn new(frame: &FrameUniforms, photons: Vec<Photon>, radius: f32) -> Self {
        let mut map = Self {
            photons: Vec::new(),
            slots: Vec::new(),
            camera: frame.position.into(),
            radius_scale: (radius * frame.pixel).min(LARGEST_RADIUS),
            rounding: SMALLEST_RADIUS * frame.rounding,
        };
        let mut keyed: Vec<((u32, u32), Photon)> =
            photons.into_iter().map(|photon| (map.cell_of(&photon).hash(), photon)).collect();
        // A stable sort: photons of a cell keep the order of their paths.
        keyed.par_sort_by_key(|(hash, _)| *hash);
        let cells = keyed.chunk_by(|(a, _), (b, _)| a == b);
        let mut slots = vec![Slot::default(); Self::slot_count(keyed.len() as u32) as usize];
        let mut first = 0;
        for cell in cells {
            let (hash, key) = cell[0].0;
            let index = probe(&slots, hash, |slot| slot.count == 0);
            slots[index] = Slot { first, count: cell.len() as u32, key };
            first += cell.len() as u32;
        }
        (map.photons, map.slots) = (keyed.into_iter().map(|(_, photon)| photon).collect(), slots);
        map
    }

    /// Length of the table for a number of photons: at least half of it is empty.
    fn slot_count(photons: u32) -> u32 {
        (2 * photons).next_power_of_two().max(2)
    }

    /// Photons of a cell.
    fn photons_of(&self, cell: Cell) -> &[Photon] {
        let (hash, key) = cell.hash();
        let Slot { first, count, .. } = self.slots[probe(&self.slots, hash, |slot| slot.count == 0 || slot.key == key)];
        &self.photons[first as usize..][..count as usize]
    }

    /// Radius of a photon at `p`, metres.
    fn radius_at(&self, p: Vec3) -> f32 {
        (self.radius_scale * p.distance(self.camera)).max(self.rounding * p.abs().max_element())
    }

    fn cell_of(&self, photon: &Photon) -> Cell {
        Cell::of(photon.p, level_of(self.radius_at(photon.p)))
    }

    /// Radiance that a surface reflects of the photons around it. `reflect` returns the value of the BSDF times the
    /// cosine for a direction to a light, and zero where none arrives.
    fn reflected(&self, surface: &LitSurface, reflect: impl Fn(Vec3) -> Vec3) -> Vec3 {
        let p = surface.p;
        let radius = self.radius_at(p);
        // Radii of photons around differ by less.
        let margin = 1.0 + 1.5 * self.radius_scale;
        let largest = radius * margin;
        let mut sum = Vec3::ZERO;
        for level in level_of(radius / margin)..=level_of(largest) {
            let (low, high) = (Cell::of(p - largest, level).place, Cell::of(p + largest, level).place);
            for z in low.z..=high.z {
                for y in low.y..=high.y {
                    for x in low.x..=high.x {
                        let cell = Cell { place: IVec3::new(x, y, z), level };
                        sum += self.reflected_of(cell, surface, &reflect);
                    }
                }
            }
        }
        sum
    }

    /// The same of the photons of one cell.
    fn reflected_of(&self, cell: Cell, surface: &LitSurface, reflect: impl Fn(Vec3) -> Vec3) -> Vec3 {
        let normal = surface.normal;
        let photons = self.photons_of(cell);
        let stride = (photons.len() as u32).div_ceil(MAX_VISITS).max(1);
        let first = hash(surface.seed ^ cell.hash().0) % stride;
        let mut sum = Vec3::ZERO;
        for photon in photons.iter().skip(first as usize).step_by(stride as usize) {
            let offset = photon.p - surface.p;
            let radius = self.radius_at(photon.p);
            let height = offset.dot(normal);
            let share = (offset.length_squared() - height * height) / (radius * radius);
            if share >= 1.0 || height.abs() > radius || photon.focusing > surface.max_focusing {
                continue;
            }
            let alignment = decode_direction(photon.normal, NORMAL_CODES).dot(normal);
            if alignment.abs() < LEAST_NORMAL_COSINE || (alignment < 0.0 && !surface.transmits) {
                continue;
            }
            let direction = decode_direction(photon.direction, DIRECTION_CODES);
            let incidence = direction.dot(normal).abs().max(LEAST_INCIDENCE);
            let kernel = 2.0 * (1.0 - share.max(0.0)) / (std::f32::consts::PI * radius * radius);
            sum += reflect(direction) * photon.power * (kernel / incidence);
        }
        sum * stride as f32
    }

    /// Appends the header to `headers`, and slots and photons to `vectors`.
    fn encode(&self, headers: &mut Vec<[f32; 4]>, vectors: &mut Vec<[f32; 4]>) {
        // All integers are below 2^24, so that they are exact; a slot without photons is empty.
        let first_slot = PHOTON_HEADERS as usize + vectors.len();
        headers.push([self.radius_scale, self.rounding, self.slots.len() as f32, first_slot as f32]);
        vectors.extend(self.slots.iter().map(|slot| [slot.first as f32, slot.count as f32, slot.key as f32, 0.0]));
        for photon in &self.photons {
            let normal = photon.normal + (photon.focusing << 16);
            vectors.push([photon.p.x, photon.p.y, photon.p.z, photon.direction as f32]);
            vectors.push([photon.power.x, photon.power.y, photon.power.z, normal as f32]);
        }
    }
}

/// Photons of one sample.
#[derive(Clone, Debug)]
pub(crate) struct PhotonMap {
    /// All photons, for surfaces that are seen directly, in mirrors and through glass.
    sharp: PhotonGrid,
    /// A share of them with larger radii, for indirect light.
    blurred: PhotonGrid,
}

impl PhotonMap {
    /// Map of the photons of a sample, in the order of their paths.
    pub(crate) fn new(frame: &FrameUniforms, photons: Vec<Photon>, sample: u32) -> Self {
        let falloff = (sample as f32 + 1.0).powf(RADIUS_EXPONENT);
        let radius = (FIRST_RADIUS * falloff).max(LAST_RADIUS);
        let share = (BLUR * BLUR) as usize;
        let first = hash(frame.seed ^ hash(sample)) as usize % share;
        let blurred = photons.iter().skip(first).step_by(share);
        let blurred = blurred.map(|photon| Photon { power: photon.power * share as f32, ..*photon }).collect();
        Self {
            blurred: PhotonGrid::new(frame, blurred, radius * BLUR as f32),
            sharp: PhotonGrid::new(frame, photons, radius),
        }
    }

    /// Radiance that a surface reflects of the photons around it. `reflect` returns the value of the BSDF times the
    /// cosine for a direction to a light, and zero where none arrives.
    pub(crate) fn reflected(&self, surface: &LitSurface, reflect: impl Fn(Vec3) -> Vec3) -> Vec3 {
        let radius = self.blurred.radius_at(surface.p);
        let grid = if surface.footprint > radius * radius { &self.blurred } else { &self.sharp };
        grid.reflected(surface, reflect)
    }

    /// Largest number of vectors of an encoded map of at most `photons` photons.
    pub(crate) fn encoded_length(photons: u32) -> usize {
        let vectors = |photons| (PhotonGrid::slot_count(photons) + PHOTON_VECTORS * photons) as usize;
        PHOTON_HEADERS as usize + vectors(photons) + vectors(photons.div_ceil(BLUR * BLUR))
    }

    /// Vectors for the kernel: the headers, and slots and photons of both grids.
    pub(crate) fn encoded(&self) -> Vec<[f32; 4]> {
        let (mut headers, mut vectors) = (Vec::new(), Vec::new());
        for grid in [&self.sharp, &self.blurred] {
            grid.encode(&mut headers, &mut vectors);
        }
        headers.extend(vectors);
        headers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_survive_their_encoding() {
        for k in 0..2000u32 {
            let number = |n: u32| hash(3 * k + n) as f32 / u32::MAX as f32 - 0.5;
            let v = Vec3::new(number(0), number(1), number(2)).normalize();
            let decoded = |codes| decode_direction(encode_direction(v, codes), codes);
            assert!(decoded(DIRECTION_CODES).dot(v) > 1.0 - 1e-6, "{v}");
            assert!(decoded(NORMAL_CODES).dot(v) > 1.0 - 2e-4, "{v}");
        }
        for axis in [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            assert!(decode_direction(encode_direction(axis, DIRECTION_CODES), DIRECTION_CODES).dot(axis) > 1.0 - 1e-6);
        }
    }

    #[test]
    fn cells_are_two_to_four_radii_wide() {
        for radius in [1e-5, 0.003, 0.124_999, 0.125, 0.25, 7.0] {
            let size = (level_of(radius) as f32).exp2();
            assert!(size > 2.0 * radius && size <= 4.0 * radius, "{radius} {size}");
        }
    }
}
