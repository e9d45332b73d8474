//! `pathmarch merge`: merges films that were rendered in parts.

use crate::film_notes::{self, is_film};
use pathmarch_cli::{DONE, Failure, check_output, note};
use pathmarch_render::image::{self, ImageFormat};
use pathmarch_render::parts::{FilmFile, FilmHeader, MergeError, Rect, merge};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Films to merge
    #[arg(required = true)]
    films: Vec<PathBuf>,
    /// Film or picture to write: .film, .png, .jpg or .exr; a picture needs all samples of all its pixels
    #[arg(short, long, value_name = "FILE", required = true)]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let output = &arguments.output;
    let is_film = is_film(output);
    if !is_film {
        ImageFormat::from_path(output)
            .map_err(|error| Failure::Usage(format!("{error}; or .film, to merge it with others later")))?;
    }
    check_output(output)?;
    let films = arguments.films.iter().map(|path| FilmFile::open(path)).collect::<Result<Vec<_>, _>>();
    let mut films = films.map_err(Failure::other)?;
    let count = films.len();
    if is_film {
        let header = merge(&mut films, output).map_err(failure)?;
        note!("wrote {} of {count} films", output.display());
        missing(&header).iter().for_each(|gap| note!("note: {gap}"));
        return Ok(DONE);
    }
    let temporary = output.with_extension("film.merging");
    let header = merge(&mut films, &temporary).map_err(failure);
    let written = header.and_then(|header| write_picture(&header, &temporary, output));
    let _ = std::fs::remove_file(&temporary);
    let samples = written?;
    note!("wrote {} of {count} films, {samples} samples", output.display());
    Ok(DONE)
}

fn failure(error: MergeError) -> Failure {
    match error {
        MergeError::File(error) => Failure::other(error),
        other => Failure::Usage(other.to_string()),
    }
}

/// Samples and pixels that a complete film would have and this has not.
fn missing(header: &FilmHeader) -> Vec<String> {
    let [start, end] = header.samples;
    let mut gaps: Vec<String> = header
        .regions
        .iter()
        .map(|region| (region.rect, region.samples().missing_from(start..end)))
        .filter(|(_, samples)| !samples.is_empty())
        .map(|(rect, samples)| format!("the samples {samples} of the pixels {rect} are missing"))
        .collect();
    let whole = Rect::of(header.size);
    let present: usize = header.regions.iter().map(|region| region.rect.pixels()).sum();
    if present < whole.pixels() {
        let rects: Vec<String> = header.regions.iter().map(|region| region.rect.to_string()).collect();
        gaps.push(format!("pixels are missing: of {whole} only {} are there", rects.join(", ")));
    }
    gaps
}

/// Writes the picture of a complete film, and returns its number of samples.
fn write_picture(header: &FilmHeader, film: &Path, output: &Path) -> Result<u32, Failure> {
    let gaps = missing(header);
    if !gaps.is_empty() {
        let help = "merge all parts, or write a .film to merge it later";
        return Err(Failure::Usage(format!("the films are not a whole picture: {}; {help}", gaps.join("; "))));
    }
    let film = FilmFile::open(film).and_then(|mut film| film.part()).map_err(Failure::other)?.film();
    let mode = film_notes::mode(header);
    let (display, provenance) =
        (mode.display(film_notes::display(header, &film)), film_notes::provenance(header, film.samples));
    image::save(output, &mode.picture(&film), &display, &provenance).map_err(Failure::other)?;
    Ok(film.samples)
}
