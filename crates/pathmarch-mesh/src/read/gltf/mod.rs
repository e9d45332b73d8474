//! glTF 2.0, as `.glb` and `.gltf`.
//!
//! **Idea.** The JSON is read into the structures of `json.rs`; buffers are loaded as primitives need them. Each mesh of the file
//! becomes a [`TriangleMesh`] whose triangles name their materials; nodes place them.
//!
//! | File | Contents |
//! |---|---|
//! | `json.rs` | the JSON |
//! | `buffers.rs` | chunks, buffers, data URIs |
//! | `accessor.rs` | typed arrays |
//! | `primitive.rs` | triangles and their attributes |
//! | `materials.rs` | materials, textures, lights, cameras |
//! | `nodes.rs` | the hierarchy |
//!
//! **Source.** glTF 2.0. **Differences.** The crate `gltf` 1.4 is not used: its iterators panic on accessors beyond
//! their buffers, and it reads no clear coat. The tests compare with it. **Limits.** Meshes have at most [`VERTICES_A_BYTE`]
//! vertices for each byte of the file. **Cost.** Linear in the vertices that triangles name.

mod accessor;
mod buffers;
mod json;
mod materials;
mod nodes;
mod primitive;

use super::error::{Mistake, Warnings};
use super::files::{Companions, shortened};
use crate::import::Imported;
use crate::material::{Image, Material};
use crate::triangle_mesh::TriangleMesh;
use buffers::Buffers;
use materials::TextureReader;
use primitive::Budget;

/// Vertices and indices for each byte of a file and its buffers, at most.
const VERTICES_A_BYTE: usize = 4;
/// Extensions that need no special care: they are read, or concern what is not shown.
const READ: [&str; 11] = [
    "KHR_lights_punctual",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
];

/// Reads a glTF file.
pub(super) fn read(bytes: &[u8], companions: &Companions, warnings: &mut Warnings) -> Result<Imported, Mistake> {
    let (text, binary) = buffers::chunks(bytes)?;
    let root: json::Root = serde_json::from_slice(text).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        let message = error.to_string();
        let problem = message.split(" at line ").next().unwrap_or_default();
        Mistake::new(place, problem)
    })?;
    check_asset(&root, warnings)?;
    let nodes = nodes::read(&root, warnings)?;
    let mut buffers = Buffers::new(&root, binary, companions);
    let mut meshes = meshes(&root, &mut buffers, bytes.len(), warnings)?;
    let (images, indices) = images(&root, &mut buffers, warnings);
    let mut textures = TextureReader { root: &root, images: &indices, warnings };
    let materials = root.materials.iter().enumerate().map(|(index, json)| textures.material(index, json));
    let mut materials = materials.collect::<Result<Vec<_>, _>>()?;
    add_default_material(&mut meshes, &mut materials);
    if !nodes.iter().any(|node| node.mesh.is_some_and(|mesh| !meshes[mesh].triangles.is_empty())) {
        let problem = "the scene that is shown has no triangles";
        return Err(Mistake::with_remedy("scene", problem, "export a surface of triangles"));
    }
    let (lights, cameras) = (materials::lights(&root, warnings), materials::cameras(&root)?);
    Ok(Imported { meshes, nodes, materials, images, lights, cameras, warnings: Vec::new() })
}

/// Checks the version, and reports what is not supported.
fn check_asset(root: &json::Root, warnings: &mut Warnings) -> Result<(), Mistake> {
    let version = root.asset.as_ref().map(|asset| asset.version.as_str());
    if !version.is_some_and(|version| version.starts_with("2.")) {
        let problem = format!("version {} is not 2.0", shortened(version.unwrap_or("(none)")));
        return Err(Mistake::with_remedy("asset", problem, "export it as glTF 2.0"));
    }
    let is_read = |name: &&String| READ.contains(&name.as_str());
    // Materials and textures can be shown without; other extensions may change the triangles.
    let is_look = |name: &str| name.contains("_materials_") || name.contains("_texture_");
    if let Some(name) = root.extensions_required.iter().find(|name| !is_read(name) && !is_look(name)) {
        let problem = format!("the file requires the extension {}, which is not supported", shortened(name));
        return Err(Mistake::with_remedy("extensionsRequired", problem, "export it without that extension"));
    }
    for name in root.extensions_used.iter().filter(|name| !is_read(name) && !is_look(name)) {
        let message = format!("extension {} is not supported; the file is shown without", shortened(name));
        warnings.add("extensionsUsed", message);
    }
    if !root.animations.is_empty() {
        warnings.add("animations", "animations are not supported; the pose of the nodes is shown");
    }
    if !root.skins.is_empty() {
        warnings.add("skins", "skins are not supported; meshes are shown in their rest pose");
    }
    Ok(())
}

/// Meshes of the file, in its order.
fn meshes(
    root: &json::Root,
    buffers: &mut Buffers,
    file_bytes: usize,
    warnings: &mut Warnings,
) -> Result<Vec<TriangleMesh>, Mistake> {
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    primitives().try_for_each(|primitive| primitive::load(primitive, root, buffers))?;
    let total = file_bytes.saturating_add(buffers.total_bytes()).saturating_mul(VERTICES_A_BYTE);
    let mut budget = Budget { left: total, total };
    let mut meshes = Vec::with_capacity(root.meshes.len());
    for (index, json) in root.meshes.iter().enumerate() {
        let mut mesh = TriangleMesh::default();
        for (number, primitive) in json.primitives.iter().enumerate() {
            let place = format!("mesh {index}, primitive {number}");
            if let Some(name) = primitive.extensions.keys().find(|name| name.contains("compression")) {
                let message = format!("{} is not supported; the uncompressed copy is shown", shortened(name));
                warnings.add(place.as_str(), message);
            }
            if !primitive.targets.is_empty() {
                warnings.add(place.as_str(), "morph targets are not supported; the base shape is shown");
            }
            let material = material_index(primitive, root, &place)?;
            primitive::append(&mut mesh, primitive, material, (root, buffers), (&place, &mut budget, warnings))?;
        }
        meshes.push(mesh);
    }
    Ok(meshes)
}

/// Material of a primitive; the one after the last if it has none.
fn material_index(primitive: &json::Primitive, root: &json::Root, place: &str) -> Result<u32, Mistake> {
    let index = primitive.material.unwrap_or(root.materials.len());
    if primitive.material.is_some() && index >= root.materials.len() {
        return Err(Mistake::new(place, format!("material {index} does not exist")));
    }
    u32::try_from(index).map_err(|_| Mistake::new(place, "too many materials"))
}

/// Appends the default material if a triangle uses it.
fn add_default_material(meshes: &mut [TriangleMesh], materials: &mut Vec<Material>) {
    let default = materials.len() as u32;
    if meshes.iter().any(|mesh| mesh.materials.contains(&default)) {
        materials.push(Material::default());
    }
}

/// Images that can be shown, and the place of each image of the file among them.
fn images(root: &json::Root, buffers: &mut Buffers, warnings: &mut Warnings) -> (Vec<Image>, Vec<Option<usize>>) {
    let (mut images, mut indices) = (Vec::new(), Vec::new());
    for (index, json) in root.images.iter().enumerate() {
        let place = format!("image {index}");
        let bytes = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => buffers.read_uri(uri, &place),
            (None, Some(view)) => buffers.view_bytes(view, &place),
            (None, None) => Err(Mistake::new(&place, "it has neither a URI nor a buffer view")),
        };
        let name = json.uri.as_deref().filter(|uri| !uri.starts_with("data:")).unwrap_or(&json.name).to_string();
        match bytes.map(|bytes| Image { name, bytes }) {
            Ok(image) if image.is_supported() => {
                indices.push(Some(images.len()));
                images.push(image);
                continue;
            }
            Ok(_) => warnings.add(place, "the image is neither PNG nor JPEG; materials are shown without"),
            Err(mistake) => warnings.add(place, format!("{}; materials are shown without", mistake.problem)),
        }
        indices.push(None);
    }
    (images, indices)
}
