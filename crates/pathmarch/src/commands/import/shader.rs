//! Scenes of shaders in GLSL: their distance function as a field, with bounds and a Lipschitz constant that are measured.
//!
//! Bounds are the smallest ball outside of which the distance grows with that from the ball, as far as samples show. The Lipschitz
//! constant is that of the [check](check_lipschitz) of fields. Cameras are those of presets of Fragmentarium, else one that
//! frames the bounds.

use super::Import;
use pathmarch_cli::{Failure, note, print_report};
use pathmarch_render::pathmarch_field::custom_sdf::glsl::Shader;
use pathmarch_render::pathmarch_field::graph::Kind;
use pathmarch_render::pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_render::pathmarch_field::number::Vec3;
use pathmarch_render::pathmarch_field::{Field, Node, Placement};
use pathmarch_render::pathmarch_scene::{Mistake, Scene, SceneError, SourceText, read_foreign_text};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Radii of bounds that are tried, metres.
const RADII: [f32; 12] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
/// Distances from the origin at which bounds are tested, in radii.
const SHELLS: [f32; 9] = [1.0, 1.05, 1.15, 1.3, 1.7, 2.5, 4.0, 8.0, 16.0];
/// Directions from the origin in which bounds are tested.
const DIRECTIONS: u32 = 2000;
/// Least growth of the distance outside of bounds, metres a metre.
const LEAST_GROWTH: f32 = 0.03;
/// Margin of measured numbers.
const MARGIN: f32 = 1.05;
/// Largest constant: rays end at a distance that is divided by it, so that a large one thickens what is thin.
const MAX_LIPSCHITZ: f32 = 2.0;
/// Points of the check of slopes.
const SAMPLE_POINTS: u32 = 20_000;

/// Scene of a shader. `entry` is the name of its distance function, `None` for a usual name.
pub(super) fn import(file: &Path, entry: Option<&str>) -> Result<Import, Failure> {
    let (code, is_latin1) = read_foreign_text(file)?;
    if is_latin1 {
        note!("{} is not UTF-8: read as Latin-1", file.display());
    }
    let code = code.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n");
    let shader = ShaderFile { file: file.display().to_string(), name: field_name(file), code, entry };
    let preset = Shader::read(&shader.code, entry, &[]).map(|shader| shader.preset).unwrap_or_default();
    let mut draft = Draft { lipschitz: 1.0, edge: None, camera: String::new() };
    let scene = shader.scene(&draft)?;
    let unbounded = shape_alone(&scene);
    let radius = bounds(&unbounded);
    draft.edge = radius.map(|radius| 2.0 * radius * MARGIN);
    draft.lipschitz = lipschitz(&shape_alone(&shader.scene(&draft)?));
    draft.camera = camera(&preset, radius, &unbounded);
    let params = scene.field.leaves().first().map_or(0, |leaf| leaf.shape.params().len());
    let bounds = radius.map_or("no bounds".to_owned(), |_| format!("bounds {}", rounded(draft.edge.unwrap_or(0.0))));
    let summary = format!("{params} parameters, lipschitz {}, {bounds}", rounded(draft.lipschitz));
    for warning in shader.scene(&draft)?.warnings {
        print_report(&shader.in_file(warning));
    }
    Ok(Import { text: shader.text(&draft), summary })
}

/// What is measured and written.
struct Draft {
    lipschitz: f32,
    /// Edge of the bounds, metres; `None` for no bounds.
    edge: Option<f32>,
    /// Nodes of the camera.
    camera: String,
}

/// Shader to import.
struct ShaderFile<'a> {
    file: String,
    /// Name of the field and of its object.
    name: String,
    code: String,
    entry: Option<&'a str>,
}

impl ShaderFile<'_> {
    /// Text of the scene.
    fn text(&self, draft: &Draft) -> String {
        let Self { file, name, code, entry } = self;
        let marks = "#".repeat(1 + longest_run(code, '#'));
        let file = file.replace(['\n', '\r'], " ");
        let entry = entry.map_or(String::new(), |name| format!(" entry={name:?}"));
        let bounds = draft.edge.map_or("\"none\"".to_owned(), rounded);
        let (lipschitz, camera) = (rounded(draft.lipschitz), &draft.camera);
        let camera = if camera.is_empty() { "camera \"main\" { position 0 0 5; target 0 0 0 }" } else { camera };
        let code = code.trim_end();
        format!(
            "pathmarch 1\n\n// Imported from {file}. `lipschitz` and `bounds` were measured: see `pathmarch check --field`.\n\n{camera}\n\
             render {{ size 1280 720; samples 256; bounces 4 }}\n\
             sky \"gradient\" {{ zenith 0.25 0.35 0.6; horizon 0.6 0.6 0.65; ground 0.25 0.22 0.2 }}\n\
             sun {{ direction 0.6 0.9 0.5; irradiance 3 2.8 2.4; angle 2 }}\n\n\
             material \"surface\" {{ principled 0.7 0.58 0.46; roughness 0.5 }}\n\n\
             field \"{name}\" {{\n    lipschitz {lipschitz}\n    bounds {bounds}\n    glsl {marks}\"\"\"\n{code}\n\"\"\"{marks}{entry}\n}}\n\n\
             object \"{name}\" material=\"surface\" {{ {name} }}\n"
        )
    }

    /// Scene of the text. Mistakes are those of the shader.
    fn scene(&self, draft: &Draft) -> Result<Scene, Failure> {
        let text = self.text(draft);
        Scene::parse(&self.file, &text).map_err(|error| {
            Failure::Scene(Box::new(match error {
                SceneError::Mistakes { name, total, mistakes } => {
                    let mistakes = mistakes.into_iter().map(|mistake| self.in_file(mistake)).collect();
                    SceneError::Mistakes { name, total, mistakes }
                }
                other => other,
            }))
        })
    }

    /// A mistake at its place in the shader, if it is in its code.
    fn in_file(&self, mistake: Mistake) -> Mistake {
        let text = mistake.source_code.inner();
        let code = self.code.trim_end();
        let Some(start) =
            text.find(code).filter(|start| (*start..=start + code.len()).contains(&mistake.span.offset()))
        else {
            return mistake;
        };
        let moved = |offset: usize, length: usize| (offset.saturating_sub(start), length);
        let also = mistake.also.clone().map(|(span, label)| (moved(span.offset(), span.len()).into(), label));
        let source_code = Arc::new(SourceText::new(&self.file, self.code.clone()));
        Mistake { span: moved(mistake.span.offset(), mistake.span.len()).into(), also, source_code, ..mistake }
    }
}

/// Longest part of a file's name in the name of its field, characters.
const MAX_STEM: usize = 30;

/// Name of a field for a file: letters, digits and hyphens, no word of the language.
fn field_name(file: &Path) -> String {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default();
    let words = stem.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let joined = words.collect::<Vec<_>>().join("-");
    let plain = joined.get(..MAX_STEM).unwrap_or(&joined).trim_end_matches('-');
    if plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
        format!("{plain}-field")
    } else {
        "imported-field".to_owned()
    }
}

/// Largest number of these characters in a row.
fn longest_run(text: &str, character: char) -> usize {
    text.split(|c| c != character).map(str::len).max().unwrap_or(0)
}

/// A number with three digits.
fn rounded(number: f32) -> String {
    let digits = 10_f32.powi(2 - number.abs().max(1e-6).log10().floor() as i32);
    format!("{}", (number * digits).ceil() / digits)
}

/// Field of the scene's only shape, without its placement.
fn shape_alone(scene: &Scene) -> Field {
    let nodes = scene.field.leaves().first().map(|leaf| {
        let params = leaf.params[..leaf.shape.params().len()].to_vec();
        Node { kind: Kind::Shape { shape: leaf.shape.clone(), params, tag: 0 }, placement: Placement::default() }
    });
    Field::new(nodes.as_slice())
}

/// Radius of the smallest ball that contains the solid; `None` if none of [`RADII`] does.
fn bounds(field: &Field) -> Option<f32> {
    let is_outside = |radius: f32| {
        SHELLS.iter().all(|shell| {
            let away = shell * radius;
            let least = (away - radius).mul_add(LEAST_GROWTH, 1e-4 * radius);
            (0..DIRECTIONS).all(|k| field.distance(direction(k) * away) > least)
        })
    };
    RADII.into_iter().find(|radius| is_outside(*radius))
}

/// Direction of a spiral on the sphere (Fibonacci lattice).
fn direction(k: u32) -> Vec3<f32> {
    let y = 1.0 - 2.0 * (k as f32 + 0.5) / DIRECTIONS as f32;
    let (sin, cos) = (2.399_963_2 * k as f32).sin_cos();
    let radius = (1.0 - y * y).sqrt();
    Vec3::new(radius * cos, y, radius * sin)
}

/// Constant with which no step passes a surface, as far as samples show, but at most [`MAX_LIPSCHITZ`].
fn lipschitz(field: &Field) -> f32 {
    let report = check_lipschitz(field, SAMPLE_POINTS);
    if report.slope <= 1.01 {
        return 1.0;
    }
    let safe = (MARGIN / report.safe_factor).max(1.0);
    if safe > MAX_LIPSCHITZ {
        note!(
            "at a few points a step passes the surface unless lipschitz is {safe:.2}, which is usual for fractals; more than \
             {MAX_LIPSCHITZ} would thicken thin parts"
        );
    }
    safe.min(MAX_LIPSCHITZ)
}

/// Camera of a preset, else one that frames the bounds, else one that looks at the origin from outside.
fn camera(preset: &HashMap<String, Vec<f32>>, radius: Option<f32>, field: &Field) -> String {
    let triple = |name: &str| preset.get(name).and_then(|values| <[f32; 3]>::try_from(&values[..]).ok());
    let three = |[x, y, z]: [f32; 3]| format!("{x} {y} {z}");
    if let (Some(eye), Some(target)) = (triple("Eye"), triple("Target"))
        && eye != target
    {
        let up = triple("Up").filter(|up| *up != [0.0; 3]).map_or(String::new(), |up| format!("; up {}", three(up)));
        // Fragmentarium has the tangent of half of the field of view.
        let tangent = preset.get("FOV").and_then(|values| values.first()).copied().filter(|tangent| *tangent > 0.0);
        let fov = 2.0 * tangent.unwrap_or(0.4).atan().to_degrees();
        return format!("camera \"main\" {{ position {}; target {}{up}; fov {fov:.1} }}", three(eye), three(target));
    }
    let away = radius.map_or_else(|| free_distance(field), |radius| 3.6 * radius);
    let eye = VIEW.map(|part| (part * away * 100.0).round() / 100.0);
    format!("camera \"main\" {{ position {}; target 0 0 0; fov 35 }}", three(eye))
}

/// Direction from the origin to the camera.
const VIEW: [f32; 3] = [0.47, 0.38, 0.8];

/// Distance at which the camera of an unbounded field is not in the solid.
fn free_distance(field: &Field) -> f32 {
    let [x, y, z] = VIEW;
    let is_free = |away: &f32| field.distance(Vec3::new(x, y, z) * *away) > 0.05 * away;
    [6.0, 4.0, 8.0, 3.0, 12.0, 2.0, 20.0, 1.0].into_iter().find(is_free).unwrap_or(6.0)
}
