//! Scalar functions of WGSL on eight lanes; [`super::compile`] composes vector functions of them.
//!
//! A lane is 32 bits: an `f32`, an `i32`, a `u32`, or a truth value with all bits set or none. Where WGSL leaves a choice,
//! results follow GPUs: a power of a negative number is NaN, `%` is x - y trunc(x/y).

use crate::number::Real;
use naga::{BinaryOperator, MathFunction, ScalarKind, UnaryOperator};
use wide::f32x8;

/// One scalar for each of eight points.
pub(super) type Lanes = [u32; 8];

/// Function of one to three scalars.
#[derive(Clone, Copy)]
pub(super) enum Function {
    One(fn(&Lanes) -> Lanes),
    Two(fn(&Lanes, &Lanes) -> Lanes),
    Three(fn(&Lanes, &Lanes, &Lanes) -> Lanes),
}

/// Type of a lane.
trait Bits: Copy {
    fn from_bits(bits: u32) -> Self;
    fn to_bits(self) -> u32;
}

impl Bits for f32 {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }
}

impl Bits for i32 {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits as i32
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        self as u32
    }
}

impl Bits for u32 {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        self
    }
}

impl Bits for bool {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits != 0
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        if self { u32::MAX } else { 0 }
    }
}

#[inline(always)]
fn map<A: Bits, R: Bits>(a: &Lanes, f: impl Fn(A) -> R) -> Lanes {
    std::array::from_fn(|lane| f(A::from_bits(a[lane])).to_bits())
}

#[inline(always)]
fn zip<A: Bits, B: Bits, R: Bits>(a: &Lanes, b: &Lanes, f: impl Fn(A, B) -> R) -> Lanes {
    std::array::from_fn(|lane| f(A::from_bits(a[lane]), B::from_bits(b[lane])).to_bits())
}

#[inline(always)]
fn zip3<A: Bits, B: Bits, C: Bits, R: Bits>(a: &Lanes, b: &Lanes, c: &Lanes, f: impl Fn(A, B, C) -> R) -> Lanes {
    std::array::from_fn(|lane| f(A::from_bits(a[lane]), B::from_bits(b[lane]), C::from_bits(c[lane])).to_bits())
}

/// Applies a function of `f32x8`.
#[inline(always)]
fn wide(a: &Lanes, f: impl Fn(f32x8) -> f32x8) -> Lanes {
    f(f32x8::from(a.map(f32::from_bits))).to_array().map(f32::to_bits)
}

macro_rules! one {
    ($kind:ty, $f:expr) => {
        Function::One(|a| map::<$kind, _>(a, $f))
    };
}
macro_rules! two {
    ($kind:ty, $f:expr) => {
        Function::Two(|a, b| zip::<$kind, $kind, _>(a, b, $f))
    };
}
macro_rules! three {
    ($kind:ty, $f:expr) => {
        Function::Three(|a, b, c| zip3::<$kind, $kind, $kind, _>(a, b, c, $f))
    };
}
macro_rules! wide {
    ($f:expr) => {
        Function::One(|a| wide(a, $f))
    };
}

pub(super) const ADD: Function = two!(f32, |a, b| a + b);
pub(super) const SUBTRACT: Function = two!(f32, |a, b| a - b);
pub(super) const MULTIPLY: Function = two!(f32, |a, b| a * b);
pub(super) const DIVIDE: Function = two!(f32, |a, b| a / b);
pub(super) const SQRT: Function = wide!(f32x8::sqrt);
pub(super) const BELOW_ZERO: Function = one!(f32, |a| a < 0.0);
pub(super) const NEGATE: Function = one!(f32, |a| -a);
pub(super) const BOTH: Function = two!(u32, |a, b| a & b);
pub(super) const EITHER: Function = two!(u32, |a, b| a | b);
/// Operands: condition, value if true, value if false.
pub(super) const SELECT: Function = three!(u32, |c, yes, no| (c & yes) | (!c & no));

fn quotient(a: i32, b: i32) -> i32 {
    if b == 0 { a } else { a.wrapping_div(b) }
}

fn rest(a: i32, b: i32) -> i32 {
    if b == 0 { 0 } else { a.wrapping_rem(b) }
}

pub(super) fn unary(op: UnaryOperator, kind: ScalarKind) -> Option<Function> {
    Some(match (op, kind) {
        (UnaryOperator::Negate, ScalarKind::Float) => NEGATE,
        (UnaryOperator::Negate, ScalarKind::Sint) => one!(i32, |a| a.wrapping_neg()),
        (UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot, _) => one!(u32, |a| !a),
        _ => return None,
    })
}

pub(super) fn binary(op: BinaryOperator, kind: ScalarKind) -> Option<Function> {
    use BinaryOperator as Op;
    use ScalarKind::{Bool, Float, Sint, Uint};
    Some(match (op, kind) {
        (Op::Add, Float) => ADD,
        (Op::Subtract, Float) => SUBTRACT,
        (Op::Multiply, Float) => MULTIPLY,
        (Op::Divide, Float) => DIVIDE,
        (Op::Modulo, Float) => two!(f32, |a, b| a - b * (a / b).trunc()),
        (Op::Equal, Float) => two!(f32, |a, b| a == b),
        (Op::NotEqual, Float) => two!(f32, |a, b| a != b),
        (Op::Less, Float) => two!(f32, |a, b| a < b),
        (Op::LessEqual, Float) => two!(f32, |a, b| a <= b),
        (Op::Greater, Float) => two!(f32, |a, b| a > b),
        (Op::GreaterEqual, Float) => two!(f32, |a, b| a >= b),
        (Op::Add, Sint | Uint) => two!(u32, |a, b| a.wrapping_add(b)),
        (Op::Subtract, Sint | Uint) => two!(u32, |a, b| a.wrapping_sub(b)),
        (Op::Multiply, Sint | Uint) => two!(u32, |a, b| a.wrapping_mul(b)),
        (Op::Divide, Sint) => two!(i32, quotient),
        (Op::Modulo, Sint) => two!(i32, rest),
        (Op::Divide, Uint) => two!(u32, |a, b| a.checked_div(b).unwrap_or(a)),
        (Op::Modulo, Uint) => two!(u32, |a, b| a.checked_rem(b).unwrap_or(0)),
        (Op::Equal, Sint | Uint) => two!(u32, |a, b| a == b),
        (Op::NotEqual, Sint | Uint) => two!(u32, |a, b| a != b),
        (Op::Equal, Bool) => two!(bool, |a, b| a == b),
        (Op::NotEqual, Bool) => two!(bool, |a, b| a != b),
        (Op::Less, Sint) => two!(i32, |a, b| a < b),
        (Op::LessEqual, Sint) => two!(i32, |a, b| a <= b),
        (Op::Greater, Sint) => two!(i32, |a, b| a > b),
        (Op::GreaterEqual, Sint) => two!(i32, |a, b| a >= b),
        (Op::Less, Uint) => two!(u32, |a, b| a < b),
        (Op::LessEqual, Uint) => two!(u32, |a, b| a <= b),
        (Op::Greater, Uint) => two!(u32, |a, b| a > b),
        (Op::GreaterEqual, Uint) => two!(u32, |a, b| a >= b),
        (Op::And, Sint | Uint | Bool) | (Op::LogicalAnd, Bool) => BOTH,
        (Op::InclusiveOr, Sint | Uint | Bool) | (Op::LogicalOr, Bool) => EITHER,
        (Op::ExclusiveOr, Sint | Uint) => two!(u32, |a, b| a ^ b),
        (Op::ShiftLeft, Sint | Uint) => two!(u32, |a, b| a << (b & 31)),
        (Op::ShiftRight, Uint) => two!(u32, |a, b| a >> (b & 31)),
        (Op::ShiftRight, Sint) => Function::Two(|a, b| zip::<i32, u32, _>(a, b, |a, b| a >> (b & 31))),
        _ => return None,
    })
}

/// Conversion of a number or truth value to another kind.
pub(super) fn convert(from: ScalarKind, to: ScalarKind) -> Option<Function> {
    use ScalarKind::{Bool, Float, Sint, Uint};
    Some(match (from, to) {
        (Float, Float) | (Sint | Uint, Sint | Uint) | (Bool, Bool) => one!(u32, |a| a),
        (Float, Sint) => one!(f32, |a| a as i32),
        (Float, Uint) => one!(f32, |a| a as u32),
        (Float, Bool) => one!(f32, |a| a != 0.0),
        (Sint, Float) => one!(i32, |a| a as f32),
        (Uint, Float) => one!(u32, |a| a as f32),
        (Sint | Uint, Bool) => one!(u32, |a| a != 0),
        (Bool, Float) => one!(bool, |a| if a { 1.0_f32 } else { 0.0 }),
        (Bool, Sint | Uint) => one!(u32, |a| a & 1),
        _ => return None,
    })
}

fn sign(a: f32) -> f32 {
    if a > 0.0 {
        1.0
    } else if a < 0.0 {
        -1.0
    } else {
        0.0
    }
}

fn power(a: f32, b: f32) -> f32 {
    if a < 0.0 { f32::NAN } else { a.powf(b) }
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn leading(a: u32) -> u32 {
    if a == 0 { u32::MAX } else { 31 - a.leading_zeros() }
}

fn trailing(a: u32) -> u32 {
    if a == 0 { u32::MAX } else { a.trailing_zeros() }
}

/// Component-wise function.
pub(super) fn componentwise(fun: MathFunction, kind: ScalarKind) -> Option<Function> {
    use MathFunction as F;
    use ScalarKind::{Float, Sint, Uint};
    Some(match (fun, kind) {
        (F::Abs, Float) => one!(f32, f32::abs),
        (F::Abs, Sint) => one!(i32, i32::wrapping_abs),
        (F::Abs, Uint) => one!(u32, |a| a),
        (F::Min, Float) => two!(f32, |a, b| if b < a { b } else { a }),
        (F::Max, Float) => two!(f32, |a, b| if a < b { b } else { a }),
        (F::Min, Sint) => two!(i32, |a, b| a.min(b)),
        (F::Max, Sint) => two!(i32, |a, b| a.max(b)),
        (F::Min, Uint) => two!(u32, |a, b| a.min(b)),
        (F::Max, Uint) => two!(u32, |a, b| a.max(b)),
        (F::Clamp, Float) => three!(f32, |x, low, high| x.max(low).min(high)),
        (F::Clamp, Sint) => three!(i32, |x, low, high| x.max(low).min(high)),
        (F::Clamp, Uint) => three!(u32, |x, low, high| x.max(low).min(high)),
        (F::Saturate, Float) => one!(f32, |a| a.clamp(0.0, 1.0)),
        (F::Cos, Float) => wide!(Real::cos),
        (F::Sin, Float) => wide!(Real::sin),
        (F::Exp, Float) => wide!(Real::exp),
        (F::Log, Float) => wide!(Real::ln),
        (F::Tan, Float) => one!(f32, f32::tan),
        (F::Cosh, Float) => one!(f32, f32::cosh),
        (F::Sinh, Float) => one!(f32, f32::sinh),
        (F::Tanh, Float) => one!(f32, f32::tanh),
        (F::Acos, Float) => one!(f32, f32::acos),
        (F::Asin, Float) => one!(f32, f32::asin),
        (F::Atan, Float) => one!(f32, f32::atan),
        (F::Atan2, Float) => two!(f32, |y, x| y.atan2(x)),
        (F::Asinh, Float) => one!(f32, f32::asinh),
        (F::Acosh, Float) => one!(f32, f32::acosh),
        (F::Atanh, Float) => one!(f32, f32::atanh),
        (F::Radians, Float) => one!(f32, f32::to_radians),
        (F::Degrees, Float) => one!(f32, f32::to_degrees),
        (F::Ceil, Float) => one!(f32, f32::ceil),
        (F::Floor, Float) => wide!(Real::floor),
        (F::Round, Float) => one!(f32, f32::round_ties_even),
        (F::Fract, Float) => wide!(|a| a - Real::floor(a)),
        (F::Trunc, Float) => one!(f32, f32::trunc),
        (F::Ldexp, Float) => Function::Two(|a, b| zip::<f32, i32, _>(a, b, |a, b| a * (b as f32).exp2())),
        (F::Exp2, Float) => one!(f32, f32::exp2),
        (F::Log2, Float) => one!(f32, f32::log2),
        (F::Pow, Float) => two!(f32, power),
        (F::Sign, Float) => one!(f32, sign),
        (F::Sign, Sint) => one!(i32, i32::signum),
        (F::Fma, Float) => three!(f32, |a, b, c| a * b + c),
        (F::Mix, Float) => three!(f32, |a, b, t| a * (1.0 - t) + b * t),
        (F::Step, Float) => two!(f32, |edge, x| if edge <= x { 1.0_f32 } else { 0.0 }),
        (F::SmoothStep, Float) => three!(f32, smoothstep),
        (F::Sqrt, Float) => SQRT,
        (F::InverseSqrt, Float) => one!(f32, |a| 1.0 / a.sqrt()),
        (F::CountTrailingZeros, Sint | Uint) => one!(u32, u32::trailing_zeros),
        (F::CountLeadingZeros, Sint | Uint) => one!(u32, u32::leading_zeros),
        (F::CountOneBits, Sint | Uint) => one!(u32, u32::count_ones),
        (F::ReverseBits, Sint | Uint) => one!(u32, u32::reverse_bits),
        (F::FirstTrailingBit, Sint | Uint) => one!(u32, trailing),
        (F::FirstLeadingBit, Uint) => one!(u32, leading),
        (F::FirstLeadingBit, Sint) => one!(i32, |a| leading(if a < 0 { !a as u32 } else { a as u32 })),
        _ => return None,
    })
}
