//! Errors of edits. A refused edit leaves the text unchanged.

use super::tree::path::Path;

/// Reason why an edit is refused, in sentences for people: what, where, what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// The path names no node of this text.
    #[error("There is no node {0} in this scene. Select one of those that it has.")]
    NoSuchNode(Path),
    /// The node has no control of this key.
    #[error("`{node}` has no `{key}`.")]
    NoSuchControl {
        /// Word of the node.
        node: String,
        /// The key that was asked for.
        key: String,
    },
    /// The value is of another type than the control's.
    #[error("`{label}` must be {expected}.")]
    WrongValue {
        /// Label of the control.
        label: String,
        /// As in "a colour".
        expected: String,
    },
    /// The value is not one of those allowed.
    #[error("`{label}` must be {range}.")]
    OutOfRange {
        /// Label of the control.
        label: String,
        /// As in "above 0".
        range: String,
    },
    /// Numbers would take the place of a formula.
    #[error("`{label}` is the formula \"{formula}\". Change that, or reset it first.")]
    Formula {
        /// Label of the control.
        label: String,
        /// The formula.
        formula: String,
    },
    /// A name that is empty or taken, or a node that has none.
    #[error("{0}")]
    Name(String),
    /// The node cannot go to this place, or not become this kind.
    #[error("{0}")]
    NotHere(String),
    /// The node is needed where it is.
    #[error("{0}")]
    Needed(String),
    /// The text around the node could not be read well enough to change it safely.
    #[error(
        "The text of `{0}` has mistakes of form, such as a brace that is never closed: correct them in the text first."
    )]
    Unreadable(String),
    /// The scene would have a mistake that it has not now.
    #[error("This would make a mistake in the scene: {message}{}", .help.as_ref().map(|help| format!(" {help}")).unwrap_or_default())]
    Mistake {
        /// The first mistake.
        message: String,
        /// Help: what to do.
        help: Option<String>,
    },
}
