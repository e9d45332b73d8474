//! Temporal anti-aliasing.
//!
//! Samples of one pixel see its edges and textures at other places in every picture. The picture is therefore averaged
//! with the last one at the same points. What the last picture shows is clamped to the colours around the pixel, so that
//! nothing stays that is not there any more.
//!
//! **Source.** Karis 2014, "High-Quality Temporal Supersampling"; clamping to mean and deviation: Salvi 2016, "An Excursion
//! in Temporal Supersampling". Colours stay linear: compressing bright ones would darken the mean.

use super::motion::Motion;
use super::temporal::{History, project};
use crate::integrator::guides::Guide;
use crate::scene::FrameUniforms;
use glam::Vec3;
use rayon::prelude::*;

/// Weight of a new picture, unless the pixel was not seen before.
const NEW_WEIGHT: f32 = 0.12;
/// Deviations from the mean of the neighbours that the past may have.
const REACH: f32 = 1.25;

/// Picture that was shown.
pub(super) struct ShownPicture {
    pub(super) frame: FrameUniforms,
    pub(super) colours: Vec<Vec3>,
}

/// Last picture, what it shows, and the motion since.
#[derive(Clone, Copy)]
pub(super) struct Last<'a> {
    pub(super) picture: &'a ShownPicture,
    pub(super) history: &'a History,
    pub(super) motion: &'a Motion,
}

/// Averages a picture with the last one.
pub(super) fn antialiased(frame: &FrameUniforms, guides: &[Guide], picture: &[Vec3], last: Option<Last>) -> Vec<Vec3> {
    let Some(Last { picture: shown, history, motion }) = last else { return picture.to_vec() };
    let [width, height] = frame.size().map(|side| side as usize);
    let pixel = |index: usize| {
        let new = picture[index];
        let (x, y) = (index % width, index / width);
        let (mut sum, mut squares, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        // Edges move with what is in front.
        let mut nearest = &guides[index];
        for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
            for column in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                let colour = picture[row * width + column];
                let guide = &guides[row * width + column];
                if guide.length < nearest.length {
                    nearest = guide;
                }
                let opponent = opponent_of(colour);
                sum += opponent;
                squares += opponent * opponent;
                count += 1.0;
            }
        }
        let Some(old) = shown.before(frame, [x, y], nearest, &motion.earlier(nearest), history) else { return new };
        let mean = sum / count;
        let deviation = REACH * (squares / count - mean * mean).max(Vec3::ZERO).map(f32::sqrt);
        colour_of(opponent_of(old).clamp(mean - deviation, mean + deviation)).max(Vec3::ZERO).lerp(new, NEW_WEIGHT)
    };
    (0..picture.len()).into_par_iter().with_min_len(1024).map(pixel).collect()
}

/// Lightness, orange against blue, green against magenta (YCoCg; Malvar and Sullivan 2003). Clamped there, a grey
/// pattern lets no colour pass.
fn opponent_of(colour: Vec3) -> Vec3 {
    let Vec3 { x: r, y: g, z: b } = colour;
    Vec3::new(0.25 * r + 0.5 * g + 0.25 * b, 0.5 * (r - b), 0.5 * g - 0.25 * (r + b))
}

/// Inverse of [`opponent_of`].
fn colour_of(opponent: Vec3) -> Vec3 {
    let Vec3 { x: lightness, y: orange, z: green } = opponent;
    Vec3::new(lightness + orange - green, lightness + green, lightness - orange - green)
}

impl ShownPicture {
    /// Bilinear colour where a pixel of the picture `frame` was, if it has moved from `earlier` to `guide`; `None` outside,
    /// and where that point was hidden.
    fn before(
        &self,
        frame: &FrameUniforms,
        pixel: [usize; 2],
        guide: &Guide,
        earlier: &Guide,
        history: &History,
    ) -> Option<Vec3> {
        let [width, height] = self.frame.size().map(|side| side as f32);
        let [old, new] = [project(&self.frame, earlier.position)?, project(frame, guide.position)?];
        // Pictures may differ in size.
        let scale = [width / frame.width as f32, height / frame.height as f32];
        let [x, y] = std::array::from_fn(|k| (pixel[k] as f32 + 0.5 - new[k]) * scale[k] + old[k]);
        if !(0.0..width).contains(&x) || !(0.0..height).contains(&y) {
            return None;
        }
        if !history.shows(earlier, frame, [x, y]) {
            return None;
        }
        let (x, y) = ((x - 0.5).clamp(0.0, width - 1.0), (y - 0.5).clamp(0.0, height - 1.0));
        let (fx, fy) = (x.fract(), y.fract());
        let row = |row: f32| {
            let start = row.min(height - 1.0) as usize * width as usize;
            let next = (x as usize + 1).min(width as usize - 1);
            self.colours[start + x as usize].lerp(self.colours[start + next], fx)
        };
        Some(row(y.floor()).lerp(row(y.floor() + 1.0), fy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opponent_colours_are_those_of_grey_and_back() {
        assert_eq!(opponent_of(Vec3::splat(0.3)), Vec3::new(0.3, 0.0, 0.0));
        let colour = Vec3::new(0.9, 0.25, 3.0);
        assert!((colour_of(opponent_of(colour)) - colour).length() < 1e-6);
    }
}
