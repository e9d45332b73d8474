//! Repetition around the y axis (Quilez 2008, "Domain repetition", rotational): copies of the child, rotated by whole
//! parts of a circle. As in `repeat`, the copies to evaluate are those next to `p`, given the angles that the child's bounding
//! box covers; all of them, at most eight, if it contains the axis.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::{ModifierDef, Motion};
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use std::f32::consts::{PI, TAU};

pub(crate) struct Op;

/// Largest number of copies to evaluate.
const MAX_COPIES: f32 = 8.0;

/// Largest angle of the box and its angular width, radians from +x.
fn angles(inside: Aabb) -> (f32, f32) {
    let holds_axis = inside.min[0] <= 0.0 && inside.max[0] >= 0.0 && inside.min[2] <= 0.0 && inside.max[2] >= 0.0;
    if holds_axis || !(inside.min[0].is_finite() && inside.max[0].is_finite() && inside.min[2].is_finite() && inside.max[2].is_finite()) {
        return (PI, TAU);
    }
    let middle = (0.5 * (inside.min[2] + inside.max[2])).atan2(0.5 * (inside.min[0] + inside.max[0]));
    let off = [inside.min[0], inside.max[0]].into_iter().flat_map(|x| [inside.min[2], inside.max[2]].map(|z| (x, z)));
    let off = off.map(|(x, z)| {
        let turn = z.atan2(x) - middle;
        turn - TAU * (turn / TAU).round()
    });
    let (low, high) = off.fold((0.0_f32, 0.0_f32), |(low, high), turn| (low.min(turn), high.max(turn)));
    (middle + high, high - low)
}

fn nearby(params: &[f32], inside: Aabb) -> f32 {
    let (_, width) = angles(inside);
    let across = (width * params[0] / TAU * 0.9999).ceil() + 1.0;
    across.min(params[0]).min(MAX_COPIES)
}

impl ModifierDef for Op {
    const INFO: Info = Info::new("polar", "Copies of its child, rotated about the y axis.", "Quilez 2008, domain repetition");
    const PARAMS: &'static [Param] = &[Param::count("count", 6.0, 1.0, 10_000.0, "Copies in the whole circle.")];
    type Coefficients<N: Real> = [N; 2];
    const IN_PLANE: bool = false;

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 2] {
        [TAU / params[0], angles(inside).0]
    }
    fn copies(params: &[f32], inside: Aabb) -> u32 {
        nearby(params, inside) as u32
    }
    fn motions(params: &[f32], _inside: Aabb, most: usize) -> Option<Vec<Motion>> {
        let copies = (0..params[0] as u32).map(|k| Motion { turn: -(k as f32) * (TAU / params[0]), offset: [0.0; 3] });
        (copies.len() <= most).then(|| copies.collect())
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, copy: N, [part, end]: [N; 2]) -> Vec3<N> {
        // From +x towards +z. The number is constant around a point: only the turn by it counts for derivatives.
        let number = ((p.z.atan2(p.x) - end) / part + N::constant(0.5)).floor() + copy;
        let turn = (number * part).named("turn");
        let (sine, cosine) = (turn.sin().named("sine"), turn.cos().named("cosine"));
        Vec3::new(p.x * cosine + p.z * sine, p.y, p.z * cosine - p.x * sine)
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        if params[0] == 1.0 {
            return inside;
        }
        let far = |k: usize| inside.min[k].abs().max(inside.max[k].abs());
        let radius = far(0).hypot(far(2));
        Aabb { min: [-radius, inside.min[1], -radius], max: [radius, inside.max[1], radius] }
    }
}
