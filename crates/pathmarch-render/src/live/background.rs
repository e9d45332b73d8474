//! Threads of low priority: a live picture is wanted soon, but the window must answer first.

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

/// Thread priority from 0 to 99; on Linux a niceness of 19.
const PRIORITY: u8 = 3;

/// Lowers the priority of this thread, and of threads that it starts where priorities are inherited. Does nothing where
/// that is not allowed.
pub(super) fn lower_priority() {
    if let Ok(priority) = ThreadPriorityValue::try_from(PRIORITY) {
        let _ = set_current_thread_priority(ThreadPriority::Crossplatform(priority));
    }
}

/// Runs `work` on this thread at low priority. Its parallel parts use a thread pool of the usual size, at low priority, too.
pub(super) fn with_all_cores<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    lower_priority();
    let threads = rayon::current_num_threads();
    match rayon::ThreadPoolBuilder::new().num_threads(threads).start_handler(|_| lower_priority()).build() {
        Ok(pool) => pool.install(work),
        // Falls back to the pool that the rest of the program uses.
        Err(_) => work(),
    }
}
