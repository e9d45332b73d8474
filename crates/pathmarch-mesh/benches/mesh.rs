//! Seconds to build a hierarchy and a distance grid, their bytes, and rays a second on all cores.
//!
//! `cargo bench -p pathmarch-mesh --bench mesh [TRIANGLES]` prints a line for each figure, the best of three runs. On Linux
//! all seconds are CPU seconds, so that other work on the machine does not count.
//! `embree.py` beside this file traces such rays through Embree.

#[path = "../tests/shapes.rs"]
#[allow(dead_code)]
mod shapes;

use glam::Vec3;
use pathmarch_mesh::bvh::{CompressedBvh, Ray};
use pathmarch_mesh::{Bvh, DistanceGrid, TriangleMesh};
use rayon::prelude::*;
use shapes::{Random, bumpy_torus};
use std::ops::ControlFlow;
use std::time::Instant;

/// Rays of each kind.
const RAYS: usize = 4_000_000;

fn main() {
    let triangles = std::env::args().find_map(|text| text.parse().ok()).unwrap_or(1_000_000.0_f64);
    let side = (triangles / 2.0).sqrt().round() as u32;
    let mesh = bumpy_torus(side, side, 0.15);
    println!("triangles              {}", mesh.triangles.len());
    println!("mesh, bytes a triangle {:.1}", per_triangle(&mesh, mesh.size_in_bytes()));
    let (seconds, bvh) = best_of_three(|| Bvh::build(&mesh).expect("a hierarchy"));
    println!("build, seconds         {seconds:.2}");
    println!("hierarchy, bytes       {:.1} a triangle", per_triangle(&mesh, bvh.size_in_bytes()));
    let (seconds, compressed) = best_of_three(|| CompressedBvh::build(&mesh).expect("a hierarchy"));
    println!("compressed, seconds    {seconds:.2}");
    println!("compressed, bytes      {:.1} a triangle", per_triangle(&mesh, compressed.size_in_bytes()));
    for (name, rays) in [("camera", camera_rays()), ("random", random_rays(&mut Random(1)))] {
        let (seconds, hits) = best_of_three(|| rays.par_iter().filter(|ray| bvh.intersect(ray).is_some()).count());
        println!("{name} rays, closest hit {:.2} M/s, {hits} hits", RAYS as f64 / seconds / 1e6);
        let (seconds, hits) = best_of_three(|| rays.par_iter().filter(|ray| bvh.occluded(ray)).count());
        println!("{name} rays, any hit     {:.2} M/s, {hits} hits", RAYS as f64 / seconds / 1e6);
    }
    let (seconds, grid) = time(|| DistanceGrid::build(&mesh, 512, &|_| ControlFlow::Continue(())).expect("a grid"));
    println!("grid of 512, seconds    {seconds:.2}");
    println!("grid of 512, megabytes  {:.1}", grid.size_in_bytes() as f64 / 1e6);
    println!("grid of 512, slope      {:.2}", grid.lipschitz());
}

fn per_triangle(mesh: &TriangleMesh, bytes: usize) -> f64 {
    bytes as f64 / mesh.triangles.len() as f64
}

fn best_of_three<T>(work: impl Fn() -> T) -> (f64, T) {
    let runs = [time(&work), time(&work), time(&work)];
    runs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("three runs")
}

fn time<T>(work: impl Fn() -> T) -> (f64, T) {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    let wall = start.elapsed().as_secs_f64();
    (cpu_seconds().zip(cpu).map_or(wall, |(end, start)| end - start), result)
}

/// CPU seconds of all threads so far, where the system reports them in the way of Linux.
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let times = stat.rsplit(')').next()?.split_whitespace().skip(11).take(2);
    Some(times.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0)
}

/// Rays of a pinhole camera, row by row.
fn camera_rays() -> Vec<Ray> {
    let side = (RAYS as f32).sqrt() as usize;
    let pixel = |index: usize| {
        let (x, y) = ((index % side) as f32 / side as f32 - 0.5, (index / side) as f32 / side as f32 - 0.5);
        Ray::new(Vec3::new(0.0, 2.0, 3.0), Vec3::new(x, y - 0.6, -0.9))
    };
    (0..RAYS).map(pixel).collect()
}

/// Rays from random points of the bounds in random directions.
fn random_rays(random: &mut Random) -> Vec<Ray> {
    let ray = |_| Ray::new(random.in_cube() * Vec3::new(1.5, 0.5, 1.5), random.direction());
    (0..RAYS).map(ray).collect()
}
