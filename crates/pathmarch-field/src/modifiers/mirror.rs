//! Mirror: the child and its image behind the plane through the origin across an axis. Both copies are evaluated, so that
//! children may cross the plane; a child on the positive side alone needs one, at the folded point.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

/// Reports whether the child is on the side of positive coordinates alone.
fn is_on_positive_side(params: &[f32], inside: Aabb) -> bool {
    inside.min[params[0] as usize] >= 0.0
}

impl ModifierDef for Op {
    const INFO: Info = Info::new("mirror", "Its child and the mirror image behind a plane through the origin.", "Hart 1996, section 2.3");
    const PARAMS: &'static [Param] = &[Param::axis("axis", "The mirror lies across this axis.")];
    type Coefficients<N: Real> = [N; 4];

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 4] {
        let across = |axis: usize| if params[0] as usize == axis { 1.0 } else { 0.0 };
        [across(0), across(1), across(2), if is_on_positive_side(params, inside) { 1.0 } else { 0.0 }]
    }
    fn copies(params: &[f32], inside: Aabb) -> u32 {
        if is_on_positive_side(params, inside) { 1 } else { 2 }
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, copy: N, [x, y, z, folds]: [N; 4]) -> Vec3<N> {
        let half = N::constant(0.5);
        let image = half.lt(copy);
        let turned = |v: N, across: N| {
            let other = N::select(half.lt(folds), v.abs(), N::select(image, -v, v));
            N::select(half.lt(across), other, v)
        };
        Vec3::new(turned(p.x, x), turned(p.y, y), turned(p.z, z))
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        let axis = params[0] as usize;
        let mut image = inside;
        (image.min[axis], image.max[axis]) = (-inside.max[axis], -inside.min[axis]);
        inside.union(image)
    }
}
