//! Random numbers: Owen-scrambled Sobol' points in pairs of dimensions, with an error that is blue noise over the
//! pixels.
//!
//! **Idea.** The two coordinates of a Sobol' point are the digits of one polynomial s over the field of two elements,
//! whose coefficients are the bits of the sample's index: at z = 0, and at z = 1 (the Pascal matrix). Here the
//! polynomial is s Q^8 + g with Q = z² + z + 1. The pixel chooses g: eight digits in base Q, polynomials of degree
//! below two. They are the digits of the pixel's index on a space-filling curve, the coarsest level first. In an
//! aligned block of 2^m by 2^m pixels and a run of 2^k samples, two such polynomials differ by Q^(8-m) times one of
//! degree below k + 2m, which cannot vanish k + 2m times at 0 and 1, where Q does not vanish. So **in every such block
//! and run, each elementary interval of area 2^-(k + 2m) contains exactly one point**, for all m up to 8 and k up to 16
//! at once; beyond, this is true of runs of 2^16. Each pixel is as well stratified as alone, and its neighbours sample
//! the intervals that it misses. So the error has a high spatial frequency after 1, 2, 4, 8, … samples, and their final
//! number need not be known in advance. Hashes of (seed, pair) scramble the order of the samples, the order of the
//! pixels (which keeps blocks) and the coordinates (Owen scrambling), so that pairs are independent. A number is a pure
//! function of (seed, pixel, sample, pair).
//!
//! **Sources.** Sobol' points in five steps of integer arithmetic: Ahmed 2024, "An Implementation Algorithm of 2D Sobol
//! Sequence Fast, Elegant, and Compact". Owen scrambling by hashing: Burley 2020, "Practical Hash-based Owen
//! Scrambling", after Laine and Karras 2011, with the constants of Vegdahl 2021. Blue noise by scrambled blocks of
//! pixels: Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical
//! Ordering of Pixels"; there each pixel takes a run of one sequence, here the curve index is separate from the sample
//! index, so that the run may have any length. Nets from places of a function field, with Q a place of degree two: the
//! survey of Niederreiter 2005. Georgiev and Fajardo 2016 and Heitz et al. 2019 reach the same end by tables. The ranks
//! of a void-and-cluster array (Ulichney 1993) instead of the curve were tried. They were better at one sample (blurred
//! variance over eight integrands fell by 7.6, with the curve by 5.9), worse at 4 (2.4, 7.2) and almost without gain at
//! 16 (1.2, 6.4), because complementary pixels are then far from each other.
//!
//! **Cost.** About 85 integer operations a pair, a third of them the same for all pixels. No memory.

use wide::f32x8;

/// Pairs of dimensions of a path, in order.
pub(crate) mod pair {
    use crate::wgsl::shared_constants;

    shared_constants! {
        /// Position within the pixel.
        pub(crate) const PAIR_PIXEL: u32 = 0;
        /// Position on the lens.
        pub(crate) const PAIR_LENS: u32 = 1;
        /// First pair of the first surface.
        pub(crate) const PAIR_SURFACE: u32 = 2;
        /// Direction of the scattered ray. This and the following pairs are relative to the first pair of the surface.
        pub(crate) const PAIR_SCATTER: u32 = 0;
        /// Choice of the light (x) and Russian roulette (y).
        pub(crate) const PAIR_CHOICE: u32 = 1;
        /// Position on the light.
        pub(crate) const PAIR_LIGHT: u32 = 2;
        /// Choice of the lobe (x).
        pub(crate) const PAIR_LOBE: u32 = 3;
        /// Number of pairs of each surface.
        pub(crate) const PAIRS_PER_SURFACE: u32 = 4;
        /// First pair of the first segment of a path in media.
        pub(crate) const PAIR_SEGMENT: u32 = 1 << 24;
        /// Distance to the next scattering event (x) and its channel (y). This and the following pairs are relative to the
        /// first pair of the segment.
        pub(crate) const PAIR_DISTANCE: u32 = 0;
        /// Point of the segment at which light is sampled (x), and the strategy or channel for it (y).
        pub(crate) const PAIR_POINT: u32 = 1;
        /// Choice of the light (x).
        pub(crate) const PAIR_SEGMENT_CHOICE: u32 = 2;
        /// Position on the light.
        pub(crate) const PAIR_SEGMENT_LIGHT: u32 = 3;
        /// Number of pairs of each segment.
        pub(crate) const PAIRS_PER_SEGMENT: u32 = 4;
        /// Number of segments before the first one behind the next boundary of a medium.
        pub(crate) const SEGMENTS_PER_CROSSING: u32 = 1 << 18;
    }
}

/// Hash of a word (PCG output permutation; Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
#[inline(always)]
pub(crate) fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Seed of a pair of dimensions, for the hash of the picture's seed.
#[inline(always)]
fn pair_seed(seed_hash: u32, pair: u32) -> u32 {
    hash(seed_hash ^ pair.wrapping_mul(0x9e37_79b9))
}

/// Owen scrambling of the reversed bits `x`: a hash of the bits below each bit decides its flip.
#[inline(always)]
pub(crate) fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Uniform number in 0..1 from the high 24 bits.
#[inline(always)]
pub(crate) fn unit(x: u32) -> f32 {
    (x >> 8) as f32 / 16_777_216.0
}

/// Polynomial with these eight digits in base Q, the coarsest in the two lowest bits.
#[inline(always)]
fn from_base_q(digits: u32) -> u32 {
    // Divide and conquer: Q^n = z^2n + z^n + 1 for n = 1, 2, 4.
    let mut sum = digits;
    let mut high = (sum >> 2) & 0x3333;
    sum ^= high ^ (high << 1);
    high = (sum >> 4) & 0x0f0f;
    sum ^= high ^ (high << 2);
    high = sum >> 8;
    sum ^ high ^ (high << 4)
}

/// Bits of a number below 2^16 with a zero between each two, for Morton codes.
fn spread_bits(mut x: u32) -> u32 {
    x = (x | (x << 8)) & 0x00ff_00ff;
    x = (x | (x << 4)) & 0x0f0f_0f0f;
    x = (x | (x << 2)) & 0x3333_3333;
    (x | (x << 1)) & 0x5555_5555
}

/// Group of a pixel among four, x and y below two. Each block of 2 by 2 pixels has one of each, in an order by chance.
pub(crate) fn interleaved_group(x: u32, y: u32) -> [u32; 2] {
    let flips = hash((x / 2) ^ hash(y / 2));
    [(x ^ flips) & 1, (y ^ (flips >> 1)) & 1]
}

/// Pixel of which the pixel (x, y) has the random numbers where pixels of a group are to be stratified together: the sixteen of a
/// tile of 8 by 8 in one [`interleaved_group`] take an aligned block, of which neighbours are far from each other.
pub(crate) fn place_by_group(x: u32, y: u32) -> [u32; 2] {
    let [group_x, group_y] = interleaved_group(x, y);
    let place = |x: u32, group: u32| (x & !7) | (group << 2) | (x & 2) | ((x >> 2) & 1);
    [place(x, group_x), place(y, group_y)]
}

/// Part of the polynomial of a Sobol' point that the pixel does not change.
#[inline(always)]
fn sobol_order(sample: u32, seed: u32) -> u32 {
    let index = scramble_reversed(sample.reverse_bits(), seed).reverse_bits();
    index ^ (index << 8) ^ (index << 16)
}

/// Scrambled Sobol' point of a pixel, see the description of the module.
#[inline(always)]
fn sobol_2d(seed: u32, order: u32, curve_index: u32) -> [f32; 2] {
    let curve_index = scramble_reversed(curve_index, seed.rotate_left(24)) >> 16;
    let at_zero = order ^ from_base_q(curve_index);
    let mut at_one = at_zero;
    at_one ^= (at_one >> 1) & 0x5555_5555;
    at_one ^= (at_one >> 2) & 0x3333_3333;
    at_one ^= (at_one >> 4) & 0x0f0f_0f0f;
    at_one ^= (at_one >> 8) & 0x00ff_00ff;
    at_one ^= (at_one >> 16) & 0x0000_ffff;
    let x = scramble_reversed(at_zero, seed.rotate_left(8)).reverse_bits();
    let y = scramble_reversed(at_one, seed.rotate_left(16)).reverse_bits();
    [unit(x), unit(y)]
}

/// Random numbers of one sample of each of eight pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelSampler8 {
    seed_hash: u32,
    curve_index: [u32; 8],
    sample: u32,
    independent: bool,
}

impl PixelSampler8 {
    /// Samplers of one seed and kind, at the same sample of each pixel.
    #[inline(always)]
    pub(crate) fn new(samplers: &[PixelSampler; 8]) -> Self {
        let PixelSampler { seed_hash, sample, independent, .. } = samplers[0];
        debug_assert!(samplers.iter().all(|other| (other.seed_hash, other.sample) == (seed_hash, sample)));
        Self { seed_hash, curve_index: samplers.map(|sampler| sampler.curve_index), sample, independent }
    }

    /// Sampler of a lane.
    pub(crate) fn lane(&self, lane: usize) -> PixelSampler {
        let &Self { seed_hash, sample, independent, .. } = self;
        PixelSampler { seed_hash, curve_index: self.curve_index[lane], sample, independent }
    }

    /// Puts a sampler of the same kind, seed and sample into a lane.
    pub(crate) fn put(&mut self, lane: usize, sampler: PixelSampler) {
        self.curve_index[lane] = sampler.curve_index;
    }

    /// [`PixelSampler::with_sample`] of every lane.
    pub(crate) fn with_sample(self, sample: u32) -> Self {
        Self { sample, ..self }
    }

    /// [`PixelSampler::part`] of every lane.
    pub(crate) fn part(self, k: u32, count: u32) -> Self {
        self.with_sample(self.lane(0).part(k, count).sample)
    }

    /// [`PixelSampler::sample_2d`] of every lane.
    #[inline]
    pub(crate) fn sample_2d(&self, pair: u32) -> [f32x8; 2] {
        let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
        if self.independent {
            for lane in 0..8 {
                [x[lane], y[lane]] = self.lane(lane).independent_2d(pair);
            }
        } else {
            let seed = pair_seed(self.seed_hash, pair);
            let order = sobol_order(self.sample, seed);
            for lane in 0..8 {
                [x[lane], y[lane]] = sobol_2d(seed, order, self.curve_index[lane]);
            }
        }
        [x.into(), y.into()]
    }
}

/// Random numbers of one sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelSampler {
    /// Hash of the seed.
    seed_hash: u32,
    /// Index of the pixel on a space-filling curve, bits reversed: two bits for each level, the finest level in the
    /// highest bits.
    curve_index: u32,
    sample: u32,
    independent: bool,
}

impl PixelSampler {
    /// Sobol' points of sample `sample` of the pixel (`x`, `y`), both below 2^16, for a seed.
    #[inline]
    pub(crate) fn new(x: u32, y: u32, sample: u32, seed: u32) -> Self {
        let morton = (spread_bits(x) | (spread_bits(y) << 1)).reverse_bits();
        // A hash decides for each block if its curve runs along x or y first, so that the noise has no preferred
        // direction.
        let flips = (scramble_reversed(morton, 0x9e37_79b9) ^ morton) & 0x5555_5555;
        let swap = (morton ^ (morton >> 1)) & flips;
        Self { seed_hash: hash(seed), curve_index: morton ^ swap ^ (swap << 1), sample, independent: false }
    }

    /// Same sampler with independent random numbers instead of Sobol' points if `independent` is set.
    pub(crate) fn independent(self, independent: bool) -> Self {
        Self { independent, ..self }
    }

    /// Random numbers of another sample of the same pixel.
    pub(crate) fn with_sample(self, sample: u32) -> Self {
        Self { sample, ..self }
    }

    /// Random numbers of part `k` of `count` of a sample, where samples have as many parts.
    pub(crate) fn part(self, k: u32, count: u32) -> Self {
        Self { sample: self.sample.wrapping_mul(count).wrapping_add(k), ..self }
    }

    /// Point of a pair of dimensions, uniform in the unit square.
    pub(crate) fn sample_2d(self, pair: u32) -> [f32; 2] {
        if self.independent { self.independent_2d(pair) } else { self.sobol_2d(pair) }
    }

    /// [`sample_2d`](Self::sample_2d) of many samplers, all of one kind.
    pub(crate) fn samples_2d(samplers: &[Self], pair: u32) -> Vec<[f32; 2]> {
        // Runs of a fixed length without branches, so that the compiler vectorises them.
        const RUN: usize = 16;
        if samplers.first().is_some_and(|sampler| sampler.independent) {
            return samplers.iter().map(|sampler| sampler.independent_2d(pair)).collect();
        }
        let mut result = Vec::with_capacity(samplers.len());
        let (runs, rest) = samplers.as_chunks::<RUN>();
        for run in runs {
            let (seed_hashes, curve_indices, samples) =
                (run.map(|r| r.seed_hash), run.map(|r| r.curve_index), run.map(|r| r.sample));
            let (mut x, mut y) = ([0.0; RUN], [0.0; RUN]);
            for k in 0..RUN {
                let sampler = Self {
                    seed_hash: seed_hashes[k],
                    curve_index: curve_indices[k],
                    sample: samples[k],
                    independent: false,
                };
                [x[k], y[k]] = sampler.sobol_2d(pair);
            }
            result.extend(x.into_iter().zip(y).map(<[f32; 2]>::from));
        }
        result.extend(rest.iter().map(|sampler| sampler.sobol_2d(pair)));
        result
    }

    #[inline(always)]
    fn independent_2d(self, pair: u32) -> [f32; 2] {
        let seed = pair_seed(self.seed_hash, pair);
        let x = hash(self.sample ^ hash(self.curve_index ^ seed));
        [unit(x), unit(hash(x ^ seed))]
    }

    #[inline(always)]
    fn sobol_2d(self, pair: u32) -> [f32; 2] {
        let seed = pair_seed(self.seed_hash, pair);
        sobol_2d(seed, sobol_order(self.sample, seed), self.curve_index)
    }

    /// Seed of choices that need no stratification, different for each surface of the path.
    pub(crate) fn unstratified_seed(self, surface: u32) -> u32 {
        hash(hash(self.curve_index ^ self.seed_hash) ^ hash(self.sample ^ surface.wrapping_mul(0x85eb_ca6b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    /// Reports whether each elementary interval contains exactly one point.
    fn is_net(points: &[[f32; 2]]) -> bool {
        let log = points.len().ilog2();
        (0..=log).all(|log_x| {
            let (nx, ny) = (1 << log_x, points.len() >> log_x);
            let mut occupied = vec![false; points.len()];
            points.iter().all(|[x, y]| {
                let cell = (x * nx as f32) as usize * ny + (y * ny as f32) as usize;
                !std::mem::replace(&mut occupied[cell], true)
            })
        })
    }

    #[test]
    fn a_pixel_and_a_block_of_pixels_are_stratified_in_every_elementary_interval() {
        for (log_block, log_samples) in [(0, 8), (1, 0), (1, 1), (1, 6), (2, 0), (2, 3), (3, 2), (4, 0), (4, 1)] {
            let (side, samples) = (1 << log_block, 1 << log_samples);
            for (seed, [x0, y0]) in [(7, [0, 0]), (8, [3, 11]), (9, [1000, 600])] {
                // Any aligned run of samples is a net, so that a picture may be continued.
                for first in [0, samples, 5 * samples] {
                    let points: Vec<[f32; 2]> = (0..side * side * samples)
                        .map(|k| {
                            let (sample, pixel) = (first + k % samples, k / samples);
                            let (x, y) = (side * x0 + pixel % side, side * y0 + pixel / side);
                            PixelSampler::new(x, y, sample, seed).sample_2d(4)
                        })
                        .collect();
                    assert!(is_net(&points), "{side} x {side} pixels of {samples} samples from {first}");
                }
            }
        }
    }

    #[test]
    fn the_pixels_of_a_group_are_stratified_together() {
        for [x0, y0] in [[0, 0], [8, 0], [160, 72]] {
            let pixels: Vec<[u32; 2]> = (0..64).map(|k| [x0 + k % 8, y0 + k / 8]).collect();
            for group in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let pixels = pixels.iter().filter(|[x, y]| interleaved_group(*x, *y) == group);
                let places: Vec<[u32; 2]> = pixels.map(|&[x, y]| place_by_group(x, y)).collect();
                let point = |k: u32| {
                    let [x, y] = places[(k % 16) as usize];
                    PixelSampler::new(x, y, 16 + k / 16, 3).sample_2d(4)
                };
                assert_eq!(places.len(), 16);
                assert!(is_net(&(0..16 * 8).map(point).collect::<Vec<_>>()), "{x0}, {y0}, {group:?}");
            }
            // All pixels of the tile still have places of their own in it.
            let mut places: Vec<[u32; 2]> = pixels.iter().map(|&[x, y]| place_by_group(x, y)).collect();
            places.sort_unstable_by_key(|&[x, y]| [y, x]);
            assert_eq!(places, pixels);
        }
    }

    #[test]
    fn many_samplers_at_once_equal_each_alone() {
        for independent in [false, true] {
            let samplers: Vec<PixelSampler> =
                (0..37).map(|k| PixelSampler { independent, ..PixelSampler::new(k, 3 * k, k / 2, 5) }).collect();
            let each: Vec<[f32; 2]> = samplers.iter().map(|sampler| sampler.sample_2d(9)).collect();
            assert_eq!(PixelSampler::samples_2d(&samplers, 9), each);
            let samplers: Vec<PixelSampler> = samplers.iter().map(|sampler| sampler.with_sample(6)).collect();
            let lanes = PixelSampler8::new(&std::array::from_fn(|lane| samplers[lane]));
            let [x, y] = lanes.part(1, 3).sample_2d(9).map(f32x8::to_array);
            for lane in 0..8 {
                let expected = samplers[lane].part(1, 3).sample_2d(9);
                assert_eq!([[x[lane], y[lane]], lanes.part(1, 3).lane(lane).sample_2d(9)], [expected; 2]);
            }
        }
    }

    #[test]
    fn pairs_seeds_and_samplers_are_independent() {
        let correlation = |a: &dyn Fn(u32) -> f32, b: &dyn Fn(u32) -> f32| {
            let n = 4096;
            (0..n).map(|k| (a(k) - 0.5) * (b(k) - 0.5)).sum::<f32>() / n as f32 * 12.0
        };
        let independent =
            |s: u32, x: u32| PixelSampler { independent: true, ..PixelSampler::new(x, 1, s, 0) }.sample_2d(2);
        let over_samples = |s| PixelSampler::new(1, 1, s, 0).sample_2d(2)[0];
        let over_pixels = |p: u32| PixelSampler::new(p % 64, p / 64, 0, 0).sample_2d(2)[0];
        let cases: [[&dyn Fn(u32) -> f32; 2]; 8] = [
            [&over_samples, &|s| PixelSampler::new(1, 1, s, 0).sample_2d(3)[0]],
            [&over_samples, &|s| PixelSampler::new(1, 1, s, 0).sample_2d(2)[1]],
            [&over_samples, &|s| PixelSampler::new(1, 1, s, 1).sample_2d(2)[0]],
            [&over_pixels, &|p| PixelSampler::new(p % 64, p / 64, 0, 0).sample_2d(3)[0]],
            [&over_pixels, &|p| PixelSampler::new(p % 64, p / 64, 0, 0).sample_2d(2)[1]],
            [&over_pixels, &|p| PixelSampler::new(p % 64, p / 64, 0, 1).sample_2d(2)[0]],
            [&|s| independent(s, 1)[0], &|s| independent(s, 1)[1]],
            [&|s| independent(s, 1)[0], &|s| independent(s, 2)[0]],
        ];
        for (k, [a, b]) in cases.into_iter().enumerate() {
            assert!(correlation(a, b).abs() < 0.06, "case {k}: {}", correlation(a, b));
        }
    }

    /// Smooth and discontinuous functions over the unit square.
    const INTEGRANDS: [fn(f32, f32) -> f32; 6] = [
        |x, y| x + y,
        |x, y| x * y,
        |x, y| (1.0 - x).sqrt() * (0.5 + 0.5 * (TAU * y).cos()),
        |x, y| (-8.0 * ((x - 0.4).powi(2) + (y - 0.6).powi(2))).exp(),
        |x, y| f32::from(u8::from((x - 0.45).hypot(y - 0.55) < 0.35)),
        |x, y| f32::from(u8::from(x + 0.7 * y < 0.8)),
    ];

    fn integral(f: fn(f32, f32) -> f32) -> f64 {
        let n = 1000;
        let at = |k: u32| (k as f32 + 0.5) / n as f32;
        (0..n * n).map(|k| f64::from(f(at(k % n), at(k / n)))).sum::<f64>() / f64::from(n * n)
    }

    #[test]
    fn the_mean_over_seeds_is_unbiased() {
        for f in INTEGRANDS {
            let n = 40_000;
            let mean = (0..n)
                .map(|seed| PixelSampler::new(5, 9, 3, seed).sample_2d(1))
                .map(|[x, y]| f64::from(f(x, y)))
                .sum::<f64>();
            let error = mean / f64::from(n) - integral(f);
            assert!(error.abs() < 4.0 * 0.5 / f64::from(n).sqrt(), "{error}");
        }
    }

    const SIDE: usize = 64;

    /// Gaussian blur with a standard deviation of two pixels of a periodic picture of [`SIDE`] by [`SIDE`] pixels.
    fn blurred(picture: &[f64]) -> Vec<f64> {
        let weight = |d: i32| (f64::from(-d * d) / 8.0).exp() / 8.0_f64.sqrt() / std::f64::consts::PI.sqrt();
        let wrap = |v: usize, d: i32| (v as i32 + d).rem_euclid(SIDE as i32) as usize;
        let along = |of: &[f64], at: &dyn Fn(usize, i32) -> usize| -> Vec<f64> {
            (0..SIDE * SIDE).map(|p| (-8..=8).map(|d| weight(d) * of[at(p, d)]).sum()).collect()
        };
        let rows = along(picture, &|p, d| p / SIDE * SIDE + wrap(p % SIDE, d));
        along(&rows, &|p, d| wrap(p / SIDE, d) * SIDE + p % SIDE)
    }

    /// Sums of the squared error after 1, 2, 4, … 64 samples, blurred and not. `sampler_of` maps a pixel to x, y and
    /// seed of its sampler.
    fn errors(f: fn(f32, f32) -> f32, sampler_of: impl Fn(u32, u32) -> [u32; 3]) -> [[f64; 2]; 7] {
        let expected = integral(f);
        let mut result = [[0.0; 2]; 7];
        for seed in 0..8 {
            let mut sums = vec![0.0; SIDE * SIDE];
            for sample in 0..64_u32 {
                for (p, sum) in sums.iter_mut().enumerate() {
                    let [x, y, seed] = sampler_of((p % SIDE) as u32, seed * 64 + (p / SIDE) as u32);
                    let [u, v] = PixelSampler::new(x, y, sample, seed).sample_2d(3);
                    *sum += f64::from(f(u, v));
                }
                let count = sample + 1;
                if count.is_power_of_two() {
                    let error: Vec<f64> = sums.iter().map(|sum| sum / f64::from(count) - expected).collect();
                    let [of_blurred, of_pixels] = &mut result[count.ilog2() as usize];
                    *of_blurred += blurred(&error).iter().map(|v| v * v).sum::<f64>();
                    *of_pixels += error.iter().map(|v| v * v).sum::<f64>();
                }
            }
        }
        result
    }

    #[test]
    fn the_error_is_blue_noise_over_the_pixels_at_every_power_of_two() {
        let (mut log_gain, mut log_pixels) = ([0.0; 7], [0.0; 7]);
        for f in INTEGRANDS {
            // Blue noise has a seed for each eighth of the rows, white noise a seed for each pixel.
            let blue = errors(f, |x, y| [x, y % 64, y / 64]);
            let white = errors(f, |x, y| [0, 0, hash(x ^ hash(y))]);
            for k in 0..7 {
                let gain = white[k][0] / blue[k][0];
                assert!(gain > 1.7, "{gain} at {} samples", 1 << k);
                log_gain[k] += gain.ln() / INTEGRANDS.len() as f64;
                log_pixels[k] += (white[k][1] / blue[k][1]).ln() / INTEGRANDS.len() as f64;
            }
        }
        println!("variance, white over blue, blurred: {:.2?}", log_gain.map(f64::exp));
        println!("variance, white over blue, of pixels: {:.2?}", log_pixels.map(f64::exp));
        for k in 0..7 {
            assert!(log_gain[k].exp() > 4.5, "{} at {} samples", log_gain[k].exp(), 1 << k);
            assert!(log_pixels[k].exp() > 0.8, "{} at {} samples", log_pixels[k].exp(), 1 << k);
        }
    }
}
