//! Code shared by the programs `pathmarch` and `pathmarch-measure`: start and exit, common arguments, Ctrl-C,
//! directories.
//!
//! This library is for these two programs and changes with them; other programs use `pathmarch-render`.

mod app_dirs;
mod arguments;
mod exit;
mod instruction_set;
mod interrupt;
mod print;
mod render_options;
mod threads;
pub mod value_parsers;

pub use app_dirs::{AppDirs, HOME_VARIABLE};
pub use arguments::{BackendArgument, check_directory, check_output};
pub use exit::{DONE, FAILED, Failure, INTERRUPTED, USAGE, end_on_closed_pipe, print_report, run};
pub use instruction_set::{InstructionSet, check_instruction_set};
pub use interrupt::catch_interrupts;
pub use print::{print_note, print_out};
pub use render_options::RenderOptions;
