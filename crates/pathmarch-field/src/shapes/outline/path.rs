//! Path of an SVG file in the xy plane, filled or drawn as a line: lines and Bézier curves as arcs ([`super::arcs`]).

use super::curve::WIDTH;
use super::{Drawn, Fill};
use crate::info::{Info, Outline};

/// A lens.
const LENS: &[[f32; 2]] = &[[0.0, -0.5], [0.3, 0.0], [0.0, 0.5], [-0.3, 0.0]];

pub(crate) static SHAPE: Drawn = Drawn {
    info: Info::new(
        "path",
        "Profile: a path in the notation of SVG, filled or drawn as a line; y points up.",
        "SVG 2, chapter 9; Bolton 1975; Frisken et al. 2000",
    )
    .inexact()
    .profile()
    .outline(Outline::Path),
    params: &[WIDTH],
    fill: Fill::NonZero,
    curved: true,
    default_outline: &[LENS],
};
