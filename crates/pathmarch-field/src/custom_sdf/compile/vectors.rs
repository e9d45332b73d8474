//! Compilation of functions of vectors and matrices to those of scalars.

use super::layout::Shape;
use super::{Body, Compiler, EACH};
use crate::custom_sdf::machine::Op;
use crate::custom_sdf::{CodeDiagnostic, math};
use naga::{BinaryOperator, Expression, Handle, MathFunction, ScalarKind};

impl<'m> Compiler<'m> {
    /// Dot product of two vectors whose components are `strides` apart.
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

    /// Vector of the components in these slots.
    pub(super) fn gathered(&mut self, body: &mut Body, from: &[u32]) -> u32 {
        let to = self.alloc(from.len() as u32);
        body.ops.extend(from.iter().zip(to..).map(|(&from, to)| Op::Copy { to, from, count: 1 }));
        to
    }

    pub(super) fn binary(
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
            // For each column of the result, a component for each row.
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

    pub(super) fn math(
        &mut self,
        body: &mut Body<'m>,
        fun: MathFunction,
        arguments: &[Handle<Expression>],
    ) -> Result<Option<u32>, CodeDiagnostic> {
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

    /// Determinant of the columns from this one on and of these rows, by cofactors of the first column.
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
