//! Choosing a file, in a window of our own: the system's dialogs need a desktop portal, which is not on every machine.
//!
//! **Use.** While a [`Chooser`] exists it is shown each frame, before anything else looks at the keyboard: it takes Escape,
//! and while no text field has the focus also the arrows, Enter and Backspace. It is done when it returns a [`Choice`].
//!
//! **Cost.** A directory is listed once, when it is entered; rows out of sight are not drawn.

mod listing;
mod view;

use egui::{Context, Id, Key, Modifiers, Panel};
use listing::Entry;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// What a file is chosen for.
#[derive(Clone, Debug)]
pub struct Purpose {
    /// The title of the window.
    pub title: String,
    /// The extensions of the files that are shown; those of all files where empty. The first is added to a name without.
    pub extensions: Vec<&'static str>,
}

/// How a [`Chooser`] ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// With this file; to be replaced, if it is to be saved and is there.
    Chosen(PathBuf),
    /// Without.
    Cancelled,
}

/// A window for choosing a file.
pub struct Chooser {
    purpose: Purpose,
    /// The name to save under; none when choosing what to open.
    name: Option<Typed>,
    directory: PathBuf,
    /// The text in the path field.
    path: String,
    entries: Vec<Entry>,
    /// Indices of the entries that are shown.
    shown: Vec<usize>,
    /// Index into `shown`.
    selected: Option<usize>,
    all_files: bool,
    places: Vec<(String, PathBuf)>,
    error: Option<String>,
    /// The file to be replaced, while that is asked.
    replace: Option<PathBuf>,
    choice: Option<Choice>,
    /// A row has the keyboard's focus.
    row_focused: bool,
    /// The selected row is to be scrolled into sight.
    reveal: bool,
    /// The first frame is still to come.
    fresh: bool,
}

/// A file name in a text field, which may stand for one that is not Unicode.
#[derive(Default)]
struct Typed {
    text: String,
    stands_for: Option<(String, OsString)>,
}

impl Typed {
    fn of(name: &OsStr) -> Self {
        let text = name.to_string_lossy().into_owned();
        Self { stands_for: Some((text.clone(), name.to_owned())), text }
    }

    fn name(&self) -> OsString {
        match &self.stands_for {
            Some((text, name)) if *text == self.text => name.clone(),
            _ => self.text.trim().into(),
        }
    }
}

impl Chooser {
    /// Chooses a file that is there.
    pub fn open(start_directory: &Path, purpose: Purpose) -> Self {
        Self::new(start_directory, purpose, None)
    }

    /// Chooses a name to save under.
    pub fn save(start_directory: &Path, suggested_name: &str, purpose: Purpose) -> Self {
        Self::new(start_directory, purpose, Some(Typed { text: suggested_name.to_owned(), stands_for: None }))
    }

    fn new(start_directory: &Path, purpose: Purpose, name: Option<Typed>) -> Self {
        let mut this = Self {
            purpose,
            name,
            directory: PathBuf::new(),
            path: String::new(),
            entries: Vec::new(),
            shown: Vec::new(),
            selected: None,
            all_files: false,
            places: Vec::new(),
            error: None,
            replace: None,
            choice: None,
            row_focused: false,
            reveal: false,
            fresh: true,
        };
        let home = directories::BaseDirs::new().map(|system| system.home_dir().to_owned());
        let current = std::env::current_dir().ok();
        let start = std::path::absolute(start_directory).unwrap_or_else(|_| start_directory.to_owned());
        // The nearest directory that can be shown; why it is another than the one asked for stays to be read.
        for directory in start.ancestors().chain(current.as_deref()).chain(home.as_deref()) {
            let error = this.error.take();
            if this.enter(directory) {
                this.error = error;
                break;
            }
            this.error = error.or(this.error.take());
        }
        this.add_place("Home", home.as_deref());
        this.add_place("Current directory", current.as_deref());
        this
    }

    /// Offers more places: that of the open file, and others, the most useful first.
    pub fn with_places(mut self, scene_directory: Option<&Path>, recent: &[PathBuf]) -> Self {
        self.add_place("Scene's directory", scene_directory);
        for directory in recent {
            let name = directory.file_name().map_or(directory.to_string_lossy(), OsStr::to_string_lossy);
            self.add_place(&name, Some(directory));
        }
        self
    }

    fn add_place(&mut self, name: &str, directory: Option<&Path>) {
        if let Some(directory) = directory.map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
            && !directory.as_os_str().is_empty()
            && !self.places.iter().any(|(_, place)| *place == directory)
        {
            self.places.push((name.to_owned(), directory));
        }
    }

    /// The directory that is shown.
    #[cfg(test)]
    fn directory(&self) -> &Path {
        &self.directory
    }

    /// Shows the window. With a choice it is done.
    pub fn show(&mut self, ctx: &Context) -> Option<Choice> {
        self.take_keys(ctx);
        let mut open = true;
        let screen = ctx.content_rect();
        let size = egui::vec2(720.0, 460.0).min(screen.size() * 0.9);
        egui::Window::new(&self.purpose.title)
            .id(Id::unique("chooser"))
            .open(&mut open)
            .collapsible(false)
            .default_size(size)
            .default_pos(screen.center() - size / 2.0)
            .show(ctx, |ui| {
                Panel::top("chooser path").show(ui, |ui| self.path_row(ui));
                Panel::bottom("chooser actions").show(ui, |ui| self.actions(ui));
                Panel::left("chooser places").default_size(150.0).show(ui, |ui| self.place_list(ui));
                egui::CentralPanel::default().show(ui, |ui| self.file_list(ui));
            });
        self.fresh = false;
        if !open {
            self.choice = Some(Choice::Cancelled);
        }
        self.choice.take()
    }

    /// What the keyboard does to the list.
    fn take_keys(&mut self, ctx: &Context) {
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
        let last = self.shown.len().saturating_sub(1);
        let moved = [
            (Key::ArrowDown, self.selected.map_or(0, |at| (at + 1).min(last))),
            (Key::ArrowUp, self.selected.map_or(last, |at| at.saturating_sub(1))),
            (Key::PageDown, self.selected.map_or(0, |at| (at + 10).min(last))),
            (Key::PageUp, self.selected.map_or(0, |at| at.saturating_sub(10))),
            (Key::Home, 0),
            (Key::End, last),
        ];
        for (key, to) in moved {
            if pressed(key) && !self.shown.is_empty() {
                self.select(to);
                self.reveal = true;
                // From here on the selection moves, not the focus.
                focused.inspect(|id| ctx.memory_mut(|memory| memory.surrender_focus(*id)));
            }
        }
        if pressed(Key::Enter) {
            self.accept();
        }
        if pressed(Key::Backspace) {
            self.up();
        }
    }

    /// Shows another directory; where it cannot be read, says why and stays.
    fn enter(&mut self, directory: &Path) -> bool {
        match listing::read(directory) {
            Ok(entries) => {
                self.take_entries(directory.to_owned(), entries);
                self.path = self.directory.to_string_lossy().into_owned();
                true
            }
            Err(error) => {
                self.error = Some(error);
                false
            }
        }
    }

    fn take_entries(&mut self, directory: PathBuf, entries: Vec<Entry>) {
        self.directory = directory;
        self.entries = entries;
        self.error = None;
        self.replace = None;
        self.filter();
    }

    fn filter(&mut self) {
        let extensions = if self.all_files { &[][..] } else { &self.purpose.extensions };
        let fits = |entry: &Entry| entry.is_directory || listing::has_extension(&entry.name, extensions);
        self.shown = (0..self.entries.len()).filter(|index| fits(&self.entries[*index])).collect();
        self.selected = None;
        self.reveal = false;
    }

    fn up(&mut self) {
        let from = self.directory.clone();
        if let Some(parent) = from.parent()
            && self.enter(parent)
        {
            // Where one came from is where one goes on.
            let is_it = |index: &usize| Some(self.entries[*index].name.as_os_str()) == from.file_name();
            self.selected = self.shown.iter().position(is_it);
            self.reveal = true;
        }
    }

    fn select(&mut self, row: usize) {
        self.selected = Some(row);
        self.error = None;
        self.replace = None;
        if let Some(entry) = self.shown.get(row).map(|index| &self.entries[*index])
            && !entry.is_directory
            && self.name.is_some()
        {
            self.name = Some(Typed::of(&entry.name));
        }
    }

    /// Takes what the path field says.
    fn go(&mut self) {
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
                    self.name = Some(Typed::of(name));
                    self.accept();
                }
            }
            _ => self.error = Some(format!("{} is not the name of a file", path.display())),
        }
    }

    /// Takes what is selected, or the name to save under.
    fn accept(&mut self) {
        let selected = self.selected.and_then(|row| self.entries.get(*self.shown.get(row)?));
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

    /// Chooses a file to open, if it is one.
    fn choose(&mut self, path: PathBuf) {
        if path.is_file() {
            self.choice = Some(Choice::Chosen(path));
        } else {
            self.error = Some(format!("{} is not there, or is not a file", path.display()));
        }
    }

    /// Chooses a name to save under, which may have directories in it.
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
        let path = parent.join(listing::with_extension(name, &self.purpose.extensions));
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
