//! Smooth curves through points: centripetal Catmull-Rom splines (Barry and Goldman 1988; Yuksel et al. 2011) as Bézier curves.
//! They have no cusps and no loops between neighbours.
//!
//! The spacing of parameters is the square root of the distance between points. At a corner the spline ends and starts again,
//! as at the ends of an open line; there its neighbour is mirrored.

use super::arcs::Cubic;

/// Point of a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplinePoint {
    /// Position, metres.
    pub at: [f32; 2],
    /// True if the curve has a corner there.
    pub is_corner: bool,
}

/// Smooth curve through points without corners.
pub fn smooth(points: &[[f32; 2]], closed: bool) -> Vec<Cubic> {
    let points: Vec<SplinePoint> = points.iter().map(|&at| SplinePoint { at, is_corner: false }).collect();
    through(&points, closed)
}

/// Curve through points; it returns to the first one if it is closed. Repeated points count once.
pub fn through(points: &[SplinePoint], closed: bool) -> Vec<Cubic> {
    let mut distinct: Vec<SplinePoint> = Vec::with_capacity(points.len());
    for point in points {
        match distinct.last_mut() {
            Some(last) if last.at == point.at => last.is_corner |= point.is_corner,
            _ => distinct.push(*point),
        }
    }
    while closed && distinct.len() > 1 && distinct[0].at == distinct[distinct.len() - 1].at {
        let last = distinct.pop();
        distinct[0].is_corner |= last.is_some_and(|last| last.is_corner);
    }
    let count = distinct.len();
    if count < 2 {
        return Vec::new();
    }
    let curves = if closed { count } else { count - 1 };
    (0..curves)
        .map(|k| {
            let (a, b) = (distinct[k], distinct[(k + 1) % count]);
            let before = (!a.is_corner && (closed || k > 0)).then(|| distinct[(k + count - 1) % count].at);
            let after = (!b.is_corner && (closed || k + 2 < count)).then(|| distinct[(k + 2) % count].at);
            between(before, a.at, b.at, after)
        })
        .collect()
}

/// The part of a spline between two points. Where a neighbour is missing, the curve leaves towards the control point of the
/// other end.
fn between(before: Option<[f32; 2]>, a: [f32; 2], b: [f32; 2], after: Option<[f32; 2]>) -> Cubic {
    if before.is_none() && after.is_none() {
        return Cubic::line(a, b);
    }
    let control = |before: [f32; 2], a: [f32; 2], b: [f32; 2]| {
        let (d1, d2) = (spacing(before, a), spacing(a, b));
        // The tangent of the spline at `a`, times a third of the parameter interval.
        [0, 1].map(|k| {
            let slope = (a[k] - before[k]) / d1 - (b[k] - before[k]) / (d1 + d2) + (b[k] - a[k]) / d2;
            a[k] + slope * d2 / 3.0
        })
    };
    let first = before.map(|before| control(before, a, b));
    let last = after.map(|after| control(after, b, a));
    // Halfway towards the other control point, as in a parabola.
    let toward = |end: [f32; 2], control: [f32; 2]| [0, 1].map(|k| end[k] + 0.5 * (control[k] - end[k]));
    let first = first.or_else(|| last.map(|last| toward(a, last))).unwrap_or(a);
    let last = last.unwrap_or_else(|| toward(b, first));
    Cubic([a, first, last, b])
}

/// Parameter interval between two points.
fn spacing([ax, ay]: [f32; 2], [bx, by]: [f32; 2]) -> f32 {
    (ax - bx).hypot(ay - by).sqrt().max(1e-12)
}
