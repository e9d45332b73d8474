//! A scene's field as WGSL: one function for each kind of shape in use, composed for the scene.
//!
//! Structure is code, numbers are data: every number of the scene stands in [`Program::parameters`], so that a scene of
//! the same structure and other numbers runs the same code. Cost: linear in the number of shapes, microseconds each.

mod bvh;
mod coordinates;
mod crowd;
mod solids;

use crate::blend::{Blend, BlendProfile};
use crate::graph::{Field, Modified, Pose, Tree, Turn};
use std::collections::BTreeSet;
use std::fmt::Write;

/// The most vectors of parameters that fit the uniform memory every adapter has (64 KiB).
pub const MAX_UNIFORM_VECTORS: usize = 4096;

/// The numbers of a field, packed for the GPU.
pub type Parameters = Vec<[f32; 4]>;

/// A field's code and numbers.
///
/// The code expects an array `field_parameters` of `vec4f` and declares `marched_distance(p: vec3f) -> f32`,
/// `direct_hit(origin: vec3f, direction: vec3f) -> DirectHit`, the struct `Surface` and `surface(p: vec3f, met: u32, seed: u32)
/// -> Surface`, where `met` is that of a direct hit or `MARCHED`: the WGSL of the [`Field`] methods of these names, the last one that of [`Field::surface_met`].
#[derive(Clone, Debug)]
pub struct Program {
    /// WGSL text; equal for scenes of equal structure.
    pub code: String,
    /// WGSL text of `whole_distance(p: vec3f) -> f32`, the distance to all that `code` only marches in part: for those
    /// who need it, behind `code`.
    pub whole_distance: String,
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
const MARCHED = 0xffffffffu;

/// The first surface of closed form along a ray: metres, or 1e30, and what `surface` tells it by.
struct DirectHit {
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
        for tree in field.alone() {
            composer.distances(tree, &mut code_of_distances);
        }
        let mut whole_distance: String =
            code_of_distances.difference(&functions).map(|(_, f)| format!("{f}\n")).collect();
        whole_distance += &composer.whole_distance();
        let distance = composer.distance();
        let direct = composer.direct_hit();
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
        let has_tables = reads_tables || !field.crowds().is_empty() || !field.bvh().nodes.is_empty();
        if reads_tables {
            code += "\n";
            code += TABLE;
        }
        for (_, function) in &functions {
            code += "\n";
            code += function;
        }
        let crowds = composer.records() + &composer.crowds() + &composer.bvh();
        let code = format!("{code}\n{crowds}{distance}\n{direct}\n{surface}");
        let Composer { parameters, bvh_records, .. } = composer;
        Self { code, whole_distance, parameters, has_tables, bvh_records }
    }

    /// WGSL text, to stand behind [`code`](Self::code), of functions `NAME(p: vec3f, own: u32) -> f32`: each is
    /// [`Field::distance_to`] the objects that count.
    pub fn distances_to(field: &Field, named: &[(&str, &[bool])]) -> String {
        let Composed { composer, functions, .. } = Composed::new(field);
        let mut of_distances = BTreeSet::new();
        let mut text = String::new();
        for (bit, (name, counts)) in named.iter().enumerate() {
            let counted: Vec<&Tree> =
                field.alone_with(counts).filter(|(_, counts)| *counts).map(|(tree, _)| tree).collect();
            let crowds = field.crowds_that_count(counts);
            counted.iter().for_each(|tree| composer.distances(tree, &mut of_distances));
            let doc =
                "Distance from `p` to the nearest surface of the objects that count here, from either side, metres.";
            text +=
                &composer.unsigned_distance(&format!("{name}(p: vec3f, own: u32)"), doc, &counted, &crowds, Some(bit));
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
            crowd_starts: Vec::new(),
            bvh_start: 0,
            bvh_records: Vec::new(),
        };
        let mut functions = BTreeSet::new();
        let mut printed = BTreeSet::new();
        let mut in_crowds = vec![false; field.leaves().len()];
        let in_data = field.crowds().iter().flat_map(|crowd| crowd.leaves.iter().copied());
        in_data.chain(field.bvh().leaves()).for_each(|leaf| in_crowds[leaf as usize] = true);
        for (leaf, in_crowd) in field.leaves().iter().zip(in_crowds) {
            composer.starts.push(composer.parameters.len());
            if in_crowd {
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
        let mut has_choice = composer.crowd_functions(&mut functions);
        composer.bvh_functions(&mut functions);
        for tree in field.alone() {
            has_choice |= composer.operators(tree, &mut functions);
        }
        field.direct_alone().for_each(|tree| composer.rays(tree, &mut functions));
        field.marched_alone().for_each(|tree| composer.distances(tree, &mut functions));
        for tree in field.alone() {
            composer.modifiers(tree, &mut functions);
        }
        composer.tables();
        composer.crowd_numbers();
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
    /// Where what tells of each crowd starts.
    crowd_starts: Vec<usize>,
    /// Where what tells of the hierarchy starts.
    bvh_start: usize,
    /// Where the record of each of its leaves stands.
    bvh_records: Vec<(u32, usize)>,
}

fn profile(smooth: Option<Blend>) -> Option<BlendProfile> {
    smooth.map(|blend| blend.profile)
}

fn component(vector: usize, k: usize) -> String {
    format!("field_parameters[{vector}].{}", ["x", "y", "z", "w"][k])
}

impl Composer<'_> {
    fn place(&mut self, pose: &Pose, numbers: &[f32]) {
        if pose.moved || pose.turn != Turn::None {
            self.parameters.push([pose.at[0], pose.at[1], pose.at[2], pose.scale]);
        }
        if pose.turn == Turn::Turned {
            self.parameters.extend(pose.local_from_world().map(|[x, y, z]| [x, y, z, 0.0]));
        }
        for chunk in numbers.chunks(4) {
            self.parameters.push(std::array::from_fn(|k| chunk.get(k).copied().unwrap_or(0.0)));
        }
    }

    /// Puts the tables of shapes behind all other numbers, whose places do not depend on how long they are.
    fn tables(&mut self) {
        let leaves = self.field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.reads_table());
        for (index, leaf) in leaves {
            let (_, place) = local(&leaf.pose, self.starts[index], "p");
            self.parameters[place][0] = self.parameters.len() as f32;
            let vectors = leaf.params.chunks_exact(4).map(|v| [v[0], v[1], v[2], v[3]]);
            self.parameters.extend(vectors);
        }
    }

    /// Collects the functions of the operators in use and stores their widths; whether any blends.
    fn operators(&mut self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) -> bool {
        let (operator, smooth, children, first_choice) = match tree {
            Tree::Leaf(_) => return false,
            Tree::Modify(modified) => {
                let chooses = self.operators(&modified.inside, functions);
                // Those inside were numbered before.
                self.modifier_starts.push(self.parameters.len());
                self.place(&modified.pose, &modified.numbers);
                functions.insert((1, modified.modifier.wgsl()));
                return chooses;
            }
            Tree::Combine { operator, smooth, children, first_choice } => (operator, smooth, children, first_choice),
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
            Tree::Combine { operator, smooth, children, .. } => {
                functions.insert((1, operator.wgsl_distance(profile(*smooth))));
                children.iter().for_each(|child| self.distances(child, functions));
            }
            Tree::Modify(modified) => self.distances(&modified.inside, functions),
        }
    }

    /// Collects the functions of the modifiers of a tree: `modified_N_distance` and `modified_N_surface`, and those of what
    /// each holds.
    fn modifiers(&self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        match tree {
            Tree::Leaf(_) => {}
            Tree::Combine { children, .. } => children.iter().for_each(|child| self.modifiers(child, functions)),
            Tree::Modify(modified) => {
                self.modifiers(&modified.inside, functions);
                functions.insert((2, self.modified(modified)));
            }
        }
    }

    fn modified(&self, modified: &Modified) -> String {
        let Modified { modifier, index, places, pose, inside, .. } = modified;
        let name = modifier.wgsl_name();
        let start = self.modifier_starts[*index as usize];
        let (point, first) = local(pose, start, "world");
        let numbers = arguments(first, modified.numbers.len());
        let mut counter = 0;
        let mut distance = format!(
            "/// Signed distance to what modifier {index}, `{name}`, holds.\nfn inside_{index}_distance(p: vec3f) -> f32 {{\n"
        );
        let value = self.tree_distance(inside, &mut distance, &mut counter);
        distance += &format!("    return {value};\n}}\n");
        let mut counter = 0;
        let mut surface = format!(
            "/// The surface of what modifier {index}, `{name}`, holds.\nfn inside_{index}_surface(p: vec3f, seed: u32) -> Surface {{\n"
        );
        let (gradient, leaf) = self.tree_surface(inside, &mut surface, &mut counter);
        surface += &format!("    return Surface({gradient}.xyz, {gradient}.w, {leaf});\n}}\n");
        let scale = match pose.turn {
            Turn::None => String::new(),
            _ => format!(" * {}", component(start, 3)),
        };
        let (looked, found) = match places {
            1 => (String::new(), format!("inside_{index}_distance({name}_point(p, 0.0{numbers}))")),
            _ => (self.nearest(modified, &numbers, "nearest = min(nearest, distance);"), "nearest".to_owned()),
        };
        let whole_distance = format!(
            "/// Signed distance to modifier {index}, `{name}`.\nfn modified_{index}_distance(world: vec3f) -> f32 {{\n    let p = \
             {point};\n{looked}    return {name}_distance(p, {found}{numbers}){scale};\n}}\n"
        );
        let looked = self.chosen(modified, &numbers);
        let back = match pose.turn {
            Turn::None => "local".to_owned(),
            Turn::Scaled => format!("vec4f(local.xyz, local.w * {})", component(start, 3)),
            Turn::Turned => format!("vec4f({} * local.xyz, local.w) * {}", rows(start + 1), component(start, 3)),
        };
        let whole_surface = format!(
            "/// The surface of modifier {index}, `{name}`.\nfn modified_{index}_surface(world: vec3f, seed: u32) -> Surface {{\n    \
             let p = {point};\n{looked}    let inside = inside_{index}_surface({name}_point(p, chosen{numbers}), seed);\n    \
             let pulled = {name}_pull(p, chosen, inside.gradient{numbers});\n    \
             let local = {name}_gradient(p, vec4f(pulled, inside.distance){numbers});\n    let result = {back};\n    \
             return Surface(result.xyz, result.w, inside.leaf);\n}}\n"
        );
        [distance, surface, whole_distance, whole_surface].join("\n")
    }

    /// WGSL that does something with the `distance` of each place of what a modifier holds and with the `nearest` so far.
    fn nearest(&self, modified: &Modified, numbers: &str, then: &str) -> String {
        let Modified { modifier, index, places, .. } = modified;
        format!(
            "    var nearest = 1e30;\n    for (var place = 0u; place < {places}u; place++) {{\n        let distance = \
             inside_{index}_distance({}_point(p, f32(place){numbers}));\n        {then}\n    }}\n",
            modifier.wgsl_name()
        )
    }

    /// WGSL of `chosen`, the place where what a modifier holds is nearest to the point `p` of its space.
    fn chosen(&self, modified: &Modified, numbers: &str) -> String {
        let then =
            "chosen = select(chosen, f32(place), distance < nearest);\n        nearest = min(nearest, distance);";
        match modified.places {
            1 => "    let chosen = 0.0;\n".to_owned(),
            _ => "    var chosen = 0.0;\n".to_owned() + &self.nearest(modified, numbers, then),
        }
    }

    /// The numbers of a blend, as further arguments of a call.
    fn width(&self, first_choice: u32, smooth: Option<Blend>) -> String {
        let Some(blend) = smooth else { return String::new() };
        let place = self.widths.iter().find(|(choice, _)| *choice == first_choice);
        place.map_or(String::new(), |(_, vector)| arguments(*vector, if blend.profile.has_steps() { 2 } else { 1 }))
    }

    /// The point `p` in local coordinates of a leaf, and the call's arguments after it.
    fn arguments(&self, index: u32, p: &str) -> (String, String) {
        let leaf = &self.field.leaves()[index as usize];
        let (point, next) = local(&leaf.pose, self.starts[index as usize], p);
        (point, arguments(next, if leaf.shape.reads_table() { 1 } else { leaf.params.len() }))
    }

    fn distance(&self) -> String {
        let marched: Vec<&Tree> = self.field.marched_alone().collect();
        let crowds: Vec<usize> = (0..self.field.crowds().len()).collect();
        let doc = "Distance from `p` to the nearest surface that must be marched, from outside or inside, metres.";
        self.unsigned_distance("marched_distance(p: vec3f)", doc, &marched, &crowds, None)
    }

    /// A function of this signature; where it is of a set of objects that count, the leaf `own` of closed form does not,
    /// and distances to crowds are about what they are.
    fn unsigned_distance(
        &self,
        signature: &str,
        doc: &str,
        objects: &[&Tree],
        crowds: &[usize],
        set: Option<usize>,
    ) -> String {
        let mut text = format!("/// {doc}\nfn {signature} -> f32 {{\n    var nearest = 1e30;\n");
        let mut counter = 0;
        for object in objects {
            let value = self.tree_distance(object, &mut text, &mut counter);
            match self.field.direct(object).filter(|_| set.is_some()) {
                Some(leaf) => {
                    writeln!(text, "    nearest = select(min(nearest, abs({value})), nearest, own == {leaf}u);")
                }
                None => writeln!(text, "    nearest = min(nearest, abs({value}));"),
            }
            .expect("writing to a string");
        }
        for crowd in crowds {
            writeln!(text, "    nearest = min(nearest, abs(crowd_{crowd}_distance(p, {})));", set.is_some())
                .expect("writing to a string");
        }
        if let Some(set) = set.filter(|_| !self.field.bvh().nodes.is_empty()) {
            writeln!(text, "    nearest = bvh_distance(p, nearest, {}u, own);", 1 << set).expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    fn whole_distance(&self) -> String {
        let mut text = String::from(
            "/// Signed distance from `p` to the nearest surface, metres.\n\
             fn whole_distance(p: vec3f) -> f32 {\n    var nearest = 1e30;\n",
        );
        let mut counter = 0;
        for object in self.field.alone() {
            let value = self.tree_distance(object, &mut text, &mut counter);
            writeln!(text, "    nearest = min(nearest, {value});").expect("writing to a string");
        }
        for crowd in 0..self.field.crowds().len() {
            writeln!(text, "    nearest = min(nearest, crowd_{crowd}_distance(p, true));")
                .expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    fn tree_distance(&self, tree: &Tree, text: &mut String, counter: &mut u32) -> String {
        match tree {
            Tree::Leaf(index) => {
                let leaf = &self.field.leaves()[*index as usize];
                let (point, values) = self.arguments(*index, "p");
                let call = format!("{}_distance({point}{values})", leaf.shape.wgsl_name());
                if leaf.pose.turn == Turn::None {
                    call
                } else {
                    format!("{call} * {}", component(self.starts[*index as usize], 3))
                }
            }
            Tree::Modify(modified) => format!("modified_{}_distance(p)", modified.index),
            Tree::Combine { operator, smooth, children, first_choice } => {
                let mut result = self.tree_distance(&children[0], text, counter);
                let width = self.width(*first_choice, *smooth);
                for child in &children[1..] {
                    let other = self.tree_distance(child, text, counter);
                    let name = format!("d{counter}");
                    *counter += 1;
                    let function = operator.wgsl_name(profile(*smooth));
                    writeln!(text, "    let {name} = {function}_distance({result}, {other}{width});")
                        .expect("writing to a string");
                    result = name;
                }
                result
            }
        }
    }

    fn surface(&self) -> String {
        let mut text = String::from(
            "/// The surface that a ray met at `p`, of the leaf of a direct hit or of what is marched: its signed distance,\n\
             /// gradient, and the leaf whose material shows.\n\
             fn surface(p: vec3f, met: u32, seed: u32) -> Surface {\n    var nearest = vec4f(0.0, 0.0, 0.0, 1e30);\n    var leaf = 0u;\n",
        );
        let mut counter = 0;
        let marched: Vec<&Tree> = self.field.marched_alone().collect();
        if !marched.is_empty() || !self.field.crowds().is_empty() {
            text += &asked("met != MARCHED");
        }
        for object in &marched {
            let (value, leaf) = self.tree_surface(object, &mut text, &mut counter);
            writeln!(
                text,
                "    if abs({value}.w) < abs(nearest.w) {{\n        nearest = {value};\n        leaf = {leaf};\n    }}"
            )
            .expect("writing to a string");
        }
        for crowd in 0..self.field.crowds().len() {
            writeln!(
                text,
                "    let crowd{crowd} = crowd_{crowd}_surface(p, seed);\n    if abs(crowd{crowd}.distance) < abs(nearest.w) \
                 {{\n        nearest = vec4f(crowd{crowd}.gradient, crowd{crowd}.distance);\n        leaf = \
                 crowd{crowd}.leaf;\n    }}"
            )
            .expect("writing to a string");
        }
        if !marched.is_empty() || !self.field.crowds().is_empty() {
            text += ANSWERED;
        }
        for index in self.field.direct_alone().flat_map(solids::leaves) {
            let mut inner = String::new();
            let (value, leaf) = self.tree_surface(&Tree::Leaf(index), &mut inner, &mut counter);
            let sign = if self.field.leaves()[index as usize].hollow { "-" } else { "" };
            text += &asked(&format!("met != {leaf}"));
            text += &inner;
            writeln!(text, "    nearest = {sign}{value};\n    leaf = {leaf};").expect("writing to a string");
            text += ANSWERED;
        }
        if !self.field.bvh().nodes.is_empty() {
            text += &asked("met < BVH || met == MARCHED");
            text += "    let record = met - BVH;\n    nearest = item_gradient(record, p);\n    leaf = \
                     u32(field_parameters[record + 3u].w);\n";
            text += ANSWERED;
        }
        text + "    return Surface(nearest.xyz, nearest.w, leaf);\n}\n"
    }

    fn tree_surface(&self, tree: &Tree, text: &mut String, counter: &mut u32) -> (String, String) {
        let mut fresh = |prefix: &str| {
            *counter += 1;
            format!("{prefix}{}", *counter - 1)
        };
        match tree {
            Tree::Leaf(index) => {
                let leaf = &self.field.leaves()[*index as usize];
                let (point, values) = self.arguments(*index, "p");
                let call = format!("{}_gradient({point}{values})", leaf.shape.wgsl_name());
                let name = fresh("g");
                let start = self.starts[*index as usize];
                match leaf.pose.turn {
                    Turn::None => writeln!(text, "    let {name} = {call};"),
                    Turn::Scaled => {
                        writeln!(text, "    let {name} = {call} * vec4f(1.0, 1.0, 1.0, {});", component(start, 3))
                    }
                    Turn::Turned => {
                        let local = fresh("l");
                        let scale = component(start, 3);
                        writeln!(
                            text,
                            "    let {local} = {call};\n    let {name} = vec4f({} * {local}.xyz, {local}.w) * {scale};",
                            rows(start + 1)
                        )
                    }
                }
                .expect("writing to a string");
                (name, format!("{index}u"))
            }
            Tree::Modify(modified) => {
                let (name, surface) = (fresh("g"), fresh("s"));
                writeln!(
                    text,
                    "    let {surface} = modified_{}_surface(p, seed);\n    let {name} = vec4f({surface}.gradient, {surface}.distance);",
                    modified.index
                )
                .expect("writing to a string");
                (name, format!("{surface}.leaf"))
            }
            Tree::Combine { operator, smooth, children, first_choice } => {
                let (mut result, mut leaf) = self.tree_surface(&children[0], text, counter);
                let width = self.width(*first_choice, *smooth);
                let function = operator.wgsl_name(profile(*smooth));
                for (k, child) in children[1..].iter().enumerate() {
                    let (other, other_leaf) = self.tree_surface(child, text, counter);
                    let name = format!("g{counter}");
                    let chosen = format!("leaf{counter}");
                    *counter += 1;
                    let threshold = match smooth {
                        Some(_) => format!("choice(seed, {}u)", first_choice + k as u32),
                        None => "0.5".to_owned(),
                    };
                    writeln!(
                        text,
                        "    let {name} = {function}_gradient({result}, {other}{width});\n    let {chosen} = select({leaf}, \
                         {other_leaf}, {threshold} < {function}_weight({result}.w, {other}.w{width}));"
                    )
                    .expect("writing to a string");
                    (result, leaf) = (name, chosen);
                }
                (result, leaf)
            }
        }
    }
}

/// What no invocation needs is skipped by a loop that is left at once: software Vulkan runs both sides of an `if`.
fn asked(not: &str) -> String {
    format!("    loop {{\n        if {not} {{\n            break;\n        }}\n")
}

/// The end of what was [`asked`].
const ANSWERED: &str = "        break;\n    }\n";

/// The matrix whose columns are the rows stored from this vector on.
fn rows(start: usize) -> String {
    let row = |k: usize| format!("field_parameters[{}].xyz", start + k);
    format!("mat3x3f({}, {}, {})", row(0), row(1), row(2))
}

/// The point `p` in local coordinates whose numbers start here, and what stands behind those.
fn local(pose: &Pose, start: usize, p: &str) -> (String, usize) {
    let mut next = start;
    let mut point = p.to_owned();
    if pose.moved || pose.turn != Turn::None {
        if pose.moved {
            point = format!("{p} - field_parameters[{next}].xyz");
        }
        next += 1;
    }
    match pose.turn {
        Turn::None => {}
        Turn::Scaled => point = format!("({point}) / field_parameters[{}].w", next - 1),
        Turn::Turned => {
            point = format!("({point}) * {}", rows(next));
            next += 3;
        }
    }
    (point, next)
}

/// Numbers from this vector on, as further arguments of a call.
fn arguments(start: usize, count: usize) -> String {
    (0..count).map(|k| format!(", {}", component(start + k / 4, k % 4))).collect()
}
