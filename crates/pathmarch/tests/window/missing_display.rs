//! Without Xvfb, tests that need a display are ignored, or fail if a display is required.

use crate::display::DISPLAY;
use pathmarch_testing::{plain, tests};
use std::process::{Command, Output};

/// A test that needs a display.
const TEST: &str = "actions::slow::any_size_is_survived_without_a_gpu";

/// Runs one test of this program with an empty `PATH`.
fn without_xvfb(required: bool) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args(["--exact", TEST]).env("PATH", "/nonexistent").env_remove(DISPLAY.variable);
    if required {
        command.env(DISPLAY.variable, "1");
    }
    command.output().expect("it runs")
}

fn tests_without_a_display_are_reported_as_ignored() {
    let output = without_xvfb(false);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("... ignored (no display: Xvfb cannot be started"), "{text}");
    assert!(text.contains("test result: ok. 0 passed; 0 failed; 1 ignored;"), "{text}");
}

fn a_required_display_that_is_missing_is_a_failure() {
    let output = without_xvfb(true);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(101), "{text}");
    assert!(text.contains("test result: FAILED. 0 passed; 1 failed; 0 ignored;"), "{text}");
}

tests! {
    plain: [tests_without_a_display_are_reported_as_ignored, a_required_display_that_is_missing_is_a_failure],
}
