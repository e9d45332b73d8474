//! Requests that wait for an answer: for a file, or for what becomes of unsaved work.

use crate::window::file_dialog::Purpose;
use std::path::PathBuf;

/// What a file is chosen for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum For {
    Open,
    SaveAs,
    /// The scene is to be saved, and then this done.
    SaveThen(After),
    /// The picture as it is shown.
    Picture,
    /// The output of the render dialog.
    Render,
}

/// What was asked for when unsaved work stood in its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum After {
    Leave,
    New,
    Open,
    /// This file, of the recent ones or dragged into the window.
    OpenFile(PathBuf),
    Gallery,
    /// The scene of the gallery.
    Example(usize),
}

/// What a file is chosen for.
pub(crate) fn purpose(title: &str, extensions: &[&'static str]) -> Purpose {
    Purpose { title: title.to_owned(), extensions: extensions.to_vec() }
}
