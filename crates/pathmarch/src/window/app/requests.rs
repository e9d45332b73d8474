//! Requests that wait for an answer: a file name, or a decision about unsaved work.

use crate::window::file_dialog::FileDialogOptions;
use std::path::PathBuf;

/// Purpose of the open file dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileRequest {
    Open,
    SaveAs,
    /// Save the scene, then run the action.
    SaveThen(PendingAction),
    /// Add the objects, lights and cameras of a mesh file.
    Import,
    /// Save the picture as displayed.
    Picture,
    /// Choose the output of the render dialog.
    Render,
}

/// Action that waits for a decision about unsaved work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PendingAction {
    Quit,
    New,
    Open,
    /// Open this file: a recent one, or one dropped onto the window.
    OpenFile(PathBuf),
    Gallery,
    /// Open this example of the gallery.
    Example(usize),
}

/// Title and extensions of a file dialog.
pub(crate) fn file_dialog_options(title: &str, extensions: &[&'static str]) -> FileDialogOptions {
    FileDialogOptions { title: title.to_owned(), extensions: extensions.to_vec() }
}
