#![doc = include_str!("../README.md")]
//!
//! [`Scene::parse`] turns the text of a scene file into a [`Scene`] (cameras, lights, materials, objects and their
//! distance field) or into a [`SceneError`] with every mistake at its place.
//! Shapes and operators come from `pathmarch_field`'s registry and materials from [`materials`]: this crate lists
//! neither, so the language grows with them. No GPU, no file writing.

mod animation;
mod assets;
pub mod atmosphere;
pub mod diagnostic;
pub mod document;
pub mod environment;
pub mod formatter;
mod language;
pub mod language_service;
pub mod light;
pub mod materials;
mod medium;
mod mesh_files;
mod mesh_materials;
pub mod navigation;
mod observer;
pub mod parts;
pub mod reference;
pub mod scene;
pub mod settings;
pub mod sky;
mod source;
mod source_text;
mod svg_path;
mod text;
pub mod textures;
mod unit;

pub use animation::Animation;
pub use atmosphere::Day;
pub use diagnostic::{Mistake, SceneError};
pub use document::Document;
pub use environment::Environment;
pub use light::Light;
pub use materials::{Material, MaterialKind};
pub use medium::Medium;
pub use mesh_files::{MeshProgress, set_mesh_cache, set_mesh_progress};
pub use parts::{PartsError, SceneParts};
pub use scene::{Camera, Moment, Object, Parameter, Scene};
pub use settings::{Caustics, DirectLighting, RenderSettings, Sampler, Tonemap};
pub use sky::Sky;
pub use source::{read_foreign_text, read_text};
pub use source_text::SourceText;
pub use unit::LengthUnit;
