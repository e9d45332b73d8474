//! Star in the xy plane: the plane is folded onto half the sector of one point, where the outline is a segment (after Quilez
//! 2008, "2D distance functions", star). The mirrors of the star bound that sector, so that the nearest surface point is in it,
//! too. Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("star", "Profile: a star around the origin, a point up.", "after Quilez 2008, star").profile();
    const PARAMS: &'static [Param] = &[
        Param::count("points", 5.0, 2.0, 100.0, "How many points it has."),
        Param::length("outer", 0.5, "From the origin to the points."),
        Param::length("inner", 0.25, "From the origin to the corners between them."),
    ];
    type Params<N: Real> = [N; 3];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [points, outer, inner]: [N; 3]) -> N {
        let (zero, half) = (N::zero(), N::constant(0.5));
        let sector = (N::constant(PI) / points).named("sector");
        // The point of the star that is nearest, turned upwards; the turn is constant around p.
        let turn = ((p.x.atan2(p.y) * half / sector + half).floor() * sector * N::constant(2.0)).named("turn");
        let (sine, cosine) = (turn.sin().named("sine"), turn.cos().named("cosine"));
        let x = (p.x * cosine - p.y * sine).abs().named("x");
        let y = (p.x * sine + p.y * cosine).named("y");
        // From the point to the corner beside it.
        let (across, down) = ((sector.sin() * inner).named("across"), (outer - sector.cos() * inner).named("down"));
        let length = across.hypot(down).named("length");
        let (below, along) = (outer - y, ((x * across + (outer - y) * down) / length).named("along"));
        let off = ((x * down - below * across) / length).named("off");
        let past = (along - length).max(-along).max(zero).named("past");
        let inside = off.lt(zero);
        let from = N::select(zero.lt(past), off.hypot(past), off.abs());
        N::select(inside, -from, from)
    }
    fn bounds([points, outer, inner]: [f32; 3]) -> Aabb {
        let mut bounds = Aabb { min: [0.0, 0.0, f32::NEG_INFINITY], max: [0.0, 0.0, f32::INFINITY] };
        for k in 0..2 * points as u32 {
            let (sine, cosine) = (PI / points * k as f32).sin_cos();
            let radius = if k % 2 == 0 { outer } else { inner };
            for (k, at) in [sine * radius, cosine * radius].into_iter().enumerate() {
                bounds.min[k] = bounds.min[k].min(at);
                bounds.max[k] = bounds.max[k].max(at);
            }
        }
        bounds
    }
}
