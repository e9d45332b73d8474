//! End-to-end tests of the window, on a virtual display on Linux.

#[cfg(target_os = "linux")]
mod actions;
#[cfg(target_os = "linux")]
mod display;
#[cfg(target_os = "linux")]
mod missing_display;

#[cfg(target_os = "linux")]
fn main() {
    let sources = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/window");
    let tests = [actions::tests(), missing_display::tests()];
    pathmarch_testing::run(&[sources], tests.into_iter().flatten().collect());
}

#[cfg(not(target_os = "linux"))]
fn main() {
    let ignored = || pathmarch_testing::ignore("Xvfb, the display of these tests, is there on Linux only");
    pathmarch_testing::run(&[], vec![pathmarch_testing::Test::new("window", ignored)]);
}
