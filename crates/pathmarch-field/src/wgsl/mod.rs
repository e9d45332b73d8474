//! Fields as WGSL: one Rust function recorded as an expression graph and printed.
//!
//! Idea: calling a function generic over [`Real`](crate::number::Real) with [`Expr`] runs it once and keeps every
//! operation as a node of a graph; equal nodes are one node, so common subexpressions are shared by construction
//! (hash-consing; Ershov, "On Programming of Arithmetic Operations", 1958). The graph is printed as one readable
//! function. The same function called with `Dual<Expr>` prints its exact gradient. Cost: microseconds for each function.

mod compose;
mod expr;
mod print;

pub use compose::{MAX_UNIFORM_VECTORS, Parameters, Program};
pub use expr::Expr;
pub(crate) use print::{Function, identifier};
