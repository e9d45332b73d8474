//! Output: films, image files and tone mapping.

pub(crate) mod atomic_file;
pub mod film;
pub mod image;
pub mod parts;
pub mod tonemap;
