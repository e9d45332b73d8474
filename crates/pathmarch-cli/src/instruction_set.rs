//! Instruction sets of the processor, and the build of the program for the best of them.
//!
//! **Idea.** A package has several builds of the program, which differ in the instructions that the compiler may use. The one
//! that starts runs on every processor; it passes its place to the best build that the processor can run. Beside dispatch in
//! each function this has two advantages: lanes, vectors of the standard library and dependencies alike use the wide registers,
//! and no call is indirect.
//!
//! **Source.** The levels are those of the x86-64 psABI (section 3.1.1, 2020), by which glibc chooses among libraries too.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Variable that forbids better instruction sets than the named one.
const VARIABLE: &str = "PATHMARCH_INSTRUCTIONS";

/// Instruction sets for which the program is built, from the least to the best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// What every processor of the architecture has: on x86-64 SSE2, on aarch64 NEON.
    Baseline,
    /// AVX2, FMA and what came with them: x86-64 processors since 2013.
    X86_64V3,
    /// AVX-512.
    X86_64V4,
}

impl InstructionSet {
    const ALL: [Self; 3] = [Self::Baseline, Self::X86_64V3, Self::X86_64V4];

    /// Returns the instruction set that this build uses.
    pub const fn of_build() -> Self {
        if cfg!(target_feature = "avx512f") {
            Self::X86_64V4
        } else if cfg!(target_feature = "avx2") {
            Self::X86_64V3
        } else {
            Self::Baseline
        }
    }

    /// Name in file names and in the variable.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::X86_64V3 => "x86-64-v3",
            Self::X86_64V4 => "x86-64-v4",
        }
    }

    /// Name for users.
    pub const fn label(self) -> &'static str {
        match self {
            Self::X86_64V4 => "AVX-512",
            Self::X86_64V3 => "AVX2",
            Self::Baseline if cfg!(target_arch = "aarch64") => "NEON",
            Self::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Baseline => "no vector instructions",
        }
    }

    /// Reports whether this processor has all instructions of the set.
    ///
    /// It runs before anything else, in builds that the processor may not be able to run, so it is integers alone: the compiler
    /// may use vectors for anything larger. The macro of the standard library would answer yes without a look.
    #[cfg(target_arch = "x86_64")]
    #[inline(never)]
    pub fn is_supported(self) -> bool {
        use std::arch::x86_64::{__cpuid, __cpuid_count};
        let has = |found: u32, needed: u32| found & needed == needed;
        if self == Self::Baseline {
            return true;
        }
        if __cpuid(0).eax < 7 || __cpuid(0x8000_0000).eax < 0x8000_0001 {
            return false;
        }
        let v4 = if self == Self::X86_64V4 { AVX512 } else { 0 };
        let registers = if self == Self::X86_64V4 { YMM | ZMM } else { YMM };
        has(__cpuid(1).ecx, FMA_TO_AVX)
            && has(__cpuid_count(7, 0).ebx, BMI_AND_AVX2 | v4)
            && has(__cpuid(0x8000_0001).ecx, LZCNT)
            // SAFETY: OSXSAVE is among the bits of the first line.
            && has(unsafe { enabled_registers() }, registers)
    }

    /// Reports whether this processor has all instructions of the set.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn is_supported(self) -> bool {
        self == Self::Baseline
    }

    /// Message of a build for a processor that lacks its instructions.
    const fn missing(self) -> &'static str {
        match self {
            Self::X86_64V4 => {
                "this program was built for processors with AVX-512, which this one lacks; build it with RUSTFLAGS=\"\", which runs everywhere"
            }
            _ => {
                "this program was built for processors with AVX2, which this one lacks; build it with RUSTFLAGS=\"\", which runs everywhere"
            }
        }
    }

    /// Best set that the variable allows; a name that is none allows all.
    fn allowed(variable: Option<&str>) -> Self {
        Self::ALL.into_iter().find(|set| variable == Some(set.name())).unwrap_or(Self::X86_64V4)
    }
}

/// FMA, MOVBE, OSXSAVE, AVX and F16C: leaf 1, ecx.
#[cfg(target_arch = "x86_64")]
const FMA_TO_AVX: u32 = 1 << 12 | 1 << 22 | 1 << 27 | 1 << 28 | 1 << 29;
/// BMI1, AVX2 and BMI2: leaf 7, ebx.
#[cfg(target_arch = "x86_64")]
const BMI_AND_AVX2: u32 = 1 << 3 | 1 << 5 | 1 << 8;
/// AVX-512 F, DQ, CD, BW and VL: leaf 7, ebx.
#[cfg(target_arch = "x86_64")]
const AVX512: u32 = 1 << 16 | 1 << 17 | 1 << 28 | 1 << 30 | 1 << 31;
/// LZCNT: leaf 0x80000001, ecx.
#[cfg(target_arch = "x86_64")]
const LZCNT: u32 = 1 << 5;
/// Registers of 256 bits, and those that AVX-512 adds, which the system has to save: XCR0.
#[cfg(target_arch = "x86_64")]
const YMM: u32 = 0b110;
#[cfg(target_arch = "x86_64")]
const ZMM: u32 = 0b1110_0000;

/// Registers that the operating system saves.
///
/// # Safety
/// The processor has OSXSAVE.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "xsave")]
fn enabled_registers() -> u32 {
    // SAFETY: the caller vouches for the instruction.
    unsafe { std::arch::x86_64::_xgetbv(0) as u32 }
}

/// Checks that this processor has the instructions that the program was built for.
///
/// # Errors
/// A message that names the missing instructions, and says what to do.
pub fn check_instruction_set() -> Result<(), &'static str> {
    let built_for = InstructionSet::of_build();
    if built_for.is_supported() { Ok(()) } else { Err(built_for.missing()) }
}

/// Gives the process to the best build of the program that is installed beside it and runs on this processor, if there is one.
/// Returns if there is none, or if it cannot be started.
pub(crate) fn run_best_build() {
    let variable = std::env::var(VARIABLE).ok();
    let program = std::env::current_exe().and_then(|program| program.canonicalize());
    let Some(best) =
        program.ok().and_then(|program| best_build(&program, InstructionSet::allowed(variable.as_deref())))
    else {
        return;
    };
    let mut arguments = std::env::args_os();
    let mut command = Command::new(best);
    name_as(&mut command, arguments.next());
    become_process(command.args(arguments));
}

/// Best build beside `program`, better than this one and no better than `limit`.
fn best_build(program: &Path, limit: InstructionSet) -> Option<PathBuf> {
    let (folder, name) = (program.parent()?, program.file_stem()?.to_str()?);
    let better = InstructionSet::ALL.into_iter().rev().filter(|set| InstructionSet::of_build() < *set && *set <= limit);
    better.filter(|set| set.is_supported()).find_map(|set| {
        let file = format!("{name}-{}{}", set.name(), std::env::consts::EXE_SUFFIX);
        [folder.join("../lib").join(name), folder.to_owned()]
            .map(|folder| folder.join(&file))
            .into_iter()
            .find(|path| path.is_file())
    })
}

/// Gives the command the name by which this program was called, which its messages show.
fn name_as(command: &mut Command, name: Option<std::ffi::OsString>) {
    #[cfg(unix)]
    if let Some(name) = name {
        std::os::unix::process::CommandExt::arg0(command, name);
    }
    #[cfg(not(unix))]
    let _ = (command, name);
}

#[cfg(unix)]
fn become_process(command: &mut Command) {
    // Returns only if the file cannot be executed; this build then goes on.
    let _ = std::os::unix::process::CommandExt::exec(command);
}

#[cfg(not(unix))]
fn become_process(command: &mut Command) {
    // Ctrl-C reaches both processes; this one waits for the other.
    let _ = ctrlc::set_handler(|| {});
    if let Ok(status) = command.status() {
        std::process::exit(status.code().unwrap_or(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_better_sets_need_the_lesser_ones() {
        assert!(InstructionSet::Baseline.is_supported());
        assert!(InstructionSet::X86_64V3.is_supported() || !InstructionSet::X86_64V4.is_supported());
        assert!(check_instruction_set().is_ok());
    }

    #[test]
    fn the_variable_limits_the_set() {
        assert_eq!(InstructionSet::allowed(Some("baseline")), InstructionSet::Baseline);
        assert_eq!(InstructionSet::allowed(Some("x86-64-v3")), InstructionSet::X86_64V3);
        assert_eq!(InstructionSet::allowed(None), InstructionSet::X86_64V4);
    }

    #[test]
    fn the_best_build_that_runs_here_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let library = folder.path().join("lib/pathmarch");
        std::fs::create_dir_all(&library).expect("created");
        std::fs::create_dir_all(folder.path().join("bin")).expect("created");
        for set in InstructionSet::ALL {
            let file = library.join(format!("pathmarch-{}{}", set.name(), std::env::consts::EXE_SUFFIX));
            std::fs::write(file, "").expect("written");
        }
        let program = folder.path().join("bin/pathmarch");
        let best = InstructionSet::ALL.into_iter().rfind(|set| set.is_supported()).expect("the baseline");
        let found = best_build(&program, InstructionSet::X86_64V4);
        assert_eq!(found.is_some(), InstructionSet::of_build() < best);
        assert!(found.is_none_or(|path| path.to_string_lossy().contains(best.name())));
        assert_eq!(best_build(&program, InstructionSet::Baseline), None);
    }
}
