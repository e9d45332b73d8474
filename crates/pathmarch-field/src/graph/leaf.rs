//! A leaf of a field: a shape, its numbers and where it stands, evaluated in the coordinates around it.

use super::{Batch, Pose};
use crate::number::{Dual, Vec3};
use crate::ray_interval::RayInterval;
use crate::shapes::ShapeRef;

/// A shape of the field.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// The shape.
    pub shape: ShapeRef,
    /// What it reads: [`Shape::coefficients`](crate::Shape::coefficients).
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
    pub subtracted: bool,
}

impl Leaf {
    #[inline]
    pub(super) fn distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let distance = N::shape(&*self.shape).distance(self.pose.local(p), &self.params);
        self.pose.length(distance)
    }

    #[inline]
    pub(super) fn ray<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> N {
        let t = N::shape(&*self.shape).ray(self.pose.local(origin), self.pose.turned(direction), &self.params);
        self.pose.length(t)
    }

    #[inline]
    pub(super) fn interval<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> RayInterval<N> {
        let (origin, direction) = (self.pose.local(origin), self.pose.turned(direction));
        let RayInterval { enter, leave } = N::shape(&*self.shape).interval(origin, direction, &self.params);
        RayInterval { enter: self.pose.length(enter), leave: self.pose.length(leave) }
    }

    #[inline]
    pub(super) fn surface<N: Batch>(&self, p: Vec3<N>) -> Dual<N> {
        let local = N::shape(&*self.shape).gradient(Dual::variables(self.pose.local(p)), &self.params);
        self.pose.world(local)
    }
}
