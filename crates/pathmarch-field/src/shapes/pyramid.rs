//! Square pyramid on the plane y = 0. Exact (Quilez 2019, "Distance functions", pyramid, gives one for a unit base).
//!
//! The eight symmetries of the square fold space onto the wedge of the face that looks along +x, which is then half of
//! an isosceles triangle. Inside, the solid is convex, so its distance is the larger of the heights over that face and
//! over the base. Outside it is the smaller of the distances to the base's square and to the face's triangle. The
//! latter is measured as for a cone's profile, in the plane of the face; below the face's lower edge it is an
//! overestimate, which does no harm because the square shares that edge and is nearer.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "pyramid",
        "Pyramid on a square in the plane y = 0 centred at the origin, its apex on the y axis.",
        "Quilez 2019, pyramid",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("base", 1.0, "Edge length of the square."),
        Param::length("height", 1.0, "From the base to the apex."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [base, height]: [N; 2]) -> N {
        let zero = N::zero();
        let half = base * N::constant(0.5);
        // The face's height in its own plane, and the edge from a corner of the base to the apex.
        let slant = half.hypot(height).named("slant");
        let edge = half.hypot(slant).named("edge");
        let (x, z) = (p.x.abs(), p.z.abs());
        // Swapped by one mask, not by max and min: those would both take the derivative of x where x = z.
        let swap = x.lt(z);
        // Measured from the middle of the face's lower edge, or for `sideways` from its corner.
        let outwards = (N::select(swap, z, x) - half).named("outwards");
        let sideways = (N::select(swap, x, z) - half).named("sideways");
        let face = ((outwards * height + p.y * half) / slant).named("face");
        let uphill = ((p.y * height - outwards * half) / slant).named("uphill");
        // In the frame of the edge: off it within the face's plane, and along it from the corner.
        let off_edge = (sideways * slant + uphill * half) / edge;
        let along_edge = ((uphill * slant - sideways * half) / edge).named("along_edge");
        let past_edge = (along_edge - edge).max(-along_edge).max(zero);
        let in_plane = Vec3::new(off_edge.max(zero), past_edge, (-uphill).max(zero)).length();
        let from_face = face.hypot(in_plane);
        let from_base = Vec3::new(outwards.max(zero), p.y, sideways.max(zero)).length();
        let inside = face.max(-p.y).named("inside");
        N::select(zero.lt(inside), from_face.min(from_base), inside)
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [base, height]: [N; 2]) -> N {
        let half = base * N::constant(0.5);
        let outwards = p.x.abs().max(p.z.abs()) - half;
        ((outwards * height + p.y * half) / half.hypot(height)).max(-p.y)
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [base, height]: [N; 2]) -> RayInterval<N> {
        let half = base * N::constant(0.5);
        // A face rises from the edge of the base to the apex.
        let face = |o: N, d: N| RayInterval::half_space(o * height + (origin.y - height) * half, d * height + direction.y * half);
        let base = RayInterval::half_space(-origin.y, -direction.y);
        let along_x = face(origin.x, direction.x).intersection(face(-origin.x, -direction.x));
        base.intersection(along_x).intersection(face(origin.z, direction.z).intersection(face(-origin.z, -direction.z)))
    }
    fn bounds([base, height]: [f32; 2]) -> Aabb {
        let half = 0.5 * base;
        Aabb { min: [-half, 0.0, -half], max: [half, height, half] }
    }
}
