//! Regular octahedron: the points with |x| + |y| + |z| at most `radius`. Exact.
//!
//! Idea: the nearest point of that solid is found by soft thresholding: every coordinate moves towards zero by the same
//! length τ, or stops there; τ is the largest of the three values (sum of the k largest coordinates - radius) / k (Duchi,
//! Shalev-Shwartz, Singer and Chandra 2008, "Efficient projections onto the l1-ball for learning in high dimensions",
//! section 3). So the offset from the nearest point is min(|p|, τ) in each coordinate. Inside, the nearest face is at
//! (radius - |x| - |y| - |z|)/√3. Quilez's 2008 form branches on the nearest face or edge; this one needs no cases.

use crate::bounds::Aabb;
use crate::number::{Real, Vec3};
use crate::registry::{Info, Param, Primitive};

pub(crate) struct Shape;

const INVERSE_SQRT_3: f32 = 0.577_350_26;

impl Primitive for Shape {
    const INFO: Info = Info::new(
        "octahedron",
        "Regular octahedron centred at the origin, its corners on the axes.",
        "Duchi et al. 2008, section 3",
    );
    const PARAMS: &'static [Param] = &[Param::length("radius", 1.0, "From the centre to the corners.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        let q = p.abs();
        let excess = (q.x + q.y + q.z - radius).named("excess");
        let smallest = q.x.min(q.y.min(q.z));
        let onto_corner = q.largest() - radius;
        let onto_edge = (excess - smallest) * N::constant(0.5);
        let onto_face = excess * N::constant(1.0 / 3.0);
        let threshold = onto_corner.max(onto_edge.max(onto_face)).named("threshold");
        let outside = Vec3::new(q.x.min(threshold), q.y.min(threshold), q.z.min(threshold)).length();
        N::select(N::zero().lt(excess), outside, excess * N::constant(INVERSE_SQRT_3))
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, radius, radius)
    }
}
