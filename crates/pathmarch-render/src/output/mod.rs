//! Output: films, image files and tone mapping.

pub mod atomic_file;
pub mod exposure;
pub mod film;
pub(crate) mod half_films;
pub mod image;
pub mod parts;
pub mod tonemap;
