//! All tests of meshes in one program, which is compiled and linked once.

mod readers;
mod shapes;
