//! A scene's field: shapes placed in space and combined.
//!
//! People write a tree of [`Node`]s. [`Field::new`] moves every placement down to the leaves (a solid's distance under a
//! similarity is its distance in local coordinates times the scale; Hart 1996, section 2.3), so that a leaf is one
//! transform away from the world, and evaluates the tree for one point or eight. [`crate::wgsl::Program`] prints the same
//! tree for the GPU. Cost of an evaluation: one virtual call and one transform for each leaf.

pub(crate) mod bvh;
mod coordinates;
pub(crate) mod crowd;
mod solids;

use crate::blend::Blend;
use crate::bounds::Aabb;
use crate::number::{Differentiable, Dual, Mask8, Real, Vec3};
use crate::registry::{Combine, Modify, NO_HIT, Shape, ShapeRef, Span, TRAPS, union};
use bvh::Bvh;
pub use coordinates::Coordinates;
use crowd::{Afar, Crowd};
use glam::{EulerRot, Mat3, Quat};
use wide::f32x8;

/// Where a node stands: scale first, then turn, then move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Direction that the shape's +y is turned to, before everything else; any length but zero.
    pub normal: Option<[f32; 3]>,
    /// Uniform factor, above zero.
    pub scale: Option<f32>,
    /// Degrees about the fixed x, then y, then z axis, right-handed.
    pub rotate: Option<[f32; 3]>,
    /// Position, metres.
    pub at: Option<[f32; 3]>,
}

impl Placement {
    /// The coordinates of what stands there.
    pub fn pose(&self) -> Pose {
        Frame::WORLD.inside(self).pose()
    }
}

/// One shape or operator of the tree people write.
#[derive(Clone, Debug)]
pub struct Node {
    /// What it is.
    pub kind: Kind,
    /// Where it stands, relative to its parent.
    pub placement: Placement,
}

/// What a [`Node`] is.
#[derive(Clone, Debug)]
pub enum Kind {
    /// A shape and its numbers, in the order of [`Shape::params`].
    Shape {
        /// The shape.
        shape: ShapeRef,
        /// Its numbers.
        params: Vec<f32>,
        /// Whatever the caller wants to know of a hit here; the scene keeps the material in it.
        tag: u32,
    },
    /// An operator over its children, folded from the first to the last.
    Combine {
        /// The operator.
        operator: &'static dyn Combine,
        /// How it blends; sharp when absent.
        smooth: Option<Blend>,
        /// At least one.
        children: Vec<Node>,
    },
    /// An operator that changes the union of its children.
    Modify {
        /// The operator.
        modifier: &'static dyn Modify,
        /// Its numbers, in the order of [`Modify::params`].
        params: Vec<f32>,
        /// At least one.
        children: Vec<Node>,
    },
}

/// How local coordinates are scaled and turned; decides which code is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Turn {
    /// Neither.
    None,
    /// Scaled only.
    Scaled,
    /// Turned, perhaps scaled.
    Turned,
}

/// Local coordinates: where a shape stands in the world, or in the space of the modifier that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Whether any placement moves it.
    pub moved: bool,
    /// Whether any placement scales or turns it.
    pub turn: Turn,
    /// Origin of the local coordinates, metres.
    pub at: [f32; 3],
    /// Size of a local unit, metres.
    pub scale: f32,
    /// The local axes x, y, z in the world, each of length one.
    pub axes: [[f32; 3]; 3],
}

/// A shape of the field.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// The shape.
    pub shape: ShapeRef,
    /// What it reads: [`Shape::numbers`].
    pub params: Vec<f32>,
    /// The tag of its node.
    pub tag: u32,
    /// Index of the object it belongs to.
    pub object: u32,
    /// Where it stands.
    pub pose: Pose,
    /// Whether that is in the space of a modifier, not in the world.
    pub modified: bool,
    /// Whether rays meet it in closed form from within: it is taken away from its object.
    pub hollow: bool,
}

impl Leaf {
    fn distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let distance = N::shape_distance(&*self.shape, self.pose.local(p), &self.params);
        self.pose.length(distance)
    }

    fn ray<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> N {
        let t = N::shape_ray(&*self.shape, self.pose.local(origin), self.pose.turned(direction), &self.params);
        self.pose.length(t)
    }

    fn span<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> Span<N> {
        let (origin, direction) = (self.pose.local(origin), self.pose.turned(direction));
        let Span { enter, leave } = N::shape_span(&*self.shape, origin, direction, &self.params);
        Span { enter: self.pose.length(enter), leave: self.pose.length(leave) }
    }

    fn surface<N: Batch>(&self, p: Vec3<N>) -> Dual<N> {
        let local = N::shape_gradient(&*self.shape, Dual::variables(self.pose.local(p)), &self.params);
        self.pose.world(local)
    }
}

impl Pose {
    /// Rows of the matrix from world offsets to local coordinates.
    pub fn local_from_world(&self) -> [[f32; 3]; 3] {
        self.axes.map(|axis| axis.map(|v| v / self.scale))
    }

    fn local<N: Real>(&self, p: Vec3<N>) -> Vec3<N> {
        let offset = if self.moved { p - Vec3::constant(self.at) } else { p };
        match self.turn {
            Turn::None => offset,
            Turn::Scaled => offset * N::constant(1.0 / self.scale),
            Turn::Turned => {
                let inverse = N::constant(1.0 / self.scale);
                let [x, y, z] = self.axes.map(|axis| Vec3::constant(axis).dot(offset) * inverse);
                Vec3::new(x, y, z)
            }
        }
    }

    /// A direction in local axes; its length stays.
    fn turned<N: Real>(&self, direction: Vec3<N>) -> Vec3<N> {
        if self.turn != Turn::Turned {
            return direction;
        }
        let [x, y, z] = self.axes.map(|axis| Vec3::constant(axis).dot(direction));
        Vec3::new(x, y, z)
    }

    /// A length in local coordinates as one in the world.
    fn length<N: Real>(&self, local: N) -> N {
        if self.turn == Turn::None { local } else { local * N::constant(self.scale) }
    }

    /// A distance and its gradient in local coordinates as those in the world.
    fn world<N: Real>(&self, local: Dual<N>) -> Dual<N> {
        let value = self.length(local.value);
        if self.turn != Turn::Turned {
            return Dual { value, gradient: local.gradient };
        }
        let [x, y, z] = self.axes.map(Vec3::constant);
        let g = local.gradient;
        Dual { value, gradient: x * g.x + y * g.y + z * g.z }
    }

    /// A box in the world that holds what this local box holds.
    fn world_bounds(&self, local: Aabb) -> Aabb {
        if self.turn != Turn::Turned {
            let place = |v: [f32; 3]| std::array::from_fn(|k| v[k] * self.scale + self.at[k]);
            return Aabb { min: place(local.min), max: place(local.max) };
        }
        // Each edge of the box spans an interval along each axis of the world; one across that axis does not reach along it.
        let mut bounds = Aabb { min: self.at, max: self.at };
        for (axis, k) in (0..3).flat_map(|axis| (0..3).map(move |k| (axis, k))) {
            let along = self.scale * self.axes[axis][k];
            if along != 0.0 {
                let (a, b) = (along * local.min[axis], along * local.max[axis]);
                bounds.min[k] += a.min(b);
                bounds.max[k] += a.max(b);
            }
        }
        bounds
    }
}

/// The tree with placements moved to the leaves.
#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Leaf(u32),
    /// Operator, blend in world metres, children, number of its first choice.
    Combine {
        operator: &'static dyn Combine,
        smooth: Option<Blend>,
        children: Vec<Tree>,
        first_choice: u32,
    },
    Modify(Box<Modified>),
}

/// What a modifier holds, in its space.
#[derive(Clone, Debug)]
pub(crate) struct Modified {
    pub(crate) modifier: &'static dyn Modify,
    /// Counts the modifiers of the field, those inside first.
    pub(crate) index: u32,
    /// What it reads.
    pub(crate) numbers: Vec<f32>,
    pub(crate) places: u32,
    pub(crate) pose: Pose,
    pub(crate) inside: Tree,
    params: Vec<f32>,
    inside_bounds: Aabb,
}

/// The nearest surface as seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface<N> {
    /// Distance and its gradient.
    pub field: Dual<N>,
    /// Index into [`Field::leaves`] of the leaf whose material shows, as a number.
    pub leaf: N,
}

/// Everything of a scene, as one signed distance field: the union of its objects.
///
/// Rays meet an object that is a single shape with a closed form ([`Shape::closed_form`]) directly; the others must be
/// marched. [`distance`](Self::distance) is over all, [`marched_distance`](Self::marched_distance) over the latter.
#[derive(Clone, Debug)]
pub struct Field {
    leaves: Vec<Leaf>,
    objects: Vec<Tree>,
    /// Whether nothing is met in closed form.
    marches_all: bool,
    bounds: Aabb,
    object_bounds: Vec<Aabb>,
    marched_bounds: Aabb,
    /// How each object is evaluated.
    roles: Vec<Role>,
    crowds: Vec<Crowd>,
    /// Over many objects of closed form.
    bvh: Bvh,
    /// How many choices and modifiers there are so far.
    choices: u32,
    modifiers: u32,
}

/// Stands for the leaf where a ray met none of closed form.
pub const MARCHED: f32 = -1.0;

/// How an object is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// By itself: rays meet it in closed form.
    Direct,
    /// By itself: marched as code.
    Marched,
    /// It is the crowd of this number.
    Crowd(usize),
    /// Its one shape is in a crowd of such objects.
    InCrowd,
    /// Its one shape is met in closed form, by way of the hierarchy.
    InBvh,
}

/// A number that a [`Field`] can be evaluated over on the CPU.
pub trait Batch: Differentiable {
    /// One seed for each point.
    type Seeds: Copy;
    /// How many points.
    #[doc(hidden)]
    const LANES: usize;
    #[doc(hidden)]
    fn any(mask: Self::Mask) -> bool;
    #[doc(hidden)]
    fn lanes(self) -> [f32; 8];
    #[doc(hidden)]
    fn from_lanes(lanes: [f32; 8]) -> Self;
    #[doc(hidden)]
    fn shape_distance(shape: &dyn Shape, p: Vec3<Self>, params: &[f32]) -> Self;
    #[doc(hidden)]
    fn shape_gradient(shape: &dyn Shape, p: Vec3<Dual<Self>>, params: &[f32]) -> Dual<Self>;
    #[doc(hidden)]
    fn shape_ray(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Self;
    #[doc(hidden)]
    fn shape_span(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Span<Self>;
    #[doc(hidden)]
    fn modified_point(modifier: &dyn Modify, p: Vec3<Self>, place: Self, numbers: &[f32]) -> Vec3<Self>;
    #[doc(hidden)]
    fn modified_point_gradient(modifier: &dyn Modify, p: Vec3<Self>, place: Self, numbers: &[f32]) -> Vec3<Dual<Self>>;
    #[doc(hidden)]
    fn modified(modifier: &dyn Modify, p: Vec3<Self>, inside: Self, numbers: &[f32]) -> Self;
    #[doc(hidden)]
    fn modified_gradient(modifier: &dyn Modify, p: Vec3<Self>, inside: Dual<Self>, numbers: &[f32]) -> Dual<Self>;
    #[doc(hidden)]
    fn combined(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self;
    #[doc(hidden)]
    fn combined_gradient(operator: &dyn Combine, a: Dual<Self>, b: Dual<Self>, blend: Option<Blend>) -> Dual<Self>;
    #[doc(hidden)]
    fn weight(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self;
    /// A uniform number in 0..1 for the choice of this index at each point.
    #[doc(hidden)]
    fn choice(seeds: Self::Seeds, index: u32) -> Self;
}

impl Batch for f32 {
    type Seeds = u32;
    const LANES: usize = 1;
    fn any(mask: bool) -> bool {
        mask
    }
    fn lanes(self) -> [f32; 8] {
        [self; 8]
    }
    fn from_lanes(lanes: [f32; 8]) -> f32 {
        lanes[0]
    }
    fn shape_distance(shape: &dyn Shape, p: Vec3<f32>, params: &[f32]) -> f32 {
        shape.distance(p, params)
    }
    fn shape_gradient(shape: &dyn Shape, p: Vec3<Dual<f32>>, params: &[f32]) -> Dual<f32> {
        shape.gradient(p, params)
    }
    fn shape_ray(shape: &dyn Shape, origin: Vec3<f32>, direction: Vec3<f32>, params: &[f32]) -> f32 {
        shape.ray(origin, direction, params)
    }
    fn shape_span(shape: &dyn Shape, origin: Vec3<f32>, direction: Vec3<f32>, params: &[f32]) -> Span<f32> {
        shape.span(origin, direction, params)
    }
    fn modified_point(modifier: &dyn Modify, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<f32> {
        modifier.point(p, place, numbers)
    }
    fn modified_point_gradient(modifier: &dyn Modify, p: Vec3<f32>, place: f32, numbers: &[f32]) -> Vec3<Dual<f32>> {
        modifier.point_gradient(p, place, numbers)
    }
    fn modified(modifier: &dyn Modify, p: Vec3<f32>, inside: f32, numbers: &[f32]) -> f32 {
        modifier.distance(p, inside, numbers)
    }
    fn modified_gradient(modifier: &dyn Modify, p: Vec3<f32>, inside: Dual<f32>, numbers: &[f32]) -> Dual<f32> {
        modifier.gradient(p, inside, numbers)
    }
    fn combined(operator: &dyn Combine, a: f32, b: f32, blend: Option<Blend>) -> f32 {
        operator.distance(a, b, blend)
    }
    fn combined_gradient(operator: &dyn Combine, a: Dual<f32>, b: Dual<f32>, blend: Option<Blend>) -> Dual<f32> {
        operator.gradient(a, b, blend)
    }
    fn weight(operator: &dyn Combine, a: f32, b: f32, blend: Option<Blend>) -> f32 {
        operator.weight(a, b, blend)
    }
    fn choice(seed: u32, index: u32) -> f32 {
        // PCG output hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"); the WGSL twin is in compose.rs.
        let state = (seed ^ index.wrapping_mul(0x9e37_79b9)).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }
}

impl Batch for f32x8 {
    type Seeds = [u32; 8];
    const LANES: usize = 8;
    fn any(mask: Mask8) -> bool {
        mask.0.to_bitmask() != 0
    }
    fn lanes(self) -> [f32; 8] {
        self.to_array()
    }
    fn from_lanes(lanes: [f32; 8]) -> f32x8 {
        f32x8::from(lanes)
    }
    fn shape_distance(shape: &dyn Shape, p: Vec3<f32x8>, params: &[f32]) -> f32x8 {
        shape.distance_lanes(p, params)
    }
    fn shape_gradient(shape: &dyn Shape, p: Vec3<Dual<f32x8>>, params: &[f32]) -> Dual<f32x8> {
        shape.gradient_lanes(p, params)
    }
    fn shape_ray(shape: &dyn Shape, origin: Vec3<f32x8>, direction: Vec3<f32x8>, params: &[f32]) -> f32x8 {
        shape.ray_lanes(origin, direction, params)
    }
    fn shape_span(shape: &dyn Shape, origin: Vec3<f32x8>, direction: Vec3<f32x8>, params: &[f32]) -> Span<f32x8> {
        shape.span_lanes(origin, direction, params)
    }
    fn modified_point(modifier: &dyn Modify, p: Vec3<f32x8>, place: f32x8, numbers: &[f32]) -> Vec3<f32x8> {
        modifier.point_lanes(p, place, numbers)
    }
    fn modified_point_gradient(
        modifier: &dyn Modify,
        p: Vec3<f32x8>,
        place: f32x8,
        numbers: &[f32],
    ) -> Vec3<Dual<f32x8>> {
        modifier.point_gradient_lanes(p, place, numbers)
    }
    fn modified(modifier: &dyn Modify, p: Vec3<f32x8>, inside: f32x8, numbers: &[f32]) -> f32x8 {
        modifier.distance_lanes(p, inside, numbers)
    }
    fn modified_gradient(modifier: &dyn Modify, p: Vec3<f32x8>, inside: Dual<f32x8>, numbers: &[f32]) -> Dual<f32x8> {
        modifier.gradient_lanes(p, inside, numbers)
    }
    fn combined(operator: &dyn Combine, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8 {
        operator.distance_lanes(a, b, blend)
    }
    fn combined_gradient(operator: &dyn Combine, a: Dual<f32x8>, b: Dual<f32x8>, blend: Option<Blend>) -> Dual<f32x8> {
        operator.gradient_lanes(a, b, blend)
    }
    fn weight(operator: &dyn Combine, a: f32x8, b: f32x8, blend: Option<Blend>) -> f32x8 {
        operator.weight_lanes(a, b, blend)
    }
    fn choice(seeds: [u32; 8], index: u32) -> f32x8 {
        f32x8::from(seeds.map(|seed| f32::choice(seed, index)))
    }
}

/// A placement under its parents: a similarity of the world, and which parts of it were written.
#[derive(Clone, Copy)]
struct Frame {
    at: glam::Vec3,
    turn: Quat,
    scale: f32,
    moved: bool,
    kind: Turn,
}

impl Frame {
    const WORLD: Self = Self { at: glam::Vec3::ZERO, turn: Quat::IDENTITY, scale: 1.0, moved: false, kind: Turn::None };

    fn inside(self, placement: &Placement) -> Self {
        let mut frame = self;
        if let Some(at) = placement.at {
            frame.at += self.turn * (glam::Vec3::from(at) * self.scale);
            frame.moved = true;
        }
        if let Some([x, y, z]) = placement.rotate {
            // Fixed axes x, then y, then z: the matrix is Rz·Ry·Rx.
            let turn = Quat::from_euler(EulerRot::ZYX, z.to_radians(), y.to_radians(), x.to_radians());
            frame.turn = (frame.turn * turn).normalize();
            frame.kind = Turn::Turned;
        }
        if let Some(scale) = placement.scale {
            frame.scale *= scale;
            if frame.kind == Turn::None {
                frame.kind = Turn::Scaled;
            }
        }
        if let Some(normal) = placement.normal {
            let normal = glam::Vec3::from(normal).normalize_or(glam::Vec3::Y);
            frame.turn = (frame.turn * Quat::from_rotation_arc(glam::Vec3::Y, normal)).normalize();
            frame.kind = Turn::Turned;
        }
        frame
    }

    fn pose(self) -> Pose {
        let axes = Mat3::from_quat(self.turn);
        Pose {
            moved: self.moved,
            turn: self.kind,
            at: self.at.into(),
            scale: self.scale,
            axes: [axes.x_axis.into(), axes.y_axis.into(), axes.z_axis.into()],
        }
    }
}

impl Field {
    /// The union of `objects`. A [`Kind::Combine`] without children is left out.
    pub fn new(objects: &[Node]) -> Self {
        Self::with_crowds_from(objects, crowd::LEAST)
    }

    /// [`new`](Self::new), where so many shapes are a crowd.
    #[doc(hidden)]
    pub fn with_crowds_from(objects: &[Node], least: usize) -> Self {
        Self::of(objects, least, false)
    }

    /// [`new`](Self::new), where nothing is met in closed form and nothing is a crowd.
    #[doc(hidden)]
    pub fn all_marched(objects: &[Node]) -> Self {
        Self::of(objects, usize::MAX, true)
    }

    fn of(objects: &[Node], least: usize, marches_all: bool) -> Self {
        let mut field = Self {
            marches_all,
            leaves: Vec::new(),
            objects: Vec::new(),
            bounds: Aabb::NOTHING,
            object_bounds: Vec::new(),
            marched_bounds: Aabb::NOTHING,
            roles: Vec::new(),
            crowds: Vec::new(),
            bvh: Bvh::default(),
            choices: 0,
            modifiers: 0,
        };
        for (index, object) in objects.iter().enumerate() {
            if let Some(tree) = field.add(object, Frame::WORLD, index as u32, false) {
                let bounds = field.tree_bounds(&tree);
                field.bounds = field.bounds.union(bounds);
                field.object_bounds.push(bounds);
                if field.is_direct(&tree) {
                    field.roles.push(Role::Direct);
                    field.mark_hollow(&tree, false);
                } else {
                    field.roles.push(Role::Marched);
                    field.marched_bounds = field.marched_bounds.union(bounds);
                }
                field.objects.push(tree);
            }
        }
        field.gather(least);
        field
    }

    fn add(&mut self, node: &Node, frame: Frame, object: u32, modified: bool) -> Option<Tree> {
        let frame = frame.inside(&node.placement);
        match &node.kind {
            Kind::Shape { shape, params, tag } => {
                self.leaves.push(Leaf {
                    shape: shape.variant(params).map_or_else(|| shape.clone(), ShapeRef::from),
                    params: shape.numbers(params),
                    tag: *tag,
                    object,
                    pose: frame.pose(),
                    modified,
                    hollow: false,
                });
                Some(Tree::Leaf(self.leaves.len() as u32 - 1))
            }
            Kind::Combine { operator, smooth, children } => {
                let scale = if operator.blends() { frame.scale } else { 1.0 };
                let smooth = smooth.map(|blend| Blend { amount: blend.amount * scale, ..blend });
                self.combine(*operator, smooth, children, frame, object, modified)
            }
            Kind::Modify { modifier, params, children } => {
                let inside = self.combine(union(), None, children, Frame::WORLD, object, true)?;
                // An intersection may hold nothing, and a box that holds nothing has no corners.
                let inside_bounds = Some(self.tree_bounds(&inside)).filter(|bounds| !bounds.is_empty());
                let inside_bounds = inside_bounds.unwrap_or(Aabb::centred(0.0, 0.0, 0.0));
                self.modifiers += 1;
                Some(Tree::Modify(Box::new(Modified {
                    modifier: *modifier,
                    index: self.modifiers - 1,
                    numbers: modifier.numbers(params, inside_bounds),
                    places: modifier.places(params, inside_bounds),
                    pose: frame.pose(),
                    inside,
                    params: params.clone(),
                    inside_bounds,
                })))
            }
        }
    }

    fn combine(
        &mut self,
        operator: &'static dyn Combine,
        smooth: Option<Blend>,
        children: &[Node],
        frame: Frame,
        object: u32,
        modified: bool,
    ) -> Option<Tree> {
        let mut children: Vec<Tree> =
            children.iter().filter_map(|child| self.add(child, frame, object, modified)).collect();
        let first_choice = self.choices;
        self.choices += children.len() as u32;
        match children.len() {
            0 => None,
            1 => children.pop(),
            _ => Some(Tree::Combine { operator, smooth, children, first_choice }),
        }
    }

    /// The shapes in the order they were written.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }
    /// A box that holds every solid.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
    /// A box that holds each object.
    pub fn object_bounds(&self) -> &[Aabb] {
        &self.object_bounds
    }
    /// A box that holds every solid that must be marched; [`Aabb::NOTHING`] where there is none.
    pub fn marched_bounds(&self) -> Aabb {
        self.marched_bounds
    }
    /// The shape of an object that is a single one which rays meet in closed form.
    pub(crate) fn direct(&self, object: &Tree) -> Option<u32> {
        match object {
            Tree::Leaf(index) if !self.marches_all && self.leaves[*index as usize].shape.closed_form() => Some(*index),
            _ => None,
        }
    }
    /// Whether the leaf of this number is an object by itself, which rays meet in closed form.
    pub fn is_whole(&self, leaf: usize) -> bool {
        let object = self.leaves.get(leaf).and_then(|leaf| self.objects.get(leaf.object as usize));
        object.is_some_and(|object| self.direct(object).is_some())
    }
    /// Whether rays meet the object of this leaf in closed form.
    pub fn is_met_directly(&self, leaf: usize) -> bool {
        let role = self.leaves.get(leaf).and_then(|leaf| self.roles.get(leaf.object as usize));
        matches!(role, Some(Role::Direct | Role::InBvh))
    }
    /// What the orbit of a point of the world comes near to on the leaf of this number: [`Shape::orbit`], where the leaf is a
    /// fractal.
    pub fn orbit(&self, leaf: usize, p: Vec3<f32>) -> Option<[f32; TRAPS]> {
        let shape = self.leaves.get(leaf).filter(|leaf| leaf.shape.has_orbit())?;
        Some(shape.shape.orbit(self.coordinates(leaf, p)?.point, &shape.params))
    }
    /// A box in the world that holds the leaf of this number, if there is one: of one that a modifier holds, the box of its
    /// object.
    pub fn leaf_bounds(&self, leaf: usize) -> Aabb {
        let Some(leaf) = self.leaves.get(leaf) else { return Aabb::NOTHING };
        match leaf.modified {
            false => leaf.pose.world_bounds(leaf.shape.bounds(&leaf.params)),
            true => self.object_bounds.get(leaf.object as usize).copied().unwrap_or(Aabb::EVERYTHING),
        }
    }
    /// An upper bound of |∇distance|: operators and placements keep the largest of the leaves'.
    pub fn lipschitz(&self) -> f32 {
        self.objects.iter().map(|object| self.tree_lipschitz(object)).fold(1.0, f32::max)
    }

    fn tree_lipschitz(&self, tree: &Tree) -> f32 {
        match tree {
            Tree::Leaf(leaf) => {
                let leaf = &self.leaves[*leaf as usize];
                leaf.shape.lipschitz(&leaf.params)
            }
            Tree::Combine { children, .. } => {
                children.iter().map(|child| self.tree_lipschitz(child)).fold(1.0, f32::max)
            }
            Tree::Modify(modified) => self.tree_lipschitz(&modified.inside),
        }
    }

    fn tree_bounds(&self, tree: &Tree) -> Aabb {
        match tree {
            Tree::Leaf(leaf) => {
                let leaf = &self.leaves[*leaf as usize];
                leaf.pose.world_bounds(leaf.shape.bounds(&leaf.params))
            }
            Tree::Modify(modified) => {
                modified.pose.world_bounds(modified.modifier.bounds(&modified.params, modified.inside_bounds))
            }
            Tree::Combine { operator, smooth, children, .. } if crowd::joins(*operator) => children
                .iter()
                .map(|child| self.tree_bounds(child))
                .fold(Aabb::NOTHING, Aabb::union)
                .expanded(crowd::growth(*smooth, children.len())),
            Tree::Combine { operator, smooth, children, .. } => children
                .iter()
                .map(|child| self.tree_bounds(child))
                .reduce(|a, b| operator.bounds(a, b, *smooth))
                .unwrap_or(Aabb::NOTHING),
        }
    }

    /// Signed distance from each point to the nearest surface, metres; infinite in an empty scene.
    pub fn distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for distance in self.object_distances(p) {
            nearest = nearest.min(distance);
        }
        nearest
    }

    /// [`distance`](Self::distance), which far from unions of many shapes need only be about right: what shading asks for.
    pub fn estimated_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.alone() {
            nearest = nearest.min(self.tree_distance(object, p));
        }
        for crowd in &self.crowds {
            nearest = nearest.min(crowd.distance(self, p, Afar::Estimate));
        }
        self.bvh.distance(self, p, nearest, |_| true, N::constant(MARCHED))
    }

    /// Distance to the nearest surface that must be marched, from outside or inside; infinite where there is none. Every
    /// object keeps its own surface: what lies inside a clear one is seen.
    pub fn marched_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.marched_alone() {
            nearest = nearest.min(self.tree_distance(object, p).abs());
        }
        for crowd in &self.crowds {
            nearest = nearest.min(crowd.distance(self, p, Afar::Bound).abs());
        }
        nearest
    }

    /// Distance from each point to the nearest surface of the objects that count, from outside or inside; infinite where
    /// there is none. `counts` has one entry for each object, in their order. The object whose only leaf has the number `own`
    /// does not count if it has a closed form: it is convex, so that nothing of it is before its own surface.
    pub fn distance_to<N: Batch>(&self, p: Vec3<N>, counts: &[bool], own: N) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for (object, _) in self.alone_with(counts).filter(|(_, counts)| *counts) {
            let closer = nearest.min(self.tree_distance(object, p).abs());
            nearest = match self.direct(object) {
                Some(leaf) => {
                    let is_own = (own - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                    N::select(is_own, nearest, closer)
                }
                None => closer,
            };
        }
        for crowd in self.crowds_that_count(counts) {
            nearest = nearest.min(self.crowds[crowd].distance(self, p, Afar::Estimate).abs());
        }
        let leaf_counts = |leaf: u32| counts.get(self.leaves[leaf as usize].object as usize) == Some(&true);
        self.bvh.distance(self, p, nearest, leaf_counts, own)
    }

    /// Signed distance from each point to each object, in their order, metres.
    pub fn object_distances<N: Batch>(&self, p: Vec3<N>) -> impl Iterator<Item = N> {
        self.objects.iter().zip(&self.roles).map(move |(object, role)| match role {
            Role::Crowd(crowd) => self.crowds[*crowd].distance(self, p, Afar::Exact),
            _ => self.tree_distance(object, p),
        })
    }

    /// Metres along each unit vector `direction` to the first surface of the objects that are met in closed form, or
    /// [`NO_HIT`]; and the number of its leaf, or [`MARCHED`].
    pub fn direct_hit<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> (N, N) {
        let mut hit = (N::constant(NO_HIT), N::constant(MARCHED));
        for object in self.direct_alone() {
            hit = self.object_hit(object, origin, direction, hit);
        }
        self.bvh.hit(self, origin, direction, hit)
    }

    fn tree_distance<N: Batch>(&self, tree: &Tree, p: Vec3<N>) -> N {
        match tree {
            Tree::Leaf(leaf) => self.leaves[*leaf as usize].distance(p),
            Tree::Modify(modified) => {
                let p = modified.pose.local(p);
                let (inside, _) = self.nearest_inside(modified, p);
                modified.pose.length(N::modified(modified.modifier, p, inside, &modified.numbers))
            }
            Tree::Combine { operator, smooth, children, .. } => {
                let mut result = self.tree_distance(&children[0], p);
                for child in &children[1..] {
                    result = N::combined(*operator, result, self.tree_distance(child, p), *smooth);
                }
                result
            }
        }
    }

    /// The least distance of what a modifier holds at the points of `p`, and the number of that point.
    fn nearest_inside<N: Batch>(&self, modified: &Modified, p: Vec3<N>) -> (N, N) {
        let mut nearest = (N::constant(f32::INFINITY), N::zero());
        for place in 0..modified.places {
            let place = N::constant(place as f32);
            let point = N::modified_point(modified.modifier, p, place, &modified.numbers);
            let distance = self.tree_distance(&modified.inside, point);
            nearest.1 = N::select(distance.lt(nearest.0), place, nearest.1);
            nearest.0 = nearest.0.min(distance);
        }
        nearest
    }

    /// The nearest surface of an object from each point: signed distance to that object, gradient, and the leaf whose
    /// material shows. Where smooth operators blend materials, one of them is chosen with the probability of its weight,
    /// by the point's seed.
    pub fn surface<N: Batch>(&self, p: Vec3<N>, seeds: N::Seeds) -> Surface<N> {
        self.nearest_surface(p, |_| N::truth(true), &|index| N::choice(seeds, index), Afar::Exact)
    }

    /// The surface of the union at each point: of the object whose signed distance is least, as in
    /// [`distance`](Self::distance). Thresholds are as in [`surface_met`](Self::surface_met).
    pub fn union_surface<N: Batch>(&self, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let mut least = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (object, role) in self.objects.iter().zip(&self.roles) {
            let surface = match role {
                Role::Crowd(crowd) => self.crowds[*crowd].surface(self, p, threshold, Afar::Exact),
                _ => self.tree_surface(object, p, threshold),
            };
            let is_less = surface.field.value.lt(least.field.value);
            least = Surface {
                field: Dual::select(is_less, surface.field, least.field),
                leaf: N::select(is_less, surface.leaf, least.leaf),
            };
        }
        least
    }

    /// The surface that a ray met at each point, as [`surface`](Self::surface): of the leaf of closed form that
    /// [`direct_hit`](Self::direct_hit) gave as `met`, or of the objects that are marched where that is [`MARCHED`]. Where a smooth
    /// operator blends two materials, the second one shows if its weight exceeds the threshold of the blend's number:
    /// [`Batch::choice`], or 0.5 for the heavier one.
    pub fn surface_met<N: Batch>(&self, p: Vec3<N>, met: N, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let all = &met.lanes()[..N::LANES];
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        if all.iter().any(|&met| met < 0.0) {
            result = self.nearest_surface(p, |closed| N::truth(!closed), threshold, Afar::Estimate);
        }
        for (lane, &leaf) in all.iter().enumerate().filter(|(_, leaf)| **leaf >= 0.0) {
            if all[..lane].contains(&leaf) {
                continue;
            }
            let Some(shape) = self.leaves.get(leaf as usize) else { continue };
            let field = if shape.hollow { -shape.surface(p) } else { shape.surface(p) };
            let is_it = (met - N::constant(leaf)).abs().lt(N::constant(0.5));
            result = Surface {
                field: Dual::select(is_it, field, result.field),
                leaf: N::select(is_it, N::constant(leaf), result.leaf),
            };
        }
        result
    }

    fn nearest_surface<N: Batch>(
        &self,
        p: Vec3<N>,
        counts: impl Fn(bool) -> N::Mask,
        threshold: &dyn Fn(u32) -> N,
        afar: Afar,
    ) -> Surface<N> {
        let mut nearest = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        let mut add = |surface: Surface<N>, counts: N::Mask| {
            let closer = surface.field.value.abs().lt(nearest.field.value.abs()) & counts;
            nearest = Surface {
                field: Dual::select(closer, surface.field, nearest.field),
                leaf: N::select(closer, surface.leaf, nearest.leaf),
            };
        };
        for (object, role) in self.objects.iter().zip(&self.roles) {
            let closed = matches!(role, Role::Direct | Role::InBvh);
            let is_evaluated = closed || *role == Role::Marched;
            if is_evaluated && N::any(counts(closed)) {
                add(self.tree_surface(object, p, threshold), counts(closed));
            }
        }
        for crowd in &self.crowds {
            add(crowd.surface(self, p, threshold, afar), counts(false));
        }
        nearest
    }

    fn tree_surface<N: Batch>(&self, tree: &Tree, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        match tree {
            Tree::Leaf(index) => {
                let field = self.leaves[*index as usize].surface(p);
                Surface { field, leaf: N::constant(*index as f32) }
            }
            Tree::Modify(modified) => {
                let Modified { modifier, numbers, pose, inside, .. } = &**modified;
                let p = pose.local(p);
                let place = if modified.places > 1 { self.nearest_inside(modified, p).1 } else { N::zero() };
                let point = N::modified_point_gradient(*modifier, p, place, numbers);
                let Surface { field, leaf } = self.tree_surface(inside, point.values(), threshold);
                let inside = Dual { value: field.value, gradient: point.pulled(field.gradient) };
                Surface { field: pose.world(N::modified_gradient(*modifier, p, inside, numbers)), leaf }
            }
            Tree::Combine { operator, smooth, children, first_choice } => {
                let mut result = self.tree_surface(&children[0], p, threshold);
                for (k, child) in children[1..].iter().enumerate() {
                    let other = self.tree_surface(child, p, threshold);
                    let weight = N::weight(*operator, result.field.value, other.field.value, *smooth);
                    let least = match smooth {
                        Some(_) => threshold(first_choice + k as u32),
                        None => N::constant(0.5),
                    };
                    let other_shows = least.lt(weight);
                    result = Surface {
                        field: N::combined_gradient(*operator, result.field, other.field, *smooth),
                        leaf: N::select(other_shows, other.leaf, result.leaf),
                    };
                }
                result
            }
        }
    }
}
