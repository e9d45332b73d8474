//! PNG and JPEG: 8-bit sRGB, the picture as a screen shows it.
//!
//! **Idea.** Going out, radiance passes through exposure, tone curve and the sRGB curve and is rounded to 8 bits; coming in,
//! codes are decoded to linear light in 0..=1 (the tone curve is not undone). A PNG says that it is sRGB in an `sRGB`
//! chunk (PNG 3, section 11.3.2.5), so that viewers need not guess; the encoder has no word for it, so the 13 bytes of the
//! chunk are put in after the header, whose length is fixed.
//!
//! **Where we differ.** Colour profiles and gamma in files that are read are ignored: all are taken for sRGB. Alpha is
//! dropped.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder, ImageReader, Limits};
use rayon::prelude::*;

use super::{ImageError, ImageFormat, MAX_SIDE, Picture, check_size};
use crate::output::tonemap::{Display, srgb_decode};

/// JPEG quality, of 100.
const JPEG_QUALITY: u8 = 95;

/// Bytes before the first chunk that may follow the header: the signature (8) and the chunk IHDR (25).
const PNG_HEADER_BYTES: usize = 33;

/// A whole `sRGB` chunk: length 1, name, rendering intent 0 (perceptual), checksum.
const PNG_SRGB_CHUNK: [u8; 13] = [0, 0, 0, 1, b's', b'R', b'G', b'B', 0, 0xae, 0xce, 0x1c, 0xe9];

/// A PNG file of the picture; `path` only names it in errors.
pub(super) fn encode_png(path: &Path, picture: &Picture, display: &Display) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&codes(picture, display), picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(path, &error))?;
    bytes.splice(PNG_HEADER_BYTES..PNG_HEADER_BYTES, PNG_SRGB_CHUNK);
    Ok(bytes)
}

/// A JPEG file of the picture; `path` only names it in errors.
pub(super) fn encode_jpeg(path: &Path, picture: &Picture, display: &Display) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .write_image(&codes(picture, display), picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(path, &error))?;
    Ok(bytes)
}

/// A picture from the bytes of a PNG or JPEG file.
pub(super) fn decode(path: &Path, bytes: &[u8], format: ImageFormat) -> Result<Picture, ImageError> {
    let format = match format {
        ImageFormat::Jpeg => ::image::ImageFormat::Jpeg,
        _ => ::image::ImageFormat::Png,
    };
    let decode_error =
        |error: ::image::ImageError| ImageError::Decode { path: path.to_owned(), reason: error.to_string() };

    if format == ::image::ImageFormat::Jpeg && !jpeg_is_whole(bytes) {
        return Err(ImageError::Decode { path: path.to_owned(), reason: "its end is missing".to_owned() });
    }
    let (width, height) =
        ImageReader::with_format(Cursor::new(bytes), format).into_dimensions().map_err(decode_error)?;
    check_size(path, width.into(), height.into())?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(8 * u64::from(width) * u64::from(height) + (64 << 20));
    reader.limits(limits);
    let decoded = reader.decode().map_err(decode_error)?.into_rgb32f();
    let pixels = decoded.par_chunks_exact(3).map(|codes| [codes[0], codes[1], codes[2]].map(srgb_decode)).collect();
    Ok(Picture { width, height, pixels })
}

/// Whether the marker "end of image" follows the last "start of scan". The decoder fills what is cut off with grey and says
/// nothing. Neither marker can occur in the coded data, where a zero follows every byte 0xff.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    let last_scan = bytes.windows(2).rposition(|marker| marker == [0xff, 0xda]);
    last_scan.is_some_and(|at| bytes[at..].windows(2).any(|marker| marker == [0xff, 0xd9]))
}

/// 8-bit sRGB, three bytes a pixel.
fn codes(picture: &Picture, display: &Display) -> Vec<u8> {
    picture.pixels.par_iter().flat_map_iter(|&pixel| display.encode_8bit(pixel)).collect()
}

fn encode_error(path: &Path, error: &::image::ImageError) -> ImageError {
    ImageError::Encode { path: path.to_owned(), reason: error.to_string() }
}
