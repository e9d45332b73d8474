//! What a shape and an operator are, and the lists of those there are.
//!
//! One file declares one shape: a unit struct that implements [`Primitive`]. The `mod` line that names the file in
//! `shapes/mod.rs` puts it into [`shapes`]; everything else (parser, reference page, CPU and GPU code, tests) reads that
//! list. Operators do the same with [`Operator`] in `operators/mod.rs`.

use crate::blend::{Blend, BlendProfile, Blending};
use crate::bounds::Aabb;
use crate::number::{Dual, Real, Vec3};
pub use crate::span::Span;
use crate::wgsl::{Expr, Function, identifier};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::Deref;
use std::sync::Arc;
use wide::f32x8;

/// What a number of a shape measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Metres,
    /// Degrees.
    Degrees,
    /// A whole number.
    Count,
    /// One of the axes x, y and z, as 0, 1 and 2.
    Axis,
    /// A number without unit.
    Ratio,
}

impl Unit {
    /// As printed after a number.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Degrees => "°",
            Self::Count => "count",
            Self::Axis => "axis",
            Self::Ratio => "",
        }
    }
}

/// One number of a shape or operator.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// Name in the scene language.
    pub name: &'static str,
    /// What it measures.
    pub unit: Unit,
    /// Value when not given.
    pub default: f32,
    /// Smallest allowed value.
    pub min: f32,
    /// Whether `min` itself is allowed.
    pub min_allowed: bool,
    /// Largest allowed value.
    pub max: f32,
    /// One line for people.
    pub doc: &'static str,
}

impl Param {
    /// A length above zero, metres.
    pub const fn length(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Metres, default, min: 0.0, min_allowed: false, max: f32::MAX, doc }
    }
    /// A length of zero or more, metres.
    pub const fn length_or_zero(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { min_allowed: true, ..Self::length(name, default, doc) }
    }
    /// A component of a direction or position: any number.
    pub const fn any(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min: f32::MIN, min_allowed: true, max: f32::MAX, doc }
    }
    /// A number from `min` to `max`.
    pub const fn between(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min, min_allowed: true, max, doc }
    }
    /// A whole number from `min` to `max`.
    pub const fn count(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { unit: Unit::Count, ..Self::between(name, default, min, max, doc) }
    }
    /// An axis.
    pub const fn axis(name: &'static str, doc: &'static str) -> Self {
        Self { unit: Unit::Axis, ..Self::between(name, 0.0, 0.0, 2.0, doc) }
    }
    /// Whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && (value > self.min || self.min_allowed && value == self.min) && value <= self.max
    }
    /// The range in words, as in "must be above 0".
    pub fn range_in_words(&self) -> String {
        let whole = if self.unit == Unit::Count { "a whole number " } else { "" };
        match (self.min > f32::MIN, self.max < f32::MAX) {
            (true, true) => format!("{whole}from {} to {}", self.min, self.max),
            (true, false) if self.min_allowed => format!("{whole}{} or more", self.min),
            (true, false) => format!("{whole}above {}", self.min),
            (false, true) => format!("{whole}at most {}", self.max),
            (false, false) => format!("{whole}any finite number"),
        }
    }
}

/// What a shape or an operator says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Name in the scene language.
    pub name: &'static str,
    /// One sentence: what it is, where it stands.
    pub doc: &'static str,
    /// Author, work, year, section; a key of REFERENCES.md where there is one.
    pub source: &'static str,
    /// Whether the value outside is the true Euclidean distance, not only a lower bound.
    pub exact: bool,
    /// How many of the leading parameters are one size, for which a single number may stand.
    pub size_params: usize,
    /// A surface without thickness that faces +y: it emits on that side only.
    pub sheet: bool,
    /// Faces +y, and may be turned to face a `normal` instead.
    pub facing: bool,
    /// A profile: it stands in the plane of x and y, its distance does not depend on z, and it has no end along z. What is
    /// [of profiles](Modifier::OF_PROFILES) makes solids of it.
    pub profile: bool,
    /// What its outline is made of, if it is drawn: numbers behind its parameters, [`crate::outline`].
    pub outline: Option<Outline>,
}

/// What people write of a shape that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// Points.
    Points,
    /// Letters of a font.
    Text,
}

impl Info {
    /// An exact solid without size parameters; override fields with struct update syntax.
    pub const fn new(name: &'static str, doc: &'static str, source: &'static str) -> Self {
        Self {
            name,
            doc,
            source,
            exact: true,
            size_params: 0,
            sheet: false,
            facing: false,
            profile: false,
            outline: None,
        }
    }
}

/// A list of parameter values; implemented by arrays.
pub trait Values<N>: AsRef<[N]> + Copy {
    /// From the value at each index.
    fn from_fn(value: impl FnMut(usize) -> N) -> Self;
}

impl<N: Copy, const K: usize> Values<N> for [N; K] {
    #[inline(always)]
    fn from_fn(value: impl FnMut(usize) -> N) -> Self {
        std::array::from_fn(value)
    }
}

/// A shape, written once.
///
/// Implementations are unit structs named `Shape`, one in each file of `shapes/`.
pub trait Primitive: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// As many numbers as there are parameters: `[N; K]`.
    type Params<N: Real>: Values<N>;

    /// Signed distance from `p` to the surface, metres, negative inside; a lower bound of it where not exact.
    fn distance<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N;
    /// The same distance, to the last bit, where little code matters more than speed: for gradients and for recording. A shape
    /// of many [variants](Self::variant) has one function here for all of them.
    #[inline(always)]
    fn distance_compact<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N {
        Self::distance(p, params)
    }
    /// A box that holds the solid.
    fn bounds(params: Self::Params<f32>) -> Aabb;
    /// An upper bound of |∇distance|.
    fn lipschitz(_params: Self::Params<f32>) -> f32 {
        1.0
    }
    /// What a light of this shape is sampled as.
    fn emitter(_params: Self::Params<f32>) -> Emitter {
        Emitter::Bounded
    }
    /// Whether the solid is convex and [`span`](Self::span) is written.
    const CONVEX: bool = false;
    /// Where a line is inside a convex solid, metres from `origin` along the unit vector `direction`.
    fn span<N: Real>(_origin: Vec3<N>, _direction: Vec3<N>, _params: Self::Params<N>) -> Span<N> {
        Span::nowhere()
    }
    /// Whether where a ray meets this shape is known in closed form: [`span`](Self::span) or [`ray`](Self::ray) is written.
    const CLOSED_FORM: bool = Self::CONVEX;
    /// Metres from `origin` along the unit vector `direction` to the first point of the surface ahead, from outside or
    /// inside; [`NO_HIT`] where there is none.
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, params: Self::Params<N>) -> N {
        Self::span(origin, direction, params).ahead()
    }
    /// Tells apart the shapes that [`variant`](Self::variant) gives, which have this one's name; 0 for the one of the list.
    const VARIANT: u32 = 0;
    /// The same shape with some of its numbers fixed in its code, which then is faster.
    fn variant(_params: Self::Params<f32>) -> Option<&'static dyn Shape> {
        None
    }
    /// Whether [`orbit`](Self::orbit) is written: the shape is a fractal, which follows the orbit of a point.
    const ORBIT: bool = false;
    /// What the orbit of `p` comes near to: its least distance to the origin, to the y axis, to the plane y = 0 and to the
    /// unit sphere, and the share of the iterations that were done before it escaped, 0..1.
    fn orbit<N: Real>(_p: Vec3<N>, _params: Self::Params<N>) -> [N; TRAPS] {
        [N::zero(); TRAPS]
    }
}

/// How many numbers tell of an orbit; see [`Primitive::orbit`].
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

/// What a ray that meets nothing gives: farther than any scene, and finite.
pub const NO_HIT: f32 = 1e30;

/// An operation on truth values: what two solids hold together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boolean {
    /// Either.
    Union,
    /// Both.
    Intersection,
    /// The first, without the second.
    Difference,
}

/// An operator that makes one solid of two, written once.
///
/// More than two children are folded from the first to the last. Implementations are unit structs named `Shape`'s twin
/// `Op`, one in each file of `operators/`.
pub trait Operator: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters: none where it blends, one that is the [`Blend::amount`] where it does not.
    const PARAMS: &'static [Param] = &[];
    /// Whether it blends edges over a width, by any [`BlendProfile`].
    const BLENDS: bool = true;
    /// How many children it needs, and how many it may have.
    const CHILDREN: (usize, usize) = (1, usize::MAX);
    /// What it does to solids, where it is sharp, as an operation on truth values.
    const BOOLEAN: Option<Boolean> = None;
    /// The sharp result.
    fn sharp<N: Real>(a: N, b: N) -> N;
    /// The blended result.
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// How much of `b`'s material shows, 0..1, in the sharp result.
    fn sharp_weight<N: Real>(a: N, b: N) -> N;
    /// How much of `b`'s material shows, 0..1, in the blended result.
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// A box that holds the result.
    fn bounds(a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
}

/// An operator that changes the space in which what it holds stands, or its distance, written once.
///
/// What it holds is one solid: the union of its children. Implementations are unit structs named `Op`, one in each file of
/// `modifiers/`.
pub trait Modifier: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// The numbers that the functions below read: `[N; K]`.
    type Numbers<N: Real>: Values<N>;
    /// Whether it needs what it holds to have an end.
    const NEEDS_BOUNDS: bool = false;
    /// Whether it makes solids of profiles, and of solids their slice at z = 0.
    const OF_PROFILES: bool = false;
    /// Whether it moves points only within planes across z, so that it may hold profiles.
    const IN_PLANE: bool = true;

    /// The numbers, found once of the parameters and of the box that holds what it holds.
    fn numbers(params: &[f32], inside: Aabb) -> Self::Numbers<f32>;
    /// In how many places what it holds must be looked for; [`point`](Self::point) tells them apart.
    fn places(_params: &[f32], _inside: Aabb) -> u32 {
        1
    }
    /// Where `p` is in the space of what it holds; `place` counts from 0.
    fn point<N: Real>(p: Vec3<N>, _place: N, _numbers: Self::Numbers<N>) -> Vec3<N> {
        p
    }
    /// The distance at `p`, given the least one of what it holds at the points of `p`.
    fn distance<N: Real>(_p: Vec3<N>, inside: N, _numbers: Self::Numbers<N>) -> N {
        inside
    }
    /// A box that holds the result.
    fn bounds(params: &[f32], inside: Aabb) -> Aabb;
}

/// A [`Primitive`] behind a pointer.
pub trait Shape: Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &Info;
    /// The parameters, in order.
    fn params(&self) -> &[Param];
    /// The numbers that the functions below read, found once of the parameters.
    fn numbers(&self, params: &[f32]) -> Vec<f32> {
        params.to_vec()
    }
    /// Whether those numbers are a table of vectors, which may be of any length: its WGSL functions read it in the table of the
    /// field, and are given the number of its first vector there instead of the numbers themselves.
    fn reads_table(&self) -> bool {
        false
    }
    /// The same shape with some of its numbers fixed in its code, which then is faster; see [`Primitive::variant`].
    fn variant(&self, _params: &[f32]) -> Option<&'static dyn Shape> {
        None
    }
    /// Distance at one point.
    fn distance(&self, p: Vec3<f32>, params: &[f32]) -> f32;
    /// Distance at eight points.
    fn distance_lanes(&self, p: Vec3<f32x8>, params: &[f32]) -> f32x8;
    /// Distance and gradient at one point.
    fn gradient(&self, p: Vec3<Dual<f32>>, params: &[f32]) -> Dual<f32>;
    /// Distance and gradient at eight points.
    fn gradient_lanes(&self, p: Vec3<Dual<f32x8>>, params: &[f32]) -> Dual<f32x8>;
    /// A box that holds the solid.
    fn bounds(&self, params: &[f32]) -> Aabb;
    /// An upper bound of |∇distance|.
    fn lipschitz(&self, params: &[f32]) -> f32;
    /// What a light of this shape is sampled as.
    fn emitter(&self, _params: &[f32]) -> Emitter {
        Emitter::Bounded
    }
    /// Whether rays meet it in closed form.
    fn closed_form(&self) -> bool {
        false
    }
    /// Whether it is convex, and spans are known in closed form.
    fn is_convex(&self) -> bool {
        false
    }
    /// Where a line is inside; see [`Primitive::span`].
    fn span(&self, _origin: Vec3<f32>, _direction: Vec3<f32>, _params: &[f32]) -> Span<f32> {
        Span::nowhere()
    }
    /// Where eight lines are inside.
    fn span_lanes(&self, _origin: Vec3<f32x8>, _direction: Vec3<f32x8>, _params: &[f32]) -> Span<f32x8> {
        Span::nowhere()
    }
    /// Where a ray first meets it, or [`NO_HIT`]; see [`Primitive::ray`].
    fn ray(&self, _origin: Vec3<f32>, _direction: Vec3<f32>, _params: &[f32]) -> f32 {
        NO_HIT
    }
    /// Where eight rays first meet it.
    fn ray_lanes(&self, _origin: Vec3<f32x8>, _direction: Vec3<f32x8>, _params: &[f32]) -> f32x8 {
        f32x8::splat(NO_HIT)
    }
    /// Whether it follows orbits.
    fn has_orbit(&self) -> bool {
        false
    }
    /// What the orbit of a point comes near to; see [`Primitive::orbit`].
    fn orbit(&self, _p: Vec3<f32>, _params: &[f32]) -> [f32; TRAPS] {
        [0.0; TRAPS]
    }
    /// What the orbits of eight points come near to.
    fn orbit_lanes(&self, _p: Vec3<f32x8>, _params: &[f32]) -> [f32x8; TRAPS] {
        [f32x8::ZERO; TRAPS]
    }
    /// The orbit as a WGSL function `NAME_orbit(p: vec3f, …) -> array<f32, 5>`.
    fn wgsl_orbit(&self) -> String {
        String::new()
    }
    /// The span as a WGSL function `NAME_span(origin: vec3f, direction: vec3f, …) -> vec2f`.
    fn wgsl_span(&self) -> String {
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
    Own(Arc<dyn Shape>),
}

impl Deref for ShapeRef {
    type Target = dyn Shape;
    fn deref(&self) -> &(dyn Shape + 'static) {
        match self {
            Self::Registered(shape) => *shape,
            Self::Own(shape) => &**shape,
        }
    }
}

impl From<&'static dyn Shape> for ShapeRef {
    fn from(shape: &'static dyn Shape) -> Self {
        Self::Registered(shape)
    }
}

/// An [`Operator`] behind a pointer.
pub trait Combine: Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &'static Info;
    /// The parameters, in order; see [`Operator::PARAMS`].
    fn params(&self) -> &'static [Param];
    /// Whether it blends edges over a width.
    fn blends(&self) -> bool;
    /// How many children it needs, and how many it may have.
    fn children(&self) -> (usize, usize);
    /// What it does to solids; see [`Operator::BOOLEAN`].
    fn boolean(&self) -> Option<Boolean>;
    /// The distance of the result; sharp without `blend`.
    fn distance(&self, a: f32, b: f32, blend: Option<Blend>) -> f32;
    /// The distances of eight results.
    fn distance_lanes(&self, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8;
    /// Distance and gradient of the result.
    fn gradient(&self, a: Dual<f32>, b: Dual<f32>, blend: Option<Blend>) -> Dual<f32>;
    /// Distances and gradients of eight results.
    fn gradient_lanes(&self, a: Dual<f32x8>, b: Dual<f32x8>, blend: Option<Blend>) -> Dual<f32x8>;
    /// How much of `b`'s material shows, 0..1.
    fn weight(&self, a: f32, b: f32, blend: Option<Blend>) -> f32;
    /// How much of `b`'s material shows in each of eight results, 0..1.
    fn weight_lanes(&self, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8;
    /// A box that holds the result.
    fn bounds(&self, a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
    /// `NAME_distance`, sharp or of a profile, as a WGSL function.
    fn wgsl_distance(&self, profile: Option<BlendProfile>) -> String;
    /// `NAME_gradient`, sharp or of a profile, as a WGSL function over (xyz gradient, w distance).
    fn wgsl_gradient(&self, profile: Option<BlendProfile>) -> String;
    /// `NAME_weight`, sharp or of a profile, as a WGSL function.
    fn wgsl_weight(&self, profile: Option<BlendProfile>) -> String;
    /// What its WGSL functions' names begin with.
    fn wgsl_name(&self, profile: Option<BlendProfile>) -> String {
        let prefix = profile.filter(|_| self.blends()).map_or(String::new(), |profile| format!("{}_", profile.name()));
        format!("{prefix}{}", self.info().name)
    }
}

impl Debug for dyn Combine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().name)
    }
}

/// A [`Modifier`] behind a pointer.
pub trait Modify: Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &'static Info;
    /// The parameters, in order.
    fn params(&self) -> &'static [Param];
    /// Whether it needs what it holds to have an end.
    fn needs_bounds(&self) -> bool;
    /// Whether it makes solids of profiles.
    fn of_profiles(&self) -> bool;
    /// Whether it may hold profiles.
    fn in_plane(&self) -> bool;
    /// The numbers that the functions below read.
    fn numbers(&self, params: &[f32], inside: Aabb) -> Vec<f32>;
    /// In how many places what it holds must be looked for.
    fn places(&self, params: &[f32], inside: Aabb) -> u32;
    /// Where a point is in the space of what it holds.
    fn point(&self, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<f32>;
    /// Where eight points are.
    fn point_lanes(&self, p: Vec3<f32x8>, place: f32x8, numbers: &[f32]) -> Vec3<f32x8>;
    /// Where a point is, with derivatives.
    fn point_gradient(&self, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<Dual<f32>>;
    /// Where eight points are, with derivatives.
    fn point_gradient_lanes(&self, p: Vec3<f32x8>, place: f32x8, numbers: &[f32]) -> Vec3<Dual<f32x8>>;
    /// The distance of the result.
    fn distance(&self, p: Vec3<f32>, inside: f32, numbers: &[f32]) -> f32;
    /// The distances of eight results.
    fn distance_lanes(&self, p: Vec3<f32x8>, inside: f32x8, numbers: &[f32]) -> f32x8;
    /// Distance and gradient of the result.
    fn gradient(&self, p: Vec3<f32>, inside: Dual<f32>, numbers: &[f32]) -> Dual<f32>;
    /// Distances and gradients of eight results.
    fn gradient_lanes(&self, p: Vec3<f32x8>, inside: Dual<f32x8>, numbers: &[f32]) -> Dual<f32x8>;
    /// A box that holds the result.
    fn bounds(&self, params: &[f32], inside: Aabb) -> Aabb;
    /// The functions `NAME_point`, `NAME_pull` (a gradient back through it), `NAME_distance` and `NAME_gradient` in WGSL.
    fn wgsl(&self) -> String;
    /// What its WGSL functions' names begin with.
    fn wgsl_name(&self) -> String {
        identifier(self.info().name).trim_end_matches('_').to_owned()
    }
}

impl Debug for dyn Modify {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().name)
    }
}

/// Makes a [`Shape`] of a [`Primitive`], a [`Combine`] of an [`Operator`], or a [`Modify`] of a [`Modifier`].
pub(crate) struct Entry<T>(pub(crate) PhantomData<T>);

fn values<N: Real, V: Values<N>>(params: &[f32]) -> V {
    V::from_fn(|k| N::constant(params[k]))
}

fn dual(inputs: &[Expr]) -> Dual<Expr> {
    Dual { value: inputs[3], gradient: Vec3::new(inputs[0], inputs[1], inputs[2]) }
}

fn outputs(result: Dual<Expr>) -> Vec<Expr> {
    vec![result.gradient.x, result.gradient.y, result.gradient.z, result.value]
}

/// The signature of a function of a shape: its points, then its parameters.
fn shape_function(shape: &dyn Shape, suffix: &str, points: &[&'static str], doc: String) -> Function<'static> {
    let points = points.iter().map(|&p| (p, "vec3f"));
    let parameters = points.chain(shape.params().iter().map(|p| (p.name, "f32"))).collect();
    Function { name: format!("{}_{suffix}", shape.wgsl_name()), doc, parameters }
}

/// The n-th point among the inputs of a recorded function.
fn point(inputs: &[Expr], n: usize) -> Vec3<Expr> {
    Vec3::new(inputs[3 * n], inputs[3 * n + 1], inputs[3 * n + 2])
}

/// What the WGSL functions of a shape of this name and variant begin with.
fn shape_name(name: &str, variant: u32) -> String {
    let name = identifier(name);
    let name = name.trim_end_matches('_');
    if variant > 0 { format!("{name}_{variant}") } else { name.to_owned() }
}

impl<T: Primitive> Shape for Entry<T> {
    fn info(&self) -> &Info {
        &T::INFO
    }
    fn params(&self) -> &[Param] {
        T::PARAMS
    }
    fn variant(&self, params: &[f32]) -> Option<&'static dyn Shape> {
        T::variant(values(params))
    }
    fn wgsl_name(&self) -> String {
        shape_name(T::INFO.name, T::VARIANT)
    }
    fn distance(&self, p: Vec3<f32>, params: &[f32]) -> f32 {
        T::distance(p, values(params))
    }
    fn distance_lanes(&self, p: Vec3<f32x8>, params: &[f32]) -> f32x8 {
        T::distance(p, values(params))
    }
    fn gradient(&self, p: Vec3<Dual<f32>>, params: &[f32]) -> Dual<f32> {
        T::distance_compact(p, values(params))
    }
    fn gradient_lanes(&self, p: Vec3<Dual<f32x8>>, params: &[f32]) -> Dual<f32x8> {
        T::distance_compact(p, values(params))
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
    fn closed_form(&self) -> bool {
        T::CLOSED_FORM
    }
    fn is_convex(&self) -> bool {
        T::CONVEX
    }
    fn span(&self, origin: Vec3<f32>, direction: Vec3<f32>, params: &[f32]) -> Span<f32> {
        T::span(origin, direction, values(params))
    }
    fn span_lanes(&self, origin: Vec3<f32x8>, direction: Vec3<f32x8>, params: &[f32]) -> Span<f32x8> {
        T::span(origin, direction, values(params))
    }
    fn ray(&self, origin: Vec3<f32>, direction: Vec3<f32>, params: &[f32]) -> f32 {
        T::ray(origin, direction, values(params))
    }
    fn ray_lanes(&self, origin: Vec3<f32x8>, direction: Vec3<f32x8>, params: &[f32]) -> f32x8 {
        T::ray(origin, direction, values(params))
    }
    fn has_orbit(&self) -> bool {
        T::ORBIT
    }
    fn orbit(&self, p: Vec3<f32>, params: &[f32]) -> [f32; TRAPS] {
        T::orbit(p, values(params))
    }
    fn orbit_lanes(&self, p: Vec3<f32x8>, params: &[f32]) -> [f32x8; TRAPS] {
        T::orbit(p, values(params))
    }
    fn wgsl_orbit(&self) -> String {
        let doc = "What the orbit of `NAME` comes near to: point, line, plane, sphere; share of iterations.";
        shape_function(self, "orbit", &["p"], doc.replace("NAME", T::INFO.name))
            .print(&|inputs| T::orbit(point(inputs, 0), T::Params::from_fn(|k| inputs[3 + k])).to_vec())
    }
    fn wgsl_span(&self) -> String {
        let doc = "Where a line enters and leaves `NAME`, metres.".replace("NAME", T::INFO.name);
        shape_function(self, "span", &["origin", "direction"], doc).print(&|inputs| {
            let params = T::Params::from_fn(|k| inputs[6 + k]);
            let Span { enter, leave } = T::span(point(inputs, 0), point(inputs, 1), params);
            vec![enter, leave]
        })
    }
    fn wgsl_ray(&self) -> String {
        let doc = "Metres to where a ray first meets `NAME`.".replace("NAME", T::INFO.name);
        shape_function(self, "ray", &["origin", "direction"], doc)
            .print(&|inputs| vec![T::ray(point(inputs, 0), point(inputs, 1), T::Params::from_fn(|k| inputs[6 + k]))])
    }
    fn wgsl_distance(&self) -> String {
        shape_function(self, "distance", &["p"], T::INFO.doc.to_owned())
            .print(&|inputs| vec![T::distance_compact(point(inputs, 0), T::Params::from_fn(|k| inputs[3 + k]))])
    }
    fn wgsl_gradient(&self) -> String {
        let doc = "Gradient (xyz) and distance (w) of `NAME`.".replace("NAME", T::INFO.name);
        shape_function(self, "gradient", &["p"], doc).print(&|inputs| {
            let p = Dual::variables(point(inputs, 0));
            outputs(T::distance_compact(p, T::Params::from_fn(|k| Dual::independent(inputs[3 + k]))))
        })
    }
}

/// The signature of a function of an operator, sharp or of a profile.
fn operator_function(
    operator: &dyn Combine,
    suffix: &str,
    kind: &'static str,
    profile: Option<BlendProfile>,
) -> Function<'static> {
    let info = operator.info();
    let doc = match suffix {
        "distance" => info.doc.to_owned(),
        "gradient" => format!("Gradient (xyz) and distance (w) of `{}`.", info.name),
        _ => format!("How much of b's material shows in `{}`, 0..1.", info.name),
    };
    let mut parameters = vec![("a", kind), ("b", kind)];
    if let Some(profile) = profile {
        parameters.push((if operator.blends() { "width" } else { "amount" }, "f32"));
        parameters.extend(profile.has_steps().then_some(("steps", "f32")));
    }
    Function { name: format!("{}_{suffix}", operator.wgsl_name(profile)), doc, parameters }
}

/// The blend whose numbers are the first of these inputs.
fn blending(profile: BlendProfile, inputs: &[Expr]) -> Blending<Expr> {
    Blending { amount: inputs[0], profile, steps: inputs.get(1).copied().unwrap_or(inputs[0]) }
}

impl<T: Operator> Combine for Entry<T> {
    fn info(&self) -> &'static Info {
        &T::INFO
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
    fn distance(&self, a: f32, b: f32, blend: Option<Blend>) -> f32 {
        combine::<T, _>(a, b, blend)
    }
    fn distance_lanes(&self, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8 {
        combine::<T, _>(a, b, blend)
    }
    fn gradient(&self, a: Dual<f32>, b: Dual<f32>, blend: Option<Blend>) -> Dual<f32> {
        combine::<T, _>(a, b, blend)
    }
    fn gradient_lanes(&self, a: Dual<f32x8>, b: Dual<f32x8>, blend: Option<Blend>) -> Dual<f32x8> {
        combine::<T, _>(a, b, blend)
    }
    fn weight(&self, a: f32, b: f32, blend: Option<Blend>) -> f32 {
        weight::<T, _>(a, b, blend)
    }
    fn weight_lanes(&self, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8 {
        weight::<T, _>(a, b, blend)
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
            let (a, b) = (dual(&inputs[0..4]), dual(&inputs[4..8]));
            outputs(match profile {
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
    fn point(&self, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<f32> {
        T::point(p, place, values(numbers))
    }
    fn point_lanes(&self, p: Vec3<f32x8>, place: f32x8, numbers: &[f32]) -> Vec3<f32x8> {
        T::point(p, place, values(numbers))
    }
    fn point_gradient(&self, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<Dual<f32>> {
        T::point(Dual::variables(p), Dual::independent(place), values(numbers))
    }
    fn point_gradient_lanes(&self, p: Vec3<f32x8>, place: f32x8, numbers: &[f32]) -> Vec3<Dual<f32x8>> {
        T::point(Dual::variables(p), Dual::independent(place), values(numbers))
    }
    fn distance(&self, p: Vec3<f32>, inside: f32, numbers: &[f32]) -> f32 {
        T::distance(p, inside, values(numbers))
    }
    fn distance_lanes(&self, p: Vec3<f32x8>, inside: f32x8, numbers: &[f32]) -> f32x8 {
        T::distance(p, inside, values(numbers))
    }
    fn gradient(&self, p: Vec3<f32>, inside: Dual<f32>, numbers: &[f32]) -> Dual<f32> {
        T::distance(Dual::variables(p), inside, values(numbers))
    }
    fn gradient_lanes(&self, p: Vec3<f32x8>, inside: Dual<f32x8>, numbers: &[f32]) -> Dual<f32x8> {
        T::distance(Dual::variables(p), inside, values(numbers))
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
                    let q = T::point(point(inputs, 0), inputs[3], plain(numbers));
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
                    let p = Dual::variables(point(inputs, 0));
                    let g =
                        T::point(p, Dual::independent(inputs[3]), independent(numbers)).pulled(point(&inputs[4..], 0));
                    vec![g.x, g.y, g.z]
                },
            ),
            modifier_function(
                self,
                "distance",
                &[("p", "vec3f"), ("inside", "f32")],
                T::INFO.doc.to_owned(),
                count,
                &|inputs, numbers| vec![T::distance(point(inputs, 0), inputs[3], plain(numbers))],
            ),
            modifier_function(
                self,
                "gradient",
                &[("p", "vec3f"), ("inside", "vec4f")],
                format!("Gradient (xyz) and distance (w) of `{name}`."),
                count,
                &|inputs, numbers| {
                    let p = Dual::variables(point(inputs, 0));
                    outputs(T::distance(p, dual(&inputs[3..7]), independent(numbers)))
                },
            ),
        ];
        functions.join("\n")
    }
}

impl Blend {
    fn over<N: Real>(self) -> Blending<N> {
        Blending { amount: N::constant(self.amount), profile: self.profile, steps: N::constant(self.steps) }
    }
}

fn combine<T: Operator, N: Real>(a: N, b: N, blend: Option<Blend>) -> N {
    match blend {
        Some(blend) => T::blended(a, b, blend.over()),
        None => T::sharp(a, b),
    }
}

fn weight<T: Operator, N: Real>(a: N, b: N, blend: Option<Blend>) -> N {
    match blend {
        Some(blend) => T::blended_weight(a, b, blend.over()),
        None => T::sharp_weight(a, b),
    }
}

/// Every shape, in the order of `shapes/mod.rs`.
pub fn shapes() -> &'static [&'static dyn Shape] {
    crate::shapes::ALL
}

/// Every operator, in the order of `operators/mod.rs`.
pub fn operators() -> &'static [&'static dyn Combine] {
    crate::operators::ALL
}

/// Every modifier, in the order of `modifiers/mod.rs`.
pub fn modifiers() -> &'static [&'static dyn Modify] {
    crate::modifiers::ALL
}

/// Anything that stands in an object.
#[derive(Clone, Copy, Debug)]
pub enum Solid<'a> {
    /// A shape.
    Shape(&'a (dyn Shape + 'static)),
    /// An operator of several solids.
    Combine(&'static dyn Combine),
    /// An operator that changes what it holds.
    Modify(&'static dyn Modify),
}

impl<'a> Solid<'a> {
    /// Name, documentation, source.
    pub fn info(self) -> &'a Info {
        match self {
            Self::Shape(shape) => shape.info(),
            Self::Combine(operator) => operator.info(),
            Self::Modify(modifier) => modifier.info(),
        }
    }
    /// The parameters, in order.
    pub fn params(self) -> &'a [Param] {
        match self {
            Self::Shape(shape) => shape.params(),
            Self::Combine(operator) => operator.params(),
            Self::Modify(modifier) => modifier.params(),
        }
    }
    /// Whether it holds solids.
    pub fn is_operator(self) -> bool {
        !matches!(self, Self::Shape(_))
    }
}

/// Every shape, operator and modifier.
pub fn solids() -> impl Iterator<Item = Solid<'static>> {
    let shapes = shapes().iter().map(|shape| Solid::Shape(*shape));
    let operators = operators().iter().map(|operator| Solid::Combine(*operator));
    shapes.chain(operators).chain(modifiers().iter().map(|modifier| Solid::Modify(*modifier)))
}

/// The shape, operator or modifier of this name.
pub fn solid(name: &str) -> Option<Solid<'static>> {
    solids().find(|solid| solid.info().name == name)
}

/// The shape of this name.
pub fn shape(name: &str) -> Option<&'static dyn Shape> {
    shapes().iter().copied().find(|shape| shape.info().name == name)
}

/// The operator that joins what no other joins.
pub fn union() -> &'static dyn Combine {
    crate::operators::UNION
}

/// The operator of this name.
pub fn operator(name: &str) -> Option<&'static dyn Combine> {
    operators().iter().copied().find(|operator| operator.info().name == name)
}
