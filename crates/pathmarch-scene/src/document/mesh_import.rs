//! Import of mesh files as nodes of a scene: objects, lights and cameras.
//!
//! **Idea.** Each node of a file that has a mesh becomes an object that names the file and the node, so that its materials and pictures
//! stay in the file. Lights and cameras become those of the scene.
//!
//! **Units.** glTF measures light in candela and lux, scenes in watts; 683 lumens are taken as a watt, as Blender does. **Limits.**
//! Parallel projections are left out, with a warning.

use super::text::literals::{number, quoted};
use crate::light::LUMENS_OF_WATT;
use glam::{Affine3A, Vec3};
use pathmarch_mesh::material::{Light, LightKind, Projection};
use pathmarch_mesh::{Bounds, Imported, ReadError, ReadOptions};
use std::f32::consts::FRAC_PI_2;
use std::path::Path;

/// Metres in the unit of STL files, millimetres by convention.
const STL_UNIT: f32 = 0.001;

/// Node to add to a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedNode {
    /// Its word, such as `object`.
    pub word: &'static str,
    /// Its name; `None` for nodes without names.
    pub name: Option<String>,
    /// Text of its children.
    pub body: String,
}

/// Nodes of a mesh file.
#[derive(Clone, Debug, Default)]
pub struct MeshImport {
    /// Objects, lights and cameras.
    pub nodes: Vec<ImportedNode>,
    /// What is not imported, or otherwise than the file means.
    pub warnings: Vec<String>,
    /// Bounds of all meshes, metres: least and greatest corner.
    pub bounds: [[f32; 3]; 2],
}

/// A mesh file as one object that stands on the ground above the origin. Scenes name the file as `written`.
///
/// # Errors
/// [`ReadError`] of the file.
pub fn mesh_on_ground(file: &Path, written: &str) -> Result<ImportedNode, ReadError> {
    let imported = pathmarch_mesh::read(file, &ReadOptions::default())?;
    let bounds = bounds(&imported);
    let is_stl = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("stl"));
    let scale = if is_stl { STL_UNIT } else { 1.0 };
    let centre = 0.5 * (bounds.min + bounds.max);
    let at = triple(-scale * Vec3::new(centre.x, bounds.min.y, centre.z));
    let scale = if is_stl { format!("scale {}; ", number(scale)) } else { String::new() };
    let body = format!("mesh {} {{ {scale}at {at} }}", quoted(written));
    Ok(ImportedNode { word: "object", name: Some(stem(file)), body })
}

/// Objects, lights and cameras of a mesh file, which scenes name as `written`.
///
/// # Errors
/// [`ReadError`] of the file.
pub fn import_mesh(file: &Path, written: &str) -> Result<MeshImport, ReadError> {
    let imported = pathmarch_mesh::read(file, &ReadOptions::default())?;
    let bounds = bounds(&imported);
    let mut import = MeshImport {
        nodes: Vec::new(),
        warnings: imported.warnings.iter().map(ToString::to_string).collect(),
        bounds: [bounds.min.into(), bounds.max.into()],
    };
    let count = imported.nodes.iter().filter(|node| node.mesh.is_some()).count();
    let mut mesh_number = 0;
    for node in &imported.nodes {
        let named = |own: &str| match (own.is_empty(), node.name.is_empty()) {
            (false, _) => Some(own.to_owned()),
            (true, false) => Some(node.name.clone()),
            (true, true) => Some(stem(file)),
        };
        if node.mesh.is_some() {
            mesh_number += 1;
            let one = if count > 1 { format!(" node={mesh_number}") } else { String::new() };
            let body = format!("mesh {}{one}", quoted(written));
            import.nodes.push(ImportedNode { word: "object", name: named(&node.name), body });
        }
        if let Some(light) = node.light.and_then(|light| imported.lights.get(light)) {
            import.nodes.push(light_node(light, &node.world_from_node));
        }
        let Some(camera) = node.camera.and_then(|camera| imported.cameras.get(camera)) else { continue };
        let Projection::Perspective { y_fov_radians, .. } = camera.projection else {
            import.warnings.push(format!("camera \"{}\": its parallel projection is left out", camera.name));
            continue;
        };
        let eye = node.world_from_node.transform_point3(Vec3::ZERO);
        let forward = axis(&node.world_from_node, Vec3::NEG_Z);
        let up = axis(&node.world_from_node, Vec3::Y);
        // The target is what the camera looks at, in the middle of the meshes.
        let reach = forward.dot(0.5 * (bounds.min + bounds.max) - eye).max(0.1);
        let body = format!(
            "position {}; target {}; up {}; fov {}",
            triple(eye),
            triple(eye + forward * reach),
            triple(up),
            number(y_fov_radians.to_degrees().clamp(1.0, 170.0))
        );
        import.nodes.push(ImportedNode { word: "camera", name: named(&camera.name), body });
    }
    Ok(import)
}

/// Text of a scene with these nodes, which stands by itself: a sky if nothing lights it, and a camera if there is none.
pub fn scene_text(import: &MeshImport) -> String {
    let has = |words: &[&str]| import.nodes.iter().any(|node| words.contains(&node.word));
    let mut text = String::from("pathmarch 1\n\n");
    if !has(&["camera"]) {
        let [min, max] = import.bounds.map(Vec3::from);
        let (centre, radius) = (0.5 * (min + max), (0.5 * (max - min).length()).max(1e-3));
        let eye = centre + Vec3::new(0.4, 0.35, 0.85).normalize() * (2.9 * radius);
        text += &format!("camera \"main\" {{ position {}; target {}; fov 40 }}\n", triple(eye), triple(centre));
    }
    let mut names: Vec<(&str, String)> = Vec::new();
    let mut written = Vec::new();
    for node in &import.nodes {
        let name = node.name.as_ref().map(|name| {
            let is_taken = |free: &str| names.iter().any(|(word, taken)| *word == node.word && taken == free);
            let candidates = std::iter::once(name.clone()).chain((2..).map(|k| format!("{name} {k}")));
            let free = candidates.into_iter().find(|name| !is_taken(name)).unwrap_or_default();
            names.push((node.word, free.clone()));
            format!(" {}", quoted(&free))
        });
        written.push((node.word, format!("{}{} {{ {} }}\n", node.word, name.unwrap_or_default(), node.body)));
    }
    // Nodes in the order in which scenes have them.
    for words in [&["camera"][..], &["sun", "point", "spot"], &["object"]] {
        if words.contains(&"sun") && !has(&["sun", "point", "spot"]) {
            text += "sky \"day\" elevation=40 azimuth=140\n";
        }
        text.extend(written.iter().filter(|(word, _)| words.contains(word)).map(|(_, line)| line.as_str()));
    }
    text
}

fn light_node(light: &Light, world_from_node: &Affine3A) -> ImportedNode {
    let power = light.colour * (light.intensity / LUMENS_OF_WATT);
    let (word, body) = match light.kind {
        LightKind::Directional => {
            let towards = axis(world_from_node, Vec3::Z);
            ("sun", format!("direction {}; irradiance {}; angle 0", triple(towards), triple(power)))
        }
        LightKind::Point => {
            let at = world_from_node.transform_point3(Vec3::ZERO);
            ("point", format!("at {}; intensity {}", triple(at), triple(power)))
        }
        LightKind::Spot { inner_cone_radians, outer_cone_radians } => {
            let at = world_from_node.transform_point3(Vec3::ZERO);
            let target = at + axis(world_from_node, Vec3::NEG_Z);
            let outer = outer_cone_radians.clamp(1e-3, FRAC_PI_2);
            let width = inner_cone_radians.clamp(0.0, outer).cos() - outer.cos();
            let (cone, blend) = (2.0 * outer.to_degrees(), width / (1.0 - outer.cos()));
            let (cone, blend) = (number(cone.min(180.0)), number(blend.clamp(0.0, 1.0)));
            let (at, target, power) = (triple(at), triple(target), triple(power));
            ("spot", format!("at {at}; target {target}; intensity {power}; cone {cone}; blend {blend}"))
        }
    };
    ImportedNode { word, name: None, body }
}

/// Bounds of all placed meshes.
fn bounds(imported: &Imported) -> Bounds {
    let placed = imported.nodes.iter().filter_map(|node| Some((node, imported.meshes.get(node.mesh?)?)));
    Bounds::of_points(placed.flat_map(|(node, mesh)| {
        mesh.triangles
            .iter()
            .flatten()
            .map(|&vertex| node.world_from_node.transform_point3(mesh.positions[vertex as usize]))
    }))
}

/// Unit vector of a direction of a node, in world space.
fn axis(world_from_node: &Affine3A, direction: Vec3) -> Vec3 {
    world_from_node.transform_vector3(direction).normalize_or(direction)
}

fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(|| "mesh".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

fn triple(v: Vec3) -> String {
    // Rounding hides the errors of rotations.
    v.to_array().map(|v| number((v * 1e5).round() / 1e5)).join(" ")
}
