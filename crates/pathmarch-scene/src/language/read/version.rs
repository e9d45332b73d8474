//! The version of the language, which a file starts with.

use super::arguments::wrong_type;
use super::context::Context;
use super::numbers::numbers;
use crate::language::diagnostics::report::draft;
use crate::language::tree::{Block, Span, Value};
use crate::settings::Range;

/// Version of the language that this program reads.
const VERSION: f32 = 1.0;

#[derive(PartialEq)]
pub(crate) enum Version {
    /// This version, or a missing one: the rest can be read.
    This,
    /// Another version, whose words are unknown.
    Other,
}

/// Checks the first node of the file.
pub(crate) fn version(file: &Block, context: &mut Context) -> Version {
    let Some(first) = file.nodes.first().filter(|first| first.name.value == "pathmarch") else {
        if !file.broken || file.nodes.iter().any(|node| node.name.value == "pathmarch") {
            let later = file.nodes.iter().find(|node| node.name.value == "pathmarch");
            let span = file.nodes.first().map_or(Span::new(0, 0), |first| first.name.span);
            let mistake = draft("pathmarch::version", span, "A scene starts with its version.");
            let mistake = mistake.label("expected `pathmarch 1` before it");
            context.report.add(match later {
                Some(later) => mistake.also(later.name.span, "move this to the top of the file"),
                None => mistake.help("Write `pathmarch 1` on the first line."),
            });
        }
        return Version::This;
    };
    if let Some(entry) = first.entries.iter().find(|entry| matches!(entry.value, Value::Text(_))) {
        wrong_type(entry, "The version", "a number", context);
        return Version::This;
    }
    let Some([given]) = numbers::<1>(first, "`pathmarch 1`", Range::ANY, context) else { return Version::This };
    if given == VERSION {
        return Version::This;
    }
    let span = first.entries[0].value_span;
    if given > VERSION && given.fract() == 0.0 {
        let message = format!("This scene is written in version {given} of the language.");
        let mistake = draft("pathmarch::version", span, message).label(format!("this program reads version {VERSION}"));
        context.report.add(mistake.help("Use a newer pathmarch."));
        return Version::Other;
    }
    let message = format!("There is no version {given} of the language.");
    context.report.add(draft("pathmarch::version", span, message).label("expected 1"));
    Version::This
}
