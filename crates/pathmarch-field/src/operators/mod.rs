//! Operators, which make one solid of several. A name in the list below is a file and its registration.
//!
//! [`OperatorDef`] is what a file implements, generic over the number type. [`Operator`] is the object-safe form by which a field
//! calls all operators.

mod definition;
mod dispatch;
mod entry;

pub use definition::OperatorDef;
pub use dispatch::{Boolean, EvalOperator, Operator};
use entry::Entry;

macro_rules! operators {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        /// Every operator, in this order.
        pub(crate) static ALL: &[&'static dyn Operator] = &[$(&Entry::<$module::Op>::new()),*];
    };
}

operators!(union, subtract, intersect, morph);

/// The union, which joins objects and the children of modifiers.
pub(crate) static UNION: &dyn Operator = &Entry::<union::Op>::new();
