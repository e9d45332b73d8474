//! The open scene: document, file on disk, and view.

pub(crate) mod playback;
pub(crate) mod selection;
pub(crate) mod view_state;

use crate::window::files::file_watcher::FileWatcher;
use crate::window::waker::Waker;
use pathmarch_render::pathmarch_scene::document::{Document, Path as NodePath};
use playback::Playback;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use view_state::ViewState;

/// Maximum number of included files that are watched: each watcher is a thread.
const MAX_INCLUDES: usize = 32;

/// A scene with its file and view.
pub(crate) struct OpenScene {
    pub(crate) document: Document,
    /// File of the scene; `None` until it is saved for the first time.
    pub(crate) path: Option<PathBuf>,
    /// Text of the file that the document is based on: as last read or written, or as the user chose in a conflict.
    /// `None` if unknown or if there is no file.
    base: Option<String>,
    watcher: Option<FileWatcher>,
    /// Included files with their watchers.
    includes: Vec<(PathBuf, FileWatcher)>,
    /// Unresolved conflict: another program changed the file while there are unsaved changes here. The text on disk, or
    /// the reason why it cannot be read.
    pub(crate) conflict: Option<Result<String, String>>,
    pub(crate) view: ViewState,
    pub(crate) playback: Playback,
    /// Nodes that are collapsed in the scene tree.
    pub(crate) collapsed: Vec<NodePath>,
    /// Names of objects that clicks and handles in the viewport leave alone.
    pub(crate) locked: HashSet<String>,
    /// Text that the scene tree is searched for; empty shows everything.
    pub(crate) tree_search: String,
}

/// Result of a change of the file on disk.
pub(crate) enum FileChange {
    /// The document was reloaded.
    Reloaded,
    /// Both the file and the document have changed: the user must choose.
    Conflict,
    /// File and document are equal again.
    InSync,
    /// The file can no longer be read; the reason.
    Unreadable(String),
}

impl OpenScene {
    /// True if a node is in a locked object.
    pub(crate) fn is_locked(&self, path: &NodePath) -> bool {
        let top = NodePath::from(path.indexes()[..path.indexes().len().min(1)].to_vec());
        let name = self.document.item(&top).and_then(|item| item.name.as_ref());
        name.is_some_and(|name| self.locked.contains(name))
    }

    /// Creates a scene of this program from text. Image files are resolved relative to `name`; `path` is its file, if it has
    /// one.
    pub(crate) fn new(name: &str, text: String, path: Option<PathBuf>) -> Self {
        Self::of_document(Document::new(name, text), path)
    }

    /// Opens the text of a file; unless `allow_files` is true, it reads no file outside the folder of the scene.
    pub(crate) fn of_file(path: PathBuf, text: String, allow_files: bool) -> Self {
        let name = path.display().to_string();
        let document = if allow_files { Document::new(name, text) } else { Document::confined(name, text) };
        Self::of_document(document, Some(path))
    }

    fn of_document(document: Document, path: Option<PathBuf>) -> Self {
        let base = path.is_some().then(|| document.text().to_owned());
        let mut view = ViewState::default();
        if let Some(scene) = document.last_good() {
            view.sync_camera(scene);
        }
        Self {
            document,
            path,
            base,
            watcher: None,
            includes: Vec::new(),
            conflict: None,
            view,
            playback: Playback::default(),
            collapsed: Vec::new(),
            locked: HashSet::new(),
            tree_search: String::new(),
        }
    }

    /// Opens recovered work as unsaved changes of its file. `on_disk`: the current text of the file, or the reason why
    /// it cannot be read. Unless `is_based_on` is true, this is a conflict. `allow_files` is that of [`Self::of_file`].
    pub(crate) fn recovered(
        path: PathBuf,
        work: String,
        on_disk: Result<String, String>,
        is_based_on: bool,
        allow_files: bool,
    ) -> Self {
        let mut this = Self::of_file(path, on_disk.clone().unwrap_or_default(), allow_files);
        let is_same = on_disk.as_ref() == Ok(&work);
        this.document.replace_text(work, "Recovery", None);
        if !is_based_on && !is_same {
            // The base version stays unknown until the user resolves the conflict.
            (this.base, this.conflict) = (None, Some(on_disk));
        }
        this
    }

    /// Checks whether another program has changed the file, before it is overwritten; `now` is its text. Records a
    /// conflict and returns true if so.
    pub(crate) fn is_newer_on_disk(&mut self, now: &str) -> bool {
        let known = self.base.as_deref() == Some(now) || now == self.document.text();
        if !known {
            self.conflict = Some(Ok(now.to_owned()));
        }
        !known
    }

    /// Watches the file for changes by other programs.
    pub(crate) fn start_watching(&mut self, waker: &Waker) {
        let waker = waker.clone();
        self.watcher = self.path.as_deref().map(|path| FileWatcher::new(path, move || waker()));
        self.sync_watcher();
    }

    /// Tells the watcher the text that this program has read or written.
    fn sync_watcher(&mut self) {
        if let (Some(watcher), Some(base)) = (&mut self.watcher, &self.base) {
            watcher.set_known(base);
        }
    }

    /// File name for the window title.
    pub(crate) fn file_name(&self) -> String {
        let name = self.path.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        name.unwrap_or_else(|| "unsaved scene".to_owned())
    }

    /// Returns true if closing would lose changes.
    pub(crate) fn has_unsaved_work(&self) -> bool {
        !self.document.is_saved()
    }

    /// Text of the file that the document is based on, if known.
    pub(crate) fn base_text(&self) -> Option<&str> {
        self.base.as_deref()
    }

    /// Applies a change of the file on disk, if there is one.
    pub(crate) fn poll_file(&mut self) -> Option<FileChange> {
        let text = match self.watcher.as_mut()?.take_change()? {
            Ok(text) => text,
            Err(why) => return Some(FileChange::Unreadable(why)),
        };
        if self.base.as_deref() == Some(text.as_str()) && self.conflict.is_none() {
            return None;
        }
        if text == self.document.text() {
            // Both sides have made the same change.
            (self.base, self.conflict) = (Some(text), None);
            self.document.mark_saved();
            return Some(FileChange::InSync);
        }
        if self.has_unsaved_work() {
            self.conflict = Some(Ok(text));
            return Some(FileChange::Conflict);
        }
        self.reload_from_disk(text);
        Some(FileChange::Reloaded)
    }

    /// Watches the included files and reloads the document if one has changed. Returns true if so.
    pub(crate) fn poll_includes(&mut self, waker: &Waker) -> bool {
        let includes = match (self.document.last_good(), &self.path) {
            (Some(scene), Some(_)) => &scene.includes[..],
            _ => &[],
        };
        let includes = &includes[..includes.len().min(MAX_INCLUDES)];
        if !self.includes.iter().map(|(path, _)| path).eq(includes) {
            let watched = |path: &PathBuf| {
                let waker = waker.clone();
                (path.clone(), FileWatcher::new(path, move || waker()))
            };
            self.includes = includes.iter().map(watched).collect();
        }
        let change: Vec<_> = self.includes.iter_mut().filter_map(|(_, watcher)| watcher.take_change()).collect();
        if !change.is_empty() {
            // An included file that cannot be read becomes an error of the scene.
            self.document.refresh();
        }
        !change.is_empty()
    }

    /// Replaces the document by the text on disk; undo brings the old text back.
    pub(crate) fn reload_from_disk(&mut self, text: String) {
        self.document.replace_text(text.clone(), "Change of the file", None);
        self.document.mark_saved();
        (self.base, self.conflict) = (Some(text), None);
    }

    /// Resolves a conflict in favour of the document; the file stays as it is until the next save.
    pub(crate) fn keep_mine(&mut self) {
        if let Some(on_disk) = self.conflict.take() {
            self.base = on_disk.ok();
        }
    }

    /// Records that the document was written to `path`. Returns true if that is a new path.
    pub(crate) fn mark_saved_to(&mut self, path: &Path) -> bool {
        self.base = Some(self.document.text().to_owned());
        self.conflict = None;
        let moved = self.path.as_deref() != Some(path);
        if moved {
            self.path = Some(path.to_owned());
            self.document.set_name(path.display().to_string());
        }
        self.document.mark_saved();
        self.sync_watcher();
        moved
    }
}
