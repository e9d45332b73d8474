//! Thread pool of the program.
//!
//! **Idea.** One rayon pool, created before any computation, with one thread per available core. The variable
//! `RAYON_NUM_THREADS` can ask for fewer threads, as in every program that uses rayon, but not for more: several
//! threads on a core are no faster, and thousands of them take minutes to start.

use rayon::ThreadPoolBuilder;

const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Starts the threads; call this before anything else uses rayon. Returns a note if more threads were requested than
/// there are cores.
pub fn start() -> Option<String> {
    let asked = std::env::var(VARIABLE).ok();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (threads, note) = chosen(asked.as_deref(), cores);
    // Fails only if a pool exists already or no thread can be started; rayon then runs on the calling thread.
    let _ = ThreadPoolBuilder::new().num_threads(threads).build_global();
    note
}

/// Number of threads, and a note if it differs from the request. As in rayon, 0 and invalid numbers request the
/// default.
fn chosen(asked: Option<&str>, cores: usize) -> (usize, Option<String>) {
    let asked = asked.map(str::trim).filter(|asked| !asked.is_empty());
    // A number that overflows an integer requests too many threads.
    let is_huge = |asked: &str| asked.parse::<usize>().is_err() && asked.bytes().all(|byte| byte.is_ascii_digit());
    match asked.map(|asked| (asked, asked.parse::<usize>())) {
        Some((_, Ok(threads @ 1..))) if threads <= cores => (threads, None),
        Some((asked, Ok(1..))) => (cores, Some(note(asked, cores))),
        Some((asked, Err(_))) if is_huge(asked) => (cores, Some(note(asked, cores))),
        _ => (cores, None),
    }
}

fn note(asked: &str, cores: usize) -> String {
    format!("{VARIABLE} asks for {asked} threads; using {cores}, one for each core")
}

#[cfg(test)]
mod tests {
    use super::chosen;

    #[test]
    fn fewer_threads_can_be_requested_but_not_more() {
        for (asked, expected) in [
            (None, 8),
            (Some(""), 8),
            (Some("0"), 8),
            (Some("many"), 8),
            (Some("-3"), 8),
            (Some("1"), 1),
            (Some("8"), 8),
        ] {
            assert_eq!(chosen(asked, 8), (expected, None), "{asked:?}");
        }
        for asked in ["9", "100000", "99999999999999999999999"] {
            let (threads, note) = chosen(Some(asked), 8);
            let note = note.expect("a note");
            assert!(threads == 8 && note.contains(asked) && note.contains("using 8"), "{note}");
        }
    }
}
