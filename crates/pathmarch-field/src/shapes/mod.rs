//! Shapes. A name in the list below is a file and its registration; names behind a colon are files of that folder, and the
//! last group is the shapes that are drawn.
//!
//! [`ShapeDef`] is what a file implements, generic over the number type. [`Shape`] is the object-safe form by which a field
//! calls all shapes.

mod definition;
mod dispatch;
mod entry;
pub(crate) mod orbit;
pub mod outline;

pub use definition::ShapeDef;
pub use dispatch::{Emitter, EvalShape, Shape, ShapeRef, TRAPS};
use entry::Entry;

macro_rules! shapes {
    ($($module:ident),* $(,)? $(; $folder:ident: $($inner:ident),* $(,)?)*; & $drawn:ident: $($outline:ident),* $(,)?) => {
        $(mod $module;)*
        $(mod $folder {
            $(pub(super) mod $inner;)*
        })*
        /// Every shape, in this order.
        pub(crate) static ALL: &[&'static dyn Shape] = &[
            $(&Entry::<$module::Shape>::new(),)*
            $($(&Entry::<$folder::$inner::Shape>::new(),)*)*
            $(&$drawn::$outline::SHAPE),*
        ];
    };
}

shapes!(
    sphere,
    r#box,
    rounded_box,
    plane,
    rect,
    disc,
    cylinder,
    cone,
    capsule,
    ellipsoid,
    torus,
    link,
    prism,
    hexprism,
    pyramid,
    octahedron;
    fractals:
    mandelbulb,
    mandelbox,
    julia,
    menger,
    sierpinski,
    apollonian,
    kleinian,
    ifs;
    profiles:
    circle,
    rectangle,
    star;
    &outline:
    polygon,
    curve,
    path,
    text,
);

/// The box, which clips custom shapes.
pub(crate) use r#box::Shape as Box;
