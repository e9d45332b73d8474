//! Handling of Ctrl-C.

use crate::{Failure, INTERRUPTED};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Returns a flag that Ctrl-C sets; a second Ctrl-C ends the program at once.
///
/// # Errors
/// Fails if the system refuses a signal handler, or if one is already set.
pub fn catch_interrupts() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .map_err(Failure::other)?;
    Ok(flag)
}
