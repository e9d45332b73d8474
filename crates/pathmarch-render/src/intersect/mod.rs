//! Ray intersection: analytic shapes in closed form, all others by sphere tracing.

pub(crate) mod march;
pub(crate) mod ray;
