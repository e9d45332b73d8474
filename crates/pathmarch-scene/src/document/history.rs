//! Undo and redo.
//!
//! A step contains the text that it removed and inserted, so that it can be undone and redone byte for byte. Cost:
//! memory in proportion to the changes; no limit on the number of steps.

use super::text::patch::{Hunk, Patch, apply, compose, difference};

/// A replacement that a step made.
#[derive(Clone, Debug)]
struct Change {
    /// Start in the text before.
    old: usize,
    removed: String,
    /// Start of the replacement in the text after.
    new: usize,
    inserted: String,
}

/// Replacements that are done and undone together.
#[derive(Clone, Debug)]
struct Step {
    label: String,
    gesture: Option<u64>,
    changes: Vec<Change>,
}

impl Step {
    fn new(label: &str, gesture: Option<u64>, (old, new): (&str, &str), hunks: &[Hunk]) -> Self {
        let changes = hunks.iter().map(|hunk| {
            let Patch { range, text } = difference(&old[hunk.old.clone()], &new[hunk.new.clone()]);
            Change {
                old: hunk.old.start + range.start,
                removed: old[hunk.old.clone()][range.clone()].to_owned(),
                new: hunk.new.start + range.start,
                inserted: text,
            }
        });
        let changes = changes.filter(|change| change.removed != change.inserted).collect();
        Self { label: label.to_owned(), gesture, changes }
    }
    fn before(&self, text: &str) -> String {
        let back = |change: &Change| Patch::replace(change.new..change.new + change.inserted.len(), &*change.removed);
        apply(text, self.changes.iter().map(back).collect()).0
    }
    fn after(&self, text: &str) -> String {
        let forth = |change: &Change| Patch::replace(change.old..change.old + change.removed.len(), &*change.inserted);
        apply(text, self.changes.iter().map(forth).collect()).0
    }
    fn hunks(&self) -> Vec<Hunk> {
        let hunk = |change: &Change| Hunk {
            old: change.old..change.old + change.removed.len(),
            new: change.new..change.new + change.inserted.len(),
        };
        self.changes.iter().map(hunk).collect()
    }
}

/// Steps that were done, and steps that were undone.
#[derive(Debug, Default)]
pub(super) struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    /// True if the next step may join the last one.
    open: bool,
}

impl History {
    /// Adds a step from the text `old` to `new`; it joins the last step of the same gesture.
    pub(super) fn push(&mut self, label: &str, gesture: Option<u64>, old: &str, new: &str, hunks: &[Hunk]) {
        self.undone.clear();
        let joined = self.done.pop_if(|last| self.open && gesture.is_some() && last.gesture == gesture);
        let step = match joined {
            Some(last) => {
                let hunks = compose(&last.hunks(), hunks);
                Step::new(&last.label, gesture, (&last.before(old), new), &hunks)
            }
            None => Step::new(label, gesture, (old, new), hunks),
        };
        // A slider that is back where it was leaves nothing to take back.
        if !step.changes.is_empty() {
            self.done.push(step);
        }
        self.open = true;
    }
    /// Undoes the last step. Returns the text before it, and its label.
    pub(super) fn undo(&mut self, text: &str) -> Option<(String, String)> {
        let step = self.done.pop()?;
        let result = (step.before(text), step.label.clone());
        self.undone.push(step);
        self.open = false;
        Some(result)
    }
    /// Redoes the step that was undone last. Returns the text after it, and its label.
    pub(super) fn redo(&mut self, text: &str) -> Option<(String, String)> {
        let step = self.undone.pop()?;
        let result = (step.after(text), step.label.clone());
        self.done.push(step);
        self.open = false;
        Some(result)
    }
    pub(super) fn next_undo(&self) -> Option<&str> {
        self.done.last().map(|step| &*step.label)
    }
    pub(super) fn next_redo(&self) -> Option<&str> {
        self.undone.last().map(|step| &*step.label)
    }
    /// Number of bytes that the history keeps.
    #[cfg(test)]
    fn bytes(&self) -> usize {
        let changes = self.done.iter().chain(&self.undone).flat_map(|step| &step.changes);
        changes.map(|change| change.removed.len() + change.inserted.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::text::patch::{Patch, apply};
    use super::History;

    #[test]
    fn a_gesture_is_one_step_and_costs_what_it_changed() {
        let mut history = History::default();
        let start = format!("{}sphere 1 2{}", "x".repeat(1000), "y".repeat(1000));
        let mut text = start.clone();
        for value in 10..99 {
            let (new, hunks) = apply(&text, vec![Patch::replace(1007..text.find(" 2y").unwrap(), value.to_string())]);
            history.push("drag", Some(1), &text, &new, &hunks);
            text = new;
        }
        assert_eq!(history.bytes(), 3);
        let (before, label) = history.undo(&text).unwrap();
        assert_eq!((before.as_str(), label.as_str(), history.next_undo()), (start.as_str(), "drag", None));
        assert_eq!(history.redo(&before).unwrap().0, text);
        // After a step back or forth, a gesture begins anew.
        let (new, hunks) = apply(&text, vec![Patch::insert(0, "z")]);
        history.push("drag", Some(1), &text, &new, &hunks);
        assert_eq!(history.undo(&new).unwrap().0, text);
        assert_eq!(history.next_undo(), Some("drag"));
    }

    #[test]
    fn a_gesture_that_comes_back_leaves_no_step() {
        let mut history = History::default();
        let (b, there) = apply("a", vec![Patch::replace(0..1, "b")]);
        history.push("drag", Some(7), "a", &b, &there);
        let (a, back) = apply(&b, vec![Patch::replace(0..1, "a")]);
        history.push("drag", Some(7), &b, &a, &back);
        assert_eq!((a.as_str(), history.next_undo()), ("a", None));
    }
}
