//! Cache of what a scene needs besides its text and is costly to make: pictures of the sky and of textures, computed
//! days, fonts, meshes, compiled custom SDFs.
//!
//! An edited text is read again after every change, and most changes do not concern the sky. The cache contains what
//! the last readings used: a picture by its file's path, size and time of change, a day by its parameters, a custom SDF
//! by its text. An unchanged sky is the same `Arc`, so that renderers detect changes by its address. Cost: the picture
//! of the last sky, twice once its strength or rotation has changed, at most 192 MiB; 1.5 MiB for each day; the last 16
//! pictures of textures; the last 256 meshes.

use crate::atmosphere::Day;
use crate::environment::{Environment, EnvironmentError, Loaded};
use crate::light::Light;
use crate::mesh_files::{MeshFile, MeshFileError};
use crate::textures::{Picture as Texture, PictureError};
use pathmarch_field::custom_sdf::glsl::Shader;
use pathmarch_field::custom_sdf::{Code, CodeDiagnostic};
use pathmarch_mesh::{Imported, files};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Days that are kept: enough for steps back and forth.
const DAYS: usize = 8;

/// Fonts that are kept.
const FONTS: usize = 4;
/// Larger files are no fonts.
const MAX_FONT_BYTES: u64 = 64 << 20;

/// Meshes that are kept.
const MESHES: usize = 256;

/// Codes of fields that are kept: those of a scene, and steps back and forth.
const CODES: usize = 128;

/// Source of a custom SDF.
#[derive(PartialEq)]
struct CodeSource {
    identifier: String,
    params: Vec<String>,
    text: String,
    /// Name of the distance function of a shader in GLSL; `None` for WGSL.
    function: Option<String>,
}

/// Identity of a file when it was read.
#[derive(PartialEq)]
struct Source {
    path: PathBuf,
    modified: Option<SystemTime>,
    bytes: u64,
}

impl Source {
    /// Present identity of the file at `path`.
    fn now(path: &Path) -> Self {
        let meta = files::metadata(path).ok();
        Self {
            path: path.to_owned(),
            modified: meta.and_then(|meta| meta.modified),
            bytes: meta.map_or(0, |meta| meta.bytes),
        }
    }
}

/// A picture of the sky as a scene uses it.
#[derive(Clone)]
pub(crate) struct Picture {
    pub(crate) environment: Arc<Environment>,
    /// Width and height in the file, texels.
    pub(crate) size: (u32, u32),
    /// As in [`Loaded`].
    pub(crate) repaired: u64,
}

/// Pictures of textures that are kept.
const TEXTURES: usize = 16;

/// Skies and textures of the last readings of a text.
#[derive(Default)]
pub(crate) struct Assets {
    /// True if only files of the scene's folder are read.
    pub(crate) confined: bool,
    source: Option<Source>,
    /// Picture of `source` as used last, with its strength.
    picture: Option<(f32, Picture)>,
    /// Unscaled picture of `source`, once a second strength or rotation was used.
    original: Option<Environment>,
    days: Vec<(Day, Arc<Environment>, Option<Light>)>,
    codes: Vec<(CodeSource, Arc<Code>)>,
    /// The last ones used come first.
    textures: Vec<(Source, Arc<Texture>)>,
    fonts: Vec<(Source, Arc<[u8]>)>,
    meshes: Vec<(Source, u32, Arc<MeshFile>)>,
    /// The last mesh file of which single nodes were used.
    imported: Option<(Source, Arc<Imported>)>,
}

impl Assets {
    /// Those of a scene that reads no file outside its folder.
    pub(crate) fn confined() -> Self {
        Self { confined: true, ..Self::default() }
    }
    /// The picture in the file at `path`, with this factor of radiance and turn in degrees.
    pub(crate) fn picture(&mut self, path: &Path, strength: f32, rotate: f32) -> Result<Picture, EnvironmentError> {
        let source = Source::now(path);
        let known = self.picture.take().filter(|_| self.source.as_ref() == Some(&source));
        let picture = match known {
            Some((factor, known)) if factor == strength && known.environment.rotate == rotate => known,
            Some((_, known)) => {
                let original = match self.original.take() {
                    Some(original) => original,
                    None => Environment::load(path, 1.0)?.environment,
                };
                let mut environment = Environment { rotate, ..original.clone() };
                environment.scale(strength);
                self.original = Some(original);
                Picture { environment: Arc::new(environment), ..known }
            }
            None => {
                self.original = None;
                let Loaded { environment, size, repaired } = Environment::load(path, strength)?;
                Picture { environment: Arc::new(Environment { rotate, ..environment }), size, repaired }
            }
        };
        self.source = Some(source);
        self.picture = Some((strength, picture.clone()));
        Ok(picture)
    }

    /// The code of a field in WGSL: read and compiled once for each text.
    pub(crate) fn code(
        &mut self,
        identifier: &str,
        params: &[String],
        text: &str,
    ) -> Result<Arc<Code>, Vec<CodeDiagnostic>> {
        let (identifier, text) = (identifier.to_owned(), text.to_owned());
        let source = CodeSource { identifier, params: params.to_vec(), text, function: None };
        self.compiled(source, |source| Code::new(&source.identifier, params, &source.text))
    }

    /// The code of a field in GLSL, as [`Self::code`].
    pub(crate) fn shader(
        &mut self,
        identifier: &str,
        params: &[String],
        text: &str,
        shader: &Shader,
    ) -> Result<Arc<Code>, Vec<CodeDiagnostic>> {
        let (identifier, text) = (identifier.to_owned(), text.to_owned());
        let function = Some(shader.function.clone());
        let source = CodeSource { identifier, params: params.to_vec(), text, function };
        self.compiled(source, |source| Code::of_shader(&source.identifier, shader))
    }

    fn compiled(
        &mut self,
        source: CodeSource,
        compile: impl FnOnce(&CodeSource) -> Result<Code, Vec<CodeDiagnostic>>,
    ) -> Result<Arc<Code>, Vec<CodeDiagnostic>> {
        let known = self.codes.iter().position(|(other, _)| *other == source);
        let (source, code) = match known {
            Some(index) => self.codes.remove(index),
            None => {
                let code = Arc::new(compile(&source)?);
                (source, code)
            }
        };
        self.codes.truncate(CODES - 1);
        self.codes.insert(0, (source, code.clone()));
        Ok(code)
    }

    /// The picture of a texture in the file at `path`; `encoded` where its codes stand for colours.
    pub(crate) fn texture(&mut self, path: &Path, encoded: bool) -> Result<Arc<Texture>, PictureError> {
        self.texels(path, (encoded, false), || Texture::load(path, encoded))
    }

    /// The picture of a decal in the file at `path`, with its alpha.
    pub(crate) fn decal(&mut self, path: &Path) -> Result<Arc<Texture>, PictureError> {
        self.texels(path, (true, true), || Texture::load_with_alpha(path))
    }

    fn texels(
        &mut self,
        path: &Path,
        kind: (bool, bool),
        load: impl FnOnce() -> Result<Texture, PictureError>,
    ) -> Result<Arc<Texture>, PictureError> {
        let source = Source::now(path);
        let is_it = |(known, picture): &(Source, Arc<Texture>)| {
            *known == source && (picture.encoded, picture.has_alpha) == kind
        };
        let picture = match self.textures.iter().position(is_it) {
            Some(index) => self.textures.remove(index).1,
            None => Arc::new(load()?),
        };
        self.textures.truncate(TEXTURES - 1);
        self.textures.insert(0, (source, picture.clone()));
        Ok(picture)
    }

    /// The bytes of the font in the file at `path`, or why there are none.
    pub(crate) fn font(&mut self, path: &Path) -> Result<Arc<[u8]>, String> {
        let source = Source::now(path);
        let known = self.fonts.iter().position(|(known, _)| *known == source);
        let (source, bytes) = match known.map(|index| self.fonts.remove(index)) {
            Some(known) => known,
            None if source.bytes > MAX_FONT_BYTES => {
                return Err(format!("it is larger than {} MiB", MAX_FONT_BYTES >> 20));
            }
            // A folder or a pipe may give no end of bytes, or wait for them.
            None if files::metadata(path).is_ok_and(|meta| !meta.is_file) => return Err("it is not a file".to_owned()),
            None => (source, files::read(path).map_err(|error| error.to_string())?.into()),
        };
        self.fonts.truncate(FONTS - 1);
        self.fonts.insert(0, (source, Arc::clone(&bytes)));
        Ok(bytes)
    }

    /// The mesh in the file at `path`: one of its nodes with a mesh, from 1, or all for 0. Files that it names are not
    /// watched.
    pub(crate) fn mesh(&mut self, path: &Path, node: u32) -> Result<Arc<MeshFile>, MeshFileError> {
        let source = Source::now(path);
        let file = match self.meshes.iter().position(|(known, of, _)| *known == source && *of == node) {
            Some(index) => self.meshes.remove(index).2,
            None if node == 0 => Arc::new(MeshFile::load(path)?),
            None => {
                let imported = match self.imported.take().filter(|(known, _)| *known == source) {
                    Some((_, imported)) => imported,
                    None => Arc::new(MeshFile::read(path)?),
                };
                self.imported = Some((Source::now(path), Arc::clone(&imported)));
                Arc::new(MeshFile::of_node(&imported, node)?)
            }
        };
        self.meshes.truncate(MESHES - 1);
        self.meshes.insert(0, (source, node, Arc::clone(&file)));
        Ok(file)
    }

    /// The sky of a day and its sun.
    pub(crate) fn day(&mut self, day: &Day) -> (Arc<Environment>, Option<Light>) {
        let (environment, sun) = match self.days.iter().position(|(known, ..)| known == day) {
            Some(index) => {
                let (_, environment, sun) = self.days.remove(index);
                (environment, sun)
            }
            None => {
                let (environment, sun) = day.bake();
                (Arc::new(environment), sun)
            }
        };
        self.days.truncate(DAYS - 1);
        self.days.insert(0, (day.clone(), environment.clone(), sun));
        (environment, sun)
    }
}
