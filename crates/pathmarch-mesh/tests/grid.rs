//! Distance grids against exact distances and winding numbers in 64 bits.

use crate::oracle::{exact_distance, exact_winding_number};
use crate::shapes::{Random, bumpy_torus, cuboid, icosphere, triangle_soup};
use glam::Vec3;
use pathmarch_mesh::grid::{CacheError, GridError};
use pathmarch_mesh::{DistanceGrid, ReadOptions, TriangleMesh, WindingTree, read};
use rayon::prelude::*;
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
            let winding = exact_winding_number(&mesh, *p);
            // Suzanne's parts overlap and have holes: inside are surfaces that bound no solid, and fans in the holes.
            let sign = if winding > 0.5 { -1.0 } else { 1.0 };
            let error = (grid.distance(*p) - sign * exact_distance(&mesh, *p) as f32) / grid.voxel();
            if name == "cuboid" || winding < 0.5 { error.abs() } else { 0.0 }
        };
        let points = points_near(&mesh, &grid, 5_000, 1.0);
        let largest = points.par_iter().map(error).reduce(|| 0.0, f32::max);
        println!("{name}: error {largest:.3} voxels, slope {:.3}", grid.lipschitz());
        assert!(largest <= 0.5, "{name}");
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
        let wrong = points.par_iter().filter(is_wrong).count();
        println!("{name}: {wrong} of {} signs differ", points.len());
        assert_eq!(wrong, 0, "{name}");
    }
}

#[test]
fn signs_of_all_samples_are_exact() {
    for (name, mesh) in [("torus", bumpy_torus(40, 30, 0.3)), ("slab", cuboid(Vec3::new(1.0, 0.7, 0.02)))] {
        let grid = build(&mesh, 48);
        let size = (grid.bounds().size() / grid.voxel()).round().as_uvec3();
        let at = |x, y, z| grid.bounds().min + grid.voxel() * Vec3::new(x as f32, y as f32, z as f32);
        let mut inside = 0;
        for p in (0..size.x).flat_map(|x| (0..size.y).flat_map(move |y| (0..size.z).map(move |z| at(x, y, z)))) {
            let is_certain = exact_distance(&mesh, p) as f32 > 1e-3 * grid.voxel();
            let is_inside = exact_winding_number(&mesh, p) > 0.5;
            inside += usize::from(is_inside);
            assert!(!is_certain || is_inside == (grid.distance(p) < 0.0), "{name}: {p}");
        }
        println!("{name}: {inside} samples inside");
        assert!(name == "slab" || inside > 1000);
    }
}

#[test]
fn fast_winding_numbers_are_close_to_exact_ones() {
    for (name, mesh) in [("torus", bumpy_torus(60, 40, 0.3)), ("suzanne", data("suzanne.glb"))] {
        let tree = WindingTree::build(&mesh).expect("a tree");
        let mut random = Random(31);
        let mut error = || {
            let p = 2.0 * random.in_cube();
            let exact = exact_winding_number(&mesh, p);
            assert!((exact - 0.5).abs() < 0.01 || tree.encloses(p) == (exact > 0.5), "{name}: {p} has {exact}");
            (f64::from(tree.winding_number(p)) - exact).abs()
        };
        let largest = (0..5_000).map(|_| error()).fold(0.0, f64::max);
        println!("{name}: error {largest:.5}");
        assert!(largest < 0.01, "{name}");
    }
}

#[test]
fn field_is_continuous_and_no_steeper_than_it_says() {
    for mesh in [cuboid(Vec3::new(1.0, 0.3, 0.05)), data("suzanne.glb"), triangle_soup(60, &mut Random(41))] {
        let grid = build(&mesh, 64);
        let lipschitz = grid.lipschitz();
        let mut random = Random(42);
        let mut steepest = 0.0_f32;
        for k in 0..200_000 {
            let p = grid.bounds().centre() + 0.7 * grid.bounds().size() * random.in_cube();
            let length = grid.voxel() * [1e-3, 0.1, 3.0][k % 3];
            let q = p + length * random.direction();
            let slope = (grid.distance(p) - grid.distance(q)).abs() / p.distance(q);
            steepest = steepest.max(if slope.is_finite() { slope } else { 0.0 });
        }
        println!("steepest {steepest:.3}, bound {lipschitz:.3}");
        // Distances are rounded, which counts where points are a thousandth of a voxel apart.
        assert!(steepest < 1.02 * lipschitz);
    }
}

#[test]
fn safe_radius_reaches_no_zero() {
    let mesh = data("suzanne.glb");
    let grid = build(&mesh, 64);
    let mut random = Random(51);
    for _ in 0..20_000 {
        let p = grid.bounds().centre() + 0.7 * grid.bounds().size() * random.in_cube();
        let (radius, is_inside) = (grid.safe_radius(p), grid.distance(p) < 0.0);
        for _ in 0..8 {
            let q = p + 0.999 * radius * random.direction();
            assert_eq!(grid.distance(q) < 0.0, is_inside, "{p} {radius} {q}");
        }
    }
}

#[test]
fn gradient_is_that_of_the_distance() {
    let grid = build(&bumpy_torus(60, 40, 0.3), 64);
    let mut random = Random(61);
    let step = 1e-3 * grid.voxel();
    for _ in 0..20_000 {
        let p = grid.bounds().centre() + 0.7 * grid.bounds().size() * random.in_cube();
        let (distance, gradient) = grid.distance_and_gradient(p);
        assert_eq!(distance, grid.distance(p));
        let to = random.direction();
        let [before, after] = [-step, step].map(|step| grid.distance(p + step * to));
        // Across a face between cells the derivative jumps.
        let difference = (after - before) / (2.0 * step);
        let one_sided = [(after - distance) / step, (distance - before) / step];
        let is_smooth = (one_sided[0] - one_sided[1]).abs() < 0.1;
        assert!(!is_smooth || (difference - gradient.dot(to)).abs() < 0.1, "{p}: {difference} {}", gradient.dot(to));
    }
}

#[test]
fn holes_and_flipped_triangles_do_not_spoil_the_inside() {
    let whole = icosphere(1.0, 3);
    let mut broken = whole.clone();
    broken.triangles.retain(|&[a, ..]| whole.positions[a as usize].y < 0.9);
    for triangle in broken.triangles.iter_mut().step_by(97) {
        triangle.swap(0, 1);
    }
    let grid = build(&broken, 64);
    for (p, is_inside) in [(Vec3::ZERO, true), (Vec3::new(0.0, 0.8, 0.0), true), (Vec3::new(0.0, 1.1, 0.0), false)] {
        assert_eq!(grid.distance(p) < 0.0, is_inside, "{p}");
    }
    let mut random = Random(71);
    for _ in 0..10_000 {
        let p = random.in_cube() * Vec3::new(1.0, 0.8, 1.0);
        let exact = p.length() - 1.0;
        assert!(exact.abs() < 0.1 || (grid.distance(p) < 0.0) == (exact < 0.0), "{p}");
    }
}

#[test]
fn grids_do_not_depend_on_the_number_of_threads_and_survive_a_cache() {
    let mesh = data("suzanne.glb");
    let of_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| build(&mesh, 48))
    };
    let grid = of_threads(1);
    assert_eq!(grid, of_threads(3));
    let bytes = grid.to_bytes();
    assert_eq!(DistanceGrid::from_bytes(&bytes), Ok(grid));
    assert_eq!(DistanceGrid::from_bytes(b"PMGRID00"), Err(CacheError::Version));
    let mut random = Random(81);
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        damaged[8 + random.below(bytes.len() - 8)] ^= 1 << random.below(8);
        assert_eq!(DistanceGrid::from_bytes(&damaged), Err(CacheError::Damaged));
        assert!(DistanceGrid::from_bytes(&bytes[..random.below(bytes.len())]).is_err());
    }
}

#[test]
fn building_reports_progress_and_stops() {
    let mesh = icosphere(1.0, 3);
    let (calls, largest) = (AtomicU32::new(0), AtomicU32::new(0));
    let progress = |share: f32| {
        assert!((0.0..=1.0).contains(&share));
        calls.fetch_add(1, Ordering::Relaxed);
        largest.fetch_max(share.to_bits(), Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    assert!(DistanceGrid::build(&mesh, 48, &progress).is_ok());
    assert!(calls.load(Ordering::Relaxed) > 100);
    assert_eq!(f32::from_bits(largest.load(Ordering::Relaxed)), 1.0);
    let half = |share: f32| if share > 0.5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    assert_eq!(DistanceGrid::build(&mesh, 48, &half), Err(GridError::Stopped));
}

#[test]
fn unusable_meshes_are_errors() {
    let build = |mesh: &TriangleMesh, resolution| DistanceGrid::build(mesh, resolution, &|_| ControlFlow::Continue(()));
    assert_eq!(build(&TriangleMesh::default(), 64), Err(GridError::Empty));
    assert_eq!(build(&icosphere(1.0, 1), 5000), Err(GridError::Resolution(5000)));
    let point = TriangleMesh { positions: vec![Vec3::ONE], triangles: vec![[0; 3]], ..TriangleMesh::default() };
    assert_eq!(build(&point, 64), Err(GridError::Empty));
    // A sheet has no inside, but distances.
    let sheet = TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let grid = build(&sheet, 32).expect("a grid");
    assert!((grid.distance(Vec3::new(0.2, 0.2, 0.1)) - 0.1).abs() < 0.1 * grid.voxel());
    let beyond = grid.distance(Vec3::new(0.2, 0.2, 0.5));
    assert!(beyond > 0.3 && beyond <= 0.5, "{beyond}");
    assert!(grid.distance(Vec3::new(0.2, 0.2, 0.0)) >= 0.0);
}
