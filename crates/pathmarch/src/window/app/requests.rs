//! Requests that wait for an answer: for a file, or for what becomes of unsaved work.

use crate::window::file_dialog::FileDialogOptions;
use std::path::PathBuf;

/// What a file is chosen for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileRequest {
    Open,
    SaveAs,
    /// The scene is to be saved, and then this done.
    SaveThen(PendingAction),
    /// The picture as it is shown.
    Picture,
    /// The output of the render dialog.
    Render,
}

/// What was asked for when unsaved work stood in its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PendingAction {
    Quit,
    New,
    Open,
    /// This file, of the recent ones or dragged into the window.
    OpenFile(PathBuf),
    Gallery,
    /// The scene of the gallery.
    Example(usize),
}

/// What a file is chosen for.
pub(crate) fn file_dialog_options(title: &str, extensions: &[&'static str]) -> FileDialogOptions {
    FileDialogOptions { title: title.to_owned(), extensions: extensions.to_vec() }
}
