//! Meshes with known properties, and random numbers, for tests and benchmarks.

use glam::Vec3;
use pathmarch_mesh::TriangleMesh;
use std::collections::HashMap;
use std::f32::consts::TAU;

/// Closed surface of `4 * around * along` triangles or so: a torus of unit radius with a bumpy tube.
pub fn bumpy_torus(around: u32, along: u32, bump: f32) -> TriangleMesh {
    let point = |i: u32, k: u32| {
        let (u, v) = (TAU * i as f32 / around as f32, TAU * k as f32 / along as f32);
        let tube = 0.4 * (1.0 + bump * (7.0 * u).sin() * (9.0 * v).sin() + 0.3 * bump * (41.0 * u + 23.0 * v).sin());
        let ring = 1.0 + tube * v.cos();
        Vec3::new(ring * u.cos(), tube * v.sin(), ring * u.sin())
    };
    let positions = (0..around).flat_map(|i| (0..along).map(move |k| point(i, k))).collect();
    let vertex = |i: u32, k: u32| i % around * along + k % along;
    let quad = |i: u32, k: u32| [vertex(i, k), vertex(i, k + 1), vertex(i + 1, k + 1), vertex(i + 1, k)];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let quads = (0..around).flat_map(|i| (0..along).map(move |k| quad(i, k)));
    TriangleMesh { positions, triangles: quads.flat_map(halves).collect(), ..TriangleMesh::default() }
}

/// Sphere of `20 * 4^levels` triangles with its vertices on the sphere.
pub fn icosphere(radius: f32, levels: u32) -> TriangleMesh {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corner = |k: u32| {
        let (a, b) = ([1.0, -1.0][(k & 1) as usize], [golden, -golden][(k >> 1 & 1) as usize]);
        [[a, b, 0.0], [0.0, a, b], [b, 0.0, a]][(k >> 2) as usize]
    };
    let mut positions: Vec<Vec3> = (0..12).map(|k| radius * Vec3::from(corner(k)).normalize()).collect();
    let mut triangles = hull_of_icosahedron(&positions);
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let mean = positions[a as usize] + positions[b as usize];
                positions.push(radius * mean.normalize());
                positions.len() as u32 - 1
            })
        };
        let split = |&[a, b, c]: &[u32; 3]| {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| middle(p, q, &mut positions));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    TriangleMesh { positions, triangles, ..TriangleMesh::default() }
}

fn hull_of_icosahedron(positions: &[Vec3]) -> Vec<[u32; 3]> {
    let edge = positions[0].length() * 1.1;
    let is_edge = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]) < edge;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let [p, q, r] = [a, b, c].map(|v| positions[v as usize]);
                    let is_outward = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if is_outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    triangles
}

/// Box of 12 triangles.
pub fn cuboid(size: Vec3) -> TriangleMesh {
    let corner = |k: u32| 0.5 * size * Vec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriangleMesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..TriangleMesh::default()
    }
}

/// Independent triangles of random place, size and shape; slivers and overlaps included.
pub fn triangle_soup(count: u32, random: &mut Random) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for index in 0..count {
        let size = 0.3 * random.unit().powi(4);
        let place = random.in_cube();
        mesh.positions.extend((0..3).map(|_| place + size * random.in_cube()).collect::<Vec<_>>());
        mesh.triangles.push([0, 1, 2].map(|k| 3 * index + k));
    }
    mesh
}

/// Pseudo-random numbers (SplitMix64), the same on every machine.
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }
    /// From zero to one, exclusive.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }
    /// An integer below a limit.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit.max(1) as u64) as usize
    }
    /// A point of the cube from -1 to 1.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::from([0, 1, 2].map(|_| 2.0 * self.unit() - 1.0))
    }
    /// A unit vector.
    pub fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    }
}
