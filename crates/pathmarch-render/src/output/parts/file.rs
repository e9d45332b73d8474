//! Film files: parts of a film on disk, read and written by bands of rows.
//!
//! **Format.** Eight bytes `PMFILM01`; the length of the header (32 bits, little-endian), the header in JSON, and its CRC-32;
//! then a chunk for each band of [`BAND`] rows of each region, top to bottom: its length, its CRC-32, and its bytes; at last
//! `PMFILM.E`. A chunk stores its numbers in planes: the first bytes of all numbers, then the second ones. A plane of one value is
//! stored as that value. A file is valid only if all of it is there and all sums of check are right.

use super::exact_sums::ExactSums;
use super::{FilmPart, Identity, Layer, Rect, SampleSet};
use crate::output::atomic_file::AtomicFile;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Rows of a chunk.
pub(super) const BAND: u32 = 16;
const START: &[u8; 8] = b"PMFILM01";
const END: &[u8; 8] = b"PMFILM.E";
/// Longest header, bytes.
const MAX_HEADER: u32 = 64 << 20;

/// Failure of a film file. Every message names the file.
#[derive(Debug, thiserror::Error)]
pub enum FilmFileError {
    /// The file cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is not a film.
    #[error("{path}: this is not a film of pathmarch; films are written by `pathmarch render -o NAME.film`", path = path.display())]
    NotAFilm {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file is incomplete or damaged.
    #[error("{path}: the film is damaged: {reason}; render this part again", path = path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// Rectangle of a film file and the samples of its pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Pixels.
    pub rect: Rect,
    /// Samples of complete blocks.
    pub(super) blocks: SampleSet,
    /// First sample and number of samples of each layer.
    pub(super) layers: Vec<[u32; 2]>,
}

impl Region {
    pub(super) fn of(part: &FilmPart) -> Self {
        let layers = part.layers.iter().map(|(first, layer)| [*first, layer.samples]).collect();
        Self { rect: part.rect, blocks: part.blocks.clone(), layers }
    }

    /// Indices of its samples.
    pub fn samples(&self) -> SampleSet {
        let layers = self.layers.iter().map(|[first, count]| SampleSet::from(*first..first + count));
        layers.fold(self.blocks.clone(), |all, layer| all.union(&layer))
    }

    fn bands(&self) -> impl Iterator<Item = Rect> + use<> {
        let Rect { x, y, width, .. } = self.rect;
        let bottom = self.rect.bottom();
        (y..bottom).step_by(BAND as usize).map(move |y| Rect { x, y, width, height: BAND.min(bottom - y) })
    }
}

/// What a film file says of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmHeader {
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// First sample of the whole picture, and the one after its last.
    pub samples: [u32; 2],
    /// Scene and settings.
    pub identity: Identity,
    /// Backends and adapters that rendered its samples.
    pub engines: Vec<String>,
    /// Further values that a picture of it needs, such as the tone curve.
    pub notes: BTreeMap<String, String>,
    /// Rectangles with their samples; they do not overlap.
    pub regions: Vec<Region>,
}

impl FilmHeader {
    fn to_json(&self) -> Value {
        let rect = |rect: &Rect| json!([rect.x, rect.y, rect.width, rect.height]);
        let regions = self.regions.iter().map(
            |region| json!({"rect": rect(&region.rect), "blocks": region.blocks.ranges(), "layers": region.layers}),
        );
        json!({
            "size": self.size,
            "samples": self.samples,
            "identity": self.identity.0,
            "engines": self.engines,
            "notes": self.notes,
            "regions": regions.collect::<Vec<_>>(),
        })
    }

    fn from_json(value: &Value) -> Option<Self> {
        let number = |value: &Value| value.as_u64().and_then(|number| u32::try_from(number).ok());
        let numbers = |value: &Value| value.as_array()?.iter().map(number).collect::<Option<Vec<u32>>>();
        let pair = |value: &Value| <[u32; 2]>::try_from(numbers(value)?).ok();
        let pairs = |value: &Value| value.as_array()?.iter().map(pair).collect::<Option<Vec<_>>>();
        let map = |value: &Value| -> Option<BTreeMap<String, String>> {
            value.as_object()?.iter().map(|(name, value)| Some((name.clone(), value.as_str()?.to_owned()))).collect()
        };
        let region = |value: &Value| {
            let [x, y, width, height] = <[u32; 4]>::try_from(numbers(&value["rect"])?).ok()?;
            let blocks = SampleSet::of(&pairs(&value["blocks"])?);
            Some(Region { rect: Rect { x, y, width, height }, blocks, layers: pairs(&value["layers"])? })
        };
        let header = Self {
            size: pair(&value["size"])?,
            samples: pair(&value["samples"])?,
            identity: Identity(map(&value["identity"])?),
            engines: value["engines"]
                .as_array()?
                .iter()
                .map(|name| Some(name.as_str()?.to_owned()))
                .collect::<Option<_>>()?,
            notes: map(&value["notes"])?,
            regions: value["regions"].as_array()?.iter().map(region).collect::<Option<_>>()?,
        };
        header.is_consistent().then_some(header)
    }

    fn is_consistent(&self) -> bool {
        let side = 1..=crate::output::image::MAX_SIDE;
        let [width, height] = self.size;
        let fits = |region: &Region| {
            let Rect { x, y, width: columns, height: rows } = region.rect;
            columns > 0 && rows > 0 && x < width && columns <= width - x && y < height && rows <= height - y
        };
        let layers = |region: &Region| {
            region.layers.iter().all(|[first, count]| *count > 0 && first.checked_add(*count).is_some())
        };
        side.contains(&width)
            && side.contains(&height)
            && self.regions.iter().all(|region| fits(region) && layers(region))
    }
}

/// Writes a film of these parts, each as a region. One part is a film that merges with others; several of the same pixels are for
/// [`FilmFile::parts`] alone.
///
/// # Errors
/// [`FilmFileError::Io`].
pub fn save(path: &Path, header: &FilmHeader, parts: &[FilmPart]) -> Result<(), FilmFileError> {
    let header = FilmHeader { regions: parts.iter().map(Region::of).collect(), ..header.clone() };
    write(path, &header, |index, rect| Ok(parts[index].crop(rect)))
}

/// Writes a film by its bands; `band` returns the pixels of a rectangle of the region of an index.
pub(super) fn write<E: From<FilmFileError>>(
    path: &Path,
    header: &FilmHeader,
    mut band: impl FnMut(usize, Rect) -> Result<FilmPart, E>,
) -> Result<(), E> {
    let failed = |source| E::from(FilmFileError::Io { path: path.to_owned(), source });
    let mut file = BufWriter::new(AtomicFile::create(path).map_err(failed)?);
    let text = header.to_json().to_string();
    let length = (text.len() as u32).to_le_bytes();
    let start = [START.as_slice(), &length, text.as_bytes(), &crc32fast::hash(text.as_bytes()).to_le_bytes()].concat();
    file.write_all(&start).map_err(failed)?;
    for (index, region) in header.regions.iter().enumerate() {
        for rect in region.bands() {
            let bytes = encode(&band(index, rect)?);
            let length = (bytes.len() as u32).to_le_bytes();
            let check = crc32fast::hash(&bytes).to_le_bytes();
            [&length[..], &check, &bytes].into_iter().try_for_each(|bytes| file.write_all(bytes)).map_err(failed)?;
        }
    }
    file.write_all(END).map_err(failed)?;
    file.into_inner().map_err(|error| failed(error.into_error()))?.commit().map_err(failed)
}

/// Opened film file.
pub struct FilmFile {
    path: PathBuf,
    header: FilmHeader,
    /// Place and length of each chunk, by region and band.
    chunks: Vec<Vec<(u64, u32)>>,
    /// Region, band and content of the last chunk that was read.
    last: Option<(usize, Rect, FilmPart)>,
}

impl FilmFile {
    /// Opens a film and finds its chunks.
    ///
    /// # Errors
    /// [`FilmFileError`].
    pub fn open(path: &Path) -> Result<Self, FilmFileError> {
        let damaged = |reason: &str| FilmFileError::Damaged { path: path.to_owned(), reason: reason.to_owned() };
        let failed = |source: io::Error| match source.kind() {
            ErrorKind::UnexpectedEof => damaged("its end is missing"),
            _ => FilmFileError::Io { path: path.to_owned(), source },
        };
        let file = File::open(path).map_err(failed)?;
        let bytes = file.metadata().map_err(failed)?.len();
        let mut file = BufReader::new(file);
        let mut start = [0; 8];
        if file.read_exact(&mut start).is_err() || &start != START {
            return Err(FilmFileError::NotAFilm { path: path.to_owned() });
        }
        let length = number(&mut file).map_err(failed)?;
        if length > MAX_HEADER || u64::from(length) > bytes {
            return Err(damaged("its header has a wrong length"));
        }
        let mut text = vec![0; length as usize];
        file.read_exact(&mut text).map_err(failed)?;
        if number(&mut file).map_err(failed)? != crc32fast::hash(&text) {
            return Err(damaged("its header is not what was written"));
        }
        let header = serde_json::from_slice(&text).ok().and_then(|value| FilmHeader::from_json(&value));
        let header = header.ok_or_else(|| damaged("its header cannot be understood"))?;
        let mut at = 16 + u64::from(length);
        let mut chunks = Vec::new();
        for region in &header.regions {
            let mut places = Vec::new();
            for _ in region.bands() {
                let length = number(&mut file).map_err(failed)?;
                places.push((at, length));
                at += 8 + u64::from(length);
                if at > bytes {
                    return Err(damaged("its end is missing"));
                }
                file.seek_relative(i64::from(length) + 4).map_err(failed)?;
            }
            chunks.push(places);
        }
        let mut end = [0; 8];
        file.read_exact(&mut end).map_err(failed)?;
        if &end != END || at + 8 != bytes {
            return Err(damaged("its end is not where it should be"));
        }
        Ok(Self { path: path.to_owned(), header, chunks, last: None })
    }

    /// Header of the film.
    pub fn header(&self) -> &FilmHeader {
        &self.header
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All samples of a film of one region.
    ///
    /// # Errors
    /// [`FilmFileError`]; a film of several regions counts as damaged.
    pub fn part(&mut self) -> Result<FilmPart, FilmFileError> {
        let [region] = &self.header.regions[..] else {
            return Err(self.damaged("it has several regions"));
        };
        let rect = region.rect;
        self.rows(0, rect)
    }

    /// Samples of each region.
    ///
    /// # Errors
    /// [`FilmFileError`].
    pub fn parts(&mut self) -> Result<Vec<FilmPart>, FilmFileError> {
        let rects: Vec<Rect> = self.header.regions.iter().map(|region| region.rect).collect();
        rects.into_iter().enumerate().map(|(region, rect)| self.rows(region, rect)).collect()
    }

    /// Samples of a rectangle within a region.
    pub(super) fn rows(&mut self, region: usize, rect: Rect) -> Result<FilmPart, FilmFileError> {
        let mut part: Option<FilmPart> = None;
        let bands: Vec<Rect> = self.header.regions[region].bands().collect();
        for (index, band) in bands.into_iter().enumerate() {
            let Some(both) = band.intersection(&rect) else { continue };
            if !matches!(&self.last, Some((last, known, _)) if (*last, *known) == (region, band)) {
                self.last = Some((region, band, self.read(region, index, band)?));
            }
            let Some((_, _, chunk)) = &self.last else { continue };
            let chunk = chunk.crop(both);
            match &mut part {
                None if both == rect => return Ok(chunk),
                None => part.insert(chunk.blank(rect)).paste(&chunk),
                Some(part) => part.paste(&chunk),
            }
        }
        part.ok_or_else(|| self.damaged("a region is empty"))
    }

    fn damaged(&self, reason: &str) -> FilmFileError {
        FilmFileError::Damaged { path: self.path.clone(), reason: reason.to_owned() }
    }

    fn read(&self, region: usize, index: usize, band: Rect) -> Result<FilmPart, FilmFileError> {
        let (at, length) = self.chunks[region][index];
        let read = || -> io::Result<(u32, Vec<u8>)> {
            let mut file = File::open(&self.path)?;
            file.seek(SeekFrom::Start(at + 4))?;
            let check = number(&mut file)?;
            let mut bytes = vec![0; length as usize];
            file.read_exact(&mut bytes)?;
            Ok((check, bytes))
        };
        let (check, bytes) = read().map_err(|source| FilmFileError::Io { path: self.path.clone(), source })?;
        if check != crc32fast::hash(&bytes) {
            return Err(self.damaged(&format!("the rows from {} on are not what was written", band.y)));
        }
        decode(&self.header.regions[region], band, &bytes).ok_or_else(|| self.damaged("a chunk has a wrong length"))
    }
}

fn number(file: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

/// Appends numbers of `size` bytes as planes.
fn put_planes(bytes: &mut Vec<u8>, numbers: &[u8], size: usize) {
    for plane in 0..size {
        let mut values = numbers.iter().skip(plane).step_by(size);
        let first = values.next().copied().unwrap_or(0);
        if values.all(|value| *value == first) {
            bytes.extend([0, first]);
        } else {
            bytes.push(1);
            bytes.extend(numbers.iter().skip(plane).step_by(size));
        }
    }
}

/// Reads `count` numbers of `size` bytes.
fn take_planes(bytes: &mut &[u8], count: usize, size: usize) -> Option<Vec<u8>> {
    let mut numbers = vec![0; count * size];
    for plane in 0..size {
        let (kind, rest) = bytes.split_first()?;
        let places = numbers.iter_mut().skip(plane).step_by(size);
        let length = if *kind == 0 { 1 } else { count };
        let (values, rest) = rest.split_at_checked(length)?;
        match kind {
            0 => places.for_each(|place| *place = values[0]),
            _ => places.zip(values).for_each(|(place, value)| *place = *value),
        }
        *bytes = rest;
    }
    Some(numbers)
}

fn encode(part: &FilmPart) -> Vec<u8> {
    let mut bytes = Vec::new();
    if !part.blocks.is_empty() {
        put_planes(&mut bytes, &part.sums.tops, 1);
        let bins: Vec<u8> = part.sums.bins.iter().flatten().flat_map(|bin| bin.to_le_bytes()).collect();
        put_planes(&mut bytes, &bins, size_of::<[u64; 6]>());
    }
    let rejected: Vec<u8> = match part.rejected.is_empty() {
        true => vec![0; 4 * part.rect.pixels()],
        false => part.rejected.iter().flat_map(|count| count.to_le_bytes()).collect(),
    };
    put_planes(&mut bytes, &rejected, 4);
    for layer in part.layers.values() {
        let sums: Vec<u8> = layer.sums.iter().flatten().flat_map(|sum| sum.to_le_bytes()).collect();
        put_planes(&mut bytes, &sums, size_of::<[f32; 3]>());
    }
    bytes
}

fn decode(region: &Region, rect: Rect, mut bytes: &[u8]) -> Option<FilmPart> {
    let pixels = rect.pixels();
    let mut part = FilmPart { blocks: region.blocks.clone(), ..FilmPart::new(rect) };
    if !part.blocks.is_empty() {
        let tops = take_planes(&mut bytes, pixels, 1)?;
        let bins = take_planes(&mut bytes, pixels, size_of::<[u64; 6]>())?;
        let bin = |bytes: &[u8]| bytes.try_into().map_or(0, u64::from_le_bytes);
        let bins = bins.chunks_exact(48).map(|pixel| std::array::from_fn(|k| bin(&pixel[8 * k..8 * k + 8]))).collect();
        part.sums = ExactSums { tops, bins };
    }
    let rejected = take_planes(&mut bytes, pixels, 4)?;
    if rejected.iter().any(|byte| *byte != 0) {
        part.rejected = rejected.chunks_exact(4).map(|bytes| bytes.try_into().map_or(0, u32::from_le_bytes)).collect();
    }
    for [first, samples] in &region.layers {
        let numbers = take_planes(&mut bytes, pixels, size_of::<[f32; 3]>())?;
        let sum = |bytes: &[u8]| bytes.try_into().map_or(0.0, f32::from_le_bytes);
        let sums =
            numbers.chunks_exact(12).map(|pixel| std::array::from_fn(|k| sum(&pixel[4 * k..4 * k + 4]))).collect();
        part.layers.insert(*first, Layer { samples: *samples, sums });
    }
    bytes.is_empty().then_some(part)
}
