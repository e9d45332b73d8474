//! Triangular prism: the exact distance to an equilateral triangle in xy, extruded along z (Quilez 2008, "2D distance
//! functions", equilateral triangle, and "extrusion"). Exact.

use crate::bounds::Aabb;
use crate::number::{Real, Vec3};
use crate::registry::{Info, Param, Primitive};

pub(crate) struct Shape;

const SQRT_3: f32 = 1.732_050_8;

impl Primitive for Shape {
    const INFO: Info = Info::new(
        "prism",
        "Equilateral triangle in xy, a corner up, its centroid at the origin, extruded along z.",
        "Quilez 2008, equilateral triangle and extrusion",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("side", 1.0, "Edge length of the triangle."),
        Param::length("depth", 1.0, "Length along z."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [side, depth]: [N; 2]) -> N {
        let root = N::constant(SQRT_3);
        let half = side * N::constant(0.5);
        // Fold onto the sector of one edge: mirror in x, then across the line to the lower right corner.
        let x = p.x.abs() - half;
        let y = p.y + half / root;
        let beyond = N::zero().lt(x + root * y);
        let folded_x = N::select(beyond, (x - root * y) * N::constant(0.5), x);
        let folded_y = N::select(beyond, (-root * x - y) * N::constant(0.5), y);
        let along = folded_x - folded_x.clamp(-side, N::zero());
        let triangle = (-along.hypot(folded_y) * folded_y.sign()).named("triangle");
        let ends = (p.z.abs() - depth * N::constant(0.5)).named("ends");
        triangle.max(N::zero()).hypot(ends.max(N::zero())) + triangle.max(ends).min(N::zero())
    }
    fn bounds([side, depth]: [f32; 2]) -> Aabb {
        let (half, inner) = (0.5 * side, 0.5 * side / SQRT_3);
        Aabb { min: [-half, -inner, -0.5 * depth], max: [half, 2.0 * inner, 0.5 * depth] }
    }
}
