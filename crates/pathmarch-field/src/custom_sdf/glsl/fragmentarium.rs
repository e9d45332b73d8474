//! Lines of Fragmentarium that are no GLSL: `#include`, `#group`, `#info`, `#camera`, and presets.
//!
//! Format: the files of Fragmentarium by M. H. Christensen. A preset is a list of `name = values` between `#preset Name` and
//! `#endpreset`; the one named `Default`, or else the first, has the values that a file opens with.

use std::collections::HashMap;
use std::ops::Range;

/// Directives of single lines.
const LINES: [&str; 12] = [
    "include",
    "group",
    "info",
    "camera",
    "buffer",
    "donotrun",
    "replace",
    "synopsis",
    "texparameter",
    "iterations",
    "subframemax",
    "title",
];
/// Lines around code that runs once for a picture: its `init` sets variables for the distance function.
const AROUND: [&str; 2] = ["vertex", "endvertex"];
/// Directive that starts a list of values, which ends with `#endpreset`.
const PRESET: &str = "preset";

/// Values that a file opens with, by name.
pub(super) type Preset = HashMap<String, Vec<f32>>;

/// Code without the lines of Fragmentarium, which are blanked, so that places stay valid.
pub(super) struct Fragment {
    pub(super) code: String,
    pub(super) preset: Preset,
    /// Byte range of the code that runs once for a picture, between `#vertex` and `#endvertex`.
    pub(super) vertex: Range<usize>,
}

impl Fragment {
    pub(super) fn new(text: &str) -> Self {
        let mut code = String::with_capacity(text.len());
        let mut presets: Vec<(String, Preset)> = Vec::new();
        let mut in_preset = false;
        let mut vertex = 0..0;
        for line in text.split_inclusive('\n') {
            let (word, rest) = directive(line);
            let is_end = word == "endpreset";
            match &*word {
                "vertex" => vertex = code.len()..text.len(),
                "endvertex" => vertex.end = code.len(),
                _ => {}
            }
            if in_preset
                && !is_end
                && let (Some((_, preset)), Some((name, values))) = (presets.last_mut(), line.split_once('='))
            {
                preset.insert(name.trim().to_owned(), numbers(values));
            }
            let starts = !in_preset && word == PRESET;
            if in_preset || starts || is_skipped(&word) {
                blank(line, &mut code);
            } else {
                code.push_str(line);
            }
            in_preset = starts || (in_preset && !is_end);
            if starts {
                presets.push((rest.trim().to_lowercase(), Preset::new()));
            }
        }
        presets.retain(|(_, preset)| !preset.is_empty());
        let opened = presets.iter().position(|(name, _)| name == "default").unwrap_or(0);
        let preset = if presets.is_empty() { Preset::new() } else { presets.swap_remove(opened).1 };
        Self { code, preset, vertex }
    }
}

/// The word of a directive in lower case, and what follows it; empty for other lines.
fn directive(line: &str) -> (String, &str) {
    let Some(rest) = line.trim_start().strip_prefix('#') else { return (String::new(), "") };
    let rest = rest.trim_start();
    let (word, rest) = rest.split_at(rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len()));
    (word.to_lowercase(), rest)
}

/// True for directives without a meaning for a distance. Their text may follow without a blank.
fn is_skipped(word: &str) -> bool {
    LINES.iter().any(|line| word.starts_with(line)) || AROUND.contains(&word)
}

fn blank(line: &str, code: &mut String) {
    code.extend(line.bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }));
}

/// Numbers of a list, as in `1,2.5,3`; `true` is 1.
fn numbers(list: &str) -> Vec<f32> {
    let words = list.split([',', ' ', '\t']).map(str::trim).filter(|word| !word.is_empty());
    let value = |word: &str| match word {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => word.parse().ok().filter(|value: &f32| value.is_finite()),
    };
    words.map_while(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_read_and_lines_blanked() {
        let text = "#include \"DE-Raytracer.frag\"\n#group A b\n#infoSome text's end\nfloat x;\n#preset Other\nA = 1\n#endpreset\n\
                    #preset Default\nEye = 1,-2.5,3\nOn = true\n#endpreset\nfloat y;";
        let fragment = Fragment::new(text);
        assert_eq!(fragment.code.len(), text.len());
        assert_eq!(fragment.code.split_whitespace().collect::<Vec<_>>().join(" "), "float x; float y;");
        assert_eq!(fragment.preset["Eye"], [1.0, -2.5, 3.0]);
        assert_eq!(fragment.preset["On"], [1.0]);
        assert!(!fragment.preset.contains_key("A"));
    }
}
