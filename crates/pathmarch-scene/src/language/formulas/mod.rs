//! Formulas, and the names that they may use.

pub(crate) mod expression;
pub(crate) mod scope;
