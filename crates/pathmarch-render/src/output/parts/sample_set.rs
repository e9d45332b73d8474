//! Sets of sample indices.

use std::fmt::{Display, Formatter};
use std::ops::Range;

/// Set of sample indices: ranges in increasing order, with gaps between them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SampleSet {
    ranges: Vec<[u32; 2]>,
}

impl From<Range<u32>> for SampleSet {
    fn from(range: Range<u32>) -> Self {
        let mut set = Self::default();
        set.insert(range);
        set
    }
}

impl SampleSet {
    /// Set of ranges, given by start and end.
    pub fn of(ranges: &[[u32; 2]]) -> Self {
        let mut set = Self::default();
        ranges.iter().for_each(|[start, end]| set.insert(*start..*end));
        set
    }

    /// Start and end of each range.
    pub fn ranges(&self) -> &[[u32; 2]] {
        &self.ranges
    }

    /// True of a set without samples.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Number of samples.
    pub fn count(&self) -> u32 {
        self.ranges.iter().map(|[start, end]| end - start).sum()
    }

    /// Adds the samples of a range.
    pub fn insert(&mut self, range: Range<u32>) {
        if range.is_empty() {
            return;
        }
        let first = self.ranges.partition_point(|[_, end]| *end < range.start);
        let last = self.ranges.partition_point(|[start, _]| *start <= range.end);
        let touched = &self.ranges[first..last];
        let start = touched.first().map_or(range.start, |[start, _]| range.start.min(*start));
        let end = touched.last().map_or(range.end, |[_, end]| range.end.max(*end));
        self.ranges.splice(first..last, [[start, end]]);
    }

    /// Samples of either set.
    pub fn union(&self, other: &Self) -> Self {
        let mut union = self.clone();
        other.ranges.iter().for_each(|[start, end]| union.insert(*start..*end));
        union
    }

    /// Samples of both sets.
    pub fn intersection(&self, other: &Self) -> Self {
        let mut both = Self::default();
        for [a, b] in &self.ranges {
            for [c, d] in &other.ranges {
                both.insert(*a.max(c)..*b.min(d));
            }
        }
        both
    }

    /// Samples of a range that are not in the set.
    pub fn missing_from(&self, range: Range<u32>) -> Self {
        let mut missing = Self::default();
        let mut at = range.start;
        for [start, end] in &self.ranges {
            missing.insert(at..(*start).min(range.end));
            at = at.max(*end);
        }
        missing.insert(at..range.end);
        missing
    }
}

impl Display for SampleSet {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        let ranges: Vec<String> = self.ranges.iter().map(|[start, end]| format!("{start}..{end}")).collect();
        f.write_str(&ranges.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_those_of_their_samples() {
        for seed in 0..2000_u32 {
            let bits = [seed.wrapping_mul(2_654_435_761), seed.wrapping_mul(40_503).rotate_left(7)];
            let [a, b] = bits.map(|bits| {
                let mut set = SampleSet::default();
                (0..32).filter(|k| bits >> k & 1 == 1).for_each(|k| set.insert(k..k + 1));
                set
            });
            let bits_of = |set: &SampleSet| {
                let samples = set.ranges().iter().flat_map(|[start, end]| *start..*end);
                samples.fold(0_u32, |bits, k| bits | 1 << k)
            };
            assert_eq!((bits_of(&a), a.count()), (bits[0], bits[0].count_ones()));
            assert_eq!(bits_of(&a.union(&b)), bits[0] | bits[1]);
            assert_eq!(bits_of(&a.intersection(&b)), bits[0] & bits[1]);
            assert_eq!(bits_of(&a.missing_from(4..30)), !bits[0] & 0x3fff_fff0);
            assert!(a.ranges().windows(2).all(|pair| pair[0][1] < pair[1][0]), "{a}");
        }
    }
}
