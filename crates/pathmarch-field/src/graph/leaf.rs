//! Leaf of a field: a shape, its coefficients and its pose.

use super::{Batch, Pose};
use crate::mesh_shape::MeshGeometry;
use crate::number::{Dual, Vec3};
use crate::ray_interval::RayInterval;
use crate::shapes::ShapeRef;

/// Placed shape of a field.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// Shape.
    pub shape: ShapeRef,
    /// Coefficients: [`Shape::coefficients`](crate::Shape::coefficients).
    pub params: Vec<f32>,
    /// Tag of its node.
    pub tag: u32,
    /// Index of its object.
    pub object: u32,
    /// Pose in the world, or in the space of the modifier around it.
    pub pose: Pose,
    /// True if the pose is in the space of a modifier.
    pub modified: bool,
    /// Number of its material among those of a mesh, whose leaves are consecutive; 0 for all other shapes.
    pub slot: u32,
    /// True if its analytic object subtracts it: rays hit it from inside.
    pub subtracted: bool,
    /// Leaf that the scene declares, if this is it or one more of the copies that a modifier makes of lamps. The others come
    /// behind all declared leaves.
    pub copy_of: Option<u32>,
    /// True if its object consists of lamps ([`Field::with_lamps`](super::Field::with_lamps)).
    pub lamp: bool,
}

impl Leaf {
    /// Reports whether all rays intersect it as triangles, by [`Field::mesh_hit`](super::Field::mesh_hit).
    pub fn is_triangles(&self) -> bool {
        !self.modified && self.shape.mesh().is_some_and(MeshGeometry::is_triangles)
    }

    /// Reports whether camera rays intersect it as triangles, and other rays as a field.
    pub fn is_lit_by_field(&self) -> bool {
        !self.modified && self.shape.mesh().is_some_and(MeshGeometry::is_lit_by_field)
    }

    /// Distance from the triangles at which other rays start off into the field, metres: a voxel if they are
    /// [lit by it](Self::is_lit_by_field), else 0.
    pub(crate) fn clearance(&self) -> f32 {
        let mesh = self.shape.mesh().filter(|_| self.is_lit_by_field());
        mesh.map_or(0.0, |mesh| mesh.voxel() * self.pose.scale)
    }

    /// Reports whether both have the same distance everywhere. False if that is unknown.
    pub(super) fn is_same_shape(&self, other: &Self) -> bool {
        self.shape.info().name == other.shape.info().name
            && std::ptr::addr_eq(&*self.shape, &*other.shape)
            && self.params == other.params
            && self.pose == other.pose
    }

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

    /// [`surface`](Self::surface) at a hit of [`ray`](Self::ray) or an end of [`interval`](Self::interval).
    #[inline]
    pub(super) fn surface_at_hit<N: Batch>(&self, p: Vec3<N>) -> Dual<N> {
        let local = N::shape(&*self.shape).gradient_at_hit(Dual::variables(self.pose.local(p)), &self.params);
        self.pose.world(if self.subtracted { -local } else { local })
    }
}
