//! Smooth curve through points in the xy plane, filled or drawn as a line: a spline ([`super::spline`]) as arcs, so that neither
//! its distance nor its normals have facets.

use super::{Drawn, Fill};
use crate::info::{Info, Outline};
use crate::parameter::Param;

/// A drop.
const DROP: &[[f32; 2]] = &[[0.0, -0.5], [0.4, -0.15], [0.15, 0.25], [0.0, 0.5], [-0.15, 0.25], [-0.4, -0.15]];

pub(super) const WIDTH: Param =
    Param::length_or_zero("width", 0.0, "Width of a line along the curve, with round ends; 0 fills it.");

pub(crate) static SHAPE: Drawn = Drawn {
    info: Info::new(
        "curve",
        "Profile: a smooth curve through points, filled or drawn as a line.",
        "Barry and Goldman 1988; Bolton 1975; Frisken et al. 2000",
    )
    .inexact()
    .profile()
    .outline(Outline::Curve),
    params: &[WIDTH],
    fill: Fill::EvenOdd,
    curved: true,
    default_outline: &[DROP],
};
