//! Changes of a text: patches, and the correspondence of ranges before and after.
//!
//! Two changes in a row are one change between the first text and the last ([`compose`]), which is what lets an edit be
//! made in several simple steps, and a drag of a slider be one step of undo. Cost: linear in text and pieces.

use std::ops::Range;

/// A range of a text and its replacement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Patch {
    pub(crate) range: Range<usize>,
    pub(crate) text: String,
}

impl Patch {
    pub(crate) fn replace(range: Range<usize>, text: impl Into<String>) -> Self {
        Self { range, text: text.into() }
    }
    pub(crate) fn insert(at: usize, text: impl Into<String>) -> Self {
        Self::replace(at..at, text)
    }
    pub(crate) fn remove(range: Range<usize>) -> Self {
        Self::replace(range, "")
    }
}

/// A range of the old text, and the range of the new text that replaced it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hunk {
    pub(crate) old: Range<usize>,
    pub(crate) new: Range<usize>,
}

/// Applies patches, which must not overlap. Returns the new text and the changed ranges. Insertions at one place keep
/// their order.
pub(crate) fn apply(text: &str, mut patches: Vec<Patch>) -> (String, Vec<Hunk>) {
    patches.sort_by_key(|patch| (patch.range.start, patch.range.end));
    let mut new = String::with_capacity(text.len() + patches.iter().map(|patch| patch.text.len()).sum::<usize>());
    let mut hunks = Vec::new();
    let mut at = 0;
    for patch in patches {
        assert!(at <= patch.range.start, "patches overlap");
        new.push_str(&text[at..patch.range.start]);
        let start = new.len();
        new.push_str(&patch.text);
        at = patch.range.end;
        hunks.push(Hunk { old: patch.range, new: start..new.len() });
    }
    new.push_str(&text[at..]);
    (new, hunks)
}

/// Composition of two changes: `first`, then `second`.
pub(crate) fn compose(first: &[Hunk], second: &[Hunk]) -> Vec<Hunk> {
    let mut composed: Vec<Hunk> = Vec::new();
    let (mut a, mut b) = (first.iter().peekable(), second.iter().peekable());
    // How far a place between hunks of the middle text is from the same place in the old text and in the new one.
    let (mut to_old, mut to_new) = (0_isize, 0_isize);
    let moved = |at: usize, by: isize| at.wrapping_add_signed(by);
    let longer = |from: &Range<usize>, to: &Range<usize>| to.len() as isize - from.len() as isize;
    while let Some(start) = [a.peek().map(|a| a.new.start), b.peek().map(|b| b.old.start)].into_iter().flatten().min() {
        let (old_start, new_start) = (moved(start, to_old), moved(start, to_new));
        let mut end = start;
        loop {
            if let Some(hunk) = a.next_if(|hunk| hunk.new.start <= end) {
                end = end.max(hunk.new.end);
                to_old += longer(&hunk.new, &hunk.old);
            } else if let Some(hunk) = b.next_if(|hunk| hunk.old.start <= end) {
                end = end.max(hunk.old.end);
                to_new += longer(&hunk.old, &hunk.new);
            } else {
                break;
            }
        }
        composed.push(Hunk { old: old_start..moved(end, to_old), new: new_start..moved(end, to_new) });
    }
    composed
}

/// Smallest patch from `old` to `new`.
pub(crate) fn difference(old: &str, new: &str) -> Patch {
    let same = |(a, b): &(u8, u8)| a == b;
    let mut start = old.bytes().zip(new.bytes()).take_while(same).count();
    while !old.is_char_boundary(start) || !new.is_char_boundary(start) {
        start -= 1;
    }
    let (old_rest, new_rest) = (&old[start..], &new[start..]);
    let mut end = old_rest.bytes().rev().zip(new_rest.bytes().rev()).take_while(same).count();
    while !old.is_char_boundary(old.len() - end) || !new.is_char_boundary(new.len() - end) {
        end -= 1;
    }
    Patch::replace(start..old.len() - end, &new[start..new.len() - end])
}

#[cfg(test)]
mod tests {
    use super::{Hunk, Patch, apply, compose, difference};
    use proptest::prelude::*;

    /// Patches of a text of this length that do not overlap.
    fn patches(length: usize, seeds: &[(usize, usize, String)]) -> Vec<Patch> {
        let mut patches: Vec<Patch> = Vec::new();
        for (at, count, text) in seeds {
            let start = at % (length + 1);
            let range = start..(start + count % 5).min(length);
            let apart = |other: &Patch| range.end < other.range.start || other.range.end < range.start;
            if patches.iter().all(apart) {
                patches.push(Patch::replace(range, text.as_str()));
            }
        }
        patches
    }

    fn rebuilt(old: &str, new: &str, hunks: &[Hunk]) -> String {
        let pieces = hunks.iter().map(|hunk| Patch::replace(hunk.old.clone(), &new[hunk.new.clone()]));
        apply(old, pieces.collect()).0
    }

    proptest! {
        #[test]
        fn two_changes_are_one(
            text in "[a-e]{0,40}",
            first in prop::collection::vec((0..100_usize, 0..9_usize, "[x-z]{0,4}"), 0..6),
            second in prop::collection::vec((0..100_usize, 0..9_usize, "[0-9]{0,4}"), 0..6),
        ) {
            let (middle, a) = apply(&text, patches(text.len(), &first));
            let (last, b) = apply(&middle, patches(middle.len(), &second));
            prop_assert_eq!(rebuilt(&text, &last, &compose(&a, &b)), last);
        }

        #[test]
        fn a_difference_makes_the_new_text(old in "[aé€]{0,12}", new in "[aé€]{0,12}") {
            let (made, _) = apply(&old, vec![difference(&old, &new)]);
            prop_assert_eq!(made, new);
        }
    }
}
