//! Printer of an expression graph as one WGSL function.
//!
//! A value that is used once is printed inline, as long as the line is short. Every other value becomes a `let`, named by its
//! author ([`Real::named`](crate::number::Real::named)) or `t1`, `t2`, …. Values that do not change in a loop are computed before
//! it.

use super::expr::{Binary, Expr, Graph, Node, Unary, record};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;

/// Longest inline expression, in characters.
const LONGEST_INLINE: usize = 64;

/// WGSL function that reads a vector of the table; see [`TABLE`](crate::wgsl::TABLE).
const TABLE_VECTOR: &str = "table_vector";

/// Names that WGSL reserves and parameters could have.
const RESERVED: [&str; 14] = [
    "union", "smooth", "box", "loop", "switch", "target", "filter", "mod", "move", "ref", "self", "type", "unit",
    "final",
];

/// Converts a name to a WGSL identifier.
pub(crate) fn identifier(name: &str) -> String {
    let name = name.replace('-', "_");
    if RESERVED.contains(&name.as_str()) { name + "_" } else { name }
}

/// Signature of a function to be recorded.
pub struct Function<'a> {
    /// Name, already an identifier.
    pub name: String,
    /// Documentation, one line.
    pub doc: String,
    /// Parameters as declared: name and type (`f32`, `vec3f`, `vec4f`); the body gets the scalar components in order.
    pub parameters: Vec<(&'a str, &'static str)>,
}

impl Function<'_> {
    /// Records `body` and prints it. One output returns an `f32`, two a `vec2f`, three a `vec3f`, four a `vec4f`, any other number
    /// an array.
    ///
    /// `body` is a trait object so that this is compiled once, not for each of some 160 functions.
    pub fn print(&self, body: &dyn Fn(&[Expr]) -> Vec<Expr>) -> String {
        let mut inputs = Vec::new();
        for (name, kind) in &self.parameters {
            let name = identifier(name);
            match *kind {
                "vec3f" => inputs.extend(["x", "y", "z"].map(|c| format!("{name}.{c}"))),
                "vec4f" => inputs.extend(["x", "y", "z", "w"].map(|c| format!("{name}.{c}"))),
                _ => inputs.push(name),
            }
        }
        let (graph, outputs) = record(inputs.len(), body);
        let parameters: Vec<String> =
            self.parameters.iter().map(|(name, kind)| format!("{}: {kind}", identifier(name))).collect();
        let result = match outputs.len() {
            1 => "f32".to_owned(),
            2 => "vec2f".to_owned(),
            3 => "vec3f".to_owned(),
            4 => "vec4f".to_owned(),
            count => format!("array<f32, {count}>"),
        };
        let mut text = format!("/// {}\nfn {}({}) -> {result} {{\n", self.doc, self.name, parameters.join(", "));
        let mut printer = Printer::new(&graph, inputs, &outputs);
        printer.returned = if outputs.len() == 1 { outputs.first().copied() } else { None };
        printer.scope(None, 1, &mut text);
        let values: Vec<String> = outputs.iter().map(|&o| printer.operand(o, None, 0)).collect();
        match values.as_slice() {
            [value] => writeln!(text, "    return {value};"),
            _ => writeln!(text, "    return {result}(\n        {},\n    );", values.join(",\n        ")),
        }
        .expect("writing to a string");
        text + "}\n"
    }
}

struct Printer<'a> {
    graph: &'a Graph,
    inputs: Vec<String>,
    uses: Vec<u32>,
    /// Nodes used by a node of another scope: these must be a `let`.
    crossing: HashSet<u32>,
    written: HashMap<u32, String>,
    taken: HashSet<String>,
    counter: u32,
    /// Node returned by a function of one output; inlined in the `return` at any length.
    returned: Option<u32>,
}

impl<'a> Printer<'a> {
    fn new(graph: &'a Graph, inputs: Vec<String>, outputs: &[u32]) -> Self {
        let taken = inputs.iter().map(|i| i.split('.').next().unwrap_or(i).to_owned()).collect();
        let mut printer = Self {
            graph,
            inputs,
            uses: vec![0; graph.nodes.len()],
            crossing: HashSet::new(),
            written: HashMap::new(),
            taken,
            counter: 0,
            returned: None,
        };
        for &output in outputs {
            printer.count(output, None);
        }
        printer
    }

    /// Counts the uses of everything `index` needs, itself used from scope `user`.
    fn count(&mut self, index: u32, user: Option<u32>) {
        let home = self.graph.home[index as usize];
        if home != user {
            self.crossing.insert(index);
        }
        self.uses[index as usize] += 1;
        if self.uses[index as usize] > 1 {
            return;
        }
        match self.graph.nodes[index as usize] {
            Node::Constant(_) | Node::Truth(_) | Node::Input(_) | Node::LoopVariable(..) => {}
            Node::Binary(_, a, b) => {
                self.count(a, home);
                self.count(b, home);
            }
            Node::Unary(_, a) | Node::Vector(a) | Node::Component(a, _) => self.count(a, home),
            Node::Select(m, a, b) => {
                self.count(m, home);
                self.count(a, home);
                self.count(b, home);
            }
            Node::LoopResult(id, _) => {
                let node = self.graph.nodes.iter().position(|n| *n == Node::Loop(id));
                if let Some(node) = node {
                    self.count(node as u32, home);
                }
            }
            Node::Loop(id) => {
                let record = self.graph.loops[id as usize].clone();
                self.count(record.count, home);
                for &initial in &record.initial {
                    self.count(initial, home);
                }
                for &next in &record.next {
                    self.count(next, Some(id));
                }
                // Always a `let`: it is tested after the stores but computed before them.
                self.count(record.go_on, Some(id));
                self.crossing.insert(record.go_on);
            }
        }
    }

    fn fresh(&mut self, wanted: Option<&str>) -> String {
        let wanted = wanted.map(identifier);
        loop {
            let name = match &wanted {
                Some(name) if !self.taken.contains(name) => name.clone(),
                Some(name) => {
                    self.counter += 1;
                    format!("{name}{}", self.counter)
                }
                None => {
                    self.counter += 1;
                    format!("t{}", self.counter)
                }
            };
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }

    /// Prints every `let` and loop of one scope, in the order they were recorded.
    fn scope(&mut self, scope: Option<u32>, indent: usize, text: &mut String) {
        let pad = "    ".repeat(indent);
        for index in 0..self.graph.nodes.len() as u32 {
            if self.uses[index as usize] == 0 || self.graph.home[index as usize] != scope {
                continue;
            }
            match self.graph.nodes[index as usize] {
                Node::Constant(_) | Node::Truth(_) | Node::Input(_) | Node::LoopVariable(..) | Node::LoopResult(..) => {
                }
                Node::Loop(id) => self.print_loop(id, indent, text),
                _ => {
                    let shared = self.uses[index as usize] > 1 || self.crossing.contains(&index);
                    let name = self.graph.names.get(&index).copied();
                    let value = self.expression(index, scope, 0);
                    let long = value.len() > LONGEST_INLINE && self.returned != Some(index);
                    if shared || name.is_some() || long {
                        let name = self.fresh(name);
                        writeln!(text, "{pad}let {name} = {value};").expect("writing to a string");
                        self.written.insert(index, name);
                    }
                }
            }
        }
    }

    fn print_loop(&mut self, id: u32, indent: usize, text: &mut String) {
        let pad = "    ".repeat(indent);
        let record = self.graph.loops[id as usize].clone();
        let mut variables = Vec::new();
        for (k, &initial) in record.initial.iter().enumerate() {
            let position = self.graph.nodes.iter().position(|n| *n == Node::LoopVariable(id, k as u32));
            let hint = position.and_then(|p| self.graph.names.get(&(p as u32)).copied());
            let name = self.fresh(hint.or(Some("s")));
            let initial = self.operand(initial, record.parent, 0);
            writeln!(text, "{pad}var {name} = {initial};").expect("writing to a string");
            if let Some(position) = position {
                self.written.insert(position as u32, name.clone());
            }
            variables.push(name);
        }
        let limit = record.limit;
        let count = match self.graph.nodes[record.count as usize] {
            Node::Constant(bits) => format!("{}u", (f32::from_bits(bits) as u32).min(limit)),
            _ => format!("min(u32({}), {limit}u)", self.operand(record.count, record.parent, 0)),
        };
        let counter = self.fresh(Some("i"));
        writeln!(text, "{pad}for (var {counter} = 0u; {counter} < {count}; {counter}++) {{")
            .expect("writing to a string");
        self.scope(Some(id), indent + 1, text);
        let inner = "    ".repeat(indent + 1);
        // All next values are computed before the first is stored.
        let mut stores = Vec::new();
        for (variable, &next) in variables.iter().zip(&record.next) {
            let value = self.operand(next, Some(id), 0);
            if value == *variable {
                continue;
            }
            if value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') && !variables.contains(&value) {
                stores.push((variable, value));
            } else {
                let name = self.fresh(Some(&format!("{variable}_next")));
                writeln!(text, "{inner}let {name} = {value};").expect("writing to a string");
                stores.push((variable, name));
            }
        }
        for (variable, value) in stores {
            writeln!(text, "{inner}{variable} = {value};").expect("writing to a string");
        }
        if self.graph.nodes[record.go_on as usize] != Node::Truth(true) {
            let go_on = self.operand(record.go_on, Some(id), 0);
            writeln!(
                text,
                "{inner}if !({go_on}) {{
{inner}    break;
{inner}}}"
            )
            .expect("writing to a string");
        }
        writeln!(text, "{pad}}}").expect("writing to a string");
        for (k, name) in variables.iter().enumerate() {
            let result = self.graph.nodes.iter().position(|n| *n == Node::LoopResult(id, k as u32));
            if let Some(result) = result {
                self.written.insert(result as u32, name.clone());
            }
        }
    }

    /// Text of a node as an operand of an operation of this precedence.
    fn operand(&self, index: u32, scope: Option<u32>, precedence: u8) -> String {
        match self.written.get(&index) {
            Some(name) => name.clone(),
            None => self.expression(index, scope, precedence),
        }
    }

    fn expression(&self, index: u32, scope: Option<u32>, outer: u8) -> String {
        let (text, precedence) = match self.graph.nodes[index as usize] {
            Node::Constant(bits) => {
                let value = f32::from_bits(bits);
                (format!("{value:?}"), if value < 0.0 { 3 } else { 4 })
            }
            Node::Truth(value) => (value.to_string(), 4),
            Node::Vector(index) => (format!("{TABLE_VECTOR}({})", self.operand(index, scope, 0)), 4),
            Node::Component(vector, k) => {
                (format!("{}.{}", self.operand(vector, scope, 4), ["x", "y", "z", "w"][k as usize]), 4)
            }
            Node::Input(k) => (self.inputs[k as usize].clone(), 4),
            Node::Unary(op, a) => match op {
                Unary::Neg => (format!("-{}", self.operand(a, scope, 4)), 3),
                Unary::Not => (format!("!{}", self.operand(a, scope, 4)), 3),
                _ => {
                    let name = match op {
                        Unary::Sqrt => "sqrt",
                        Unary::Abs => "abs",
                        Unary::Floor => "floor",
                        Unary::Sin => "sin",
                        Unary::Cos => "cos",
                        Unary::Exp => "exp",
                        _ => "log",
                    };
                    (format!("{name}({})", self.operand(a, scope, 0)), 4)
                }
            },
            Node::Binary(op, a, b) => {
                let infix = |symbol: &str, precedence: u8| {
                    let left = self.operand(a, scope, precedence);
                    let right = self.operand(b, scope, precedence + 1);
                    (format!("{left} {symbol} {right}"), precedence)
                };
                let call =
                    |name: &str| (format!("{name}({}, {})", self.operand(a, scope, 0), self.operand(b, scope, 0)), 4);
                match op {
                    Binary::Add => infix("+", 1),
                    Binary::Sub => infix("-", 1),
                    Binary::Mul => infix("*", 2),
                    Binary::Div => infix("/", 2),
                    Binary::Min => call("min"),
                    Binary::Max => call("max"),
                    Binary::Atan2 => call("atan2"),
                    // Comparisons bind loosest and are always parenthesised inside anything.
                    Binary::Less => (format!("{} < {}", self.operand(a, scope, 1), self.operand(b, scope, 1)), 0),
                    Binary::And => (format!("({}) && ({})", self.operand(a, scope, 0), self.operand(b, scope, 0)), 0),
                    Binary::Or => (format!("({}) || ({})", self.operand(a, scope, 0), self.operand(b, scope, 0)), 0),
                }
            }
            Node::Select(mask, yes, no) => (
                format!(
                    "select({}, {}, {})",
                    self.operand(no, scope, 0),
                    self.operand(yes, scope, 0),
                    self.operand(mask, scope, 0)
                ),
                4,
            ),
            // Always printed by name.
            Node::LoopVariable(..) | Node::Loop(_) | Node::LoopResult(..) => ("0.0".to_owned(), 4),
        };
        if precedence < outer { format!("({text})") } else { text }
    }
}
