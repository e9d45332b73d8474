//! NumPy arrays of pictures and points.

use numpy::{AllowTypeChange, Element, PyArray1, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods};
use pathmarch_render::image::Picture;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Array of height x width x 3 numbers, without a copy.
pub fn of_picture(py: Python, picture: Picture) -> PyResult<Bound<PyAny>> {
    let shape = [picture.height as usize, picture.width as usize, 3];
    of_values(py, picture.pixels.into_flattened(), &shape)
}

/// Array of values in rows, without a copy.
pub fn of_values<'py, T: Element>(py: Python<'py>, values: Vec<T>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let flat = PyArray1::from_vec(py, values);
    let array: Bound<PyArrayDyn<T>> = flat.reshape(shape.to_vec())?;
    Ok(array.into_any())
}

/// Picture of an array of height x width x 3 numbers.
///
/// # Errors
/// `ValueError` for other shapes, and the error of NumPy for what is no array of numbers.
pub fn picture(array: &Bound<PyAny>) -> PyResult<Picture> {
    let (numbers, shape) = numbers(array)?;
    let &[height, width, 3] = &shape[..] else {
        return Err(PyValueError::new_err(format!("picture: expected height x width x 3 numbers, not {shape:?}")));
    };
    let side = |side: usize| u32::try_from(side).map_err(|_| PyValueError::new_err("picture: too large"));
    Ok(Picture { width: side(width)?, height: side(height)?, pixels: triples(&numbers) })
}

/// Points of an array whose last axis has x, y and z, and the lengths of its other axes.
///
/// # Errors
/// `ValueError` for other shapes, and the error of NumPy for what is no array of numbers.
pub fn points(array: &Bound<PyAny>) -> PyResult<(Vec<[f32; 3]>, Vec<usize>)> {
    let (numbers, mut shape) = numbers(array)?;
    if shape.pop() != Some(3) {
        let message = "points: the last axis must have three numbers, x, y and z, as in an array of N x 3";
        return Err(PyValueError::new_err(message));
    }
    Ok((triples(&numbers), shape))
}

/// Numbers of an array in rows, and its shape.
fn numbers(array: &Bound<PyAny>) -> PyResult<(Vec<f32>, Vec<usize>)> {
    let array: PyArrayLikeDyn<f32, AllowTypeChange> = array.extract()?;
    let array = array.as_array();
    Ok((array.iter().copied().collect(), array.shape().to_vec()))
}

fn triples(numbers: &[f32]) -> Vec<[f32; 3]> {
    numbers.as_chunks::<3>().0.to_vec()
}
