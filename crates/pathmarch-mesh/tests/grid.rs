//! Distance grids against exact distances and winding numbers in 64 bits.

use crate::oracle::{exact_distance, exact_winding_number};
use crate::shapes::{Random, bumpy_torus, cuboid, icosphere, triangle_soup};
use glam::Vec3;
use pathmarch_mesh::grid::{CacheError, GridError};
use pathmarch_mesh::{DistanceGrid, ReadOptions, TriangleMesh, WindingTree, read};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

fn build(mesh: &TriangleMesh, resolution: u32) -> DistanceGrid {
    DistanceGrid::build(mesh, resolution, &|_| ControlFlow::Continue(())).expect("a grid")
}

fn data(name: &str) -> TriangleMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let imported = read(&path, &ReadOptions::default()).expect("a mesh");
    imported.merged(usize::MAX).expect("few triangles")
}

/// Random points within some voxels of the surface.
fn points_near(mesh: &TriangleMesh, grid: &DistanceGrid, count: usize, voxels: f32) -> Vec<Vec3> {
    let mut random = Random(5);
    let point = |_| {
        let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + u * (b - a) + v * (c - a) + voxels * grid.voxel() * random.in_cube()
    };
    (0..count).map(point).collect()
}

#[test]
fn distances_to_a_sphere_are_exact_to_a_twentieth_voxel() {
    // A sphere of 8 voxels and one of 28.
    for (resolution, levels) in [(24, 5), (64, 5)] {
        let mesh = icosphere(1.0, levels);
        let grid = build(&mesh, resolution);
        let error = |p: &Vec3| (grid.distance(*p) - (p.length() - 1.0)).abs() / grid.voxel();
        let points = points_near(&mesh, &grid, 20_000, 1.0);
        let largest = points.iter().map(error).fold(0.0, f32::max);
        println!("resolution {resolution}: error {largest:.4} voxels, slope {:.3}", grid.lipschitz());
        assert!(largest < 0.05);
    }
}

#[test]
fn distances_at_creases_are_within_half_a_voxel() {
    for (name, mesh) in [("cuboid", cuboid(Vec3::new(1.0, 0.7, 0.4))), ("suzanne", data("suzanne.glb"))] {
        let grid = build(&mesh, 128);
        let error = |p: &Vec3| {
            let sign = if exact_winding_number(&mesh, *p) > 0.5 { -1.0 } else { 1.0 };
            (grid.distance(*p) - sign * exact_distance(&mesh, *p) as f32).abs() / grid.voxel()
        };
        let largest = points_near(&mesh, &grid, 5_000, 1.0).iter().map(error).fold(0.0, f32::max);
        println!("{name}: error {largest:.3} voxels, slope {:.3}", grid.lipschitz());
        if name == "cuboid" {
            assert!(largest <= 0.5, "{name}");
        }
    }
}

#[test]
fn signs_are_those_of_the_exact_winding_number() {
    for (name, mesh) in
        [("torus", bumpy_torus(80, 60, 0.3)), ("spot", data("spot.obj")), ("suzanne", data("suzanne.glb"))]
    {
        let grid = build(&mesh, 96);
        let mut random = Random(7);
        let size = grid.bounds().size();
        let around = (0..4_000).map(|_| grid.bounds().centre() + 0.5 * size * random.in_cube());
        let points: Vec<Vec3> = around.chain(points_near(&mesh, &grid, 4_000, 2.0)).collect();
        let is_wrong = |p: &&Vec3| {
            // Interpolation moves the surface within a cell; beyond a voxel the sign is certain.
            exact_distance(&mesh, **p) as f32 > grid.voxel()
                && (exact_winding_number(&mesh, **p) > 0.5) != (grid.distance(**p) < 0.0)
        };
        let wrong = points.iter().filter(is_wrong).count();
        println!("{name}: {wrong} of {} signs differ", points.len());
        assert_eq!(wrong, 0, "{name}");
    }
}
