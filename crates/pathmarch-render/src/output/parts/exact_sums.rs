//! Sums that are the same in any order: of floats, without rounding that depends on the order.
//!
//! **Idea.** The bits of all positive floats are divided into bins of 32 bits. A pixel keeps two consecutive bins: the highest
//! that any of its values reaches, and the one below. Each bin is an integer, and a value adds the bits that fall into it; bits
//! below the two bins are dropped. Nothing is carried from one bin to the other before the sum is read. So the bins depend on
//! the set of values alone, and sums of parts add up to the sum of the whole in any order and grouping.
//!
//! **Source.** Demmel and Nguyen 2015, "Parallel Reproducible Summation"; their bins are floats, ours integers. The three
//! channels of a pixel share their bins.
//!
//! **Accuracy.** The dropped bits are below 2⁻³² of the largest value, at most once for each value. **Cost.** 49 bytes a pixel.

use rayon::prelude::*;

/// Width of a bin.
const BITS: u32 = 32;
/// Exponent of the lowest bit of bin 0: below the smallest float, 2⁻¹⁴⁹.
const LOWEST: i32 = -160;
/// Pixels that a thread adds at once.
const CHUNK: usize = 4096;

/// Sums of three channels for each pixel; every value is finite and not negative.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ExactSums {
    /// Higher bin of each pixel, at least 1.
    pub(super) tops: Vec<u8>,
    /// Both bins of each channel, the higher first.
    pub(super) bins: Vec<[u64; 6]>,
}

/// Bin in which a value starts, and its bits there and in the next.
fn split(value: f32) -> (i32, u64, u64) {
    let bits = value.to_bits();
    let exponent = ((bits >> 23) & 0xff) as i32;
    let fraction = u64::from(bits & 0x7f_ffff);
    let (mantissa, exponent) = if exponent == 0 { (fraction, -149) } else { (fraction | 0x80_0000, exponent - 150) };
    let place = (exponent - LOWEST) as u32;
    let shifted = mantissa << (place % BITS);
    ((place / BITS) as i32, shifted & 0xffff_ffff, shifted >> BITS)
}

/// Moves the bins of a pixel up.
fn raise(top: &mut u8, bins: &mut [u64; 6], to: i32) {
    let by = to - i32::from(*top);
    if by <= 0 {
        return;
    }
    *top = to as u8;
    for channel in bins.chunks_exact_mut(2) {
        channel[1] = if by == 1 { channel[0] } else { 0 };
        channel[0] = 0;
    }
}

fn add(top: &mut u8, bins: &mut [u64; 6], values: [f32; 3]) {
    let parts = values.map(split);
    let highest = parts.iter().map(|(bin, _, high)| bin + i32::from(*high > 0)).max().unwrap_or(1);
    raise(top, bins, highest);
    let top = i32::from(*top);
    for (channel, (bin, low, high)) in bins.chunks_exact_mut(2).zip(parts) {
        for (bin, bits) in [(bin, low), (bin + 1, high)] {
            match top - bin {
                0 => channel[0] += bits,
                1 => channel[1] += bits,
                _ => {}
            }
        }
    }
}

/// Sum of one channel.
fn value(top: u8, bins: &[u64]) -> f64 {
    let sum = (u128::from(bins[0]) << BITS) + u128::from(bins[1]);
    // Two factors, each a normal number.
    let exponent = (i32::from(top) - 1) * BITS as i32 + LOWEST;
    sum as f64 * 2.0_f64.powi(exponent / 2) * 2.0_f64.powi(exponent - exponent / 2)
}

impl ExactSums {
    /// Sums of `pixels` pixels, all zero.
    pub(super) fn new(pixels: usize) -> Self {
        Self { tops: vec![1; pixels], bins: vec![[0; 6]; pixels] }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.tops.is_empty()
    }

    /// Adds one value to each pixel; the first values make the sums.
    pub(super) fn add(&mut self, values: &[[f32; 3]]) {
        if self.is_empty() {
            *self = Self::new(values.len());
        }
        let pixels = self.tops.par_chunks_mut(CHUNK).zip(self.bins.par_chunks_mut(CHUNK));
        pixels.zip(values.par_chunks(CHUNK)).for_each(|((tops, bins), values)| {
            for ((top, bins), values) in tops.iter_mut().zip(bins).zip(values) {
                add(top, bins, *values);
            }
        });
    }

    /// Adds the sums of another part of the values.
    pub(super) fn merge(&mut self, other: &Self) {
        if self.is_empty() {
            *self = other.clone();
            return;
        }
        let pixels = self.tops.iter_mut().zip(&mut self.bins);
        for ((top, bins), (other_top, other_bins)) in pixels.zip(other.tops.iter().zip(&other.bins)) {
            let (mut other_top, mut other_bins) = (*other_top, *other_bins);
            raise(top, bins, i32::from(other_top));
            raise(&mut other_top, &mut other_bins, i32::from(*top));
            for (bin, other) in bins.iter_mut().zip(other_bins) {
                *bin += other;
            }
        }
    }

    /// Sum of each pixel, rounded once.
    pub(super) fn values(&self) -> Vec<[f32; 3]> {
        let pixels = self.tops.par_iter().zip(&self.bins);
        pixels.map(|(top, bins)| std::array::from_fn(|k| value(*top, &bins[2 * k..2 * k + 2]) as f32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of all sizes, from a simple generator.
    fn random(count: usize, seed: u64) -> Vec<[f32; 3]> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32
        };
        let mut value = || match next() % 8 {
            0 => 0.0,
            1 => f32::from_bits(next() % (1 << 23)),
            2 => f32::from_bits(next() % 0x7180_0000),
            _ => f32::from_bits((118 << 23) + next() % (16 << 23)),
        };
        (0..count).map(|_| std::array::from_fn(|_| value())).collect()
    }

    fn sum(values: &[[f32; 3]]) -> ExactSums {
        let mut sums = ExactSums::default();
        values.iter().for_each(|value| sums.add(&[*value]));
        sums
    }

    #[test]
    fn sums_have_the_same_bits_in_any_order_and_grouping() {
        for seed in 0..200 {
            let values = random(60, seed);
            let whole = sum(&values);
            let mut reversed = values.clone();
            reversed.reverse();
            assert_eq!(whole, sum(&reversed));
            let (a, b) = values.split_at(1 + seed as usize % 58);
            let (mut ab, mut ba) = (sum(a), sum(b));
            ab.merge(&sum(b));
            ba.merge(&sum(a));
            assert_eq!((&whole, &whole), (&ab, &ba), "seed {seed}");
        }
    }

    #[test]
    fn sums_are_as_accurate_as_64_bit_floats() {
        for seed in 0..100 {
            let values: Vec<_> =
                random(1000, seed).into_iter().map(|value| value.map(|v| v.clamp(1e-6, 1e6))).collect();
            let found = sum(&values).values()[0];
            for channel in 0..3 {
                let expected: f64 = values.iter().map(|value| f64::from(value[channel])).sum();
                let error = (f64::from(found[channel]) - expected).abs() / expected;
                assert!(error < 1e-7, "{} {expected}", found[channel]);
            }
        }
    }

    #[test]
    fn a_single_value_is_exact() {
        for value in [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1e-30, 0.1, 1.0, 3.5e7, 1.6e31] {
            assert_eq!(sum(&[[value, 0.0, value]]).values(), [[value, 0.0, value]]);
        }
    }
}
