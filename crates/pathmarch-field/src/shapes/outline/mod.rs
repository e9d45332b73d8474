//! Drawn shapes: profiles whose outline has any number of segments.
//!
//! Idea: the exact distance to an outline is that to its nearest segment. Its sign is the side of that segment or, at a corner,
//! given by the direction of the corner (Quilez 2008, "2D distance functions", polygon; the sign by the nearest
//! feature: Bærentzen and Aanæs 2005). A text has too many segments to test all, so a grid of cells covers the outline,
//! each with a list of the segments that can be nearest to one of its points (as Frisken et al. 2000 divide space). An
//! evaluation reads one list: a few segments near the edge, some tens in the middle of round holes, for a hundred segments or
//! ten thousand. Beyond the cells the distance is a lower bound: points in a box are at least √(d² + e²) away, with d the
//! distance to the box and e that from there (the projection onto a convex set; Boyd and Vandenberghe 2004, section 8.1).
//!
//! Curves are arcs that share their tangents (`arcs`), with a function and a table of their own, which have the curvature
//! of each piece.
//!
//! `clean` removes crossings and overlaps: every segment then has the inside on its left and the outside on its right. `cells`
//! makes the table. It is behind all other parameters of the field, so that neither moving nor adding a point changes the
//! printed code. Cost: about 800 bytes for each segment, and 15 ms to build the table of 1,000 segments, about ten letters; both
//! are measured in `tests/outline.rs`.

mod arcs;
mod cells;
mod clean;
pub(super) mod curve;
pub(super) mod path;
pub(super) mod polygon;
mod spline;
pub(super) mod text;

use super::dispatch::{EvalShape, Shape};
use crate::bounds::Aabb;
use crate::expression::{Expr, Function};
use crate::info::Info;
use crate::number::{Differentiable, Dual, Real, Vec3};
use crate::parameter::Param;
use crate::ray_interval::T_MAX;
pub use arcs::{Cubic, NUMBERS as NUMBERS_OF_ARC, arcs};
use cells::{Drawing, HEADER, HEADER_OF_ARCS, PER_SEGMENT};
pub use clean::MAX_CROSSINGS;
use clean::{curved, straight};
pub use spline::{SplinePoint, smooth, through};

/// Fill rule: the areas of an outline that are inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Areas from which a ray crosses the outline an odd number of times.
    EvenOdd,
    /// Areas with a winding number other than zero: overlaps are inside, holes wind the other way.
    NonZero,
}

/// Largest number of segments of an outline.
pub const MAX_SEGMENTS: usize = 20_000;

/// Segments of a closed contour through these points, four numbers each.
pub fn contour(points: &[[f32; 2]]) -> impl Iterator<Item = f32> {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).flat_map(|([ax, ay], [bx, by])| [*ax, *ay, *bx, *by])
}

/// Reports whether the outline of these segments has an inside; `None` if it crosses itself more than [`MAX_CROSSINGS`] times.
pub fn has_area(segments: &[f32], fill: Fill) -> Option<bool> {
    clean::pieces(straight(segments), fill).map(|pieces| !pieces.is_empty())
}

/// As [`has_area`], of [`arcs`].
pub fn curve_has_area(arcs: &[f32], fill: Fill) -> Option<bool> {
    clean::pieces(curved(arcs), fill).map(|pieces| !pieces.is_empty())
}

/// Drawn shape. Its values are the parameters and behind them the segments, four numbers each, or arcs of [`NUMBERS_OF_ARC`].
pub(crate) struct Drawn {
    pub(crate) info: Info,
    /// No parameter, or the size by which the outline is scaled; for curves, the width of a line, 0 for a filled outline.
    pub(crate) params: &'static [Param],
    pub(crate) fill: Fill,
    /// True if the segments are arcs.
    pub(crate) curved: bool,
    /// Outline used if there are no segments.
    pub(crate) default_outline: &'static [&'static [[f32; 2]]],
}

/// Signed distance to the outline in the table that starts at vector `first`; `curved` if it is a table of arcs.
#[inline(always)]
fn distance<N: Real>(p: Vec3<N>, table: &[f32], first: N, curved: bool) -> N {
    let (zero, one) = (N::zero(), N::one());
    let vector = |index: f32| N::vector(table, first + N::constant(index));
    let [min_x, min_y, max_x, max_y] = vector(0.0);
    let [left, low, rate_x, rate_y] = vector(1.0);
    let [columns, rows, right, high] = vector(2.0);
    let x = p.x.clamp(left, right).named("x");
    let y = p.y.clamp(low, high).named("y");
    let column = ((x - left) * rate_x).floor().clamp(zero, columns - one);
    let row = ((y - low) * rate_y).floor().clamp(zero, rows - one);
    let header = if curved { HEADER_OF_ARCS } else { HEADER };
    let cell = first + N::constant(header as f32) + row * columns + column;
    let [start, count, _, _] = N::vector(table, cell);
    let farthest = N::constant(T_MAX);
    let [least, signed, _] =
        N::iterate(N::constant(MAX_SEGMENTS as f32), MAX_SEGMENTS as u32, [farthest, farthest, zero], |state| {
            let [least, signed, number] = state;
            let at = (first + start + number * N::constant(PER_SEGMENT as f32)).named("at");
            let [[from_x, from_y, along_x, along_y], numbers] = N::vectors(table, at);
            let (x, y) = ((x - from_x).named("x"), (y - from_y).named("y"));
            let along = (x * along_x + y * along_y).named("along");
            let off = (x * along_y - y * along_x).named("off");
            let [here, nearest] = if curved {
                let [length, curvature, sign_at_start, sign_at_end] = numbers;
                arcs::distance(along, off, length, curvature, [sign_at_start, sign_at_end])
            } else {
                let [length, sign_at_start, sign_at_end, _] = numbers;
                to_segment(along, off, length, [sign_at_start, sign_at_end])
            };
            let closer = here.lt(least);
            let signed = N::select(closer, nearest, signed);
            let next = number + one;
            ([N::select(closer, here, least), signed, next], next.lt(count))
        });
    let signed = if curved {
        let [filled, half_width, _, _] = vector(3.0);
        N::select(zero.lt(filled), signed, least - half_width).named("signed")
    } else {
        signed
    };
    let beyond = (p.x - x).hypot(p.y - y).named("beyond");
    let to_box = (min_x - p.x).max(p.x - max_x).max(zero).hypot((min_y - p.y).max(p.y - max_y).max(zero));
    N::select(zero.lt(beyond), beyond.hypot(signed.max(zero)).max(to_box), signed)
}

/// Unsigned and signed distance to a segment that starts at the origin and has the direction +x.
#[inline(always)]
fn to_segment<N: Real>(along: N, off: N, length: N, [sign_at_start, sign_at_end]: [N; 2]) -> [N; 2] {
    let zero = N::zero();
    let past = (along - length).max(-along).named("past");
    // Beside the segment the distance is linear, so that its gradient is correct on the segment, too.
    let is_past = zero.lt(past);
    let sign = N::select(along.lt(zero), sign_at_start, sign_at_end);
    let from_corner = past.hypot(off);
    let here = N::select(is_past, from_corner, off.abs()).named("here");
    [here, N::select(is_past, sign * from_corner, off)]
}

impl Drawn {
    fn function(&self, suffix: &str, doc: String) -> Function<'static> {
        let parameters = vec![("p", "vec3f"), ("first", "f32")];
        Function { name: format!("{}_{suffix}", self.wgsl_name()), doc, parameters }
    }
}

/// Table of a curve: filled, or a line of a width along it.
fn curve_table(width: f32, numbers: &[f32], shape: &Drawn) -> Vec<f32> {
    let default_outline: Vec<f32>;
    let numbers = if numbers.is_empty() {
        default_outline =
            arcs(&shape.default_outline.iter().flat_map(|points| smooth(points, true)).collect::<Vec<_>>());
        &default_outline
    } else {
        numbers
    };
    if width > 0.0 {
        cells::table(&clean::strokes(&curved(numbers)), Drawing::Stroke(f64::from(width)))
    } else {
        cells::table(&clean::cleaned(curved(numbers), shape.fill), Drawing::Curve)
    }
}

impl<N: Differentiable> EvalShape<N> for Drawn {
    fn distance(&self, p: Vec3<N>, table: &[f32]) -> N {
        distance(p, table, N::zero(), self.curved)
    }
    fn gradient(&self, p: Vec3<Dual<N>>, table: &[f32]) -> Dual<N> {
        distance(p, table, Dual::zero(), self.curved)
    }
}

impl Shape for Drawn {
    fn info(&self) -> &Info {
        &self.info
    }
    fn params(&self) -> &[Param] {
        self.params
    }
    /// The table, which includes the size.
    fn coefficients(&self, params: &[f32]) -> Vec<f32> {
        let (params, segments) = params.split_at(self.params.len().min(params.len()));
        if self.curved {
            return curve_table(params.first().copied().unwrap_or_default(), segments, self);
        }
        let default_outline: Vec<f32>;
        let segments = match segments {
            [] => {
                default_outline = self.default_outline.iter().flat_map(|points| contour(points)).collect();
                &default_outline
            }
            segments => segments,
        };
        let size = params.first().copied().unwrap_or(1.0);
        let scaled: Vec<f32> = segments.iter().map(|v| v * size).collect();
        cells::table(&clean::cleaned(straight(&scaled), self.fill), Drawing::Polygon)
    }
    fn reads_table(&self) -> bool {
        true
    }
    fn bounds(&self, table: &[f32]) -> Aabb {
        let end = f32::INFINITY;
        match *table {
            [min_x, min_y, max_x, max_y, ..] => Aabb { min: [min_x, min_y, -end], max: [max_x, max_y, end] },
            _ => Aabb::NOTHING,
        }
    }
    fn lipschitz(&self, _table: &[f32]) -> f32 {
        1.0
    }
    fn wgsl_distance(&self) -> String {
        self.function("distance", "Signed distance to an outline in the table.".to_owned()).print(&|inputs| {
            let p = Vec3::new(inputs[0], inputs[1], inputs[2]);
            vec![distance(p, &[], inputs[3], self.curved)]
        })
    }
    fn wgsl_gradient(&self) -> String {
        self.function("gradient", "Gradient (xyz) and distance (w) of an outline in the table.".to_owned()).print(
            &|inputs| {
                let p = Dual::<Expr>::variables(Vec3::new(inputs[0], inputs[1], inputs[2]));
                let Dual { value, gradient } = distance(p, &[], Dual::independent(inputs[3]), self.curved);
                vec![gradient.x, gradient.y, gradient.z, value]
            },
        )
    }
    /// One name for all drawn shapes with one function, so that a scene has it once.
    fn wgsl_name(&self) -> String {
        if self.curved { "curve" } else { "outline" }.to_owned()
    }
}
