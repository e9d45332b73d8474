//! Object-safe form of a shape: the trait behind which a field evaluates all shapes.

use crate::bounds::Aabb;
use crate::expression::identifier;
use crate::info::Info;
use crate::number::{Dual, Real, Vec3};
use crate::parameter::Param;
use crate::ray_interval::{RayInterval, T_MAX};
use std::fmt::Debug;
use std::ops::Deref;
use std::sync::Arc;
use wide::f32x8;

/// How many numbers tell of an orbit; see [`ShapeDef::orbit`].
pub const TRAPS: usize = 5;

/// The surface of a shape, for choosing points on it: lengths in metres, local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emitter {
    /// A sphere of this radius.
    Sphere(f32),
    /// A sheet with these edges along x and z.
    Rect([f32; 2]),
    /// A round sheet of this radius.
    Disc(f32),
    /// A box of these edges.
    Box([f32; 3]),
    /// Anything else: somewhere in its bounds.
    Bounded,
}

/// Functions of a shape over one number type: `f32` for one point, `f32x8` for eight.
pub trait EvalShape<N: Real> {
    /// Signed distance at `p`, metres.
    fn distance(&self, p: Vec3<N>, params: &[f32]) -> N;
    /// Distance and gradient at `p`.
    fn gradient(&self, p: Vec3<Dual<N>>, params: &[f32]) -> Dual<N>;
    /// Interval of a line inside a convex solid; see [`ShapeDef::span`](super::ShapeDef::interval).
    fn interval(&self, _origin: Vec3<N>, _direction: Vec3<N>, _params: &[f32]) -> RayInterval<N> {
        RayInterval::nowhere()
    }
    /// Metres to the first hit of a ray, or [`T_MAX`]; see [`ShapeDef::ray`](super::ShapeDef::ray).
    fn ray(&self, _origin: Vec3<N>, _direction: Vec3<N>, _params: &[f32]) -> N {
        N::constant(T_MAX)
    }
    /// Orbit traps of a point; see [`ShapeDef::orbit`](super::ShapeDef::orbit).
    fn orbit(&self, _p: Vec3<N>, _params: &[f32]) -> [N; TRAPS] {
        [N::zero(); TRAPS]
    }
}

/// A shape as a field evaluates it: object-safe, with all its number types.
///
/// Registered shapes get it from their [`ShapeDef`](super::ShapeDef). Code that is generic over the number type calls
/// [`Batch::shape`](crate::graph::Batch::shape). The eight-point functions come first: their vtable is a prefix, so that the
/// conversion costs nothing.
pub trait Shape: EvalShape<f32x8> + EvalShape<f32> + Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &Info;
    /// The parameters, in order.
    fn params(&self) -> &[Param];
    /// The numbers that the functions below read, found once of the parameters.
    fn coefficients(&self, params: &[f32]) -> Vec<f32> {
        params.to_vec()
    }
    /// Whether those numbers are a table of vectors, which may be of any length: its WGSL functions read it in the table of the
    /// field, and are given the number of its first vector there instead of the numbers themselves.
    fn reads_table(&self) -> bool {
        false
    }
    /// The same shape with some of its numbers fixed in its code, which then is faster; see [`ShapeDef::variant`].
    fn variant(&self, _params: &[f32]) -> Option<&'static dyn Shape> {
        None
    }
    /// A box that holds the solid.
    fn bounds(&self, params: &[f32]) -> Aabb;
    /// An upper bound of |∇distance|.
    fn lipschitz(&self, params: &[f32]) -> f32;
    /// What a light of this shape is sampled as.
    fn emitter(&self, _params: &[f32]) -> Emitter {
        Emitter::Bounded
    }
    /// Whether rays meet it in closed form.
    fn is_analytic(&self) -> bool {
        false
    }
    /// Whether it is convex, and spans are known in closed form.
    fn is_convex(&self) -> bool {
        false
    }
    /// Whether it follows orbits.
    fn has_orbit(&self) -> bool {
        false
    }
    /// The orbit as a WGSL function `NAME_orbit(p: vec3f, …) -> array<f32, 5>`.
    fn wgsl_orbit(&self) -> String {
        String::new()
    }
    /// The span as a WGSL function `NAME_interval(origin: vec3f, direction: vec3f, …) -> vec2f`.
    fn wgsl_interval(&self) -> String {
        String::new()
    }
    /// The closed form as a WGSL function `NAME_ray(origin: vec3f, direction: vec3f, …) -> f32`.
    fn wgsl_ray(&self) -> String {
        String::new()
    }
    /// The distance as a WGSL function `NAME_distance(p: vec3f, …) -> f32`.
    fn wgsl_distance(&self) -> String;
    /// The gradient (xyz) and distance (w) as a WGSL function `NAME_gradient(p: vec3f, …) -> vec4f`.
    fn wgsl_gradient(&self) -> String;
    /// What its WGSL functions' names begin with.
    fn wgsl_name(&self) -> String {
        identifier(self.info().name).trim_end_matches('_').to_owned()
    }
    /// The Lipschitz constant that a person declared, by which the distance is divided.
    fn declared_lipschitz(&self) -> Option<f32> {
        None
    }
    /// Whether its WGSL is ours, and needs no checks where it runs.
    fn is_trusted(&self) -> bool {
        true
    }
}

impl Debug for dyn Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().name)
    }
}

/// A shape that is kept: one of the registry, or one that a scene declares and that lives as long as it is used.
#[derive(Clone, Debug)]
pub enum ShapeRef {
    /// One of the registry.
    Registered(&'static dyn Shape),
    /// One that a scene declares.
    Custom(Arc<dyn Shape>),
}

impl Deref for ShapeRef {
    type Target = dyn Shape;
    fn deref(&self) -> &(dyn Shape + 'static) {
        match self {
            Self::Registered(shape) => *shape,
            Self::Custom(shape) => &**shape,
        }
    }
}

impl From<&'static dyn Shape> for ShapeRef {
    fn from(shape: &'static dyn Shape) -> Self {
        Self::Registered(shape)
    }
}
