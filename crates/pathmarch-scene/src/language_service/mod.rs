//! Answers for text editors about a place in a scene text: mistakes, names that fit, help, colours, declarations.
//!
//! **Idea.** The reader of scenes knows best what may stand where, and lists it in its mistakes. Names that fit a place
//! are those that the reader expects when a word that does not exist stands there (`completion.rs`). So there is no second
//! description of the language, and completion knows what the reader knows, such as declared shapes and parameters.
//! Help comes from [`crate::reference`], colours are those that the reader has read as colours.
//!
//! Places are bytes of the text. **Cost.** A change of the text is one reading; a completion is up to two, in a scene of
//! 10,000 objects about 50 ms each.

mod colours;
mod completion;
mod declarations;
mod definition;
mod highlight;
mod hover;
pub mod in_document;
mod locate;
mod symbols;

use crate::assets::Assets;
use crate::diagnostic::{Mistake, SceneError};
use crate::language::tree::Block;
use crate::language::{self, Read, Values};
use crate::scene::Moment;
pub use colours::{TextColour, display_colour, written_colours};
pub use completion::{Completion, CompletionKind, Completions};
pub use definition::Definition;
pub use highlight::{Token, TokenKind, highlight};
pub use hover::Hover;
pub use symbols::{Symbol, SymbolKind};

/// A scene text that is open in an editor.
pub struct OpenText {
    name: String,
    text: String,
    assets: Assets,
    /// Nodes; `None` if the text was refused as a whole.
    file: Option<Block<'static>>,
    values: Values,
    mistakes: Vec<Mistake>,
    /// Reason and help of a text that could not be read at all.
    refusal: Option<(String, String)>,
}

impl OpenText {
    /// Opens a text. `name` is its path, to which other files are relative; unless `allow_files` is true, none is read
    /// outside its folder.
    pub fn new(name: impl Into<String>, text: impl Into<String>, allow_files: bool) -> Self {
        let assets = if allow_files { Assets::default() } else { Assets::confined() };
        let (name, file, values) = (name.into(), None, Values::default());
        let mut open = Self { name, text: String::new(), assets, file, values, mistakes: Vec::new(), refusal: None };
        open.set_text(text);
        open
    }
    /// Replaces the text.
    pub fn set_text(&mut self, text: impl Into<String>) {
        self.text = text.into();
        self.refresh();
    }
    /// Reads the text again, because a file that it names has changed.
    pub fn refresh(&mut self) {
        let Read { file, scene, values } = language::read(&self.name, &self.text, Moment::default(), &mut self.assets);
        self.file = file.map(Block::into_owned);
        self.values = values;
        (self.mistakes, self.refusal) = match scene {
            Ok(scene) => (scene.warnings, None),
            Err(SceneError::Mistakes { mistakes, .. }) => (mistakes, None),
            Err(SceneError::Unreadable { reason, help, .. }) => (Vec::new(), Some((reason, help))),
        };
    }
    /// Path of the text.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }
    /// Mistakes of the text and of the files that it includes, a hundred at most; the warnings of a text without mistakes.
    pub fn mistakes(&self) -> &[Mistake] {
        &self.mistakes
    }
    /// Reason and help of a text that could not be read at all.
    pub fn refusal(&self) -> Option<(&str, &str)> {
        self.refusal.as_ref().map(|(reason, help)| (reason.as_str(), help.as_str()))
    }
}
