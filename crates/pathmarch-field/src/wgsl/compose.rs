//! A scene's field as WGSL: one function for each kind of shape in use, composed for the scene.
//!
//! Structure is code, numbers are data: every number of the scene stands in [`Program::parameters`], so that a scene of
//! the same structure and other numbers runs the same code. Cost: linear in the number of shapes, microseconds each.

mod analytic;
mod bvh;
mod coordinates;
mod distance;
mod modifiers;
mod parameters;
mod shape_grid;
mod surface;

use crate::blend::{Blend, BlendProfile};
use crate::graph::{Field, Tree};
use std::collections::BTreeSet;

/// The most vectors of parameters that fit the uniform memory every adapter has (64 KiB).
pub const MAX_UNIFORM_VECTORS: usize = 4096;

/// The numbers of a field, packed for the GPU.
pub type Parameters = Vec<[f32; 4]>;

/// A field's code and numbers.
///
/// The code expects an array `field_parameters` of `vec4f` and declares `sphere_traced_distance(p: vec3f) -> f32`,
/// `analytic_hit(origin: vec3f, direction: vec3f) -> AnalyticHit`, the struct `Surface` and `surface(p: vec3f, met: u32, seed: u32)
/// -> Surface`, where `met` is that of a direct hit or `SPHERE_TRACED`: the WGSL of the [`Field`] methods of these names, the last one that of [`Field::surface_at_hit`].
#[derive(Clone, Debug)]
pub struct Program {
    /// WGSL text; equal for scenes of equal structure.
    pub code: String,
    /// WGSL text of `estimated_distance(p: vec3f) -> f32`, the distance to all that `code` only marches in part: for those
    /// who need it, behind `code`.
    pub estimated_distance: String,
    /// The numbers, at least one vector.
    pub parameters: Parameters,
    /// Whether the code looks numbers up in tables: then the array has no length in its type, which another point of an
    /// outline would change.
    pub has_tables: bool,
    /// Records of the leaves of the hierarchy.
    bvh_records: Vec<(u32, usize)>,
}

const SURFACE: &str = "\
/// A surface that was met by marching.
const SPHERE_TRACED = 0xffffffffu;

/// The first surface of closed form along a ray: metres, or 1e30, and what `surface` tells it by.
struct AnalyticHit {
    t: f32,
    met: u32,
}

/// The nearest surface as seen from a point.
struct Surface {
    gradient: vec3f,
    distance: f32,
    leaf: u32,
}
";

/// WGSL text of `choice(seed: u32, index: u32) -> f32`, as it stands in the code of a field that blends: for those who
/// choose among blended materials in another way.
pub const CHOICE: &str = "\
/// A uniform number in 0..1 for the choice of this index (PCG hash; Jarzynski and Olano 2020).
fn choice(seed: u32, index: u32) -> f32 {
    let state = (seed ^ (index * 0x9e3779b9u)) * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}
";

/// WGSL text of `table_vector(index: f32) -> vec4f`, as it stands in the code of a field with shapes that read tables.
pub const TABLE: &str = "\
/// A vector of the field's numbers.
fn table_vector(index: f32) -> vec4f {
    return field_parameters[min(u32(index), arrayLength(&field_parameters) - 1u)];
}
";

impl Program {
    /// Whether the numbers may be a uniform buffer: if they fit, and are not looked up in tables of any length.
    pub fn is_uniform(&self) -> bool {
        !self.has_tables && self.parameters.len() <= MAX_UNIFORM_VECTORS
    }
    /// The type of the array of numbers.
    pub fn parameters_type(&self) -> String {
        match self.has_tables {
            true => "array<vec4f>".to_owned(),
            false => format!("array<vec4f, {}>", self.parameters.len()),
        }
    }
    /// Prints a field.
    pub fn new(field: &Field) -> Self {
        let Composed { mut composer, functions, has_choice } = Composed::new(field);
        let mut code_of_distances = BTreeSet::new();
        for tree in field.single_objects() {
            composer.distances(tree, &mut code_of_distances);
        }
        let mut estimated_distance: String =
            code_of_distances.difference(&functions).map(|(_, f)| format!("{f}\n")).collect();
        estimated_distance += &composer.estimated_distance();
        let distance = composer.distance();
        let direct = composer.analytic_hit();
        let surface = composer.surface();
        if composer.parameters.is_empty() {
            composer.parameters.push([0.0; 4]);
        }
        let mut code = String::from(SURFACE);
        if has_choice {
            code += "\n";
            code += CHOICE;
        }
        let reads_tables = field.leaves().iter().any(|leaf| leaf.shape.reads_table());
        let has_tables = reads_tables || !field.shape_grids().is_empty() || !field.bvh().nodes.is_empty();
        if reads_tables {
            code += "\n";
            code += TABLE;
        }
        for (_, function) in &functions {
            code += "\n";
            code += function;
        }
        let shape_grids = composer.records() + &composer.shape_grids() + &composer.bvh();
        let code = format!("{code}\n{shape_grids}{distance}\n{direct}\n{surface}");
        let Composer { parameters, bvh_records, .. } = composer;
        Self { code, estimated_distance, parameters, has_tables, bvh_records }
    }

    /// WGSL text, to stand behind [`code`](Self::code), of functions `NAME(p: vec3f, own: u32) -> f32`: each is
    /// [`Field::distance_to`] the objects that count.
    pub fn distances_to(field: &Field, named: &[(&str, &[bool])]) -> String {
        let Composed { composer, functions, .. } = Composed::new(field);
        let mut of_distances = BTreeSet::new();
        let mut text = String::new();
        for (bit, (name, counts)) in named.iter().enumerate() {
            let counted: Vec<&Tree> =
                field.single_objects_with(counts).filter(|(_, counts)| *counts).map(|(tree, _)| tree).collect();
            let shape_grids = field.included_shape_grids(counts);
            counted.iter().for_each(|tree| composer.distances(tree, &mut of_distances));
            let doc =
                "Distance from `p` to the nearest surface of the objects that count here, from either side, metres.";
            text += &composer.unsigned_distance(
                &format!("{name}(p: vec3f, own: u32)"),
                doc,
                &counted,
                &shape_grids,
                Some(bit),
            );
        }
        of_distances.difference(&functions).map(|(_, function)| format!("{function}\n")).collect::<String>() + &text
    }
}

/// A field's numbers in their places, and the functions that its code calls.
struct Composed<'a> {
    composer: Composer<'a>,
    functions: BTreeSet<(u32, String)>,
    /// Whether any operator blends.
    has_choice: bool,
}

impl<'a> Composed<'a> {
    fn new(field: &'a Field) -> Self {
        let mut composer = Composer {
            field,
            parameters: Vec::new(),
            widths: Vec::new(),
            starts: Vec::new(),
            modifier_starts: Vec::new(),
            shape_grid_starts: Vec::new(),
            bvh_start: 0,
            bvh_records: Vec::new(),
        };
        let mut functions = BTreeSet::new();
        let mut printed = BTreeSet::new();
        let mut in_shape_grids = vec![false; field.leaves().len()];
        let in_data = field.shape_grids().iter().flat_map(|shape_grid| shape_grid.leaves.iter().copied());
        in_data.chain(field.bvh().leaves()).for_each(|leaf| in_shape_grids[leaf as usize] = true);
        for (leaf, in_shape_grid) in field.leaves().iter().zip(in_shape_grids) {
            composer.starts.push(composer.parameters.len());
            if in_shape_grid {
                continue;
            }
            match leaf.shape.reads_table() {
                // Where its table is, once that is known.
                true => composer.place(&leaf.pose, &[0.0]),
                false => composer.place(&leaf.pose, &leaf.params),
            }
            if printed.insert(leaf.shape.wgsl_name()) {
                functions.insert((0, leaf.shape.wgsl_gradient()));
            }
        }
        let mut has_choice = composer.shape_grid_functions(&mut functions);
        composer.bvh_functions(&mut functions);
        for tree in field.single_objects() {
            has_choice |= composer.operators(tree, &mut functions);
        }
        field.analytic_objects().for_each(|tree| composer.rays(tree, &mut functions));
        field.sphere_traced_objects().for_each(|tree| composer.distances(tree, &mut functions));
        for tree in field.single_objects() {
            composer.modifiers(tree, &mut functions);
        }
        composer.tables();
        composer.shape_grid_numbers();
        composer.bvh_numbers();
        Self { composer, functions, has_choice }
    }
}

struct Composer<'a> {
    field: &'a Field,
    parameters: Parameters,
    /// Where the numbers of each operator's blend stand, by its first choice.
    widths: Vec<(u32, usize)>,
    /// Where the parameters of each leaf start.
    starts: Vec<usize>,
    /// Where the numbers of each modifier start.
    modifier_starts: Vec<usize>,
    /// Where what tells of each shape_grid starts.
    shape_grid_starts: Vec<usize>,
    /// Where what tells of the hierarchy starts.
    bvh_start: usize,
    /// Where the record of each of its leaves stands.
    bvh_records: Vec<(u32, usize)>,
}

fn profile(smooth: Option<Blend>) -> Option<BlendProfile> {
    smooth.map(|blend| blend.profile)
}

impl Composer<'_> {
    /// Collects the functions of the operators in use and stores their widths; whether any blends.
    fn operators(&mut self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) -> bool {
        let (operator, smooth, children, first_choice) = match tree {
            Tree::Leaf(_) => return false,
            Tree::Modifier(modified) => {
                let chooses = self.operators(&modified.inside, functions);
                // Those inside were numbered before.
                self.modifier_starts.push(self.parameters.len());
                self.place(&modified.pose, &modified.coefficients);
                functions.insert((1, modified.modifier.wgsl()));
                return chooses;
            }
            Tree::Operator { operator, smooth, children, first_choice } => (operator, smooth, children, first_choice),
        };
        functions.insert((1, operator.wgsl_gradient(profile(*smooth))));
        functions.insert((1, operator.wgsl_weight(profile(*smooth))));
        if let Some(blend) = smooth {
            self.widths.push((*first_choice, self.parameters.len()));
            self.parameters.push([blend.amount, blend.steps, 0.0, 0.0]);
        }
        children.iter().fold(smooth.is_some(), |blends, child| self.operators(child, functions) | blends)
    }

    /// Collects the distance functions of a tree that is marched.
    fn distances(&self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        match tree {
            Tree::Leaf(leaf) => {
                functions.insert((0, self.field.leaves()[*leaf as usize].shape.wgsl_distance()));
            }
            Tree::Operator { operator, smooth, children, .. } => {
                functions.insert((1, operator.wgsl_distance(profile(*smooth))));
                children.iter().for_each(|child| self.distances(child, functions));
            }
            Tree::Modifier(modified) => self.distances(&modified.inside, functions),
        }
    }
}
