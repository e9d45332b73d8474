//! Pictures on surfaces.
//!
//! **Projection.** Along the three axes of the texture's coordinates, blended by the eighth powers of the normal's components
//! (triplanar mapping; Geiss 2007, "Generating Complex Procedural Terrains Using the GPU"). Seen from +z, the picture's
//! right is +x and its top is +y; from +x its right is -z; from above its top is -z. It repeats without end; its left lower
//! corner is at the origin.
//!
//! **Filter.** Bilinear within a level of a pyramid (Williams 1983, "Pyramidal Parametrics"), linear between the two levels
//! whose texels are as large as what a pixel covers. Each level is the mean of squares of the one below; of colours,
//! the mean of light. What is covered is known from the length of the path, not from the slope of the surface, so that
//! pictures at a grazing angle are sharper than a pixel, and the samples of the pixel average them.
//!
//! **Files.** PNG and JPEG, by way of the crate `image`; colours are sRGB, values that stand for numbers are linear. Alpha is
//! ignored, except by decals. Larger pictures than 4096 texels a side are averaged down.
//!
//! **Cost.** Four bytes a texel and a third more.

use super::Spot;
use glam::{Vec2, Vec3, Vec4};
use image::{DynamicImage, ImageReader, Limits, Rgb, RgbImage};
use pathmarch_mesh::files;
use std::io::{BufReader, ErrorKind};
use std::path::Path;

/// The largest side that is kept, texels.
const KEPT_SIDE: u32 = 4096;
/// The largest side that is read, texels.
const MAX_SIDE: u32 = 32_768;
/// The most texels that are read.
const MAX_TEXELS: u64 = 1 << 28;

/// A picture with its levels of detail.
#[derive(Clone, PartialEq)]
pub struct Picture {
    /// Texels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// True if its codes are sRGB.
    pub encoded: bool,
    /// True if texels have an alpha.
    pub has_alpha: bool,
    /// Red, green and blue codes and alpha, a byte each, the lowest first; all levels, the whole picture first, each half as wide
    /// and high (rounded down, at least 1) as the one before, to the last of one texel. Alpha is 0 in pictures without it.
    pub texels: Vec<u32>,
}

impl std::fmt::Debug for Picture {
    /// All but the texels.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Picture {{ {}x{}, encoded: {} }}", self.width, self.height, self.encoded)
    }
}

/// Error of a file that is no texture.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum PictureError {
    /// It is not there.
    #[error("there is no such file")]
    Missing,
    /// It is no file.
    #[error("it is a directory")]
    Directory,
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(String),
    /// It is none of the formats.
    #[error("it is neither PNG nor JPEG")]
    UnknownFormat,
    /// Its contents are wrong.
    #[error("it is damaged: {0}")]
    Damaged(String),
    /// It has too many texels.
    #[error("{0} x {1} texels are too many")]
    TooLarge(u32, u32),
}

impl PictureError {
    /// Help: what to do.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Missing | Self::Directory => "Its path is relative to the scene file.",
            Self::Unreadable(_) => "Check its permissions.",
            Self::UnknownFormat => "Save it as .png or .jpg.",
            Self::Damaged(_) => "Save it again from the program that made it.",
            Self::TooLarge(..) => "Make it smaller: at most 32768 texels a side and 268435456 in all.",
        }
    }
}

impl Picture {
    /// Loads the picture in the file at `path`; `encoded` for colours in sRGB.
    ///
    /// # Errors
    /// [`PictureError`] if the file is no picture.
    pub fn load(path: &Path, encoded: bool) -> Result<Self, PictureError> {
        Ok(Self::of_image(decode(path)?.into_rgb8(), encoded))
    }

    /// Loads the picture in the file at `path`, of colours in sRGB, with its alpha.
    ///
    /// # Errors
    /// [`PictureError`] if the file is no picture.
    pub fn load_with_alpha(path: &Path) -> Result<Self, PictureError> {
        let image = decode(path)?.into_rgba8();
        let size = image.dimensions();
        Ok(Self::of_texels(image.pixels().map(|pixel| u32::from_le_bytes(pixel.0)).collect(), size, true, true))
    }

    /// The picture with these texels of the whole.
    pub(crate) fn of_image(image: RgbImage, encoded: bool) -> Self {
        let size = image.dimensions();
        let pack = |Rgb([r, g, b]): &Rgb<u8>| u32::from_le_bytes([*r, *g, *b, 0]);
        Self::of_texels(image.pixels().map(pack).collect(), size, encoded, false)
    }

    fn of_texels(texels: Vec<u32>, size: (u32, u32), encoded: bool, has_alpha: bool) -> Self {
        let mut level = Level { texels, width: size.0, height: size.1 };
        while level.width.max(level.height) > KEPT_SIDE {
            level = level.halved(encoded, has_alpha);
        }
        let (width, height) = (level.width, level.height);
        let mut texels = Vec::new();
        while level.texels.len() > 1 {
            texels.extend(&level.texels);
            level = level.halved(encoded, has_alpha);
        }
        texels.extend(level.texels);
        Self { width, height, encoded, has_alpha, texels }
    }

    /// White picture of one texel.
    pub(crate) fn white() -> Self {
        Self::of_image(RgbImage::from_pixel(1, 1, Rgb([255; 3])), false)
    }

    /// Number of levels.
    pub fn levels(&self) -> u32 {
        1 + self.width.max(self.height).ilog2()
    }

    /// Its mean.
    pub fn mean(&self) -> Vec3 {
        self.texel(self.texels.len() - 1, 1, 0, 0)
    }

    /// Linear colour of a texel of a level that starts at `start`.
    pub(super) fn texel(&self, start: usize, width: u32, x: u32, y: u32) -> Vec3 {
        let [r, g, b, _] = self.texels[start + (y * width + x) as usize].to_le_bytes();
        Vec3::new(f32::from(r), f32::from(g), f32::from(b))
            .to_array()
            .map(|code| light(code / 255.0, self.encoded))
            .into()
    }

    /// First texel, width and height of a level.
    pub(super) fn level(&self, level: u32) -> (usize, u32, u32) {
        let (mut start, mut width, mut height) = (0, self.width, self.height);
        for _ in 0..level {
            start += (width * height) as usize;
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
        }
        (start, width, height)
    }

    /// A level at a place: x from the left, y from the bottom, the whole picture once from 0 to 1.
    fn bilinear(&self, level: u32, place: Vec2) -> Vec3 {
        let (start, width, height) = self.level(level);
        let inside = place - place.floor();
        let at = Vec2::new(inside.x * width as f32, (1.0 - inside.y) * height as f32) - 0.5;
        let corner = at.floor();
        let part = at - corner;
        let wrapped = |v: f32, count: u32| (v as i32).rem_euclid(count as i32) as u32;
        let (x0, x1) = (wrapped(corner.x, width), wrapped(corner.x + 1.0, width));
        let (y0, y1) = (wrapped(corner.y, height), wrapped(corner.y + 1.0, height));
        let row = |y: u32| self.texel(start, width, x0, y).lerp(self.texel(start, width, x1, y), part.x);
        row(y0).lerp(row(y1), part.y)
    }

    /// Colour times alpha, and alpha, of a texel of a level that starts at `start`.
    fn texel_with_alpha(&self, start: usize, width: u32, x: u32, y: u32) -> Vec4 {
        let [.., alpha] = self.texels[start + (y * width + x) as usize].to_le_bytes();
        let alpha = f32::from(alpha) / 255.0;
        (self.texel(start, width, x, y) * alpha).extend(alpha)
    }

    /// As [`Self::bilinear`], with alpha, and the outermost texels beyond the edges.
    fn bilinear_with_alpha(&self, level: u32, place: Vec2) -> Vec4 {
        let (start, width, height) = self.level(level);
        let at = Vec2::new(place.x * width as f32, (1.0 - place.y) * height as f32) - 0.5;
        let corner = at.floor();
        let part = at - corner;
        let clamped = |v: f32, count: u32| v.clamp(0.0, (count - 1) as f32) as u32;
        let (x0, x1) = (clamped(corner.x, width), clamped(corner.x + 1.0, width));
        let (y0, y1) = (clamped(corner.y, height), clamped(corner.y + 1.0, height));
        let texel = |x: u32, y: u32| self.texel_with_alpha(start, width, x, y);
        let row = |y: u32| texel(x0, y).lerp(texel(x1, y), part.x);
        row(y0).lerp(row(y1), part.y)
    }

    /// Colour times alpha, and alpha, around a place from 0 to 1, over `texels` texels.
    pub(super) fn filtered_with_alpha(&self, texels: f32, place: Vec2) -> Vec4 {
        let last = self.levels() - 1;
        let level = texels.max(1.0).log2().min(last as f32);
        let first = level.floor();
        let fine = self.bilinear_with_alpha((first as u32).min(last), place);
        if level == first {
            return fine;
        }
        fine.lerp(self.bilinear_with_alpha((first as u32 + 1).min(last), place), level - first)
    }

    fn filtered(&self, level: f32, place: Vec2) -> Vec3 {
        let first = level.floor();
        let last = self.levels() - 1;
        let fine = self.bilinear((first as u32).min(last), place);
        if level == first {
            return fine;
        }
        fine.lerp(self.bilinear((first as u32 + 1).min(last), place), level - first)
    }

    /// The blend of the projections along the axes; `size` is the picture's width, in the spot's coordinates.
    pub(super) fn projected(&self, spot: &Spot, size: f32) -> Vec3 {
        let texel = size / self.width as f32;
        let level = (spot.footprint / texel).max(1.0).log2().min((self.levels() - 1) as f32);
        let scale = Vec2::new(1.0, self.width as f32 / self.height as f32) / size;
        let n = spot.normal;
        let weights = (n * n) * (n * n);
        let weights = weights * weights;
        let side = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
        let p = spot.p;
        let places =
            [Vec2::new(-side(n.x) * p.z, p.y), Vec2::new(p.x, -side(n.y) * p.z), Vec2::new(side(n.z) * p.x, p.y)];
        let total = weights.element_sum().max(1e-30);
        let mut sum = Vec3::ZERO;
        for (k, place) in places.into_iter().enumerate() {
            let weight = weights[k] / total;
            // Too little to be seen.
            if weight > 1e-3 {
                sum += self.filtered(level, place * scale) * weight;
            }
        }
        sum
    }
}

/// Decodes the file at `path`.
fn decode(path: &Path) -> Result<DynamicImage, PictureError> {
    let unreadable = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => PictureError::Missing,
        _ => PictureError::Unreadable(error.to_string()),
    };
    let file = files::open(path).map_err(unreadable)?;
    if file.is_directory().map_err(unreadable)? {
        return Err(PictureError::Directory);
    }
    let read = |file: BufReader<files::File>| -> Result<ImageReader<_>, PictureError> {
        let reader = ImageReader::new(file).with_guessed_format().map_err(unreadable)?;
        match reader.format() {
            Some(image::ImageFormat::Png | image::ImageFormat::Jpeg) => Ok(reader),
            _ => Err(PictureError::UnknownFormat),
        }
    };
    let first_line = |error: image::ImageError| {
        let reason = error.to_string();
        PictureError::Damaged(reason.lines().next().unwrap_or_default().chars().take(200).collect())
    };
    let (width, height) = read(BufReader::new(file))?.into_dimensions().map_err(first_line)?;
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(PictureError::TooLarge(width, height));
    }
    let mut reader = read(BufReader::new(files::open(path).map_err(unreadable)?))?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(16 * MAX_TEXELS);
    reader.limits(limits);
    reader.decode().map_err(first_line)
}

/// Light of a code from 0 to 1.
fn light(code: f32, encoded: bool) -> f32 {
    match encoded {
        false => code,
        true if code <= 0.04045 => code / 12.92,
        true => ((code + 0.055) / 1.055).powf(2.4),
    }
}

/// The code of light from 0 to 1.
fn code(light: f32, encoded: bool) -> f32 {
    match encoded {
        false => light,
        true if light <= 0.003_130_8 => light * 12.92,
        true => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

/// A level of a picture, with texels as those of [`Picture::texels`].
struct Level {
    texels: Vec<u32>,
    width: u32,
    height: u32,
}

impl Level {
    /// Half as wide and as high; each texel is the mean of those that it covers, weighted by their alpha.
    fn halved(&self, encoded: bool, has_alpha: bool) -> Self {
        let table: Vec<f32> = (0..256u32).map(|byte| light(byte as f32 / 255.0, encoded)).collect();
        let half = |side: u32| (side / 2).max(1);
        // A side that is odd gives its last texels to the last one.
        let covered = |at: u32, side: u32| at * 2..if at + 1 == half(side) { side } else { at * 2 + 2 };
        let texel = |x: u32, y: u32| {
            let (columns, rows) = (covered(x, self.width), covered(y, self.height));
            let count = (columns.len() * rows.len()) as f32;
            let (mut sum, mut weights, mut plain) = ([0.0; 3], 0.0, [0.0; 3]);
            for (column, row) in rows.flat_map(|row| columns.clone().map(move |column| (column, row))) {
                let codes = self.texels[(row * self.width + column) as usize].to_le_bytes();
                let weight = if has_alpha { f32::from(codes[3]) / 255.0 } else { 1.0 };
                weights += weight;
                for k in 0..3 {
                    let value = table[codes[k] as usize];
                    sum[k] += weight * value;
                    plain[k] += value;
                }
            }
            let mean = if weights > 0.0 { sum.map(|sum| sum / weights) } else { plain.map(|sum| sum / count) };
            let [r, g, b] = mean.map(|mean| (code(mean, encoded) * 255.0).round() as u8);
            let alpha = if has_alpha { (weights / count * 255.0).round() as u8 } else { 0 };
            u32::from_le_bytes([r, g, b, alpha])
        };
        let (width, height) = (half(self.width), half(self.height));
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { texels, width, height }
    }
}
