//! Parts of the source editor: coloured syntax, names that fit, marks of mistakes and colours beside the line numbers, numbers
//! that are dragged.

mod coloured_text;
mod completion_list;
mod margin;
mod number_drag;
mod positions;

pub(crate) use coloured_text::ColouredText;
pub(crate) use completion_list::CompletionList;
pub(crate) use margin::Margin;
pub(crate) use number_drag::NumberDrag;
pub(crate) use positions::{byte_of, set_cursor};

/// State of the source editor.
#[derive(Default)]
pub(crate) struct SourceEditor {
    pub(crate) coloured: ColouredText,
    pub(crate) list: Option<CompletionList>,
    pub(crate) drag: NumberDrag,
    pub(crate) margin: Margin,
    /// Byte of the text to go to in the next frame.
    pub(crate) go_to: Option<usize>,
    /// Byte under a resting pointer, the revision of the text, and the help on the word there.
    pub(crate) help: Option<(usize, u64, Option<String>)>,
    /// The text cursor, characters.
    pub(crate) cursor: Option<usize>,
}
