//! Paths in the notation of SVG (SVG 2, chapter 9) as Bézier curves. SVG's y points down, that of scenes up.

use pathmarch_field::outline::Cubic;
use svgtypes::{SimplePathSegment, SimplifyingPathParser};

/// A heart, for a path that has just been added.
pub(crate) const DEFAULT_PATH: &str =
    "M 0 0.5 C -0.8 0 -0.6 -0.5 -0.3 -0.5 Q -0.05 -0.5 0 -0.25 Q 0.05 -0.5 0.3 -0.5 C 0.6 -0.5 0.8 0 0 0.5 Z";

/// The curves of a path; each part of it returns to its start if it is filled. An error is a description.
pub(crate) fn curves(text: &str, filled: bool) -> Result<Vec<Cubic>, String> {
    let mut curves = Vec::new();
    let (mut start, mut at) = ([0.0; 2], [0.0; 2]);
    let close = |at: [f32; 2], start: [f32; 2], curves: &mut Vec<Cubic>| {
        if at != start {
            curves.push(Cubic::line(at, start));
        }
    };
    let point = |x: f64, y: f64| [x as f32, -y as f32];
    for segment in SimplifyingPathParser::from(text) {
        match segment.map_err(|error| error.to_string())? {
            SimplePathSegment::MoveTo { x, y } => {
                if filled {
                    close(at, start, &mut curves);
                }
                (start, at) = (point(x, y), point(x, y));
            }
            SimplePathSegment::LineTo { x, y } => {
                let to = point(x, y);
                if to != at {
                    curves.push(Cubic::line(at, to));
                }
                at = to;
            }
            SimplePathSegment::CurveTo { x1, y1, x2, y2, x, y } => {
                curves.push(Cubic([at, point(x1, y1), point(x2, y2), point(x, y)]));
                at = point(x, y);
            }
            SimplePathSegment::Quadratic { x1, y1, x, y } => {
                let (control, to) = (point(x1, y1), point(x, y));
                let toward = |end: [f32; 2]| [0, 1].map(|k| end[k] + 2.0 / 3.0 * (control[k] - end[k]));
                curves.push(Cubic([at, toward(at), toward(to), to]));
                at = to;
            }
            SimplePathSegment::ClosePath => {
                close(at, start, &mut curves);
                at = start;
            }
        }
    }
    if filled {
        close(at, start, &mut curves);
    }
    if curves.is_empty() { Err("it draws nothing".to_owned()) } else { Ok(curves) }
}
