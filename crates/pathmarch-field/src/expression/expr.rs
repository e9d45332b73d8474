//! Number type that records operations in an expression graph.

use crate::number::{Differentiable, Dual, Real, Vec3};
use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Number in the expression graph that this thread records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Expr(pub(super) u32);

impl Expr {
    /// Point `n` of the inputs of a recorded function.
    pub(crate) fn point(inputs: &[Self], n: usize) -> Vec3<Self> {
        Vec3::new(inputs[3 * n], inputs[3 * n + 1], inputs[3 * n + 2])
    }
    /// A dual number given as gradient (xyz) and value (w).
    pub(crate) fn dual(inputs: &[Self]) -> Dual<Self> {
        Dual { value: inputs[3], gradient: Vec3::new(inputs[0], inputs[1], inputs[2]) }
    }
    /// A dual number as outputs: gradient (xyz) and value (w).
    pub(crate) fn outputs(result: Dual<Self>) -> Vec<Self> {
        vec![result.gradient.x, result.gradient.y, result.gradient.z, result.value]
    }
}

/// Truth value in the expression graph that this thread records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprMask(pub(super) u32);

/// Operation of the graph; operands are indices of earlier nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// Constant, as the bits of an `f32`.
    Constant(u32),
    /// Constant truth value.
    Truth(bool),
    /// Input of the function, by index.
    Input(u32),
    Binary(Binary, u32, u32),
    Unary(Unary, u32),
    /// Mask, value where true, value where false.
    Select(u32, u32, u32),
    /// Vector of a table, by index.
    Vector(u32),
    /// Component of a vector, by index.
    Component(u32, u32),
    /// Variable of a loop's state during the loop: loop, index.
    LoopVariable(u32, u32),
    /// Loop as a whole, at the place where it is printed.
    Loop(u32),
    /// Variable of a loop's state after the loop: loop, index.
    LoopResult(u32, u32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    Atan2,
    Less,
    And,
    Or,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Neg,
    Sqrt,
    Abs,
    Floor,
    Sin,
    Cos,
    Exp,
    Ln,
    Not,
}

/// Recorded loop.
#[derive(Clone, Debug)]
pub(super) struct LoopRecord {
    pub(super) count: u32,
    pub(super) limit: u32,
    pub(super) initial: Vec<u32>,
    pub(super) next: Vec<u32>,
    pub(super) go_on: u32,
    /// Loop around this one.
    pub(super) parent: Option<u32>,
    pub(super) depth: u32,
}

/// Expression graph under construction.
#[derive(Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
    /// Innermost loop on which each node depends.
    pub(super) home: Vec<Option<u32>>,
    pub(super) names: HashMap<u32, &'static str>,
    pub(super) loops: Vec<LoopRecord>,
    known: HashMap<Node, u32>,
    open: Vec<u32>,
}

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::default();
}

/// Records `body` with `inputs` inputs. Returns the graph and the outputs.
pub(super) fn record(inputs: usize, body: &dyn Fn(&[Expr]) -> Vec<Expr>) -> (Graph, Vec<u32>) {
    GRAPH.with_borrow_mut(|graph| *graph = Graph::default());
    let inputs: Vec<Expr> = (0..inputs).map(|k| Expr(push(Node::Input(k as u32)))).collect();
    let outputs = body(&inputs).into_iter().map(|e| e.0).collect();
    (GRAPH.take(), outputs)
}

#[inline(never)]
fn push(node: Node) -> u32 {
    GRAPH.with_borrow_mut(|graph| graph.push(node))
}

impl Graph {
    fn push(&mut self, node: Node) -> u32 {
        if let Some(&index) = self.known.get(&node) {
            return index;
        }
        let home = match node {
            Node::Constant(_) | Node::Truth(_) | Node::Input(_) => None,
            Node::Binary(_, a, b) => self.inner(self.home[a as usize], self.home[b as usize]),
            Node::Unary(_, a) | Node::Vector(a) | Node::Component(a, _) => self.home[a as usize],
            Node::Select(m, a, b) => {
                let inner = self.inner(self.home[a as usize], self.home[b as usize]);
                self.inner(self.home[m as usize], inner)
            }
            Node::LoopVariable(id, _) => Some(id),
            Node::Loop(id) | Node::LoopResult(id, _) => self.loops[id as usize].parent,
        };
        let index = self.nodes.len() as u32;
        self.nodes.push(node);
        self.home.push(home);
        self.known.insert(node, index);
        index
    }

    fn inner(&self, a: Option<u32>, b: Option<u32>) -> Option<u32> {
        let depth = |home: Option<u32>| home.map_or(0, |id| self.loops[id as usize].depth);
        if depth(a) >= depth(b) { a } else { b }
    }
}

fn value_of(index: u32) -> Option<f32> {
    GRAPH.with_borrow(|graph| match graph.nodes[index as usize] {
        Node::Constant(bits) => Some(f32::from_bits(bits)),
        _ => None,
    })
}

fn negated(index: u32) -> Option<u32> {
    GRAPH.with_borrow(|graph| match graph.nodes[index as usize] {
        Node::Unary(Unary::Neg, inner) => Some(inner),
        _ => None,
    })
}

/// Adds an operation. Folds constants and drops operations without effect, so that gradients have no `0 * x`.
#[inline(never)]
fn binary(op: Binary, a: u32, b: u32) -> u32 {
    let (ca, cb) = (value_of(a), value_of(b));
    if let (Some(x), Some(y)) = (ca, cb) {
        let folded = match op {
            Binary::Add => Some(x + y),
            Binary::Sub => Some(x - y),
            Binary::Mul => Some(x * y),
            Binary::Div => Some(x / y),
            Binary::Min => Some(x.min(y)),
            Binary::Max => Some(x.max(y)),
            _ => None,
        };
        if let Some(value) = folded.filter(|v| v.is_finite()) {
            return Expr::constant(value).0;
        }
    }
    match (op, ca, cb) {
        (Binary::Add, Some(0.0), _) | (Binary::Mul, Some(1.0), _) => b,
        (Binary::Add | Binary::Sub, _, Some(0.0)) | (Binary::Mul | Binary::Div, _, Some(1.0)) => a,
        (Binary::Sub, Some(0.0), _) | (Binary::Mul, Some(-1.0), _) => unary(Unary::Neg, b),
        (Binary::Mul | Binary::Div, _, Some(-1.0)) => unary(Unary::Neg, a),
        (Binary::Mul | Binary::Div, Some(0.0), _) | (Binary::Mul, _, Some(0.0)) => Expr::constant(0.0).0,
        (Binary::Sub | Binary::Div, _, _) if a == b => Expr::constant(if op == Binary::Sub { 0.0 } else { 1.0 }).0,
        (Binary::Min | Binary::Max | Binary::And | Binary::Or, _, _) if a == b => a,
        (Binary::Add, _, _) if a == b => binary(Binary::Mul, Expr::constant(2.0).0, a),
        (Binary::Add, _, _) if negated(b).is_some() => binary(Binary::Sub, a, negated(b).unwrap_or(b)),
        (Binary::Add, _, _) if negated(a).is_some() => binary(Binary::Sub, b, negated(a).unwrap_or(a)),
        (Binary::Sub, _, _) if negated(b).is_some() => binary(Binary::Add, a, negated(b).unwrap_or(b)),
        _ => push(Node::Binary(op, a, b)),
    }
}

#[inline(never)]
fn unary(op: Unary, a: u32) -> u32 {
    if op == Unary::Neg {
        if let Some(value) = value_of(a) {
            return Expr::constant(-value).0;
        }
        if let Some(inner) = negated(a) {
            return inner;
        }
    }
    push(Node::Unary(op, a))
}

macro_rules! operator {
    ($trait:ident, $method:ident, $type:ident) => {
        operator!($trait, $method, $type, $trait);
    };
    ($trait:ident, $method:ident, $type:ident, $op:ident) => {
        impl $trait for $type {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(binary(Binary::$op, self.0, other.0))
            }
        }
    };
}
operator!(Add, add, Expr);
operator!(Sub, sub, Expr);
operator!(Mul, mul, Expr);
operator!(Div, div, Expr);
operator!(BitAnd, bitand, ExprMask, And);
operator!(BitOr, bitor, ExprMask, Or);

impl Neg for Expr {
    type Output = Self;
    fn neg(self) -> Self {
        Self(unary(Unary::Neg, self.0))
    }
}

impl Not for ExprMask {
    type Output = Self;
    fn not(self) -> Self {
        Self(unary(Unary::Not, self.0))
    }
}

/// Body of a recorded loop: from the state to the next state and the condition to go on.
type LoopBody<'a> = dyn Fn(&[Expr]) -> (Vec<u32>, u32) + 'a;

/// Records a loop over `initial`. Returns the state after it.
fn record_loop(count: u32, limit: u32, initial: Vec<u32>, body: &LoopBody) -> Vec<Expr> {
    let id = GRAPH.with_borrow_mut(|graph| {
        let parent = graph.open.last().copied();
        let depth = graph.open.len() as u32 + 1;
        graph.loops.push(LoopRecord {
            count,
            limit,
            initial: initial.clone(),
            next: Vec::new(),
            go_on: 0,
            parent,
            depth,
        });
        let id = graph.loops.len() as u32 - 1;
        graph.open.push(id);
        id
    });
    let variables: Vec<Expr> = (0..initial.len()).map(|k| Expr(push(Node::LoopVariable(id, k as u32)))).collect();
    let (next, go_on) = body(&variables);
    GRAPH.with_borrow_mut(|graph| {
        graph.open.pop();
        graph.loops[id as usize].next = next;
        graph.loops[id as usize].go_on = go_on;
    });
    push(Node::Loop(id));
    (0..initial.len()).map(|k| Expr(push(Node::LoopResult(id, k as u32)))).collect()
}

/// Names a node, unless it is a constant or an input or has a name.
fn set_name(index: u32, name: &'static str) {
    GRAPH.with_borrow_mut(|graph| {
        if !matches!(graph.nodes[index as usize], Node::Constant(_) | Node::Input(_)) {
            graph.names.entry(index).or_insert(name);
        }
    });
}

/// Nodes of a loop's state.
fn flat(state: &[Expr]) -> Vec<u32> {
    state.iter().map(|e| e.0).collect()
}

/// Nodes of a loop's state of dual numbers: the value of each, then its gradient.
fn flat_duals(state: &[Dual<Expr>]) -> Vec<u32> {
    state.iter().flat_map(|d| [d.value.0, d.gradient.x.0, d.gradient.y.0, d.gradient.z.0]).collect()
}

/// First dual number of a flat state.
fn dual(flat: &[Expr]) -> Dual<Expr> {
    Dual { value: flat[0], gradient: Vec3::new(flat[1], flat[2], flat[3]) }
}

impl Real for Expr {
    type Mask = ExprMask;

    #[inline(never)]
    fn constant(value: f32) -> Self {
        // One zero, so that -0 and 0 print and fold alike.
        let value = if value == 0.0 { 0.0 } else { value };
        Self(push(Node::Constant(value.to_bits())))
    }
    fn sqrt(self) -> Self {
        Self(unary(Unary::Sqrt, self.0))
    }
    fn abs(self) -> Self {
        Self(unary(Unary::Abs, self.0))
    }
    fn min(self, other: Self) -> Self {
        Self(binary(Binary::Min, self.0, other.0))
    }
    fn max(self, other: Self) -> Self {
        Self(binary(Binary::Max, self.0, other.0))
    }
    fn floor(self) -> Self {
        Self(unary(Unary::Floor, self.0))
    }
    fn sin(self) -> Self {
        Self(unary(Unary::Sin, self.0))
    }
    fn cos(self) -> Self {
        Self(unary(Unary::Cos, self.0))
    }
    fn atan2(self, x: Self) -> Self {
        Self(binary(Binary::Atan2, self.0, x.0))
    }
    fn exp(self) -> Self {
        Self(unary(Unary::Exp, self.0))
    }
    fn ln(self) -> Self {
        Self(unary(Unary::Ln, self.0))
    }
    fn lt(self, other: Self) -> ExprMask {
        ExprMask(push(Node::Binary(Binary::Less, self.0, other.0)))
    }
    fn truth(value: bool) -> ExprMask {
        ExprMask(push(Node::Truth(value)))
    }
    fn select(mask: ExprMask, yes: Self, no: Self) -> Self {
        if yes == no { yes } else { Self(push(Node::Select(mask.0, yes.0, no.0))) }
    }
    #[inline(never)]
    fn vector(_table: &[f32], index: Self) -> [Self; 4] {
        let vector = push(Node::Vector(index.0));
        std::array::from_fn(|k| Self(push(Node::Component(vector, k as u32))))
    }
    fn iterate<const K: usize>(
        count: Self,
        limit: u32,
        state: [Self; K],
        body: impl Fn([Self; K]) -> ([Self; K], ExprMask),
    ) -> [Self; K] {
        let results = record_loop(count.0, limit, flat(&state), &|variables| {
            let (next, go_on) = body(std::array::from_fn(|k| variables[k]));
            (flat(&next), go_on.0)
        });
        std::array::from_fn(|k| results[k])
    }
    fn named(self, name: &'static str) -> Self {
        set_name(self.0, name);
        self
    }
}

impl Differentiable for Expr {
    fn iterate_dual<const K: usize>(
        count: Dual<Self>,
        limit: u32,
        state: [Dual<Self>; K],
        body: impl Fn([Dual<Self>; K]) -> ([Dual<Self>; K], ExprMask),
    ) -> [Dual<Self>; K] {
        let gather = |flat: &[Expr]| -> [Dual<Self>; K] { std::array::from_fn(|k| dual(&flat[4 * k..])) };
        let results = record_loop(count.value.0, limit, flat_duals(&state), &|variables| {
            let (next, go_on) = body(gather(variables));
            (flat_duals(&next), go_on.0)
        });
        gather(&results)
    }
}
