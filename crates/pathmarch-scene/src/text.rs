//! Outlines of texts: the glyphs of a font side by side, their curves as short segments.
//!
//! A glyph of a TrueType or OpenType font is closed contours of lines and Bézier curves, holes run the other way (OpenType
//! 1.9, chapters "glyf" and "CFF"). A curve of which the second derivative is at most M is nowhere farther than M/8n² from
//! the n chords between evenly spaced parameters (de Boor 1978, chapter 2): n is chosen for a ten-thousandth of the size.
//! Glyphs are set by their advances and the pairs of the font's `kern` table; there are no ligatures, and no scripts that
//! run from right to left or join their letters. Cost: microseconds for each glyph.

use pathmarch_field::outline::{MAX_SEGMENTS, contour};
use ttf_parser::{Face, FaceParsingError, GlyphId, OutlineBuilder};

/// The font of texts that name none: Cantarell Regular.
pub(crate) const DEFAULT_FONT: &[u8] = include_bytes!("../fonts/Cantarell-Regular.ttf");
/// The text where none is given.
pub(crate) const DEFAULT_TEXT: &str = "Text";
/// Largest distance of chords from their curve, as a fraction of the size.
const TOLERANCE: f32 = 1e-4;
/// The most chords of a curve.
const MOST_CHORDS: f32 = 64.0;

/// Error of a text that has no outline.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TextError {
    #[error("this is not a TrueType or OpenType font: {0}")]
    NotAFont(#[from] FaceParsingError),
    #[error("the font has no glyph for `{0}`")]
    NoGlyph(char),
    #[error("no glyph of this text is visible")]
    Empty,
    #[error("its outline has more than {MAX_SEGMENTS} segments")]
    TooLong,
}

impl TextError {
    /// Help: what to do.
    pub(crate) fn help(&self) -> &'static str {
        match self {
            Self::NotAFont(_) => "Choose a .ttf, .otf or .ttc file.",
            Self::NoGlyph(_) => "Choose a font that has it with `font=\"path.ttf\"`, or write something else.",
            Self::Empty => "Write at least one letter that is not blank.",
            Self::TooLong => "Divide it into several texts.",
        }
    }
}

/// Segments of a text, four numbers each, for a size of one metre: lines are centred at x = 0, and the last one has its
/// baseline at y = 0.
pub(crate) fn segments(font: &[u8], text: &str) -> Result<Vec<f32>, TextError> {
    let face = Face::parse(font, 0)?;
    let unit = 1.0 / f32::from(face.units_per_em());
    let line_height = f32::from(face.ascender()) - f32::from(face.descender()) + f32::from(face.line_gap());
    let lines: Vec<&str> = text.lines().collect();
    let mut numbers = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let glyph = |c: char| face.glyph_index(c).ok_or(TextError::NoGlyph(c));
        let glyphs: Vec<GlyphId> = line.chars().map(glyph).collect::<Result<_, _>>()?;
        let mut places = Vec::with_capacity(glyphs.len());
        let mut pen = 0.0;
        for (k, &glyph) in glyphs.iter().enumerate() {
            if let Some(&before) = k.checked_sub(1).and_then(|before| glyphs.get(before)) {
                pen += kerning(&face, before, glyph);
            }
            places.push(pen);
            pen += f32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
        }
        let height = (lines.len() - 1 - index) as f32 * line_height;
        for (glyph, place) in glyphs.into_iter().zip(places) {
            let mut pen = Pen { at: [place - 0.5 * pen, height], unit, points: Vec::new(), numbers: &mut numbers };
            // A glyph without outline is a blank.
            let _ = face.outline_glyph(glyph, &mut pen);
            if numbers.len() / 4 > MAX_SEGMENTS {
                return Err(TextError::TooLong);
            }
        }
    }
    if numbers.is_empty() { Err(TextError::Empty) } else { Ok(numbers) }
}

/// Kerning of two glyphs, units of the font.
fn kerning(face: &Face, left: GlyphId, right: GlyphId) -> f32 {
    let Some(kern) = face.tables().kern else { return 0.0 };
    let usable = kern.subtables.into_iter().filter(|table| table.horizontal && !table.variable);
    f32::from(usable.filter_map(|table| table.glyphs_kerning(left, right)).next().unwrap_or_default())
}

/// Draws the contours of a glyph.
struct Pen<'n> {
    at: [f32; 2],
    unit: f32,
    /// Points of the contour so far.
    points: Vec<[f32; 2]>,
    numbers: &'n mut Vec<f32>,
}

impl Pen<'_> {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        [(self.at[0] + x) * self.unit, (self.at[1] + y) * self.unit]
    }
    /// Chords of a curve whose second derivative is at most `bend`.
    fn chords(&mut self, bend: f32, curve: impl Fn(f32) -> [f32; 2]) {
        let count = (bend / (8.0 * TOLERANCE)).sqrt().ceil().clamp(1.0, MOST_CHORDS) as u32;
        self.points.extend((1..=count).map(|k| curve(k as f32 / count as f32)));
    }
}

/// Length of the second difference of three points.
fn second_difference(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (a[0] - 2.0 * b[0] + c[0]).hypot(a[1] - 2.0 * b[1] + c[1])
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.points = vec![self.place(x, y)];
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.points.push(self.place(x, y));
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let Some(&a) = self.points.last() else { return };
        let (b, c) = (self.place(x1, y1), self.place(x, y));
        self.chords(2.0 * second_difference(a, b, c), |t| {
            let s = 1.0 - t;
            [0, 1].map(|k| s * s * a[k] + 2.0 * s * t * b[k] + t * t * c[k])
        });
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let Some(&a) = self.points.last() else { return };
        let (b, c, d) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.chords(6.0 * second_difference(a, b, c).max(second_difference(b, c, d)), |t| {
            let s = 1.0 - t;
            [0, 1].map(|k| s * s * s * a[k] + 3.0 * s * t * (s * b[k] + t * c[k]) + t * t * t * d[k])
        });
    }
    fn close(&mut self) {
        let points = std::mem::take(&mut self.points);
        if points.len() > 2 {
            self.numbers.extend(contour(&points));
        }
    }
}
