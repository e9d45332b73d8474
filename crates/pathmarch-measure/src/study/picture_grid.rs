//! Pictures of the page: tone-mapped panels beside each other, written as JPEG files of a limited size.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use pathmarch_cli::Failure;
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::flip::ErrorMap;
use pathmarch_render::tonemap::Display;
use std::path::Path;

/// Largest JPEG file, bytes.
const MAX_BYTES: usize = 150_000;
/// Pixels between panels.
const GAP: u32 = 4;

/// 8-bit sRGB panel.
#[derive(Clone)]
pub struct Panel {
    width: u32,
    height: u32,
    codes: Vec<[u8; 3]>,
}

impl Panel {
    /// A picture as a screen shows it.
    pub fn of(picture: &Picture, display: &Display) -> Self {
        let codes = picture.pixels.iter().map(|pixel| display.encode_8bit(*pixel)).collect();
        Self { width: picture.width, height: picture.height, codes }
    }

    /// Errors from 0, black, to 1, through purple, red and yellow to white.
    pub fn of_errors(map: &ErrorMap) -> Self {
        let codes = map.errors.iter().map(|error| heat(*error)).collect();
        Self { width: map.width, height: map.height, codes }
    }

    /// The panel at a whole fraction of its size, by averages of its codes.
    pub fn reduced(&self, factor: u32) -> Self {
        let (width, height) = ((self.width / factor).max(1), (self.height / factor).max(1));
        let at = |x: u32, y: u32| self.codes[(y.min(self.height - 1) * self.width + x.min(self.width - 1)) as usize];
        let mean = |x: u32, y: u32| {
            let sum = |k: usize| -> u32 {
                (0..factor * factor).map(|i| u32::from(at(x * factor + i % factor, y * factor + i / factor)[k])).sum()
            };
            std::array::from_fn(|k| (sum(k) / (factor * factor)) as u8)
        };
        let codes = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
        Self { width, height, codes }
    }
}

/// Colour of an error from 0 to 1: piecewise linear, after the *magma* map of van der Walt and Smith, 2015.
fn heat(error: f32) -> [u8; 3] {
    const STOPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 4.0], [81.0, 18.0, 124.0], [183.0, 55.0, 121.0], [252.0, 137.0, 97.0], [252.0, 253.0, 191.0]];
    let position = error.clamp(0.0, 1.0) * 4.0;
    let (index, share) = ((position as usize).min(3), position - position.floor().min(3.0));
    std::array::from_fn(|k| (STOPS[index][k] + share * (STOPS[index + 1][k] - STOPS[index][k])) as u8)
}

/// Writes panels of one size in rows, white between them, as a JPEG file of at most [`MAX_BYTES`] where its quality
/// can fall so far.
pub fn save(path: &Path, panels: &[Panel], columns: u32) -> Result<(), Failure> {
    let Some(first) = panels.first() else { return Ok(()) };
    let rows = (panels.len() as u32).div_ceil(columns);
    let (step_x, step_y) = (first.width + GAP, first.height + GAP);
    let (width, height) = (columns * step_x - GAP, rows * step_y - GAP);
    let mut bytes = vec![255u8; 3 * (width * height) as usize];
    for (index, panel) in panels.iter().enumerate() {
        let (left, top) = (index as u32 % columns * step_x, index as u32 / columns * step_y);
        for (y, row) in panel.codes.chunks(panel.width as usize).take(first.height as usize).enumerate() {
            let start = 3 * ((top + y as u32) * width + left) as usize;
            let row: Vec<u8> = row.iter().take(first.width as usize).flatten().copied().collect();
            bytes[start..start + row.len()].copy_from_slice(&row);
        }
    }
    let mut quality = 92;
    loop {
        let mut jpeg = Vec::new();
        JpegEncoder::new_with_quality(&mut jpeg, quality)
            .write_image(&bytes, width, height, ExtendedColorType::Rgb8)
            .map_err(Failure::other)?;
        if jpeg.len() > MAX_BYTES && quality <= 40 && first.width > 64 {
            // Noise: smaller panels show it as well.
            let smaller: Vec<Panel> = panels.iter().map(|panel| panel.reduced(2)).collect();
            return save(path, &smaller, columns);
        }
        if jpeg.len() <= MAX_BYTES || quality <= 40 {
            return std::fs::write(path, jpeg).map_err(|error| Failure::Other(format!("{}: {error}", path.display())));
        }
        quality -= 4;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_placed_in_rows() {
        let panel = |code: u8| Panel { width: 8, height: 8, codes: vec![[code; 3]; 64] };
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("grid.jpg");
        save(&path, &[panel(0), panel(100), panel(200)], 2).unwrap_or_else(|_| panic!("saved"));
        let read = image::open(&path).expect("a picture").to_rgb8();
        assert_eq!(read.dimensions(), (20, 20));
        for (x, y, code) in [(3, 3, 0u8), (15, 3, 100), (3, 15, 200), (16, 16, 255)] {
            assert!(read.get_pixel(x, y)[0].abs_diff(code) < 24, "{x} {y}");
        }
    }

    #[test]
    fn pictures_of_noise_keep_to_the_limit() {
        let code = |k: u32| [(k.wrapping_mul(2_654_435_761) >> 24) as u8; 3];
        let panel = Panel { width: 1280, height: 720, codes: (0..1280 * 720).map(code).collect() };
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("grid.jpg");
        save(&path, &[panel], 1).unwrap_or_else(|_| panic!("saved"));
        assert!(path.metadata().expect("written").len() <= MAX_BYTES as u64);
        assert_eq!(image::open(&path).expect("a picture").to_rgb8().dimensions(), (640, 360));
    }

    #[test]
    fn reduced_panels_hold_averages() {
        let codes = (0..16).map(|k| [if k % 2 == 0 { 0 } else { 100 }; 3]).collect();
        let panel = Panel { width: 4, height: 4, codes }.reduced(2);
        assert_eq!((panel.width, panel.height, panel.codes[0]), (2, 2, [50; 3]));
    }

    #[test]
    fn heat_rises_from_black() {
        assert_eq!(heat(0.0), [0, 0, 4]);
        let light = |error: f32| heat(error).map(u32::from).iter().sum::<u32>();
        assert!((1..=10).all(|k| light(k as f32 / 10.0) > light((k - 1) as f32 / 10.0)));
    }
}
