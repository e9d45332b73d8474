//! Code of a custom shape: parsed, validated, and printed under unique names.

use super::budget::{self, Cost, Costs};
use super::compile::compile;
use super::glsl::{self, Shader};
use super::machine::Program;
use super::messages::{MAX_MESSAGE, innermost, sentence};
use super::size::{self, Sizes, shown};
use super::{CodeDiagnostic, MAX_BYTES, range, wgsl_distance, wgsl_gradient};
use naga::back::wgsl::{Writer, WriterFlags};
use naga::valid::{Capabilities, ValidationError, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Handle, Module, Scalar, ScalarKind, TypeInner, VectorSize, WithSpan};
use std::sync::atomic::{AtomicU64, Ordering};

/// Largest number of functions in a code.
const MAX_FUNCTIONS: usize = 128;
/// Largest number of arguments of a function.
const MAX_ARGUMENTS: usize = 64;
/// Stack for parsing, bytes: naga parses chains of operators by recursion, and a chain may be as long as the code. The system
/// commits only the used part.
#[cfg(not(target_family = "wasm"))]
const STACK: usize = 256 << 20;

/// Validated code of a custom shape, independent of its parameters.
pub struct Code {
    /// Part of all its names in WGSL.
    pub(super) identifier: String,
    pub(super) id: u64,
    pub(super) program: Program,
    wgsl: String,
    entry: String,
    params: usize,
}

impl Code {
    /// Parses and validates WGSL. `identifier` is unique in the scene and consists of ASCII letters, digits and underscores,
    /// with a letter first and no underscore last. `params` are the names of the parameters, which are WGSL identifiers.
    ///
    /// # Errors
    /// The mistakes found.
    pub fn new(identifier: &str, params: &[String], text: &str) -> Result<Self, Vec<CodeDiagnostic>> {
        if text.len() > MAX_BYTES {
            let message = format!("The text of a field has at most {} KiB.", MAX_BYTES >> 10);
            return Err(vec![whole(message, "too long")]);
        }
        on_large_stack(|| Self::read(identifier, params, text))
    }

    /// Parses and validates the distance function of a shader. Its parameters are `Shader::names`.
    ///
    /// # Errors
    /// The mistakes found.
    pub fn of_shader(identifier: &str, shader: &Shader) -> Result<Self, Vec<CodeDiagnostic>> {
        let place = |fault: CodeDiagnostic| CodeDiagnostic {
            range: fault.range.and_then(|range| shader.place(&range)),
            ..fault
        };
        let constants: Vec<String> = shader.names.iter().map(|name| glsl::constant_name(name)).collect();
        on_large_stack(|| {
            let module = glsl::parse(shader)?;
            let source = Source { params: &constants, entry: glsl::ENTRY };
            let invalid = |error: &WithSpan<ValidationError>| shader.validation_fault(error);
            Self::of_module(identifier, module, &source, &invalid)
                .map_err(|faults| faults.into_iter().map(place).collect())
        })
    }

    fn read(identifier: &str, params: &[String], text: &str) -> Result<Self, Vec<CodeDiagnostic>> {
        let declarations: String = params.iter().map(|name| format!("\noverride {name}: f32;")).collect();
        let one = |fault: CodeDiagnostic| vec![fault];
        // Appended, so that byte ranges in the text stay valid.
        let whole_text = format!("{text}\n{declarations}");
        size::check_constants(&whole_text)
            .map_err(|fault| one(fault.unwrap_or_else(|error| parse_fault(&error, text))))?;
        let module = naga::front::wgsl::parse_str(&whole_text).map_err(|error| one(parse_fault(&error, text)))?;
        let faults = forbidden_globals(&module, params, text);
        if !faults.is_empty() {
            return Err(faults);
        }
        let invalid = |error: &WithSpan<ValidationError>| validation_fault(error, text);
        Self::of_module(identifier, module, &Source { params, entry: "distance" }, &invalid)
    }

    /// Checks the limits of a module and prints it again. `invalid` translates the mistakes that naga finds in it.
    fn of_module(
        identifier: &str,
        mut module: Module,
        source: &Source,
        invalid: &dyn Fn(&WithSpan<ValidationError>) -> CodeDiagnostic,
    ) -> Result<Self, Vec<CodeDiagnostic>> {
        let one = |fault: CodeDiagnostic| vec![fault];
        let params = source.params;
        let entry = entry(&module, source.entry).map_err(one)?;
        if let Some(fault) = size::too_large_declaration(&module) {
            return Err(one(fault));
        }
        let info = validate(&module).map_err(|error| one(invalid(&error)))?;
        let costs = Costs::new(&module, &info);
        check_limits(&module, &costs, entry).map_err(one)?;
        let program = compile(&module, &info, &costs, entry, params).map_err(one)?;
        let entry_name = rename(&mut module, identifier, entry);
        budget::instrument(&mut module, &costs, entry, params, format!("user_{identifier}_passes"));
        name_expressions(&mut module);
        let unprintable = |what: String| {
            let message = "This text cannot be made a part of the program for the GPU.";
            vec![CodeDiagnostic {
                help: Some(match what.contains("fall-through") {
                    true => "End each case of a `switch` with `break`: none can run into the next.".to_owned(),
                    false => format!("{what} Write it in a simpler way."),
                }),
                ..whole(message, "in this text")
            }]
        };
        let info = validate(&module).map_err(|error| unprintable(innermost(error.as_inner())))?;
        let mut wgsl = String::new();
        let mut writer = Writer::new(&mut wgsl, WriterFlags::EXPLICIT_TYPES);
        writer.write(&module, &info).map_err(|error| unprintable(error.to_string()))?;
        let code = Self {
            identifier: identifier.to_owned(),
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            program,
            wgsl,
            entry: entry_name,
            params: params.len(),
        };
        // The printed code must be valid, too.
        let printed = code.wgsl_distance() + &code.wgsl_gradient();
        let again = naga::front::wgsl::parse_str(&printed).map_err(|error| unprintable(error.message().to_owned()))?;
        validate(&again).map_err(|error| unprintable(innermost(error.as_inner())))?;
        Ok(code)
    }

    fn name(&self) -> String {
        format!("custom_{}", self.identifier)
    }
    pub(super) fn wgsl_distance(&self) -> String {
        format!("{}\n{}", self.wgsl, wgsl_distance(&self.name(), &self.entry, self.params))
    }
    pub(super) fn wgsl_gradient(&self) -> String {
        wgsl_gradient(&self.name(), self.params)
    }
}

/// What a module has of the language it was written in.
struct Source<'a> {
    /// Names of the overrides that are the parameters, in order.
    params: &'a [String],
    /// Name of the distance function.
    entry: &'a str,
}

/// Runs a reader of code on a thread with a stack of [`STACK`] bytes; a panic is an error.
#[cfg(not(target_family = "wasm"))]
fn on_large_stack<T: Send>(
    read: impl FnOnce() -> Result<T, Vec<CodeDiagnostic>> + Send,
) -> Result<T, Vec<CodeDiagnostic>> {
    std::thread::scope(|scope| {
        let read = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, read);
        match read.map(|thread| thread.join()) {
            Ok(Ok(result)) => result,
            _ => Err(vec![whole("This text could not be read.", "in this text")]),
        }
    })
}

/// Runs a reader of code. WebAssembly has one thread, whose stack the program that embeds this sets at its link.
#[cfg(target_family = "wasm")]
fn on_large_stack<T>(read: impl FnOnce() -> Result<T, Vec<CodeDiagnostic>>) -> Result<T, Vec<CodeDiagnostic>> {
    read()
}

/// Next id of a code; each has machines of its own.
static NEXT: AtomicU64 = AtomicU64::new(0);

fn whole(message: impl Into<String>, label: &str) -> CodeDiagnostic {
    CodeDiagnostic { message: message.into(), label: label.to_owned(), range: None, help: None }
}

fn validate(module: &Module) -> Result<naga::valid::ModuleInfo, Box<WithSpan<ValidationError>>> {
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module).map_err(Box::new)
}

/// Start of the messages of naga for code that it gives up on; the only cause is nesting beyond its limit.
const GIVEN_UP: &str = "internal wgsl front end error";

fn parse_fault(error: &naga::front::wgsl::ParseError, text: &str) -> CodeDiagnostic {
    if error.message().to_lowercase().starts_with(GIVEN_UP) {
        let help = Some("Use at most about 60 levels of brackets: name a part with `let`.".to_owned());
        return CodeDiagnostic { help, ..whole("This text is nested too deeply.", "in this text") };
    }
    let place = error.labels().find_map(|(span, label)| Some((within(range(span)?, text)?, label.to_owned())));
    let notes: Vec<String> = error.notes().map(sentence).collect();
    let (range, label) = match place {
        Some((range, label)) => (Some(range), label),
        None => (None, "in this text".to_owned()),
    };
    let label: String = label.chars().take(MAX_MESSAGE).collect();
    let label = if label.is_empty() { "here".to_owned() } else { label };
    CodeDiagnostic {
        message: sentence(error.message()),
        label,
        range,
        help: Some(notes.join(" ")).filter(|notes| !notes.is_empty()),
    }
}

fn validation_fault(error: &WithSpan<ValidationError>, text: &str) -> CodeDiagnostic {
    // The narrowest place is the most useful.
    let spans = error.spans().filter_map(|(span, _)| within(range(*span)?, text));
    let range = spans.min_by_key(|range| range.len());
    let message = innermost(error.as_inner());
    // naga evaluates some functions of untyped numbers too late.
    let help = message.contains("Abstract").then(|| "Give one of the numbers here a type, as in 1.0f.".to_owned());
    CodeDiagnostic { message, label: "here".to_owned(), range, help }
}

/// The range, if it is in the text and not in the appended declarations.
fn within(range: std::ops::Range<usize>, text: &str) -> Option<std::ops::Range<usize>> {
    (range.end <= text.len()).then_some(range)
}

/// Mistakes in the global declarations.
fn forbidden_globals(module: &Module, params: &[String], text: &str) -> Vec<CodeDiagnostic> {
    let mut faults = Vec::new();
    for (handle, global) in module.global_variables.iter() {
        let message = match global.space {
            AddressSpace::Private => "A field has no variables of its own outside its functions.",
            _ => "A field has no access to memory.",
        };
        let help = "Use `const`, a `param` of the field, or a `var` in a function that is handed on as a pointer.";
        faults.push(CodeDiagnostic {
            message: message.to_owned(),
            label: "not in a field".to_owned(),
            range: range(module.global_variables.get_span(handle)).and_then(|range| within(range, text)),
            help: Some(help.to_owned()),
        });
    }
    for (handle, constant) in module.overrides.iter() {
        let known = constant.name.as_ref().is_some_and(|name| params.contains(name));
        let place = range(module.overrides.get_span(handle)).and_then(|range| within(range, text));
        if !known || place.is_some() {
            faults.push(CodeDiagnostic {
                message: "A field has no overrides.".to_owned(),
                label: "not in a field".to_owned(),
                range: place,
                help: Some("Numbers that can be set from outside are the field's `param`s.".to_owned()),
            });
        }
    }
    for point in &module.entry_points {
        let place = text.find(&format!("fn {}", point.name)).map(|at| at..at + 3 + point.name.len());
        faults.push(CodeDiagnostic {
            message: "A field has no entry points.".to_owned(),
            label: "not in a field".to_owned(),
            range: place,
            help: Some("Leave out @compute, @vertex and @fragment.".to_owned()),
        });
    }
    faults
}

/// Finds the function of this name, from a point to a number.
fn entry(module: &Module, name: &str) -> Result<Handle<naga::Function>, CodeDiagnostic> {
    let help = "It looks like this: fn distance(p: vec3f) -> f32 { return length(p) - 1.0; }";
    let found = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some(name));
    let Some((handle, function)) = found else {
        let message = "This text has no function `distance`.";
        return Err(CodeDiagnostic {
            help: Some(help.to_owned()),
            ..whole(message, "expected `fn distance(p: vec3f) -> f32`")
        });
    };
    let inner = |ty: naga::Handle<naga::Type>| &module.types[ty].inner;
    let point = TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::F32 };
    let takes = matches!(&function.arguments[..], [argument] if *inner(argument.ty) == point);
    let gives = function.result.as_ref().is_some_and(|result| {
        matches!(inner(result.ty), TypeInner::Scalar(Scalar { kind: ScalarKind::Float, width: 4 }))
    });
    if takes && gives {
        return Ok(handle);
    }
    Err(CodeDiagnostic {
        message: "`distance` takes a point and gives a number.".to_owned(),
        label: "expected `fn distance(p: vec3f) -> f32`".to_owned(),
        range: range(module.functions.get_span(handle)),
        help: Some(help.to_owned()),
    })
}

/// Checks the numbers of functions, arguments, operations and array elements.
fn check_limits(module: &Module, costs: &Costs, entry: Handle<naga::Function>) -> Result<(), CodeDiagnostic> {
    if module.functions.len() > MAX_FUNCTIONS {
        return Err(whole(format!("A field has at most {MAX_FUNCTIONS} functions."), "too many"));
    }
    let refused = |function: Handle<naga::Function>, message: String, label: &str, help: &str| CodeDiagnostic {
        message,
        label: label.to_owned(),
        range: range(module.functions.get_span(function)),
        help: Some(help.to_owned()),
    };
    for (handle, function) in module.functions.iter() {
        if function.arguments.len() > MAX_ARGUMENTS {
            let message = format!("A function of a field has at most {MAX_ARGUMENTS} arguments.");
            return Err(refused(handle, message, "too many", "Put arguments that belong together into a structure."));
        }
    }
    // Drivers compile functions that are not called, too.
    let functions = || module.functions.iter().map(|(handle, _)| handle);
    let with_most = |of: &dyn Fn(Cost) -> u32| functions().max_by_key(|handle| of(costs.of(*handle))).unwrap_or(entry);
    let most = with_most(&|cost| cost.numbers);
    let numbers = costs.of(most).numbers.saturating_add(costs.globals().numbers);
    if numbers > budget::MAX_ARRAY_SCALARS {
        let message = format!(
            "The arrays of this function come to {} numbers with every call written out; at most {} are allowed.",
            shown(numbers),
            budget::MAX_ARRAY_SCALARS
        );
        let help = "Make arrays smaller, or keep one in a variable and hand it on as a pointer: an array that is an \
                    argument, a result or a value is a copy.";
        return Err(refused(most, message, "too much memory", help));
    }
    let most = with_most(&|cost| cost.compiled);
    let operations = costs.of(most).compiled;
    if operations > budget::MAX_OPERATIONS {
        let message = format!(
            "This function comes to {} operations with every call written out; at most {} are allowed.",
            shown(operations),
            budget::MAX_OPERATIONS
        );
        let sizes = Sizes::new(&module.types);
        let help = if module.types.iter().any(|(ty, _)| sizes.of(ty).has_array) {
            "A copy of an array counts as 16 operations for each element, an element found by a computed index as 32: make \
             arrays smaller, and hand them on as pointers. Put what is done several times into a loop: its passes count against a budget of their own."
        } else {
            "Put what is done several times into one loop: its passes count against a budget of their own. A loop counts as 256 \
             operations, and a case of a switch as 12."
        };
        return Err(refused(most, message, "too much to compile", help));
    }
    Ok(())
}

/// Renames all declarations to names that are unique in the kernel. Returns the entry's name.
fn rename(module: &mut Module, identifier: &str, entry: Handle<naga::Function>) -> String {
    let mut count = 0;
    let mut fresh = |name: &str| {
        count += 1;
        // The identifier is followed by a digit, and names start with none: two shapes never make the same name. naga's
        // writer would shorten several `_` in a row.
        let parts: Vec<&str> = name.split('_').filter(|part| !part.is_empty()).collect();
        format!("user_{identifier}_{count}_{}_v", parts.join("_"))
    };
    let predeclared: Vec<_> = module.special_types.predeclared_types.values().copied().collect();
    let structs: Vec<_> = module
        .types
        .iter()
        .filter(|(handle, ty)| matches!(ty.inner, TypeInner::Struct { .. }) && !predeclared.contains(handle))
        .map(|(handle, ty)| (handle, ty.clone()))
        .collect();
    for (handle, mut ty) in structs {
        ty.name = Some(fresh(ty.name.as_deref().unwrap_or("s")));
        module.types.replace(handle, ty);
    }
    for (_, constant) in module.constants.iter_mut() {
        constant.name = constant.name.as_ref().map(|name| fresh(name));
    }
    for (_, global) in module.global_variables.iter_mut() {
        global.name = global.name.as_ref().map(|name| fresh(name));
    }
    let mut entry_name = String::new();
    for (handle, function) in module.functions.iter_mut() {
        let name = fresh(function.name.as_deref().unwrap_or("f"));
        if handle == entry {
            entry_name.clone_from(&name);
        }
        function.name = Some(name);
    }
    entry_name
}

/// Names the result of every operation, so that printed expressions are not nested too deep for parsers.
fn name_expressions(module: &mut Module) {
    for (_, function) in module.functions.iter_mut() {
        let operations: Vec<_> = function
            .expressions
            .iter()
            .filter(|(_, expression)| {
                matches!(
                    expression,
                    Expression::Binary { .. }
                        | Expression::Unary { .. }
                        | Expression::Select { .. }
                        | Expression::Math { .. }
                        | Expression::As { .. }
                )
            })
            .map(|(handle, _)| handle)
            .collect();
        for handle in operations {
            function.named_expressions.entry(handle).or_insert_with(|| "t".to_owned());
        }
    }
}
