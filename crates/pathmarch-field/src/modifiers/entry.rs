//! Registration of a modifier: makes the object-safe [`Modify`] of a generic [`Modifier`].

use super::definition::Modifier;
use super::dispatch::{EvalModifier, Modify};
use crate::bounds::Aabb;
use crate::expression::{Expr, Function};
use crate::info::Info;
use crate::number::{Differentiable, Dual, Values, Vec3, values};
use crate::parameter::Param;
use std::marker::PhantomData;

/// The entry of a registered definition in its list.
pub(crate) struct Entry<T>(PhantomData<T>);

impl<T> Entry<T> {
    /// The entry; a constant, so that lists can be static.
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

/// Records a function of a point and numbers.
type Body<'a> = dyn Fn(&[Expr], &[Expr]) -> Vec<Expr> + 'a;

/// A function of a modifier: its `parameters`, then `count` numbers. The body gets the components of the one and the others.
fn modifier_function(
    modifier: &dyn Modify,
    suffix: &str,
    parameters: &[(&'static str, &'static str)],
    doc: String,
    count: usize,
    body: &Body,
) -> String {
    const NUMBERS: [&str; MOST_NUMBERS] = [
        "n0", "n1", "n2", "n3", "n4", "n5", "n6", "n7", "n8", "n9", "n10", "n11", "n12", "n13", "n14", "n15", "n16",
        "n17", "n18", "n19",
    ];
    let components = |kind: &str| match kind {
        "f32" => 1,
        "vec3f" => 3,
        _ => 4,
    };
    let inputs: usize = parameters.iter().map(|(_, kind)| components(kind)).sum();
    let numbers = NUMBERS[..count].iter().map(|name| (*name, "f32"));
    let parameters = parameters.iter().copied().chain(numbers).collect();
    let name = format!("{}_{suffix}", modifier.wgsl_name());
    Function { name, doc, parameters }.print(&|all| {
        let (inputs, numbers) = all.split_at(inputs);
        body(inputs, numbers)
    })
}

/// The most numbers that a modifier may read.
const MOST_NUMBERS: usize = 20;

impl<T: Modifier, N: Differentiable> EvalModifier<N> for Entry<T> {
    fn point(&self, p: Vec3<N>, place: N, numbers: &[f32]) -> Vec3<N> {
        T::point(p, place, values(numbers))
    }
    fn point_gradient(&self, p: Vec3<N>, place: N, numbers: &[f32]) -> Vec3<Dual<N>> {
        T::point(Dual::variables(p), Dual::independent(place), values(numbers))
    }
    fn distance(&self, p: Vec3<N>, inside: N, numbers: &[f32]) -> N {
        T::distance(p, inside, values(numbers))
    }
    fn gradient(&self, p: Vec3<N>, inside: Dual<N>, numbers: &[f32]) -> Dual<N> {
        T::distance(Dual::variables(p), inside, values(numbers))
    }
}

impl<T: Modifier> Modify for Entry<T> {
    fn info(&self) -> &'static Info {
        &T::INFO
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
    fn numbers(&self, params: &[f32], inside: Aabb) -> Vec<f32> {
        T::numbers(params, inside).as_ref().to_vec()
    }
    fn places(&self, params: &[f32], inside: Aabb) -> u32 {
        T::places(params, inside)
    }
    fn bounds(&self, params: &[f32], inside: Aabb) -> Aabb {
        T::bounds(params, inside)
    }
    fn wgsl(&self) -> String {
        let name = T::INFO.name;
        let count = T::Numbers::<f32>::from_fn(|_| 0.0).as_ref().len();
        let plain = |numbers: &[Expr]| T::Numbers::<Expr>::from_fn(|k| numbers[k]);
        let independent = |numbers: &[Expr]| T::Numbers::<Dual<Expr>>::from_fn(|k| Dual::independent(numbers[k]));
        let functions = [
            modifier_function(
                self,
                "point",
                &[("p", "vec3f"), ("place", "f32")],
                format!("Where `p` is in the space of what `{name}` holds."),
                count,
                &|inputs, numbers| {
                    let q = T::point(Expr::point(inputs, 0), inputs[3], plain(numbers));
                    vec![q.x, q.y, q.z]
                },
            ),
            modifier_function(
                self,
                "pull",
                &[("p", "vec3f"), ("place", "f32"), ("gradient", "vec3f")],
                format!("A gradient there as one at `p`, for `{name}`."),
                count,
                &|inputs, numbers| {
                    let p = Dual::variables(Expr::point(inputs, 0));
                    let g = T::point(p, Dual::independent(inputs[3]), independent(numbers))
                        .pulled(Expr::point(&inputs[4..], 0));
                    vec![g.x, g.y, g.z]
                },
            ),
            modifier_function(
                self,
                "distance",
                &[("p", "vec3f"), ("inside", "f32")],
                T::INFO.doc.to_owned(),
                count,
                &|inputs, numbers| vec![T::distance(Expr::point(inputs, 0), inputs[3], plain(numbers))],
            ),
            modifier_function(
                self,
                "gradient",
                &[("p", "vec3f"), ("inside", "vec4f")],
                format!("Gradient (xyz) and distance (w) of `{name}`."),
                count,
                &|inputs, numbers| {
                    let p = Dual::variables(Expr::point(inputs, 0));
                    Expr::outputs(T::distance(p, Expr::dual(&inputs[3..7]), independent(numbers)))
                },
            ),
        ];
        functions.join("\n")
    }
}
