//! What reads random inputs.

use super::mutation::{Random, mutate};
use clap::ValueEnum;
use pathmarch_mesh::{ReadOptions, read_bytes};
use pathmarch_render::image::load;
use pathmarch_render::parts::FilmFile;
use pathmarch_render::pathmarch_field::custom_sdf::Code;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings, kernel_wgsl};
use std::path::Path;
use std::time::Duration;

/// What reads the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Target {
    /// Texts of scenes.
    Scene,
    /// Pictures: EXR, PNG and JPEG.
    Picture,
    /// Films.
    Film,
    /// Meshes: OBJ, STL and PLY.
    Mesh,
    /// Code of custom shapes.
    Wgsl,
    /// Fields: their kernel is validated, and rendered on both backends.
    Field,
}

impl Target {
    /// Random input.
    pub(super) fn input(self, random: &mut Random, seeds: &[Vec<u8>]) -> Vec<u8> {
        if self == Self::Field {
            return fields(random).into_bytes();
        }
        let seed = random.pick(seeds).clone();
        let other = random.pick(seeds).clone();
        mutate(random, &seed, &other)
    }

    /// Number of cases of an input.
    pub(super) fn cases(self) -> u64 {
        if self == Self::Field { FIELDS as u64 } else { 1 }
    }

    /// Longest time for an input: a second, but compilers of software GPUs take that for a few fields alone.
    pub(super) fn limit(self) -> Duration {
        Duration::from_secs(if self == Self::Field { 20 } else { 1 })
    }

    /// Reads an input: true if it is accepted; an error for a wrong result.
    pub(super) fn run(self, input: &[u8], scratch: &Path) -> Result<bool, String> {
        let file = scratch.join("input");
        let write = || std::fs::write(&file, input).map_err(|error| error.to_string());
        match self {
            Self::Scene => {
                let name = scratch.join("scene.kdl").display().to_string();
                Ok(Scene::parse(&name, &String::from_utf8_lossy(input)).is_ok())
            }
            Self::Picture => write().map(|()| load(&file).is_ok()),
            Self::Film => write().map(|()| FilmFile::open(&file).and_then(|mut film| film.part()).is_ok()),
            Self::Mesh => Ok(["obj", "stl", "ply"]
                .iter()
                .any(|extension| read_bytes(input, extension, &file, &ReadOptions::default()).is_ok())),
            Self::Wgsl => Ok(Code::new("a", &[], &String::from_utf8_lossy(input)).is_ok()),
            Self::Field => render(&String::from_utf8_lossy(input)),
        }
    }
}

/// Number of random fields of an input: with several in one kernel, a GPU compiles less often.
pub(super) const FIELDS: usize = 32;

thread_local! {
    /// The GPU, or the reason why there is none.
    static GPU: Result<Renderer, String> = Renderer::open(Backend::Gpu, None).map_err(|error| error.to_string());
}

/// Reason why there is no GPU for the fields.
pub(super) fn without_gpu() -> Option<String> {
    GPU.with(|gpu| gpu.as_ref().err().cloned())
}

/// Validates the kernel of a scene, and renders a few pixels on both backends.
fn render(text: &str) -> Result<bool, String> {
    let Ok(scene) = Scene::parse("field.kdl", text) else { return Ok(false) };
    let settings = Settings { size: [32, 16], samples: 1, bounces: 1, ..Settings::of(&scene) };
    let code = kernel_wgsl(&scene, &settings, false).map_err(|error| error.to_string())?;
    let module = naga::front::wgsl::parse_str(&code).map_err(|error| error.emit_to_string(&code))?;
    let capabilities = naga::valid::Capabilities::all();
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| error.emit_to_string(&code))?;
    let finite = |renderer: &Renderer| {
        let film = renderer.render(&scene, &settings).map_err(|error| error.to_string())?;
        if film.non_finite() > 0 { Err(format!("{} non-finite samples", film.non_finite())) } else { Ok(()) }
    };
    finite(&Renderer::open(Backend::Cpu, None).map_err(|error| error.to_string())?)?;
    GPU.with(|gpu| gpu.as_ref().map_or(Ok(()), finite))?;
    Ok(true)
}

/// Scene of objects.
fn scene(objects: &str) -> String {
    format!("pathmarch 1\ncamera {{ position 0 0 40; target 0 0 0 }}\nsky 1\n{objects}")
}

/// Scene with random fields, side by side.
fn fields(random: &mut Random) -> String {
    let mut objects = String::new();
    let mut count = 0;
    while count < FIELDS {
        let [x, y] = [5.0 * (count % 8) as f32 - 17.5, 5.0 * (count / 8) as f32 - 7.5];
        let field = solid(random, 1, &mut 12);
        let object = format!("object \"{count}\" {{\n  union {{\n    at {x} {y} 0\n{field}  }}\n}}\n");
        // Some operators refuse some children.
        if Scene::parse("field.kdl", &scene(&object)).is_ok() {
            objects += &object;
            count += 1;
        }
    }
    scene(&objects)
}

fn number(random: &mut Random, low: i32, high: i32) -> f32 {
    (low + random.below((high - low) as usize) as i32) as f32 / 10.0
}

/// Random solid with a pose.
fn solid(random: &mut Random, depth: u32, budget: &mut u32) -> String {
    *budget = budget.saturating_sub(1);
    let indent = "  ".repeat(depth as usize + 1);
    let [x, y, z] = [0; 3].map(|_| number(random, -10, 11));
    let pose = match random.below(4) {
        0 => String::new(),
        1 => format!("at {x} {y} {z}"),
        2 => format!("at {x} {y} {z}; rotate {} {} {}", 90.0 * x, 90.0 * y, 90.0 * z),
        _ => format!("at {x} {y} {z}; scale {}", number(random, 5, 20)),
    };
    let leaf = depth >= 4 || *budget == 0 || random.below(3) == 0;
    if leaf {
        // Sheets and profiles need a place of their own.
        let solids: Vec<_> =
            shapes().iter().map(|shape| shape.info()).filter(|info| !info.sheet && !info.profile).collect();
        return format!("{indent}{} {{ {pose} }}\n", random.pick(&solids).name);
    }
    let child = |random: &mut Random, budget: &mut u32| solid(random, depth + 1, budget);
    if random.below(3) == 0 {
        let name = &random.pick(modifiers()).info().name;
        return format!("{indent}{name} {{\n{}{indent}}}\n", child(random, budget));
    }
    let operator = random.pick(operators());
    let smooth = if operator.blends() { format!("smooth={}", number(random, 0, 5)) } else { String::new() };
    let children: String = (0..1 + random.below(3)).map(|_| child(random, budget)).collect();
    format!("{indent}{} {smooth} {{\n{children}{indent}}}\n", operator.info().name)
}
