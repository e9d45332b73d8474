//! Registration of a modifier: makes the object-safe [`Modifier`] of a generic [`ModifierDef`].

use super::definition::{ModifierDef, Motion};
use super::dispatch::{EvalModifier, Modifier};
use crate::bounds::Aabb;
use crate::expression::{Expr, Function};
use crate::info::Info;
use crate::number::{Differentiable, Dual, Values, Vec3, values};
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

/// Body of a recorded function: inputs, then coefficients.
type Body<'a> = dyn Fn(&[Expr], &[Expr]) -> Vec<Expr> + 'a;

/// Prints a WGSL function of a modifier: its `parameters`, then `count` coefficients. The body gets both as scalars.
fn modifier_function(
    modifier: &dyn Modifier,
    suffix: &str,
    parameters: &[(&'static str, &'static str)],
    doc: String,
    count: usize,
    body: &Body,
) -> String {
    const NUMBERS: [&str; MAX_COEFFICIENTS] = [
        "n0", "n1", "n2", "n3", "n4", "n5", "n6", "n7", "n8", "n9", "n10", "n11", "n12", "n13", "n14", "n15", "n16",
        "n17", "n18", "n19",
    ];
    let components = |kind: &str| match kind {
        "f32" => 1,
        "vec3f" => 3,
        _ => 4,
    };
    let inputs: usize = parameters.iter().map(|(_, kind)| components(kind)).sum();
    let coefficients = NUMBERS[..count].iter().map(|name| (*name, "f32"));
    let parameters = parameters.iter().copied().chain(coefficients).collect();
    let name = format!("{}_{suffix}", modifier.wgsl_name());
    Function { name, doc, parameters }.print(&|all| {
        let (inputs, coefficients) = all.split_at(inputs);
        body(inputs, coefficients)
    })
}

/// Largest number of coefficients of a modifier.
const MAX_COEFFICIENTS: usize = 20;

impl<T: ModifierDef, N: Differentiable> EvalModifier<N> for Entry<T> {
    fn point(&self, p: Vec3<N>, copy: N, coefficients: &[f32]) -> Vec3<N> {
        T::point(p, copy, values(coefficients))
    }
    fn point_gradient(&self, p: Vec3<N>, copy: N, coefficients: &[f32]) -> Vec3<Dual<N>> {
        T::point(Dual::variables(p), Dual::independent(copy), values(coefficients))
    }
    fn distance(&self, p: Vec3<N>, inside: N, coefficients: &[f32]) -> N {
        T::distance(p, inside, values(coefficients))
    }
    fn gradient(&self, p: Vec3<N>, inside: Dual<N>, coefficients: &[f32]) -> Dual<N> {
        T::distance(Dual::variables(p), inside, values(coefficients))
    }
}

impl<T: ModifierDef> Modifier for Entry<T> {
    fn info(&self) -> &'static Info {
        const { &T::INFO }
    }
    fn params(&self) -> &'static [Param] {
        T::PARAMS
    }
    fn needs_bounds(&self) -> bool {
        T::NEEDS_BOUNDS
    }
    fn of_profiles(&self) -> bool {
        T::OF_PROFILES
    }
    fn in_plane(&self) -> bool {
        T::IN_PLANE
    }
    fn coefficients(&self, params: &[f32], inside: Aabb) -> Vec<f32> {
        T::coefficients(params, inside).as_ref().to_vec()
    }
    fn copies(&self, params: &[f32], inside: Aabb) -> u32 {
        T::copies(params, inside)
    }
    fn motions(&self, params: &[f32], inside: Aabb, most: usize) -> Option<Vec<Motion>> {
        T::motions(params, inside, most)
    }
    fn inner_margin(&self, params: &[f32], inside: Aabb, margin: f32) -> Option<f32> {
        T::inner_margin(params, inside, margin)
    }
    fn bounds(&self, params: &[f32], inside: Aabb) -> Aabb {
        T::bounds(params, inside)
    }
    fn wgsl(&self) -> String {
        let name = T::INFO.name;
        let count = T::Coefficients::<f32>::from_fn(|_| 0.0).as_ref().len();
        let plain = |coefficients: &[Expr]| T::Coefficients::<Expr>::from_fn(|k| coefficients[k]);
        let independent =
            |coefficients: &[Expr]| T::Coefficients::<Dual<Expr>>::from_fn(|k| Dual::independent(coefficients[k]));
        let functions = [
            modifier_function(
                self,
                "point",
                &[("p", "vec3f"), ("copy", "f32")],
                format!("Point `p` in the space of the child of `{name}`."),
                count,
                &|inputs, coefficients| {
                    let q = T::point(Expr::point(inputs, 0), inputs[3], plain(coefficients));
                    vec![q.x, q.y, q.z]
                },
            ),
            modifier_function(
                self,
                "pull",
                &[("p", "vec3f"), ("copy", "f32"), ("gradient", "vec3f")],
                format!("Gradient in the space of the child of `{name}`, pulled back to `p`."),
                count,
                &|inputs, coefficients| {
                    let p = Dual::variables(Expr::point(inputs, 0));
                    let g = T::point(p, Dual::independent(inputs[3]), independent(coefficients))
                        .pulled_back(Expr::point(&inputs[4..], 0));
                    vec![g.x, g.y, g.z]
                },
            ),
            modifier_function(
                self,
                "distance",
                &[("p", "vec3f"), ("inside", "f32")],
                T::INFO.doc.into_owned(),
                count,
                &|inputs, coefficients| vec![T::distance(Expr::point(inputs, 0), inputs[3], plain(coefficients))],
            ),
            modifier_function(
                self,
                "gradient",
                &[("p", "vec3f"), ("inside", "vec4f")],
                format!("Gradient (xyz) and distance (w) of `{name}`."),
                count,
                &|inputs, coefficients| {
                    let p = Dual::variables(Expr::point(inputs, 0));
                    Expr::outputs(T::distance(p, Expr::dual(&inputs[3..7]), independent(coefficients)))
                },
            ),
        ];
        functions.join("\n")
    }
}
