//! A checked module of naga as the program of a [`Machine`](super::machine::Machine).
//!
//! Functions on vectors and matrices become operations on scalars; every value and variable gets slots of its own. What is
//! not known here is refused, so that this is also the list of what a field may use: the kernel has nothing that a field
//! could name, and no field reads memory, calls barriers or derivatives.

use super::budget::Costs;
use super::machine::{Case, Op, Procedure, Program};
use super::math::{self, Function};
use super::{Fault, range};
use naga::proc::TypeResolution;
use naga::valid::ModuleInfo;
use naga::{
    ArraySize, BinaryOperator, Block, Expression, Handle, Literal, MathFunction, Module, RelationalFunction,
    ScalarKind, Span, Statement, SwitchValue, Type, TypeInner,
};
use std::collections::HashMap;

/// The most scalars that all values and variables together may have.
const MAX_SLOTS: usize = 1 << 16;

/// The program of a module whose overrides are the parameters of these names.
pub(super) fn compile(
    module: &Module,
    info: &ModuleInfo,
    entry: Handle<naga::Function>,
    params: &[String],
) -> Result<Program, Fault> {
    let mut compiler = Compiler {
        module,
        info,
        params,
        costs: Costs::new(module),
        memory: vec![0; params.len()],
        procedures: Vec::new(),
        arguments: Vec::new(),
        constants: HashMap::new(),
    };
    let mut start = None;
    for (handle, function) in module.functions.iter() {
        compiler.function(handle, function)?;
        if handle == entry {
            start = Some(compiler.procedures.len() - 1);
        }
    }
    let entry = start.unwrap_or_default();
    let point = compiler.arguments[entry].first().copied().unwrap_or_default();
    Ok(Program { memory: compiler.memory, functions: compiler.procedures, entry, point, params: 0 })
}

/// Where a pointer points to.
#[derive(Clone, Copy)]
enum Pointer {
    /// To this slot.
    Slot(u32),
    /// To the slot whose number is in this one.
    At(u32),
}

/// What an expression stands for.
#[derive(Clone, Copy)]
enum Value {
    /// A value from this slot on.
    Slots(u32),
    Pointer(Pointer),
}

struct Compiler<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    params: &'m [String],
    costs: Costs,
    memory: Vec<u32>,
    procedures: Vec<Procedure>,
    /// Slots of the arguments of each function.
    arguments: Vec<Vec<u32>>,
    /// Slots of scalar constants.
    constants: HashMap<u32, u32>,
}

/// A function while it is compiled.
struct Body<'m> {
    handle: Handle<naga::Function>,
    function: &'m naga::Function,
    values: HashMap<Handle<Expression>, Value>,
    locals: HashMap<Handle<naga::LocalVariable>, u32>,
    arguments: Vec<u32>,
    ops: Vec<Op>,
}

/// What an expression's type is made of.
#[derive(Clone, Copy)]
struct Shape {
    kind: ScalarKind,
    /// Scalars of a column.
    rows: u32,
    columns: u32,
}

fn fault(span: Span, message: impl Into<String>) -> Fault {
    Fault { message: message.into(), label: "not in a field".to_owned(), range: range(span), help: None }
}

/// A bit for each operand of which every component is used.
const EACH: u8 = 0b111;

impl<'m> Compiler<'m> {
    fn alloc(&mut self, count: u32) -> u32 {
        let slot = self.memory.len() as u32;
        // Past the limit the program is refused at the end of the function; until then a place that is wrong will do.
        if self.memory.len() + count as usize > MAX_SLOTS {
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

    /// How many scalars a value of this type has.
    fn size(&self, inner: &TypeInner, span: Span) -> Result<u32, Fault> {
        let scalar = |scalar: naga::Scalar| match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) | (_, 4) => Ok(()),
            _ => Err(fault(span, "Numbers of a field are f32, i32 and u32.")),
        };
        match *inner {
            TypeInner::Scalar(kind) => scalar(kind).map(|()| 1),
            TypeInner::Vector { size, scalar: kind } => scalar(kind).map(|()| size as u32),
            TypeInner::Matrix { columns, rows, scalar: kind } => scalar(kind).map(|()| columns as u32 * rows as u32),
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let one = u64::from(self.size_of(base, span)?);
                u32::try_from(one * u64::from(count.get()))
                    .ok()
                    .filter(|size| *size as usize <= MAX_SLOTS)
                    .ok_or_else(|| fault(span, format!("An array of more than {MAX_SLOTS} numbers is too large.")))
            }
            TypeInner::Struct { ref members, .. } => {
                let mut size = 0_u32;
                for member in members {
                    size = size.saturating_add(self.size_of(member.ty, span)?);
                }
                Ok(size)
            }
            _ => Err(fault(span, "A field has numbers, vectors, matrices, structures and arrays of a fixed size.")),
        }
    }

    fn size_of(&self, ty: Handle<Type>, span: Span) -> Result<u32, Fault> {
        self.size(&self.module.types[ty].inner, span)
    }

    fn function(&mut self, handle: Handle<naga::Function>, function: &'m naga::Function) -> Result<(), Fault> {
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

    /// Compiles a block into operations of its own.
    fn block(&mut self, body: &mut Body<'m>, block: &'m Block) -> Result<Vec<Op>, Fault> {
        let outer = std::mem::take(&mut body.ops);
        for (statement, span) in block.span_iter() {
            self.statement(body, statement, *span)?;
        }
        Ok(std::mem::replace(&mut body.ops, outer))
    }

    fn statement(&mut self, body: &mut Body<'m>, statement: &'m Statement, span: Span) -> Result<(), Fault> {
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
                    .collect::<Result<_, Fault>>()?;
                body.ops.push(Op::Switch { selector, cases });
            }
            Statement::Loop { body: inner, continuing, break_if } => {
                let weight = self.costs.weight(inner, continuing);
                let inner = self.block(body, inner)?;
                // The condition is found at the end of the continuing block.
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

    fn shape(&self, body: &Body, expression: Handle<Expression>) -> Option<Shape> {
        shape(self.inner(body, expression))
    }

    /// The slot of a value that is no pointer.
    fn value(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<u32, Fault> {
        match self.any(body, expression)? {
            Value::Slots(slot) => Ok(slot),
            Value::Pointer(_) => Err(self.unknown(body, expression)),
        }
    }

    fn pointer(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<Pointer, Fault> {
        match self.any(body, expression)? {
            Value::Pointer(pointer) => Ok(pointer),
            Value::Slots(_) => Err(self.unknown(body, expression)),
        }
    }

    fn unknown(&self, body: &Body, expression: Handle<Expression>) -> Fault {
        let span = body.function.expressions.get_span(expression);
        fault(span, "A field only computes with numbers: this is not for it.")
    }

    /// What was emitted, or what needs not be.
    fn any(&mut self, body: &mut Body<'m>, expression: Handle<Expression>) -> Result<Value, Fault> {
        match body.values.get(&expression) {
            Some(value) => Ok(*value),
            None => self.expression(body, expression),
        }
    }

    fn literal(&mut self, literal: Literal, span: Span) -> Result<u32, Fault> {
        let bits = match literal {
            Literal::F32(value) => value.to_bits(),
            Literal::U32(value) => value,
            Literal::I32(value) => value as u32,
            Literal::Bool(value) => {
                if value {
                    u32::MAX
                } else {
                    0
                }
            }
            Literal::AbstractInt(value) => value as u32,
            Literal::AbstractFloat(value) => (value as f32).to_bits(),
            _ => return Err(fault(span, "Numbers of a field are f32, i32 and u32.")),
        };
        Ok(self.constant(bits))
    }

    /// A constant of the module: a tree of literals.
    fn global(&mut self, expression: Handle<Expression>, ops: &mut Vec<Op>) -> Result<(u32, u32), Fault> {
        let span = self.module.global_expressions.get_span(expression);
        match &self.module.global_expressions[expression] {
            Expression::Literal(literal) => Ok((self.literal(*literal, span)?, 1)),
            Expression::Constant(constant) => self.global(self.module.constants[*constant].init, ops),
            Expression::ZeroValue(ty) => {
                let size = self.size_of(*ty, span)?;
                Ok((self.alloc(size), size))
            }
            Expression::Compose { ty, components } => {
                let size = self.size_of(*ty, span)?;
                let to = self.alloc(size);
                let mut at = 0;
                for component in components {
                    let (from, count) = self.global(*component, ops)?;
                    ops.push(Op::Copy { to: to + at, from, count });
                    at += count;
                }
                Ok((to, size))
            }
            Expression::Splat { size, value } => {
                let (from, _) = self.global(*value, ops)?;
                let to = self.alloc(*size as u32);
                ops.extend((0..*size as u32).map(|k| Op::Copy { to: to + k, from, count: 1 }));
                Ok((to, *size as u32))
            }
            _ => Err(fault(span, "A constant of a field is a number, or made of numbers.")),
        }
    }

    fn apply(&mut self, body: &mut Body, function: Function, operands: &[u32], steps: u8, count: u32) -> u32 {
        let to = self.alloc(count);
        let operands = std::array::from_fn(|k| operands.get(k).copied().unwrap_or_default());
        body.ops.push(Op::Apply { function, to, operands, steps, count });
        to
    }

    /// The sum of products of two vectors whose components are `strides` apart.
    fn dot(&mut self, body: &mut Body, a: u32, b: u32, count: u32, [step_a, step_b]: [u32; 2]) -> u32 {
        let mut sum = self.apply(body, math::MULTIPLY, &[a, b], EACH, 1);
        for k in 1..count {
            let product = self.apply(body, math::MULTIPLY, &[a + k * step_a, b + k * step_b], EACH, 1);
            sum = self.apply(body, math::ADD, &[sum, product], EACH, 1);
        }
        sum
    }

    fn length(&mut self, body: &mut Body, a: u32, count: u32) -> u32 {
        let square = self.dot(body, a, a, count, [1, 1]);
        self.apply(body, math::SQRT, &[square], EACH, 1)
    }

    /// The components from these slots, side by side.
    fn gathered(&mut self, body: &mut Body, from: &[u32]) -> u32 {
        let to = self.alloc(from.len() as u32);
        body.ops.extend(from.iter().zip(to..).map(|(&from, to)| Op::Copy { to, from, count: 1 }));
        to
    }

    fn expression(&mut self, body: &mut Body<'m>, handle: Handle<Expression>) -> Result<Value, Fault> {
        let span = body.function.expressions.get_span(handle);
        let unknown = || fault(span, "A field only computes with numbers: this is not for it.");
        let slot = match &body.function.expressions[handle] {
            Expression::Literal(literal) => self.literal(*literal, span)?,
            Expression::Constant(constant) => {
                let init = self.module.constants[*constant].init;
                let mut ops = Vec::new();
                let (slot, _) = self.global(init, &mut ops)?;
                body.ops.extend(ops);
                slot
            }
            Expression::Override(param) => {
                let name = &self.module.overrides[*param].name;
                self.params.iter().position(|param| Some(param) == name.as_ref()).ok_or_else(unknown)? as u32
            }
            Expression::ZeroValue(ty) => {
                let size = self.size_of(*ty, span)?;
                self.alloc(size)
            }
            Expression::FunctionArgument(index) => {
                let slot = body.arguments[*index as usize];
                match self.inner(body, handle) {
                    TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => {
                        return Ok(Value::Pointer(Pointer::At(slot)));
                    }
                    _ => slot,
                }
            }
            Expression::LocalVariable(local) => return Ok(Value::Pointer(Pointer::Slot(body.locals[local]))),
            Expression::Compose { ty, components } => {
                let size = self.size_of(*ty, span)?;
                let to = self.alloc(size);
                let mut at = 0;
                for &component in components {
                    let from = self.value(body, component)?;
                    let count = self.size(self.inner(body, component), span)?;
                    body.ops.push(Op::Copy { to: to + at, from, count });
                    at += count;
                }
                to
            }
            Expression::Splat { size, value } => {
                let from = self.value(body, *value)?;
                self.gathered(body, &vec![from; *size as usize])
            }
            Expression::Swizzle { size, vector, pattern } => {
                let from = self.value(body, *vector)?;
                let slots: Vec<u32> =
                    pattern[..*size as usize].iter().map(|&component| from + component as u32).collect();
                self.gathered(body, &slots)
            }
            Expression::AccessIndex { base, index } => {
                let inner = self.pointee(body, *base);
                let (offset, _, _) = self.element(&inner, *index, span)?;
                match self.any(body, *base)? {
                    Value::Slots(slot) => slot + offset,
                    Value::Pointer(Pointer::Slot(slot)) => return Ok(Value::Pointer(Pointer::Slot(slot + offset))),
                    Value::Pointer(Pointer::At(slot)) => {
                        let index = self.constant(offset);
                        let to = self.alloc(1);
                        body.ops.push(Op::Address {
                            to,
                            base: slot,
                            relative: true,
                            index,
                            stride: 1,
                            limit: offset + 1,
                        });
                        return Ok(Value::Pointer(Pointer::At(to)));
                    }
                }
            }
            Expression::Access { base, index } => {
                let inner = self.pointee(body, *base);
                let (_, stride, limit) = self.element(&inner, 0, span)?;
                let index = self.value(body, *index)?;
                let base = self.any(body, *base)?;
                let to = self.alloc(1);
                let (slot, relative) = match base {
                    Value::Slots(slot) | Value::Pointer(Pointer::Slot(slot)) => (slot, false),
                    Value::Pointer(Pointer::At(slot)) => (slot, true),
                };
                body.ops.push(Op::Address { to, base: slot, relative, index, stride, limit });
                if let Value::Pointer(_) = base {
                    return Ok(Value::Pointer(Pointer::At(to)));
                }
                let value = self.alloc(stride);
                body.ops.push(Op::Load { to: value, address: to, count: stride });
                value
            }
            Expression::Load { pointer } => {
                let count = self.size(self.inner(body, handle), span)?;
                let pointer = self.pointer(body, *pointer)?;
                let to = self.alloc(count);
                body.ops.push(match pointer {
                    Pointer::Slot(from) => Op::Copy { to, from, count },
                    Pointer::At(address) => Op::Load { to, address, count },
                });
                to
            }
            Expression::Unary { op, expr } => {
                let shape = self.shape(body, *expr).ok_or_else(unknown)?;
                let a = self.value(body, *expr)?;
                let function = math::unary(*op, shape.kind).ok_or_else(unknown)?;
                self.apply(body, function, &[a], EACH, shape.count())
            }
            Expression::Binary { op, left, right } => {
                let (a, b) = (self.value(body, *left)?, self.value(body, *right)?);
                let shapes = self.shape(body, *left).zip(self.shape(body, *right)).ok_or_else(unknown)?;
                self.binary(body, *op, (a, b), shapes).ok_or_else(unknown)?
            }
            Expression::Select { condition, accept, reject } => {
                let count = self.size(self.inner(body, *accept), span)?;
                let each = self.shape(body, *condition).ok_or_else(unknown)?.count() == count;
                let condition = self.value(body, *condition)?;
                let (accept, reject) = (self.value(body, *accept)?, self.value(body, *reject)?);
                let steps = if each { EACH } else { 0b110 };
                self.apply(body, math::SELECT, &[condition, accept, reject], steps, count)
            }
            Expression::Relational { fun, argument } => {
                let count = self.shape(body, *argument).ok_or_else(unknown)?.count();
                let a = self.value(body, *argument)?;
                let function = match fun {
                    RelationalFunction::All => math::BOTH,
                    RelationalFunction::Any => math::EITHER,
                    _ => return Err(unknown()),
                };
                (1..count).fold(a, |all, k| self.apply(body, function, &[all, a + k], EACH, 1))
            }
            Expression::Math { fun, arg, arg1, arg2, arg3: None } => {
                let arguments: Vec<Handle<Expression>> = [Some(*arg), *arg1, *arg2].into_iter().flatten().collect();
                self.math(body, *fun, &arguments)?.ok_or_else(|| {
                    fault(span, format!("A field does not have the function `{}`.", format!("{fun:?}").to_lowercase()))
                })?
            }
            Expression::As { expr, kind, convert } => {
                let shape = self.shape(body, *expr).ok_or_else(unknown)?;
                let a = self.value(body, *expr)?;
                match convert {
                    None => a,
                    Some(1 | 4) => {
                        let function = math::convert(shape.kind, *kind).ok_or_else(unknown)?;
                        self.apply(body, function, &[a], EACH, shape.count())
                    }
                    Some(_) => return Err(fault(span, "Numbers of a field are f32, i32 and u32.")),
                }
            }
            _ => return Err(unknown()),
        };
        Ok(Value::Slots(slot))
    }

    /// The type of a value, or of what a pointer points to.
    fn pointee(&self, body: &Body, expression: Handle<Expression>) -> TypeInner {
        match self.inner(body, expression) {
            TypeInner::Pointer { base, .. } => self.module.types[*base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => {
                TypeInner::Vector { size: *size, scalar: *scalar }
            }
            inner => inner.clone(),
        }
    }

    /// Offset and size of an element, and how many there are.
    fn element(&self, inner: &TypeInner, index: u32, span: Span) -> Result<(u32, u32, u32), Fault> {
        Ok(match inner {
            TypeInner::Vector { size, .. } => (index.min(*size as u32 - 1), 1, *size as u32),
            TypeInner::Matrix { columns, rows, .. } => {
                (index.min(*columns as u32 - 1) * *rows as u32, *rows as u32, *columns as u32)
            }
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let size = self.size_of(*base, span)?;
                (index.min(count.get() - 1) * size, size, count.get())
            }
            TypeInner::Struct { members, .. } => {
                let mut offset = 0;
                for member in &members[..index as usize] {
                    offset += self.size_of(member.ty, span)?;
                }
                (offset, 1, 1)
            }
            _ => return Err(fault(span, "A field only computes with numbers: this is not for it.")),
        })
    }

    fn binary(
        &mut self,
        body: &mut Body,
        op: BinaryOperator,
        (a, b): (u32, u32),
        (left, right): (Shape, Shape),
    ) -> Option<u32> {
        let is_matrix = |shape: Shape| shape.columns > 1;
        if op == BinaryOperator::Multiply
            && (is_matrix(left) || is_matrix(right))
            && !left.is_scalar()
            && !right.is_scalar()
        {
            // Columns of the result, each of which has a component for each row.
            let (rows, columns, inner) = match (is_matrix(left), is_matrix(right)) {
                (true, true) => (left.rows, right.columns, left.columns),
                (true, false) => (left.rows, 1, left.columns),
                _ => (1, right.columns, right.rows),
            };
            let mut components = Vec::new();
            for column in 0..columns {
                for row in 0..rows {
                    let (a, step) = if is_matrix(left) { (a + row, left.rows) } else { (a, 1) };
                    components.push(self.dot(body, a, b + column * inner, inner, [step, 1]));
                }
            }
            return Some(self.gathered(body, &components));
        }
        let function = math::binary(op, left.kind)?;
        let count = left.count().max(right.count());
        let steps = u8::from(!left.is_scalar()) | u8::from(!right.is_scalar()) << 1;
        Some(self.apply(body, function, &[a, b], steps, count))
    }

    fn math(
        &mut self,
        body: &mut Body<'m>,
        fun: MathFunction,
        arguments: &[Handle<Expression>],
    ) -> Result<Option<u32>, Fault> {
        use MathFunction as F;
        let mut slots = Vec::new();
        let mut shapes = Vec::new();
        for &argument in arguments {
            slots.push(self.value(body, argument)?);
            let Some(shape) = self.shape(body, argument) else { return Ok(None) };
            shapes.push(shape);
        }
        let first = shapes[0];
        let count = first.count();
        if let Some(function) = math::componentwise(fun, first.kind) {
            let count = shapes.iter().map(|shape| shape.count()).max().unwrap_or(1);
            let steps = shapes.iter().enumerate().map(|(k, shape)| u8::from(!shape.is_scalar()) << k).sum();
            return Ok(Some(self.apply(body, function, &slots, steps, count)));
        }
        if first.kind != ScalarKind::Float && fun != F::Dot {
            return Ok(None);
        }
        let a = slots[0];
        let b = slots.get(1).copied().unwrap_or_default();
        let c = slots.get(2).copied().unwrap_or_default();
        let result = match fun {
            F::Dot if first.kind == ScalarKind::Float => self.dot(body, a, b, count, [1, 1]),
            F::Dot => {
                let (Some(times), Some(plus)) =
                    (math::binary(BinaryOperator::Multiply, first.kind), math::binary(BinaryOperator::Add, first.kind))
                else {
                    return Ok(None);
                };
                let products = self.apply(body, times, &[a, b], EACH, count);
                (1..count).fold(products, |sum, k| self.apply(body, plus, &[sum, products + k], EACH, 1))
            }
            F::Length => self.length(body, a, count),
            F::Distance => {
                let offset = self.apply(body, math::SUBTRACT, &[a, b], EACH, count);
                self.length(body, offset, count)
            }
            F::Normalize => {
                let length = self.length(body, a, count);
                self.apply(body, math::DIVIDE, &[a, length], 0b01, count)
            }
            F::Cross => {
                let component = |compiler: &mut Self, body: &mut Body, [i, j]: [u32; 2]| {
                    let first = compiler.apply(body, math::MULTIPLY, &[a + i, b + j], EACH, 1);
                    let second = compiler.apply(body, math::MULTIPLY, &[a + j, b + i], EACH, 1);
                    compiler.apply(body, math::SUBTRACT, &[first, second], EACH, 1)
                };
                let components = [[1, 2], [2, 0], [0, 1]].map(|pair| component(self, body, pair));
                self.gathered(body, &components)
            }
            F::FaceForward => {
                let facing = self.dot(body, b, c, count, [1, 1]);
                let below = self.apply(body, math::BELOW_ZERO, &[facing], EACH, 1);
                let turned = self.apply(body, math::NEGATE, &[a], EACH, count);
                self.apply(body, math::SELECT, &[below, a, turned], 0b110, count)
            }
            F::Reflect => {
                let along = self.dot(body, b, a, count, [1, 1]);
                let twice = self.apply(body, math::ADD, &[along, along], EACH, 1);
                let change = self.apply(body, math::MULTIPLY, &[twice, b], 0b10, count);
                self.apply(body, math::SUBTRACT, &[a, change], EACH, count)
            }
            F::Refract => {
                // k = 1 - eta² (1 - (b·a)²); eta a - (eta b·a + √k) b, zero where k < 0.
                let one = self.constant(1.0_f32.to_bits());
                let along = self.dot(body, b, a, count, [1, 1]);
                let square = self.apply(body, math::MULTIPLY, &[along, along], EACH, 1);
                let across = self.apply(body, math::SUBTRACT, &[one, square], EACH, 1);
                let eta_square = self.apply(body, math::MULTIPLY, &[c, c], EACH, 1);
                let lost = self.apply(body, math::MULTIPLY, &[eta_square, across], EACH, 1);
                let k = self.apply(body, math::SUBTRACT, &[one, lost], EACH, 1);
                let root = self.apply(body, math::SQRT, &[k], EACH, 1);
                let scaled = self.apply(body, math::MULTIPLY, &[c, along], EACH, 1);
                let factor = self.apply(body, math::ADD, &[scaled, root], EACH, 1);
                let straight = self.apply(body, math::MULTIPLY, &[c, a], 0b10, count);
                let bent = self.apply(body, math::MULTIPLY, &[factor, b], 0b10, count);
                let result = self.apply(body, math::SUBTRACT, &[straight, bent], EACH, count);
                let zero = self.constant(0);
                let total = self.apply(body, math::BELOW_ZERO, &[k], EACH, 1);
                self.apply(body, math::SELECT, &[total, zero, result], 0b100, count)
            }
            F::Transpose => {
                let components: Vec<u32> = (0..first.rows)
                    .flat_map(|row| (0..first.columns).map(move |column| a + column * first.rows + row))
                    .collect();
                self.gathered(body, &components)
            }
            F::Determinant => {
                let rows: Vec<u32> = (0..first.rows).collect();
                self.determinant(body, a, first.rows, 0, &rows)
            }
            _ => return Ok(None),
        };
        Ok(Some(result))
    }

    /// Of the columns from this one on and these rows, by cofactors of the first of them.
    fn determinant(&mut self, body: &mut Body, a: u32, size: u32, column: u32, rows: &[u32]) -> u32 {
        let at = |row: u32| a + column * size + row;
        if let [row] = rows {
            return at(*row);
        }
        let mut sum = None;
        for (k, &row) in rows.iter().enumerate() {
            let others: Vec<u32> = rows.iter().copied().filter(|&other| other != row).collect();
            let minor = self.determinant(body, a, size, column + 1, &others);
            let term = self.apply(body, math::MULTIPLY, &[at(row), minor], EACH, 1);
            sum = Some(match sum {
                None => term,
                Some(sum) => {
                    let function = if k % 2 == 0 { math::ADD } else { math::SUBTRACT };
                    self.apply(body, function, &[sum, term], EACH, 1)
                }
            });
        }
        sum.unwrap_or_default()
    }
}

impl Shape {
    fn count(self) -> u32 {
        self.rows * self.columns
    }
    fn is_scalar(self) -> bool {
        self.count() == 1
    }
}

/// The shape of a scalar, a vector or a matrix.
fn shape(inner: &TypeInner) -> Option<Shape> {
    let (scalar, rows, columns) = match *inner {
        TypeInner::Scalar(scalar) => (scalar, 1, 1),
        TypeInner::Vector { size, scalar } => (scalar, size as u32, 1),
        TypeInner::Matrix { columns, rows, scalar } => (scalar, rows as u32, columns as u32),
        _ => return None,
    };
    Some(Shape { kind: scalar.kind, rows, columns })
}
