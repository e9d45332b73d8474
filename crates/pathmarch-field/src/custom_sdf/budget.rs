//! Cost limits of custom shapes: operations are counted when a scene is read, loop passes at run time.
//!
//! WGSL has no recursion, so that only loops, nested calls and arrays can take long or much memory. Calls and arrays are counted
//! when the scene is read. With every call inlined, `distance` has at most [`MAX_OPERATIONS`] operations; a copy of an array or
//! a matrix (variable, argument, result, load or store) is one operation for each scalar or vector. All arrays together have at
//! most [`MAX_ARRAY_SCALARS`] scalars, because drivers inline every call with variables of its own. Each pass of a loop takes
//! one from a budget of [`LOOP_BUDGET`] that all loops of one call share, and one more for every [`OPERATIONS_PER_PASS`]
//! operations of its body; without budget, every loop ends. So a call does at most about [`MAX_OPERATIONS`] + [`LOOP_BUDGET`] ·
//! [`OPERATIONS_PER_PASS`] operations, whatever its code.
//!
//! For the limit on compilation arrays, loops and cases count more, because drivers compile them much slower than arithmetic.
//!
//! naga's SPIR-V copies an array value, e.g. a constant, to memory for each access by a computed index: such an access counts as
//! a copy.
//!
//! Sphere tracing takes at most 256 steps. With 256 passes in each, it stays below the 65,535 loop iterations after which Mesa's
//! software Vulkan silently ends all loops of an invocation.

pub use super::size::MAX_ARRAY_SCALARS;
use super::size::{Size, Sizes};
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, BinaryOperator, Block, Expression, FunctionArgument, GlobalVariable, Handle, Literal, MathFunction,
    Module, Range, Scalar, Span, Statement, Type, TypeInner,
};

/// Loop passes of one call of `distance`.
pub const LOOP_BUDGET: u32 = 256;
/// Operations of a loop's body that count as one pass.
pub const OPERATIONS_PER_PASS: u32 = 64;
/// Largest number of operations of `distance` with every call inlined.
pub const MAX_OPERATIONS: u32 = 8192;
/// Weight of each scalar or vector of a copied array, in operations.
///
/// Compilers unroll copies of arrays to single stores: 7,000 of them took software Vulkan more than 200 s, 1,300 products and
/// sums less than one.
const COPIED: u32 = 16;
/// Weight of an access to an array by a computed index, in operations: 200 took software Vulkan 10 s.
const INDEXED: u32 = 32;
/// Weight of a loop with every call inlined, in operations: 10 took software Vulkan 3 s, 30 14 s, 100 more than 30 s.
const LOOP: u32 = 256;
/// Weight of a case of a `switch`, in operations: 300 took software Vulkan 4 s, 600 8 s, 1,800 more than 30 s.
const CASE: u32 = 12;

/// Cost of code with every call inlined and every loop passed once; sums saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    pub(super) operations: u32,
    /// Operations with the weights for compilation: [`COPIED`], [`INDEXED`], [`LOOP`] and [`CASE`].
    pub(super) compiled: u32,
    /// Scalars of the arrays in memory.
    pub(super) numbers: u32,
}

impl Cost {
    const ONE: Self = Self { operations: 1, compiled: 1, numbers: 0 };
    /// Cost of an access to an array by a computed index.
    const INDEX: Self = Self { operations: 1, compiled: INDEXED, numbers: 0 };

    fn plus(self, other: Self) -> Self {
        Self {
            operations: self.operations.saturating_add(other.operations),
            compiled: self.compiled.saturating_add(other.compiled),
            numbers: self.numbers.saturating_add(other.numbers),
        }
    }
    /// Cost of a loop, without its body.
    const LOOP: Self = Self { operations: 0, compiled: LOOP, numbers: 0 };
    /// Cost of a case of a `switch`, without its body.
    const CASE: Self = Self { operations: 0, compiled: CASE, numbers: 0 };

    /// Cost of a copy of a value of this size; scalars and vectors are free.
    fn copy(size: Size) -> Self {
        let operations = if size.copies > 1 || size.has_array { size.copies } else { 0 };
        if size.has_array {
            Self { operations, compiled: operations.saturating_mul(COPIED), numbers: size.numbers }
        } else {
            Self { operations, compiled: operations, numbers: 0 }
        }
    }
    fn at_least_one(self) -> Self {
        Self { operations: self.operations.max(1), compiled: self.compiled.max(1), ..self }
    }
}

/// Cost of an expression.
#[derive(Clone, Copy)]
struct ExpressionCost {
    /// Cost of computing it.
    computed: Cost,
    /// Cost of copying its value.
    copied: Cost,
}

/// The cost of every function and of every expression in them.
pub(super) struct Costs {
    functions: Vec<Cost>,
    expressions: Vec<Vec<ExpressionCost>>,
    /// Cost of setting the variables outside functions to zero.
    globals: Cost,
}

impl Costs {
    pub(super) fn new(module: &Module, info: &ModuleInfo) -> Self {
        let sizes = Sizes::new(&module.types);
        let variables = module.global_variables.iter().map(|(_, variable)| variable.ty);
        let globals = variables.map(|ty| Cost::copy(sizes.of(ty)).at_least_one()).fold(Cost::default(), Cost::plus);
        let mut costs = Self { functions: Vec::new(), expressions: Vec::new(), globals };
        for (handle, function) in module.functions.iter() {
            let of = |expression| expression_cost(module, &sizes, function, &info[handle], expression);
            costs.expressions.push(function.expressions.iter().map(|(expression, _)| of(expression)).collect());
            let variables = function.local_variables.iter().map(|(_, variable)| variable.ty);
            let variables = variables.map(|ty| Cost::copy(sizes.of(ty)).at_least_one());
            let arguments = function.arguments.iter().map(|argument| Cost::copy(sizes.of(argument.ty)));
            // Callees are before their callers.
            let body = costs.block(handle, &function.body);
            costs.functions.push(variables.chain(arguments).fold(body.plus(Cost::ONE), Cost::plus));
        }
        costs
    }

    pub(super) fn of(&self, function: Handle<naga::Function>) -> Cost {
        let unknown = Cost { operations: u32::MAX, compiled: u32::MAX, numbers: u32::MAX };
        self.functions.get(function.index()).copied().unwrap_or(unknown)
    }

    pub(super) fn globals(&self) -> Cost {
        self.globals
    }

    /// Budget taken by one pass of a loop of this function.
    pub(super) fn weight(&self, function: Handle<naga::Function>, body: &Block, continuing: &Block) -> u32 {
        let pass = self.block(function, body).plus(self.block(function, continuing));
        1 + pass.operations / OPERATIONS_PER_PASS
    }

    fn expression(&self, function: Handle<naga::Function>, expression: Handle<Expression>) -> ExpressionCost {
        let known = self.expressions.get(function.index()).and_then(|costs| costs.get(expression.index()));
        known.copied().unwrap_or(ExpressionCost { computed: Cost::ONE, copied: Cost::default() })
    }

    fn block(&self, function: Handle<naga::Function>, block: &Block) -> Cost {
        let inner = |block: &Block| self.block(function, block);
        let copied = |expression: Handle<Expression>| self.expression(function, expression).copied;
        let moved = |expression| Cost { numbers: 0, ..copied(expression) };
        let cost = |statement: &Statement| match statement {
            Statement::Emit(range) => range
                .clone()
                .map(|expression| self.expression(function, expression).computed)
                .fold(Cost::default(), Cost::plus),
            Statement::Block(block) => inner(block),
            Statement::If { accept, reject, .. } => inner(accept).plus(inner(reject)),
            Statement::Switch { cases, .. } => {
                cases.iter().map(|case| inner(&case.body).plus(Cost::CASE)).fold(Cost::ONE, Cost::plus)
            }
            Statement::Loop { body, continuing, .. } => inner(body).plus(inner(continuing)).plus(Cost::LOOP),
            Statement::Call { function, arguments, result } => {
                let arguments = arguments.iter().map(|&argument| moved(argument));
                let result = result.map(copied).unwrap_or_default();
                arguments.fold(self.of(*function).plus(result), Cost::plus)
            }
            Statement::Store { value, .. } | Statement::Return { value: Some(value) } => moved(*value).at_least_one(),
            _ => Cost::ONE,
        };
        block.iter().map(cost).fold(Cost::default(), Cost::plus)
    }
}

fn expression_cost(
    module: &Module,
    sizes: &Sizes,
    function: &naga::Function,
    info: &FunctionInfo,
    expression: Handle<Expression>,
) -> ExpressionCost {
    let inner = |expression: Handle<Expression>| info[expression].ty.inner_with(&module.types);
    let size = |expression| sizes.of_inner(inner(expression));
    let copied = Cost::copy(size(expression));
    let least = |operations: u32| Cost {
        operations: copied.operations.max(operations),
        compiled: copied.compiled.max(operations),
        ..copied
    };
    let computed = match function.expressions[expression] {
        Expression::Access { base, .. } => match inner(base) {
            TypeInner::Pointer { base, .. } if sizes.of(*base).has_array => Cost::INDEX,
            // naga copies the value to memory first.
            _ if size(base).has_array => Cost::copy(size(base)).plus(copied).plus(Cost::INDEX),
            _ => Cost::copy(size(base)).plus(copied).at_least_one(),
        },
        // The columns of one for each column of the other.
        Expression::Binary { left, right, .. } => least(size(left).copies.saturating_mul(size(right).copies)),
        Expression::Math { fun: MathFunction::Determinant | MathFunction::Inverse, arg, .. } => {
            least(size(arg).numbers)
        }
        _ => copied.at_least_one(),
    };
    ExpressionCost { computed, copied }
}

/// Adds the loop budget to a module: every loop takes from the variable `counter`, which `entry` fills. `entry` also sets the
/// variables outside functions to zero. Turns the parameters
/// `params`, which were overrides, into arguments of all functions.
pub(super) fn instrument(
    module: &mut Module,
    costs: &Costs,
    entry: Handle<naga::Function>,
    params: &[String],
    counter: String,
) {
    let inner = |inner| Type { name: None, inner };
    let u32_type = module.types.insert(inner(TypeInner::Scalar(Scalar::U32)), Span::UNDEFINED);
    let f32_type = module.types.insert(inner(TypeInner::Scalar(Scalar::F32)), Span::UNDEFINED);
    let variables: Vec<_> = module.global_variables.iter().map(|(handle, variable)| (handle, variable.ty)).collect();
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
        let expressions = &mut function.expressions;
        let mut work = Instrument { costs, function: handle, expressions, budget, before, params: params.len() };
        let mut body = work.block(std::mem::take(&mut function.body));
        if handle == entry {
            let mut start = Block::new();
            let pointer = work.add(Expression::GlobalVariable(budget));
            let value = work.add(Expression::Literal(Literal::U32(LOOP_BUDGET)));
            start.push(Statement::Store { pointer, value }, Span::UNDEFINED);
            for &(variable, ty) in &variables {
                let pointer = work.add(Expression::GlobalVariable(variable));
                let value = work.add(Expression::ZeroValue(ty));
                start.push(Statement::Store { pointer, value }, Span::UNDEFINED);
            }
            start.append(&mut body);
            body = start;
        }
        if let Some(result) = results[handle.index()] {
            // A loop without end can end now; a function that then reaches its end returns zero.
            let value = work.add(Expression::ZeroValue(result));
            returns(&mut body, value);
        }
        function.body = body;
    }
}

/// Adds a return to a block that may reach its end.
fn returns(block: &mut Block, value: Handle<Expression>) {
    match block.last_mut() {
        Some(Statement::Return { value: Some(_) }) => {}
        Some(Statement::Return { value: given }) => *given = Some(value),
        _ => block.push(Statement::Return { value: Some(value) }, Span::UNDEFINED),
    }
}

struct Instrument<'a> {
    costs: &'a Costs,
    function: Handle<naga::Function>,
    expressions: &'a mut naga::Arena<Expression>,
    budget: Handle<GlobalVariable>,
    /// Number of arguments without the parameters.
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
                    let mut counted = self.count(self.costs.weight(self.function, &body, &continuing));
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

    /// Statements that take a pass of this weight from the budget, or break.
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
