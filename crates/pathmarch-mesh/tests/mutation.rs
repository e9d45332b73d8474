//! Damaged files: no panic, and memory in proportion to the file.

use crate::memory;
use crate::shapes::Random;
use pathmarch_mesh::{EXTENSIONS, ReadOptions, read_bytes};
use std::path::Path;

/// Bytes of memory for each byte of a file, and for any file, that reading may take at its peak.
const BYTES_A_BYTE: usize = 1000;
const BYTES: usize = 1 << 20;

/// Files to damage: extension and contents.
fn seeds() -> Vec<(String, Vec<u8>)> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let directories = [data.join("odd"), data];
    let paths = directories.iter().flat_map(|directory| std::fs::read_dir(directory).expect("a directory"));
    let mut paths: Vec<_> = paths.map(|entry| entry.expect("a file").path()).collect();
    paths.sort();
    let seed = |path: &std::path::PathBuf| {
        let extension = path.extension()?.to_str()?.to_string();
        let is_small = path.metadata().ok()?.len() < 80_000;
        (is_small && EXTENSIONS.contains(&extension.as_str()))
            .then(|| (extension, std::fs::read(path).expect("a file")))
    };
    paths.iter().filter_map(seed).collect()
}

/// Values that are often at the border of what is valid.
const WORDS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"4294967295",
    b"18446744073709551615",
    b"1e39",
    b"nan",
    b"[",
    b"}",
    b"\"",
    b"\n",
    b"/",
    b" ",
    b"\\",
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x00",
    b"\xff\xff\xff\x7f",
];

/// Damages some bytes: mostly overwrites, so that much of a file stays what it was; or inserts, removes, repeats, and cuts.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let scale = random.below(8);
        let end = (at + 1 + random.below(1 << scale)).min(bytes.len());
        let word = WORDS[random.below(WORDS.len())];
        match random.below(16) {
            0 => bytes.truncate(at),
            1 => drop(bytes.splice(at..end, [])),
            2 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            3 => drop(bytes.splice(at..at, word.iter().copied())),
            4..8 => {
                let end = (at + word.len()).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            8..12 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            _ if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => {}
        }
    }
}

fn read_mutated(count: u64) {
    let seeds = seeds();
    let (mut read, mut largest) = (0, 0.0_f64);
    for number in 0..count {
        let mut random = Random(1 + number);
        let (extension, bytes) = &seeds[random.below(seeds.len())];
        let mut bytes = bytes.clone();
        mutate(&mut bytes, &mut random);
        let limit = BYTES_A_BYTE * bytes.len() + BYTES;
        let (result, peak) = memory::peak_of(|| {
            read_bytes(&bytes, extension, Path::new("nowhere/mesh"), &ReadOptions::default()).map(|_| ())
        });
        read += usize::from(result.is_ok());
        largest = largest.max(peak as f64 / bytes.len().max(1000) as f64);
        assert!(peak < limit, "file {number}: {peak} bytes for {}", bytes.len());
        if let Err(error) = result {
            assert!(error.to_string().contains("nowhere/mesh: "), "{error}");
        }
    }
    println!("{read} of {count} damaged files are read; at most {largest:.0} bytes of memory a byte");
}

#[test]
fn damaged_files_are_read_or_refused() {
    read_mutated(2_000);
}

#[test]
#[ignore = "takes minutes"]
fn a_hundred_thousand_damaged_files_are_read_or_refused() {
    read_mutated(100_000);
}
