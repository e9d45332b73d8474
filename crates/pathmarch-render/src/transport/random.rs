//! Random numbers: Owen-scrambled Sobol' points, two dimensions at a time.
//!
//! Idea: every pair of dimensions of a path draws from the two-dimensional Sobol' sequence, its index shuffled and its
//! coordinates Owen-scrambled by hashes of (pixel, seed, pair), so that each pair is stratified over the samples of a
//! pixel and independent of the others (Burley 2020, "Practical Hash-based Owen Scrambling"; the hash after Laine and
//! Karras 2011 with Vegdahl's constants, 2021). The second Sobol' dimension is the Pascal matrix modulo two, applied in
//! five steps (Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact"). A number is a
//! pure function of (seed, pixel, sample, pair). Cost: about 60 integer operations a pair, no memory.

/// The pairs of dimensions a path uses, in order.
pub(crate) mod pair {
    /// Position within the pixel.
    pub(crate) const PIXEL: u32 = 0;
    /// Position on the lens.
    pub(crate) const LENS: u32 = 1;
    /// First pair of the first surface; each surface has [`PER_SURFACE`].
    pub(crate) const SURFACE: u32 = 2;
    /// Direction of the scattered ray.
    pub(crate) const SCATTER: u32 = 0;
    /// Choice of the light (x) and of going on (y).
    pub(crate) const CHOICE: u32 = 1;
    /// Position on the light.
    pub(crate) const LIGHT: u32 = 2;
    /// Choice of the lobe (x).
    pub(crate) const LOBE: u32 = 3;
    /// Pairs of a surface.
    pub(crate) const PER_SURFACE: u32 = 4;
}

/// A well-mixed word of a word (PCG output permutation; Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
pub(crate) fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Owen scrambling of the reversed bits `x`: every bit is flipped by a hash of the bits below it.
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// A uniform number in 0..1 of the high 24 bits.
pub(crate) fn unit(x: u32) -> f32 {
    (x >> 8) as f32 / 16_777_216.0
}

/// The random numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Random {
    base: u32,
    sample: u32,
}

impl Random {
    /// Of sample `sample` of the pixel (`x`, `y`) under `seed`.
    pub(crate) fn new(x: u32, y: u32, sample: u32, seed: u32) -> Self {
        Self { base: hash(x ^ hash(y ^ hash(seed))), sample }
    }

    /// The point of a pair of dimensions, uniform in the unit square.
    pub(crate) fn pair(self, pair: u32) -> [f32; 2] {
        let seed = hash(self.base ^ pair.wrapping_mul(0x9e37_79b9));
        let index = scramble_reversed(self.sample.reverse_bits(), seed).reverse_bits();
        let mut second = index;
        second ^= (second >> 1) & 0x5555_5555;
        second ^= (second >> 2) & 0x3333_3333;
        second ^= (second >> 4) & 0x0f0f_0f0f;
        second ^= (second >> 8) & 0x00ff_00ff;
        second ^= (second >> 16) & 0x0000_ffff;
        let x = scramble_reversed(index, hash(seed ^ 0x68bc_21eb)).reverse_bits();
        let y = scramble_reversed(second, hash(seed ^ 0x02e5_be93)).reverse_bits();
        [unit(x), unit(y)]
    }

    /// A seed for choices that need no stratification, different for each surface of the path.
    pub(crate) fn loose(self, surface: u32) -> u32 {
        hash(self.base ^ hash(self.sample ^ surface.wrapping_mul(0x85eb_ca6b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_stratified_in_every_elementary_interval() {
        // A (0,2)-sequence in base two: the first 256 points have one in each box of area 1/256.
        let points: Vec<[f32; 2]> = (0..256).map(|s| Random::new(3, 5, s, 7).pair(4)).collect();
        for log_x in 0..=8 {
            let (nx, ny) = (1 << log_x, 256 >> log_x);
            let mut seen = vec![false; 256];
            for [x, y] in &points {
                let cell = (x * nx as f32) as usize * ny + (y * ny as f32) as usize;
                assert!(!seen[cell], "two points in one box of a {nx} by {ny} grid");
                seen[cell] = true;
            }
        }
    }

    #[test]
    fn pairs_and_pixels_are_independent() {
        let correlation = |a: &dyn Fn(u32) -> f32, b: &dyn Fn(u32) -> f32| {
            let n = 4096;
            (0..n).map(|k| (a(k) - 0.5) * (b(k) - 0.5)).sum::<f32>() / n as f32 * 12.0
        };
        let one = |s| Random::new(1, 1, s, 0).pair(2)[0];
        assert!(correlation(&one, &|s| Random::new(1, 1, s, 0).pair(3)[0]).abs() < 0.06);
        assert!(correlation(&one, &|s| Random::new(2, 1, s, 0).pair(2)[0]).abs() < 0.06);
        assert!(correlation(&one, &|s| Random::new(1, 1, s, 1).pair(2)[0]).abs() < 0.06);
        let over_pixels = |s: u32| Random::new(s % 64, s / 64, 0, 0).pair(2)[0];
        assert!(correlation(&over_pixels, &|s| Random::new(s % 64 + 1, s / 64, 0, 0).pair(2)[0]).abs() < 0.06);
    }
}
