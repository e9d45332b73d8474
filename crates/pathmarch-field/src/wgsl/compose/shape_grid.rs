//! WGSL of shape grids: code for the kinds of shapes in use, and everything else as parameters.
//!
//! `graph/shape_grid.rs` explains them. Each grid appends to the parameters a record of every shape (position, scale, rotation,
//! coefficients), its cells, two vectors each, and the lists of records. The code has only the index of the grid's header, so
//! that it does not change with the number of shapes or their positions. Members that are code are functions. In lists, they are
//! negative numbers.
//!
//! Cost: a descent without a loop, and one iteration for each shape in a list. Mesa's software Vulkan ends all loops of an
//! invocation after 65,535 iterations together: a path of ten rays at a hundred evaluations each with lists of eight takes
//! 9,000. It runs all cases of a `switch`, which is cheaper than a test for each; only functions that loop themselves are
//! skipped, by a loop with one pass.

use super::parameters::component;
use super::{Composer, profile};
use crate::graph::Pose;
use crate::graph::shape_grid::{BITS, Cell, Member, SPLITS, ShapeGrid};
use crate::registry::union;
use crate::shapes::Shape;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Vectors of a grid's header before the choices of the members that are code.
const HEADER: usize = 5;
/// Vectors of a record before those of further coefficients.
const RECORD: usize = 5;

const CELL: &str = "\
/// Cell of a shape grid that contains a point, or the nearest one.
struct GridCell {
    /// Near a surface: 1, start and length of the list. Far from all: 2 and the leaf whose material shows.
    entry: vec4f,
    /// Of a far cell: the surface point nearest to its centre, and the distance of the centre.
    far_field: vec4f,
    centre: vec3f,
    inside: bool,
}
";

impl Composer<'_> {
    /// Shapes with records, one of each kind, and the prefixes of their functions.
    pub(super) fn shape_grid_kinds(&self) -> Vec<(String, &dyn Shape)> {
        let mut kinds: Vec<(String, &dyn Shape)> = Vec::new();
        for leaf in self.leaves_with_records() {
            let shape = &*self.field.leaves()[leaf as usize].shape;
            let name = shape.wgsl_name();
            if kinds.iter().all(|(known, _)| *known != name) {
                kinds.push((name, shape));
            }
        }
        // The order must not depend on positions, as that of the leaves of a BVH does.
        kinds.sort_by(|(a, _), (b, _)| a.cmp(b));
        kinds
    }

    fn leaves_with_records(&self) -> impl Iterator<Item = u32> {
        self.field.shape_grids().iter().flat_map(ShapeGrid::leaves).chain(self.field.bvh().leaves())
    }

    /// Kinds of shapes with records, for calls of their functions.
    pub(super) fn record_kinds(&self) -> Vec<RecordKind> {
        let kind = |(name, shape): (String, &dyn Shape)| {
            let leaves = self.field.leaves();
            let known = self.leaves_with_records().map(|leaf| &leaves[leaf as usize]);
            let count = known.into_iter().find(|leaf| leaf.shape.wgsl_name() == name).map(|leaf| leaf.params.len());
            let arguments = if shape.reads_table() { 1 } else { count.unwrap_or_default() };
            RecordKind { is_long: is_long(&shape.wgsl_distance()), has_ray: shape.is_analytic(), name, arguments }
        };
        self.shape_grid_kinds().into_iter().map(kind).collect()
    }

    /// Collects the functions that grids call and reserves their headers. Returns true if any blends.
    pub(super) fn shape_grid_functions(&mut self, functions: &mut BTreeSet<(u32, String)>) -> bool {
        for (_, shape) in self.shape_grid_kinds() {
            functions.insert((0, shape.wgsl_distance()));
            functions.insert((0, shape.wgsl_gradient()));
        }
        let field = self.field;
        let mut blends = false;
        for shape_grid in field.shape_grids() {
            self.shape_grid_starts.push(self.parameters.len());
            let vectors = HEADER + shape_grid.code.len().div_ceil(4);
            self.parameters.resize(self.parameters.len() + vectors, [0.0; 4]);
            if !shape_grid.separate {
                let profile = profile(shape_grid.smooth);
                functions.insert((1, union().wgsl_distance(profile)));
                functions.insert((1, union().wgsl_gradient(profile)));
                functions.insert((1, union().wgsl_weight(profile)));
            }
            blends |= shape_grid.smooth.is_some();
        }
        blends
    }

    /// Appends records, cells and lists behind all other parameters.
    pub(super) fn append_shape_grids(&mut self) {
        let field = self.field;
        let kinds: Vec<String> = self.shape_grid_kinds().into_iter().map(|(name, _)| name).collect();
        for (shape_grid, header) in field.shape_grids().iter().zip(self.shape_grid_starts.clone()) {
            let (grid, all) = (shape_grid.grid(field), shape_grid.all_cells(field));
            let mut records = Vec::new();
            for (position, member) in shape_grid.members.iter().enumerate() {
                let choice = shape_grid.choices.get(position).copied().unwrap_or_default();
                records.push(match *member {
                    Member::Shape(leaf) => self.record(&kinds, choice, leaf),
                    Member::Code(index) => {
                        self.parameters[header + HEADER + index as usize / 4][index as usize % 4] = choice as f32;
                        -1.0 - index as f32
                    }
                });
            }
            let any_record = records.iter().copied().find(|&record| record >= 0.0).unwrap_or_default();
            let cells = self.parameters.len();
            for cell in &all.cells {
                self.parameters.extend(match *cell {
                    Cell::Split { first } => [[0.0, first as f32, 0.0, 0.0], [0.0; 4]],
                    Cell::Near { start, length } => [[1.0, start as f32, length as f32, 0.0], [0.0; 4]],
                    Cell::Far { surface: [x, y, z], distance, leaf } => {
                        [[2.0, leaf as f32, 0.0, 0.0], [x, y, z, distance]]
                    }
                });
            }
            let lists = self.parameters.len();
            for numbers in all.lists.chunks(4) {
                let record = |k: usize| numbers.get(k).map_or(0.0, |&number| records[number as usize]);
                self.parameters.push(std::array::from_fn(record));
            }
            let blend = shape_grid.smooth.map_or([0.0; 2], |blend| [blend.amount, blend.steps]);
            let ([x, y, z], roots, bounds) = (grid.min, grid.counts.map(|count| count as f32), shape_grid.bounds);
            self.parameters[header..header + HEADER].copy_from_slice(&[
                [x, y, z, grid.edge],
                [roots[0], roots[1], roots[2], any_record],
                [bounds.min[0], bounds.min[1], bounds.min[2], blend[0]],
                [bounds.max[0], bounds.max[1], bounds.max[2], blend[1]],
                [cells as f32, lists as f32, grid.lipschitz, grid.code_width],
            ]);
        }
    }

    /// Appends the record of a leaf; returns its index.
    pub(super) fn record(&mut self, kinds: &[String], choice: u32, leaf: u32) -> f32 {
        let shape = &self.field.leaves()[leaf as usize];
        let mut params = shape.params.clone();
        if shape.shape.reads_table() {
            // The table of a leaf is before its record.
            params = vec![self.parameters.len() as f32];
            self.parameters.extend(shape.params.chunks_exact(4).map(|v| [v[0], v[1], v[2], v[3]]));
        }
        let name = shape.shape.wgsl_name();
        let kind = kinds.iter().position(|kind| *kind == name).unwrap_or_default();
        let Pose { at, scale, .. } = shape.pose;
        let [x, y, z] = shape.pose.local_from_world();
        let place = self.parameters.len();
        self.parameters.extend([
            [at[0], at[1], at[2], scale],
            [x[0], x[1], x[2], kind as f32],
            [y[0], y[1], y[2], choice as f32],
            [z[0], z[1], z[2], leaf as f32],
        ]);
        params.resize(params.len().next_multiple_of(4).max(4), 0.0);
        self.parameters.extend(params.chunks_exact(4).map(|v| [v[0], v[1], v[2], v[3]]));
        place as f32
    }

    /// Prints the functions of all shape grids: `shape_grid_N_distance` and `shape_grid_N_surface`.
    pub(super) fn shape_grids(&self) -> String {
        if self.field.shape_grids().is_empty() {
            return String::new();
        }
        let mut text = format!("{CELL}\n{}\n", find());
        for (number, (shape_grid, &header)) in self.field.shape_grids().iter().zip(&self.shape_grid_starts).enumerate()
        {
            text += &self.code_members(number, shape_grid);
            text += &shape_grid_functions(number, shape_grid, header);
        }
        text
    }

    /// Prints the members of a grid that are code: `shape_grid_N_code_K_distance` and `shape_grid_N_code_K_surface`.
    fn code_members(&self, number: usize, shape_grid: &ShapeGrid) -> String {
        let member = |(index, tree)| {
            let mut distance = format!(
                "/// Signed distance to the member {index} of shape grid {number} that is code.\n\
                 fn shape_grid_{number}_code_{index}_distance(p: vec3f, estimate: bool) -> f32 {{\n"
            );
            let value = self.tree_distance(tree, &mut distance, &mut 0, "estimate");
            let mut surface = format!(
                "/// Surface of the member {index} of shape grid {number} that is code.\n\
                 fn shape_grid_{number}_code_{index}_surface(p: vec3f, seed: u32) -> Surface {{\n"
            );
            let (gradient, leaf) = self.tree_surface(tree, &mut surface, &mut 0);
            format!(
                "{distance}    return {value};\n}}\n\n{surface}    return Surface({gradient}.xyz, {gradient}.w, {leaf}, \
                 NO_TRIANGLE);\n}}\n\n"
            )
        };
        shape_grid.code.iter().enumerate().map(member).collect()
    }

    /// Prints distance and gradient of the shape of a record.
    pub(super) fn records(&self) -> String {
        let kinds = self.record_kinds();
        if kinds.is_empty() {
            return String::new();
        }
        let local = "    let at = field_vector(record);\n    let x = field_vector(record + 1u);\n    \
                     let y = field_vector(record + 2u);\n    let z = field_vector(record + 3u);\n    \
                     let n = field_vector(record + 4u);\n    let q = (p - at.xyz) * mat3x3f(x.xyz, y.xyz, z.xyz);\n";
        format!(
            "/// Signed distance to the shape of a record.\nfn record_distance(record: u32, p: vec3f) -> f32 {{\n{local}    var d = \
             1e30;\n{}    return d * at.w;\n}}\n\n/// Gradient (xyz) and distance (w) of the shape of a record.\n\
             fn record_gradient(record: u32, p: vec3f) -> vec4f {{\n{local}    var d = vec4f(0.0, 0.0, 0.0, 1e30);\n{}    return \
             vec4f(mat3x3f(x.xyz, y.xyz, z.xyz) * d.xyz, d.w) * at.w;\n}}\n\n",
            cases(&kinds, "d", "distance", "q"),
            cases(&kinds, "d", "gradient", "q"),
        )
    }
}

/// Kind of a shape with records, for calls of its functions.
pub(super) struct RecordKind {
    pub(super) name: String,
    /// Number of coefficients, or 1 for the index of a table.
    pub(super) arguments: usize,
    pub(super) is_long: bool,
    pub(super) has_ray: bool,
}

/// Reports whether a function loops or is long, so that skipping it pays.
pub(super) fn is_long(function: &str) -> bool {
    function.contains("for (")
        || function.contains("loop")
        || function.contains("while")
        || function.lines().count() > 60
}

/// Prints the choice of a record's function by its kind `x.w`, and its call with the coefficients in `n`; sets `result`.
pub(super) fn cases(kinds: &[RecordKind], result: &str, function: &str, inputs: &str) -> String {
    let call = |kind: &RecordKind| {
        let numbers: String = (0..kind.arguments)
            .map(|k| match k {
                0..4 => format!(", n.{}", ["x", "y", "z", "w"][k]),
                _ => format!(", field_vector(record + {}u).{}", RECORD - 1 + k / 4, ["x", "y", "z", "w"][k % 4]),
            })
            .collect();
        format!("{result} = {}_{function}({inputs}{numbers});", kind.name)
    };
    if let [item] = kinds {
        return format!("    {}\n", call(item));
    }
    let mut text = String::from("    switch u32(x.w) {\n");
    let is_called = |kind: &RecordKind| kind.has_ray || function != "ray";
    for (number, item) in kinds.iter().enumerate().filter(|(_, item)| !item.is_long && is_called(item)) {
        writeln!(text, "        case {number}u: {{\n            {}\n        }}", call(item))
            .expect("writing to a string");
    }
    text += "        default: {}\n    }\n";
    for (number, item) in kinds.iter().enumerate().filter(|(_, item)| item.is_long && is_called(item)) {
        writeln!(
            text,
            "    loop {{\n        if u32(x.w) != {number}u {{\n            break;\n        }}\n        {}\n        break;\n    }}",
            call(item)
        )
        .expect("writing to a string");
    }
    text
}

/// Prints the descent to a cell.
fn find() -> String {
    let mut text = format!(
        "fn shape_grid_cell(header: u32, p: vec3f) -> GridCell {{\n    let corner = field_vector(header);\n    let roots = \
         vec3u(field_vector(header + 1u).xyz);\n    let cells = u32(field_vector(header + 4u).x);\n    let q = (p - \
         corner.xyz) * (1.0 / corner.w);\n    let count = vec3f(roots << vec3u({BITS}u));\n    let inside = all(q >= \
         vec3f(0.0)) && all(q < count);\n    let place = vec3u(clamp(q, vec3f(0.0), count - 1.0));\n    var shift = {BITS}u;\n    \
         var offset = place >> vec3u(shift);\n    var index = cells + 2u * ((offset.z * roots.y + offset.y) * roots.x + offset.x);\n    var \
         entry = field_vector(index);\n"
    );
    let mut shift = BITS;
    for bits in SPLITS {
        shift -= bits;
        let mask = (1 << bits) - 1;
        writeln!(
            text,
            "    if entry.x == 0.0 {{\n        shift = {shift}u;\n        offset = (place >> vec3u(shift)) & vec3u({mask}u);\n        \
             index = cells + 2u * (u32(entry.y) + (((offset.z << {bits}u) + offset.y) << {bits}u) + offset.x);\n        entry = \
             field_vector(index);\n    }}"
        )
        .expect("writing to a string");
    }
    text + "    let edge = corner.w * f32(1u << shift);\n    let centre = corner.xyz + (vec3f(place >> vec3u(shift)) + 0.5) * edge;\n    \
            return GridCell(entry, field_vector(index + 1u), centre, inside);\n}\n"
}

fn shape_grid_functions(number: usize, shape_grid: &ShapeGrid, header: usize) -> String {
    let profile = profile(shape_grid.smooth);
    let name = union().wgsl_name(profile);
    let widths = match profile {
        None => "",
        Some(profile) if profile.has_steps() => ", width, steps",
        Some(_) => ", width",
    };
    let (signed, combined) = match shape_grid.separate {
        true => ("abs(d)", "min(result, abs(d))".to_owned()),
        false => ("d", format!("{name}_distance(result, d{widths})")),
    };
    let far_field =
        if shape_grid.separate { "far_field" } else { "select(far_field, -far_field, cell.far_field.w < 0.0)" };
    let numbers = format!(
        "    let width = field_vector({}).w;\n    let steps = field_vector({}).w;\n    let lists = \
         u32(field_vector({}).y);\n    let cell = shape_grid_cell({header}u, p);\n",
        header + 2,
        header + 3,
        header + 4
    );
    let code = CodeMembers { grid: number, count: shape_grid.code.len(), header };
    let listed = code.listed();
    let distance = format!(
        "/// Distance to shape grid {number}: exact near its surface, elsewhere a bound or, on request, an estimate.\n\
         fn shape_grid_{number}_distance(p: vec3f, estimate: bool) -> f32 {{\n{numbers}    let bounded = abs(cell.far_field.w) - \
         field_vector({lipschitz}).z * length(p - cell.centre);\n    let far_field = select(max(bounded, 0.0), length(p - \
         cell.far_field.xyz), estimate);\n    let beyond = max(max(field_vector({least}).xyz - p, p - \
         field_vector({most}).xyz), vec3f(0.0));\n    let outside = !cell.inside && !estimate;\n    var result = \
         select({far_field}, length(beyond) - field_vector({lipschitz}).w, outside);\n    let start = \
         u32(cell.entry.y);\n    let count = select(0u, u32(cell.entry.z), cell.entry.x == 1.0 && !outside);\n    for (var k \
         = 0u; k < count; k++) {{\n{listed}        {declared} d = record_distance(record, p);\n{codes}        result = \
         select({combined}, {signed}, k == 0u);\n    }}\n{outside}    return result;\n}}\n",
        lipschitz = header + 4,
        least = header + 2,
        most = header + 3,
        declared = code.declared(),
        codes = code.distances(),
        outside = code.distance_outside(&format!("{name}_distance"), widths),
    );
    let shown = match shape_grid.separate {
        true => {
            "        let shows = k == 0u || abs(d.w) < abs(result.w);\n        result = select(result, d, shows);\n"
                .to_owned()
        }
        false => {
            let threshold = match shape_grid.smooth {
                Some(_) => "choice(seed, u32(chosen))".to_owned(),
                None => "0.5".to_owned(),
            };
            format!(
                "        let shows = k == 0u || {threshold} < \
                 {name}_weight(result.w, d.w{widths});\n        result = select({name}_gradient(result, d{widths}), d, k == \
                 0u);\n"
            )
        }
    };
    let surface = format!(
        "/// Surface of shape grid {number}; far from it, of a plane in its place.\nfn shape_grid_{number}_surface(p: vec3f, seed: \
         u32) -> Surface {{\n{numbers}    let away = p - cell.far_field.xyz;\n    let value = select(length(away), -length(away), \
         cell.far_field.w < 0.0);\n    var result = vec4f(away / value, value);\n    var leaf = u32(cell.entry.y);\n    let start = \
         leaf;\n    let count = select(0u, u32(cell.entry.z), cell.entry.x == 1.0);\n    for (var k = 0u; k < count; k++) \
         {{\n{listed}        {declared} d = record_gradient(record, p);\n        {declared} chosen = field_vector(record + \
         2u).w;\n        {declared} other = u32(field_vector(record + 3u).w);\n{codes}{shown}        leaf = select(leaf, \
         other, shows);\n    }}\n{outside}    return Surface(result.xyz, result.w, leaf, NO_TRIANGLE);\n}}\n",
        declared = code.declared(),
        codes = code.surfaces(),
        outside = code.surface_outside(&name, widths, shape_grid.smooth.is_some()),
    );
    format!("{distance}\n{surface}\n")
}

/// Calls of the members of a grid that are code. Software Vulkan skips them only as loops with one pass.
struct CodeMembers {
    grid: usize,
    count: usize,
    header: usize,
}

impl CodeMembers {
    /// Keyword of what a member that is code replaces.
    fn declared(&self) -> &'static str {
        if self.count == 0 { "let" } else { "var" }
    }

    /// Prints the record of the member `start + k` of the lists; of code, any record.
    fn listed(&self) -> String {
        let place = "        let place = start + k;\n";
        let listed = "field_vector(lists + (place >> 2u))[place & 3u]";
        match self.count {
            0 => format!("{place}        let record = u32({listed});\n"),
            _ => format!(
                "{place}        let listed = {listed};\n        let record = u32(select(listed, field_vector({}).w, \
                 listed < 0.0));\n",
                self.header + 1
            ),
        }
    }

    /// Prints the choice of the member `listed`, if it is code, and statements for it.
    fn cases(&self, statements: impl Fn(usize) -> String) -> String {
        if self.count == 0 {
            return String::new();
        }
        let case = |index: usize| {
            format!(
                "            loop {{\n                if listed != {}.0 {{\n                    break;\n                }}\n{}                \
                 break;\n            }}\n",
                -1 - index as i64,
                statements(index)
            )
        };
        let cases: String = (0..self.count).map(case).collect();
        format!(
            "        loop {{\n            if listed >= 0.0 {{\n                break;\n            }}\n{cases}            break;\n        }}\n"
        )
    }

    fn distances(&self) -> String {
        self.cases(|index| {
            format!("                d = shape_grid_{}_code_{index}_distance(p, estimate);\n", self.grid)
        })
    }

    fn surfaces(&self) -> String {
        self.cases(|index| {
            format!(
                "                let code = shape_grid_{}_code_{index}_surface(p, seed);\n                d = vec4f(code.gradient, \
                 code.distance);\n                chosen = {};\n                other = code.leaf;\n",
                self.grid,
                self.choice(index)
            )
        })
    }

    fn choice(&self, index: usize) -> String {
        component(self.header + HEADER + index / 4, index % 4)
    }

    /// Prints the union with all code for points outside of the grid.
    fn distance_outside(&self, union: &str, widths: &str) -> String {
        let value = |index: usize| format!("shape_grid_{}_code_{index}_distance(p, estimate)", self.grid);
        let further: String =
            (1..self.count).map(|index| format!("        code = {union}(code, {}{widths});\n", value(index))).collect();
        self.outside(&format!("        var code = {};\n{further}        result = min(result, code);\n", value(0)))
    }

    fn surface_outside(&self, name: &str, widths: &str, is_smooth: bool) -> String {
        let surface = |index: usize| {
            format!("        let code{index} = shape_grid_{}_code_{index}_surface(p, seed);\n", self.grid)
        };
        let further = |index: usize| {
            let threshold = if is_smooth { format!("choice(seed, u32({}))", self.choice(index)) } else { "0.5".into() };
            format!(
                "{}        let d{index} = vec4f(code{index}.gradient, code{index}.distance);\n        code_leaf = select(code_leaf, \
                 code{index}.leaf, {threshold} < {name}_weight(code.w, d{index}.w{widths}));\n        code = \
                 {name}_gradient(code, d{index}{widths});\n",
                surface(index)
            )
        };
        let further: String = (1..self.count).map(further).collect();
        self.outside(&format!(
            "{}        var code = vec4f(code0.gradient, code0.distance);\n        var code_leaf = code0.leaf;\n{further}        leaf = \
             select(leaf, code_leaf, code.w < result.w);\n        result = select(result, code, code.w < result.w);\n",
            surface(0)
        ))
    }

    fn outside(&self, statements: &str) -> String {
        match self.count {
            0 => String::new(),
            _ => format!(
                "    loop {{\n        if cell.inside {{\n            break;\n        }}\n{statements}        break;\n    }}\n"
            ),
        }
    }
}
