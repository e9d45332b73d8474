//! Cubes of two values by turns. The lattice lies a thousandth of a cube beside the origin, so that a face that lies in it,
//! such as a floor at y = 0, is of one side and not torn by rounding.

use super::noise::{TextureNumber, cell_of};
use super::{Param, Place, TextureKind, TextureParameters};
use pathmarch_field::number::Vec3;
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "checker",
    doc: "Cubes of 0 and 1 by turns.",
    source: "Ebert et al. 2003",
    params: &[Param::length("size", 0.2, "Edge of a cube.")],
    step: |[size, ..]| 0.01 * size,
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("checker.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(place: &Place<N>, &[size, ..]: &TextureParameters) -> N {
    let cell = cell_of(place.p / N::constant(size) + Vec3::constant([0.001; 3]));
    let sum = cell.x + cell.y + cell.z;
    sum - N::constant(2.0) * (sum * N::constant(0.5)).floor()
}
