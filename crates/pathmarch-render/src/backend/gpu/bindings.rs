//! Bindings of the kernel, and the memory of each.
//!
//! A GPU reads uniform memory as fast as registers if all of its threads read the same address; storage memory suits reads of
//! different addresses. A software adapter (Mesa's llvmpipe) has other costs. In a branch, a read of storage memory is a loop
//! over the lanes, and a read of uniform memory a plain load. But a branch that depends on uniforms alone makes llvmpipe
//! recompile the kernel at every dispatch. On software adapters the kernel therefore reads the frame from storage once, before
//! the first branch, small tables are uniform, and others [textures](super::table_memory). Measured on two cores:
//! emitting-spheres 67 to 38 ms a sample at 480x270 (docs/performance.md).
//!
//! Each read of a uniform costs llvmpipe about as much as the arithmetic of a shape with it. In a kernel for one long
//! picture, the numbers of the field, of the frame and of [short tables](super::tables) are therefore constants, which its
//! compiler also folds: cornell-box 5.3 to 2.3 s, closed-metal-room 9.7 to 6.3 s for 64 samples at 480x270.

use super::device::KernelTarget;
use super::encode::LightRecord;
use super::slice::PIXELS_PER_LANE;
use super::table_memory::{Element, Memory, film_declaration, texture_length};
use super::tables::TableReaders;
use crate::backend::RenderInput;
use crate::mode::Mode;
use crate::scene::{FrameUniforms, LeafRecord, LightNode, MaterialRecord};
use crate::wgsl;
use pathmarch_field::wgsl::Program;

/// Binding numbers.
pub(crate) const FRAME: u32 = 0;
pub(super) const SLICE: u32 = 1;
pub(super) const PARAMETERS: u32 = 2;
pub(crate) const LEAVES: u32 = 3;
pub(super) const MATERIALS: u32 = 4;
pub(super) const LIGHTS: u32 = 5;
pub(super) const FILM: u32 = 6;
pub(super) const SCENE_DATA: u32 = 7;
/// Environment map, and the light tree unless it is in uniform memory.
pub(super) const VECTORS: u32 = 8;
/// Paths that the next dispatch resumes; only if loops are limited.
pub(super) const SUSPENDED: u32 = 9;
/// Guides of the pixels; only if they are recorded.
pub(super) const GUIDES: u32 = 10;
/// Light tree in uniform memory.
pub(crate) const LIGHT_TREE: u32 = 11;
const BINDINGS: u32 = 12;

/// Largest number of samples of a pixel in a dispatch of a long picture on a software adapter. The more, the less often the film
/// is read and written, and the later a dispatch ends.
const SEVERAL_SAMPLES: u32 = 4;

/// Size of a uniform binding that every adapter supports, bytes.
const UNIFORM_BYTES: usize = 1 << 16;

/// Memory of each buffer of a kernel.
pub(crate) struct Bindings {
    /// Memory of each buffer. Indexed by binding.
    memory: [Memory; BINDINGS as usize],
    software: bool,
    /// True if the adapter may end the loops of this kernel, see [`super::loop_limit`].
    pub(super) loops_are_limited: bool,
    /// True if the kernel records guides.
    pub(super) has_guides: bool,
    /// Largest number of samples of a pixel in a dispatch, each with a camera ray of its own.
    pub(super) samples_per_dispatch: u32,
    /// Pixels of a lane, eight columns apart.
    pub(super) pixels_per_lane: u32,
    readers: TableReaders,
    /// Numbers that the kernel contains; `None` if it reads them.
    constants: Option<Constants>,
}

/// Numbers of a picture as expressions in WGSL.
struct Constants {
    parameters: String,
    frame: String,
}

impl Constants {
    /// `None` if the field reads tables, or if a number is not finite.
    fn new(input: &RenderInput, program: &Program) -> Option<Self> {
        if !program.is_uniform() || !program.parameters.iter().flatten().all(|number| number.is_finite()) {
            return None;
        }
        let vectors = program.parameters.iter().map(|[x, y, z, w]| format!("vec4f({x:?}, {y:?}, {z:?}, {w:?})"));
        let vectors: Vec<_> = vectors.collect();
        Some(Self { parameters: vectors.join(", "), frame: wgsl::value(&input.frame)? })
    }
}

impl Bindings {
    pub(super) fn new(input: &RenderInput, program: &Program, target: KernelTarget) -> Self {
        let software = target.is_software;
        let mut memory = [Memory::Storage; BINDINGS as usize];
        let loops_are_limited = software && input.scene.field.has_loops();
        // Paths that are resumed do not keep the state of the recorder.
        let has_guides = input.records_guides() && !loops_are_limited;
        if target.has_textures {
            let mut put = |binding: u32, fits: bool| {
                if fits {
                    memory[binding as usize] = Memory::Texture;
                }
            };
            put(PARAMETERS, true);
            put(SCENE_DATA, true);
            // Photons are written to it for every sample.
            put(VECTORS, input.light_paths().is_none());
            // Reconstruction reads the film as a buffer.
            put(FILM, !has_guides);
        }
        if program.is_uniform() {
            memory[PARAMETERS as usize] = Memory::Uniform(16 * program.parameters.len());
        }
        if software {
            let tables = [
                (LEAVES, input.scene.leaves.len(), size_of::<LeafRecord>()),
                (MATERIALS, input.scene.materials.len(), size_of::<MaterialRecord>()),
                (LIGHTS, input.scene.lights.len(), size_of::<LightRecord>()),
                (LIGHT_TREE, input.light_tree().map_or(0, |tree| tree.nodes.len()), size_of::<LightNode>()),
            ];
            for (binding, count, size) in tables {
                // A power of two, so that a few more records do not change the code.
                let bytes = count.next_power_of_two() * size;
                if bytes <= UNIFORM_BYTES && (count > 0 || binding != LIGHT_TREE) {
                    memory[binding as usize] = Memory::Uniform(bytes);
                }
            }
        } else {
            memory[FRAME as usize] = Memory::Uniform(size_of::<FrameUniforms>());
        }
        let constants = if software && input.config.constant_numbers { Constants::new(input, program) } else { None };
        let config = &input.config;
        let takes_several = input.mode == Mode::Path
            && constants.is_some()
            && !(loops_are_limited || has_guides || config.path_reuse || config.traced_caustics)
            && config.splitting == 1
            && config.indirect_samples == 1
            && input.edges.is_none();
        let (samples_per_dispatch, pixels_per_lane) =
            if takes_several { (SEVERAL_SAMPLES, PIXELS_PER_LANE) } else { (1, 1) };
        let readers = TableReaders::new(&input.scene, constants.is_some());
        Self {
            memory,
            software,
            loops_are_limited,
            has_guides,
            samples_per_dispatch,
            pixels_per_lane,
            readers,
            constants,
        }
    }

    /// Binding numbers of the kernel.
    pub(super) fn all(&self) -> impl Iterator<Item = u32> {
        let (loops_are_limited, has_guides) = (self.loops_are_limited, self.has_guides);
        let has_uniform_tree = self.is_uniform(LIGHT_TREE);
        let are_constant = self.constants.is_some();
        (0..BINDINGS).filter(move |&binding| match binding {
            SUSPENDED => loops_are_limited,
            GUIDES => has_guides,
            LIGHT_TREE => has_uniform_tree,
            FRAME | PARAMETERS => !are_constant,
            _ => true,
        })
    }

    /// True if the kernel contains the frame.
    pub(super) fn frame_is_constant(&self) -> bool {
        self.constants.is_some()
    }

    /// True if a buffer is in uniform memory.
    pub(crate) fn is_uniform(&self, binding: u32) -> bool {
        matches!(self.memory[binding as usize], Memory::Uniform(_))
    }

    /// Memory of a buffer.
    pub(super) fn memory(&self, binding: u32) -> Memory {
        self.memory[binding as usize]
    }

    /// Element of a table in a texture; `None` for buffers.
    pub(super) fn texel(&self, binding: u32) -> Option<Element> {
        let element = if binding == SCENE_DATA { Element::Word } else { Element::Vector };
        (self.memory(binding) == Memory::Texture).then_some(element)
    }

    /// Size of the buffer for `contents` bytes.
    pub(super) fn bytes(&self, binding: u32, contents: usize) -> usize {
        match self.memory(binding) {
            Memory::Uniform(declared) => declared,
            _ => contents.max(256),
        }
    }

    /// Declarations of the buffers in WGSL, and `load_frame()`.
    pub(super) fn declarations(&self, input: &RenderInput, program: &Program) -> String {
        let table = |binding: u32, name: &str, kind: &str| {
            let space = if self.is_uniform(binding) { "uniform" } else { "storage, read" };
            format!("@group(0) @binding({binding}) var<{space}> {name}: {kind};\n")
        };
        let array = |binding: u32, name: &str, record: &str, size: usize| {
            let kind = match self.memory(binding) {
                Memory::Uniform(bytes) => format!("array<{record}, {}>", bytes / size),
                _ => format!("array<{record}>"),
            };
            table(binding, name, &kind)
        };
        let mut text = match (&self.constants, self.software) {
            // Not `const`, so that the front end evaluates nothing: a division by zero is no mistake here.
            (Some(Constants { parameters, frame }), _) => {
                let constant =
                    |name: &str, kind: &str, value: &str| format!("var<private> {name}: {kind} = {value};\n");
                constant("frame", "Frame", frame) + &program.constants(parameters) + "\nfn load_frame() {}\n\n"
            }
            (None, true) => {
                table(FRAME, "stored_frame", "Frame")
                    + "var<private> frame: Frame;\n\nfn load_frame() {\n    frame = stored_frame;\n}\n\n"
            }
            (None, false) => table(FRAME, "frame", "Frame") + "\nfn load_frame() {}\n\n",
        };
        if self.constants.is_none() {
            text += &match self.memory(PARAMETERS) {
                Memory::Uniform(_) => program.declaration(&format!("@group(0) @binding({PARAMETERS}) var<uniform>")),
                Memory::Storage => program.declaration(&format!("@group(0) @binding({PARAMETERS}) var<storage, read>")),
                Memory::Texture => {
                    Element::Vector.declaration(Memory::Texture, PARAMETERS, "field_parameters", "field_vector")
                        + &texture_length("field_parameters", "field_vector_count")
                }
            };
        }
        text += &film_declaration(self.memory(FILM), FILM);
        text += &Element::Word.declaration(self.memory(SCENE_DATA), SCENE_DATA, "scene_data", "scene_word");
        text += &Element::Vector.declaration(self.memory(VECTORS), VECTORS, "scene_vectors", "scene_vector");
        text += &array(LEAVES, "leaves", "LeafRecord", size_of::<LeafRecord>());
        text += &array(MATERIALS, "materials", "Material", size_of::<MaterialRecord>());
        text += &self.readers.objects;
        if input.mode.traces_paths() || input.preview().is_some() {
            text += &array(LIGHTS, "lights", "Light", size_of::<LightRecord>());
            text += &self.readers.lights;
            if self.is_uniform(LIGHT_TREE) {
                text += &array(LIGHT_TREE, "light_nodes", "LightNode", size_of::<LightNode>());
            }
        }
        text + "\n"
    }
}
