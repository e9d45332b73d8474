#![doc = include_str!("../README.md")]
//!
//! Each shape is one file with its parameters, source, bounds, Lipschitz constant, and distance: one Rust function that is
//! generic over the number type ([`number::Real`]). The same function computes the distance on the CPU (for one point or
//! eight) and the exact gradient (dual numbers), and prints the WGSL of both (an expression graph).
//!
//! [`registry`] lists shapes, operators and modifiers; [`graph`] composes them to a scene's field; [`wgsl`] prints that field
//! for the GPU; [`mesh`] meshes it. This crate has no file access, no GPU and no light.

pub mod blend;
pub mod bounds;
pub mod custom_sdf;
mod expression;
pub mod graph;
mod info;
pub mod lipschitz_check;
pub mod mesh;
pub mod mesh_shape;
mod modifiers;
pub mod number;
mod operators;
mod parameter;
mod range;
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
pub use mesh_shape::{MeshAttributes, MeshGeometry, MeshOpacity, MeshShape, MeshSurface};
pub use modifiers::{EvalModifier, Modifier, ModifierDef};
pub use operators::{Boolean, EvalOperator, Operator, OperatorDef};
pub use parameter::{Param, Unit};
pub use pathmarch_mesh::{EXTENSIONS as MESH_EXTENSIONS, MeshReport, PrintReport};
pub use range::Range;
pub use ray_interval::{RayInterval, T_MAX};
pub use registry::Solid;
pub use shapes::{Emitter, EvalShape, Shape, ShapeDef, ShapeRef, TRAPS, outline};
