//! Accuracy of a distance far from all surfaces.

/// Value of the distance far from all surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FarField {
    /// A bound: nearer to zero than the distance, of the same sign.
    Bound,
    /// An estimate of the distance.
    Estimate,
    /// The exact fold of all shapes.
    Exact,
}
