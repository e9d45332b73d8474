//! Object-safe form of a shape: the trait behind which a field evaluates all shapes.

use crate::bounds::Aabb;
use crate::expression::identifier;
use crate::info::Info;
use crate::mesh_shape::MeshGeometry;
use crate::number::{Dual, Real, Vec3};
use crate::parameter::Param;
use crate::ray_interval::{RayInterval, T_MAX};
use std::fmt::Debug;
use std::ops::Deref;
use std::sync::Arc;
use wide::f32x8;

/// Number of orbit traps; see [`ShapeDef::orbit`](super::ShapeDef::orbit).
pub const TRAPS: usize = 6;

/// Surface on which a light is sampled; lengths in metres, local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emitter {
    /// Sphere of this radius.
    Sphere(f32),
    /// Rectangle with these edge lengths along x and z.
    Rect([f32; 2]),
    /// Disc of this radius.
    Disc(f32),
    /// Box with these edge lengths.
    Box([f32; 3]),
    /// Any other surface: directions to its bounding box are sampled.
    Bounded,
}

/// Functions of a shape over one number type: `f32` for one point, `f32x8` for eight.
pub trait EvalShape<N: Real> {
    /// Signed distance at `p`, metres.
    fn distance(&self, p: Vec3<N>, params: &[f32]) -> N;
    /// Distance and gradient at `p`.
    fn gradient(&self, p: Vec3<Dual<N>>, params: &[f32]) -> Dual<N>;
    /// Distance and gradient at an analytic hit; see [`ShapeDef::distance_at_hit`](super::ShapeDef::distance_at_hit).
    fn gradient_at_hit(&self, p: Vec3<Dual<N>>, params: &[f32]) -> Dual<N> {
        self.gradient(p, params)
    }
    /// Interval of a line inside a convex solid; see [`ShapeDef::interval`](super::ShapeDef::interval).
    fn interval(&self, _origin: Vec3<N>, _direction: Vec3<N>, _params: &[f32]) -> RayInterval<N> {
        RayInterval::empty()
    }
    /// Metres to the first hit of a ray, or [`T_MAX`]; see [`ShapeDef::ray`](super::ShapeDef::ray).
    fn ray(&self, _origin: Vec3<N>, _direction: Vec3<N>, _params: &[f32]) -> N {
        N::constant(T_MAX)
    }
    /// Orbit traps of a point about `centre`; see [`ShapeDef::orbit`](super::ShapeDef::orbit).
    fn orbit(&self, _p: Vec3<N>, _centre: Vec3<N>, _params: &[f32]) -> [N; TRAPS] {
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
    /// Parameters, in order.
    fn params(&self) -> &[Param];
    /// Coefficients that the functions read as `params`, computed once from the parameters.
    fn coefficients(&self, params: &[f32]) -> Vec<f32> {
        params.to_vec()
    }
    /// True if the coefficients are a lookup table of `vec4`s of any length. Its WGSL functions read the table from the
    /// parameter buffer and take the index of its first vector as their argument.
    fn reads_table(&self) -> bool {
        false
    }
    /// Faster variant with some parameters fixed at compile time; see [`ShapeDef::variant`](super::ShapeDef::variant).
    fn variant(&self, _params: &[f32]) -> Option<&'static dyn Shape> {
        None
    }
    /// Bounding box of the solid.
    fn bounds(&self, params: &[f32]) -> Aabb;
    /// Lipschitz constant: an upper bound of |∇distance|.
    fn lipschitz(&self, params: &[f32]) -> f32;
    /// Surface on which a light of this shape is sampled.
    fn emitter(&self, _params: &[f32]) -> Emitter {
        Emitter::Bounded
    }
    /// Area of the surface, of a sheet that of one side, square metres; `None` where there is no formula.
    fn area(&self, _params: &[f32]) -> Option<f32> {
        None
    }
    /// Reports whether rays intersect it analytically.
    fn is_analytic(&self) -> bool {
        false
    }
    /// Reports whether it is convex and lines through it have an analytic interval.
    fn is_convex(&self) -> bool {
        false
    }
    /// Reports whether it is a fractal with orbit traps.
    fn has_orbit(&self) -> bool {
        false
    }
    /// Orbit traps as a WGSL function `NAME_orbit(p: vec3f, centre: vec3f, …) -> array<f32, 6>`.
    fn wgsl_orbit(&self) -> String {
        String::new()
    }
    /// Interval of a line as a WGSL function `NAME_interval(origin: vec3f, direction: vec3f, …) -> vec2f`.
    fn wgsl_interval(&self) -> String {
        String::new()
    }
    /// Ray intersection as a WGSL function `NAME_ray(origin: vec3f, direction: vec3f, …) -> f32`.
    fn wgsl_ray(&self) -> String {
        String::new()
    }
    /// Distance as a WGSL function `NAME_distance(p: vec3f, …) -> f32`.
    fn wgsl_distance(&self) -> String;
    /// Gradient (xyz) and distance (w) as a WGSL function `NAME_gradient(p: vec3f, …) -> vec4f`.
    fn wgsl_gradient(&self) -> String;
    /// Gradient and distance at an analytic hit as a WGSL function `NAME_hit_gradient(p: vec3f, …) -> vec4f`.
    fn wgsl_hit_gradient(&self) -> String {
        String::new()
    }
    /// Prefix of the names of its WGSL functions.
    fn wgsl_name(&self) -> String {
        identifier(&self.info().name).trim_end_matches('_').to_owned()
    }
    /// Lipschitz constant declared in the scene, by which the distance is divided.
    fn declared_lipschitz(&self) -> Option<f32> {
        None
    }
    /// The mesh, if it is one.
    fn mesh(&self) -> Option<&MeshGeometry> {
        None
    }
    /// Reports whether its WGSL is built in and may run without bounds checks.
    fn is_trusted(&self) -> bool {
        true
    }
}

impl Debug for dyn Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.info().name)
    }
}

/// Shared reference to a shape: registered, or declared in a scene and owned by its users.
#[derive(Clone, Debug)]
pub enum ShapeRef {
    /// Registered shape.
    Registered(&'static dyn Shape),
    /// Shape declared in a scene.
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
