//! All tests of meshes in one program, which is compiled and linked once.

mod grid;
mod oracle;
mod readers;
mod shapes;
