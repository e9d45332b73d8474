//! A scene as renderers see it: checked, with names resolved to indices. Colours are linear Rec. 709, lengths metres, angles
//! degrees; axes are right-handed, y up.

use crate::diagnostic::Mistake;
use crate::light::Light;
use crate::materials::Material;
use crate::medium::Medium;
use crate::settings::RenderSettings;
use crate::sky::Sky;
use crate::unit::LengthUnit;
use pathmarch_field::{Field, Node};
use std::path::PathBuf;

/// A moment of an animation. Formulas read it as `t` and `frame`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the first frame, which has the number 0; finite.
    pub seconds: f64,
    /// Frame number.
    pub frame: u32,
}

impl Moment {
    /// Start of a frame, at `fps` frames a second.
    pub fn of_frame(frame: u32, fps: f32) -> Self {
        Self { seconds: f64::from(frame) / f64::from(fps), frame }
    }
    /// Moment at `seconds` after the start, with the frame that is shown then.
    pub fn of_seconds(seconds: f64, fps: f32) -> Self {
        Self { seconds, frame: (seconds * f64::from(fps) + 1e-6).floor().clamp(0.0, f64::from(u32::MAX)) as u32 }
    }
}

/// A number with a name, declared at the top of a file by `param`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, unique among the parameters of a scene.
    pub name: String,
    /// Value at the moment of the scene.
    pub value: f32,
    /// Smallest and largest allowed value, if limited.
    pub range: (Option<f32>, Option<f32>),
    /// Help for people.
    pub doc: Option<String>,
    /// True if the value depends on the moment.
    pub animated: bool,
}

/// A scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Unit of lengths, for reports and exports.
    pub unit: LengthUnit,
    /// Cameras, at least one; the first is the default. Names are unique.
    pub cameras: Vec<Camera>,
    /// Size of the picture, quality, estimator.
    pub render: RenderSettings,
    /// Radiance of the surroundings.
    pub sky: Sky,
    /// Medium between the objects.
    pub fog: Medium,
    /// Lights that are not objects, in the order of the file; the sun of a `sky "day"` is last.
    pub lights: Vec<Light>,
    /// Materials in the order of the file; the default material is last, if an object needs it.
    pub materials: Vec<Material>,
    /// Objects in the order of the file. Names are unique.
    pub objects: Vec<Object>,
    /// Union of the objects. The `tag` of each leaf is the index of its material.
    pub field: Field,
    /// Parameters in the order of the file.
    pub params: Vec<Parameter>,
    /// Included files, in the order of inclusion.
    pub includes: Vec<PathBuf>,
    /// Moment of the scene; [`Moment::default`] for a still scene.
    pub moment: Moment,
    /// True if anything depends on the moment.
    pub animated: bool,
    /// Warnings: allowed, but most likely not intended.
    pub warnings: Vec<Mistake>,
    /// Path or name of the source, as given to [`Scene::parse`].
    pub source_name: String,
    /// Text of the source.
    pub source_text: String,
}

/// A camera: pinhole or thin lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name; `main` when absent.
    pub name: String,
    /// Position, metres.
    pub position: [f32; 3],
    /// Point in the middle of the picture, metres; differs from `position`.
    pub target: [f32; 3],
    /// Unit vector that is up in the picture, never parallel to the view.
    pub up: [f32; 3],
    /// Vertical field of view, degrees, above 0 and below 180.
    pub fov: f32,
    /// Radius of the thin lens, metres; 0 is a pinhole.
    pub lens_radius: f32,
    /// Distance in focus, metres; the distance to `target` when absent.
    pub focus: Option<f32>,
    /// Exposure for display, stops (EV); never applied to radiance.
    pub exposure: f32,
    /// True if the exposure is the one that suits the picture, instead of `exposure`.
    pub auto_exposure: bool,
}

/// A named solid.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name.
    pub name: String,
    /// Index into [`Scene::materials`]: material of the shapes that name no other.
    pub material: usize,
    /// Tree of shapes; the tag of each is the index of its material.
    pub root: Node,
}
