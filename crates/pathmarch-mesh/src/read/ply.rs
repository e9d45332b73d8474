//! PLY, text and binary of both byte orders.
//!
//! **Idea.** The header says which elements with which properties follow; elements and properties that mean nothing here are
//! skipped. Vertices have positions, and normals, texture coordinates and colours if the properties have their usual names; faces
//! are polygons or triangle strips. Colours are sRGB.
//!
//! **Source.** Turk 1994. **Cost.** Memory of about three times the file: counts of the header are compared with the bytes that
//! are left before anything is reserved.

mod header;
mod values;

use super::error::{Mistake, Warnings};
use super::polygon::triangulate;
use super::text::srgb_decode;
use crate::triangle_mesh::TriangleMesh;
use glam::{Vec2, Vec3, Vec4};
use header::{Element, Header};
use values::{Record, Values};

/// Reads a PLY file.
pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<TriangleMesh, Mistake> {
    let header = Header::parse(bytes)?;
    let mut values = Values::new(header.format, &bytes[header.length..]);
    let mut mesh = TriangleMesh::default();
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    for element in &header.elements {
        values.check_count(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut values, &mut mesh)?,
            "face" => read_polygons(element, &["vertex_indices", "vertex_index"], &mut values, &mut polygons)?,
            "tristrips" => {
                let mut strips = Vec::new();
                read_polygons(element, &["vertex_indices", "vertex_index"], &mut values, &mut strips)?;
                strips.iter().for_each(|strip| push_strip(strip, &mut mesh));
            }
            name => {
                let message = format!("elements \"{}\" are ignored", super::files::shortened(name));
                warnings.add("header", message);
                values.skip(element)?;
            }
        }
    }
    check_indices(&mesh, &polygons)?;
    for polygon in &polygons {
        let corners: Vec<Vec3> = polygon.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
        triangulate(&corners, |triangle| mesh.triangles.push(triangle.map(|k| polygon[k])));
    }
    if mesh.triangles.is_empty() {
        let problem = format!("there are no faces, but {} points", mesh.positions.len());
        return Err(Mistake::with_remedy("file", problem, "export a surface of triangles"));
    }
    Ok(mesh)
}

/// Places of some properties in an element, if it has them all.
fn places<const N: usize>(element: &Element, names: [&str; N]) -> Option<[usize; N]> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = element.properties.iter().position(|property| property.name == name && !property.is_list())?;
    }
    Some(places)
}

fn read_vertices(element: &Element, values: &mut Values, mesh: &mut TriangleMesh) -> Result<(), Mistake> {
    let missing = || Mistake::new("header", "vertices have no properties x, y and z");
    let position = places(element, ["x", "y", "z"]).ok_or_else(missing)?;
    let normal = places(element, ["nx", "ny", "nz"]);
    let uv = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]].iter().find_map(|names| places(element, *names));
    let colour = places(element, ["red", "green", "blue"]).or_else(|| places(element, ["r", "g", "b"]));
    let alpha = places(element, ["alpha"]);
    let mut record = Record::default();
    for _ in 0..element.count {
        values.read(element, &mut record)?;
        let vector = |places: [usize; 3]| Vec3::from_array(places.map(|place| record.scalar(place)));
        let unit = |place: usize| record.scalar(place) / element.properties[place].largest();
        mesh.positions.push(vector(position));
        mesh.normals.extend(normal.map(|places| vector(places).normalize_or_zero()));
        // From v up to the orientation of images.
        mesh.uvs[0].extend(uv.map(|[u, v]| Vec2::new(record.scalar(u), 1.0 - record.scalar(v))));
        let with_alpha = |colour: Vec3| colour.extend(alpha.map_or(1.0, |[alpha]| unit(alpha).clamp(0.0, 1.0)));
        mesh.colours
            .extend(colour.map(|places| -> Vec4 { with_alpha(Vec3::from_array(places.map(unit)).map(srgb_decode)) }));
    }
    Ok(())
}

fn read_polygons(
    element: &Element,
    names: &[&str],
    values: &mut Values,
    polygons: &mut Vec<Vec<u32>>,
) -> Result<(), Mistake> {
    let is_indices = |property: &header::Property| property.is_list() && names.contains(&property.name.as_str());
    let missing = || Mistake::new("header", format!("elements \"{}\" have no list {}", element.name, names[0]));
    let place = element.properties.iter().position(is_indices).ok_or_else(missing)?;
    let mut record = Record::default();
    for _ in 0..element.count {
        values.read(element, &mut record)?;
        // Numbers beyond 32 bits saturate, and are found to be out of range. A negative one ends a strip.
        polygons
            .push(record.list(place).iter().map(|&index| if index < 0.0 { u32::MAX } else { index as u32 }).collect());
    }
    Ok(())
}

/// Triangles of a strip; [`u32::MAX`] starts a new one.
fn push_strip(strip: &[u32], mesh: &mut TriangleMesh) {
    for part in strip.split(|&index| index == u32::MAX) {
        for (k, corners) in part.windows(3).enumerate() {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            if a != b && b != c && c != a {
                mesh.triangles.push(if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
    }
}

fn check_indices(mesh: &TriangleMesh, polygons: &[Vec<u32>]) -> Result<(), Mistake> {
    let count = mesh.positions.len();
    let is_bad = |index: &&u32| **index as usize >= count;
    for (number, polygon) in polygons.iter().enumerate() {
        if let Some(index) = polygon.iter().find(is_bad) {
            return Err(Mistake::new(
                format!("face {number}"),
                format!("vertex {index} does not exist; there are {count}"),
            ));
        }
    }
    match mesh.triangles.iter().flatten().find(is_bad) {
        Some(index) => Err(Mistake::new("strips", format!("vertex {index} does not exist; there are {count}"))),
        None => Ok(()),
    }
}
