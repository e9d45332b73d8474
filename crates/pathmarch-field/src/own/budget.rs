//! What a call of a field may cost: counted in its code before it runs, and in its loops while it does.
//!
//! WGSL has no recursion, so that only loops can take long, and calls that are nested. The latter are counted when the scene is
//! read: what a call of `distance` comes to when every call in it is written out is limited by [`MOST_OPERATIONS`]. Each
//! pass of a loop takes one from a budget of [`PASSES`] that all loops of one call share, and one more for every
//! [`OPERATIONS_IN_A_PASS`] operations in its body; when the budget is used up every loop breaks off. So a call does at most
//! about [`MOST_OPERATIONS`] + [`PASSES`] · [`OPERATIONS_IN_A_PASS`] operations, whatever its text says.
//!
//! A march has at most 256 steps; 256 passes in each are as many as Mesa's software Vulkan lets the loops of an invocation
//! have (65,535) before it ends them all without a word.

use naga::{
    AddressSpace, BinaryOperator, Block, Expression, FunctionArgument, GlobalVariable, Handle, Literal, Module, Range,
    Scalar, Span, Statement, Type, TypeInner,
};

/// How many passes of loops a call of `distance` has.
pub const PASSES: u32 = 256;
/// How many operations of a loop's body count as one pass.
pub const OPERATIONS_IN_A_PASS: u32 = 64;
/// How many operations `distance` may have with every call written out.
pub const MOST_OPERATIONS: u32 = 8192;

/// How many operations each function has, every call written out and every loop passed once.
pub(super) struct Costs(Vec<u32>);

impl Costs {
    pub(super) fn new(module: &Module) -> Self {
        let mut costs = Self(Vec::new());
        for (_, function) in module.functions.iter() {
            // What is called stands before what calls it.
            let cost = costs.block(&function.body);
            costs.0.push(cost.saturating_add(1));
        }
        costs
    }

    pub(super) fn of(&self, function: Handle<naga::Function>) -> u32 {
        self.0.get(function.index()).copied().unwrap_or(u32::MAX)
    }

    /// What a pass of a loop takes from the budget.
    pub(super) fn weight(&self, body: &Block, continuing: &Block) -> u32 {
        1 + self.block(body).saturating_add(self.block(continuing)) / OPERATIONS_IN_A_PASS
    }

    fn block(&self, block: &Block) -> u32 {
        let cost = |statement: &Statement| match statement {
            Statement::Emit(range) => range.index_range().len() as u32,
            Statement::Block(block) => self.block(block),
            Statement::If { accept, reject, .. } => self.block(accept).saturating_add(self.block(reject)),
            Statement::Switch { cases, .. } => {
                cases.iter().fold(1, |sum: u32, case| sum.saturating_add(self.block(&case.body)))
            }
            Statement::Loop { body, continuing, .. } => self.block(body).saturating_add(self.block(continuing)),
            Statement::Call { function, .. } => self.of(*function),
            _ => 1,
        };
        block.iter().fold(0, |sum: u32, statement| sum.saturating_add(cost(statement)))
    }
}

/// Makes every loop of a module count, gives the parameters of these names, which were overrides, to its functions as
/// arguments, and makes `entry` fill the budget. The counter has the name `counter`.
pub(super) fn instrument(module: &mut Module, entry: Handle<naga::Function>, params: &[String], counter: String) {
    let costs = Costs::new(module);
    let inner = |inner| Type { name: None, inner };
    let u32_type = module.types.insert(inner(TypeInner::Scalar(Scalar::U32)), Span::UNDEFINED);
    let f32_type = module.types.insert(inner(TypeInner::Scalar(Scalar::F32)), Span::UNDEFINED);
    let budget = module.global_variables.append(
        GlobalVariable {
            name: Some(counter),
            space: AddressSpace::Private,
            binding: None,
            ty: u32_type,
            init: None,
            memory_decorations: Default::default(),
        },
        Span::UNDEFINED,
    );
    let overrides = std::mem::take(&mut module.overrides);
    let results: Vec<Option<Handle<Type>>> =
        module.functions.iter().map(|(_, function)| function.result.as_ref().map(|result| result.ty)).collect();
    for (handle, function) in module.functions.iter_mut() {
        let before = function.arguments.len() as u32;
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::Override(param) = expression {
                let name = &overrides[*param].name;
                let index = params.iter().position(|param| Some(param) == name.as_ref()).unwrap_or_default();
                *expression = Expression::FunctionArgument(before + index as u32);
            }
        }
        let argument = |name: &String| FunctionArgument { name: Some(name.clone()), ty: f32_type, binding: None };
        function.arguments.extend(params.iter().map(argument));
        let mut work =
            Instrument { costs: &costs, expressions: &mut function.expressions, budget, before, params: params.len() };
        let mut body = work.block(std::mem::take(&mut function.body));
        if handle == entry {
            let mut start = Block::new();
            let pointer = work.add(Expression::GlobalVariable(budget));
            let value = work.add(Expression::Literal(Literal::U32(PASSES)));
            start.push(Statement::Store { pointer, value }, Span::UNDEFINED);
            start.append(&mut body);
            body = start;
        }
        if let Some(result) = results[handle.index()] {
            // A loop that never ended may end now: what then comes to the end of the function gives zero.
            let value = work.add(Expression::ZeroValue(result));
            returns(&mut body, value);
        }
        function.body = body;
    }
}

/// Makes a block that may come to its end return a value there.
fn returns(block: &mut Block, value: Handle<Expression>) {
    match block.last_mut() {
        Some(Statement::Return { value: Some(_) }) => {}
        Some(Statement::Return { value: given }) => *given = Some(value),
        _ => block.push(Statement::Return { value: Some(value) }, Span::UNDEFINED),
    }
}

struct Instrument<'a> {
    costs: &'a Costs,
    expressions: &'a mut naga::Arena<Expression>,
    budget: Handle<GlobalVariable>,
    /// How many arguments the function had.
    before: u32,
    params: usize,
}

impl Instrument<'_> {
    fn add(&mut self, expression: Expression) -> Handle<Expression> {
        self.expressions.append(expression, Span::UNDEFINED)
    }

    fn block(&mut self, block: Block) -> Block {
        let mut result = Block::new();
        for (statement, span) in block.span_into_iter() {
            let statement = match statement {
                Statement::Block(block) => Statement::Block(self.block(block)),
                Statement::If { condition, accept, reject } => {
                    Statement::If { condition, accept: self.block(accept), reject: self.block(reject) }
                }
                Statement::Switch { selector, mut cases } => {
                    for case in &mut cases {
                        case.body = self.block(std::mem::take(&mut case.body));
                    }
                    Statement::Switch { selector, cases }
                }
                Statement::Loop { body, continuing, break_if } => {
                    let mut counted = self.count(self.costs.weight(&body, &continuing));
                    counted.append(&mut self.block(body));
                    Statement::Loop { body: counted, continuing: self.block(continuing), break_if }
                }
                Statement::Call { function, mut arguments, result } => {
                    for k in 0..self.params as u32 {
                        let argument = self.add(Expression::FunctionArgument(self.before + k));
                        arguments.push(argument);
                    }
                    Statement::Call { function, arguments, result }
                }
                other => other,
            };
            result.push(statement, span);
        }
        result
    }

    /// What takes a pass of this weight from the budget, or breaks off.
    fn count(&mut self, weight: u32) -> Block {
        let pointer = self.add(Expression::GlobalVariable(self.budget));
        let weight = self.add(Expression::Literal(Literal::U32(weight)));
        let left = self.add(Expression::Load { pointer });
        let condition = self.add(Expression::Binary { op: BinaryOperator::Less, left, right: weight });
        let rest = self.add(Expression::Binary { op: BinaryOperator::Subtract, left, right: weight });
        let mut block = Block::new();
        block.push(Statement::Emit(Range::new_from_bounds(left, condition)), Span::UNDEFINED);
        let accept = Block::from_vec(vec![Statement::Break]);
        block.push(Statement::If { condition, accept, reject: Block::new() }, Span::UNDEFINED);
        block.push(Statement::Emit(Range::new_from_bounds(rest, rest)), Span::UNDEFINED);
        block.push(Statement::Store { pointer, value: rest }, Span::UNDEFINED);
        block
    }
}
