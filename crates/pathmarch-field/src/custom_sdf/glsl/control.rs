//! Sliders, checkboxes and colours that a shader gives its uniforms.

use super::lexer::{Kind, Token, fault};
use crate::custom_sdf::CodeDiagnostic;

/// Slider, checkbox or colour of a uniform, as Fragmentarium writes them: `slider[least, default, greatest]`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Control {
    pub(super) least: Vec<f32>,
    pub(super) default: Vec<f32>,
    pub(super) greatest: Vec<f32>,
}

/// Reads the control behind a uniform: its word, and the square brackets.
pub(super) fn control(word: &Token, group: &[Token]) -> Result<Control, CodeDiagnostic> {
    let inner = group.get(1..group.len().saturating_sub(1)).unwrap_or_default();
    let groups = lists(inner);
    let list = |index: usize| groups.get(index).cloned().unwrap_or_default();
    let flat: Vec<f32> = groups.iter().flatten().copied().collect();
    match word.text {
        "slider" | "floatslider" if groups.len() == 3 => {
            Ok(Control { least: list(0), default: list(1), greatest: list(2) })
        }
        "checkbox" => Ok(Control { least: vec![0.0], default: flat, greatest: vec![1.0] }),
        // A slider of the opacity may come before the colour.
        "color" | "color3" => {
            let default = flat[flat.len().saturating_sub(3)..].to_vec();
            Ok(Control { least: vec![0.0], default, greatest: vec![1.0] })
        }
        _ => {
            let help = "Write slider[least, default, greatest], checkbox[true] or color[r, g, b].";
            Err(fault(word.at, format!("This is no control of a uniform: `{}`.", word.text), "not known", help))
        }
    }
}

/// Numbers in brackets, separated by commas; round brackets group them.
pub(super) fn lists(tokens: &[Token]) -> Vec<Vec<f32>> {
    let (mut all, mut depth, mut sign) = (vec![Vec::new()], 0, 1.0);
    for token in tokens {
        match token.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            "," if depth == 0 => all.push(Vec::new()),
            "-" => sign = -1.0,
            _ => {
                let value = match token.text {
                    "true" => Some(1.0),
                    "false" => Some(0.0),
                    text if token.kind == Kind::Number => text.trim_end_matches(['f', 'F']).parse::<f32>().ok(),
                    _ => None,
                };
                let value = value.filter(|value| value.is_finite()).map(|value| sign * value);
                all.last_mut().into_iter().for_each(|last| last.extend(value));
                sign = 1.0;
            }
        }
    }
    all
}
