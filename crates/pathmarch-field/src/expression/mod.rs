//! Expressions: one Rust function, recorded as a graph and printed as WGSL.
//!
//! Idea: calling a function generic over [`Real`](crate::number::Real) with [`Expr`] runs it once and keeps every
//! operation as a node of a graph; equal nodes are one node, so common subexpressions are shared by construction
//! (hash-consing; Ershov, "On Programming of Arithmetic Operations", 1958). The graph is printed as one readable
//! function. The same function called with `Dual<Expr>` prints its exact gradient. Cost: microseconds for each function.

mod expr;
mod print;

pub use expr::Expr;
pub use print::Function;
pub(crate) use print::identifier;

use crate::number::{Dual, Vec3};

/// Prints a distance written over [`Expr`] as a WGSL function `name(p: vec3f, …) -> f32`, each parameter an `f32`.
///
/// Registered shapes print themselves ([`Shape::wgsl_distance`](crate::Shape::wgsl_distance)); this is for functions that
/// are not registered.
pub fn distance_function(
    name: &str,
    doc: &str,
    parameters: &[&str],
    distance: impl Fn(Vec3<Expr>, &[Expr]) -> Expr,
) -> String {
    signature(name, doc, parameters)
        .print(&|inputs| vec![distance(Vec3::new(inputs[0], inputs[1], inputs[2]), &inputs[3..])])
}

/// Prints the same function's gradient (xyz) and distance (w) as a WGSL function `name(p: vec3f, …) -> vec4f`.
pub fn gradient_function(
    name: &str,
    doc: &str,
    parameters: &[&str],
    distance: impl Fn(Vec3<Dual<Expr>>, &[Dual<Expr>]) -> Dual<Expr>,
) -> String {
    signature(name, doc, parameters).print(&|inputs| {
        let parameters: Vec<_> = inputs[3..].iter().map(|&value| Dual::independent(value)).collect();
        let result = distance(Dual::variables(Vec3::new(inputs[0], inputs[1], inputs[2])), &parameters);
        vec![result.gradient.x, result.gradient.y, result.gradient.z, result.value]
    })
}

fn signature<'a>(name: &str, doc: &str, parameters: &[&'a str]) -> Function<'a> {
    let parameters = [("p", "vec3f")].into_iter().chain(parameters.iter().map(|&p| (p, "f32"))).collect();
    Function { name: identifier(name), doc: doc.to_owned(), parameters }
}
