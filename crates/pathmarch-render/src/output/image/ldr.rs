//! PNG and JPEG: tone-mapped 8-bit sRGB.
//!
//! **Idea.** The writer applies exposure, tone curve and the sRGB curve, and rounds to 8 bits. The reader decodes codes to
//! linear light in 0..=1; it does not invert the tone curve. An `sRGB` chunk (PNG 3, section 11.3.2.5) declares the colour
//! space of a PNG. The encoder does not support the chunk, so that the writer inserts its 13 bytes after the header, whose
//! length is fixed. The provenance of a picture is in `tEXt` chunks behind it.
//!
//! **Limits.** The reader ignores colour profiles and gamma: all files count as sRGB. It drops alpha.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder, ImageReader, Limits};
use rayon::prelude::*;

use super::{ImageError, ImageFormat, MAX_SIDE, Picture, Provenance, check_size};
use crate::output::tonemap::{Display, srgb_decode};

/// JPEG quality, from 1 to 100.
const JPEG_QUALITY: u8 = 95;

/// Offset of the first chunk after the header, bytes: the signature (8) and the chunk IHDR (25).
const PNG_HEADER_BYTES: usize = 33;

/// Complete `sRGB` chunk: length 1, name, rendering intent 0 (perceptual), checksum.
const PNG_SRGB_CHUNK: [u8; 13] = [0, 0, 0, 1, b's', b'R', b'G', b'B', 0, 0xae, 0xce, 0x1c, 0xe9];

/// Encodes the picture as a PNG file with its provenance; errors name `path`.
pub(super) fn encode_png(
    path: &Path,
    picture: &Picture,
    display: &Display,
    provenance: &Provenance,
) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&codes(picture, display), picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(path, &error))?;
    let mut chunks = PNG_SRGB_CHUNK.to_vec();
    provenance.named_values().into_iter().for_each(|(name, value)| chunks.extend(text_chunk(name, &value)));
    bytes.splice(PNG_HEADER_BYTES..PNG_HEADER_BYTES, chunks);
    Ok(bytes)
}

/// `tEXt` chunk (PNG 3, section 11.3.3.2): a keyword, a zero, and text in Latin-1, here printable ASCII.
fn text_chunk(keyword: &str, text: &str) -> Vec<u8> {
    let text: String = text.chars().map(|c| if matches!(c, ' '..='~') { c } else { '?' }).collect();
    let body = [b"tEXt", keyword.as_bytes(), b"\0", text.as_bytes()].concat();
    let length = (body.len() as u32 - 4).to_be_bytes();
    [&length[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
}

/// Encodes the picture as a JPEG file; errors name `path`.
pub(super) fn encode_jpeg(path: &Path, picture: &Picture, display: &Display) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .write_image(&codes(picture, display), picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(path, &error))?;
    Ok(bytes)
}

/// Decodes the bytes of a PNG or JPEG file.
pub(super) fn decode(path: &Path, bytes: &[u8], format: ImageFormat) -> Result<Picture, ImageError> {
    let format = match format {
        ImageFormat::Jpeg => ::image::ImageFormat::Jpeg,
        _ => ::image::ImageFormat::Png,
    };
    let decode_error =
        |error: ::image::ImageError| ImageError::Decode { path: path.to_owned(), reason: error.to_string() };

    if format == ::image::ImageFormat::Jpeg && !jpeg_is_complete(bytes) {
        return Err(ImageError::Decode { path: path.to_owned(), reason: "the end of the file is missing".to_owned() });
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

/// True if the marker "end of image" follows the last "start of scan". The decoder fills missing data with grey and reports no
/// error. Neither marker can occur in the coded data, in which a zero follows every byte 0xff.
fn jpeg_is_complete(bytes: &[u8]) -> bool {
    let last_scan = bytes.windows(2).rposition(|marker| marker == [0xff, 0xda]);
    last_scan.is_some_and(|at| bytes[at..].windows(2).any(|marker| marker == [0xff, 0xd9]))
}

/// Tone-mapped 8-bit sRGB, three bytes a pixel.
fn codes(picture: &Picture, display: &Display) -> Vec<u8> {
    picture.pixels.par_iter().flat_map_iter(|&pixel| display.encode_8bit(pixel)).collect()
}

fn encode_error(path: &Path, error: &::image::ImageError) -> ImageError {
    ImageError::Encode { path: path.to_owned(), reason: error.to_string() }
}
