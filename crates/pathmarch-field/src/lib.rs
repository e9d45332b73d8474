#![doc = include_str!("../README.md")]
//!
//! A shape is one file: its parameters, its source, its bounds, its Lipschitz constant, and its distance as one Rust
//! function generic over its number ([`number::Real`]). From that one function come the distance on the CPU (for one
//! point or eight), the exact gradient (dual numbers), and the WGSL of both (an expression graph, printed).
//!
//! [`registry`] lists the shapes and operators; [`graph`] composes them into a scene's field; [`wgsl`] prints that
//! field for the GPU; [`mesh`] makes triangles of it. This crate knows no files, no GPU and no light.

pub mod blend;
pub mod bounds;
pub mod graph;
pub mod mesh;
mod modifiers;
pub mod number;
mod operators;
mod orbit;
pub mod outline;
pub mod own;
pub mod registry;
mod shapes;
mod span;
pub mod survey;
pub mod wgsl;

pub use blend::{Blend, BlendProfile};
pub use bounds::Aabb;
pub use graph::{Field, Node, Placement};
pub use mesh::Mesh;
pub use own::OwnField;
pub use registry::{Combine, Emitter, Info, Modify, Param, Shape, ShapeRef, Solid, Unit};
