//! Modifiers, which change the domain or the distance of one child. A name in the list below is a file and its registration.
//!
//! [`ModifierDef`] is what a file implements, generic over the number type. [`Modifier`] is the object-safe form by which a field
//! calls all modifiers.

mod bounding_box;
mod definition;
mod dispatch;
mod entry;

pub use definition::{ModifierDef, Motion};
pub use dispatch::{EvalModifier, Modifier};
use entry::Entry;

macro_rules! modifiers {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        /// Every modifier, in this order.
        pub(crate) static ALL: &[&'static dyn Modifier] = &[$(&Entry::<$module::Op>::new()),*];
    };
}

modifiers!(repeat, polar, mirror, twist, bend, elongate, round, shell, displace, extrude, revolve);
