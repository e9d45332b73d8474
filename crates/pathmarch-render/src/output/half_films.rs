//! Films of two halves of a picture's samples, whose difference shows the noise.

use super::film::Film;
use super::parts::Rect;
use glam::Vec3;

/// Films of two halves with independent noise. Pixels may have different numbers of samples, but equal shares of them in each half.
#[derive(Clone, Debug)]
pub struct HalfFilms {
    rect: Rect,
    halves: [Film; 2],
    whole: Film,
}

impl HalfFilms {
    /// Films of the halves of a picture of these pixels, and of all samples.
    pub(crate) fn new(rect: Rect, halves: [Film; 2], whole: Film) -> Self {
        Self { rect, halves, whole }
    }

    /// Pixels.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// All samples.
    pub fn film(&self) -> &Film {
        &self.whole
    }

    /// Means of both halves and of all samples.
    pub fn means(&self) -> Means {
        let ([first, second], all) = (&self.halves, &self.whole);
        let means = |film: &Film| -> Vec<Option<Vec3>> {
            let pixels = film.sums.iter().zip(film.sample_counts());
            pixels.map(|(sum, count)| (count > 0).then(|| Vec3::from(*sum) / count as f32)).collect()
        };
        let whole: Vec<Vec3> = means(all).into_iter().map(Option::unwrap_or_default).collect();
        let or_whole = |film| means(film).into_iter().zip(&whole).map(|(mean, all)| mean.unwrap_or(*all)).collect();
        let first_share = first.samples as f32 / all.samples.max(1) as f32;
        Means { halves: [or_whole(first), or_whole(second)], whole, first_share }
    }
}

/// Means of the samples of each pixel.
pub struct Means {
    /// Means of both halves; of all samples where a half has none.
    pub halves: [Vec<Vec3>; 2],
    /// Means of all samples.
    pub whole: Vec<Vec3>,
    /// Share of the first half in all samples.
    pub first_share: f32,
}
