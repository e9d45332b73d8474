//! Volumes of signed distances, as files of NumPy.
//!
//! | Format | Contents |
//! |---|---|
//! | `.npy` | `array[x, y, z]` of 32-bit floats, metres, negative inside; `mesh "FILE.npy"` of the scene language reads it |
//! | `.npz` | the same as `distance`; `origin`, the position of `distance[0, 0, 0]`; `cell`, the distance of neighbours; metres |
//!
//! **Source.** NumPy Enhancement Proposal 1, version 1 of the format. **Cost.** A plane of the volume in memory.

use crate::output::atomic_file::AtomicFile;
use pathmarch_field::mesh::{DistanceGrid, Progress};
use std::io::{self, BufWriter, Seek, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Formats of volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeFormat {
    /// One array.
    Npy,
    /// An archive of arrays.
    Npz,
}

impl VolumeFormat {
    /// Format of a file name's extension, in any case; `None` if it is another one.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "npy" => Some(Self::Npy),
            "npz" => Some(Self::Npz),
            _ => None,
        }
    }
}

/// Failure of writing a volume.
#[derive(Debug, thiserror::Error)]
pub enum VolumeFileError {
    /// The file cannot be written.
    #[error("{path}: cannot be written: {source}; check that its directory exists, its permissions and the free space", path = path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The progress callback stopped it; no file is written.
    #[error("stopped")]
    Stopped,
}

/// Writes a volume. Replaces an existing file atomically.
///
/// # Errors
/// [`VolumeFileError`].
pub fn save(path: &Path, format: VolumeFormat, grid: &DistanceGrid, progress: Progress) -> Result<(), VolumeFileError> {
    let write_error = |source| VolumeFileError::Write { path: path.to_owned(), source };
    let mut writer = BufWriter::new(AtomicFile::create(path).map_err(write_error)?);
    let flow = match format {
        VolumeFormat::Npy => write_distances(&mut writer, grid, progress),
        VolumeFormat::Npz => write_archive(&mut writer, grid, progress),
    };
    if flow.map_err(write_error)?.is_break() {
        return Err(VolumeFileError::Stopped);
    }
    let file = writer.into_inner().map_err(|error| write_error(error.into_error()))?;
    file.commit().map_err(write_error)
}

fn write_archive(
    writer: &mut (impl Write + Seek),
    grid: &DistanceGrid,
    progress: Progress,
) -> io::Result<ControlFlow<()>> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    let mut archive = ZipWriter::new(writer);
    archive.start_file("origin.npy", options)?;
    write_header(&mut archive, "<f8", "(3,)")?;
    for v in grid.origin() {
        archive.write_all(&v.to_le_bytes())?;
    }
    archive.start_file("cell.npy", options)?;
    write_header(&mut archive, "<f8", "()")?;
    archive.write_all(&grid.cell().to_le_bytes())?;
    archive.start_file("distance.npy", options)?;
    let flow = write_distances(&mut archive, grid, progress)?;
    archive.finish()?;
    Ok(flow)
}

fn write_distances(writer: &mut dyn Write, grid: &DistanceGrid, progress: Progress) -> io::Result<ControlFlow<()>> {
    let [width, height, depth] = grid.size();
    write_header(writer, "<f4", &format!("({width}, {height}, {depth})"))?;
    for x in 0..width {
        if progress(x as f32 / width as f32).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        for distance in grid.plane(x) {
            writer.write_all(&distance.to_le_bytes())?;
        }
    }
    let _ = progress(1.0);
    Ok(ControlFlow::Continue(()))
}

/// Writes all that comes before the values, a multiple of 64 bytes.
fn write_header(writer: &mut dyn Write, kind: &str, shape: &str) -> io::Result<()> {
    let before: &[u8] = b"\x93NUMPY\x01\x00";
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let length = (before.len() + 2 + text.len() + 1).next_multiple_of(64) - before.len() - 2;
    writer.write_all(before)?;
    writer.write_all(&(length as u16).to_le_bytes())?;
    writeln!(writer, "{text:<0$}", length - 1)
}
