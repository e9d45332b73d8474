//! Compilation of expressions: constants, composition and access, and calls of functions.

use super::{Body, Compiler, EACH, Pointer, Value, fault};
use crate::custom_sdf::CodeDiagnostic;
use crate::custom_sdf::machine::Op;
use crate::custom_sdf::math;
use naga::{Expression, Handle, Literal, RelationalFunction, Span, TypeInner};

/// Literal as the bits of a slot.
fn bits(literal: Literal, span: Span) -> Result<u32, CodeDiagnostic> {
    Ok(match literal {
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
    })
}

impl<'m> Compiler<'m> {
    /// First slot of a constant of the module, evaluated once; nothing writes to it.
    fn global(&mut self, constant: Handle<naga::Constant>) -> Result<u32, CodeDiagnostic> {
        if let Some(&slot) = self.globals.get(&constant) {
            return Ok(slot);
        }
        let mut values = Vec::new();
        self.constant_values(self.module.constants[constant].init, &mut values)?;
        let slot = self.alloc(values.len() as u32);
        // Slots beyond the limit do not exist; the program is refused.
        if let Some(place) = self.memory.get_mut(slot as usize..slot as usize + values.len()) {
            place.copy_from_slice(&values);
        }
        self.globals.insert(constant, slot);
        Ok(slot)
    }

    /// Scalars of a tree of literals; the size of constants is limited.
    fn constant_values(&self, expression: Handle<Expression>, values: &mut Vec<u32>) -> Result<(), CodeDiagnostic> {
        let span = self.module.global_expressions.get_span(expression);
        match &self.module.global_expressions[expression] {
            Expression::Literal(literal) => values.push(bits(*literal, span)?),
            Expression::Constant(constant) => self.constant_values(self.module.constants[*constant].init, values)?,
            Expression::ZeroValue(ty) => {
                let size = self.size_of(*ty, span)? as usize;
                values.resize(values.len() + size, 0);
            }
            Expression::Compose { components, .. } => {
                for component in components {
                    self.constant_values(*component, values)?;
                }
            }
            Expression::Splat { size, value } => {
                for _ in 0..*size as u32 {
                    self.constant_values(*value, values)?;
                }
            }
            _ => return Err(fault(span, "A constant of a field is a number, or made of numbers.")),
        }
        Ok(())
    }

    pub(super) fn expression(
        &mut self,
        body: &mut Body<'m>,
        handle: Handle<Expression>,
    ) -> Result<Value, CodeDiagnostic> {
        let span = body.function.expressions.get_span(handle);
        let unknown = || fault(span, "A field only computes with numbers: this is not for it.");
        let slot = match &body.function.expressions[handle] {
            Expression::Literal(literal) => self.constant(bits(*literal, span)?),
            Expression::Constant(constant) => self.global(*constant)?,
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
            Expression::GlobalVariable(global) => {
                return self.variables.get(global).map(|slot| Value::Pointer(Pointer::Slot(*slot))).ok_or_else(unknown);
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
}
