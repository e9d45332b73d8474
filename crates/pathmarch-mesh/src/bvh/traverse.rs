//! Rays through a hierarchy.
//!
//! **Idea.** Depth first, the nearest child first; a child beyond the closest hit so far is skipped. Box tests are conservative
//! (Ize 2013) and triangle tests watertight, so that no ray passes a closed surface. **Cost.** See `benches/mesh.rs`.

use super::ray::{Ray, ShearedRay, SlabRay};
use super::stack::Stack;
use super::{Bvh, LEAF};

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter of the ray, in multiples of its direction.
    pub t: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Weights of the second and third corner; the first has what they leave of one.
    pub barycentrics: [f32; 2],
}

impl Bvh {
    /// Closest hit of a ray with t_min < t < t_max, on either side of a triangle.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut closest = None;
        self.traverse(ray, |block, sheared, t_max| {
            let hit = self.blocks[block].intersect(sheared, ray.t_min, t_max, u32::MAX)?;
            let triangle = self.blocks[block].triangles[hit.lane];
            closest = Some(Hit { t: hit.t, triangle, barycentrics: hit.barycentrics });
            Some(hit.t)
        });
        closest
    }

    /// Closest hit of a ray with t_min < t < t_max that is accepted. `accepts` is called in no particular order.
    pub fn intersect_where(&self, ray: &Ray, accepts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let mut closest = None;
        self.traverse(ray, |block, sheared, t_max| {
            let block = &self.blocks[block];
            let mut lanes = u32::MAX;
            while let Some(hit) = block.intersect(sheared, ray.t_min, t_max, lanes) {
                let accepted = Hit { t: hit.t, triangle: block.triangles[hit.lane], barycentrics: hit.barycentrics };
                if accepts(&accepted) {
                    closest = Some(accepted);
                    return Some(hit.t);
                }
                lanes &= !(1 << hit.lane);
            }
            None
        });
        closest
    }

    /// Reports any hit with t_min < t < t_max.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut is_occluded = false;
        self.traverse(ray, |block, sheared, t_max| {
            is_occluded |= self.blocks[block].intersect(sheared, ray.t_min, t_max, u32::MAX).is_some();
            is_occluded.then_some(f32::NEG_INFINITY)
        });
        is_occluded
    }

    /// Visits the leaves that a ray passes. `visit` gets the index of a block and the range's end, and returns a new end if
    /// it shortens the range.
    #[inline(always)]
    fn traverse(&self, ray: &Ray, mut visit: impl FnMut(usize, &ShearedRay, f32) -> Option<f32>) {
        if self.nodes.is_empty() {
            return;
        }
        let (sheared, slabs) = (ShearedRay::new(ray), SlabRay::new(ray));
        let mut t_max = ray.t_max;
        let mut stack = Stack::new();
        while let Some(entry) = stack.pop() {
            if entry.distance > t_max {
                continue;
            }
            if entry.node & LEAF != 0 {
                t_max = visit((entry.node & !LEAF) as usize, &sheared, t_max).unwrap_or(t_max);
                continue;
            }
            let node = &self.nodes[entry.node as usize];
            let (enter, leave) = slabs.slabs(&node.min, &node.max, ray.t_min, t_max);
            stack.push_sorted(enter.simd_le(leave).to_bitmask(), enter.as_array(), &node.children);
        }
    }
}
