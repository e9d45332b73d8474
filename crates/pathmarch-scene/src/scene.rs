//! A scene as renderers see it: everything checked, names resolved to indices, numbers in linear Rec. 709, metres and
//! degrees. Right-handed, y up.

use crate::diagnostic::{Mistake, SceneError};
use crate::language;
use crate::materials::Material;
use crate::render_settings::RenderSettings;
use crate::sky::Sky;
use pathmarch_field::{Field, Node};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// When a scene is looked at. Formulas know it as `t` and `frame`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the first frame, which has the number 0; finite.
    pub seconds: f64,
    /// Number of the picture of an animation.
    pub frame: u32,
}

impl Moment {
    /// When the frame of this number begins, at so many frames a second.
    pub fn of_frame(frame: u32, fps: f32) -> Self {
        Self { seconds: f64::from(frame) / f64::from(fps), frame }
    }
    /// This many seconds after the start, in the frame that is shown then.
    pub fn of_seconds(seconds: f64, fps: f32) -> Self {
        Self { seconds, frame: (seconds * f64::from(fps) + 1e-6).floor().clamp(0.0, f64::from(u32::MAX)) as u32 }
    }
}

/// A number with a name, declared at the top of a file by `param`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, unlike those of the others.
    pub name: String,
    /// Its value at the moment of the scene.
    pub value: f32,
    /// The smallest and the largest value that is allowed, where there is one.
    pub range: (Option<f32>, Option<f32>),
    /// What it is, for people.
    pub doc: Option<String>,
    /// Whether its value depends on the moment.
    pub animated: bool,
}

/// Everything in a scene file.
#[derive(Clone, Debug)]
pub struct Scene {
    /// At least one; the first is the default. Their names differ.
    pub cameras: Vec<Camera>,
    /// Picture size, quality, and how light is followed.
    pub render: RenderSettings,
    /// Radiance of the surroundings.
    pub sky: Sky,
    /// Lights that are not objects, in the order they were written; the sun of a `sky "day"` is the last.
    pub lights: Vec<Light>,
    /// Materials in the order they were written, and last the default one if an object needed it.
    pub materials: Vec<Material>,
    /// Objects in the order they were written; their names differ.
    pub objects: Vec<Object>,
    /// The union of the objects. The `tag` of each leaf is the index of its material.
    pub field: Field,
    /// Parameters in the order they were written.
    pub params: Vec<Parameter>,
    /// Other files whose text it includes, in the order in which they were found.
    pub includes: Vec<PathBuf>,
    /// When this is: [`Moment::default`] unless said otherwise.
    pub moment: Moment,
    /// Whether anything of it depends on the moment.
    pub animated: bool,
    /// What is allowed but most likely not meant.
    pub warnings: Vec<Mistake>,
    /// Where the text came from: a path, as given to [`Scene::parse`].
    pub source_name: String,
    /// The text.
    pub source_text: String,
}

/// Where the picture is taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// `main` when not given.
    pub name: String,
    /// Position, metres.
    pub position: [f32; 3],
    /// The point in the middle of the picture, metres; differs from `position`.
    pub target: [f32; 3],
    /// Direction that is up in the picture, of length one, never parallel to the view.
    pub up: [f32; 3],
    /// Vertical field of view, degrees, above 0 and below 180.
    pub fov: f32,
    /// Radius of the thin lens, metres; 0 is a pinhole.
    pub lens_radius: f32,
    /// Distance that is in focus, metres; the distance to `target` when absent.
    pub focus: Option<f32>,
    /// Stops (EV) added for display, never to radiance.
    pub exposure: f32,
}

/// A light that is not an object and has no place in the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Light from far away.
    Sun {
        /// Towards the sun, of length one.
        direction: [f32; 3],
        /// On a surface that faces it, W/m².
        irradiance: [f32; 3],
        /// Apparent diameter, degrees, 0 to 180; 0 is parallel light.
        angle: f32,
        /// An approximation of soft shadows for a light without size: light that passes a surface within the angle
        /// 1/penumbra of it is dimmed, judged from the nearest misses of the march (Quilez 2010). Above 0; larger is
        /// sharper. `None` leaves shadows as they are.
        penumbra: Option<f32>,
    },
    /// Light from a point, the same in every direction.
    Point {
        /// Position, metres.
        at: [f32; 3],
        /// W/sr.
        intensity: [f32; 3],
        /// As that of the sun.
        penumbra: Option<f32>,
    },
}

/// A named solid.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Index into [`Scene::materials`] of the material of its shapes that name no other.
    pub material: usize,
    /// Its shapes; the tag of each is the index of the shape's material.
    pub root: Node,
}

impl Scene {
    /// The scene that `text` describes, or every mistake in it. `name` is where the text came from, for the report.
    ///
    /// # Errors
    /// [`SceneError::Mistakes`] with all of them; [`SceneError::Unreadable`] for a text of more than 16 MiB.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        Self::parse_at(name, text, Moment::default())
    }

    /// The scene that `text` describes at a moment. Several moments of one text: [`Animation`](crate::Animation).
    ///
    /// # Errors
    /// Those of [`Scene::parse`]; values of formulas that are not allowed say at which moment they are not.
    pub fn parse_at(name: &str, text: &str, moment: Moment) -> Result<Self, SceneError> {
        language::parse(name, text, moment)
    }

    /// The scene in the file at `path`.
    ///
    /// # Errors
    /// Those of [`Scene::parse`], and [`SceneError::Unreadable`] for a file that is missing, a directory, larger than
    /// 16 MiB, or not UTF-8.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::parse(&path.display().to_string(), &read_text(path)?)
    }
}

/// The text of the scene file at `path`, as it is.
///
/// # Errors
/// [`SceneError::Unreadable`] as of [`Scene::load`].
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    read(path).map_err(|(reason, help)| SceneError::Unreadable { name: path.display().to_string(), reason, help })
}

/// The text of a file; otherwise why not, and what to do.
fn read(path: &Path) -> Result<String, (String, String)> {
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => ("there is no such file".to_owned(), "Check the path.".to_owned()),
        ErrorKind::PermissionDenied => ("reading it is not permitted".to_owned(), "Check its permissions.".to_owned()),
        _ => (error.to_string(), "Check the path.".to_owned()),
    };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(("it is a directory".to_owned(), "Name a .kdl file in it.".to_owned()));
    }
    let mut bytes = Vec::new();
    // One byte more than allowed tells that there is more, whatever the file says of its size.
    file.take(language::MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() > language::MAX_BYTES {
        return Err(language::too_large());
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count();
        (format!("it is not UTF-8 text (line {line}, byte {at})"), "Save it as UTF-8.".to_owned())
    })
}
