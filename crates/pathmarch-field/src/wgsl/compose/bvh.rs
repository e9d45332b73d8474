//! The hierarchy of objects of closed form as WGSL: one traversal, and everything else as numbers.
//!
//! Twin of `graph/bvh.rs`, which explains it. A node is two vectors: its least corner and where to go on when it is skipped; its
//! greatest corner and the record of its leaf, or zero. Records are those of shape_grids. Cost: two iterations for each node that is
//! visited, of the 65,535 that Mesa's software Vulkan grants an invocation: a path of ten rays through a thousand spheres takes
//! about 2,000.

use super::shape_grid::cases;
use super::{Composer, Program};
use std::collections::{BTreeSet, HashMap};

const TRAVERSAL: &str = "\
/// What tells records of the hierarchy from numbers of leaves.
const BVH = 0x80000000u;

/// The first hit of a ray, or what it has met before.
fn bvh_hit(origin: vec3f, direction: vec3f, before: AnalyticHit) -> AnalyticHit {
    var nearest = before;
    let inverse = 1.0 / select(direction, vec3f(1e-12), abs(direction) < vec3f(1e-12));
    var node = u32(field_parameters[HEADERu].x);
    let end = u32(field_parameters[HEADERu].y);
    while node < end {
        let low = field_parameters[node];
        let high = field_parameters[node + 1u];
        let a = (low.xyz - origin) * inverse;
        let b = (high.xyz - origin) * inverse;
        let first = min(a, b);
        let last = max(a, b);
        let enters = max(max(first.x, first.y), max(first.z, 0.0));
        let leaves = min(min(last.x, last.y), min(last.z, nearest.t));
        // A box may be flat.
        let meets = enters < leaves + abs(leaves) * 1e-6 + 1e-30;
        let record = u32(high.w);
        loop {
            if !meets || record == 0u {
                break;
            }
            let t = item_ray(record, origin, direction);
            if t < nearest.t {
                nearest = AnalyticHit(t, BVH + record);
            }
            break;
        }
        node = select(u32(low.w), node + 2u, meets);
    }
    return nearest;
}

/// The distance to the nearest surface of the leaves that count in a set, or what is nearer; of all where `sets` is zero. The leaf
/// `own` does not count.
fn bvh_distance(p: vec3f, before: f32, sets: u32, own: u32) -> f32 {
    var nearest = before;
    var node = u32(field_parameters[HEADERu].x);
    let end = u32(field_parameters[HEADERu].y);
    while node < end {
        let low = field_parameters[node];
        let high = field_parameters[node + 1u];
        let is_near = length(max(max(low.xyz - p, p - high.xyz), vec3f(0.0))) < nearest;
        let record = u32(high.w);
        loop {
            if !is_near || record == 0u {
                break;
            }
            let counts = sets == 0u || (u32(field_parameters[record + 2u].w) & sets) != 0u;
            if counts && u32(field_parameters[record + 3u].w) != own {
                nearest = min(nearest, abs(item_distance(record, p)));
            }
            break;
        }
        node = select(u32(low.w), node + 2u, is_near);
    }
    return nearest;
}

";

impl Program {
    /// Says which objects count in each of the sets whose distances [`distances_to`](Self::distances_to) prints, in that order: where
    /// there are many objects, that is a number, too.
    pub fn write_object_sets(&mut self, field: &crate::graph::Field, named: &[(&str, &[bool])]) {
        for &(leaf, record) in &self.bvh_records {
            let object = field.leaves()[leaf as usize].object as usize;
            let counts = |(_, counts): &(&str, &[bool])| counts.get(object) == Some(&true);
            let sets: u32 = named.iter().enumerate().map(|(bit, named)| u32::from(counts(named)) << bit).sum();
            self.parameters[record + 2][3] = sets as f32;
        }
    }
}

impl Composer<'_> {
    /// Collects the functions that the traversal calls and keeps a place for what tells of it.
    pub(super) fn bvh_functions(&mut self, functions: &mut BTreeSet<(u32, String)>) {
        let field = self.field;
        if field.bvh().nodes.is_empty() {
            return;
        }
        for (_, shape) in self.shape_grid_kinds() {
            functions.insert((0, shape.wgsl_distance()));
            functions.insert((0, shape.wgsl_gradient()));
            if shape.is_analytic() {
                functions.insert((0, shape.wgsl_ray()));
            }
        }
        self.bvh_start = self.parameters.len();
        self.parameters.push([0.0; 4]);
    }

    /// Puts its numbers behind all others.
    pub(super) fn bvh_numbers(&mut self) {
        let field = self.field;
        if field.bvh().nodes.is_empty() {
            return;
        }
        let kinds: Vec<String> = self.shape_grid_kinds().into_iter().map(|(name, _)| name).collect();
        let records: HashMap<u32, f32> =
            field.bvh().leaves().map(|leaf| (leaf, self.record(&kinds, 0, leaf))).collect();
        let first = self.parameters.len();
        for node in &field.bvh().nodes {
            let ([ax, ay, az], [bx, by, bz]) = (node.bounds.min, node.bounds.max);
            let record = node.leaf.and_then(|leaf| records.get(&leaf)).copied().unwrap_or(0.0);
            self.parameters.push([ax, ay, az, (first + 2 * node.skip as usize) as f32]);
            self.parameters.push([bx, by, bz, record]);
        }
        self.parameters[self.bvh_start] = [first as f32, self.parameters.len() as f32, 0.0, 0.0];
        self.bvh_records = records.into_iter().map(|(leaf, record)| (leaf, record as usize)).collect();
    }

    /// The functions of the hierarchy: `bvh_hit` and `bvh_distance`.
    pub(super) fn bvh(&self) -> String {
        if self.field.bvh().nodes.is_empty() {
            return String::new();
        }
        let ray = format!(
            "/// Metres to where a ray first meets the shape of a record.\nfn item_ray(record: u32, origin: vec3f, direction: \
             vec3f) -> f32 {{\n    let at = field_parameters[record];\n    let x = field_parameters[record + 1u];\n    let y = \
             field_parameters[record + 2u];\n    let z = field_parameters[record + 3u];\n    let n = field_parameters[record + \
             4u];\n    let rows = mat3x3f(x.xyz, y.xyz, z.xyz);\n    let o = (origin - at.xyz) * rows;\n    let d = direction * rows \
             * at.w;\n    var t = 1e30;\n{}    return t * at.w;\n}}\n\n",
            cases(&self.record_kinds(), "t", "ray", "o, d")
        );
        ray + &TRAVERSAL.replace("HEADER", &self.bvh_start.to_string())
    }
}
