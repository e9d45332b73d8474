//! A scene described in JSON for other renderers, with the numbers of the scene itself.
//!
//! Spheres, boxes, prisms, rectangles and planes keep their parameters, and the reader makes meshes of them. Triangle meshes
//! keep their triangles. All other objects are written as meshes of a chosen number of cells, with the colours of their
//! vertices. Fractals are thickened by half a
//! cell first: their surface is rougher than any cell, and a mesh of it would be noise.

use pathmarch_cli::Failure;
use pathmarch_render::mesh_file;
use pathmarch_render::pathmarch_field::graph::{Kind, Leaf};
use pathmarch_render::pathmarch_field::mesh::Fineness;
use pathmarch_render::pathmarch_field::number::Vec3;
use pathmarch_render::pathmarch_field::registry::modifiers;
use pathmarch_render::pathmarch_field::{Aabb, Mesh, Node, Placement};
use pathmarch_render::pathmarch_scene::{Light, Material, Object, Scene, Sky};
use pathmarch_render::{Settings, scene_hash};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Shapes that keep their parameters.
const SHAPES: [&str; 5] = ["sphere", "box", "prism", "rect", "plane"];

/// A scene that other renderers can read.
pub struct DescribedScene {
    /// The JSON file.
    pub path: PathBuf,
    /// Triangles of the objects that became meshes.
    pub triangles: usize,
    /// Time that making those meshes took, seconds.
    pub mesh_seconds: f64,
    /// Distances of the middles of their triangles from the surface: mean and maximum, metres.
    pub distances: [f64; 2],
}

impl DescribedScene {
    /// Writes a scene as one camera sees it into a directory. `cells` is the number of cells of a mesh along its longest
    /// side.
    ///
    /// # Errors
    /// [`Failure::Other`] names what the description cannot hold: textures, suns and skies that are not constant.
    pub fn write(scene: &Scene, settings: &Settings, cells: u32, directory: &Path) -> Result<Self, Failure> {
        let mut described = Self {
            path: directory.join(format!("{}-{cells}.json", &scene_hash(scene)[..12])),
            triangles: 0,
            mesh_seconds: 0.0,
            distances: [0.0; 2],
        };
        let Sky::Constant(sky) = &scene.sky else {
            return Err(Failure::Other("only a sky of one colour can be described".to_owned()));
        };
        let point = |light: &Light| match light {
            Light::Point { at, intensity, .. } => Ok(json!({ "position": at, "intensity": intensity })),
            Light::Sun { .. } | Light::Spot { .. } => {
                Err(Failure::Other("suns and spot lights cannot be described".to_owned()))
            }
        };
        let mut parts = Vec::new();
        let mut coloured = vec![false; scene.materials.len()];
        for (index, object) in scene.objects.iter().enumerate() {
            if let Some(solids) = described_parts(scene, index, object) {
                parts.extend(solids);
            } else if let Some(leaf) = triangles(scene, index) {
                parts.push(described.triangle_mesh(object, leaf, directory)?);
            } else {
                coloured[object.material] |= scene.materials[object.material].orbit_trap.is_some();
                parts.push(described.mesh(scene, object, cells, directory)?);
            }
        }
        let materials: Result<Vec<Value>, Failure> = scene
            .materials
            .iter()
            .zip(coloured)
            .map(|(material, coloured)| described_material(material, coloured))
            .collect();
        let camera = settings.camera_of(scene);
        let all = json!({
            "camera": { "position": camera.position, "target": camera.target, "up": camera.up, "fov": camera.fov },
            "sky": sky,
            "bounces": settings.bounces,
            "points": scene.lights.iter().map(point).collect::<Result<Vec<_>, _>>()?,
            "materials": materials?,
            "parts": parts,
        });
        std::fs::write(&described.path, all.to_string()).map_err(Failure::other)?;
        Ok(described)
    }

    /// Part of an object that becomes a mesh.
    fn mesh(&mut self, scene: &Scene, object: &Object, cells: u32, directory: &Path) -> Result<Value, Failure> {
        let began = Instant::now();
        let object = &thickened(scene, object, cells);
        let mesh = mesh_file::mesh(scene, &[object], Fineness::Resolution(cells), None, &|_| ControlFlow::Continue(()))
            .map_err(Failure::other)?;
        self.mesh_seconds += began.elapsed().as_secs_f64();
        self.triangles += mesh.triangles.len();
        self.distances = distances(scene, &mesh);
        let arrays =
            Arrays { positions: &mesh.positions, normals: &[], colours: &mesh.colours, triangles: &mesh.triangles };
        let pose = matrix([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        self.mesh_part(object, object.material as u32, &pose, &arrays, directory)
    }

    /// Part of an object that is a triangle mesh.
    fn triangle_mesh(&self, object: &Object, leaf: &Leaf, directory: &Path) -> Result<Value, Failure> {
        let geometry = leaf.shape.mesh().ok_or_else(|| Failure::Other("no mesh".to_owned()))?;
        let [tag] = geometry.tags() else {
            let message = format!("the object {:?} has materials of its file, which cannot be described", object.name);
            return Err(Failure::Other(message));
        };
        let mesh = geometry.surface().mesh();
        let [positions, normals] = [&mesh.positions, &mesh.normals]
            .map(|vectors| vectors.iter().map(|vector| vector.to_array()).collect::<Vec<[f32; 3]>>());
        let arrays = Arrays { positions: &positions, normals: &normals, colours: &[], triangles: &mesh.triangles };
        self.mesh_part(object, *tag, &pose_matrix(leaf), &arrays, directory)
    }

    /// Part with arrays, which are written beside the description.
    fn mesh_part(
        &self,
        object: &Object,
        material: u32,
        matrix: &[[f32; 4]; 4],
        arrays: &Arrays,
        directory: &Path,
    ) -> Result<Value, Failure> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut part = json!({
            "object": object.name, "shape": "mesh", "material": material, "inside_out": false, "matrix": matrix,
        });
        let floats = |values: &[[f32; 3]]| bytemuck::cast_slice(values).to_vec();
        let written: [(&str, Vec<u8>); 4] = [
            ("positions", floats(arrays.positions)),
            ("normals", floats(arrays.normals)),
            ("colours", floats(arrays.colours)),
            ("triangles", bytemuck::cast_slice(arrays.triangles).to_vec()),
        ];
        for (name, bytes) in written.iter().filter(|(_, bytes)| !bytes.is_empty()) {
            let file = format!("{stem}-{}.{name}", object.name);
            std::fs::write(directory.join(&file), bytes).map_err(Failure::other)?;
            part[*name] = json!(file);
        }
        Ok(part)
    }
}

/// Arrays of a mesh; normals and colours may be empty.
struct Arrays<'a> {
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    colours: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
}

/// The triangle mesh of an object, if it is one.
fn triangles(scene: &Scene, object: usize) -> Option<&Leaf> {
    scene.field.leaves().iter().find(|leaf| leaf.object as usize == object && leaf.is_triangles())
}

/// The object; if it has a fractal, thickened by half a cell.
fn thickened(scene: &Scene, object: &Object, cells: u32) -> Object {
    let index = scene.objects.iter().position(|other| other.name == object.name);
    let of_object = |leaf: &usize| Some(scene.field.leaves()[*leaf].object as usize) == index;
    let leaves: Vec<usize> = (0..scene.field.leaves().len()).filter(of_object).collect();
    let is_fractal = leaves.iter().any(|leaf| scene.field.leaves()[*leaf].shape.has_orbit());
    let bounds = leaves.iter().map(|leaf| scene.field.leaf_bounds(*leaf)).reduce(Aabb::union);
    let round = modifiers().iter().find(|modifier| modifier.info().name == "round");
    let (true, Some(bounds), Some(round)) = (is_fractal, bounds, round) else {
        return object.clone();
    };
    let side = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f32::max);
    let kind = Kind::Modifier {
        modifier: *round,
        params: vec![0.5 * side / cells as f32],
        children: vec![object.root.clone()],
    };
    Object { root: Node { kind, placement: Placement::default() }, ..object.clone() }
}

/// Distances of the middles of triangles from the field's surface: mean and maximum, metres.
fn distances(scene: &Scene, mesh: &Mesh) -> [f64; 2] {
    let distance = |corners: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*corners);
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
        f64::from(scene.field.distance(Vec3::new(x, y, z)).abs())
    };
    let mut all = [0.0, 0.0f64];
    for distance in mesh.triangles.iter().map(distance) {
        all = [all[0] + distance / mesh.triangles.len() as f64, all[1].max(distance)];
    }
    all
}

/// The parts of an object: its shape, or a shape and the hollows in it. `None` if it has to become a mesh.
fn described_parts(scene: &Scene, index: usize, object: &Object) -> Option<Vec<Value>> {
    let mut shapes = Vec::new();
    match &object.root.kind {
        Kind::Shape { .. } => shapes.push((&object.root, false)),
        Kind::Operator { operator, smooth: None, children } if operator.info().name == "subtract" => {
            let is_shape = |node: &Node| matches!(node.kind, Kind::Shape { .. });
            if !children.iter().all(is_shape) || !is_hollow(scene, index) {
                return None;
            }
            shapes.extend(children.iter().enumerate().map(|(child, node)| (node, child > 0)));
        }
        _ => return None,
    }
    let leaves: Vec<&Leaf> = scene.field.leaves().iter().filter(|leaf| leaf.object as usize == index).collect();
    let part = |((node, inside_out), leaf): ((&Node, bool), &&Leaf)| {
        let Kind::Shape { shape, params, tag } = &node.kind else { return None };
        let name = &*shape.info().name;
        SHAPES.contains(&name).then(|| {
            json!({
                "object": object.name, "shape": name, "params": params, "material": tag, "inside_out": inside_out,
                "matrix": pose_matrix(leaf),
            })
        })
    };
    (shapes.len() == leaves.len()).then(|| shapes.into_iter().zip(&leaves).map(part).collect())?
}

/// True if the bounds of everything that is subtracted are within those of the first shape: a hollow, which cuts nothing
/// of the outside. This suffices for solids of one kind that share a centre.
fn is_hollow(scene: &Scene, object: usize) -> bool {
    let leaves =
        || (0..scene.field.leaves().len()).filter(|leaf| scene.field.leaves()[*leaf].object as usize == object);
    let Some(first) = leaves().next() else { return false };
    let outer = scene.field.leaf_bounds(first);
    let one_kind =
        |leaf: usize| scene.field.leaves()[leaf].shape.info().name == scene.field.leaves()[first].shape.info().name;
    leaves().skip(1).all(|leaf| {
        let inner = scene.field.leaf_bounds(leaf);
        one_kind(leaf) && (0..3).all(|axis| outer.min[axis] < inner.min[axis] && inner.max[axis] < outer.max[axis])
    })
}

/// Matrix of a leaf's pose.
fn pose_matrix(leaf: &Leaf) -> [[f32; 4]; 4] {
    matrix(leaf.pose.at, leaf.pose.axes.map(|axis| axis.map(|v| v * leaf.pose.scale)))
}

/// Rows of the matrix with this translation and these columns.
fn matrix(at: [f32; 3], axes: [[f32; 3]; 3]) -> [[f32; 4]; 4] {
    let row = |k: usize| [axes[0][k], axes[1][k], axes[2][k], at[k]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

fn described_material(material: &Material, vertex_colours: bool) -> Result<Value, Failure> {
    let fail =
        |what: &str| Err(Failure::Other(format!("{} of the material \"{}\" cannot be described", what, material.name)));
    if !material.textured.is_empty() || material.bump.is_some() {
        return fail("a texture");
    }
    let value = |name: &str| {
        let missing = || Failure::Other(format!("a {} material has no {name}", material.kind.name));
        material.value(name).ok_or_else(missing)
    };
    let number = |name: &str| value(name).map(|value| value[0]);
    Ok(match material.kind.name {
        "diffuse" => json!({
            "name": material.name, "kind": "diffuse", "colour": value("albedo")?, "vertex_colours": vertex_colours,
            "emission": material.emission(),
        }),
        "metal" => json!({
            "name": material.name, "kind": "metal",
            "colour": value("colour")?, "edge": value("edge")?, "roughness": number("roughness")?,
            "emission": material.emission(),
        }),
        "glass" if value("absorb").is_ok_and(|absorb| absorb.iter().any(|v| *v > 0.0)) => return fail("absorption"),
        "glass" if number("abbe")? > 0.0 => return fail("dispersion"),
        "glass" => json!({
            "name": material.name, "kind": "glass", "colour": value("colour")?, "ior": number("ior")?,
        }),
        "emit" => json!({ "name": material.name, "kind": "emit", "radiance": value("radiance")? }),
        other => return fail(&format!("the kind {other}")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(text: &str) -> Result<Value, Failure> {
        let scene = Scene::parse("test.kdl", text)?;
        let directory = tempfile::tempdir().map_err(Failure::other)?;
        let described = DescribedScene::write(&scene, &Settings::of(&scene), 16, directory.path())?;
        let text = std::fs::read_to_string(described.path).map_err(Failure::other)?;
        serde_json::from_str(&text).map_err(Failure::other)
    }

    const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\nmaterial \"m\" { metal 0.5 }\n";

    #[test]
    fn shapes_keep_their_numbers() {
        let text = format!("{HEAD}object \"a\" material=\"m\" {{ sphere 2 {{ scale 3; at 1 2 4 }} }}");
        let scene = described(&text).unwrap_or_else(|_| panic!("described"));
        let part = &scene["parts"][0];
        assert_eq!((part["shape"].as_str(), part["params"][0].as_f64()), (Some("sphere"), Some(2.0)));
        assert_eq!(
            part["matrix"],
            json!([[3.0, 0.0, 0.0, 1.0], [0.0, 3.0, 0.0, 2.0], [0.0, 0.0, 3.0, 4.0], [0.0, 0.0, 0.0, 1.0]])
        );
        let index = part["material"].as_u64().unwrap_or_default() as usize;
        assert_eq!(scene["materials"][index]["kind"], "metal");
        assert_eq!(scene["materials"][index]["colour"], json!([0.5, 0.5, 0.5]));
    }

    #[test]
    fn hollows_are_turned_inside_out_and_other_solids_are_meshes() {
        let hollow = format!("{HEAD}object \"a\" {{ subtract {{ box 2 2 2; box 1 1 1 }} }}");
        let scene = described(&hollow).unwrap_or_else(|_| panic!("described"));
        let parts = scene["parts"].as_array().expect("parts");
        let inside_out: Vec<_> = parts.iter().map(|part| part["inside_out"].as_bool()).collect();
        assert_eq!(inside_out, [Some(false), Some(true)]);
        let cut = format!("{HEAD}object \"a\" {{ subtract {{ box 2 2 2; box 1 1 3 }} }}");
        let scene = described(&cut).unwrap_or_else(|_| panic!("described"));
        assert_eq!(scene["parts"][0]["shape"], "mesh");
    }

    #[test]
    fn fractals_are_thickened_by_half_a_cell() {
        let text = format!("{HEAD}object \"a\" {{ mandelbulb {{ at 1 0 0 }} }}\nobject \"b\" {{ sphere 1 }}");
        let scene = Scene::parse("test.kdl", &text).unwrap_or_else(|_| panic!("a scene"));
        let Kind::Modifier { params, .. } = thickened(&scene, &scene.objects[0], 64).root.kind else {
            panic!("the fractal is as it was");
        };
        assert!((params[0] * 128.0 - 2.4).abs() < 0.3, "{params:?}");
        assert!(matches!(thickened(&scene, &scene.objects[1], 64).root.kind, Kind::Shape { .. }));
    }

    #[test]
    fn what_cannot_be_described_is_an_error() {
        for more in ["sun { direction 0 1 0; irradiance 1 }", "material \"p\" { principled 0.5 }"] {
            let text = format!("{HEAD}{more}\nobject \"a\" {{ sphere 1 }}");
            assert!(described(&text).is_err(), "{more}");
        }
    }
}
