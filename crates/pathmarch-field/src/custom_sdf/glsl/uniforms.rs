//! Uniforms of a shader, which become parameters of the field.

use super::control::lists;
use super::fragmentarium::Preset;
use super::items::{Item, ItemKind};
use crate::range::Range;

/// Parameter that a uniform becomes.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaderParam {
    /// Name: that of the uniform, followed by `_x`, `_y`, `_z` or `_w` for a vector.
    pub name: String,
    /// Value at the start.
    pub default: f32,
    /// Range of its slider.
    pub range: Range,
    /// Comment in the line above the uniform.
    pub doc: Option<String>,
    /// Byte range of the uniform's name in the code; `None` if the code has none.
    pub place: Option<std::ops::Range<usize>>,
}

/// Type of a uniform: the number of its components, and what makes one of a parameter.
pub(super) struct UniformType {
    pub(super) components: usize,
    pub(super) convert: fn(&str) -> String,
}

/// Type of uniforms that fields can have.
pub(super) fn uniform_type(ty: &str) -> Option<UniformType> {
    let float = |components| UniformType { components, convert: str::to_owned };
    Some(match ty {
        "float" => float(1),
        "vec2" => float(2),
        "vec3" => float(3),
        "vec4" => float(4),
        "int" => UniformType { components: 1, convert: |value| format!("int(round({value}))") },
        "uint" => UniformType { components: 1, convert: |value| format!("uint(round(max({value}, 0.0)))") },
        "bool" => UniformType { components: 1, convert: |value| format!("({value} > 0.5)") },
        _ => return None,
    })
}

/// Names of the parameters of a uniform.
pub(super) fn param_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_owned()],
        _ => ["x", "y", "z", "w"][..components].iter().map(|axis| format!("{name}_{axis}")).collect(),
    }
}

/// Parameters of a uniform, with the values of the preset; `None` if its type is not supported.
pub(super) fn params(item: &Item, preset: &Preset, code: &str) -> Option<Vec<ShaderParam>> {
    let ItemKind::Uniform { ty, value, control } = &item.kind else { return None };
    let components = uniform_type(ty)?.components;
    let control = control.as_ref().and_then(|control| control.as_ref().ok());
    let at = |list: &[f32], k: usize| list.get(k).or(list.last()).copied();
    let own: Vec<f32> = lists(value).into_iter().flatten().collect();
    let names = param_names(item.name, components).into_iter().enumerate();
    let param = |(k, name): (usize, String)| {
        let default = preset.get(item.name).and_then(|values| at(values, k));
        let default = default.or(control.and_then(|control| at(&control.default, k))).or(at(&own, k));
        let default = default.unwrap_or_default();
        let range = control.and_then(|control| Some((at(&control.least, k)?, at(&control.greatest, k)?)));
        let range = match (range, *ty) {
            (Some((least, greatest)), _) => (least.min(greatest), greatest.max(least)),
            (None, "bool") => (0.0, 1.0),
            (None, "uint") => (0.0, f32::MAX),
            (None, _) => (f32::MIN, f32::MAX),
        };
        // A preset may lie outside the slider.
        let range = Range { min: range.0.min(default), max: range.1.max(default), ..Range::ANY };
        ShaderParam { name, default, range, doc: comment_above(code, item.at.start as usize), place: item.at.range() }
    };
    Some(names.map(param).collect())
}

/// Longest comment that becomes the help of a slider, characters.
const MAX_DOC: usize = 200;

/// The comment in the line above a place, which is the help of a slider in Fragmentarium.
fn comment_above(code: &str, at: usize) -> Option<String> {
    let above = code.get(..at)?.rsplit('\n').nth(1)?.trim();
    let comment = above.strip_prefix("//")?.trim_matches(['/', ' ', '-', '=', '*']);
    let is_text = comment.contains(|c: char| c.is_alphabetic()) && !comment.contains([';', '{', '}', '[']);
    is_text.then(|| comment.chars().filter(|c| !c.is_control()).take(MAX_DOC).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::custom_sdf::glsl::items::items;
    use crate::custom_sdf::glsl::lexer::tokens;

    fn read(code: &str) -> Vec<ShaderParam> {
        let tokens = tokens(code);
        let items = items(&tokens, false).unwrap_or_else(|fault| panic!("{fault:?}"));
        items.iter().flat_map(|item| params(item, &Preset::new(), code).unwrap_or_default()).collect()
    }

    #[test]
    fn sliders_give_ranges() {
        let all =
            read("// Edge of the cube.\nuniform float Scale; slider[-1,2.5,4] Locked\nuniform int N;slider[0,3,9]");
        assert_eq!((all[0].default, all[0].range.min, all[0].range.max), (2.5, -1.0, 4.0));
        assert_eq!(all[0].doc.as_deref(), Some("Edge of the cube."));
        assert_eq!((all[1].name.as_str(), all[1].default), ("N", 3.0));
    }

    #[test]
    fn vectors_are_several_parameters() {
        let all = read("uniform vec3 Offset; slider[(-5,-5,-5),(1,2,3),(5,5,5)]\nuniform vec2 a, b = vec2(4, -.5);");
        let pairs: Vec<(&str, f32)> = all.iter().map(|param| (param.name.as_str(), param.default)).collect();
        let expected = [("Offset_x", 1.0), ("Offset_y", 2.0), ("Offset_z", 3.0), ("a_x", 0.0), ("a_y", 0.0)];
        assert_eq!(pairs[..5], expected);
        assert_eq!(pairs[5..], [("b_x", 4.0), ("b_y", -0.5)]);
    }

    #[test]
    fn a_comment_or_a_checkbox_describes_a_uniform() {
        let all = read("uniform float k; // slider[0,0.25,1]\nuniform bool On; checkbox[true]");
        assert_eq!((all[0].default, all[0].range.max), (0.25, 1.0));
        assert_eq!((all[1].default, all[1].range.max), (1.0, 1.0));
    }
}
