//! WGSL of the BVH over analytic objects: one traversal as code, all nodes as parameters.
//!
//! `graph/bvh.rs` explains it. A node is two vectors: its least corner and the index of the node after its subtree; its greatest
//! corner and the index of its leaf's record, or zero. Records are those of shape grids. Cost: two loop iterations for each
//! visited node, of the 65,535 that Mesa's software Vulkan grants an invocation: a path of ten rays through a thousand spheres
//! takes about 2,000.

use super::shape_grid::cases;
use super::{Composer, Program};
use std::collections::{BTreeSet, HashMap};

const TRAVERSAL: &str = "\
/// Bit that marks the id of a hit as a record of the BVH, not a leaf.
const BVH = 0x80000000u;

/// First hit of a ray with the objects of the BVH, or the one found before.
fn bvh_hit(origin: vec3f, direction: vec3f, before: AnalyticHit) -> AnalyticHit {
    var nearest = before;
    let inverse = 1.0 / select(direction, vec3f(1e-12), abs(direction) < vec3f(1e-12));
    var node = u32(field_vector(HEADERu).x);
    let end = u32(field_vector(HEADERu).y);
    while node < end {
        let low = field_vector(node);
        let high = field_vector(node + 1u);
        let a = (low.xyz - origin) * inverse;
        let b = (high.xyz - origin) * inverse;
        let first = min(a, b);
        let last = max(a, b);
        let enters = max(max(first.x, first.y), max(first.z, 0.0));
        let leaves = min(min(last.x, last.y), min(last.z, nearest.t));
        // The margin keeps flat boxes.
        let is_hit = enters < leaves + abs(leaves) * 1e-6 + 1e-30;
        let record = u32(high.w);
        loop {
            if !is_hit || record == 0u {
                break;
            }
            let t = record_ray(record, origin, direction);
            if t < nearest.t {
                nearest = AnalyticHit(t, BVH + record, NO_TRIANGLE);
            }
            break;
        }
        node = select(u32(low.w), node + 2u, is_hit);
    }
    return nearest;
}

/// Unsigned distance to the nearest leaf of the BVH in one of the sets, or in any if `sets` is zero, except `ignored_leaf`; or the
/// distance found before, if that is less.
fn bvh_distance(p: vec3f, before: f32, sets: u32, ignored_leaf: u32) -> f32 {
    var nearest = before;
    var node = u32(field_vector(HEADERu).x);
    let end = u32(field_vector(HEADERu).y);
    while node < end {
        let low = field_vector(node);
        let high = field_vector(node + 1u);
        let is_near = length(max(max(low.xyz - p, p - high.xyz), vec3f(0.0))) < nearest;
        let record = u32(high.w);
        loop {
            if !is_near || record == 0u {
                break;
            }
            let is_included = sets == 0u || (u32(field_vector(record + 2u).w) & sets) != 0u;
            if is_included && u32(field_vector(record + 3u).w) != ignored_leaf {
                nearest = min(nearest, abs(record_distance(record, p)));
            }
            break;
        }
        node = select(u32(low.w), node + 2u, is_near);
    }
    return nearest;
}

";

impl Program {
    /// Writes to the parameters which objects of the BVH are in each of the sets of [`distances_to`](Self::distances_to), in the
    /// same order.
    pub fn write_object_sets(&mut self, field: &crate::graph::Field, named: &[(&str, &[bool])]) {
        for &(leaf, record) in &self.bvh_records {
            let object = field.leaves()[leaf as usize].object as usize;
            let includes = |(_, included): &(&str, &[bool])| included.get(object) == Some(&true);
            let sets: u32 = named.iter().enumerate().map(|(bit, named)| u32::from(includes(named)) << bit).sum();
            self.parameters[record + 2][3] = sets as f32;
        }
    }
}

impl Composer<'_> {
    /// Collects the functions that the traversal calls and reserves its header.
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

    /// Appends the records and nodes behind all other parameters.
    pub(super) fn append_bvh(&mut self) {
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

    /// Prints the functions of the BVH: `bvh_hit` and `bvh_distance`.
    pub(super) fn bvh(&self) -> String {
        if self.field.bvh().nodes.is_empty() {
            return String::new();
        }
        let ray = format!(
            "/// Metres to the first hit of a ray with the shape of a record.\nfn record_ray(record: u32, origin: vec3f, direction: \
             vec3f) -> f32 {{\n    let at = field_vector(record);\n    let x = field_vector(record + 1u);\n    let y = \
             field_vector(record + 2u);\n    let z = field_vector(record + 3u);\n    let n = field_vector(record + \
             4u);\n    let rows = mat3x3f(x.xyz, y.xyz, z.xyz);\n    let o = (origin - at.xyz) * rows;\n    let d = direction * rows \
             * at.w;\n    var t = 1e30;\n{}    return t * at.w;\n}}\n\n",
            cases(&self.record_kinds(), "t", "ray", "o, d")
        );
        ray + &TRAVERSAL.replace("HEADER", &self.bvh_start.to_string())
    }
}
