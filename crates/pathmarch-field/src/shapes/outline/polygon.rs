//! Polygon in the xy plane with any number of points: an outline ([`super`]) with the even-odd rule.

use super::{Drawn, Fill};
use crate::info::{Info, Outline};

/// An arrow upwards.
const ARROW: &[[f32; 2]] = &[[-0.2, -0.5], [0.2, -0.5], [0.2, 0.0], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [-0.2, 0.0]];

pub(crate) static SHAPE: Drawn = Drawn {
    info: Info::new(
        "polygon",
        "Profile: what the lines between points go around.",
        "Quilez 2008, polygon; Frisken et al. 2000",
    )
    .inexact()
    .profile()
    .outline(Outline::Points),
    params: &[],
    fill: Fill::EvenOdd,
    curved: false,
    default_outline: &[ARROW],
};
