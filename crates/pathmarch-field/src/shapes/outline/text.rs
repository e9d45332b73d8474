//! Text in the xy plane: the outlines of a font's glyphs ([`super`]), which the caller reads from the font. Glyphs may
//! overlap; their holes wind the other way.

use super::{Drawn, Fill};
use crate::info::{Info, Outline};
use crate::parameter::Param;

/// The letter T.
const LETTER: &[[f32; 2]] =
    &[[-0.07, 0.0], [0.07, 0.0], [0.07, 0.56], [0.27, 0.56], [0.27, 0.7], [-0.27, 0.7], [-0.27, 0.56], [-0.07, 0.56]];

pub(crate) static SHAPE: Drawn = Drawn {
    info: Info::new(
        "text",
        "Profile: letters that stand on the x axis, centred at x = 0.",
        "Quilez 2008, polygon; Frisken et al. 2000",
    )
    .inexact()
    .profile()
    .outline(Outline::Text),
    params: &[Param::length("size", 1.0, "Size of the font: the height of a line without the space between lines.")],
    fill: Fill::NonZero,
    curved: false,
    default_outline: &[LETTER],
};
