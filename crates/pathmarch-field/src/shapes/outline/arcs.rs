//! Curves as circular arcs: a Bézier curve becomes pairs of arcs that share a tangent (biarcs; Bolton 1975), and the distance
//! to an arc is exact.
//!
//! Idea: an outline of chords has a facet for each chord, and its exact distance to curves is a polynomial of degree five. Arcs
//! have both: tangents without jumps, and a distance in closed form. An arc is stored as its chord and its signed curvature, so
//! that a straight piece is one of curvature 0 and needs no case of its own. Beside an arc with curvature k, unit normal n at its
//! start and offset w from there, the distance is g / (1 + √(1 + k g)) with g = k w·w + 2 n·w: that of the circle, without the
//! loss of digits of |w + n/k| − 1/k.

use crate::number::Real;

type Point = [f64; 2];

/// Numbers of a segment in the values of a shape: its ends, and its curvature, 1/m, positive where it turns left.
pub const NUMBERS: usize = 5;
/// Largest distance of arcs from their chords and from the curve, as fractions of the size of the outline.
const CHORD_TOLERANCE: f64 = 1e-3;
const CURVE_TOLERANCE: f64 = 2e-6;
/// Largest number of biarcs of a Bézier curve.
const MAX_BIARCS: f64 = 64.0;
/// Overlap of arcs that share a tangent, as a fraction of their chord.
const OVERLAP: f32 = 1e-3;

/// Cubic Bézier curve: its ends and, between them, its two control points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic(pub [[f32; 2]; 4]);

impl Cubic {
    /// Straight line.
    pub fn line(from: [f32; 2], to: [f32; 2]) -> Self {
        let part = |t: f32| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
        Self([from, part(1.0 / 3.0), part(2.0 / 3.0), to])
    }
    fn points(&self) -> [Point; 4] {
        self.0.map(|point| point.map(f64::from))
    }
    fn is_straight(&self) -> bool {
        let [a, b, c, d] = self.points();
        let along = minus(d, a);
        let length = dot(along, along).sqrt();
        [b, c].iter().all(|p| {
            let offset = minus(*p, a);
            let part = dot(offset, along);
            cross(along, offset).abs() <= 1e-7 * length * length && part >= 0.0 && part <= length * length
        })
    }
}

fn minus([ax, ay]: Point, [bx, by]: Point) -> Point {
    [ax - bx, ay - by]
}

fn dot([ax, ay]: Point, [bx, by]: Point) -> f64 {
    ax * bx + ay * by
}

fn cross([ax, ay]: Point, [bx, by]: Point) -> f64 {
    ax * by - ay * bx
}

fn unit(v: Point) -> Option<Point> {
    let length = dot(v, v).sqrt();
    (length > 0.0).then(|| [v[0] / length, v[1] / length])
}

fn at([a, b, c, d]: [Point; 4], t: f64) -> Point {
    let s = 1.0 - t;
    [0, 1].map(|k| s * s * s * a[k] + 3.0 * s * t * (s * b[k] + t * c[k]) + t * t * t * d[k])
}

/// Direction of a curve; where it stops, that towards the rest of it.
fn direction([a, b, c, d]: [Point; 4], t: f64) -> Point {
    let s = 1.0 - t;
    let slope = [0, 1].map(|k| s * s * (b[k] - a[k]) + 2.0 * s * t * (c[k] - b[k]) + t * t * (d[k] - c[k]));
    let scale = [b, c, d].iter().map(|p| dot(minus(*p, a), minus(*p, a))).fold(0.0, f64::max).sqrt();
    if dot(slope, slope).sqrt() > 1e-9 * scale {
        return unit(slope).unwrap_or([1.0, 0.0]);
    }
    let near = if t < 0.5 {
        minus(at([a, b, c, d], t + 1e-3), at([a, b, c, d], t))
    } else {
        minus(at([a, b, c, d], t), at([a, b, c, d], t - 1e-3))
    };
    unit(near).unwrap_or([1.0, 0.0])
}

/// Arcs of these curves, [`NUMBERS`] numbers each. Curves without a length have none.
pub fn arcs(curves: &[Cubic]) -> Vec<f32> {
    let all = || curves.iter().flat_map(Cubic::points);
    let extent = [0, 1].map(|k| {
        let range = all().map(|p| p[k]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        range.1 - range.0
    });
    let size = extent[0].hypot(extent[1]);
    let mut numbers = Vec::new();
    for curve in curves {
        let points = curve.points();
        if points.iter().all(|p| *p == points[0]) {
            continue;
        }
        if curve.is_straight() {
            push(points[0], points[3], 0.0, &mut numbers);
            continue;
        }
        let mut count: f64 = 2.0;
        while count < MAX_BIARCS && !fits(points, count as u32, size) {
            count *= 2.0;
        }
        biarcs(points, count as u32, |from, to, curvature| push(from, to, curvature, &mut numbers));
    }
    numbers
}

fn push(from: Point, to: Point, curvature: f64, numbers: &mut Vec<f32>) {
    let [a, b] = [from, to].map(|p| p.map(|v| v as f32));
    if a != b {
        numbers.extend([a[0], a[1], b[0], b[1], curvature as f32]);
    }
}

/// Reports whether so many biarcs are near enough to the curve and to their chords.
fn fits(points: [Point; 4], count: u32, size: f64) -> bool {
    let mut fits = true;
    let mut arcs = Vec::new();
    biarcs(points, count, |from, to, curvature| arcs.push((from, to, curvature)));
    for (from, to, curvature) in &arcs {
        let chord = minus(*to, *from);
        fits &= curvature.abs() * dot(chord, chord) <= 8.0 * CHORD_TOLERANCE * size;
        fits &= curvature * curvature * dot(chord, chord) <= 0.25;
    }
    // The middles of the parameter intervals' halves lie on neither end of an arc.
    for part in 0..4 * count {
        let p = at(points, (f64::from(part) + 0.5) / f64::from(4 * count));
        let nearest = arcs.iter().map(|arc| to_circle(p, *arc)).fold(f64::INFINITY, f64::min);
        fits &= nearest <= CURVE_TOLERANCE * size;
    }
    fits
}

/// Distance of a point from the circle of an arc, if it is beside its chord.
fn to_circle(p: Point, (from, to, curvature): (Point, Point, f64)) -> f64 {
    let chord = minus(to, from);
    let (length, w) = (dot(chord, chord).sqrt(), minus(p, from));
    let (along, off) = (dot(w, chord) / length, cross(w, chord) / length);
    if along < -1e-3 * length || along > 1.001 * length {
        return f64::INFINITY;
    }
    let sine = 0.5 * curvature * length;
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let g = curvature * (along * along + off * off) + 2.0 * (cosine * off - sine * along);
    (g / (1.0 + (1.0 + curvature * g).max(0.0).sqrt())).abs()
}

/// The arcs of a curve that is divided into `count` biarcs at even parameters.
fn biarcs(points: [Point; 4], count: u32, mut arc: impl FnMut(Point, Point, f64)) {
    let part = |k: u32| f64::from(k) / f64::from(count);
    for k in 0..count {
        let [from, to] = [k, k + 1].map(|k| at(points, part(k)));
        let [start, end] = [k, k + 1].map(|k| direction(points, part(k)));
        biarc(from, start, to, end, &mut arc);
    }
}

/// Two arcs between points with these directions, whose tangents at both have one length.
fn biarc(from: Point, start: Point, to: Point, end: Point, arc: &mut impl FnMut(Point, Point, f64)) {
    let v = minus(to, from);
    let t = [start[0] + end[0], start[1] + end[1]];
    let (vt, vv) = (dot(v, t), dot(v, v));
    if vv == 0.0 {
        return;
    }
    let denominator = 2.0 * (1.0 - dot(start, end));
    // The larger coefficient first, so that parallel directions divide by no zero.
    let root = (vt * vt + denominator * vv).max(0.0).sqrt();
    let length = if vt + root > 0.0 { vv / (vt + root) } else { 0.5 * vv.sqrt() };
    let joint = [0, 1].map(|k| 0.5 * (from[k] + to[k] + length * (start[k] - end[k])));
    // An arc from p along t to q turns by twice the angle between t and its chord.
    let first = minus(joint, from);
    let last = minus(to, joint);
    arc(from, joint, 2.0 * cross(start, first) / dot(first, first).max(1e-300));
    arc(joint, to, 2.0 * cross(last, end) / dot(last, last).max(1e-300));
}

/// Unsigned and signed distance to an arc, whose chord starts at the origin and has the direction +x: `along` it and `off`
/// it to the right, which is outside. `curvature` is positive where it bulges outwards. `signs` are those of its ends,
/// 0 where the next arc has the same tangent.
#[inline(always)]
pub(super) fn distance<N: Real>(along: N, off: N, length: N, curvature: N, signs: [N; 2]) -> [N; 2] {
    let (zero, one, two) = (N::zero(), N::one(), N::constant(2.0));
    let sine = (curvature * length * N::constant(0.5)).named("sine");
    let cosine = (one - sine * sine).max(zero).sqrt().named("cosine");
    let g = (curvature * (along * along + off * off) + two * (cosine * off - sine * along)).named("g");
    let beside = (g / (one + (one + curvature * g).max(N::constant(1e-12)).sqrt())).named("beside");
    let rest = (along - length).named("rest");
    let overlap = |sign: N| (one - sign.abs()) * length * N::constant(OVERLAP);
    let past_start = N::zero() - (along * cosine + off * sine) - overlap(signs[0]);
    let past_end = rest * cosine - off * sine - overlap(signs[1]);
    let is_past = zero.lt(past_start.max(past_end));
    let is_end = (length * N::constant(0.5)).lt(along);
    let sign = N::select(is_end, signs[1], signs[0]);
    let side = N::select(beside.lt(zero), N::constant(-1.0), one);
    let sign = N::select(sign.abs().lt(N::constant(0.5)), side, sign).named("sign");
    let corner = N::select(is_end, rest, along).hypot(off).named("corner");
    [N::select(is_past, corner, beside.abs()).named("here"), N::select(is_past, sign * corner, beside)]
}
