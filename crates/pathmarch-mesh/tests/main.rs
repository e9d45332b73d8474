//! All tests of meshes in one program, which is compiled and linked once.

mod bvh;
mod grid;
mod memory;
mod mutation;
mod oracle;
mod readers;
mod report;
mod shapes;
