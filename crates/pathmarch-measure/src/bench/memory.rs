//! Memory of a scene: peak of a separate process that renders one sample.
//!
//! A process that has measured other scenes keeps some of their memory, and so do drivers; only a new process shows
//! what a user sees. Linux reports the peak in `/proc/self/status`; other systems have no figure.

use super::{Arguments, scenes};
use crate::measure::{self, Interrupt};
use pathmarch_cli::{DONE, Failure, outln};
use pathmarch_render::{Renderer, Settings};
use std::path::Path;
use std::process::{Command, Stdio};

/// Peak resident memory of this process, MiB.
fn peak_of_this_process() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes / 1024.0)
}

/// Body of the separate process: renders one sample and prints the peak.
pub fn report(arguments: &Arguments, interrupt: &Interrupt) -> Result<u8, Failure> {
    let backend = arguments.backend.map(Into::into);
    for renderer in measure::renderers(backend, arguments.adapter.as_deref())? {
        for chosen in scenes::chosen(&arguments.scenes)? {
            let settings = arguments.settings(&chosen.scene, 1);
            let mut job = measure::start(&renderer, &chosen.scene, &Settings { samples: 1, ..settings })?;
            measure::until(&mut job, 1, interrupt)?;
            job.film().map_err(Failure::other)?;
        }
    }
    if let Some(peak) = peak_of_this_process() {
        outln!("{peak}");
    }
    Ok(DONE)
}

/// Peak resident memory of a process that renders one sample of the scene, MiB.
pub fn of_scene(arguments: &Arguments, scene: &Path, renderer: &Renderer) -> Option<f64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    let [width, height] = arguments.size();
    let mut command = Command::new(std::env::current_exe().ok()?);
    command.args(["bench", "--peak-memory", "--size", &format!("{width}x{height}")]);
    command.args(["--bounces", &arguments.bounces.to_string()]);
    if renderer.backend().name == "CPU" {
        command.args(["--backend", "cpu"]);
    } else {
        command.args(["--backend", "gpu", "--adapter", &renderer.backend().adapter]);
    }
    let output = command.arg("--").arg(scene).stderr(Stdio::null()).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
