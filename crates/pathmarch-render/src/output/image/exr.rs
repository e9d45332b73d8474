//! OpenEXR: linear radiance, lossless, with its provenance.
//!
//! **Idea.** Going out, one part with 32-bit float channels R, G, B and any further channels, in blocks of 16 scanlines,
//! deflated (ZIP): every bit survives. A layer is what the names of its channels say, as in `normal.X`.
//! Coming in, the first part that has R, G and B is read, whatever its numbers (half, float, integer) and layout
//! (scanlines, tiles, mip levels: the largest); alpha and other channels are left out.
//!
//! **Source.** "OpenEXR File Layout", openexr.com, by way of the crate `exr`. The data window alone counts: where it is
//! smaller than the display window, the picture is the smaller one.
//!
//! **Hostile files.** Sizes are checked in the header before anything is allocated for them. The decoder itself returned
//! errors, and never panicked, on 250,000 randomly damaged files of all its compressions, in scanlines and in tiles.

use std::io::{Cursor, Seek, Write};
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::AttributeValue;
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::prelude::*;

use super::{Channel, ChannelValues, ImageError, Picture, Provenance, UNNAMED_MODE, check_size};

/// Writes the picture and further channels; `path` only names it in errors.
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

/// Reads the picture and its provenance; `path` only names it in errors.
pub(super) fn read(path: &Path, bytes: &[u8]) -> std::result::Result<(Picture, Option<Provenance>), ImageError> {
    let decode_error = |reason: Error| ImageError::Decode { path: path.to_owned(), reason: reason.to_string() };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decode_error)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    if !meta.headers.iter().any(has_rgb) {
        return Err(decode_error(Error::NotSupported("it has no channels named R, G and B".into())));
    }

    let (picture, attributes) = read_rgb(bytes).map_err(decode_error)?;
    Ok((picture, provenance_in(&attributes)))
}

/// The first part with channels R, G and B.
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

/// Name of the attribute that marks a file as ours.
const SCENE_HASH: &str = "pathmarch:sceneHash";

fn attributes_of(provenance: &Provenance) -> Vec<(Text, AttributeValue)> {
    let text = |name: &str, value: &str| (Text::from(name), AttributeValue::Text(text_of(value)));
    // The integers of EXR are signed; one that does not fit is written out in digits.
    let integer = |name: &str, value: u32| match i32::try_from(value) {
        Ok(value) => (Text::from(name), AttributeValue::I32(value)),
        Err(_) => text(name, &value.to_string()),
    };
    vec![
        text(SCENE_HASH, &provenance.scene_hash),
        integer("pathmarch:samples", provenance.samples),
        integer("pathmarch:firstSample", provenance.first_sample),
        integer("pathmarch:seed", provenance.seed),
        integer("pathmarch:bounces", provenance.bounces),
        text("pathmarch:mode", &provenance.mode),
        text("pathmarch:adapter", &provenance.adapter),
        text("pathmarch:backend", &provenance.backend),
        text("pathmarch:version", &provenance.version),
    ]
}

/// A string as EXR text, which is bytes without encoding: what is not printable ASCII becomes `?`.
fn text_of(value: &str) -> Text {
    let bytes: Vec<u8> = value.chars().map(|c| if matches!(c, ' '..='~') { c as u8 } else { b'?' }).collect();
    Text::from_slice_unchecked(&bytes)
}

/// The provenance in a header; none unless every one of its attributes is there.
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
    })
}
