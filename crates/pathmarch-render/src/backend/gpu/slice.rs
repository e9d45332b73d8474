//! Slices of the work on a picture, one for each dispatch.

use crate::wgsl::shared_struct;

shared_struct! {
    /// Samples and pixels of one dispatch.
    pub(super) struct Slice as Slice {
        /// Index of the first sample.
        pub(super) sample: u32,
        /// Number of samples: one, or more where they share a camera ray.
        pub(super) samples: u32,
        pub(super) first_row: u32,
        pub(super) rows: u32,
        pub(super) first_column: u32,
        pub(super) columns: u32,
        /// Slot of the first path among those that may be suspended.
        pub(super) first_slot: u32,
        pub(super) padding: u32,
    }
}

impl Slice {
    /// Number of samples of single pixels.
    pub(super) fn work(&self) -> f64 {
        f64::from(self.samples) * f64::from(self.rows) * f64::from(self.columns)
    }
}

/// Progress of a film: every pixel has `samples` samples. Those above `row`, and in the eight rows from there
/// those left of `column`, have `begun` more.
#[derive(Clone, Copy, Default)]
pub(super) struct Progress {
    pub(super) samples: u32,
    pub(super) begun: u32,
    pub(super) row: u32,
    pub(super) column: u32,
}

/// Rows of a workgroup.
pub(super) const BAND: u32 = 8;
