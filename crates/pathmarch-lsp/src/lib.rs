#![doc = include_str!("../README.md")]
//!
//! [`serve_stdio`] is the whole program. Answers come from [`pathmarch_scene::language_service`] and
//! [`pathmarch_scene::formatter`]; this crate translates them into the language server protocol 3.17. Messages that have
//! arrived are handled before mistakes are published, so that fast typing costs one reading of the text. One thread
//! answers everything.

mod actions;
mod colours;
mod completion;
mod diagnostics;
mod documents;
mod files;
mod formatting;
mod navigation;
mod positions;
mod server;

use lsp_server::{Connection, ProtocolError};
pub use server::serve;

/// Reason why a server ends early.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The editor breaks the protocol, or is gone.
    #[error("language server: {0}")]
    Protocol(#[from] ProtocolError),
    /// Messages are not of the form that the protocol prescribes.
    #[error("language server: {0}")]
    Form(#[from] serde_json::Error),
    /// Standard input or output fails.
    #[error("language server: {0}")]
    Io(#[from] std::io::Error),
}

/// Serves an editor over standard input and output, until it says goodbye.
///
/// # Errors
/// If the editor breaks the protocol or disappears.
pub fn serve_stdio() -> Result<(), ServeError> {
    let (connection, threads) = Connection::stdio();
    serve(&connection)?;
    // The threads end once nothing can be sent any more.
    drop(connection);
    Ok(threads.join()?)
}
