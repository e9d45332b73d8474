//! Constants and structures that Rust and WGSL share. Rust declares them and prints them for the kernels.

use pathmarch_scene::materials::BsdfParameters;
use std::fmt::Write;

/// Type of a field of a shared structure.
pub(crate) trait FieldType {
    /// Name of the type in WGSL.
    const WGSL: &'static str;
}

impl FieldType for f32 {
    const WGSL: &'static str = "f32";
}

impl FieldType for u32 {
    const WGSL: &'static str = "u32";
}

impl FieldType for [u32; 2] {
    const WGSL: &'static str = "vec2u";
}

impl FieldType for [u32; 4] {
    const WGSL: &'static str = "vec4u";
}

impl FieldType for [f32; 3] {
    const WGSL: &'static str = "vec3f";
}

impl FieldType for BsdfParameters {
    const WGSL: &'static str = "array<vec4f, 8>";
}

/// Value of a shared constant.
pub(crate) trait ConstantValue {
    /// Expression in WGSL.
    fn wgsl(&self) -> String;
}

impl ConstantValue for f32 {
    fn wgsl(&self) -> String {
        format!("{self:?}")
    }
}

impl ConstantValue for u32 {
    fn wgsl(&self) -> String {
        format!("{self}u")
    }
}

impl ConstantValue for i32 {
    fn wgsl(&self) -> String {
        format!("{self}i")
    }
}

impl ConstantValue for usize {
    fn wgsl(&self) -> String {
        format!("{self}u")
    }
}

/// Appends a constant to a shader, with the lines of its documentation.
pub(crate) fn write_constant(code: &mut String, doc: &[&str], name: &str, value: &dyn ConstantValue) {
    for line in doc {
        writeln!(code, "///{line}").expect("writing to a string");
    }
    writeln!(code, "const {name} = {};", value.wgsl()).expect("writing to a string");
}

/// Field of a shared structure.
pub(crate) struct Field {
    pub(crate) name: &'static str,
    /// Lines of the documentation.
    pub(crate) doc: &'static [&'static str],
    /// Type in WGSL.
    pub(crate) kind: &'static str,
    /// Offset in Rust, bytes.
    pub(crate) offset: usize,
}

/// Structure that Rust and WGSL share.
pub(crate) trait SharedStruct {
    /// Name in WGSL.
    const NAME: &'static str;

    /// Fields in order. WGSL leaves out those called `padding`.
    fn fields() -> Vec<Field>;
}

/// Declaration of a shared structure in WGSL.
pub(crate) fn declaration<S: SharedStruct>() -> String {
    let mut code = format!("struct {} {{\n", S::NAME);
    for field in S::fields().into_iter().filter(|field| field.name != "padding") {
        for line in field.doc {
            writeln!(code, "    ///{line}").expect("writing to a string");
        }
        writeln!(code, "    {}: {},", field.name, field.kind).expect("writing to a string");
    }
    code + "}\n"
}

/// Value of a shared structure as an expression in WGSL; `None` if a number is not finite.
pub(crate) fn value<S: SharedStruct + bytemuck::Pod>(record: &S) -> Option<String> {
    let arguments: Vec<String> = field_values(record)?.iter().map(FieldValue::wgsl).collect();
    Some(format!("{}({})", S::NAME, arguments.join(", ")))
}

/// Value of a field of a shared structure.
pub(crate) struct FieldValue {
    /// Type in WGSL.
    pub(crate) kind: &'static str,
    /// Expressions of the vectors of an array, or the components of a scalar or vector.
    pub(crate) parts: Vec<String>,
}

impl FieldValue {
    /// Expression in WGSL.
    pub(crate) fn wgsl(&self) -> String {
        format!("{}({})", self.kind, self.parts.join(", "))
    }
}

/// Values of the fields of a shared structure; `None` if a number is not finite.
pub(crate) fn field_values<S: SharedStruct + bytemuck::Pod>(record: &S) -> Option<Vec<FieldValue>> {
    let words: &[u32] = bytemuck::cast_slice(bytemuck::bytes_of(record));
    let value = |Field { kind, offset, .. }: Field| {
        let float = |k: usize| {
            let number = f32::from_bits(words[offset / 4 + k]);
            number.is_finite().then(|| number.wgsl())
        };
        let integer = |k: usize| Some(words[offset / 4 + k].wgsl());
        let vector = |k: usize| {
            let numbers: Option<Vec<_>> = (4 * k..4 * k + 4).map(float).collect();
            Some(format!("vec4f({})", numbers?.join(", ")))
        };
        let parts: Option<Vec<String>> = match kind {
            "f32" => (0..1).map(float).collect(),
            "u32" => (0..1).map(integer).collect(),
            "vec2u" => (0..2).map(integer).collect(),
            "vec4u" => (0..4).map(integer).collect(),
            "vec3f" => (0..3).map(float).collect(),
            <BsdfParameters as FieldType>::WGSL => (0..size_of::<BsdfParameters>() / 16).map(vector).collect(),
            kind => unreachable!("{kind} is not written as a value"),
        };
        Some(FieldValue { kind, parts: parts? })
    };
    S::fields().into_iter().filter(|field| field.name != "padding").map(value).collect()
}

/// Declares constants, and a function `shared_wgsl()` that prints them in WGSL.
macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])* $vis:vis const $name:ident: $kind:ty = $value:expr;)+) => {
        $($(#[doc = $doc])* $vis const $name: $kind = $value;)+

        /// Constants of this module in WGSL.
        pub(crate) fn shared_wgsl() -> String {
            let mut code = String::new();
            $($crate::wgsl::write_constant(&mut code, &[$($doc),*], stringify!($name), &$name);)+
            code
        }
    };
}

/// Declares a structure in the memory layout of WGSL.
macro_rules! shared_struct {
    ($(#[doc = $doc:literal])* $vis:vis struct $name:ident as $wgsl:ident {
        $($(#[doc = $field_doc:literal])* $field_vis:vis $field:ident: $kind:ty,)+
    }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(C)]
        $vis struct $name {
            $($(#[doc = $field_doc])* $field_vis $field: $kind,)+
        }

        impl $crate::wgsl::SharedStruct for $name {
            const NAME: &'static str = stringify!($wgsl);

            fn fields() -> Vec<$crate::wgsl::Field> {
                vec![$($crate::wgsl::Field {
                    name: stringify!($field),
                    doc: &[$($field_doc),*],
                    kind: <$kind as $crate::wgsl::FieldType>::WGSL,
                    offset: std::mem::offset_of!(Self, $field),
                }),+]
            }
        }
    };
}

pub(crate) use shared_constants;
pub(crate) use shared_struct;

/// Compares the layout of a structure in Rust with naga's layout of its declaration.
#[cfg(test)]
pub(crate) fn check_layout<S: SharedStruct>() {
    let code = declaration::<S>() + &format!("@group(0) @binding(0) var<storage> all: array<{}>;\n", S::NAME);
    let module = naga::front::wgsl::parse_str(&code).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
    let members = module.types.iter().find_map(|(_, kind)| match &kind.inner {
        naga::TypeInner::Struct { members, span } if kind.name.as_deref() == Some(S::NAME) => Some((members, *span)),
        _ => None,
    });
    let (members, span) = members.expect("the structure is declared");
    let found: Vec<_> =
        members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize)).collect();
    let (padding, fields): (Vec<_>, Vec<_>) = S::fields().into_iter().partition(|field| field.name == "padding");
    let expected: Vec<_> = fields.iter().map(|field| (field.name.to_owned(), field.offset)).collect();
    assert_eq!(found, expected, "{}", S::NAME);
    // Padding at the end may be part of the structure in WGSL, or lie behind it.
    let padding_bytes = size_of::<S>() - padding.first().map_or(size_of::<S>(), |field| field.offset);
    let sizes = [size_of::<S>(), size_of::<S>() - padding_bytes];
    assert!(sizes.contains(&(span as usize)), "{}: {span} bytes, {} in Rust", S::NAME, sizes[0]);
}

#[cfg(test)]
mod tests {
    use super::*;

    shared_constants! {
        /// A number.
        const NUMBER: f32 = 0.5;
        const COUNT: u32 = 3;
    }

    shared_struct! {
        /// A pair.
        struct Pair as WgslPair {
            /// First of them.
            first: [f32; 3],
            second: u32,
            padding: u32,
        }
    }

    #[test]
    fn declarations_are_printed() {
        assert_eq!(shared_wgsl(), "/// A number.\nconst NUMBER = 0.5;\nconst COUNT = 3u;\n");
        assert_eq!(
            declaration::<Pair>(),
            "struct WgslPair {\n    /// First of them.\n    first: vec3f,\n    second: u32,\n}\n"
        );
        assert_eq!(Pair::fields()[1].offset, 12);
    }

    #[test]
    fn values_are_printed() {
        let pair = Pair { first: [0.5, -1e-8, 3.0], second: 7, padding: 0 };
        assert_eq!(value(&pair).as_deref(), Some("WgslPair(vec3f(0.5, -1e-8, 3.0), u32(7u))"));
        assert_eq!(value(&Pair { first: [f32::INFINITY; 3], ..pair }), None);
    }
}
