//! Runs the `pathmarch` program.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a directory that also contains its preferences and caches.
pub fn pathmarch(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pathmarch"))
        .args(arguments)
        .current_dir(directory)
        .env("PATHMARCH_HOME", directory.join("home"))
        .output()
        .expect("the program starts")
}

pub fn code(output: &Output) -> i32 {
    output.status.code().expect("it ended by itself")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
