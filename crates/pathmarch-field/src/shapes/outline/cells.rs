//! Table of an outline: cells, each with the segments that can be nearest to one of its points.
//!
//! A cell leaves out a segment if another is nearer everywhere in it: the cell's least distance from the one is above its largest
//! distance from the other, which is that of a corner, because the distance to a segment is convex. Cells are found by
//! bisection, so that each half only tests the segments left by its parent.
//!
//! The table consists of vectors of four numbers. Header, three vectors: bounds of the outline; lower left corner of the cells
//! and cells per metre; columns and rows, and the upper right corner. Then one vector for each cell: start and length of its
//! list. Then the lists, two vectors for each segment: start and direction; length and the signs of its ends.
//!
//! Arcs are nowhere farther from their chords than their sagitta, by which both bounds are widened. Their table has a fourth vector
//! in its header: whether it is filled, and else half the width of its line. The length of a chord is followed by the curvature.

use super::clean::Piece;

/// Vectors of the header.
pub(super) const HEADER: usize = 3;
/// Vectors of the header of a table of arcs.
pub(super) const HEADER_OF_ARCS: usize = 4;
/// Vectors of a segment.
pub(super) const PER_SEGMENT: usize = 2;
/// Largest number of cells.
const MAX_CELLS: f64 = 65_536.0;
/// Largest number of cells along an axis.
const MAX_CELLS_ACROSS: f64 = 2_048.0;
/// Margin of the cells around the outline, as a fraction of its smaller side, and least margin, as one of its larger side.
const MARGIN: [f64; 2] = [0.25, 0.002];

type Point = [f64; 2];

struct Cells<'p> {
    pieces: &'p [Piece],
    low: Point,
    cell: Point,
    columns: usize,
    lists: Vec<Vec<u32>>,
}

/// Contents of the pieces of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Drawing {
    /// Straight edges of a filled outline.
    Polygon,
    /// Arcs around a filled outline.
    Curve,
    /// Arcs in the middle of a line of this width, metres.
    Stroke(f64),
}

/// Builds the table of an outline.
pub(super) fn table(pieces: &[Piece], drawing: Drawing) -> Vec<f32> {
    // An empty outline is a point without an inside.
    let nothing = [Piece { from: [0.0; 2], to: [0.0; 2], signs: [1.0; 2], curvature: 0.0 }];
    let pieces = if pieces.is_empty() { &nothing } else { pieces };
    let half = if let Drawing::Stroke(width) = drawing { 0.5 * width } else { 0.0 };
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for piece in pieces {
        let extremes = (0..4).filter_map(|side| extreme(piece, side));
        for point in [piece.from, piece.to].into_iter().chain(extremes) {
            for k in 0..2 {
                (min[k], max[k]) = (min[k].min(point[k] - half), max[k].max(point[k] + half));
            }
        }
    }
    let sides = [max[0] - min[0], max[1] - min[1]];
    let margin = (MARGIN[0] * sides[0].min(sides[1])).max(MARGIN[1] * sides[0].max(sides[1])).max(1e-6);
    // Rounded to f32, as the distance reads them.
    let low = min.map(|v| (v - margin) as f32);
    let high = max.map(|v| (v + margin) as f32);
    let sides = [0, 1].map(|k| f64::from(high[k]) - f64::from(low[k]));
    let wanted = (2.0 * pieces.len() as f64).clamp(64.0, MAX_CELLS);
    let cell = (sides[0] * sides[1] / wanted).sqrt();
    let counts = sides.map(|side| (side / cell).ceil().clamp(1.0, MAX_CELLS_ACROSS));
    let rates = [0, 1].map(|k| (counts[k] / sides[k]) as f32);
    let (columns, rows) = (counts[0] as usize, counts[1] as usize);
    let mut cells = Cells {
        pieces,
        low: low.map(f64::from),
        cell: [0, 1].map(|k| sides[k] / counts[k]),
        columns,
        lists: vec![Vec::new(); columns * rows],
    };
    let all: Vec<u32> = (0..pieces.len() as u32).collect();
    cells.divide([0, 0], [columns, rows], &all);
    let float = |v: f64| v as f32;
    let mut table = vec![
        float(min[0]),
        float(min[1]),
        float(max[0]),
        float(max[1]),
        low[0],
        low[1],
        rates[0],
        rates[1],
        columns as f32,
        rows as f32,
        high[0],
        high[1],
    ];
    if drawing != Drawing::Polygon {
        let filled = if matches!(drawing, Drawing::Curve) { 1.0 } else { 0.0 };
        table.extend([filled, float(half), 0.0, 0.0]);
    }
    let mut start = table.len() / 4 + cells.lists.len();
    for list in &cells.lists {
        table.extend([start as f32, list.len() as f32, 0.0, 0.0]);
        start += PER_SEGMENT * list.len();
    }
    for Piece { from, to, signs, curvature } in cells.lists.iter().flatten().map(|&index| pieces[index as usize]) {
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let length = x.hypot(y);
        let unit = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        table.extend([from[0], from[1], unit[0], unit[1], length].map(float));
        match drawing {
            Drawing::Polygon => table.extend([signs[0], signs[1], 0.0]),
            Drawing::Curve | Drawing::Stroke(_) => table.extend([float(curvature), signs[0], signs[1]]),
        }
    }
    table
}

impl Cells<'_> {
    /// Fills the cells from `first` on, `count` along each axis, with the `candidates` that can be nearest there.
    fn divide(&mut self, first: [usize; 2], count: [usize; 2], candidates: &[u32]) {
        // Wider by a fraction of a cell, for points that rounding puts into a neighbour.
        let slack = self.cell.map(|side| 1e-3 * side);
        let low: Point = std::array::from_fn(|k| self.low[k] + self.cell[k] * first[k] as f64 - slack[k]);
        let high: Point = std::array::from_fn(|k| self.low[k] + self.cell[k] * (first[k] + count[k]) as f64 + slack[k]);
        let piece = |index: &u32| &self.pieces[*index as usize];
        let corners = [low, [high[0], low[1]], [low[0], high[1]], high];
        let farthest = |piece: &Piece| {
            widened(corners.iter().map(|corner| squared_distance(*corner, piece)).fold(0.0, f64::max), sagitta(piece))
        };
        let bound = candidates.iter().map(|index| farthest(piece(index))).fold(f64::INFINITY, f64::min);
        let can_be_nearest =
            |index: &&u32| widened(squared_from_box(piece(index), low, high), -sagitta(piece(index))) <= bound;
        let left: Vec<u32> = candidates.iter().filter(can_be_nearest).copied().collect();
        let axis = usize::from(count[1] > count[0]);
        if count[axis] == 1 {
            self.lists[first[1] * self.columns + first[0]] = left;
            return;
        }
        let half = count[axis] / 2;
        let (mut counts, mut rest, mut beyond) = (count, count, first);
        (counts[axis], rest[axis], beyond[axis]) = (half, count[axis] - half, first[axis] + half);
        self.divide(first, counts, &left);
        self.divide(beyond, rest, &left);
    }
}

/// Largest distance between an arc and its chord: s = L/2 tan(θ/4), with a margin.
fn sagitta(Piece { from, to, curvature, .. }: &Piece) -> f64 {
    if *curvature == 0.0 {
        return 0.0;
    }
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    1.001 * 0.5 * length * (0.5 * (0.5 * curvature.abs() * length).min(1.0).asin()).tan()
}

/// The square of a distance that grows by `by`.
fn widened(square: f64, by: f64) -> f64 {
    if by == 0.0 { square } else { (square.sqrt() + by).max(0.0).powi(2) }
}

/// Point of an arc that is farthest in direction +x, +y, -x or -y, if it is between its ends.
fn extreme(Piece { from, to, curvature, .. }: &Piece, side: usize) -> Option<Point> {
    if *curvature == 0.0 {
        return None;
    }
    let chord = [to[0] - from[0], to[1] - from[1]];
    let length = chord[0].hypot(chord[1]);
    let along = chord.map(|v| v / length);
    let cosine = (1.0 - (0.5 * curvature * length).powi(2)).max(0.0).sqrt();
    // The centre is to the left of arcs that turn left.
    let height = cosine / curvature;
    let centre = [0.5 * (from[0] + to[0]) - along[1] * height, 0.5 * (from[1] + to[1]) + along[0] * height];
    let way = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][side];
    let point = [0, 1].map(|k| centre[k] + way[k] / curvature.abs());
    // On the arc's side of its chord.
    let off = (point[0] - from[0]) * chord[1] - (point[1] - from[1]) * chord[0];
    (off * curvature > 0.0).then_some(point)
}

/// Squared distance of a point from a segment.
fn squared_distance(p: Point, Piece { from, to, .. }: &Piece) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let offset = [p[0] - from[0], p[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let t = if square > 0.0 { ((offset[0] * along[0] + offset[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (offset[0] - t * along[0]).powi(2) + (offset[1] - t * along[1]).powi(2)
}

/// Squared least distance between a segment and a box: that of an end and the box, of a corner and the segment, or zero.
fn squared_from_box(piece: &Piece, low: Point, high: Point) -> f64 {
    let to_box = |p: Point| {
        let [x, y] = [0, 1].map(|k| (low[k] - p[k]).max(p[k] - high[k]).max(0.0));
        x * x + y * y
    };
    let ends = to_box(piece.from).min(to_box(piece.to));
    let along = [piece.to[0] - piece.from[0], piece.to[1] - piece.from[1]];
    let corners = [low, [high[0], low[1]], [low[0], high[1]], high];
    let sides = corners.map(|c| along[0] * (c[1] - piece.from[1]) - along[1] * (c[0] - piece.from[0]));
    let overlaps =
        (0..2).all(|k| piece.from[k].min(piece.to[k]) <= high[k] && piece.from[k].max(piece.to[k]) >= low[k]);
    let crosses = overlaps && sides.iter().any(|s| *s <= 0.0) && sides.iter().any(|s| *s >= 0.0);
    if ends == 0.0 || crosses {
        return 0.0;
    }
    corners.iter().map(|corner| squared_distance(*corner, piece)).fold(ends, f64::min)
}
