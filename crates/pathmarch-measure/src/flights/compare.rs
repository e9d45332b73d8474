//! Errors of reconstructed frames against converged ones.

use pathmarch_cli::Failure;
use pathmarch_cli::outln;
use pathmarch_render::image::{Picture, PictureKind};
use pathmarch_render::metrics::{self, block_means};
use pathmarch_render::reconstruct::Frame;
use pathmarch_render::tonemap::{Display, srgb_decode};

/// Result of a compared frame.
pub(super) struct Row {
    frame: u32,
    /// FLIP and relMSE, before and after.
    flip: [f64; 2],
    relmse: [f64; 2],
    /// relMSE after, of pixels with fewer than [`SHORT_HISTORY`] samples; `None` if there are none, and in enlarged pictures.
    pub(super) short_history: Option<f64>,
    /// Mean difference between the changes of the picture and of the reference since the last frame, along the motion;
    /// `None` at rest, and in enlarged pictures.
    pub(super) temporal: Option<f64>,
    /// Mean luminance after, divided by that of the reference.
    energy: f64,
    /// Smallest and largest ratio of the 32x32 tiles, before and after. The samples before have no bias, so that theirs is noise.
    tiles: [[f64; 2]; 2],
}

/// Number of samples below which a history is short.
const SHORT_HISTORY: f32 = 4.0;

impl Row {
    pub(super) fn print(&self, name: &str) {
        let Self { frame, flip, relmse, short_history, temporal, energy, tiles } = self;
        let optional = |value: &Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        outln!(
            "{name:8} {:3}   FLIP {:.3} -> {:.3}   relMSE {:8.4} -> {:.4}, short history {}   temporal {}   energy \
             {energy:.3}, tiles {:.3} to {:.3} -> {:.3} to {:.3}",
            frame + 1,
            flip[0],
            flip[1],
            relmse[0],
            relmse[1],
            optional(short_history),
            optional(temporal),
            tiles[0][0],
            tiles[0][1],
            tiles[1][0],
            tiles[1][1]
        );
    }
}

/// Picture as a screen shows it: clipped to 0..=1, linear.
pub(super) fn shown(picture: &Picture, display: &Display) -> Picture {
    let pixels = picture.pixels.iter().map(|pixel| display.encode(*pixel).map(srgb_decode)).collect();
    Picture { pixels, ..*picture }
}

fn mean(picture: &Picture) -> f64 {
    picture.mean_colour().iter().sum::<f64>() / 3.0
}

/// relMSE of the pixels with fewer than [`SHORT_HISTORY`] samples.
pub(super) fn relmse_of_short_histories(frame: &Frame, reference: &Picture) -> Result<Option<f64>, Failure> {
    let is_short = |lengths: &[f32; 3]| lengths[0] < SHORT_HISTORY;
    let pick = |picture: &Picture| -> Vec<[f32; 3]> {
        let pixels = picture.pixels.iter().zip(&frame.history_length.pixels);
        pixels.filter(|(_, lengths)| is_short(lengths)).map(|(pixel, _)| *pixel).collect()
    };
    let row = |pixels: Vec<[f32; 3]>| Picture { width: pixels.len() as u32, height: 1, pixels };
    let [ours, expected] = [row(pick(&frame.reconstructed)), row(pick(reference))];
    if ours.width == 0 {
        return Ok(None);
    }
    metrics::relmse(&ours, &expected).map(Some).map_err(Failure::other)
}

/// Mean over pixels and channels of |(ours - ours before) - (reference - reference before)|, where "before" is the nearest
/// pixel of the last frame along the motion. Pixels that were hidden do not count.
pub(super) fn temporal_error([ours, ours_before, reference, reference_before]: [&Picture; 4], motion: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (index, &[dx, dy, is_known]) in motion.pixels.iter().enumerate() {
        let (x, y) = (index as u32 % motion.width, index as u32 / motion.width);
        let (x, y) = ((x as f32 + dx).round(), (y as f32 + dy).round());
        if is_known == 0.0 || x < 0.0 || y < 0.0 {
            continue;
        }
        let before = |picture: &Picture| picture.get(x as u32, y as u32);
        let (Some(a), Some(b)) = (before(ours_before), before(reference_before)) else { continue };
        let difference = |k: usize| (ours.pixels[index][k] - a[k]) - (reference.pixels[index][k] - b[k]);
        sum += (0..3).map(|k| f64::from(difference(k).abs())).sum::<f64>() / 3.0;
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// Picture enlarged to this size by repeating pixels.
pub(super) fn enlarged(picture: &Picture, [width, height]: [u32; 2]) -> Picture {
    Picture::from_fn(width, height, |x, y| {
        picture.get(x * picture.width / width, y * picture.height / height).unwrap_or_default()
    })
}

/// Compares the samples of a frame and its reconstructed picture with a reference.
pub(super) fn compare(
    number: u32,
    pictures: [&Picture; 2],
    reference: &Picture,
    display: &Display,
) -> Result<Row, Failure> {
    let shown_reference = shown(reference, display);
    let (mut flip, mut relmse) = ([0.0; 2], [0.0; 2]);
    for (k, picture) in pictures.into_iter().enumerate() {
        let compared = metrics::compare(&shown(picture, display), &shown_reference, PictureKind::Ldr);
        flip[k] = compared.map_err(Failure::other)?.flip;
        relmse[k] = metrics::relmse(picture, reference).map_err(Failure::other)?;
    }
    let expected = block_means(reference, 32);
    let tiles = pictures.map(|picture| {
        let ratio = |(ours, expected): (&[f32; 3], &[f32; 3])| {
            let sum = |pixel: &[f32; 3]| f64::from(pixel.iter().sum::<f32>());
            sum(ours) / sum(expected).max(1e-3)
        };
        let ratios = block_means(picture, 32).pixels;
        let ratios = ratios.iter().zip(&expected.pixels).map(ratio);
        ratios.fold([f64::INFINITY, 0.0], |[least, most], ratio| [least.min(ratio), most.max(ratio)])
    });
    let energy = mean(pictures[1]) / mean(reference);
    Ok(Row { frame: number, flip, relmse, short_history: None, temporal: None, energy, tiles })
}

/// Mean absolute difference of two pictures.
pub(super) fn difference(a: &Picture, b: &Picture) -> f64 {
    let change = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>()) / 3.0;
    a.pixels.iter().zip(&b.pixels).map(change).sum::<f64>() / a.pixels.len() as f64
}
