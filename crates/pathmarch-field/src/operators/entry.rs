//! Registration of an operator: makes the object-safe [`Operator`] of a generic [`OperatorDef`].

use super::definition::OperatorDef;
use super::dispatch::{Boolean, EvalOperator, Operator};
use crate::blend::{Blend, BlendProfile, Blending};
use crate::bounds::Aabb;
use crate::expression::{Expr, Function};
use crate::info::Info;
use crate::number::{Differentiable, Dual, Real};
use crate::parameter::Param;
use std::marker::PhantomData;

/// Entry of a definition in the registry's list.
pub(crate) struct Entry<T>(PhantomData<T>);

impl<T> Entry<T> {
    /// Makes the entry; constant, so that lists are static.
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

/// Signature of an operator's WGSL function, sharp or with a blend profile.
fn operator_function(
    operator: &dyn Operator,
    suffix: &str,
    kind: &'static str,
    profile: Option<BlendProfile>,
) -> Function<'static> {
    let info = operator.info();
    let doc = match suffix {
        "distance" => info.doc.clone().into_owned(),
        "gradient" => format!("Gradient (xyz) and distance (w) of `{}`.", info.name),
        _ => format!("Weight of b's material in `{}`, 0..1.", info.name),
    };
    let mut parameters = vec![("a", kind), ("b", kind)];
    if let Some(profile) = profile {
        parameters.push((if operator.blends() { "width" } else { "amount" }, "f32"));
        parameters.extend(profile.has_steps().then_some(("steps", "f32")));
    }
    Function { name: format!("{}_{suffix}", operator.wgsl_name(profile)), doc, parameters }
}

/// Blend whose parameters are the first of these inputs.
fn blending(profile: BlendProfile, inputs: &[Expr]) -> Blending<Expr> {
    Blending { amount: inputs[0], profile, steps: inputs.get(1).copied().unwrap_or(inputs[0]) }
}

impl<T: OperatorDef, N: Differentiable> EvalOperator<N> for Entry<T> {
    fn distance(&self, a: N, b: N, blend: Option<Blend>) -> N {
        combine::<T, _>(a, b, blend)
    }
    fn gradient(&self, a: Dual<N>, b: Dual<N>, blend: Option<Blend>) -> Dual<N> {
        combine::<T, _>(a, b, blend)
    }
    fn weight(&self, a: N, b: N, blend: Option<Blend>) -> N {
        weight::<T, _>(a, b, blend)
    }
}

impl<T: OperatorDef> Operator for Entry<T> {
    fn info(&self) -> &'static Info {
        const { &T::INFO }
    }
    fn params(&self) -> &'static [Param] {
        T::PARAMS
    }
    fn blends(&self) -> bool {
        T::BLENDS
    }
    fn children(&self) -> (usize, usize) {
        T::CHILDREN
    }
    fn boolean(&self) -> Option<Boolean> {
        T::BOOLEAN
    }
    fn bounds(&self, a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb {
        T::bounds(a, b, blend)
    }
    fn wgsl_distance(&self, profile: Option<BlendProfile>) -> String {
        operator_function(self, "distance", "f32", profile).print(&|inputs| {
            vec![match profile {
                Some(profile) => T::blended(inputs[0], inputs[1], blending(profile, &inputs[2..])),
                None => T::sharp(inputs[0], inputs[1]),
            }]
        })
    }
    fn wgsl_gradient(&self, profile: Option<BlendProfile>) -> String {
        operator_function(self, "gradient", "vec4f", profile).print(&|inputs| {
            let (a, b) = (Expr::dual(&inputs[0..4]), Expr::dual(&inputs[4..8]));
            Expr::outputs(match profile {
                Some(profile) => {
                    let Blending { amount, steps, .. } = blending(profile, &inputs[8..]);
                    let (amount, steps) = (Dual::independent(amount), Dual::independent(steps));
                    T::blended(a, b, Blending { amount, profile, steps })
                }
                None => T::sharp(a, b),
            })
        })
    }
    fn wgsl_weight(&self, profile: Option<BlendProfile>) -> String {
        operator_function(self, "weight", "f32", profile).print(&|inputs| {
            vec![match profile {
                Some(profile) => T::blended_weight(inputs[0], inputs[1], blending(profile, &inputs[2..])),
                None => T::sharp_weight(inputs[0], inputs[1]),
            }]
        })
    }
}

fn combine<T: OperatorDef, N: Real>(a: N, b: N, blend: Option<Blend>) -> N {
    match blend {
        Some(blend) => T::blended(a, b, blend.over()),
        None => T::sharp(a, b),
    }
}

fn weight<T: OperatorDef, N: Real>(a: N, b: N, blend: Option<Blend>) -> N {
    match blend {
        Some(blend) => T::blended_weight(a, b, blend.over()),
        None => T::sharp_weight(a, b),
    }
}
