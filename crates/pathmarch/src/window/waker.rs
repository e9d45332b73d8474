//! Waker of the event loop, for other threads.

use std::sync::Arc;

/// Requests a new frame of the window; callable from any thread.
pub(crate) type Waker = Arc<dyn Fn() + Send + Sync>;
