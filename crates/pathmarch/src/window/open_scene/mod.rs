//! The scene that is open: its text, its file, and how it is looked at.

pub(crate) mod playback;
pub(crate) mod view_state;

use crate::window::files::file_watcher::FileWatcher;
use crate::window::waker::Waker;
use pathmarch_render::pathmarch_scene::document::{Document, Path as NodePath};
use playback::Playback;
use std::path::{Path, PathBuf};
use view_state::ViewState;

/// The most included files that are followed: each has a thread.
const MAX_INCLUDES: usize = 32;

/// A scene, its file, and how it is looked at.
pub(crate) struct OpenScene {
    pub(crate) document: Document,
    /// Its file; none before it is saved for the first time.
    pub(crate) path: Option<PathBuf>,
    /// The version of the file that the document is based on: what the file held when it was last read or written, or when
    /// somebody decided between it and the document. None where it is not known or there is no file.
    base: Option<String>,
    watcher: Option<FileWatcher>,
    /// The files that the scene includes.
    includes: Vec<(PathBuf, FileWatcher)>,
    /// The other version, where someone else has changed the file while there were unsaved changes here: what the file
    /// holds now, or why it cannot be read.
    pub(crate) conflict: Option<Result<String, String>>,
    pub(crate) view: ViewState,
    pub(crate) playback: Playback,
    /// Nodes whose children the tree does not show.
    pub(crate) collapsed: Vec<NodePath>,
}

/// What became of a change of the file.
pub(crate) enum FileChange {
    /// The document is now what the file says.
    Reloaded,
    /// Both have changed: somebody must decide.
    Conflict,
    /// Both are the same now: nothing is unsaved, and there is nothing to decide.
    InSync,
    /// The file can no longer be read, and why.
    Unreadable(String),
}

impl OpenScene {
    /// A scene of this text. `name` says where pictures of the sky are looked for; `path` is its file, where it has one.
    pub(crate) fn new(name: &str, text: String, path: Option<PathBuf>) -> Self {
        let base = path.is_some().then(|| text.clone());
        let document = Document::new(name, text);
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
        }
    }

    /// Work that was not saved when the program ended, as unsaved changes of its file. `on_disk` is what the file holds now,
    /// or why it cannot be read; unless the work `is_based_on` that, somebody must decide between the two.
    pub(crate) fn recovered(path: PathBuf, work: String, on_disk: Result<String, String>, is_based_on: bool) -> Self {
        let name = path.display().to_string();
        let mut this = Self::new(&name, on_disk.clone().unwrap_or_default(), Some(path));
        let is_same = on_disk.as_ref() == Ok(&work);
        this.document.replace_text(work, "Recovery", None);
        if !is_based_on && !is_same {
            // Which version the work is based on is not known, and stays so until somebody decides.
            (this.base, this.conflict) = (None, Some(on_disk));
        }
        this
    }

    /// Notes that the file holds something that nobody here has seen; returns whether somebody must decide. To be asked
    /// before the file is replaced.
    pub(crate) fn is_newer_on_disk(&mut self, now: &str) -> bool {
        let known = self.base.as_deref() == Some(now) || now == self.document.text();
        if !known {
            self.conflict = Some(Ok(now.to_owned()));
        }
        !known
    }

    /// Follows changes of the file by others.
    pub(crate) fn watch(&mut self, waker: &Waker) {
        let waker = waker.clone();
        self.watcher = self.path.as_deref().map(|path| FileWatcher::new(path, move || waker()));
        self.sync_watcher();
    }

    /// What was read or written here is no change by others.
    fn sync_watcher(&mut self) {
        if let (Some(watch), Some(base)) = (&mut self.watcher, &self.base) {
            watch.set_known(base);
        }
    }

    /// What the title says.
    pub(crate) fn file_name(&self) -> String {
        let name = self.path.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        name.unwrap_or_else(|| "unsaved scene".to_owned())
    }

    /// Whether something would be lost with it.
    pub(crate) fn has_unsaved_work(&self) -> bool {
        !self.document.is_saved()
    }

    /// What the file held when it was last read or written.
    pub(crate) fn base_text(&self) -> Option<&str> {
        self.base.as_deref()
    }

    /// Takes on what became of the file, if anything did.
    pub(crate) fn poll_file(&mut self) -> Option<FileChange> {
        let text = match self.watcher.as_mut()?.take_change()? {
            Ok(text) => text,
            Err(why) => return Some(FileChange::Unreadable(why)),
        };
        if self.base.as_deref() == Some(text.as_str()) && self.conflict.is_none() {
            return None;
        }
        if text == self.document.text() {
            // The same change on both sides.
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

    /// Follows the files that the scene includes, and reads them again where one has changed; says whether one has.
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
        let change: Vec<_> = self.includes.iter_mut().filter_map(|(_, watch)| watch.take_change()).collect();
        if !change.is_empty() {
            // One that can no longer be read is revision as a mistake of the scene.
            self.document.refresh();
        }
        !change.is_empty()
    }

    /// Makes the document what the file says. What was here can be had again by undoing.
    pub(crate) fn reload_from_disk(&mut self, text: String) {
        self.document.replace_text(text.clone(), "Change of the file", None);
        self.document.mark_saved();
        (self.base, self.conflict) = (Some(text), None);
    }

    /// Keeps what is here; the file stays as it is until the next save.
    pub(crate) fn keep_mine(&mut self) {
        if let Some(on_disk) = self.conflict.take() {
            self.base = on_disk.ok();
        }
    }

    /// The document has been written to this file.
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
