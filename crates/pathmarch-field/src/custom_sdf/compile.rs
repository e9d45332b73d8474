//! Compiler from a validated naga module to the program of a [`Machine`](super::machine::Machine).
//!
//! Functions on vectors and matrices become operations on scalars; every value and variable has slots of its own. Unknown
//! expressions and statements are refused, so that this is also the list of what custom shapes may use: they cannot name
//! anything of the kernel, access its memory, or call barriers or derivatives.

mod expression;
mod layout;
mod vectors;

use super::budget::Costs;
use super::machine::{Case, Op, Procedure, Program};
use super::math::Function;
use super::{CodeDiagnostic, range};
use naga::proc::TypeResolution;
use naga::valid::ModuleInfo;
use naga::{Block, Expression, Handle, Module, Span, Statement, SwitchValue, TypeInner};
use std::collections::HashMap;

/// Largest number of scalars of all values and variables together.
const MAX_SLOTS: usize = 1 << 16;

/// Compiles a module whose overrides are the parameters `params`.
pub(super) fn compile(
    module: &Module,
    info: &ModuleInfo,
    costs: &Costs,
    entry: Handle<naga::Function>,
    params: &[String],
) -> Result<Program, CodeDiagnostic> {
    let mut compiler = Compiler {
        module,
        info,
        params,
        costs,
        memory: vec![0; params.len()],
        procedures: Vec::new(),
        arguments: Vec::new(),
        constants: HashMap::new(),
        globals: HashMap::new(),
        variables: HashMap::new(),
    };
    let first = compiler.memory.len();
    for (handle, variable) in module.global_variables.iter() {
        let size = compiler.size_of(variable.ty, module.global_variables.get_span(handle))?;
        let slot = compiler.alloc(size);
        compiler.variables.insert(handle, slot);
    }
    let variables = first as u32..compiler.memory.len() as u32;
    let mut start = None;
    for (handle, function) in module.functions.iter() {
        compiler.function(handle, function)?;
        if handle == entry {
            start = Some(compiler.procedures.len() - 1);
        }
    }
    let entry = start.unwrap_or_default();
    let point = compiler.arguments[entry].first().copied().unwrap_or_default();
    Ok(Program { memory: compiler.memory, functions: compiler.procedures, entry, point, params: 0, variables })
}

/// Target of a pointer.
#[derive(Clone, Copy)]
enum Pointer {
    /// This slot.
    Slot(u32),
    /// The slot whose index is in this one.
    At(u32),
}

/// Compiled expression.
#[derive(Clone, Copy)]
enum Value {
    /// Value in the slots from this one on.
    Slots(u32),
    Pointer(Pointer),
}

struct Compiler<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    params: &'m [String],
    costs: &'m Costs,
    memory: Vec<u32>,
    procedures: Vec<Procedure>,
    /// Slots of the arguments of each compiled function.
    arguments: Vec<Vec<u32>>,
    /// Slots of scalar constants.
    constants: HashMap<u32, u32>,
    /// Slots of the constants of the module.
    globals: HashMap<Handle<naga::Constant>, u32>,
    /// Slots of the variables outside functions.
    variables: HashMap<Handle<naga::GlobalVariable>, u32>,
}

/// Function being compiled.
struct Body<'m> {
    handle: Handle<naga::Function>,
    function: &'m naga::Function,
    values: HashMap<Handle<Expression>, Value>,
    locals: HashMap<Handle<naga::LocalVariable>, u32>,
    arguments: Vec<u32>,
    ops: Vec<Op>,
}

fn fault(span: Span, message: impl Into<String>) -> CodeDiagnostic {
    CodeDiagnostic { message: message.into(), label: "not in a field".to_owned(), range: range(span), help: None }
}

/// Mask for [`Op::Apply`]: all operands have a slot for each component.
const EACH: u8 = 0b111;

impl<'m> Compiler<'m> {
    fn alloc(&mut self, count: u32) -> u32 {
        let slot = self.memory.len() as u32;
        // Beyond the limit the function is refused at its end; until then any slot will do.
        if self.memory.len().saturating_add(count as usize) > MAX_SLOTS {
            self.memory.resize(MAX_SLOTS + 1, 0);
            return 0;
        }
        self.memory.resize(self.memory.len() + count as usize, 0);
        slot
    }

    fn constant(&mut self, bits: u32) -> u32 {
        if let Some(&slot) = self.constants.get(&bits) {
            return slot;
        }
        let slot = self.alloc(1);
        if let Some(place) = self.memory.get_mut(slot as usize) {
            *place = bits;
        }
        self.constants.insert(bits, slot);
        slot
    }

    fn function(&mut self, handle: Handle<naga::Function>, function: &'m naga::Function) -> Result<(), CodeDiagnostic> {
        let span = self.module.functions.get_span(handle);
        let mut body = Body {
            handle,
            function,
            values: HashMap::new(),
            locals: HashMap::new(),
            arguments: Vec::new(),
            ops: Vec::new(),
        };
        for argument in &function.arguments {
            let size = match &self.module.types[argument.ty].inner {
                TypeInner::Pointer { space: naga::AddressSpace::Function, .. } => 1,
                inner => self.size(inner, span)?,
            };
            body.arguments.push(self.alloc(size));
        }
        for (local, variable) in function.local_variables.iter() {
            let span = function.local_variables.get_span(local);
            let size = self.size_of(variable.ty, span)?;
            let slot = self.alloc(size);
            body.locals.insert(local, slot);
            let from = match variable.init {
                Some(init) => self.value(&mut body, init)?,
                None => self.alloc(size),
            };
            body.ops.push(Op::Copy { to: slot, from, count: size });
        }
        let size = match &function.result {
            Some(result) => self.size_of(result.ty, span)?,
            None => 0,
        };
        let result = self.alloc(size);
        let inner = self.block(&mut body, &function.body)?;
        body.ops.extend(inner);
        if self.memory.len() > MAX_SLOTS {
            let message = format!("The values and variables of a field have at most {MAX_SLOTS} numbers.");
            return Err(fault(span, message));
        }
        self.procedures.push(Procedure { body: body.ops, result, size });
        self.arguments.push(body.arguments);
        Ok(())
    }

    /// Compiles a block to its operations.
    fn block(&mut self, body: &mut Body<'m>, block: &'m Block) -> Result<Vec<Op>, CodeDiagnostic> {
        let outer = std::mem::take(&mut body.ops);
        for (statement, span) in block.span_iter() {
            self.statement(body, statement, *span)?;
        }
        Ok(std::mem::replace(&mut body.ops, outer))
    }

    fn statement(&mut self, body: &mut Body<'m>, statement: &'m Statement, span: Span) -> Result<(), CodeDiagnostic> {
        match statement {
            Statement::Emit(expressions) => {
                for expression in expressions.clone() {
                    let value = self.expression(body, expression)?;
                    body.values.insert(expression, value);
                }
            }
            Statement::Block(block) => {
                let ops = self.block(body, block)?;
                body.ops.extend(ops);
            }
            Statement::If { condition, accept, reject } => {
                let condition = self.value(body, *condition)?;
                let accept = self.block(body, accept)?;
                let reject = self.block(body, reject)?;
                body.ops.push(Op::If { condition, accept, reject });
            }
            Statement::Switch { selector, cases } => {
                let selector = self.value(body, *selector)?;
                let cases = cases
                    .iter()
                    .map(|case| {
                        let value = match case.value {
                            SwitchValue::I32(value) => Some(value as u32),
                            SwitchValue::U32(value) => Some(value),
                            SwitchValue::Default => None,
                        };
                        Ok(Case { value, body: self.block(body, &case.body)?, falls_through: case.fall_through })
                    })
                    .collect::<Result<_, CodeDiagnostic>>()?;
                body.ops.push(Op::Switch { selector, cases });
            }
            Statement::Loop { body: inner, continuing, break_if } => {
                let weight = self.costs.weight(body.handle, inner, continuing);
                let inner = self.block(body, inner)?;
                // The condition is evaluated at the end of the continuing block.
                let continuing = self.block(body, continuing)?;
                let break_if = break_if.map(|condition| self.value(body, condition)).transpose()?;
                body.ops.push(Op::Loop { body: inner, continuing, break_if, weight });
            }
            Statement::Break => body.ops.push(Op::Break),
            Statement::Continue => body.ops.push(Op::Continue),
            Statement::Return { value } => {
                let value = value.map(|value| self.value(body, value)).transpose()?;
                body.ops.push(Op::Return { value });
            }
            Statement::Store { pointer, value } => {
                let from = self.value(body, *value)?;
                let count = self.size(self.inner(body, *value), span)?;
                match self.pointer(body, *pointer)? {
                    Pointer::Slot(to) => body.ops.push(Op::Store { to, from, count }),
                    Pointer::At(address) => body.ops.push(Op::StoreAt { address, from, count }),
                }
            }
            Statement::Call { function, arguments, result } => {
                let called = function.index();
                for (k, argument) in arguments.iter().enumerate() {
                    let to = self.arguments[called][k];
                    match self.any(body, *argument)? {
                        Value::Slots(from) => {
                            let count = self.size(self.inner(body, *argument), span)?;
                            body.ops.push(Op::Copy { to, from, count });
                        }
                        Value::Pointer(Pointer::Slot(slot)) => {
                            let from = self.constant(slot);
                            body.ops.push(Op::Copy { to, from, count: 1 });
                        }
                        Value::Pointer(Pointer::At(from)) => body.ops.push(Op::Copy { to, from, count: 1 }),
                    }
                }
                let to = result.map(|result| {
                    let slot = self.alloc(self.procedures[called].size);
                    body.values.insert(result, Value::Slots(slot));
                    slot
                });
                body.ops.push(Op::Call { function: called, to });
            }
            _ => return Err(fault(span, "A field only computes: this statement is not for it.")),
        }
        Ok(())
    }

    fn inner<'a>(&'a self, body: &Body, expression: Handle<Expression>) -> &'a TypeInner {
        let resolution: &TypeResolution = &self.info[body.handle][expression].ty;
        resolution.inner_with(&self.module.types)
    }

    /// First slot of a value, which must not be a pointer.
    fn value(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<u32, CodeDiagnostic> {
        match self.any(body, expression)? {
            Value::Slots(slot) => Ok(slot),
            Value::Pointer(_) => Err(self.unknown(body, expression)),
        }
    }

    fn pointer(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<Pointer, CodeDiagnostic> {
        match self.any(body, expression)? {
            Value::Pointer(pointer) => Ok(pointer),
            Value::Slots(_) => Err(self.unknown(body, expression)),
        }
    }

    fn unknown(&self, body: &Body, expression: Handle<Expression>) -> CodeDiagnostic {
        let span = body.function.expressions.get_span(expression);
        fault(span, "A field only computes with numbers: this is not for it.")
    }

    /// Compiled value of an expression that was emitted or needs no emission.
    fn any(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<Value, CodeDiagnostic> {
        match body.values.get(&expression) {
            Some(value) => Ok(*value),
            None => self.expression(body, expression),
        }
    }

    fn apply(&mut self, body: &mut Body, function: Function, operands: &[u32], steps: u8, count: u32) -> u32 {
        let to = self.alloc(count);
        let operands = std::array::from_fn(|k| operands.get(k).copied().unwrap_or_default());
        body.ops.push(Op::Apply { function, to, operands, steps, count });
        to
    }
}
