//! Import checks on meshes with known mistakes.

use crate::shapes::{cuboid, icosphere};
use glam::Vec3;
use pathmarch_mesh::{MeshReport, PrintReport, TriangleMesh};

fn report(mesh: &TriangleMesh, voxel: f32) -> MeshReport {
    MeshReport::new(mesh, voxel).expect("a report")
}

#[test]
fn good_meshes_are_clean() {
    for mesh in [icosphere(1.0, 3), cuboid(Vec3::ONE)] {
        let report = report(&mesh, 0.02);
        assert!(report.is_clean(), "{report}");
        assert_eq!(
            report.to_string(),
            format!("{} triangles, closed and manifold, no wall thinner than two voxels", mesh.triangles.len())
        );
    }
}

#[test]
fn seams_are_no_holes() {
    let whole = cuboid(Vec3::ONE);
    let split = TriangleMesh {
        positions: (0..12).flat_map(|triangle| whole.corners(triangle)).collect(),
        triangles: (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        ..TriangleMesh::default()
    };
    assert!(report(&split, 0.02).is_clean());
}

#[test]
fn mistakes_are_counted() {
    let mut mesh = icosphere(1.0, 3);
    mesh.triangles.swap_remove(100);
    assert_eq!(report(&mesh, 0.02).boundary_edges, 3);
    mesh.triangles[7].swap(0, 1);
    assert_eq!(report(&mesh, 0.02).flipped_edges, 3);
    mesh.triangles.push(mesh.triangles[50]);
    let found = report(&mesh, 0.02);
    assert_eq!((found.duplicate_triangles, found.non_manifold_edges), (1, 3));
    mesh.triangles.push([0, 0, 1]);
    let found = report(&mesh, 0.02);
    assert_eq!(found.degenerate_triangles, 1);
    let text = found.to_string();
    for words in [
        "3 edges at holes",
        "3 edges with more than two",
        "3 edges beside a flipped",
        "1 triangles that are there twice",
    ] {
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn thin_walls_are_found_and_measured() {
    let slab = cuboid(Vec3::new(1.0, 1.0, 0.03));
    let thin = report(&slab, 0.02);
    assert_eq!(thin.thin_triangles, 4);
    assert!((thin.least_thickness - 0.03).abs() < 1e-5);
    assert!(thin.to_string().contains("4 of 12 triangles on walls thinner than two voxels (0.040), down to 0.030"));
    assert!(report(&slab, 0.01).is_clean());
}

#[test]
fn printers_learn_of_walls_and_overhangs() {
    let report = |mesh: &TriangleMesh| PrintReport::new(mesh, Vec3::Y).expect("a report");
    let slab = report(&cuboid(Vec3::new(2.0, 1.0, 0.03)));
    assert!(slab.thinnest_wall.is_some_and(|wall| (wall - 0.03).abs() < 1e-6), "{slab:?}");
    assert_eq!(slab.overhang_share, 0.0, "its lower side lies on the plate");
    // The cap of a sphere below 45° has half of 1 - cos 45° of its area.
    let ball = report(&icosphere(1.0, 5));
    assert!(ball.thinnest_wall.is_some_and(|wall| (wall - 2.0).abs() < 0.02), "{ball:?}");
    assert!((ball.overhang_share - 0.1464).abs() < 0.01, "{ball:?}");
    // A table of which the top, twice the area of the leg's foot, overhangs.
    let mut table = cuboid(Vec3::new(1.0, 1.0, 1.0));
    let mut top = cuboid(Vec3::new(3.0, 0.1, 1.0));
    top.positions.iter_mut().for_each(|position| position.y += 2.0);
    table.append(&top);
    let table = report(&table);
    assert!(table.thinnest_wall.is_some_and(|wall| (wall - 0.1).abs() < 1e-6), "{table:?}");
    assert!((table.overhang_share - 3.0 / (6.0 + 6.0 + 0.6 + 0.2)).abs() < 1e-6, "{table:?}");
    assert_eq!(report(&TriangleMesh::default()).thinnest_wall, None);
}
