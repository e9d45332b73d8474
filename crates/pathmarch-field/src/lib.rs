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
pub mod custom_sdf;
mod expression;
pub mod graph;
mod info;
pub mod lipschitz_check;
pub mod mesh;
mod modifiers;
pub mod number;
mod operators;
mod parameter;
mod ray_interval;
pub mod registry;
mod shapes;
pub mod wgsl;

pub use blend::{Blend, BlendProfile};
pub use bounds::Aabb;
pub use custom_sdf::CustomShape;
pub use graph::{Field, Node, Placement};
pub use info::{Info, Outline};
pub use mesh::Mesh;
pub use modifiers::{EvalModifier, Modifier, ModifierDef};
pub use operators::{Boolean, EvalOperator, Operator, OperatorDef};
pub use parameter::{Param, Unit};
pub use ray_interval::{RayInterval, T_MAX};
pub use registry::Solid;
pub use shapes::{Emitter, EvalShape, Shape, ShapeDef, ShapeRef, TRAPS, outline};
