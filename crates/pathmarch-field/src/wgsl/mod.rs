//! WGSL of a scene's field, and its parameters.

mod compose;

pub use crate::expression::{Expr, Function, distance_function, gradient_function};
pub use compose::{MAX_UNIFORM_VECTORS, Parameters, Program, ProgramOptions, TABLE};
