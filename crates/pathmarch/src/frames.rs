//! Frame ranges of `--frames`, and file names of frames.

use crate::film_notes::is_film;
use pathmarch_render::image;
use pathmarch_render::parts::FilmFile;
use std::path::{Path, PathBuf};

/// Maximum number of frames of one command.
const MAX_FRAMES: u32 = 1_000_000;

/// Frame range of `--frames`: first frame, last frame and step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRange {
    first: u32,
    last: u32,
    step: u32,
}

/// Parses `7`, `1-120` or `1-120x2`.
pub fn parse(text: &str) -> Result<FrameRange, String> {
    let expected = || "expected a frame number, a range such as 1-120, or a range with a step, 1-120x2".to_owned();
    let number = |text: &str| {
        let text = text.trim();
        let is_whole = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse::<u32>().map_err(|_| if is_whole { format!("the last frame is {}", u32::MAX) } else { expected() })
    };
    let (range, step) = match text.split_once(['x', '×']) {
        Some((range, step)) => (range, number(step)?),
        None => (text, 1),
    };
    let (first, last) = match range.split_once('-') {
        Some((first, last)) => (number(first)?, number(last)?),
        None => (number(range)?, number(range)?),
    };
    if first > last {
        return Err(format!("the first frame, {first}, is after the last, {last}"));
    }
    if step == 0 {
        return Err("the step must be at least 1".to_owned());
    }
    if (last - first) / step >= MAX_FRAMES {
        return Err(format!("at most {MAX_FRAMES} frames"));
    }
    Ok(FrameRange { first, last, step })
}

impl FrameRange {
    #[cfg(feature = "window")]
    /// All frames from `first` to `last`; only `last` if it is before `first`.
    pub fn from_to(first: u32, last: u32) -> Self {
        Self { first: first.min(last), last, step: 1 }
    }
    /// Difference between consecutive numbers.
    pub fn step(self) -> u32 {
        self.step
    }
    /// Frame numbers.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }
}

/// File name of a frame: replaces the last run of `#` in `pattern` by the frame number, padded with zeros.
pub fn file(pattern: &Path, frame: u32) -> PathBuf {
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    let Some(end) = name.rfind('#') else { return pattern.to_owned() };
    let start = name[..end].trim_end_matches('#').len();
    let digits = end + 1 - start;
    pattern.with_file_name(format!("{}{frame:0digits$}{}", &name[..start], &name[end + 1..]))
}

/// True if the file of a frame is whole: it can be read to its end.
pub fn is_whole(file: &Path) -> bool {
    if is_film(file) {
        FilmFile::open(file).and_then(|mut film| film.part()).is_ok()
    } else {
        image::load(file).is_ok()
    }
}

/// Rejects a file name that several frames would share.
///
/// # Errors
/// Fails with a message.
pub fn check_pattern(pattern: &Path, frames: FrameRange) -> Result<(), String> {
    if frames.numbers().nth(1).is_none() || file(pattern, 0) != pattern {
        return Ok(());
    }
    let (stem, extension) = (pattern.file_stem().unwrap_or_default(), pattern.extension().unwrap_or_default());
    let name = format!("{}-####.{}", stem.to_string_lossy(), extension.to_string_lossy());
    Err(format!(
        "{} would be overwritten by every frame; put # in place of the frame number, as in {}",
        pattern.display(),
        pattern.with_file_name(name).display()
    ))
}

#[cfg(test)]
mod tests {
    use super::{FrameRange, file, parse};
    use std::path::Path;

    #[test]
    fn ranges_are_parsed() {
        assert_eq!(parse("4294967295"), Ok(FrameRange { first: u32::MAX, last: u32::MAX, step: 1 }));
        for huge in ["4294967296", "1-99999999999999999999", "0-9x99999999999"] {
            assert!(parse(huge).is_err_and(|words| words.contains("the last frame is 4294967295")), "{huge}");
        }
        assert_eq!(parse("7"), Ok(FrameRange { first: 7, last: 7, step: 1 }));
        assert_eq!(parse("1-120"), Ok(FrameRange { first: 1, last: 120, step: 1 }));
        assert_eq!(parse("0-9x4").unwrap().numbers().collect::<Vec<_>>(), [0, 4, 8]);
        for wrong in ["", "-", "a", "1-", "-3", "5-1", "1-9x0", "1x", "0-4294967295", "1-2-3", "1.5"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_take_the_place_of_digits() {
        let named = |pattern: &str, frame| file(Path::new(pattern), frame).display().to_string();
        assert_eq!(named("out/frame-####.png", 12), "out/frame-0012.png");
        assert_eq!(named("a#/b##c.png", 123), "a#/b123c.png");
        assert_eq!(named("take#2-###.exr", 7), "take#2-007.exr");
        assert_eq!(named("still.png", 7), "still.png");
    }
}
