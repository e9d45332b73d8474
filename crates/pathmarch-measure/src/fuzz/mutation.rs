//! Random changes of an input.

/// Random numbers: SplitMix64 (Steele, Lea, Flood 2014).
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// Number below `end`, which is at least 1.
    pub(super) fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
    pub(super) fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Longest input, bytes.
const MAX_BYTES: usize = 64 << 10;
/// Texts that are likely to be misread.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1e38",
    "1e-38",
    "nan",
    "#inf",
    "4294967296",
    "{",
    "}",
    "(",
    ")",
    ";",
    "\n",
    "\\",
    "\"",
    "\"\"\"",
    "/*",
    "*/",
    "/-",
    "//",
    "\u{feff}",
    "\u{202e}",
    "\u{0}",
    "object \"x\" { sphere }",
    "repeat 1 1 1 {",
    "union smooth=1 {",
    "include \"x.kdl\"",
    "\"t * 2\"",
];
const BYTES: &[u8] = &[0, 1, 0x7f, 0x80, 0xff, b'"', b'{', b'}', b'-', b'9'];

/// Random range of an input, mostly short.
fn range(random: &mut Random, length: usize) -> std::ops::Range<usize> {
    let start = random.below(length + 1);
    let longest = if random.below(4) == 0 { length } else { 16 };
    start..(start + random.below(longest + 1)).min(length)
}

/// Changes an input at random, a few times; ranges of `other` may get into it.
pub(super) fn mutate(random: &mut Random, input: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=random.below(6) {
        change(random, &mut bytes, other);
    }
    bytes.truncate(MAX_BYTES);
    bytes
}

fn change(random: &mut Random, bytes: &mut Vec<u8>, other: &[u8]) {
    let place = range(random, bytes.len());
    match random.below(9) {
        0 if !bytes.is_empty() => {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
        }
        1 if !bytes.is_empty() => {
            let at = random.below(bytes.len());
            bytes[at] = *random.pick(BYTES);
        }
        2 => drop(bytes.drain(place)),
        3 => {
            let copy = bytes[place.clone()].to_vec();
            let times = 1 + random.below(8);
            bytes.splice(place.end..place.end, copy.repeat(times));
        }
        4 => drop(bytes.splice(place, random.pick(WORDS).bytes())),
        5 => {
            let taken = range(random, other.len());
            bytes.splice(place, other[taken].iter().copied());
        }
        6 => bytes.truncate(place.start),
        7 => {
            // A number of four bytes, as headers have them.
            let number = (random.next() >> random.below(64)) as u32;
            let number = if random.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
            let end = (place.start + 4).min(bytes.len());
            bytes.splice(place.start..end, number);
        }
        _ => {
            let text = format!("{}", (random.next() >> random.below(64)) as f64 / 1000.0);
            bytes.splice(place, text.bytes());
        }
    }
}
