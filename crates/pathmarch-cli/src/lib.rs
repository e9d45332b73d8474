//! Shared code of the programs `pathmarch` and `pathmarch-measure`: how they start and end, arguments that both take,
//! Ctrl-C, and their own directories.
//!
//! A library for these programs alone. It changes with them; other programs use `pathmarch-render`.

mod app_dirs;
mod arguments;
mod exit;
mod interrupt;
pub mod numbers;
mod threads;

pub use app_dirs::{AppDirs, HOME_VARIABLE};
pub use arguments::{BackendArgument, check_directory};
pub use exit::{DONE, FAILED, Failure, INTERRUPTED, USAGE, print_report, run};
pub use interrupt::watch_interrupts;
