//! Merging of film files.
//!
//! The edges of all rectangles divide the picture into cells, so that every file has all pixels of a cell or none. The files
//! of a cell must have different samples. Cells are merged by bands of rows: memory is that of one band of each file. If all
//! cells have the same samples and fill a rectangle, the result has one region, else one for each cell.

use super::file::{FilmFile, FilmFileError, FilmHeader, Region, write};
use super::{FilmPart, Rect, SampleSet};
use std::collections::BTreeSet;
use std::path::Path;

/// Reason why films do not merge. Every message names the files.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// There is no film.
    #[error("there is nothing to merge")]
    Nothing,
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FilmFileError),
    /// Films of different pictures.
    #[error("{a} and {b} are not parts of one picture: {difference}")]
    Different {
        /// The first file.
        a: String,
        /// The other file.
        b: String,
        /// What differs.
        difference: String,
    },
    /// Two films have the same samples.
    #[error("{a} and {b} overlap: both have the samples {samples} of the pixels {rect}")]
    Overlap {
        /// The first file.
        a: String,
        /// The other file.
        b: String,
        /// The samples of both.
        samples: SampleSet,
        /// The pixels of both.
        rect: Rect,
    },
}

/// Pixels that each file has completely or not at all.
struct Cell {
    rect: Rect,
    /// Files, and the regions there.
    sources: Vec<(usize, usize)>,
    samples: SampleSet,
}

/// Merges films into one file, and returns its header.
///
/// # Errors
/// [`MergeError`].
pub fn merge(files: &mut [FilmFile], output: &Path) -> Result<FilmHeader, MergeError> {
    let header = common_header(files)?;
    let cells = cells(files)?;
    let groups = groups(&cells);
    let regions = groups.iter().map(|(rect, group)| {
        let Some(first) = group.first() else {
            return Ok(Region { rect: *rect, blocks: SampleSet::default(), layers: Vec::new() });
        };
        // One pixel tells the layers of all.
        let pixel = Rect { width: 1, height: 1, ..first.rect };
        Ok(Region { rect: *rect, ..Region::of(&merged(files, first, pixel)?) })
    });
    let regions = regions.collect::<Result<Vec<Region>, MergeError>>()?;
    let header = FilmHeader { regions, ..header };
    write(output, &header, |index, band| {
        let mut whole: Option<FilmPart> = None;
        for cell in &groups[index].1 {
            let Some(rect) = cell.rect.intersection(&band) else { continue };
            let part = merged(files, cell, rect)?;
            if rect == band {
                return Ok(part);
            }
            whole.get_or_insert_with(|| part.blank(band)).paste(&part);
        }
        whole.ok_or(MergeError::Nothing)
    })?;
    Ok(header)
}

fn name(file: &FilmFile) -> String {
    file.path().display().to_string()
}

/// Header of the merged film, without regions.
fn common_header(files: &[FilmFile]) -> Result<FilmHeader, MergeError> {
    let Some(first) = files.first() else { return Err(MergeError::Nothing) };
    let mut header = FilmHeader { regions: Vec::new(), ..first.header().clone() };
    let mut engines: BTreeSet<String> = BTreeSet::new();
    for file in files {
        let other = file.header();
        let (a, b) = (name(first), name(file));
        if let Some(difference) = first.header().identity.difference("there", &other.identity, "here") {
            return Err(MergeError::Different { a, b, difference });
        }
        if other.size != header.size {
            let difference = format!("sizes are {:?} and {:?}", header.size, other.size);
            return Err(MergeError::Different { a, b, difference });
        }
        header.samples = [header.samples[0].min(other.samples[0]), header.samples[1].max(other.samples[1])];
        engines.extend(other.engines.iter().cloned());
    }
    header.engines = engines.into_iter().collect();
    Ok(header)
}

/// Cells of all films, row by row.
fn cells(files: &[FilmFile]) -> Result<Vec<Cell>, MergeError> {
    let regions = || files.iter().flat_map(|file| &file.header().regions);
    let edges = |of: fn(&Rect) -> [u32; 2]| -> Vec<u32> {
        regions().flat_map(|region| of(&region.rect)).collect::<BTreeSet<u32>>().into_iter().collect()
    };
    let (columns, rows) = (edges(|rect| [rect.x, rect.right()]), edges(|rect| [rect.y, rect.bottom()]));
    let mut cells = Vec::new();
    for y in rows.windows(2) {
        for x in columns.windows(2) {
            let rect = Rect { x: x[0], y: y[0], width: x[1] - x[0], height: y[1] - y[0] };
            cells.extend(cell(files, rect)?);
        }
    }
    Ok(cells)
}

/// The cell of a rectangle; `None` if no file has it.
fn cell(files: &[FilmFile], rect: Rect) -> Result<Option<Cell>, MergeError> {
    let mut cell = Cell { rect, sources: Vec::new(), samples: SampleSet::default() };
    for (file, film) in files.iter().enumerate() {
        for (index, region) in
            film.header().regions.iter().enumerate().filter(|(_, region)| region.rect.contains(&rect))
        {
            let samples = region.samples();
            if !samples.intersection(&cell.samples).is_empty() {
                return Err(overlap(files, &cell, file, &samples));
            }
            cell.samples = cell.samples.union(&samples);
            cell.sources.push((file, index));
        }
    }
    Ok((!cell.sources.is_empty()).then_some(cell))
}

fn overlap(files: &[FilmFile], cell: &Cell, file: usize, samples: &SampleSet) -> MergeError {
    let of = |(file, region): &(usize, usize)| files[*file].header().regions[*region].samples();
    let other = cell.sources.iter().find(|source| !of(source).intersection(samples).is_empty());
    let (a, both) = other.map_or((String::new(), SampleSet::default()), |source| {
        (name(&files[source.0]), of(source).intersection(samples))
    });
    MergeError::Overlap { a, b: name(&files[file]), samples: both, rect: cell.rect }
}

/// Regions of the merged film, each with its cells.
fn groups(cells: &[Cell]) -> Vec<(Rect, Vec<&Cell>)> {
    let all = cells.iter().map(|cell| cell.rect).reduce(|a, b| {
        let (x, y) = (a.x.min(b.x), a.y.min(b.y));
        Rect { x, y, width: a.right().max(b.right()) - x, height: a.bottom().max(b.bottom()) - y }
    });
    let Some(all) = all else { return Vec::new() };
    let is_filled = cells.iter().map(|cell| cell.rect.pixels()).sum::<usize>() == all.pixels();
    if is_filled && cells.iter().all(|cell| cell.samples == cells[0].samples) {
        return vec![(all, cells.iter().collect())];
    }
    cells.iter().map(|cell| (cell.rect, vec![cell])).collect()
}

/// Samples of all files of a rectangle within a cell.
fn merged(files: &mut [FilmFile], cell: &Cell, rect: Rect) -> Result<FilmPart, MergeError> {
    let mut whole = FilmPart::new(rect);
    for (file, region) in &cell.sources {
        whole.absorb(files[*file].rows(*region, rect)?);
    }
    Ok(whole)
}
