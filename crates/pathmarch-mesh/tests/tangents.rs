//! Tangents of vertices.

use glam::{Vec2, Vec3, Vec4};
use pathmarch_mesh::TriangleMesh;

/// Two squares side by side in the plane z = 0 that share an edge; u runs away from it on both.
fn mirrored_squares() -> TriangleMesh {
    let positions: Vec<Vec3> =
        [-1.0, 0.0, 1.0].into_iter().flat_map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]).collect();
    // v points down.
    let uvs = positions.iter().map(|p| Vec2::new(p.x.abs(), 1.0 - p.y)).collect();
    TriangleMesh {
        normals: vec![Vec3::Z; positions.len()],
        uvs: [uvs, Vec::new()],
        triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
        positions,
        ..TriangleMesh::default()
    }
}

#[test]
fn tangents_run_along_u_and_mirrored_ones_split_vertices() {
    let mut mesh = mirrored_squares();
    mesh.add_tangents(|_| Some(0));
    assert_eq!(mesh.tangents.len(), mesh.positions.len());
    assert_eq!(mesh.positions.len(), 8, "both vertices of the shared edge are split");
    assert_eq!(mesh.uvs[0].len(), 8);
    for (triangle, expected) in [(0, Vec4::new(-1.0, 0.0, 0.0, -1.0)), (2, Vec4::new(1.0, 0.0, 0.0, 1.0))] {
        for vertex in mesh.triangles[triangle] {
            let tangent = mesh.tangents[vertex as usize];
            assert!(tangent.distance(expected) < 1e-5, "{triangle}: {tangent}");
            // The bitangent points up in the picture.
            let bitangent = mesh.normals[vertex as usize].cross(tangent.truncate()) * tangent.w;
            assert!(bitangent.distance(Vec3::Y) < 1e-5, "{triangle}: {bitangent}");
        }
    }
}

#[test]
fn tangents_of_the_file_are_kept() {
    let mut mesh = mirrored_squares();
    mesh.tangents = vec![Vec4::new(0.0, 1.0, 0.0, 1.0); mesh.positions.len()];
    let before = mesh.clone();
    mesh.add_tangents(|_| Some(0));
    assert_eq!(mesh, before);
}

#[test]
fn materials_without_a_normal_map_get_none() {
    let mut mesh = mirrored_squares();
    mesh.materials = vec![0, 0, 1, 1];
    mesh.add_tangents(|material| (material == 1).then_some(0));
    let [a, b] = [0, 2].map(|triangle: usize| mesh.tangents[mesh.triangles[triangle][0] as usize]);
    assert_eq!((a, b.w), (Vec4::ZERO, 1.0));
}
