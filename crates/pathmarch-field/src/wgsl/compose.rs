//! WGSL of a scene's field: one function for each kind of shape in use, composed for the scene.
//!
//! Structure is code, parameters are data: every number of the scene is in [`Program::parameters`], so that scenes of the same
//! structure run the same code. Cost: linear in the number of shapes, microseconds each.

mod analytic;
mod bvh;
mod coordinates;
mod distance;
mod mesh;
mod modifiers;
mod parameters;
mod shape_grid;
mod surface;

use crate::blend::{Blend, BlendProfile};
use crate::graph::shape_grid::ShapeGrid;
use crate::graph::{Field, Tree};
use crate::mesh_shape::words::MeshWords;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Largest number of parameter vectors for uniform memory: 64 KiB, which every adapter has.
pub const MAX_UNIFORM_VECTORS: usize = 4096;

/// Parameters of a field, packed for the GPU.
pub type Parameters = Vec<[f32; 4]>;

/// Code and parameters of a field.
///
/// The code reads its parameters by `field_vector(index: u32) -> vec4f`, and the length of tables by `field_vector_count() -> u32`;
/// [`declaration`](Self::declaration) declares both for an array. It declares the WGSL of [`Field`] methods:
/// `sphere_traced_distance(p: vec3f) -> f32`, `analytic_hit(origin: vec3f, direction: vec3f) -> AnalyticHit`, and
/// `surface(p: vec3f, hit_id: u32, triangle: u32, seed: u32) -> Surface` for [`Field::surface_at_hit`], where `hit_id` and
/// `triangle` are those of an analytic hit, or `hit_id` is `SPHERE_TRACED`. The code of fields with meshes calls
/// `mesh_word(index: u32) -> u32`, which the kernel declares: a word of [`Program::mesh_words`].
#[derive(Clone, Debug)]
pub struct Program {
    /// WGSL text, equal for scenes of equal structure.
    pub code: String,
    /// WGSL text of `estimated_distance(p: vec3f) -> f32`, the WGSL of [`Field::estimated_distance`]; optional, to be appended
    /// to `code`.
    pub estimated_distance: String,
    /// Parameters, at least one vector.
    pub parameters: Parameters,
    /// Words of all meshes.
    mesh_words: Arc<MeshWords>,
    /// True if the code reads tables of any length. Then the type of the array has no length, so that it does not change with
    /// the number of points of an outline.
    pub has_tables: bool,
    /// Leaves of the BVH and the indices of their records.
    bvh_records: Vec<(u32, usize)>,
}

const SURFACE: &str = "\
/// Id of a sphere-traced hit.
const SPHERE_TRACED = 0xffffffffu;

/// Triangle of a hit that is none of a mesh.
const NO_TRIANGLE = 0xffffffffu;

/// First analytic hit of a ray: metres, or 1e30, and the id and triangle that `surface` takes.
struct AnalyticHit {
    t: f32,
    hit_id: u32,
    triangle: u32,
}

/// Surface nearest to a point.
struct Surface {
    gradient: vec3f,
    distance: f32,
    leaf: u32,
    /// Triangle of a mesh, or NO_TRIANGLE.
    triangle: u32,
}
";

/// WGSL text of `choice(seed: u32, index: u32) -> f32`, which chooses among blended materials.
const CHOICE: &str = "\
/// Uniform number in 0..1 for the choice of this index (PCG hash; Jarzynski and Olano 2020).
fn choice(seed: u32, index: u32) -> f32 {
    let state = (seed ^ (index * 0x9e3779b9u)) * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}
";

/// WGSL text of `field_vector(index: u32) -> vec4f` for an array `field_parameters`.
const VECTOR: &str = "
/// Vector of the field's parameters.
fn field_vector(index: u32) -> vec4f {
    return field_parameters[index];
}
";

/// WGSL text of `field_vector_count() -> u32` for such an array without a declared length.
const VECTOR_COUNT: &str = "
/// Number of the field's parameters, vectors.
fn field_vector_count() -> u32 {
    return arrayLength(&field_parameters);
}
";

/// WGSL text of `table_vector(index: f32) -> vec4f`, part of the code of fields with shapes that read tables.
pub const TABLE: &str = "\
/// Vector of a shape's table.
fn table_vector(index: f32) -> vec4f {
    return field_vector(min(u32(index), field_vector_count() - 1u));
}
";

/// Options of a program's code.
#[derive(Clone, Copy, Debug)]
pub struct ProgramOptions<'a> {
    /// Name of the function `sphere_traced_distance`, for kernels that declare their own in front of it.
    pub sphere_traced_distance: &'a str,
    /// True for kernels that evaluate the distance of triangles: with [`Program::distances_to`] or
    /// [`Program::estimated_distance`].
    pub has_triangle_distances: bool,
    /// True to declare `choice` in the code of fields that blend; false for kernels that declare their own.
    pub declares_choice: bool,
    /// True if the kernel contains the parameters, so that the code may depend on their values.
    pub has_constant_numbers: bool,
}

impl Default for ProgramOptions<'_> {
    fn default() -> Self {
        Self {
            sphere_traced_distance: "sphere_traced_distance",
            has_triangle_distances: true,
            declares_choice: true,
            has_constant_numbers: false,
        }
    }
}

impl Program {
    /// Words of all meshes, which `mesh_word` reads; empty if there are none.
    pub fn mesh_words(&self) -> &[u32] {
        &self.mesh_words.words
    }
    /// Reports whether the parameters may be in a uniform buffer: they fit, and the code reads no tables.
    pub fn is_uniform(&self) -> bool {
        !self.has_tables && self.parameters.len() <= MAX_UNIFORM_VECTORS
    }
    /// WGSL of an array `field_parameters` in a place such as `@group(0) @binding(0) var<uniform>`, and of the functions that
    /// read it.
    pub fn declaration(&self, place: &str) -> String {
        let count = if self.has_tables { VECTOR_COUNT } else { "" };
        format!("{place} field_parameters: {};\n{VECTOR}{count}", self.parameters_type())
    }
    /// WGSL of such an array of these vectors, and of the functions that read it.
    pub fn constants(&self, vectors: &str) -> String {
        let kind = self.parameters_type();
        format!("var<private> field_parameters: {kind} = {kind}({vectors});\n{VECTOR}")
    }
    /// WGSL type of the array of parameters.
    fn parameters_type(&self) -> String {
        match self.has_tables {
            true => "array<vec4f>".to_owned(),
            false => format!("array<vec4f, {}>", self.parameters.len()),
        }
    }
    /// Composes the program of a field with the default options.
    pub fn new(field: &Field) -> Self {
        Self::with_options(field, ProgramOptions::default())
    }

    /// Composes the program of a field.
    pub fn with_options(field: &Field, options: ProgramOptions) -> Self {
        let Composed { mut composer, functions, has_choice } =
            Composed::new(field, options.has_triangle_distances, options.has_constant_numbers);
        let mut code_of_distances = BTreeSet::new();
        for tree in field.single_objects() {
            composer.distances(tree, &mut code_of_distances);
        }
        let mut estimated_distance: String =
            code_of_distances.difference(&functions).map(|(_, f)| format!("{f}\n")).collect();
        estimated_distance += &composer.estimated_distance();
        let distance = composer.sphere_traced_distance(options.sphere_traced_distance);
        let analytic_hit = composer.analytic_hit();
        let surface = composer.surface();
        if composer.parameters.is_empty() {
            composer.parameters.push([0.0; 4]);
        }
        let mut code = String::from(SURFACE);
        if has_choice && options.declares_choice {
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
        code += &composer.mesh_code();
        let shape_grids = composer.records() + &composer.shape_grids() + &composer.bvh();
        let code = format!("{code}\n{shape_grids}{distance}\n{analytic_hit}\n{surface}");
        let Composer { parameters, bvh_records, meshes, .. } = composer;
        Self { code, estimated_distance, parameters, mesh_words: meshes, has_tables, bvh_records }
    }

    /// WGSL text of functions `NAME(p: vec3f, ignored_leaf: u32) -> f32`, to be appended to [`code`](Self::code): each is
    /// [`Field::distance_to`] the objects of one set, which has an entry for each object.
    pub fn distances_to(field: &Field, named: &[(&str, &[bool])]) -> String {
        let Composed { composer, functions, .. } = Composed::new(field, true, false);
        let mut of_distances = BTreeSet::new();
        let mut text = String::new();
        for (bit, (name, included)) in named.iter().enumerate() {
            let objects: Vec<&Tree> =
                field.single_objects_with(included).filter(|(_, included)| *included).map(|(tree, _)| tree).collect();
            let shape_grid = field.included_shape_grid(included);
            objects.iter().for_each(|tree| composer.distances(tree, &mut of_distances));
            let doc = "Unsigned distance from `p` to the nearest surface of the included objects, metres.";
            text += &composer.unsigned_distance(
                &format!("{name}(p: vec3f, ignored_leaf: u32)"),
                doc,
                &objects,
                shape_grid,
                Some(bit),
            );
        }
        of_distances.difference(&functions).map(|(_, function)| format!("{function}\n")).collect::<String>() + &text
    }
}

/// Packed parameters of a field, and the functions that its code calls.
struct Composed<'a> {
    composer: Composer<'a>,
    functions: BTreeSet<(u32, String)>,
    /// True if any operator blends.
    has_choice: bool,
}

impl<'a> Composed<'a> {
    fn new(field: &'a Field, has_all_grids: bool, has_constant_numbers: bool) -> Self {
        let mut composer = Composer {
            field,
            parameters: Vec::new(),
            widths: Vec::new(),
            starts: Vec::new(),
            modifier_starts: BTreeMap::new(),
            shape_grid_starts: Vec::new(),
            bvh_start: 0,
            bvh_records: Vec::new(),
            meshes: Arc::default(),
            has_all_grids,
            has_constant_numbers,
        };
        let mut functions = BTreeSet::new();
        let mut printed = BTreeSet::new();
        let mut is_record = vec![false; field.leaves().len()];
        let records = field.shape_grids().iter().flat_map(ShapeGrid::leaves);
        records.chain(field.bvh().leaves()).for_each(|leaf| is_record[leaf as usize] = true);
        let analytic: BTreeSet<u32> = field.analytic_objects().flat_map(analytic::leaves).collect();
        for ((index, leaf), is_record) in (0..).zip(field.leaves()).zip(is_record) {
            composer.starts.push(composer.parameters.len());
            if is_record {
                continue;
            }
            match leaf.shape.reads_table() {
                // The index of its table, written later.
                true => composer.pack(&leaf.pose, &[0.0]),
                false => composer.pack(&leaf.pose, &leaf.params),
            }
            if !analytic.contains(&index) && printed.insert(leaf.shape.wgsl_name()) {
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
        composer.append_meshes();
        composer.append_tables();
        composer.append_shape_grids();
        composer.append_bvh();
        Self { composer, functions, has_choice }
    }
}

struct Composer<'a> {
    field: &'a Field,
    parameters: Parameters,
    /// Index of the parameters of each blend, by its operator's first choice.
    widths: Vec<(u32, usize)>,
    /// Index of the first parameters of each leaf.
    starts: Vec<usize>,
    /// Index of the first parameters of each modifier.
    modifier_starts: BTreeMap<u32, usize>,
    /// Index of each shape grid's header.
    shape_grid_starts: Vec<usize>,
    /// Index of the BVH's header.
    bvh_start: usize,
    /// Leaves of the BVH and the indices of their records.
    bvh_records: Vec<(u32, usize)>,
    meshes: Arc<MeshWords>,
    /// Triangles have distances.
    has_all_grids: bool,
    /// The code may depend on the values of the parameters.
    has_constant_numbers: bool,
}

fn profile(smooth: Option<Blend>) -> Option<BlendProfile> {
    smooth.map(|blend| blend.profile)
}

impl Composer<'_> {
    /// Collects the functions of the operators in use and packs their blends. Returns true if any blends.
    fn operators(&mut self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) -> bool {
        let (operator, smooth, children, first_choice) = match tree {
            Tree::Leaf(_) => return false,
            Tree::Modifier(modified) => {
                let chooses = self.operators(&modified.inside, functions);
                self.modifier_starts.insert(modified.index, self.parameters.len());
                self.pack(&modified.pose, &modified.coefficients);
                functions.insert((1, modified.modifier.wgsl()));
                return chooses;
            }
            Tree::Operator { shape_grid: Some(index), .. } => {
                let code = &self.field.shape_grids()[*index as usize].code;
                return code.iter().fold(false, |blends, tree| self.operators(tree, functions) | blends);
            }
            Tree::Operator { operator, smooth, children, first_choice, .. } => {
                (operator, smooth, children, first_choice)
            }
        };
        functions.insert((1, operator.wgsl_gradient(profile(*smooth))));
        functions.insert((1, operator.wgsl_weight(profile(*smooth))));
        if let Some(blend) = smooth {
            self.widths.push((*first_choice, self.parameters.len()));
            self.parameters.push([blend.amount, blend.steps, 0.0, 0.0]);
        }
        children.iter().fold(smooth.is_some(), |blends, child| self.operators(child, functions) | blends)
    }

    /// Collects the distance functions of a sphere-traced tree.
    fn distances(&self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        match tree {
            Tree::Leaf(leaf) => {
                functions.insert((0, self.field.leaves()[*leaf as usize].shape.wgsl_distance()));
            }
            Tree::Operator { shape_grid: Some(index), .. } => {
                let code = &self.field.shape_grids()[*index as usize].code;
                code.iter().for_each(|tree| self.distances(tree, functions));
            }
            Tree::Operator { operator, smooth, children, .. } => {
                functions.insert((1, operator.wgsl_distance(profile(*smooth))));
                children.iter().for_each(|child| self.distances(child, functions));
            }
            Tree::Modifier(modified) => self.distances(&modified.inside, functions),
        }
    }
}
