//! Cubes of two values by turns. The lattice lies a thousandth of a cube beside the origin, so that a face that lies in it,
//! such as a floor at y = 0, is of one side and not torn by rounding.

use super::{Param, Spot, TextureKind, TextureParameters};

pub(super) static KIND: TextureKind = TextureKind {
    name: "checker",
    doc: "Cubes of 0 and 1 by turns.",
    source: "Ebert et al. 2003",
    params: &[Param::length("size", 0.2, "Edge of a cube.")],
    step: |[size, ..]| 0.01 * size,
    value,
    wgsl: include_str!("checker.wgsl"),
};

fn value(spot: &Spot, &[size, ..]: &TextureParameters) -> f32 {
    let cell = (spot.p / size + 0.001).floor();
    let sum = cell.x + cell.y + cell.z;
    sum - 2.0 * (0.5 * sum).floor()
}
