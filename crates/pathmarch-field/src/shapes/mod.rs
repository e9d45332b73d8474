//! The shapes. A name in this list is a file and its registration; those of folders stand behind their names, the last one
//! being that of shapes that are drawn.

use crate::registry::{Entry, Shape};
use std::marker::PhantomData;

macro_rules! shapes {
    ($($module:ident),* $(,)? $(; $folder:ident: $($inner:ident),* $(,)?)*; & $last:ident: $($drawn:ident),* $(,)?) => {
        $(mod $module;)*
        $(mod $folder {
            $(pub(super) mod $inner;)*
        })*
        mod $last {
            $(pub(super) mod $drawn;)*
        }
        /// Every shape, in this order.
        pub(crate) static ALL: &[&'static dyn Shape] = &[
            $(&Entry::<$module::Shape>(PhantomData),)*
            $($(&Entry::<$folder::$inner::Shape>(PhantomData),)*)*
            $(&$last::$drawn::SHAPE),*
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
    &outlines:
    polygon,
    text,
);

/// The box, which bounds what is cut by one.
pub(crate) use r#box::Shape as Box;
