//! Bindings of the kernel; uniform or storage memory for each buffer.
//!
//! A GPU reads uniform memory as fast as registers where all of its threads read one place, and storage where they
//! read many. Software that runs kernels on a processor (Mesa's llvmpipe) has other costs: reading storage is a loop over
//! the lanes wherever a branch is about, and reading uniforms a plain load; but where uniforms alone decide a branch it makes
//! the kernel anew at every dispatch. So there, the frame is read from storage once, before the first branch, and small
//! tables are uniform. Measured on two cores: emitting-spheres 67 to 38 ms a sample at 480x270 (docs/performance.md).

use super::encode::LightRecord;
use crate::backend::RenderInput;
use crate::scene::{FrameUniforms, LeafRecord, MaterialRecord};
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
pub(super) const SKY: u32 = 8;
/// Paths that go on in the next dispatch; only where loops are limited.
pub(super) const SUSPENDED: u32 = 9;
const BINDINGS: u32 = 10;

/// Storage buffers that the kernel binds at most: leaves, materials, lights, film, tables, sky, and the parameters of a
/// large field.
pub(crate) const STORAGE_BUFFERS: u32 = 7;

/// The size of uniform memory that every adapter has, bytes.
const UNIFORM_BYTES: usize = 1 << 16;

/// Where each table stands.
pub(crate) struct Bindings {
    /// Bytes of those that are uniform, else 0; by binding.
    uniform: [usize; BINDINGS as usize],
    software: bool,
    /// Whether the adapter may end the loops of this kernel, see [`super::loop_limit`].
    pub(super) loops_are_limited: bool,
}

impl Bindings {
    pub(super) fn new(input: &RenderInput, program: &Program, software: bool) -> Self {
        let mut uniform = [0; BINDINGS as usize];
        uniform[PARAMETERS as usize] = if program.is_uniform() { 16 * program.parameters.len() } else { 0 };
        if software {
            let tables = [
                (LEAVES, input.scene.leaves.len(), size_of::<LeafRecord>()),
                (MATERIALS, input.scene.materials.len(), size_of::<MaterialRecord>()),
                (LIGHTS, input.scene.lights.len(), size_of::<LightRecord>()),
            ];
            for (binding, count, size) in tables {
                // A few more or less are the same code.
                let bytes = count.next_power_of_two() * size;
                uniform[binding as usize] = if bytes <= UNIFORM_BYTES { bytes } else { 0 };
            }
        } else {
            uniform[FRAME as usize] = size_of::<FrameUniforms>();
        }
        let loops_are_limited = software && input.scene.field.has_loops();
        Self { uniform, software, loops_are_limited }
    }

    /// BsdfParameters of the bindings that the kernel has.
    pub(super) fn all(&self) -> std::ops::Range<u32> {
        0..if self.loops_are_limited { BINDINGS } else { SUSPENDED }
    }

    /// Whether this table is uniform.
    pub(crate) fn is_uniform(&self, binding: u32) -> bool {
        self.uniform[binding as usize] > 0
    }

    /// Bytes of a table that holds so many.
    pub(super) fn bytes(&self, binding: u32, contents: usize) -> usize {
        match self.uniform[binding as usize] {
            0 => contents.max(256),
            declared => declared,
        }
    }

    /// The bindings that depend on it, in WGSL, and `load_frame()`.
    pub(super) fn declarations(&self, input: &RenderInput, program: &Program) -> String {
        let table = |binding: u32, name: &str, kind: &str| {
            let space = if self.is_uniform(binding) { "uniform" } else { "storage, read" };
            format!("@group(0) @binding({binding}) var<{space}> {name}: {kind};\n")
        };
        let array = |binding: u32, name: &str, record: &str, size: usize| {
            let kind = match self.uniform[binding as usize] {
                0 => format!("array<{record}>"),
                bytes => format!("array<{record}, {}>", bytes / size),
            };
            table(binding, name, &kind)
        };
        let mut text = match self.software {
            true => {
                table(FRAME, "stored_frame", "Frame")
                    + "var<private> frame: Frame;\n\nfn load_frame() {\n    frame = stored_frame;\n}\n\n"
            }
            false => table(FRAME, "frame", "Frame") + "\nfn load_frame() {}\n\n",
        };
        text += &table(PARAMETERS, "field_parameters", &program.parameters_type());
        text += &array(LEAVES, "leaves", "LeafRecord", size_of::<LeafRecord>());
        text += &array(MATERIALS, "materials", "Material", size_of::<MaterialRecord>());
        if input.mode.traces_paths() || input.preview().is_some() {
            text += &array(LIGHTS, "lights", "Light", size_of::<LightRecord>());
        }
        text + "\n"
    }
}
