//! Colours of a text, and how to write one.

use super::OpenText;
use crate::document::numbers;
use std::ops::Range;

/// A colour that is written in a text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextColour {
    /// Bytes of its numbers, or of its string.
    pub range: Range<usize>,
    /// Linear Rec. 709; radiance may be above 1.
    pub value: [f32; 3],
}

impl OpenText {
    /// Colours that are written as numbers or as "#rrggbb", in the order of the text.
    pub fn colours(&self) -> Vec<TextColour> {
        let inside = self.values.colours.iter().filter(|colour| colour.span.end as usize <= self.text.len());
        let colour = |colour: &crate::language::WrittenColour| TextColour {
            range: colour.span.start as usize..colour.span.end as usize,
            value: colour.value,
        };
        let mut colours: Vec<TextColour> = inside.map(colour).collect();
        colours.sort_by_key(|colour| colour.range.start);
        colours.dedup_by_key(|colour| colour.range.start);
        colours
    }
}

/// The colour as a screen shows it, encoded as sRGB from 0 to 1, and the factor that brings its largest channel to 1 if it
/// is above.
pub fn display_colour(value: [f32; 3]) -> ([f32; 3], f32) {
    let scale = value.into_iter().fold(1.0_f32, f32::max);
    (value.map(|channel| encoded(channel / scale)), scale)
}

/// Ways to write a displayed colour times a factor: three linear numbers, one for a grey, and "#rrggbb" without a factor.
pub fn written_colours(displayed: [f32; 3], scale: f32) -> Vec<String> {
    let linear = displayed.map(|channel| round(decoded(channel) * scale));
    let [r, g, b] = linear;
    let numbers = if r == g && g == b { numbers(&[r]) } else { numbers(&linear) };
    let mut ways = vec![numbers];
    if scale == 1.0 {
        let [r, g, b] = displayed.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8);
        ways.push(format!("\"#{r:02x}{g:02x}{b:02x}\""));
    }
    ways
}

/// sRGB of a linear value (IEC 61966-2-1).
fn encoded(linear: f32) -> f32 {
    match linear {
        ..=0.0 => 0.0,
        ..=0.003_130_8 => 12.92 * linear,
        // Not rounded to a little less.
        1.0.. => 1.0,
        _ => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    }
}

fn decoded(encoded: f32) -> f32 {
    let encoded = encoded.clamp(0.0, 1.0);
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Rounded to three significant digits: finer than 8-bit colours differ.
fn round(value: f32) -> f32 {
    if value < 1e-4 {
        return 0.0;
    }
    format!("{value:.2e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three numbers, or one for a grey.
    fn expected(value: [f32; 3]) -> String {
        if value.iter().all(|channel| *channel == value[0]) { numbers(&value[..1]) } else { numbers(&value) }
    }

    #[test]
    fn colours_come_back_as_they_were() {
        for value in [[0.5, 0.25, 0.1], [1.0, 1.0, 1.0], [15.0, 13.6, 11.6], [0.0, 0.0, 0.0], [0.8; 3]] {
            let (displayed, scale) = display_colour(value);
            assert!(displayed.iter().all(|channel| (0.0..=1.0).contains(channel)), "{displayed:?}");
            assert_eq!(written_colours(displayed, scale)[0], expected(value), "{value:?}");
        }
        assert_eq!(written_colours([1.0, 0.5, 0.0], 1.0), ["1 0.214 0", "\"#ff8000\""]);
        assert_eq!(written_colours([0.5; 3], 1.0), ["0.214", "\"#808080\""]);
    }
}
