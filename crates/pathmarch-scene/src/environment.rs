//! An environment: a picture of the radiance that comes from every direction.
//!
//! **Directions.** Equirectangular (Blinn and Newell 1976), y up, oriented as the `envmap` of Mitsuba 3. A direction d of
//! length one is first turned back: rotated about +y, right-handed, by minus [`Environment::rotate`]. Then
//!
//! ```text
//! u = fract(atan2(d.x, -d.z) / 2π)      v = acos(d.y) / π
//! ```
//!
//! so that the middle of an unturned picture is in direction +z, its left edge is -z, and +x is a quarter from the left.
//! Texel (i, j) has its centre at u = (i + 0.5) / width, v = (j + 0.5) / height; row 0 is up. Between centres radiance is
//! bilinear; u wraps around, v is clamped. (Mitsuba 3 has the same columns, but spreads its rows from pole to pole:
//! row j is at v = j / (height - 1), at most half a texel away.)
//!
//! **Files.** Radiance RGBE (`.hdr`; Ward 1991) and OpenEXR (`.exr`), by way of the crate `image`. What a renderer cannot
//! use is repaired and counted: NaN and negative channels become 0, infinite ones the largest finite value of the picture.
//! Pictures larger than 4096 by 2048 are averaged down over squares of k by k texels, k the smallest whole number that
//! suffices; squares at the right and lower edge hold what is left.
//!
//! **Cost.** Twelve bytes a texel, at most 96 MiB; while a file is read, 12 to 24 bytes for each of its texels.

use glam::Vec3;
use image::codecs::{hdr::HdrDecoder, openexr::OpenExrDecoder};
use image::{ImageDecoder, ImageResult, Limits};
use pathmarch_mesh::files;
use std::f32::consts::{PI, TAU};
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::Path;

/// The largest width that is kept, texels.
const KEPT_WIDTH: u32 = 4096;
/// The largest height that is kept, texels.
const KEPT_HEIGHT: u32 = 2048;
/// The largest width or height that is read, texels.
const MAX_SIDE: u32 = 32_768;
/// The most texels that are read.
const MAX_TEXELS: u64 = 1 << 29;
/// Radiance that no texel exceeds, W/(m² sr): its square and sums of it are finite in `f32`.
pub(crate) const MAX_RADIANCE: f32 = 1e12;

/// Radiance in every direction; see the module for the directions of texels.
#[derive(Clone, PartialEq)]
pub struct Environment {
    /// Texels in a row, all around the horizon.
    pub width: u32,
    /// Rows, from straight up to straight down.
    pub height: u32,
    /// `width * height` radiances, W/(m² sr), row 0 is up; finite, not negative, at most 1e12.
    pub texels: Vec<[f32; 3]>,
    /// Turn of the picture about +y, right-handed, degrees.
    pub rotate: f32,
}

impl std::fmt::Debug for Environment {
    /// All but the texels.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Self { width, height, rotate, .. } = self;
        write!(f, "Environment {{ {width}x{height}, rotate: {rotate} }}")
    }
}

/// An environment read from a file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The environment, unturned.
    pub environment: Environment,
    /// Width and height in the file, texels.
    pub size: (u32, u32),
    /// Number of texels in the file with a negative or non-finite channel.
    pub repaired: u64,
}

/// Error of a file that is no environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// Nothing has this name.
    #[error("no such file")]
    Missing,
    /// It is a directory, a pipe or a device.
    #[error("not a regular file")]
    NoFile,
    /// The file is a picture of display colours, or no picture.
    #[error("it contains no radiance")]
    NoRadiance,
    /// The system could not read it.
    #[error("not readable: {0}")]
    Unreadable(std::io::Error),
    /// The file is empty.
    #[error("an empty file")]
    Empty,
    /// The file is damaged, cut short, or of a variety that is not read.
    #[error("not readable: {0}")]
    Damaged(String),
    /// No texels, or too many.
    #[error("{0} x {1} texels")]
    BadSize(u32, u32),
    /// Not a single number in it is finite.
    #[error("none of its values is finite")]
    NotFinite,
}

impl EnvironmentError {
    /// Help: what to do, a sentence.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Missing => "Check the name; the path is relative to the scene file.",
            Self::NoFile => "Name a .hdr or .exr file.",
            Self::NoRadiance => "Name a .hdr (Radiance) or .exr (OpenEXR) file; others stop at the white of a screen.",
            Self::Unreadable(_) => "Check its permissions.",
            Self::Empty | Self::Damaged(_) => "It may be damaged or cut short: write it again, as .hdr or .exr.",
            Self::BadSize(..) => {
                "Width and height must be 1 to 32768, such as 8192 x 4096; together at most 2^29 texels."
            }
            Self::NotFinite => "Write it again.",
        }
    }
}

impl Environment {
    /// Radiance from `direction`, which is of length one, W/(m² sr): bilinear between texels.
    pub fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        self.around(direction).0
    }

    /// Radiance from `direction`, and the four texels that it is mixed of.
    pub fn around(&self, direction: [f32; 3]) -> ([f32; 3], [[f32; 3]; 4]) {
        let [x, y, z] = direction;
        let (sin, cos) = self.rotate.rem_euclid(360.0).to_radians().sin_cos();
        let (x, z) = (x * cos - z * sin, x * sin + z * cos);
        let u = (x.atan2(-z) / TAU).rem_euclid(1.0);
        let v = x.hypot(z).atan2(y) / PI;
        let column = u * self.width as f32 - 0.5;
        let row = (v * self.height as f32 - 0.5).clamp(0.0, self.height as f32 - 1.0);
        let left = (column.floor() as i64).rem_euclid(i64::from(self.width)) as usize;
        let right = (left + 1) % self.width as usize;
        let upper = row as usize;
        let lower = (upper + 1).min(self.height as usize - 1);
        let texel = |column: usize, row: usize| self.texels[row * self.width as usize + column];
        let corners = [texel(left, upper), texel(right, upper), texel(left, lower), texel(right, lower)];
        let [a, b, c, d] = corners.map(Vec3::from);
        let across = column - column.floor();
        (a.lerp(b, across).lerp(c.lerp(d, across), row.fract()).into(), corners)
    }

    /// The picture in the file at `path`, its radiance multiplied by `strength`, which is 0 or more.
    ///
    /// # Errors
    /// [`EnvironmentError`]: not there, not readable, no radiance in it, damaged, or too large. Sizes are checked before
    /// memory is asked for.
    pub fn load(path: &Path, strength: f32) -> Result<Loaded, EnvironmentError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        if extension.is_some_and(|extension| !["hdr", "pic", "exr"].contains(&&*extension)) {
            return Err(EnvironmentError::NoRadiance);
        }
        let (mut texels, size) = read(path)?;
        let repaired = repair(&mut texels)?;
        let (texels, (width, height)) = averaged(texels, size);
        let mut environment = Self { width, height, texels, rotate: 0.0 };
        environment.scale(strength);
        Ok(Loaded { environment, size, repaired })
    }

    /// Multiplies its radiance.
    pub(crate) fn scale(&mut self, strength: f32) {
        for channel in self.texels.as_flattened_mut() {
            *channel = (*channel * strength).min(MAX_RADIANCE);
        }
    }
}

type Texels = (Vec<[f32; 3]>, (u32, u32));

/// Reads the texels of a file unchanged, and its width and height.
fn read(path: &Path) -> Result<Texels, EnvironmentError> {
    let system = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => EnvironmentError::Missing,
        ErrorKind::UnexpectedEof => EnvironmentError::Empty,
        _ => EnvironmentError::Unreadable(error),
    };
    // Asked before it is opened: opening a pipe waits for a writer.
    if !files::metadata(path).map_err(system)?.is_file {
        return Err(EnvironmentError::NoFile);
    }
    let mut file = BufReader::new(files::open(path).map_err(system)?);
    let mut magic = [0; 4];
    file.read_exact(&mut magic[..1]).map_err(system)?;
    let _ = file.read(&mut magic[1..]);
    file.rewind().map_err(system)?;
    // The file may be anything, and decoders have been known to overflow on such: then it is damaged.
    let decoded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| match magic {
        [b'#', b'?', ..] => decode_hdr(file),
        [0x76, 0x2f, 0x31, 0x01] => decode(OpenExrDecoder::with_alpha_preference(file, Some(false))),
        _ => Err(EnvironmentError::NoRadiance),
    }));
    decoded.unwrap_or_else(|_| Err(EnvironmentError::Damaged("its structure makes no sense".to_owned())))
}

fn decode_hdr(file: BufReader<files::File>) -> Result<Texels, EnvironmentError> {
    let decoder = HdrDecoder::new_nonstrict(file).map_err(damaged)?;
    let meta = decoder.metadata();
    // The header contains the factor by which radiance has been multiplied.
    let exposure = meta.exposure.filter(|exposure| exposure.is_normal() && *exposure > 0.0).unwrap_or(1.0);
    let (mut texels, size) = decode(Ok(decoder))?;
    if exposure != 1.0 {
        texels.as_flattened_mut().iter_mut().for_each(|channel| *channel /= exposure);
    }
    Ok((texels, size))
}

fn damaged(error: image::ImageError) -> EnvironmentError {
    if matches!(&error, image::ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof) {
        return EnvironmentError::Damaged("it ends too early".to_owned());
    }
    let reason = error.to_string();
    // Some decoders return several lines, of which the first is the summary.
    EnvironmentError::Damaged(reason.lines().next().unwrap_or_default().chars().take(200).collect())
}

fn decode(decoder: ImageResult<impl ImageDecoder>) -> Result<Texels, EnvironmentError> {
    let mut decoder = decoder.map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) || count > MAX_TEXELS {
        return Err(EnvironmentError::BadSize(width, height));
    }
    let mut limits = Limits::no_limits();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(2 * 12 * MAX_TEXELS);
    decoder.set_limits(limits).map_err(damaged)?;
    let mut texels = vec![[0.0_f32; 3]; count as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(damaged)?;
    Ok((texels, (width, height)))
}

/// Makes every channel finite and not negative. Returns the number of repaired texels.
fn repair(texels: &mut [[f32; 3]]) -> Result<u64, EnvironmentError> {
    let finite = |v: &f32| v.is_finite();
    let largest = texels.as_flattened().iter().copied().filter(finite).reduce(f32::max);
    let largest = largest.ok_or(EnvironmentError::NotFinite)?.clamp(0.0, MAX_RADIANCE);
    let mut repaired = 0;
    for texel in texels {
        if texel.iter().all(|v| (0.0..=MAX_RADIANCE).contains(v)) {
            continue;
        }
        repaired += u64::from(texel.iter().any(|v| !v.is_finite() || *v < 0.0));
        // NaN is not above 0 either. The upper end is that of the whole picture, not of radiance.
        *texel = texel.map(|v| if v > 0.0 { v.min(largest) } else { 0.0 });
    }
    Ok(repaired)
}

/// The picture, averaged over squares if it is larger than what is kept.
fn averaged(texels: Vec<[f32; 3]>, (width, height): (u32, u32)) -> Texels {
    let k = width.div_ceil(KEPT_WIDTH).max(height.div_ceil(KEPT_HEIGHT));
    if k == 1 {
        return (texels, (width, height));
    }
    let size = (width.div_ceil(k), height.div_ceil(k));
    let square = |column: u32, row: u32| {
        let columns = (column * k) as usize..((column + 1) * k).min(width) as usize;
        let rows = row * k..((row + 1) * k).min(height);
        let count = columns.len() * rows.len();
        let sum = rows.fold(Vec3::ZERO, |sum, row| {
            let start = row as usize * width as usize;
            let texels = &texels[start + columns.start..start + columns.end];
            texels.iter().fold(sum, |sum, texel| sum + Vec3::from(*texel))
        });
        (sum / count as f32).into()
    };
    let small = (0..size.1).flat_map(|row| (0..size.0).map(move |column| square(column, row))).collect();
    (small, size)
}
