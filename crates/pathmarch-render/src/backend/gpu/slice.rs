//! Slices of a picture's work, one for each dispatch.

use crate::wgsl::{shared_constants, shared_struct};

shared_struct! {
    /// Samples and pixels of one dispatch.
    pub(super) struct Slice as Slice {
        /// Index of the first sample.
        pub(super) sample: u32,
        /// Number of samples: one, several that share a camera ray, or several with rays of their own.
        pub(super) samples: u32,
        pub(super) first_row: u32,
        pub(super) rows: u32,
        pub(super) first_column: u32,
        pub(super) columns: u32,
        /// Index of the first path in the buffer of suspended paths.
        pub(super) first_slot: u32,
        /// Number of samples whose guides are stored, this one included; 0 if they are not.
        pub(super) guide_samples: u32,
        /// First of the edges of emitters in its rows, and their number.
        pub(super) first_edge: u32,
        pub(super) edges: u32,
        pub(super) padding: [u32; 2],
    }
}

shared_constants! {
    /// Pixels of a lane, where it takes several.
    pub(super) const PIXELS_PER_LANE: u32 = 4;
    /// Largest number of workgroups in a row of a dispatch for edges.
    pub(super) const MAX_GROUPS_ACROSS: u32 = 32_768;
}

impl Slice {
    /// Number of samples, summed over pixels.
    pub(super) fn work(&self) -> f64 {
        f64::from(self.samples) * f64::from(self.rows) * f64::from(self.columns)
    }
}

/// Progress of a film. Every pixel has `samples` samples. Pixels above `row` have `begun` more, and so have, in the eight rows
/// from there, the pixels left of `column`.
#[derive(Clone, Copy, Default)]
pub(super) struct Progress {
    pub(super) samples: u32,
    pub(super) begun: u32,
    pub(super) row: u32,
    pub(super) column: u32,
}

/// Height of a workgroup, rows.
pub(super) const BAND: u32 = 8;
