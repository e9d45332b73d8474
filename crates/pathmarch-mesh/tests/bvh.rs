//! Rays and closest points against plain algorithms in 64 bits.

use crate::oracle::{exact_distance, exact_hit};
use crate::shapes::{Random, bumpy_torus, cuboid, icosphere, triangle_soup};
use glam::Vec3;
use pathmarch_mesh::bvh::{BuildError, CompressedBvh, NODE_WORDS, Ray};
use pathmarch_mesh::{Bvh, TriangleMesh};
use rayon::prelude::*;

/// Rays from inside a torus, at random, at its vertices, and at points of its edges: none may leave without a hit.
fn assert_no_ray_is_lost(count: u64) {
    let mesh = bumpy_torus(120, 90, 0.2);
    let (bvh, compressed) =
        (Bvh::build(&mesh).expect("a hierarchy"), CompressedBvh::build(&mesh).expect("a hierarchy"));
    let is_lost = |seed: &u64| {
        let mut random = Random(*seed);
        let (sin, cos) = (std::f32::consts::TAU * random.unit()).sin_cos();
        let origin = Vec3::new(cos, 0.0, sin) + 0.1 * random.in_cube();
        let [a, b, _] = mesh.corners(random.below(mesh.triangles.len()));
        let direction = match seed % 3 {
            0 => random.direction(),
            1 => a - origin,
            _ => a + random.unit() * (b - a) - origin,
        };
        let ray = Ray::new(origin, direction);
        match (bvh.intersect(&ray), compressed.intersect(&ray)) {
            // Triangles at a vertex have it at parameters that rounding makes different.
            (Some(hit), Some(other)) => (hit.t - other.t).abs() > 1e-5 * hit.t || !bvh.occluded(&ray),
            _ => true,
        }
    };
    let lost: Vec<u64> = (0..count).into_par_iter().filter(is_lost).collect();
    assert!(lost.is_empty(), "{} of {count} rays, first {:?}", lost.len(), lost.first());
}

#[test]
fn no_ray_of_a_million_is_lost_on_a_closed_mesh() {
    assert_no_ray_is_lost(1_000_000);
}

#[test]
#[ignore = "takes a minute"]
fn no_ray_of_ten_million_is_lost_on_a_closed_mesh() {
    assert_no_ray_is_lost(10_000_000);
}

#[test]
fn hits_are_those_of_brute_force() {
    let mesh = bumpy_torus(60, 40, 0.3);
    let bvh = Bvh::build(&mesh).expect("a hierarchy");
    let mut random = Random(3);
    let rays: Vec<Ray> = (0..20_000).map(|_| Ray::new(2.0 * random.in_cube(), random.direction())).collect();
    let is_wrong = |ray: &&Ray| match (bvh.intersect(ray), exact_hit(&mesh, ray)) {
        (Some(hit), Some(t)) => (f64::from(hit.t) - t).abs() > 1e-4 * t.max(0.1),
        (hit, exact) => hit.is_some() != exact.is_some(),
    };
    let wrong: Vec<&Ray> = rays.par_iter().filter(is_wrong).collect();
    // At silhouettes, the side on which a ray passes is a matter of rounding.
    assert!(wrong.len() <= 4, "{} rays: {:?}", wrong.len(), &wrong[..1]);
}

#[test]
fn both_hierarchies_agree_on_a_soup() {
    let mesh = triangle_soup(3_000, &mut Random(11));
    let (bvh, compressed) =
        (Bvh::build(&mesh).expect("a hierarchy"), CompressedBvh::build(&mesh).expect("a hierarchy"));
    let mut random = Random(12);
    for _ in 0..50_000 {
        let mut ray = Ray::new(1.5 * random.in_cube(), random.direction());
        // Rays along axes and diagonals, and ranges that cut the scene.
        if random.unit() < 0.3 {
            ray.direction = ray.direction.round();
        }
        if ray.direction == Vec3::ZERO {
            continue;
        }
        (ray.t_min, ray.t_max) = (0.5 * random.unit(), 3.0 * random.unit());
        let (hit, other) = (bvh.intersect(&ray), compressed.intersect(&ray));
        assert_eq!(hit.map(|hit| hit.t), other.map(|hit| hit.t), "{ray:?}");
        assert_eq!(hit.is_some(), bvh.occluded(&ray), "{ray:?}");
        if let Some(hit) = hit {
            let [a, b, c] = mesh.corners(hit.triangle as usize);
            let [v, w] = hit.barycentrics;
            let off = (a + v * (b - a) + w * (c - a)).distance(ray.at(hit.t));
            assert!(off < 1e-3 && hit.t > ray.t_min && hit.t < ray.t_max, "{ray:?}: off by {off}");
        }
    }
}

#[test]
fn closest_points_are_those_of_brute_force() {
    for mesh in [triangle_soup(500, &mut Random(21)), bumpy_torus(20, 20, 0.3), cuboid(Vec3::new(1.0, 2.0, 1e-4))] {
        let bvh = Bvh::build(&mesh).expect("a hierarchy");
        let mut random = Random(22);
        for _ in 0..5_000 {
            let p = 1.5 * random.in_cube();
            let closest = bvh.closest_point(&mesh, p, f32::INFINITY).expect("there are triangles");
            let exact = exact_distance(&mesh, p);
            assert!((f64::from(closest.distance) - exact).abs() < 2e-6, "{p}: {} {exact}", closest.distance);
            let [a, b, c] = mesh.corners(closest.triangle as usize);
            let [v, w] = closest.barycentrics;
            assert!((a + v * (b - a) + w * (c - a)).distance(closest.point) < 1e-6, "{p}");
            assert_eq!(bvh.closest_point(&mesh, p, 0.99 * closest.distance), None, "{p}");
        }
    }
}

#[test]
fn hierarchies_take_at_most_120_bytes_a_triangle() {
    let mesh = icosphere(1.0, 6);
    let (bvh, compressed) =
        (Bvh::build(&mesh).expect("a hierarchy"), CompressedBvh::build(&mesh).expect("a hierarchy"));
    let bytes = |bytes: usize| bytes as f64 / mesh.triangles.len() as f64;
    println!(
        "mesh {:.1}, hierarchy {:.1}, compressed {:.1} bytes a triangle",
        bytes(mesh.size_in_bytes()),
        bytes(bvh.size_in_bytes()),
        bytes(compressed.size_in_bytes())
    );
    assert!(bytes(mesh.size_in_bytes() + bvh.size_in_bytes()) < 120.0);
    assert!(bytes(mesh.size_in_bytes() + compressed.size_in_bytes()) < 120.0);
    assert_eq!(compressed.nodes.len() % NODE_WORDS, 0);
}

#[test]
fn hierarchies_do_not_depend_on_the_number_of_threads() {
    let mesh = bumpy_torus(300, 300, 0.2);
    let of_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| CompressedBvh::build(&mesh).expect("a hierarchy"))
    };
    let (one, three) = (of_threads(1), of_threads(3));
    assert!(one.nodes == three.nodes && one.triangles == three.triangles);
}

#[test]
fn degenerate_meshes_are_built() {
    let ray = Ray::new(Vec3::new(0.1, 0.2, -1.0), Vec3::Z);
    let empty = TriangleMesh::default();
    assert_eq!(Bvh::build(&empty).expect("empty").intersect(&ray), None);
    assert_eq!(CompressedBvh::build(&empty).expect("empty").intersect(&ray), None);
    assert_eq!(Bvh::build(&empty).expect("empty").closest_point(&empty, Vec3::ZERO, 1.0), None);
    // A thousand equal triangles, a triangle without area, and coordinates from tiny to huge.
    let mut mesh = TriangleMesh {
        positions: vec![
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            Vec3::splat(1e-30),
            Vec3::splat(1e12),
            Vec3::new(-1e12, 1e12, 3.0),
        ],
        triangles: vec![[0, 1, 2]; 1000],
        ..TriangleMesh::default()
    };
    mesh.triangles.extend([[0, 0, 0], [0, 3, 3], [3, 4, 5]]);
    let hit = Bvh::build(&mesh).expect("a hierarchy").intersect(&ray);
    assert_eq!(hit.map(|hit| hit.t), Some(1.0));
    assert_eq!(CompressedBvh::build(&mesh).expect("a hierarchy").intersect(&ray).map(|hit| hit.t), Some(1.0));
    // Each next triangle is half as large and half as far: trees by the heuristic alone would be deep.
    let mut chain = TriangleMesh::default();
    for k in 0..20_000 {
        let scale = 0.99_f32.powi(k % 2_500);
        chain.positions.extend([Vec3::X, Vec3::Y, Vec3::Z].map(|corner| scale * corner));
        chain.triangles.push([0, 1, 2].map(|corner| 3 * k as u32 + corner));
    }
    let ray = Ray::new(Vec3::splat(2.0), Vec3::splat(-1.0));
    let hit = Bvh::build(&chain).expect("a hierarchy").intersect(&ray).expect("a hit");
    assert!((hit.t - 5.0 / 3.0).abs() < 1e-5);
}

#[test]
fn unusable_triangles_are_errors() {
    let mut mesh = cuboid(Vec3::ONE);
    mesh.positions[5].y = f32::NAN;
    assert!(matches!(Bvh::build(&mesh), Err(BuildError::NotFinite(_))));
    mesh.positions[5].y = 1e20;
    assert!(matches!(CompressedBvh::build(&mesh), Err(BuildError::NotFinite(_))));
    mesh.triangles[3] = [0, 1, 99];
    mesh.positions[5].y = 0.5;
    assert_eq!(Bvh::build(&mesh).err(), Some(BuildError::OutOfRange(3)));
    assert_eq!(mesh.drop_unusable().out_of_range, 1);
    assert!(Bvh::build(&mesh).is_ok());
}
