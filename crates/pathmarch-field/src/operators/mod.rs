//! The operators. A name in this list is a file and its registration.

use crate::registry::{Combine, Entry};
use std::marker::PhantomData;

macro_rules! operators {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        /// Every operator, in this order.
        pub(crate) static ALL: &[&'static dyn Combine] = &[$(&Entry::<$module::Op>(PhantomData)),*];
    };
}

operators!(union, subtract, intersect, morph);

/// What joins solids that stand side by side.
pub(crate) static UNION: &dyn Combine = &Entry::<union::Op>(PhantomData);
