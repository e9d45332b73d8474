//! Meshes: `mesh "file.glb" as="field"`.

use super::Solids;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::{MATERIAL, PLACEMENT};
use crate::language::read::arguments::{arguments, missing_arguments, properties, string};
use crate::language::read::context::{Context, relative_to};
use crate::language::read::placement::Placements;
use crate::language::read::settings::Properties;
use crate::language::read::unexpected::unexpected_node;
use crate::language::tree::{Entry, Node};
use crate::mesh_files::MeshFile;
use crate::settings::MESH;
use pathmarch_field::graph::Kind;
use pathmarch_field::{MeshShape, Node as FieldNode, ShapeRef};
use std::sync::Arc;

impl Solids<'_> {
    /// A mesh, unless its file cannot be read.
    pub(super) fn mesh(&mut self, node: &Node, material: Option<u32>, context: &mut Context) -> Option<FieldNode> {
        const USAGE: &str = "`mesh \"statue.glb\"`";
        let known: Vec<&str> = MESH.iter().map(|setting| setting.name).chain([MATERIAL]).collect();
        let named = properties(node, &known, context);
        let own = named.iter().find(|(name, _)| *name == MATERIAL).map(|(_, entry)| self.material(entry, context));
        let settings = Properties::of(MESH, &named);
        let (form, resolution) = (settings.choice("as", context), settings.whole("resolution", context));
        let file_node = settings.whole("node", context);
        let mut placement = Placements::default();
        for child in node.child_nodes() {
            if !placement.take(child, false, context) {
                unexpected_node(&child.name, PLACEMENT, "in a `mesh`", context);
            }
        }
        let entries = arguments(node, 1, USAGE, context);
        let Some(entry) = entries.first() else {
            missing_arguments(node, USAGE, context);
            return None;
        };
        let file = self.mesh_file(entry, file_node?, context)?;
        let is_own = own.or(material).is_some();
        let tags = match own.or(material) {
            Some(material) => vec![material],
            None => self.materials_of(&file, entry, context),
        };
        let tag = tags.first().copied().unwrap_or_default();
        let form = form?;
        let shape = match form == "triangles" {
            true => {
                // A material of the scene replaces the opacity of those of the file, too.
                let opacity = if is_own { None } else { file.opacity() };
                MeshShape::triangles(Arc::clone(&file.surface), tags).with_opacity(opacity)
            }
            false => {
                let grid = file.field(resolution?).map_err(|error| {
                    let message = "This mesh cannot be a distance field.";
                    let mistake = draft("pathmarch::mesh_field", entry.value_span, message);
                    context.report.add(mistake.label(error.to_string()));
                });
                let (surface, grid) = (Arc::clone(&file.surface), grid.ok()?);
                match form == "field" {
                    true => MeshShape::field(surface, grid, tags),
                    false => MeshShape::lit_by_field(surface, grid, tags),
                }
            }
        };
        let kind = Kind::Shape { shape: ShapeRef::Custom(Arc::new(shape)), params: Vec::new(), tag };
        Some(FieldNode { kind, placement: placement.value })
    }

    fn mesh_file(&mut self, entry: &Entry, node: u32, context: &mut Context) -> Option<Arc<MeshFile>> {
        let name = string(entry, "The mesh", context)?;
        if name.is_empty() {
            let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
            context.report.add(mistake.label("expected the path of a .glb, .gltf, .obj, .stl, .ply or .npy file"));
            return None;
        }
        match self.files.assets.mesh(&relative_to(self.files.scene, name), node) {
            Ok(file) => Some(file),
            Err(error) => {
                let message = format!("The mesh {} cannot be read.", shown(name));
                let mistake = draft("pathmarch::mesh_file", entry.value_span, message).label(error.to_string());
                context.report.add(mistake.help("Its path is relative to the scene file."));
                None
            }
        }
    }

    /// The materials of a file, added to those of the scene once.
    fn materials_of(&mut self, file: &Arc<MeshFile>, entry: &Entry, context: &mut Context) -> Vec<u32> {
        if let Some((_, tags)) = self.mesh_materials.iter().find(|(known, _)| Arc::ptr_eq(known, file)) {
            return tags.clone();
        }
        let mut warnings: Vec<String> = file.warnings.iter().map(ToString::to_string).collect();
        let mut tags = Vec::new();
        for converted in file.scene_materials() {
            tags.push(self.materials.list.len() as u32);
            self.materials.list.push(converted.material.clone());
            warnings.extend(converted.warnings.iter().cloned());
        }
        for warning in warnings {
            let message = format!("Not all of this mesh is shown: {warning}.");
            context.report.warn(draft("pathmarch::mesh", entry.value_span, message).label("in this file"));
        }
        self.mesh_materials.push((Arc::clone(file), tags.clone()));
        tags
    }
}

/// Reports triangles that an operator would have to combine.
pub(super) fn refuse_combined_triangles(node: &FieldNode, owner: &Node, context: &mut Context) {
    let is_alone = match &node.kind {
        Kind::Shape { .. } => true,
        Kind::Operator { children, .. } => children.len() == 1,
        Kind::Modifier { .. } => false,
    };
    if is_alone || !has_triangles(node) {
        return;
    }
    let message = "This combines the triangles of a mesh with operators or other shapes.";
    let mistake = draft("pathmarch::combined_triangles", owner.name.span, message).label("with triangles in it");
    context.report.add(mistake.help("Write `as=\"field\"` at the mesh, or give it an object of its own."));
}

fn has_triangles(node: &FieldNode) -> bool {
    match &node.kind {
        Kind::Shape { shape, .. } => shape.mesh().is_some_and(|mesh| mesh.is_triangles() || mesh.is_lit_by_field()),
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => children.iter().any(has_triangles),
    }
}
