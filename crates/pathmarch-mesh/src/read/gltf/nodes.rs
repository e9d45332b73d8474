//! The node hierarchy.

use super::super::error::{Mistake, Warnings};
use super::json;
use crate::import::Node;
use glam::{Affine3A, Mat4, Quat, Vec3};

/// Nodes of the shown scene with their global transforms, parents before children.
pub fn read(root: &json::Root, warnings: &mut Warnings) -> Result<Vec<Node>, Mistake> {
    check_tree(root)?;
    let scene = root.scene.unwrap_or(0);
    let roots = match root.scenes.get(scene) {
        Some(shown) => shown.nodes.clone(),
        None if root.scenes.is_empty() => roots(root),
        None => return Err(Mistake::new("scene", format!("scene {scene} does not exist"))),
    };
    if root.scenes.len() > 1 {
        warnings.add("scenes", format!("only scene {scene} of {} is shown", root.scenes.len()));
    }
    let mut nodes: Vec<Node> = Vec::new();
    let mut is_placed = vec![false; root.nodes.len()];
    let mut ahead: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|index| (index, None)).collect();
    while let Some((index, parent)) = ahead.pop() {
        let missing = || Mistake::new("nodes", format!("node {index} does not exist"));
        let json = root.nodes.get(index).ok_or_else(missing)?;
        if std::mem::replace(&mut is_placed[index], true) {
            return Err(Mistake::new(format!("node {index}"), "it is in the scene twice"));
        }
        let parent_transform = parent.map_or(Affine3A::IDENTITY, |parent| nodes[parent].world_from_node);
        let world_from_node = parent_transform * local_transform(json, index)?;
        if !world_from_node.is_finite() {
            return Err(Mistake::new(format!("node {index}"), "its transform is not finite"));
        }
        let exists = |what: &str, index: Option<usize>, count: usize| match index.filter(|&index| index >= count) {
            Some(index) => Err(Mistake::new("nodes", format!("{what} {index} does not exist"))),
            None => Ok(index),
        };
        let lights = root.extensions.lights.as_ref().map_or(0, |lights| lights.lights.len());
        ahead.extend(json.children.iter().rev().map(|&child| (child, Some(nodes.len()))));
        nodes.push(Node {
            name: json.name.clone(),
            parent,
            world_from_node,
            mesh: exists("mesh", json.mesh, root.meshes.len())?,
            light: exists("light", json.extensions.light.as_ref().map(|light| light.light), lights)?,
            camera: exists("camera", json.camera, root.cameras.len())?,
        });
        if json.skin.is_some() {
            warnings.add(format!("node {index}"), "skins are not supported; the mesh is shown in its rest pose");
        }
    }
    Ok(nodes)
}

/// Nodes that are no node's child.
fn roots(root: &json::Root) -> Vec<usize> {
    let mut is_child = vec![false; root.nodes.len()];
    root.nodes.iter().flat_map(|node| &node.children).for_each(|&child| is_child[child] = true);
    (0..root.nodes.len()).filter(|&index| !is_child[index]).collect()
}

/// Checks that every node has at most one parent and none is its own ancestor.
fn check_tree(root: &json::Root) -> Result<(), Mistake> {
    let mut parents: Vec<Option<usize>> = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for &child in &node.children {
            let place = || format!("node {index}");
            let parent = parents.get_mut(child);
            let parent = parent.ok_or_else(|| Mistake::new(place(), format!("its child {child} does not exist")))?;
            if let Some(other) = parent.replace(index) {
                return Err(Mistake::new(place(), format!("its child {child} is a child of node {other}, too")));
            }
        }
    }
    // Walks up from each node; nodes known to end at a root are not walked again.
    let mut ends = vec![false; parents.len()];
    for start in 0..parents.len() {
        let (mut trail, mut at) = (Vec::new(), Some(start));
        while let Some(node) = at.filter(|&node| !ends[node]) {
            if trail.len() > parents.len() {
                return Err(Mistake::new(format!("node {start}"), "it is its own ancestor"));
            }
            trail.push(node);
            at = parents[node];
        }
        trail.into_iter().for_each(|node| ends[node] = true);
    }
    Ok(())
}

fn local_transform(node: &json::Node, index: usize) -> Result<Affine3A, Mistake> {
    if let Some(matrix) = &node.matrix {
        if matrix[3] != 0.0 || matrix[7] != 0.0 || matrix[11] != 0.0 || matrix[15] != 1.0 {
            return Err(Mistake::new(format!("node {index}"), "the last row of its matrix is not 0 0 0 1"));
        }
        return Ok(Affine3A::from_mat4(Mat4::from_cols_array(matrix)));
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, Quat::from_array);
    let length = rotation.length();
    if !(length.is_finite() && length > 0.0) {
        return Err(Mistake::new(format!("node {index}"), "its rotation is not a quaternion"));
    }
    let [translation, scale] = [node.translation.unwrap_or([0.0; 3]), node.scale.unwrap_or([1.0; 3])].map(Vec3::from);
    Ok(Affine3A::from_scale_rotation_translation(scale, rotation.normalize(), translation))
}
