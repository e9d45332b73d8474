#![doc = include_str!("../README.md")]

mod bounds;
pub mod bvh;
mod triangle_mesh;

pub use bounds::Bounds;
pub use bvh::Bvh;
pub use triangle_mesh::{Dropped, MAX_COORDINATE, TriangleMesh};
