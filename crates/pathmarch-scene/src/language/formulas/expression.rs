//! Formulas for numbers: `"spin + 90*t"`.
//!
//! The grammar is that of school mathematics, by `winnow`'s Pratt parser (Pratt 1973): `+ - * / % ^`, brackets, names and
//! functions. `^` binds tighter than a sign and to the right, so that `-2^2` is -4 and `2^3^2` is 512; `%` is the remainder
//! with the sign of the divisor, as `mod`. A formula knows no names: who evaluates it looks them up. Cost: parsing about
//! 0.1 µs for each character, evaluation some ns for each operation; length and nesting are bounded before either.

use winnow::Parser;
use winnow::ascii::{digit1, multispace0};
use winnow::combinator::{Infix, Prefix, alt, cut_err, delimited, expression, opt, preceded, separated, terminated};
use winnow::error::{ContextError, ErrMode};
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{any, one_of, take_while};

/// Bytes of a formula; longer ones are refused.
pub(crate) const MAX_LENGTH: usize = 1000;
/// Largest number of brackets, signs and powers in a formula, each of which may contain all that follows.
pub(crate) const MAX_DEPTH: usize = 100;

/// Function of one or more numbers.
#[derive(Clone, Copy)]
enum Formula {
    One(fn(f64) -> f64),
    Two(fn(f64, f64) -> f64),
    Three(fn(f64, f64, f64) -> f64),
    /// One number or more, folded from the first to the last.
    Fold(fn(f64, f64) -> f64),
    /// A number, and pairs of numbers of which the first ones rise.
    Pairs(fn(f64, &[[f64; 2]]) -> f64),
}

/// A function: name, formula, usage.
struct Function {
    name: &'static str,
    formula: Formula,
    usage: &'static str,
}

const fn function(name: &'static str, formula: Formula, usage: &'static str) -> Function {
    Function { name, formula, usage }
}

/// Angles are radians, as in every mathematical library.
const FUNCTIONS: &[Function] = &[
    function("sin", Formula::One(f64::sin), "sin(x)"),
    function("cos", Formula::One(f64::cos), "cos(x)"),
    function("tan", Formula::One(f64::tan), "tan(x)"),
    function("asin", Formula::One(f64::asin), "asin(x)"),
    function("acos", Formula::One(f64::acos), "acos(x)"),
    function("atan", Formula::One(f64::atan), "atan(x)"),
    function("atan2", Formula::Two(f64::atan2), "atan2(y, x)"),
    function("radians", Formula::One(f64::to_radians), "radians(degrees)"),
    function("degrees", Formula::One(f64::to_degrees), "degrees(radians)"),
    function("sqrt", Formula::One(f64::sqrt), "sqrt(x)"),
    function("pow", Formula::Two(f64::powf), "pow(x, y)"),
    function("exp", Formula::One(f64::exp), "exp(x)"),
    function("log", Formula::One(f64::ln), "log(x)"),
    function("log2", Formula::One(f64::log2), "log2(x)"),
    function("log10", Formula::One(f64::log10), "log10(x)"),
    function("abs", Formula::One(f64::abs), "abs(x)"),
    function("sign", Formula::One(sign), "sign(x)"),
    function("floor", Formula::One(f64::floor), "floor(x)"),
    function("ceil", Formula::One(f64::ceil), "ceil(x)"),
    function("round", Formula::One(f64::round), "round(x)"),
    function("fract", Formula::One(fract), "fract(x)"),
    function("mod", Formula::Two(modulo), "mod(x, y)"),
    function("min", Formula::Fold(f64::min), "min(a, b)"),
    function("max", Formula::Fold(f64::max), "max(a, b)"),
    function("clamp", Formula::Three(clamp), "clamp(x, low, high)"),
    function("mix", Formula::Three(mix), "mix(a, b, share)"),
    function("step", Formula::Two(step), "step(edge, x)"),
    function("smoothstep", Formula::Three(smoothstep), "smoothstep(from, to, x)"),
    function("keys", Formula::Pairs(keys), "keys(t, time, value, later, value, …)"),
];

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
fn fract(x: f64) -> f64 {
    x - x.floor()
}
fn modulo(x: f64, y: f64) -> f64 {
    x - y * (x / y).floor()
}
fn clamp(x: f64, low: f64, high: f64) -> f64 {
    x.max(low).min(high)
}
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}
fn step(edge: f64, x: f64) -> f64 {
    if x < edge { 0.0 } else { 1.0 }
}
fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let share = clamp((x - from) / (to - from), 0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Smooth curve through keys, without overshoot; constant before the first and after the last one: cubic Hermite curves with
/// the harmonic mean of the slopes at both sides as tangent, and level tangents at extremes (Fritsch and Butland 1984).
fn keys(x: f64, keys: &[[f64; 2]]) -> f64 {
    let (Some(&[start, first]), Some(&[end, last])) = (keys.first(), keys.last()) else { return f64::NAN };
    if x <= start {
        return first;
    }
    if x >= end {
        return last;
    }
    // Not a number is in no interval.
    let Some(k) = keys.windows(2).position(|pair| x < pair[1][0]) else { return f64::NAN };
    let slope = |k: usize| (keys[k + 1][1] - keys[k][1]) / (keys[k + 1][0] - keys[k][0]);
    let tangent = |k: usize| {
        if k == 0 || k + 1 == keys.len() {
            return 0.0;
        }
        let (before, after) = (slope(k - 1), slope(k));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (w1, w2) = (keys[k][0] - keys[k - 1][0], keys[k + 1][0] - keys[k][0]);
        (w1 + w2) / ((2.0 * w1 + w2) / (3.0 * after) + (w1 + 2.0 * w2) / (3.0 * before))
    };
    let width = keys[k + 1][0] - keys[k][0];
    let s = (x - keys[k][0]) / width;
    let rise = s * s * (3.0 - 2.0 * s);
    let (out, back) = (s * (1.0 - s) * (1.0 - s), s * s * (s - 1.0));
    keys[k][1] + (keys[k + 1][1] - keys[k][1]) * rise + width * (tangent(k) * out + tangent(k + 1) * back)
}

/// Names of all functions.
pub(crate) fn functions() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|function| function.name)
}

/// The constants, by name.
pub(crate) const CONSTANTS: [(&str, f64); 3] =
    [("pi", std::f64::consts::PI), ("tau", std::f64::consts::TAU), ("e", std::f64::consts::E)];

/// True for characters of names; a name does not start with a digit.
fn is_name_character(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// True if a formula can use `text` as a name.
pub(crate) fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| is_name_character(c) && !c.is_numeric()) && text.chars().all(is_name_character)
}

/// Renames a parameter in a formula; functions keep their names.
pub(crate) fn renamed(text: &str, (old, new): (&str, &str)) -> String {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let class = is_name_character(first);
        let end = rest.find(|c| is_name_character(c) != class).unwrap_or(rest.len());
        let (piece, behind) = rest.split_at(end);
        // The `e` of 2e5 is part of a word that starts with a digit.
        let call = behind.trim_start().starts_with('(');
        result.push_str(if piece == old && !call { new } else { piece });
        rest = behind;
    }
    result
}

/// Bytes of the text.
type Range = std::ops::Range<usize>;

/// A parsed formula.
#[derive(Clone, Debug)]
pub(crate) struct Expression {
    root: Term,
}

#[derive(Clone, Debug)]
enum Term {
    Number(f64),
    Name(String, Range),
    Negated(Box<Term>),
    Two(fn(f64, f64) -> f64, Box<(Term, Term)>),
    Call(String, Range, Vec<Term>),
}

/// Reason why a text is no formula, or has no value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Trouble {
    /// It has more characters than allowed.
    TooLong,
    /// It is nested too deeply.
    TooDeep,
    /// The formulas of the scene have taken too long together.
    TooMuch,
    /// It uses a number whose mistake has been reported.
    Told,
    /// It cannot be read from this byte on.
    Syntax(usize),
    /// There is no number of this name.
    UnknownName(String, Range),
    /// There is no function of this name.
    UnknownFunction(String, Range),
    /// A function without brackets, or with a wrong number of arguments: its usage.
    Arguments(&'static str, Range),
}

type Input<'t> = LocatingSlice<&'t str>;
type Result<T> = std::result::Result<T, ErrMode<ContextError>>;

impl Expression {
    /// Parses a formula.
    pub(crate) fn read(text: &str) -> std::result::Result<Self, Trouble> {
        if text.len() > MAX_LENGTH {
            return Err(Trouble::TooLong);
        }
        if depth(text) > MAX_DEPTH {
            return Err(Trouble::TooDeep);
        }
        let mut input = LocatingSlice::new(text);
        match preceded(multispace0, terms).parse_next(&mut input) {
            Ok(root) if input.is_empty() => Ok(Self { root }),
            _ => Err(Trouble::Syntax(input.current_token_start())),
        }
    }
    /// Evaluates the formula; `lookup` resolves names that are not constants.
    pub(crate) fn value(&self, lookup: &mut dyn FnMut(&str) -> Option<f64>) -> std::result::Result<f64, Trouble> {
        value(&self.root, lookup)
    }
    /// True if it is a name and nothing else.
    pub(crate) fn is_name(&self) -> bool {
        matches!(self.root, Term::Name(..))
    }
}

/// Lower bound of a text's nesting: brackets, signs and powers may each contain all that follows.
fn depth(text: &str) -> usize {
    let mut operand = false;
    let holds = text.chars().filter(|c| {
        let holds = matches!(c, '(' | '^') || matches!(c, '+' | '-') && !operand;
        operand = *c == ')' || is_name_character(*c) || operand && c.is_whitespace();
        holds
    });
    holds.count()
}

/// Operands with operators between them. Recursion is bounded by [`depth`].
fn terms(input: &mut Input) -> Result<Term> {
    expression(operand).prefix(sign_before).infix(operator).parse_next(input)
}

fn no<T>() -> Result<T> {
    Err(ErrMode::Backtrack(ContextError::new()))
}

fn two(formula: fn(f64, f64) -> f64, a: Term, b: Term) -> Result<Term> {
    Ok(Term::Two(formula, Box::new((a, b))))
}

/// An operator between two operands, with the white space behind it.
fn operator<'t>(input: &mut Input<'t>) -> Result<Infix<Input<'t>, Term, ErrMode<ContextError>>> {
    let infix = match input.chars().next() {
        Some('+') => Infix::Left(1, |_: &mut Input<'t>, a, b| two(|a, b| a + b, a, b)),
        Some('-') => Infix::Left(1, |_: &mut Input<'t>, a, b| two(|a, b| a - b, a, b)),
        Some('*') => Infix::Left(3, |_: &mut Input<'t>, a, b| two(|a, b| a * b, a, b)),
        Some('/') => Infix::Left(3, |_: &mut Input<'t>, a, b| two(|a, b| a / b, a, b)),
        Some('%') => Infix::Left(3, |_: &mut Input<'t>, a, b| two(modulo, a, b)),
        Some('^') => Infix::Right(7, |_: &mut Input<'t>, a, b| two(f64::powf, a, b)),
        _ => return no(),
    };
    (any, multispace0).value(infix).parse_next(input)
}

/// A sign before an operand.
fn sign_before<'t>(input: &mut Input<'t>) -> Result<Prefix<Input<'t>, Term, ErrMode<ContextError>>> {
    let prefix = match input.chars().next() {
        Some('+') => Prefix(5, |_: &mut Input<'t>, a| Ok(a)),
        Some('-') => Prefix(5, |_: &mut Input<'t>, a| Ok(Term::Negated(Box::new(a)))),
        _ => return no(),
    };
    (any, multispace0).value(prefix).parse_next(input)
}

/// A number, a name, a call, or brackets, with the white space behind it.
fn operand(input: &mut Input) -> Result<Term> {
    match input.chars().next() {
        Some(c) if c.is_ascii_digit() || c == '.' => terminated(number, multispace0).parse_next(input),
        Some(c) if is_name_character(c) => {
            let (name, range) = take_while(1.., is_name_character).with_span().parse_next(input)?;
            multispace0.parse_next(input)?;
            if !input.starts_with('(') {
                return Ok(Term::Name(name.to_owned(), range));
            }
            let arguments = brackets(separated(0.., terms, (',', multispace0))).parse_next(input)?;
            Ok(Term::Call(name.to_owned(), range, arguments))
        }
        Some('(') => brackets(terms).parse_next(input),
        _ => no(),
    }
}

/// Parses brackets. Nothing else starts with one, so that a mistake in them is reported at its place.
fn brackets<'t, T>(
    inside: impl Parser<Input<'t>, T, ErrMode<ContextError>>,
) -> impl Parser<Input<'t>, T, ErrMode<ContextError>> {
    delimited(('(', multispace0), cut_err(inside), cut_err((')', multispace0)))
}

fn number(input: &mut Input) -> Result<Term> {
    let exponent = || opt((one_of(['e', 'E']), opt(one_of(['+', '-'])), digit1));
    let digits = alt(((digit1, opt(('.', digit1)), exponent()).take(), ('.', digit1, exponent()).take()));
    digits.parse_to().map(Term::Number).parse_next(input)
}

fn value(term: &Term, lookup: &mut dyn FnMut(&str) -> Option<f64>) -> std::result::Result<f64, Trouble> {
    Ok(match term {
        Term::Number(number) => *number,
        Term::Negated(term) => -value(term, lookup)?,
        Term::Two(formula, terms) => formula(value(&terms.0, lookup)?, value(&terms.1, lookup)?),
        Term::Name(name, range) => {
            let constant = || CONSTANTS.iter().find(|(constant, _)| constant == name).map(|(_, value)| *value);
            match lookup(name).or_else(constant) {
                Some(value) => value,
                None => match FUNCTIONS.iter().find(|function| function.name == name) {
                    Some(function) => return Err(Trouble::Arguments(function.usage, range.clone())),
                    None => return Err(Trouble::UnknownName(name.clone(), range.clone())),
                },
            }
        }
        Term::Call(name, range, arguments) => {
            let Some(function) = FUNCTIONS.iter().find(|function| function.name == name) else {
                return Err(Trouble::UnknownFunction(name.clone(), range.clone()));
            };
            let values: Vec<f64> =
                arguments.iter().map(|term| value(term, lookup)).collect::<std::result::Result<_, _>>()?;
            match (function.formula, &values[..]) {
                (Formula::One(formula), [x]) => formula(*x),
                (Formula::Two(formula), [x, y]) => formula(*x, *y),
                (Formula::Three(formula), [x, y, z]) => formula(*x, *y, *z),
                (Formula::Fold(formula), [first, others @ ..]) => others.iter().fold(*first, |a, b| formula(a, *b)),
                (Formula::Pairs(formula), [x, pairs @ ..]) => match pairs.as_chunks() {
                    (pairs, []) if !pairs.is_empty() && pairs.windows(2).all(|pair| pair[0][0] < pair[1][0]) => {
                        formula(*x, pairs)
                    }
                    _ => return Err(Trouble::Arguments(function.usage, range.clone())),
                },
                _ => return Err(Trouble::Arguments(function.usage, range.clone())),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{Expression, MAX_LENGTH, Trouble};
    use proptest::prelude::*;

    fn value(text: &str) -> Result<f64, Trouble> {
        Expression::read(text)?.value(&mut |name| (name == "x").then_some(3.0))
    }

    #[test]
    fn school_mathematics() {
        let cases = [
            ("1 + 2*3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("-2^2", -4.0),
            ("(-2)^2", 4.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("2*-3", -6.0),
            ("- - 2", 2.0),
            ("+x", 3.0),
            ("8/4/2", 1.0),
            ("10-3-2", 5.0),
            ("2*6/4*2", 6.0),
            ("-1 % 3", 2.0),
            ("7 % 4 * 2", 6.0),
            ("1e-3*2", 0.002),
            (".5 + 0.25", 0.75),
            ("2E2", 200.0),
            ("x^2 - x", 6.0),
            ("max(1, min(2, x), 0.5)", 2.0),
            ("clamp(5, 0, 1)", 1.0),
            ("mix(2, 4, 0.25)", 2.5),
            ("smoothstep(0, 2, 1)", 0.5),
            ("step(2, 1) + step(2, 2)", 1.0),
            ("mod(-1, 4)", 3.0),
            ("fract(-0.25)", 0.75),
            ("round(sin(pi/2)*10 + cos(0))", 11.0),
            ("atan2(0, 1)", 0.0),
            ("log(e)", 1.0),
            ("degrees(tau)", 360.0),
            (" ( 1 ) ", 1.0),
            ("keys(x, 1, 5)", 5.0),
            ("keys(x, 2, 0, 4, 10)", 5.0),
            ("keys(0, 2, 7, 4, 10) + keys(9, 2, 7, 4, 10)", 17.0),
            ("keys(x, 0, 1, 3, -2, 4, 8)", -2.0),
            ("keys(x % 2, 0, 0, 1, 4, 2, 0)", 4.0),
        ];
        for (text, expected) in cases {
            let value = value(text).unwrap_or_else(|trouble| panic!("{text}: {trouble:?}"));
            assert!((value - expected).abs() < 1e-12, "{text} is {value}");
        }
    }

    #[test]
    fn troubles_are_told_where_they_are() {
        let cases = [
            ("", Trouble::Syntax(0)),
            ("1 +", Trouble::Syntax(3)),
            ("1 + * 2", Trouble::Syntax(4)),
            ("(1 + * 2)", Trouble::Syntax(5)),
            ("sin(1 2)", Trouble::Syntax(6)),
            ("2x", Trouble::Syntax(1)),
            ("1e", Trouble::Syntax(1)),
            ("(1", Trouble::Syntax(2)),
            ("1)", Trouble::Syntax(1)),
            ("1, 2", Trouble::Syntax(1)),
            ("max(1,)", Trouble::Syntax(5)),
            ("0.5;", Trouble::Syntax(3)),
            ("1 + yy", Trouble::UnknownName("yy".to_owned(), 4..6)),
            ("2*sine(1)", Trouble::UnknownFunction("sine".to_owned(), 2..6)),
            ("sin", Trouble::Arguments("sin(x)", 0..3)),
            ("sin()", Trouble::Arguments("sin(x)", 0..3)),
            ("clamp(1, 2)", Trouble::Arguments("clamp(x, low, high)", 0..5)),
            ("keys(x)", Trouble::Arguments("keys(t, time, value, later, value, …)", 0..4)),
            ("keys(x, 1, 2, 3)", Trouble::Arguments("keys(t, time, value, later, value, …)", 0..4)),
            ("keys(x, 1, 2, 1, 3)", Trouble::Arguments("keys(t, time, value, later, value, …)", 0..4)),
            ("x(1)", Trouble::UnknownFunction("x".to_owned(), 0..1)),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Err(expected), "{text}");
        }
    }

    /// Nothing that can be written in a formula takes long or much of the stack, which here is small.
    #[test]
    fn hostile_formulas_are_refused() {
        let run = || {
            for (piece, end) in [("(", ")"), ("-", ""), ("+", ""), ("2^", ""), ("sin(", ")"), ("- (", ")"), ("((", "")]
            {
                let text = format!("{}1{}", piece.repeat(5000), end.repeat(5000));
                assert_eq!(value(&text), Err(Trouble::TooLong));
                let many = (MAX_LENGTH - 1) / (piece.len() + end.len());
                let text = format!("{}1{}", piece.repeat(many), end.repeat(many));
                assert_eq!(value(&text), Err(Trouble::TooDeep), "{text}");
            }
            let sum = "1".to_owned() + &"+1".repeat(MAX_LENGTH / 2 - 1);
            assert_eq!(value(&sum), Ok((MAX_LENGTH / 2) as f64));
            assert_eq!(value("1/0"), Ok(f64::INFINITY));
            assert_eq!(value(&"9".repeat(MAX_LENGTH)), Ok(f64::INFINITY));
            assert!(value("0/0").unwrap().is_nan() && value("(-1)^0.5").unwrap().is_nan());
        };
        std::thread::Builder::new().stack_size(512 << 10).spawn(run).unwrap().join().unwrap();
    }

    proptest! {
        #[test]
        fn no_text_is_too_much(text in "\\PC{0,60}|[-+*/%^(),. a-e0-9]{0,200}|(sin\\(|\\(|-|2|x|\\^|\\)| |max|,){0,80}") {
            let _ = value(&text);
        }
    }
}
