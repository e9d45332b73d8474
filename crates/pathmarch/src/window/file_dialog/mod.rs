//! File dialog of our own: native dialogs need a desktop portal, which not every machine has.
//!
//! **Use.** Show a [`FileDialog`] each frame before anything else reads the keyboard: it handles Escape and, unless a
//! text field has the focus, the arrow keys, Enter and Backspace. It is done when it returns a [`Choice`].
//!
//! **Cost.** A directory is listed once, when it is entered; only visible rows are drawn.

mod listing;
mod view;

use egui::{Context, Id, Key, Modifiers, Panel};
use listing::Entry;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Options of a file dialog.
#[derive(Clone, Debug)]
pub struct FileDialogOptions {
    /// Window title.
    pub title: String,
    /// Extensions of the files listed; empty for all files. The first one is added to names without an extension.
    pub extensions: Vec<&'static str>,
}

/// Result of a [`FileDialog`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The chosen file; when saving, an existing file is to be replaced.
    Chosen(PathBuf),
    /// The user cancelled.
    Cancelled,
}

/// A file dialog.
pub struct FileDialog {
    options: FileDialogOptions,
    /// Name to save under; `None` when opening.
    name: Option<TypedName>,
    directory: PathBuf,
    /// Text of the path field.
    path: String,
    entries: Vec<Entry>,
    /// Indices of the listed entries.
    visible: Vec<usize>,
    /// Index into `visible`.
    selected: Option<usize>,
    all_files: bool,
    bookmarks: Vec<(String, PathBuf)>,
    error: Option<String>,
    /// Existing file that the user is asked to replace.
    replace: Option<PathBuf>,
    choice: Option<Choice>,
    /// A row has the keyboard focus.
    row_focused: bool,
    /// Scroll to the selected row in the next frame.
    scroll_to_selection: bool,
    /// The dialog has not been drawn yet.
    is_first_frame: bool,
}

/// File name in a text field; keeps the original if that is not Unicode.
#[derive(Default)]
struct TypedName {
    text: String,
    original: Option<(String, OsString)>,
}

impl TypedName {
    fn of(name: &OsStr) -> Self {
        let text = name.to_string_lossy().into_owned();
        Self { original: Some((text.clone(), name.to_owned())), text }
    }

    fn name(&self) -> OsString {
        match &self.original {
            Some((text, name)) if *text == self.text => name.clone(),
            _ => self.text.trim().into(),
        }
    }
}

impl FileDialog {
    /// Creates a dialog that opens an existing file.
    pub fn open(start_directory: &Path, options: FileDialogOptions) -> Self {
        Self::new(start_directory, options, None)
    }

    /// Creates a dialog that saves under a name.
    pub fn save(start_directory: &Path, suggested_name: &str, options: FileDialogOptions) -> Self {
        Self::new(start_directory, options, Some(TypedName { text: suggested_name.to_owned(), original: None }))
    }

    fn new(start_directory: &Path, options: FileDialogOptions, name: Option<TypedName>) -> Self {
        let mut this = Self {
            options,
            name,
            directory: PathBuf::new(),
            path: String::new(),
            entries: Vec::new(),
            visible: Vec::new(),
            selected: None,
            all_files: false,
            bookmarks: Vec::new(),
            error: None,
            replace: None,
            choice: None,
            row_focused: false,
            scroll_to_selection: false,
            is_first_frame: true,
        };
        let home = directories::BaseDirs::new().map(|system| system.home_dir().to_owned());
        let current = std::env::current_dir().ok();
        let start = std::path::absolute(start_directory).unwrap_or_else(|_| start_directory.to_owned());
        // Falls back to the nearest readable directory; the error for the requested one stays visible.
        for directory in start.ancestors().chain(current.as_deref()).chain(home.as_deref()) {
            let error = this.error.take();
            if this.enter(directory) {
                this.error = error;
                break;
            }
            this.error = error.or(this.error.take());
        }
        this.add_bookmark("Home", home.as_deref());
        this.add_bookmark("Current directory", current.as_deref());
        this
    }

    /// Adds bookmarks: the directory of the open file, then others, most useful first.
    pub fn with_bookmarks(mut self, scene_directory: Option<&Path>, recent: &[PathBuf]) -> Self {
        self.add_bookmark("Scene directory", scene_directory);
        for directory in recent {
            let name = directory.file_name().map_or(directory.to_string_lossy(), OsStr::to_string_lossy);
            self.add_bookmark(&name, Some(directory));
        }
        self
    }

    fn add_bookmark(&mut self, name: &str, directory: Option<&Path>) {
        if let Some(directory) = directory.map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
            && !directory.as_os_str().is_empty()
            && !self.bookmarks.iter().any(|(_, place)| *place == directory)
        {
            self.bookmarks.push((name.to_owned(), directory));
        }
    }

    /// The listed directory.
    #[cfg(test)]
    fn directory(&self) -> &Path {
        &self.directory
    }

    /// Draws the dialog; returns the result once there is one.
    pub fn show(&mut self, ctx: &Context) -> Option<Choice> {
        self.handle_keys(ctx);
        let mut open = true;
        let screen = ctx.content_rect();
        let size = egui::vec2(720.0, 460.0).min(screen.size() * 0.9);
        egui::Window::new(&self.options.title)
            .id(Id::unique("file dialog"))
            .open(&mut open)
            .collapsible(false)
            .default_size(size)
            .default_pos(screen.center() - size / 2.0)
            .show(ctx, |ui| {
                Panel::top("file dialog path").show(ui, |ui| self.path_row(ui));
                Panel::bottom("file dialog actions").show(ui, |ui| self.actions(ui));
                Panel::left("file dialog bookmarks").default_size(150.0).show(ui, |ui| self.bookmark_list(ui));
                egui::CentralPanel::default().show(ui, |ui| self.file_list(ui));
            });
        self.is_first_frame = false;
        if !open {
            self.choice = Some(Choice::Cancelled);
        }
        self.choice.take()
    }

    /// Handles the keys of the list.
    fn handle_keys(&mut self, ctx: &Context) {
        let pressed = |key| ctx.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if pressed(Key::Escape) {
            if self.replace.take().is_none() {
                self.choice = Some(Choice::Cancelled);
            }
            return;
        }
        let focused = ctx.memory(|memory| memory.focused());
        if self.replace.is_some() || focused.is_some() && !self.row_focused {
            return;
        }
        let last = self.visible.len().saturating_sub(1);
        let moved = [
            (Key::ArrowDown, self.selected.map_or(0, |at| (at + 1).min(last))),
            (Key::ArrowUp, self.selected.map_or(last, |at| at.saturating_sub(1))),
            (Key::PageDown, self.selected.map_or(0, |at| (at + 10).min(last))),
            (Key::PageUp, self.selected.map_or(0, |at| at.saturating_sub(10))),
            (Key::Home, 0),
            (Key::End, last),
        ];
        for (key, to) in moved {
            if pressed(key) && !self.visible.is_empty() {
                self.select(to);
                self.scroll_to_selection = true;
                // From here on arrow keys move the selection, not the focus.
                focused.inspect(|id| ctx.memory_mut(|memory| memory.surrender_focus(*id)));
            }
        }
        if pressed(Key::Enter) {
            self.accept();
        }
        if pressed(Key::Backspace) {
            self.enter_parent();
        }
    }

    /// Enters a directory; if it cannot be read, shows the error and stays.
    fn enter(&mut self, directory: &Path) -> bool {
        match listing::read(directory) {
            Ok(entries) => {
                self.set_entries(directory.to_owned(), entries);
                self.path = self.directory.to_string_lossy().into_owned();
                true
            }
            Err(error) => {
                self.error = Some(error);
                false
            }
        }
    }

    fn set_entries(&mut self, directory: PathBuf, entries: Vec<Entry>) {
        self.directory = directory;
        self.entries = entries;
        self.error = None;
        self.replace = None;
        self.filter();
    }

    fn filter(&mut self) {
        let extensions = if self.all_files { &[][..] } else { &self.options.extensions };
        let fits = |entry: &Entry| entry.is_directory || listing::has_extension(&entry.name, extensions);
        self.visible = (0..self.entries.len()).filter(|index| fits(&self.entries[*index])).collect();
        self.selected = None;
        self.scroll_to_selection = false;
    }

    fn enter_parent(&mut self) {
        let from = self.directory.clone();
        if let Some(parent) = from.parent()
            && self.enter(parent)
        {
            // Select the directory that we came from.
            let is_it = |index: &usize| Some(self.entries[*index].name.as_os_str()) == from.file_name();
            self.selected = self.visible.iter().position(is_it);
            self.scroll_to_selection = true;
        }
    }

    fn select(&mut self, row: usize) {
        self.selected = Some(row);
        self.error = None;
        self.replace = None;
        if let Some(entry) = self.visible.get(row).map(|index| &self.entries[*index])
            && !entry.is_directory
            && self.name.is_some()
        {
            self.name = Some(TypedName::of(&entry.name));
        }
    }

    /// Opens the path of the path field.
    fn open_typed_path(&mut self) {
        if self.path == self.directory.to_string_lossy() {
            return;
        }
        let path = listing::resolve(&self.directory, &self.path);
        if path.is_dir() {
            self.enter(&path);
            return;
        }
        match (&self.name, path.parent(), path.file_name()) {
            (None, ..) => self.choose(path),
            (Some(_), Some(parent), Some(name)) => {
                if self.enter(parent) {
                    self.name = Some(TypedName::of(name));
                    self.accept();
                }
            }
            _ => self.error = Some(format!("{} is not a file name", path.display())),
        }
    }

    /// Accepts the selection, or the name to save under.
    fn accept(&mut self) {
        let selected = self.selected.and_then(|row| self.entries.get(*self.visible.get(row)?));
        match (&self.name, selected) {
            (_, Some(entry)) if entry.is_directory => {
                let directory = self.directory.join(&entry.name);
                self.enter(&directory);
            }
            (Some(name), _) => {
                let name = name.name();
                self.save_as(&name);
            }
            (None, Some(entry)) => {
                let path = self.directory.join(&entry.name);
                self.choose(path);
            }
            (None, None) => {}
        }
    }

    /// Chooses a file to open, if it is a file.
    fn choose(&mut self, path: PathBuf) {
        if path.is_file() {
            self.choice = Some(Choice::Chosen(path));
        } else {
            self.error = Some(format!("{} does not exist or is not a file", path.display()));
        }
    }

    /// Chooses a name to save under; it may contain directories.
    fn save_as(&mut self, name: &OsStr) {
        let path = match name.to_str() {
            Some(name) => listing::resolve(&self.directory, name),
            None => self.directory.join(name),
        };
        if path.is_dir() {
            if path != self.directory {
                self.enter(&path);
            }
            return;
        }
        let (Some(parent), Some(name)) = (path.parent(), path.file_name()) else { return };
        let path = parent.join(listing::with_extension(name, &self.options.extensions));
        if !parent.is_dir() {
            self.error = Some(format!("{} is not a directory; create it first", parent.display()));
        } else if path.is_dir() {
            self.error = Some(format!("{} is a directory; choose another name", path.display()));
        } else if path.exists() {
            self.replace = Some(path);
        } else {
            self.choice = Some(Choice::Chosen(path));
        }
    }
}

#[cfg(test)]
mod tests;
