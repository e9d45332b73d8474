//! Size limits of the types in custom shapes.
//!
//! A copy of an array takes as many operations as it has elements, and every variable of a function is memory of each ray on the
//! GPU. Sizes are checked before anything else, because naga copies whole constants while it parses the functions that name
//! them, which grows without bound if constants contain each other.

use super::{CodeDiagnostic, range};
use naga::front::wgsl::ParseError;
use naga::{ArraySize, Module, Span, Type, TypeInner, UniqueArena};
use std::collections::HashMap;
use std::num::NonZeroU32;

/// Largest number of scalars of a variable, a constant or a value, and of all arrays of a call of `distance` together.
///
/// Drivers inline the code wherever it is evaluated. Mesa's software Vulkan then takes 4 s of processor time to compile arrays of
/// 128 scalars, 12 s for 256, 33 s for 512 and minutes for 1,500.
pub const MAX_ARRAY_SCALARS: u32 = 256;
/// Largest number of scalars of all constants that functions name, each counted as often as it is named.
pub(super) const MAX_NAMED_SCALARS: u64 = 1 << 16;

/// Size of a type; sums and products saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Size {
    /// Scalars of a value.
    pub(super) numbers: u32,
    /// Scalars and vectors of a value, which are the operations of a copy.
    pub(super) copies: u32,
    /// True if it is an array or contains one.
    pub(super) has_array: bool,
}

impl Size {
    const ONE: Self = Self { numbers: 1, copies: 1, has_array: false };

    /// Size of a type, given the sizes of those before it.
    fn of(inner: &TypeInner, known: &[Self]) -> Self {
        let of = |handle: naga::Handle<Type>| known.get(handle.index()).copied().unwrap_or(Self::ONE);
        match *inner {
            TypeInner::Vector { size, .. } => Self { numbers: size as u32, ..Self::ONE },
            TypeInner::Matrix { columns, rows, .. } => {
                Self { numbers: columns as u32 * rows as u32, copies: columns as u32, has_array: false }
            }
            TypeInner::Array { base, size, .. } => {
                let count = if let ArraySize::Constant(count) = size { count } else { NonZeroU32::MIN };
                let one = of(base);
                Self {
                    numbers: one.numbers.saturating_mul(count.get()),
                    copies: one.copies.saturating_mul(count.get()),
                    has_array: true,
                }
            }
            TypeInner::Struct { ref members, .. } => {
                members.iter().map(|member| of(member.ty)).fold(Self::default(), |sum, member| Self {
                    numbers: sum.numbers.saturating_add(member.numbers),
                    copies: sum.copies.saturating_add(member.copies),
                    has_array: sum.has_array | member.has_array,
                })
            }
            _ => Self::ONE,
        }
    }
}

/// Sizes of all types of a module.
pub(super) struct Sizes(Vec<Size>);

impl Sizes {
    pub(super) fn new(types: &UniqueArena<Type>) -> Self {
        let mut sizes = Vec::new();
        for (_, ty) in types.iter() {
            // The parts of a type are before it.
            sizes.push(Size::of(&ty.inner, &sizes));
        }
        Self(sizes)
    }

    pub(super) fn of(&self, ty: naga::Handle<Type>) -> Size {
        self.0.get(ty.index()).copied().unwrap_or(Size::ONE)
    }

    /// Size of a type that may have no handle.
    pub(super) fn of_inner(&self, inner: &TypeInner) -> Size {
        Size::of(inner, &self.0)
    }
}

/// Text of a count, which may have saturated.
pub(super) fn shown(count: u32) -> String {
    if count == u32::MAX { "more than 4 billion".to_owned() } else { count.to_string() }
}

fn too_large(what: &str, numbers: u32, span: Span) -> CodeDiagnostic {
    CodeDiagnostic {
        message: format!(
            "{what} has {} numbers; a variable, a constant or a value of a field has at most {MAX_ARRAY_SCALARS}.",
            shown(numbers)
        ),
        label: "too large".to_owned(),
        range: range(span),
        help: Some("Make the array smaller, or compute its elements where they are used.".to_owned()),
    }
}

/// Finds a variable, argument, result or value that is too large.
pub(super) fn too_large_declaration(module: &Module) -> Option<CodeDiagnostic> {
    let sizes = Sizes::new(&module.types);
    let too_many = |ty| Some(sizes.of(ty).numbers).filter(|numbers| *numbers > MAX_ARRAY_SCALARS);
    let named = |name: &Option<String>| name.as_deref().unwrap_or("_").to_owned();
    for (handle, variable) in module.global_variables.iter() {
        if let Some(numbers) = too_many(variable.ty) {
            let what = format!("The variable `{}`", named(&variable.name));
            return Some(too_large(&what, numbers, module.global_variables.get_span(handle)));
        }
    }
    for (handle, function) in module.functions.iter() {
        let (name, span) = (named(&function.name), module.functions.get_span(handle));
        for (handle, variable) in function.local_variables.iter() {
            if let Some(numbers) = too_many(variable.ty) {
                let what = format!("The variable `{}`", named(&variable.name));
                return Some(too_large(&what, numbers, function.local_variables.get_span(handle)));
            }
        }
        for argument in &function.arguments {
            if let Some(numbers) = too_many(argument.ty) {
                return Some(too_large(
                    &format!("The argument `{}` of `{name}`", named(&argument.name)),
                    numbers,
                    span,
                ));
            }
        }
        if let Some(numbers) = function.result.as_ref().and_then(|result| too_many(result.ty)) {
            return Some(too_large(&format!("The result of `{name}`"), numbers, span));
        }
        for (handle, expression) in function.expressions.iter() {
            if let naga::Expression::ZeroValue(ty) | naga::Expression::Compose { ty, .. } = expression
                && let Some(numbers) = too_many(*ty)
            {
                let what = format!("A value in `{name}`");
                return Some(too_large(&what, numbers, function.expressions.get_span(handle)));
            }
        }
    }
    None
}

/// Checks the sizes of constants without parsing the bodies of functions.
///
/// # Errors
/// A constant that is too large, or the parser's error. Code with unmatched braces passes: parsing it as a whole fails before any
/// constant is evaluated.
pub(super) fn check_constants(text: &str) -> Result<(), Result<CodeDiagnostic, Box<ParseError>>> {
    let Some((outline, named)) = outline(text) else { return Ok(()) };
    let module = naga::front::wgsl::parse_str(&outline).map_err(|error| Err(Box::new(error)))?;
    let sizes = Sizes::new(&module.types);
    let mut all = 0;
    for (handle, constant) in module.constants.iter() {
        let numbers = sizes.of(constant.ty).numbers;
        let name = constant.name.as_deref().unwrap_or("_");
        let span = module.constants.get_span(handle);
        if numbers > MAX_ARRAY_SCALARS {
            return Err(Ok(too_large(&format!("The constant `{name}`"), numbers, span)));
        }
        if numbers > 1 {
            all += u64::from(numbers) * named.get(name).copied().unwrap_or_default();
        }
        if all > MAX_NAMED_SCALARS {
            return Err(Ok(CodeDiagnostic {
                message: format!(
                    "The constants that functions of a field name have at most {MAX_NAMED_SCALARS} numbers, each counted as \
                     often as it is named."
                ),
                label: "named too often".to_owned(),
                range: range(span),
                help: Some("Copy a large constant to a variable, and hand that on as a pointer.".to_owned()),
            }));
        }
    }
    Ok(())
}

/// Blanks the bodies of all functions, at the same byte offsets, and counts each name in them; `None` if braces do not match.
fn outline(text: &str) -> Option<(String, HashMap<&str, u64>)> {
    let mut outline = String::with_capacity(text.len());
    let mut named: HashMap<&str, u64> = HashMap::new();
    let (mut depth, mut is_function) = (0_usize, false);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = token_length(rest, first);
        let (token, after) = rest.split_at(length);
        rest = after;
        let is_name = first.is_alphabetic() || first == '_';
        match token {
            "fn" if depth == 0 => is_function = true,
            "struct" | "const" if depth == 0 => is_function = false,
            "}" => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth > 0 && is_function {
            if is_name {
                *named.entry(token).or_default() += 1;
            }
            outline.extend(std::iter::repeat_n(' ', length));
        } else {
            outline.push_str(token);
        }
        if token == "{" {
            depth += 1;
        }
    }
    (depth == 0).then_some((outline, named))
}

/// Length of the token or comment at the start of a text, bytes.
fn token_length(text: &str, first: char) -> usize {
    let until = |end: &dyn Fn(char) -> bool| text.find(end).unwrap_or(text.len());
    if text.starts_with("//") {
        return until(&|c| matches!(c, '\n'..='\r' | '\u{85}' | '\u{2028}' | '\u{2029}'));
    }
    if text.starts_with("/*") {
        let (mut depth, mut at) = (1, 2);
        while depth > 0 && at < text.len() {
            let (step, change) = match &text.as_bytes()[at..] {
                [b'/', b'*', ..] => (2, 1),
                [b'*', b'/', ..] => (2, -1),
                _ => (1, 0),
            };
            at += step;
            depth += change;
        }
        return at;
    }
    if first.is_alphanumeric() || first == '_' {
        return until(&|c| !(c.is_alphanumeric() || c == '_'));
    }
    first.len_utf8()
}
