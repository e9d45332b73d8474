//! What reads random inputs.

use super::mutation::{Random, mutate};
use clap::ValueEnum;
use pathmarch_mesh::{ReadOptions, read_bytes};
use pathmarch_render::image::load;
use pathmarch_render::parts::FilmFile;
use pathmarch_render::pathmarch_field::custom_sdf::Code;
use pathmarch_render::pathmarch_field::custom_sdf::glsl::Shader;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Mode, RenderError, Renderer, Settings, kernel_wgsl};
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
    /// Code of custom shapes in WGSL.
    Wgsl,
    /// Code of custom shapes in GLSL.
    Glsl,
    /// Fields: their kernel is validated, and they are rendered on the CPU.
    Field,
    /// Fields on the GPU, several in a kernel, because its compiler takes most of the time.
    GpuField,
}

impl Target {
    /// Random input.
    pub(super) fn input(self, random: &mut Random, seeds: &[Vec<u8>]) -> Vec<u8> {
        if let Self::Field | Self::GpuField = self {
            return fields(random, self.cases()).into_bytes();
        }
        let seed = random.pick(seeds).clone();
        let other = random.pick(seeds).clone();
        mutate(random, &seed, &other)
    }

    /// Number of cases of an input.
    pub(super) fn cases(self) -> u64 {
        if self == Self::GpuField { FIELDS } else { 1 }
    }

    /// Longest time for an input: a second, but compilers of software GPUs take longer for a few fields.
    pub(super) fn limit(self) -> Duration {
        Duration::from_secs(if self == Self::GpuField { 60 } else { 1 })
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
            Self::Film => write().map(|()| FilmFile::open(&file).and_then(|mut film| film.parts()).is_ok()),
            Self::Mesh => Ok(["obj", "stl", "ply"]
                .iter()
                .any(|extension| read_bytes(input, extension, &file, &ReadOptions::default()).is_ok())),
            Self::Wgsl => Ok(Code::new("a", &[], &String::from_utf8_lossy(input)).is_ok()),
            Self::Glsl => {
                let read = Shader::read(&String::from_utf8_lossy(input), None, &[]);
                Ok(read.and_then(|shader| Code::of_shader("a", &shader)).is_ok())
            }
            Self::Field => on_cpu(&String::from_utf8_lossy(input)),
            Self::GpuField => on_gpu(&String::from_utf8_lossy(input)),
        }
    }
}

/// Number of random fields in a kernel of a GPU.
const FIELDS: u64 = 8;

thread_local! {
    /// The GPU, or the reason why there is none.
    static GPU: Result<Renderer, String> = Renderer::open(Backend::Gpu, None).map_err(|error| error.to_string());
}

/// Reason why there is no GPU for the fields.
pub(super) fn without_gpu() -> Option<String> {
    GPU.with(|gpu| gpu.as_ref().err().cloned())
}

/// Validates the kernel of a scene, and renders a few pixels on the CPU.
fn on_cpu(text: &str) -> Result<bool, String> {
    let Ok(scene) = Scene::parse("field.kdl", text) else { return Ok(false) };
    let settings = Settings { size: [4, 4], samples: 1, bounces: 1, ..Settings::of(&scene) };
    let code = kernel_wgsl(&scene, &settings, false).map_err(|error| error.to_string())?;
    let module = naga::front::wgsl::parse_str(&code).map_err(|error| error.emit_to_string(&code))?;
    let capabilities = naga::valid::Capabilities::all();
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| error.emit_to_string(&code))?;
    let renderer = Renderer::open(Backend::Cpu, None).map_err(|error| error.to_string())?;
    is_finite(&renderer, &scene, &settings)
}

/// Renders the normals of a scene on the GPU, with a kernel that is smaller than that of light.
fn on_gpu(text: &str) -> Result<bool, String> {
    let Ok(scene) = Scene::parse("field.kdl", text) else { return Ok(false) };
    let settings = Settings { size: [32, 8], samples: 1, mode: Mode::Normal, ..Settings::of(&scene) };
    GPU.with(|gpu| gpu.as_ref().map_or(Ok(false), |renderer| is_finite(renderer, &scene, &settings)))
}

/// Renders a scene; an error for samples that are not finite.
fn is_finite(renderer: &Renderer, scene: &Scene, settings: &Settings) -> Result<bool, String> {
    let film = match renderer.render(scene, settings) {
        // Software Vulkan refuses very slow fields, as it should.
        Err(RenderError::LoopLimit { .. }) => return Ok(false),
        other => other.map_err(|error| error.to_string())?,
    };
    if film.non_finite() > 0 { Err(format!("{} non-finite samples", film.non_finite())) } else { Ok(true) }
}

/// Scene of objects.
fn scene(objects: &str) -> String {
    format!("pathmarch 1\ncamera {{ position 0 0 40; target 0 0 0 }}\nsky 1\n{objects}")
}

/// Scene with random fields, side by side.
fn fields(random: &mut Random, number: u64) -> String {
    let mut objects = String::new();
    let mut count = 0;
    while count < number {
        let [x, y] = [5.0 * (count as f32 - number as f32 / 2.0), 0.0];
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
