//! Threads that give way: what they compute is wanted soon, but never before a window has answered.

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

/// Of 0 to 99; on Linux a niceness of 19.
const PRIORITY: u8 = 3;

/// Lets this thread, and those that it starts on systems where priorities are inherited, give way to others. Where that is
/// not allowed everything goes on as before.
pub(super) fn give_way() {
    if let Ok(priority) = ThreadPriorityValue::try_from(PRIORITY) {
        let _ = set_current_thread_priority(ThreadPriority::Crossplatform(priority));
    }
}

/// Does work whose parallel parts run on as many such threads as the program uses for everything else.
pub(super) fn with_all_cores<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    give_way();
    let threads = rayon::current_num_threads();
    match rayon::ThreadPoolBuilder::new().num_threads(threads).start_handler(|_| give_way()).build() {
        Ok(pool) => pool.install(work),
        // The pool that everything else uses will do.
        Err(_) => work(),
    }
}
