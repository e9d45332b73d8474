//! Removal of crossings from outlines: segments are cut where they meet; pieces with the inside on one side only are kept and
//! turned so that it is on their left.
//!
//! Left and right of the middle of each piece are tested by counting the segments that a ray to +x crosses (Shimrat 1962, with
//! half-open segments; with their directions: Hormann and Agathos 2001). Segments are sorted into rows, and there from left to
//! right, so that a test reads one row. Computed in f64. Cost: linear, apart from the segments of a row.

use super::Fill;
use super::arcs::NUMBERS;
use std::collections::{HashMap, HashSet};

type Point = [f64; 2];

/// Largest number of points at which an outline crosses itself. Each costs a test of its pieces against a row of segments.
pub const MAX_CROSSINGS: usize = 10_000;

/// Piece of an outline with the inside on its left; the sign of each end is 1 if its corner is convex, -1 if it is reflex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) from: Point,
    pub(super) to: Point,
    pub(super) signs: [f32; 2],
    /// Curvature of the arc over it, 1/m, positive where it bulges outwards; 0 for a straight piece.
    pub(super) curvature: f64,
}

/// Directed segment, or an arc over it with a curvature that is positive where it turns left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) ends: [Point; 2],
    pub(super) curvature: f64,
}

/// Straight segments, four numbers each.
pub(super) fn straight(numbers: &[f32]) -> Vec<Segment> {
    numbers.chunks_exact(4).map(|s| Segment { ends: ends(s), curvature: 0.0 }).collect()
}

/// Arcs, [`NUMBERS`] numbers each.
pub(super) fn curved(numbers: &[f32]) -> Vec<Segment> {
    numbers.chunks_exact(NUMBERS).map(|s| Segment { ends: ends(s), curvature: f64::from(s[4]) }).collect()
}

fn ends(numbers: &[f32]) -> [Point; 2] {
    [[f64::from(numbers[0]), f64::from(numbers[1])], [f64::from(numbers[2]), f64::from(numbers[3])]]
}

/// Segments by the rows that they overlap.
struct Rows {
    low: f64,
    height: f64,
    rows: Vec<Vec<u32>>,
}

impl Rows {
    fn new(segments: &[Segment]) -> Self {
        let heights = segments.iter().flat_map(|segment| segment.ends).map(|p| p[1]);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
        let count = (segments.len() / 2).clamp(1, 8192);
        let mut rows = Self { low, height: ((high - low) / count as f64).max(1e-300), rows: vec![Vec::new(); count] };
        for (index, Segment { ends: [a, b], .. }) in segments.iter().enumerate() {
            let (first, last) = (rows.of(a[1].min(b[1])), rows.of(a[1].max(b[1])));
            rows.rows[first..=last].iter_mut().for_each(|row| row.push(index as u32));
        }
        rows
    }
    fn of(&self, y: f64) -> usize {
        (((y - self.low) / self.height).max(0.0) as usize).min(self.rows.len() - 1)
    }
}

fn minus([ax, ay]: Point, [bx, by]: Point) -> Point {
    [ax - bx, ay - by]
}

fn cross([ax, ay]: Point, [bx, by]: Point) -> f64 {
    ax * by - ay * bx
}

fn dot([ax, ay]: Point, [bx, by]: Point) -> f64 {
    ax * bx + ay * by
}

/// Angle by which the tangents of arcs may differ at a point that is no corner, radians.
const SMOOTH: f64 = 2e-3;

/// Pieces of the outline of these segments, without crossings; none of an outline that crosses itself more than
/// [`MAX_CROSSINGS`] times.
pub(super) fn cleaned(segments: Vec<Segment>, fill: Fill) -> Vec<Piece> {
    pieces(segments, fill).unwrap_or_default()
}

/// Pieces of a line along these segments, as they are.
pub(super) fn strokes(segments: &[Segment]) -> Vec<Piece> {
    let reach = segments.iter().flat_map(|segment| segment.ends).flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
    let grain = (reach * 1e-7).max(1e-300);
    with_corners(segments, |[x, y]: Point| ((x / grain).round() as i64, (y / grain).round() as i64))
}

/// As [`cleaned`], but `None` of an outline that crosses itself too often.
pub(super) fn pieces(mut segments: Vec<Segment>, fill: Fill) -> Option<Vec<Piece>> {
    segments.retain(|segment| segment.ends[0] != segment.ends[1]);
    let reach = segments.iter().flat_map(|segment| segment.ends).flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
    // Points closer than this are merged; f32 does not resolve them.
    let grain = reach * 1e-7;
    if segments.is_empty() || !grain.is_finite() || grain <= 0.0 {
        return Some(Vec::new());
    }
    // Sorted by the left end within each row.
    let left_end = |segment: &Segment| segment.ends[0][0].min(segment.ends[1][0]);
    segments.sort_by(|one, other| left_end(one).total_cmp(&left_end(other)));
    let rows = Rows::new(&segments);
    let mut seen = HashSet::new();
    let key = |[x, y]: Point| ((x / grain).round() as i64, (y / grain).round() as i64);
    let mut pieces = Vec::new();
    for (mut points, segment) in cut_points(&segments, &rows, grain)?.into_iter().zip(&segments) {
        let Segment { ends: [a, b], curvature } = segment;
        points.extend([*a, *b]);
        let along = minus(*b, *a);
        points.sort_by(|p, q| dot(minus(*p, *a), along).total_cmp(&dot(minus(*q, *a), along)));
        points.dedup_by_key(|p| key(*p));
        for pair in points.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            // The piece of two overlapping segments counts once.
            let ends = [key(from), key(to)];
            if !seen.insert([ends[0].min(ends[1]), ends[0].max(ends[1])]) {
                continue;
            }
            let [x, y] = minus(to, from);
            let step = grain / x.hypot(y);
            let left = [-y * step, x * step];
            let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
            let is_inside =
                |side: f64| is_inside([middle[0] + side * left[0], middle[1] + side * left[1]], &segments, &rows, fill);
            match (is_inside(1.0), is_inside(-1.0)) {
                (true, false) => pieces.push(Segment { ends: [from, to], curvature: *curvature }),
                (false, true) => pieces.push(Segment { ends: [to, from], curvature: -curvature }),
                _ => {}
            }
        }
    }
    Some(with_corners(&pieces, key))
}

/// Points at which each segment meets others; `None` if there are too many.
fn cut_points(segments: &[Segment], rows: &Rows, grain: f64) -> Option<Vec<Vec<Point>>> {
    let mut cuts = vec![Vec::new(); segments.len()];
    let mut crossings = 0;
    let extent = |k: u32| {
        let [a, b] = segments[k as usize].ends;
        [0, 1].map(|axis| (a[axis].min(b[axis]) - grain, a[axis].max(b[axis]) + grain))
    };
    for (number, row) in rows.rows.iter().enumerate() {
        for (k, &one) in row.iter().enumerate() {
            let reach = extent(one);
            for &other in &row[k + 1..] {
                let there = extent(other);
                if there[0].0 > reach[0].1 {
                    break;
                }
                let apart = reach[1].1 < there[1].0 || there[1].1 < reach[1].0;
                // A pair in several rows is tested in the first of them.
                let first = rows.of((reach[1].0 + grain).max(there[1].0 + grain));
                if apart || first != number {
                    continue;
                }
                let [first, second] = [one, other].map(|index| &segments[index as usize]);
                let ([a, b], [c, d]) = (first.ends, second.ends);
                let (ab, cd) = (minus(b, a), minus(d, c));
                // Ends that lie on the other segment.
                let is_on = |p: Point, from: Point, along: Point| {
                    let square = dot(along, along);
                    let (t, off) = (dot(minus(p, from), along) / square, cross(along, minus(p, from)) / square.sqrt());
                    off.abs() <= grain && (0.0..=1.0).contains(&t)
                };
                let mut touches = false;
                for p in [c, d] {
                    if is_on(p, a, ab) {
                        cuts[one as usize].push(p);
                        touches = true;
                    }
                }
                for p in [a, b] {
                    if is_on(p, c, cd) {
                        cuts[other as usize].push(p);
                        touches = true;
                    }
                }
                let area = cross(ab, cd);
                let (t, u) = (cross(minus(c, a), cd) / area, cross(minus(c, a), ab) / area);
                if !touches && (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
                    crossings += 1;
                    if crossings > MAX_CROSSINGS {
                        return None;
                    }
                    let p = on_both([a[0] + t * ab[0], a[1] + t * ab[1]], first, second);
                    cuts[one as usize].push(p);
                    cuts[other as usize].push(p);
                }
            }
        }
    }
    Some(cuts)
}

/// Crossing of two arcs near that of their chords (Newton's method), or that of their chords if it finds none.
fn on_both(start: Point, one: &Segment, other: &Segment) -> Point {
    if one.curvature == 0.0 && other.curvature == 0.0 {
        return start;
    }
    let sagitta = |segment: &Segment| {
        let chord = minus(segment.ends[1], segment.ends[0]);
        segment.curvature.abs() * dot(chord, chord) / 8.0
    };
    let reach = 4.0 * (sagitta(one) + sagitta(other));
    let mut p = start;
    for _ in 0..8 {
        let ((f, df), (g, dg)) = (to_circle(p, one), to_circle(p, other));
        let area = cross(df, dg);
        let step = [(f * dg[1] - g * df[1]) / area, (g * df[0] - f * dg[0]) / area];
        p = minus(p, step);
        let moved = dot(minus(p, start), minus(p, start)).sqrt();
        // Not a number of circles that touch.
        if moved > reach || moved.is_nan() {
            return start;
        }
    }
    p
}

/// A function that vanishes on the circle of an arc, of slope 1 there, and its gradient.
fn to_circle(p: Point, Segment { ends: [a, b], curvature }: &Segment) -> (f64, Point) {
    let chord = minus(*b, *a);
    let length = dot(chord, chord).sqrt();
    let along = [chord[0] / length, chord[1] / length];
    let sine = 0.5 * curvature * length;
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    // The normal at the start, to the right of the tangent.
    let right = [along[1], -along[0]];
    let normal = [0, 1].map(|k| cosine * right[k] - sine * along[k]);
    let w = minus(p, *a);
    let value = 0.5 * curvature * dot(w, w) + dot(normal, w);
    (value, [0, 1].map(|k| curvature * w[k] + normal[k]))
}

fn is_inside([x, y]: Point, segments: &[Segment], rows: &Rows, fill: Fill) -> bool {
    let (mut crossed, mut around) = (0, 0);
    for &index in &rows.rows[rows.of(y)] {
        let [a, b] = segments[index as usize].ends;
        if (a[1] <= y) == (b[1] <= y) {
            continue;
        }
        // The segment is to the right if the point is on its left as it goes up.
        let side = cross(minus(b, a), minus([x, y], a));
        let up = a[1] <= y;
        if (side > 0.0) == up {
            crossed += 1;
            around += if up { 1 } else { -1 };
        }
    }
    match fill {
        Fill::EvenOdd => crossed % 2 == 1,
        Fill::NonZero => around != 0,
    }
}

/// Adds the signs of corners. Points that are nearest to a corner are in the widest angle between its segments, which is more
/// than half a turn; that angle is outside or inside.
fn with_corners(pieces: &[Segment], key: impl Fn(Point) -> (i64, i64)) -> Vec<Piece> {
    let mut corners: HashMap<(i64, i64), Vec<(f64, bool)>> = HashMap::new();
    let mut is_curved: HashMap<(i64, i64), bool> = HashMap::new();
    for Segment { ends: [from, to], curvature } in pieces {
        let ([x, y], [back_x, back_y]) = (minus(*to, *from), minus(*from, *to));
        // The tangents at the ends of an arc, which turns left by twice this angle.
        let half = (0.5 * curvature * x.hypot(y)).clamp(-1.0, 1.0).asin();
        corners.entry(key(*from)).or_default().push((y.atan2(x) - half, true));
        corners.entry(key(*to)).or_default().push((back_y.atan2(back_x) + half, false));
        for end in [from, to] {
            *is_curved.entry(key(*end)).or_default() |= *curvature != 0.0;
        }
    }
    let signs: HashMap<(i64, i64), f32> = corners
        .into_iter()
        .map(|(corner, mut ways)| {
            if let [(one, starts), (other, also_starts)] = ways[..]
                && is_curved[&corner]
                && starts != also_starts
                && ((one - other).abs() % std::f64::consts::TAU - std::f64::consts::PI).abs() < SMOOTH
            {
                return (corner, 0.0);
            }
            ways.sort_by(|a, b| a.0.total_cmp(&b.0));
            let next = |k: usize| match ways.get(k + 1) {
                Some((angle, _)) => *angle,
                None => ways[0].0 + std::f64::consts::TAU,
            };
            let widest = (0..ways.len()).max_by(|&a, &b| (next(a) - ways[a].0).total_cmp(&(next(b) - ways[b].0)));
            // Counter-clockwise from a segment that starts at the corner is its left: the inside.
            let inside = widest.is_some_and(|k| ways[k].1);
            (corner, if inside { -1.0 } else { 1.0 })
        })
        .collect();
    let sign = |p: Point| signs.get(&key(p)).copied().unwrap_or(1.0);
    let piece = |Segment { ends: [from, to], curvature }: &Segment| Piece {
        from: *from,
        to: *to,
        signs: [sign(*from), sign(*to)],
        curvature: *curvature,
    };
    pieces.iter().map(piece).collect()
}
