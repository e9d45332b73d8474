//! GLSL where something else is expected.

/// True for code with declarations of GLSL and no function of WGSL.
pub(crate) fn is_glsl(code: &str) -> bool {
    let is_function = |line: &str| line.trim_start().starts_with("fn ");
    code.lines().any(declares) && !code.lines().any(is_function)
}

/// Bytes of the first line of a text that is a shader in GLSL instead of a scene; `None` for any other text.
pub(crate) fn shader_line(text: &str) -> Option<std::ops::Range<usize>> {
    let mut rest = text;
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
        let end = match () {
            () if rest.starts_with("/*") => rest.find("*/").map(|at| at + 2),
            () if rest.starts_with("//") || rest.starts_with('#') => rest.find('\n'),
            () => break,
        };
        rest = &rest[end?..];
    }
    let line = rest.lines().next().filter(|line| declares(line))?.trim_end();
    let start = text.len() - rest.len();
    Some(start..start + line.len())
}

/// True for a line that declares a function or a variable in GLSL.
fn declares(line: &str) -> bool {
    const TYPES: [&str; 9] = ["float", "int", "void", "vec2", "vec3", "vec4", "mat2", "mat3", "mat4"];
    let mut words = line.split_whitespace().skip_while(|word| matches!(*word, "const" | "uniform" | "highp"));
    let is_type = words.next().is_some_and(|word| TYPES.contains(&word));
    is_type && words.next().is_some_and(|word| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaders_are_told_from_scenes() {
        let shader = "// A torus.\n#define R 1.0\n/* float x */\n\nfloat map(vec3 p) {\n  return length(p) - R;\n}\n";
        assert_eq!(shader_line(shader).map(|range| &shader[range]), Some("float map(vec3 p) {"));
        for scene in [
            "",
            "// a",
            "/* a",
            "# a",
            "pathmarch 1\nfloat map(vec3 p) {}",
            "camera { position 0 0 1 }",
            "object \"float x\" {}",
            "float",
        ] {
            assert_eq!(shader_line(scene), None, "{scene}");
        }
    }
}
