//! Box by its edge lengths. Outside, the length of what sticks out along each axis; inside, the nearest face
//! (Quilez 2008, "Distance functions", box). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::{Emitter, ShapeDef};
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("box", "Box centred at the origin, its edges along the axes.", "Quilez 2008, box").size_params(3);
    const PARAMS: &'static [Param] = &[
        Param::length("x", 1.0, "Edge length along x."),
        Param::length("y", 1.0, "Edge length along y."),
        Param::length("z", 1.0, "Edge length along z."),
    ];
    type Params<N: Real> = [N; 3];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [x, y, z]: [N; 3]) -> N {
        let excess = p.abs() - Vec3::new(x, y, z) * N::constant(0.5);
        let outside = excess.max(N::zero()).length();
        let inside = excess.largest().min(N::zero());
        outside + inside
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [x, y, z]: [N; 3]) -> N {
        (p.abs() - Vec3::new(x, y, z) * N::constant(0.5)).largest()
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [x, y, z]: [N; 3]) -> RayInterval<N> {
        let half = N::constant(0.5);
        let slab = |o: N, d: N, size: N| RayInterval::slab(o, d, size * half);
        slab(origin.x, direction.x, x).intersection(slab(origin.y, direction.y, y)).intersection(slab(origin.z, direction.z, z))
    }
    fn emitter([x, y, z]: [f32; 3]) -> Emitter {
        Emitter::Box([x, y, z])
    }
    fn area([x, y, z]: [f32; 3]) -> Option<f32> {
        Some(2.0 * (x * y + y * z + z * x))
    }
    fn bounds([x, y, z]: [f32; 3]) -> Aabb {
        Aabb::centred(0.5 * x, 0.5 * y, 0.5 * z)
    }
}
