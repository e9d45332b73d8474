//! Pictures for screens: tone curves, and image files.

use crate::arrays;
use crate::failure::Failure;
use crate::names::find;
use pathmarch_render::image::{self, Display, ImageError, ImageFormat, Picture, Provenance};
use pathmarch_render::pathmarch_scene::Tonemap;
use pathmarch_render::pathmarch_scene::settings::EXPOSURE;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};

/// Colours of a screen for a picture of linear radiance: an array of 8-bit sRGB numbers.
///
/// `curve` is "agx", "neutral" or "srgb"; `exposure` is in stops.
///
/// >>> import numpy, pathmarch
/// >>> pathmarch.tonemap(numpy.full((1, 1, 3), 0.5), "srgb").tolist()
/// [[[188, 188, 188]]]
#[pyfunction]
#[pyo3(signature = (picture, curve = "agx", exposure = 0.0))]
pub fn tonemap<'py>(
    py: Python<'py>,
    picture: &Bound<'py, PyAny>,
    curve: &str,
    exposure: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let picture = arrays::picture(picture)?;
    let display = display(curve, exposure)?;
    let colours = |picture: &Picture| picture.pixels.iter().map(|&pixel| display.encode_8bit(pixel)).collect();
    let codes: Vec<[u8; 3]> = py.detach(|| colours(&picture));
    arrays::of_values(py, codes.into_flattened(), &[picture.height as usize, picture.width as usize, 3])
}

/// Bytes of an image file of a picture of linear radiance; `format` is "png", "jpg" or "exr".
///
/// PNG and JPEG get the tone curve and the exposure, EXR contains the picture as it is. In a notebook,
/// `IPython.display.Image(pathmarch.encode(picture))` shows it.
///
/// >>> import numpy, pathmarch
/// >>> pathmarch.encode(numpy.ones((4, 4, 3)))[1:4]
/// b'PNG'
#[pyfunction]
#[pyo3(signature = (picture, format = "png", curve = "agx", exposure = 0.0))]
pub fn encode<'py>(
    py: Python<'py>,
    picture: &Bound<'py, PyAny>,
    format: &str,
    curve: &str,
    exposure: f64,
) -> PyResult<Bound<'py, PyBytes>> {
    let picture = arrays::picture(picture)?;
    let display = display(curve, exposure)?;
    let name = PathBuf::from(format!("picture.{format}"));
    Ok(PyBytes::new(py, &py.detach(|| bytes(&name, &picture, &display))?))
}

/// Writes a picture of linear radiance as `.png`, `.jpg` or `.exr`.
///
/// PNG and JPEG get the tone curve and the exposure, EXR contains the picture as it is.
#[pyfunction]
#[pyo3(signature = (path, picture, curve = "agx", exposure = 0.0))]
pub fn save(py: Python, path: PathBuf, picture: &Bound<PyAny>, curve: &str, exposure: f64) -> PyResult<()> {
    let picture = arrays::picture(picture)?;
    let display = display(curve, exposure)?;
    let saved = py.detach(|| image::save(&path, &picture, &display, &provenance()));
    saved.map_err(|error| failure(error).into())
}

/// Picture of an `.exr`, `.png` or `.jpg` file, in linear light: a float32 array of height x width x 3.
#[pyfunction]
pub fn load(py: Python, path: PathBuf) -> PyResult<Bound<PyAny>> {
    let loaded = py.detach(|| image::load(&path)).map_err(failure)?;
    arrays::of_picture(py, loaded.picture)
}

fn bytes(path: &Path, picture: &Picture, display: &Display) -> Result<Vec<u8>, Failure> {
    let format = ImageFormat::from_path(path).map_err(failure)?;
    image::encode(path, format, picture, Vec::new(), display, &provenance()).map_err(failure)
}

fn provenance() -> Provenance {
    Provenance { version: env!("CARGO_PKG_VERSION").to_owned(), ..Provenance::default() }
}

fn failure(error: ImageError) -> Failure {
    let message = error.to_string();
    match error {
        ImageError::UnknownExtension { .. } | ImageError::Encode { .. } => Failure::Value(message),
        _ => Failure::File(message),
    }
}

fn display(curve: &str, exposure: f64) -> PyResult<Display> {
    let tonemap = find("curve", curve, Tonemap::ALL.map(|tonemap| (tonemap.name(), tonemap)))?;
    let exposure_stops = exposure as f32;
    if !EXPOSURE.accepts(exposure_stops) {
        let message = format!("exposure: must be a number {}, not {exposure}", EXPOSURE.in_words());
        return Err(PyValueError::new_err(message));
    }
    Ok(Display { tonemap, exposure_stops })
}
