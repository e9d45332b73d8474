//! Distances and gradients of a scene at many points.
//!
//! **Cost.** Eight points at a time, on all cores. Ctrl-C is seen between batches of a hundred thousand points.

use crate::fork;
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_field::number::{Real, Vec3};
use pyo3::prelude::*;
use rayon::prelude::*;
use wide::f32x8;

/// Points that are evaluated between two looks for signals.
const BATCH: usize = 100_000;
/// Points that are evaluated side by side.
const LANES: usize = 8;

/// Signed distance of each point to the nearest surface, metres; infinite in an empty scene.
pub fn distances(py: Python, field: &Field, points: &[[f32; 3]]) -> PyResult<Vec<f32>> {
    for_points(py, points, |p| field.distance(p).to_array())
}

/// Gradient of the distance at each point.
pub fn gradients(py: Python, field: &Field, points: &[[f32; 3]]) -> PyResult<Vec<[f32; 3]>> {
    for_points(py, points, |p| {
        let gradient = field.union_surface(p, &|_| f32x8::constant(0.5)).field.gradient;
        let [x, y, z] = [gradient.x, gradient.y, gradient.z].map(f32x8::to_array);
        std::array::from_fn(|lane| [x[lane], y[lane], z[lane]])
    })
}

/// Evaluates a function at all points, without the interpreter's lock.
fn for_points<T: Copy + Send>(
    py: Python,
    points: &[[f32; 3]],
    value: impl Fn(Vec3<f32x8>) -> [T; LANES] + Sync,
) -> PyResult<Vec<T>> {
    fork::check()?;
    let mut values = Vec::with_capacity(points.len());
    for batch in points.chunks(BATCH) {
        let of_chunk = |chunk: &[[f32; 3]]| value(in_lanes(chunk)).into_iter().take(chunk.len()).collect::<Vec<_>>();
        let found: Vec<Vec<T>> = py.detach(|| batch.par_chunks(LANES).with_min_len(64).map(of_chunk).collect());
        values.extend(found.into_iter().flatten());
        py.check_signals()?;
    }
    Ok(values)
}

/// Up to eight points side by side; the last one fills the rest.
fn in_lanes(points: &[[f32; 3]]) -> Vec3<f32x8> {
    let last = points.len().saturating_sub(1);
    let axis = |axis: usize| f32x8::new(std::array::from_fn(|lane| points[lane.min(last)][axis]));
    Vec3::new(axis(0), axis(1), axis(2))
}
