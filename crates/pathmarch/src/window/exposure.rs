//! Histogram of the picture.

/// Bars of the histogram.
pub(crate) const BARS: usize = 64;
/// Largest number of pixels that the histogram looks at.
const MAX_PIXELS: usize = 100_000;

/// Histogram of a displayed picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Histogram {
    /// Number of the picture.
    pub(crate) serial: u64,
    /// Share of pixels in each bar of red, green and blue, from dark to bright; the largest one is 1.
    pub(crate) bars: [[f32; BARS]; 3],
    /// Share of pixels with a channel at its maximum.
    pub(crate) clipped: f32,
}

impl Histogram {
    /// The histogram of sRGB codes, four a pixel.
    pub(crate) fn new(serial: u64, codes: &[u8]) -> Self {
        let pixels = codes.len() / 4;
        let stride = pixels.div_ceil(MAX_PIXELS).max(1);
        let mut counts = [[0_u32; BARS]; 3];
        let (mut clipped, mut all) = (0_u32, 0_u32);
        for pixel in codes.chunks_exact(4).step_by(stride) {
            for (channel, counts) in counts.iter_mut().enumerate() {
                counts[usize::from(pixel[channel]) * BARS / 256] += 1;
            }
            clipped += u32::from(pixel[..3].contains(&255));
            all += 1;
        }
        // The ends may have most pixels, such as those of a black background.
        let most = counts.iter().flat_map(|counts| &counts[1..BARS - 1]).copied().max().unwrap_or(0).max(1);
        let bars = counts.map(|counts| counts.map(|count| (count as f32 / most as f32).min(1.0)));
        Self { serial, bars, clipped: clipped as f32 / all.max(1) as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_where_the_pixels_are() {
        let grey = [128, 128, 128, 255].repeat(3);
        let histogram = Histogram::new(1, &[grey, vec![255, 0, 0, 255]].concat());
        assert_eq!((histogram.bars[1][32], histogram.bars[0][33], histogram.clipped), (1.0, 0.0, 0.25));
    }
}
