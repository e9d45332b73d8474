//! Objects that emit a given luminous flux: `object "bulb" material="lamp" lumen=800 { sphere 0.03 }`.
//!
//! A surface of area A and radiance L emits a power of π A L. The radiance of the object's materials is scaled by one
//! factor, so that the power of all its surfaces has the luminous flux. Areas are exact where a shape has a formula
//! ([`Shape::area`](pathmarch_field::Shape::area)), and so are sums over shapes whose bounds do not overlap. The area of
//! any other solid is that of a triangle mesh of it, within a percent or so.

use crate::light::LUMENS_OF_WATT;
use crate::materials::Material;
use crate::unit::LengthUnit;
use pathmarch_field::graph::Kind;
use pathmarch_field::mesh::Fineness;
use pathmarch_field::{Aabb, Field, Mesh, Node};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Cells of the mesh of a solid along its longest side.
const CELLS: u32 = 96;
/// Most children of a union whose bounds are compared.
const MOST_CHILDREN: usize = 256;

/// Why an object has no radiance for a flux.
pub(super) enum FluxError {
    /// None of its materials emits.
    Dark,
    /// Its area is not known.
    Area(String),
}

/// Replaces the materials of a solid that emit by such whose flux together is this one; returns which.
pub(super) fn scale_emission(
    root: &mut Node,
    lumens: f32,
    unit: LengthUnit,
    materials: &mut Vec<Material>,
) -> Result<HashMap<u32, u32>, FluxError> {
    let luminance = |tag: u32| {
        let [r, g, b] = materials[tag as usize].emission().map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    if tags(root).into_iter().all(|tag| luminance(tag) <= 0.0) {
        return Err(FluxError::Dark);
    }
    let metres = unit.metres();
    let power = PI * power_by_pi(root, &luminance)? * metres * metres;
    if power <= 0.0 {
        return Err(FluxError::Area("none of its surface emits".to_owned()));
    }
    let factor = f64::from(lumens) / f64::from(LUMENS_OF_WATT) / power;
    let mut scaled: HashMap<u32, u32> = HashMap::new();
    for tag in tags(root) {
        if materials[tag as usize].emits() {
            let material = materials[tag as usize].with_emission_scaled(factor as f32);
            scaled.insert(tag, materials.len() as u32);
            materials.push(material);
        }
    }
    replace_tags(root, &scaled);
    Ok(scaled)
}

/// Integral of the luminance of a solid's radiance over its surface.
fn power_by_pi(node: &Node, luminance: &dyn Fn(u32) -> f64) -> Result<f64, FluxError> {
    let scale = f64::from(node.placement.scale.unwrap_or(1.0));
    match &node.kind {
        Kind::Shape { shape, params, tag } => {
            if shape.mesh().is_some() {
                let reason = "it is a mesh file; give its material a radiance instead";
                return Err(FluxError::Area(reason.to_owned()));
            }
            match shape.area(params) {
                Some(area) => Ok(f64::from(area) * scale * scale * luminance(*tag)),
                None => meshed(node, luminance),
            }
        }
        Kind::Operator { operator, smooth, children } => {
            let is_sharp = smooth.as_ref().is_none_or(|blend| blend.amount == 0.0);
            if operator.info().name != "union" || !is_sharp || !are_apart(children) {
                return meshed(node, luminance);
            }
            let parts = children.iter().map(|child| power_by_pi(child, luminance));
            Ok(parts.sum::<Result<f64, FluxError>>()? * scale * scale)
        }
        Kind::Modifier { .. } => meshed(node, luminance),
    }
}

/// True if the bounds of no two nodes overlap.
fn are_apart(nodes: &[Node]) -> bool {
    if nodes.len() > MOST_CHILDREN {
        return false;
    }
    let bounds: Vec<Aabb> = nodes.iter().map(|node| Field::new(std::slice::from_ref(node)).bounds()).collect();
    let overlap = |a: &Aabb, b: &Aabb| (0..3).all(|k| a.min[k] < b.max[k] && b.min[k] < a.max[k]);
    bounds.iter().enumerate().all(|(k, a)| bounds[k + 1..].iter().all(|b| !overlap(a, b)))
}

/// [`power_by_pi`] of a mesh of the solid.
fn meshed(node: &Node, luminance: &dyn Fn(u32) -> f64) -> Result<f64, FluxError> {
    let field = Field::new(std::slice::from_ref(node));
    let by_leaf: Vec<f32> = field.leaves().iter().map(|leaf| luminance(leaf.tag) as f32).collect();
    let paint = |leaf: usize, _: [f32; 3], _: [f32; 3]| [by_leaf[leaf]; 3];
    let progress = |_: f32| ControlFlow::Continue(());
    let mesh = Mesh::new(&field, Fineness::Resolution(CELLS), None, &paint, &progress)
        .map_err(|error| FluxError::Area(error.to_string()))?;
    let part = |&triangle: &[u32; 3]| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| glam::Vec3::from(corner).as_dvec3());
        let mean = triangle.iter().map(|vertex| f64::from(mesh.colours[*vertex as usize][0])).sum::<f64>() / 3.0;
        0.5 * (b - a).cross(c - a).length() * mean
    };
    Ok(mesh.triangles.iter().map(part).sum())
}

/// Tags of all shapes, each once.
fn tags(node: &Node) -> Vec<u32> {
    let mut all = match &node.kind {
        Kind::Shape { shape, tag, .. } => {
            let of_mesh = shape.mesh().map_or(&[][..], |mesh| mesh.tags());
            of_mesh.iter().copied().chain([*tag]).collect()
        }
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => {
            children.iter().flat_map(tags).collect::<Vec<u32>>()
        }
    };
    all.sort_unstable();
    all.dedup();
    all
}

fn replace_tags(node: &mut Node, new: &HashMap<u32, u32>) {
    match &mut node.kind {
        Kind::Shape { tag, .. } => *tag = new.get(tag).copied().unwrap_or(*tag),
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => {
            children.iter_mut().for_each(|child| replace_tags(child, new));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    /// Nodes of an object's shapes, and their area by both ways.
    #[test]
    fn exact_areas_are_those_of_fine_meshes() {
        for shape in [
            "sphere 0.7",
            "box 1 2 0.5",
            "cylinder 0.4 1.5",
            "cone 0.6 0.8",
            "capsule 0.3 0.9",
            "torus 0.8 0.3",
            "union { sphere 0.5 { at 2 0 0; scale 2 }; box 1 { at -1 0 0; rotate 0 30 0 }; scale 0.5 }",
        ] {
            let text = format!("pathmarch 1\ncamera {{ position 0 1 5; target 0 0 0 }}\nobject \"o\" {{ {shape} }}");
            let scene = Scene::parse("scene.kdl", &text).unwrap_or_else(|error| panic!("{shape}: {error:?}"));
            let root = &scene.objects[0].root;
            let both = [power_by_pi(root, &|_| 1.0), meshed(root, &|_| 1.0)].map(Result::ok);
            let [Some(exact), Some(meshed)] = both else { panic!("{shape}: {both:?}") };
            println!("{shape}: {exact} {meshed}");
            assert!((exact - meshed).abs() < 0.01 * exact, "{shape}: {exact} is not {meshed}");
        }
    }
}
