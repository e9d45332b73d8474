//! Mesh shapes: hits against a plain search of all triangles in 64 bits, and distances of fields.

use crate::sampling::declared;
use glam::{DVec3, Vec3};
use pathmarch_field::graph::{Kind, MeshHit, RayKind};
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_field::wgsl::Program;
use pathmarch_field::{Field, MeshShape, MeshSurface, Node, Placement, ShapeRef, Solid, registry};
use pathmarch_mesh::{DistanceGrid, ReadOptions, TriangleMesh};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use wide::f32x8;

fn suzanne() -> Arc<MeshSurface> {
    static SURFACE: OnceLock<Arc<MeshSurface>> = OnceLock::new();
    let read = || {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-mesh/tests/data/suzanne.glb");
        let imported = pathmarch_mesh::read(&path, &ReadOptions::default()).expect("a mesh");
        Arc::new(MeshSurface::new(imported.merged(1 << 20).expect("few triangles")).expect("a surface"))
    };
    Arc::clone(SURFACE.get_or_init(read))
}

fn node(shape: MeshShape, placement: Placement) -> Node {
    let kind = Kind::Shape { shape: ShapeRef::Custom(Arc::new(shape)), params: vec![], tag: 0 };
    Node { kind, placement }
}

fn field_shape(resolution: u32) -> MeshShape {
    let surface = suzanne();
    let grid = DistanceGrid::build(surface.mesh(), resolution, &|_| ControlFlow::Continue(())).expect("a grid");
    MeshShape::field(surface, Arc::new(grid), vec![0])
}

/// Evenly spread numbers from 0 to 1 (Roberts 2018).
fn spread(index: u32) -> [f64; 3] {
    [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|step| (0.5 + step * f64::from(index + 1)).fract())
}

fn point(index: u32, half_edge: f64) -> DVec3 {
    (DVec3::from(spread(index)) - 0.5) * 2.0 * half_edge
}

/// Nearest hit of all triangles (Möller and Trumbore 1997), and how far inside its triangle it is.
fn plain_hit(mesh: &TriangleMesh, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let hits = (0..mesh.triangles.len()).filter_map(|triangle| {
        let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let (ab, ac, p) = (b - a, c - a, direction.cross(c - a));
        let inverse = 1.0 / ab.dot(p);
        let (from, q) = (origin - a, (origin - a).cross(ab));
        let (v, w, t) = (from.dot(p) * inverse, direction.dot(q) * inverse, ac.dot(q) * inverse);
        let inside = v.min(w).min(1.0 - v - w);
        (inside >= 0.0 && t > 0.0).then_some((t, inside))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[test]
fn placed_triangles_are_hit_where_a_plain_search_hits_them() {
    let surface = suzanne();
    let placements = [
        Placement { at: Some([2.0, -0.5, 0.3]), rotate: Some([20.0, 130.0, -40.0]), scale: Some(0.7), normal: None },
        Placement { at: Some([-2.0, 0.4, 0.0]), scale: Some(1.6), ..Placement::default() },
    ];
    let nodes = placements.map(|placement| node(MeshShape::triangles(Arc::clone(&surface), vec![0]), placement));
    let field = Field::new(&nodes);
    assert!(field.has_triangles() && field.sphere_traced_bounds().is_empty());
    let poses = placements.map(|placement| placement.pose());
    let (mut hit_count, mut compared) = (0, 0);
    for index in 0..4000 {
        let origin = point(index, 5.0);
        let direction = (point(index + 50_000, 2.5) - origin).normalize();
        let expected = poses.iter().zip(0..).filter_map(|(pose, leaf)| {
            let [x, y, z] = pose.axes.map(|axis| Vec3::from(axis).as_dvec3());
            let local = |v: DVec3| DVec3::new(x.dot(v), y.dot(v), z.dot(v)) / f64::from(pose.scale);
            let at = Vec3::from(pose.at).as_dvec3();
            plain_hit(surface.mesh(), local(origin - at), local(direction)).map(|hit| (hit, leaf))
        });
        let expected = expected.min_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let found = field.mesh_hit(origin.as_vec3(), direction.as_vec3(), f32::INFINITY, RayKind::Camera);
        // At edges, rounding decides.
        if expected.is_some_and(|((_, inside), _)| inside < 1e-4) {
            continue;
        }
        compared += 1;
        hit_count += u32::from(found.is_some());
        match (found, expected) {
            (Some(MeshHit { t, leaf, .. }), Some(((expected, _), expected_leaf))) => {
                assert!((f64::from(t) - expected).abs() < 1e-4 * expected.max(1.0), "ray {index}: {t}, not {expected}");
                assert_eq!(leaf, expected_leaf);
            }
            (None, None) => {}
            (found, expected) => panic!("ray {index}: {found:?}, not {expected:?}"),
        }
    }
    assert!(compared > 3900 && hit_count > 800, "{hit_count} hits of {compared}");
}

#[test]
fn hits_have_the_normal_of_their_triangle() {
    let surface = suzanne();
    let placement = Placement { rotate: Some([0.0, 90.0, 0.0]), scale: Some(2.0), ..Placement::default() };
    let field = Field::new(&[node(MeshShape::triangles(surface, vec![0]), placement)]);
    for index in 0..500 {
        let origin = point(index, 6.0).as_vec3();
        let direction = (point(index + 9000, 1.0).as_vec3() - origin).normalize();
        let Some(hit) = field.mesh_hit(origin, direction, f32::INFINITY, RayKind::Camera) else { continue };
        let p = origin + direction * hit.t;
        let here = field.mesh_interaction(hit.leaf, hit.triangle, p).expect("a mesh");
        assert!(here.distance.abs() < 1e-5 && (here.normal.length() - 1.0).abs() < 1e-5);
        assert!(here.shading_normal.dot(here.normal) > 0.0);
        // Another point of the same plane is hit at the same normal.
        let beside = origin + direction * hit.t + here.normal.any_orthonormal_vector() * 1e-3;
        let distance = field.mesh_interaction(hit.leaf, hit.triangle, beside).expect("a mesh").distance;
        assert!(distance.abs() < 1e-5, "{distance}");
    }
}

#[test]
fn fields_are_the_same_for_one_point_and_for_eight() {
    let Some(Solid::Modifier(twist)) = registry::solid("twist") else { panic!("is registered") };
    let inside = node(field_shape(48), Placement { scale: Some(0.5), ..Placement::default() });
    let twisted = Node {
        kind: Kind::Modifier { modifier: twist, params: vec![0.2], children: vec![inside] },
        placement: Placement::default(),
    };
    for root in [node(field_shape(48), Placement::default()), twisted] {
        let field = Field::new(&[root]);
        assert!(!field.has_triangles() && field.has_meshes());
        for index in 0..200 {
            let points: [Vec3; 8] = std::array::from_fn(|lane| point(8 * index + lane as u32, 2.0).as_vec3());
            let lanes = |axis: usize| f32x8::from(points.map(|p| p[axis]));
            let eight = field.distance(FieldVec3::new(lanes(0), lanes(1), lanes(2))).to_array();
            for (p, eight) in points.iter().zip(eight) {
                let one = field.distance(FieldVec3::new(p.x, p.y, p.z));
                assert!((one - eight).abs() <= 1e-6 * one.abs().max(1.0), "{one} {eight}");
            }
        }
    }
}

#[test]
fn fields_keep_their_lipschitz_constant_and_their_gradient() {
    let field = Field::new(&[node(field_shape(64), Placement { scale: Some(1.5), ..Placement::default() })]);
    let at = |p: Vec3| FieldVec3::new(p.x, p.y, p.z);
    let mut smooth = 0;
    for index in 0..5000 {
        let (a, b) = (point(index, 3.0).as_vec3(), point(index + 7777, 3.0).as_vec3());
        let change = (field.distance(at(a)) - field.distance(at(b))).abs();
        assert!(change <= field.lipschitz() * a.distance(b) * 1.0001 + 1e-5, "{a} {b}");
        let h = 1e-3;
        let slope = |axis: Vec3| (field.distance(at(a + axis * h)) - field.distance(at(a - axis * h))) / (2.0 * h);
        let differences = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
        let gradient = field.surface(at(a), 0).field.gradient;
        smooth += u32::from(differences.distance(Vec3::new(gradient.x, gradient.y, gradient.z)) < 0.02);
    }
    // Gradients jump between cells.
    assert!(smooth > 4800, "{smooth}");
}

#[test]
fn copies_share_their_words() {
    let surface = suzanne();
    let copy = |x: f32| {
        let placement = Placement { at: Some([x, 0.0, 0.0]), ..Placement::default() };
        node(MeshShape::triangles(Arc::clone(&surface), vec![0]), placement)
    };
    let words = |count: u32| {
        let nodes: Vec<Node> = (0..count).map(|k| copy(3.0 * k as f32)).collect();
        Program::new(&Field::new(&nodes)).mesh_words().len()
    };
    let (one, hundred) = (words(1), words(100));
    assert!(hundred < one + 100 * 40, "{one} {hundred}");
}

#[test]
fn code_of_meshes_is_valid() {
    let words = "@group(0) @binding(1) var<storage, read> words: array<u32>;\n\
                 fn mesh_word(index: u32) -> u32 { return words[index]; }\n";
    for shape in [MeshShape::triangles(suzanne(), vec![0, 1]), field_shape(16)] {
        let program = Program::new(&Field::new(&[node(shape, Placement::default())]));
        let code = format!("{}{words}{}", declared(&program), program.code);
        let module =
            naga::front::wgsl::parse_str(&code).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
        let flags = naga::valid::ValidationFlags::all();
        naga::valid::Validator::new(flags, naga::valid::Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
    }
}
