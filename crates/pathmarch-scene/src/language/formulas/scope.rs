//! Scope of formulas: the moment, and the visible parameters.

use super::expression::{CONSTANTS, Expression, Trouble, functions};
use crate::language::tree::Span;
use crate::scene::Moment;
use std::collections::HashMap;
use std::rc::Rc;

/// Bytes of formulas that are evaluated for one scene; more are refused. About a second.
const MAX_WORK: usize = 64 << 20;
/// The names of the moment.
const MOMENT: [&str; 2] = ["t", "frame"];

/// Names that no parameter may have.
pub(crate) fn reserved() -> impl Iterator<Item = &'static str> {
    MOMENT.into_iter().chain(CONSTANTS.iter().map(|(name, _)| *name)).chain(functions())
}

/// The value of a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Evaluated {
    pub(crate) value: f64,
    /// True if it depends on the moment.
    pub(crate) moving: bool,
}

/// Names that are visible at a place of the file.
#[derive(Default)]
pub(crate) struct Scope {
    pub(crate) moment: Moment,
    /// True if anything in the scene depends on the moment.
    pub(crate) animated: bool,
    /// The first value of each formula, by the place of its string in the text.
    pub(crate) values: HashMap<u32, f64>,
    /// Parameters of the file.
    file: Vec<(String, Evaluated)>,
    /// Parameters of the declaration that is being read; they hide those of the file.
    own: Vec<(String, Evaluated)>,
    inside: bool,
    read: HashMap<String, Rc<Result<Expression, Trouble>>>,
    work: usize,
}

impl Scope {
    pub(crate) fn at(moment: Moment) -> Self {
        Self { moment, ..Self::default() }
    }

    /// Makes a parameter visible; a value of NaN marks one whose mistake has been reported.
    pub(crate) fn define(&mut self, name: &str, value: Evaluated) {
        let names = if self.inside { &mut self.own } else { &mut self.file };
        names.push((name.to_owned(), value));
    }

    /// Enters a declaration with parameters of its own: parameters around it, except those of the file, are hidden.
    /// Returns the argument of [`Self::leave`].
    pub(crate) fn enter(&mut self) -> Outside {
        Outside { own: std::mem::take(&mut self.own), inside: std::mem::replace(&mut self.inside, true) }
    }
    /// Leaves a declaration.
    pub(crate) fn leave(&mut self, outside: Outside) {
        (self.own, self.inside) = (outside.own, outside.inside);
    }

    /// Names of all visible parameters.
    pub(crate) fn params(&self) -> impl Iterator<Item = &str> {
        self.own.iter().chain(&self.file).map(|(name, _)| name.as_str())
    }
    /// Names of all visible numbers.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.params().chain(MOMENT).chain(CONSTANTS.iter().map(|(name, _)| *name))
    }

    /// Evaluates the formula `text` of the string at `span`.
    pub(crate) fn evaluate(&mut self, text: &str, span: Span) -> Result<Evaluated, Trouble> {
        self.work += text.len();
        if self.work > MAX_WORK {
            return Err(Trouble::TooMuch);
        }
        let read = match self.read.get(text) {
            Some(read) => read.clone(),
            None => {
                let read = Rc::new(Expression::read(text));
                self.read.insert(text.to_owned(), read.clone());
                read
            }
        };
        let expression = read.as_ref().as_ref().map_err(Clone::clone)?;
        let (mut moving, mut broken) = (false, false);
        let value = expression.value(&mut |name| {
            let param = self.own.iter().chain(&self.file).find(|(other, _)| other == name);
            if let Some((_, param)) = param {
                moving |= param.moving;
                broken |= param.value.is_nan();
                return Some(param.value);
            }
            let value = match name {
                "t" => self.moment.seconds,
                "frame" => f64::from(self.moment.frame),
                _ => return None,
            };
            moving = true;
            Some(value)
        })?;
        if broken {
            return Err(Trouble::Told);
        }
        self.animated |= moving;
        self.values.entry(span.start).or_insert(value);
        Ok(Evaluated { value, moving })
    }

    /// The moment, as in "at t = 1.5 s, frame 36".
    pub(crate) fn moment_in_words(&self) -> String {
        format!("at t = {} s, frame {}", self.moment.seconds as f32, self.moment.frame)
    }
}

/// Parameters that are hidden inside a declaration.
pub(crate) struct Outside {
    own: Vec<(String, Evaluated)>,
    inside: bool,
}
