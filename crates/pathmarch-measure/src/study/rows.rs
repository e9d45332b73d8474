//! The rows of Tables 5.2 to 5.7 of the thesis: a view of a scene, with its published times.

use super::{Study, example};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::pathmarch_scene::Scene;

/// Row of a table.
pub struct Row {
    /// Number of the table.
    pub table: &'static str,
    /// What the thesis calls the row.
    pub title: &'static str,
    /// Figures: the thesis's program, and Cycles.
    pub figures: [&'static str; 2],
    /// Name of the scene.
    pub scene: &'static str,
    /// Name of the camera.
    pub camera: &'static str,
    /// Letter of the scene in `scripts/peers/render_thesis.py`; `None` where the program has no such light.
    pub program: Option<&'static str>,
    /// Published milliseconds of a frame of the thesis's program, 1280x720, Radeon R9 390.
    pub published: f64,
    /// Published time of Cycles 2.8 with 128 samples.
    pub cycles: &'static str,
}

const fn row(
    [table, title]: [&'static str; 2],
    figures: [&'static str; 2],
    [scene, camera]: [&'static str; 2],
    program: Option<&'static str>,
    published: f64,
    cycles: &'static str,
) -> Row {
    Row { table, title, figures, scene, camera, program, published, cycles }
}

const SPHERE: [&str; 2] = ["5.5", "5.6"];
const METAL: [&str; 2] = ["5.8", "5.9"];
const PRISM: [&str; 2] = ["5.10", "5.11"];
const ROOM: [&str; 2] = ["5.12", "5.13"];

/// All rows.
pub static ROWS: [Row; 13] = [
    row(["5.2", "Back of sphere"], SPHERE, ["diffuse-sphere", "main"], Some("a"), 7.0, "2:09 min"),
    row(["5.2", "Front of sphere"], SPHERE, ["diffuse-sphere", "front"], Some("a"), 6.0, "1:03 min"),
    row(["5.2", "Sphere detail"], SPHERE, ["diffuse-sphere", "detail"], Some("a"), 10.0, "3:14 min"),
    row(["5.3", "0.9 roughness"], METAL, ["metal-room-rough-90", "main"], Some("b"), 29.0, "2:55 min"),
    row(["5.3", "0.5 roughness"], METAL, ["metal-room-rough-50", "main"], Some("b"), 27.0, "2:50 min"),
    row(["5.3", "0.05 roughness"], METAL, ["metal-room-rough-05", "main"], Some("b"), 26.0, "2:46 min"),
    row(["5.4", "Left side"], PRISM, ["glass-prism", "left"], Some("c"), 29.0, "40 s"),
    row(["5.4", "Front side"], PRISM, ["glass-prism", "front"], Some("c"), 37.0, "1 min"),
    row(["5.4", "Right side"], PRISM, ["glass-prism", "main"], Some("c"), 31.0, "59 s"),
    row(["5.5", "Ambient light"], ROOM, ["open-room-sky", "main"], None, 14.3, "1 min"),
    row(["5.5", "Global light"], ROOM, ["open-room", "main"], Some("d"), 25.0, "1:15 min"),
    row(["5.6", "Emissive objects"], ["5.14", "5.14"], ["emitting-spheres", "main"], Some("e"), 14.3, "2 min"),
    row(["5.7", "Mandelbulb 8-powered"], ["5.16", "5.16"], ["grey-mandelbulb", "main"], Some("f"), 45.5, "29 s"),
];

impl Row {
    /// Short name for files.
    pub fn name(&self) -> String {
        match self.camera {
            "main" => self.scene.to_owned(),
            camera => format!("{}-{camera}", self.scene),
        }
    }

    /// Table and title.
    pub fn label(&self) -> String {
        format!("{}, {}", self.table, self.title.to_lowercase())
    }

    /// Scene, and settings of this view in a size, with the scene's own bounces.
    pub fn load(&self, size: [u32; 2]) -> Result<(Scene, Settings), Failure> {
        let scene = example(self.scene)?;
        let camera = scene.cameras.iter().position(|camera| camera.name == self.camera);
        let camera = camera.ok_or_else(|| Failure::Other(format!("{} has no camera {}", self.scene, self.camera)))?;
        let settings = Settings { size, camera, ..Settings::of(&scene) };
        Ok((scene, settings))
    }
}

/// Letter of the scene of this name in the thesis's program, if it has such a scene.
pub fn letter_of(scene: &str) -> Option<&'static str> {
    // Figure 5.1 is in no table.
    if scene == "three-spheres" {
        return Some("g");
    }
    ROWS.iter().find(|row| row.scene == scene && row.camera == "main")?.program
}

impl Study<'_> {
    /// Rows that are asked for: all, or in a trial the first of each scene kind.
    pub fn rows(&self) -> impl Iterator<Item = &'static Row> {
        let few = self.plan.few_rows;
        ROWS.iter().enumerate().filter(move |(index, _)| !few || index % 6 == 0).map(|(_, row)| row)
    }
}
