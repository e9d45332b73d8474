//! Value parsers for numbers on the command line, with their error messages.
//!
//! Options that override a setting of the scene use the ranges of the scene language
//! ([`pathmarch_render::pathmarch_scene::settings`]). Numeric options accept values with a hyphen, so that the error for
//! `--seed -1` names the range of a seed instead of an unknown option `-1`.

use pathmarch_render::pathmarch_scene::settings::Range;

/// Parses an integer from `least` to `most`.
pub fn whole((least, most): (u32, u32)) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("must be a whole number from {least} to {most}"))
    }
}

/// Parses a finite number within a range.
pub fn number(range: Range) -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.accepts(*number));
        let finite = if range.max < f32::MAX { "" } else { "finite " };
        number.ok_or_else(|| format!("must be a {finite}number {}", range.in_words()))
    }
}

/// Parses a positive number of seconds, at most a day.
pub fn seconds(text: &str) -> Result<f64, String> {
    const DAY: f64 = 86_400.0;
    let seconds = text.trim().parse().ok().filter(|seconds: &f64| *seconds > 0.0 && *seconds <= DAY);
    seconds.ok_or_else(|| format!("must be a number of seconds above 0, at most {DAY}"))
}

/// Parses width and height in pixels, such as `1280x720`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    use pathmarch_render::pathmarch_scene::settings::SIDE;
    let side = |text: &str| {
        let text = text.trim();
        let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
        let is_whole = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        // A number that overflows an integer is still a number.
        is_whole.then(|| text.parse().ok().filter(|side| (SIDE.0..=SIDE.1).contains(side)))
    };
    let sides = text.split_once(['x', 'X', '×']).and_then(|(width, height)| side(width).zip(side(height)));
    match sides {
        Some((Some(width), Some(height))) => Ok([width, height]),
        Some(_) => Err(format!("each side must be from {} to {}", SIDE.0, SIDE.1)),
        None => Err("expected WIDTHxHEIGHT in pixels, such as 1280x720".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::settings;
    use pathmarch_render::{MAX_BOUNCES, image};

    #[test]
    fn limits_are_those_of_the_renderer() {
        assert_eq!((settings::BOUNCES.1, settings::SIDE.1), (MAX_BOUNCES, image::MAX_SIDE));
    }

    #[test]
    fn whole_numbers_are_within_their_range() {
        let parse = whole((1, 1000));
        assert_eq!((parse("1"), parse("1000"), parse(" 7 ")), (Ok(1), Ok(1000), Ok(7)));
        for wrong in ["", "0", "-1", "1001", "1.5", "1e2", "nan", "inf", "99999999999999999999", "--seed", "٣"] {
            assert_eq!(parse(wrong), Err("must be a whole number from 1 to 1000".to_owned()), "{wrong}");
        }
        assert_eq!(whole((0, u32::MAX))("4294967295"), Ok(u32::MAX));
        assert!(whole((0, u32::MAX))("4294967296").is_err());
    }

    #[test]
    fn numbers_are_finite_and_within_their_range() {
        let exposure = number(settings::EXPOSURE);
        assert_eq!((exposure("-100"), exposure("1e2"), exposure("-2.5")), (Ok(-100.0), Ok(100.0), Ok(-2.5)));
        for wrong in ["", "nan", "NaN", "inf", "-inf", "infinity", "1e9", "-100.1", "1e999", "--seed", "2 stops"] {
            assert_eq!(exposure(wrong), Err("must be a number from -100 to 100".to_owned()), "{wrong}");
        }
        let clamp = number(settings::CLAMP);
        for wrong in ["0", "-1", "inf", "1e39", "1e-60", "nan"] {
            assert_eq!(clamp(wrong), Err("must be a finite number above 0".to_owned()), "{wrong}");
        }
        let fps = number(settings::FPS);
        assert_eq!((fps("1000"), fps("1e-3")), (Ok(1000.0), Ok(1e-3)));
        assert_eq!(fps("1001"), Err("must be a number above 0 and at most 1000".to_owned()));
    }

    #[test]
    fn seconds_end() {
        assert_eq!((seconds("0.5"), seconds("86400")), (Ok(0.5), Ok(86_400.0)));
        for wrong in ["0", "-1", "nan", "inf", "1e9", "soon"] {
            assert!(seconds(wrong).is_err_and(|words| words.contains("above 0, at most 86400")), "{wrong}");
        }
    }

    #[test]
    fn sizes_are_two_sides() {
        assert_eq!((size("1280x720"), size("1×16384"), size(" 3 X 4 ")), (Ok([1280, 720]), Ok([1, 16384]), Ok([3, 4])));
        for wrong in ["0x1", "1x16385", "99999999999x1", "1x99999999999999999999999999", "-5x10", "5x-10"] {
            assert_eq!(size(wrong), Err("each side must be from 1 to 16384".to_owned()), "{wrong}");
        }
        for wrong in ["", "10", "x", "10x", "axb", "1.5x2", "nanxnan", "1x2x3", "--samples"] {
            assert!(size(wrong).is_err_and(|words| words.contains("WIDTHxHEIGHT")), "{wrong}");
        }
    }
}
