//! The shapes. A name in this list is a file and its registration.

use crate::registry::{Entry, Shape};
use std::marker::PhantomData;

macro_rules! shapes {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        /// Every shape, in this order.
        pub(crate) static ALL: &[&'static dyn Shape] = &[$(&Entry::<$module::Shape>(PhantomData)),*];
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
    octahedron,
);
