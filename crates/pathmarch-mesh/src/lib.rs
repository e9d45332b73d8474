#![doc = include_str!("../README.md")]
//!
//! [`read`] reads files, [`bvh`] intersects rays and finds closest points, [`grid`] makes distance fields, [`report`] checks what a
//! mesh needs for that. This crate has no GPU and no light.

mod bounds;
pub mod bvh;
pub mod files;
pub mod grid;
pub mod import;
pub mod material;
pub mod printing;
mod read;
pub mod report;
mod tangents;
mod topology;
mod triangle_mesh;
mod winding;

pub use bounds::Bounds;
pub use bvh::Bvh;
pub use grid::{DistanceGrid, GridArrays};
pub use import::Imported;
pub use material::Material;
pub use printing::PrintReport;
pub use read::{EXTENSIONS, Mistake, ReadError, ReadOptions, read, read_bytes};
pub use report::MeshReport;
pub use triangle_mesh::{Dropped, MAX_COORDINATE, TriangleMesh};
pub use winding::WindingTree;
