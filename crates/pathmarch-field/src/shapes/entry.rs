//! Registration of a shape: makes the object-safe [`Shape`] of a generic [`ShapeDef`].

use super::definition::ShapeDef;
use super::dispatch::{Emitter, EvalShape, Shape, TRAPS};
use crate::bounds::Aabb;
use crate::expression::{Expr, Function, identifier};
use crate::info::Info;
use crate::number::{Differentiable, Dual, Values, Vec3, values};
use crate::parameter::Param;
use crate::ray_interval::RayInterval;
use std::marker::PhantomData;

/// Entry of a definition in the registry's list.
pub(crate) struct Entry<T>(PhantomData<T>);

impl<T> Entry<T> {
    /// Makes the entry; constant, so that lists are static.
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

/// Signature of a shape's WGSL function: its points, then its parameters.
fn shape_function<'a>(shape: &'a dyn Shape, suffix: &str, points: &[&'static str], doc: String) -> Function<'a> {
    let points = points.iter().map(|&p| (p, "vec3f"));
    let parameters = points.chain(shape.params().iter().map(|p| (&*p.name, "f32"))).collect();
    Function { name: format!("{}_{suffix}", shape.wgsl_name()), doc, parameters }
}

/// Prefix of the WGSL functions of a shape of this name and variant.
fn shape_name(name: &str, variant: u32) -> String {
    let name = identifier(name);
    let name = name.trim_end_matches('_');
    if variant > 0 { format!("{name}_{variant}") } else { name.to_owned() }
}

/// Outputs of a gradient function: the derivatives of a distance along the axes, then the distance.
fn gradient<V: Values<Dual<Expr>>>(inputs: &[Expr], distance: impl Fn(Vec3<Dual<Expr>>, V) -> Dual<Expr>) -> Vec<Expr> {
    let params = V::from_fn(|k| Dual::independent(inputs[3 + k]));
    Expr::outputs(distance(Dual::variables(Expr::point(inputs, 0)), params))
}

impl<T: ShapeDef, N: Differentiable> EvalShape<N> for Entry<T> {
    fn distance(&self, p: Vec3<N>, params: &[f32]) -> N {
        T::distance(p, values(params))
    }
    fn gradient(&self, p: Vec3<Dual<N>>, params: &[f32]) -> Dual<N> {
        T::distance_compact(p, values(params))
    }
    fn gradient_at_hit(&self, p: Vec3<Dual<N>>, params: &[f32]) -> Dual<N> {
        T::distance_at_hit(p, values(params))
    }
    fn interval(&self, origin: Vec3<N>, direction: Vec3<N>, params: &[f32]) -> RayInterval<N> {
        T::interval(origin, direction, values(params))
    }
    fn ray(&self, origin: Vec3<N>, direction: Vec3<N>, params: &[f32]) -> N {
        T::ray(origin, direction, values(params))
    }
    fn orbit(&self, p: Vec3<N>, centre: Vec3<N>, params: &[f32]) -> [N; TRAPS] {
        T::orbit(p, centre, values(params))
    }
}

impl<T: ShapeDef> Shape for Entry<T> {
    fn info(&self) -> &Info {
        const { &T::INFO }
    }
    fn params(&self) -> &[Param] {
        T::PARAMS
    }
    fn variant(&self, params: &[f32]) -> Option<&'static dyn Shape> {
        T::variant(values(params))
    }
    fn wgsl_name(&self) -> String {
        shape_name(&T::INFO.name, T::VARIANT)
    }
    fn bounds(&self, params: &[f32]) -> Aabb {
        T::bounds(values(params))
    }
    fn lipschitz(&self, params: &[f32]) -> f32 {
        T::lipschitz(values(params))
    }
    fn emitter(&self, params: &[f32]) -> Emitter {
        T::emitter(values(params))
    }
    fn area(&self, params: &[f32]) -> Option<f32> {
        T::area(values(params))
    }
    fn is_analytic(&self) -> bool {
        T::ANALYTIC
    }
    fn is_convex(&self) -> bool {
        T::CONVEX
    }
    fn has_orbit(&self) -> bool {
        T::ORBIT
    }
    fn wgsl_orbit(&self) -> String {
        let doc = "Orbit traps of `NAME` about a centre: point, line, plane, sphere, farthest; fraction of iterations.";
        shape_function(self, "orbit", &["p", "centre"], doc.replace("NAME", &T::INFO.name)).print(&|inputs| {
            let params = T::Params::from_fn(|k| inputs[6 + k]);
            T::orbit(Expr::point(inputs, 0), Expr::point(inputs, 1), params).to_vec()
        })
    }
    fn wgsl_interval(&self) -> String {
        let doc = "Interval of a line inside `NAME`, metres.".replace("NAME", &T::INFO.name);
        shape_function(self, "interval", &["origin", "direction"], doc).print(&|inputs| {
            let params = T::Params::from_fn(|k| inputs[6 + k]);
            let RayInterval { enter, leave } = T::interval(Expr::point(inputs, 0), Expr::point(inputs, 1), params);
            vec![enter, leave]
        })
    }
    fn wgsl_ray(&self) -> String {
        let doc = "Metres to the first hit of a ray with `NAME`.".replace("NAME", &T::INFO.name);
        shape_function(self, "ray", &["origin", "direction"], doc).print(&|inputs| {
            vec![T::ray(Expr::point(inputs, 0), Expr::point(inputs, 1), T::Params::from_fn(|k| inputs[6 + k]))]
        })
    }
    fn wgsl_distance(&self) -> String {
        shape_function(self, "distance", &["p"], T::INFO.doc.into_owned())
            .print(&|inputs| vec![T::distance_compact(Expr::point(inputs, 0), T::Params::from_fn(|k| inputs[3 + k]))])
    }
    fn wgsl_gradient(&self) -> String {
        let doc = "Gradient (xyz) and distance (w) of `NAME`.".replace("NAME", &T::INFO.name);
        shape_function(self, "gradient", &["p"], doc).print(&|inputs| gradient(inputs, T::distance_compact))
    }
    fn wgsl_hit_gradient(&self) -> String {
        let doc = "Gradient (xyz) and distance (w) of `NAME` at the hit of a ray.".replace("NAME", &T::INFO.name);
        shape_function(self, "hit_gradient", &["p"], doc).print(&|inputs| gradient(inputs, T::distance_at_hit))
    }
}
