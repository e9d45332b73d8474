//! Values of the members of a shape grid that are code.

use std::cell::Cell;

/// Number of members whose values are kept.
const KEPT: usize = 4;

/// Values of members at the points of one evaluation. The first few are evaluated once at most, others each time.
pub(super) struct CodeValues<T, F> {
    values: [Cell<Option<T>>; KEPT],
    value: F,
}

impl<T: Copy, F: Fn(u32) -> T> CodeValues<T, F> {
    /// `value` evaluates the member of an index.
    pub(super) fn new(value: F) -> Self {
        Self { values: [const { Cell::new(None) }; KEPT], value }
    }

    /// Value of the member of this index.
    pub(super) fn get(&self, index: u32) -> T {
        let kept = self.values.get(index as usize);
        kept.and_then(Cell::get).unwrap_or_else(|| {
            let value = (self.value)(index);
            kept.inspect(|kept| kept.set(Some(value)));
            value
        })
    }
}
