//! Panels, viewport and windows: each file draws one part of [`App`](super::app::App).

mod diagnostics;
mod dialogs;
mod gallery_page;
mod help;
mod inspector;
pub(crate) mod materials;
mod menu_bar;
mod plots;
mod scene_tree;
mod source_editor;
mod status_bar;
mod timeline;
mod toasts;
mod viewport;
