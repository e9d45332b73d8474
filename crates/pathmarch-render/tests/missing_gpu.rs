//! Tests that need a GPU are ignored on a machine without one, and fail where one is required.
//!
//! This program runs itself again with hidden drivers, which only Linux allows.

use crate::common::GPU;
use pathmarch_testing::{ignore, plain, tests};
use std::process::{Command, Output};

/// Fast test that needs a GPU.
const TEST: &str = "backends::a_sheet_emits_on_the_side_it_faces_only";

/// Runs tests of this program without graphics drivers.
fn without_drivers(arguments: &[&str], required: bool) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args(arguments).env_remove(GPU.variable);
    // Drivers of Vulkan (under the current and the old name) and of OpenGL.
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "__EGL_VENDOR_LIBRARY_FILENAMES"] {
        command.env(variable, "/nonexistent.json");
    }
    if required {
        command.env(GPU.variable, "1");
    }
    command.output().expect("it runs")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn tests_without_a_gpu_are_reported_as_ignored() {
    if !cfg!(target_os = "linux") {
        ignore("drivers can be hidden on Linux only");
    }
    let output = without_drivers(&[TEST], false);
    let text = text(&output);
    assert!(output.status.success(), "{text}");
    let line = |name: &str| {
        let name = format!("test {TEST}::{name} ");
        text.lines()
            .find(|line| line.starts_with(&name))
            .unwrap_or_else(|| panic!("no line of {name}: {text}"))
            .to_owned()
    };
    assert!(line("cpu").ends_with("... ok"), "{text}");
    assert!(line("gpu").contains("... ignored (no usable GPU adapter"), "{text}");
    assert!(text.contains("test result: ok. 1 passed; 0 failed; 1 ignored;"), "{text}");
}

fn tests_without_a_gpu_are_listed_as_ignored() {
    if !cfg!(target_os = "linux") {
        ignore("drivers can be hidden on Linux only");
    }
    let listed = text(&without_drivers(&["--list", "--ignored", TEST], false));
    assert!(listed.contains(&format!("{TEST}::gpu: test")) && !listed.contains("::cpu: "), "{listed}");
}

fn a_required_gpu_that_is_missing_is_a_failure() {
    if !cfg!(target_os = "linux") {
        ignore("drivers can be hidden on Linux only");
    }
    let output = without_drivers(&[TEST], true);
    let text = text(&output);
    assert_eq!(output.status.code(), Some(101), "{text}");
    assert!(text.contains("test result: FAILED. 1 passed; 1 failed; 0 ignored;"), "{text}");
    assert!(text.contains("PATHMARCH_REQUIRE_GPU is set"), "{text}");
}

tests! {
    plain: [
        tests_without_a_gpu_are_reported_as_ignored,
        tests_without_a_gpu_are_listed_as_ignored,
        a_required_gpu_that_is_missing_is_a_failure,
    ],
}
