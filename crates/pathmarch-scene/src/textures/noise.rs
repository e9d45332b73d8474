//! Random numbers of the cells of a lattice, and gradient noise.
//!
//! Both are pure functions of whole numbers and a seed, by an integer hash (pcg3d; Jarzynski and Olano 2020, "Hash Functions
//! for GPU Rendering"), so that the processor and the graphics card draw the same. Gradient noise is that of Perlin 1985
//! with the quintic blend of Perlin 2002; its gradients are uniform in a cube. Cost: eight hashes for a value of noise.

use glam::Vec3;

/// Lattice coordinates are clamped to this.
const FARTHEST: f32 = 1e9;

/// Three random words of a cell.
pub(super) fn hash(cell: Vec3, seed: u32) -> [u32; 3] {
    let whole = |v: f32| v.clamp(-FARTHEST, FARTHEST) as i32 as u32;
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y, mut z) =
        (step(whole(cell.x).wrapping_add(seed.wrapping_mul(0x9e37_79b9))), step(whole(cell.y)), step(whole(cell.z)));
    let mut mix = || {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
    };
    mix();
    (x, y, z) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16));
    let mut mix = || {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
    };
    mix();
    [x, y, z]
}

/// Three uniform numbers in 0..1 of a cell.
pub(super) fn random(cell: Vec3, seed: u32) -> Vec3 {
    Vec3::from_array(hash(cell, seed).map(|word| (word >> 8) as f32 / 16_777_216.0))
}

/// Gradient noise of a lattice of cells of edge one: zero at its points, mean zero, within -1 and 1.
pub(super) fn noise(p: Vec3, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let corner = |x: f32, y: f32, z: f32| {
        let offset = Vec3::new(x, y, z);
        (random(cell + offset, seed) * 2.0 - 1.0).dot(f - offset)
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |y: f32, z: f32| mix(corner(0.0, y, z), corner(1.0, y, z), s.x);
    mix(mix(edge(0.0, 0.0), edge(1.0, 0.0), s.y), mix(edge(0.0, 1.0), edge(1.0, 1.0), s.y), s.z).clamp(-1.0, 1.0)
}

/// Octaves of noise, each of twice the frequency and `gain` times the strength of the one before; as strong as one alone.
pub(super) fn octaves(p: Vec3, count: f32, gain: f32, seed: u32) -> f32 {
    let (mut sum, mut strength, mut total) = (0.0, 1.0, 0.0);
    let mut q = p;
    for octave in 0..count as u32 {
        sum += strength * noise(q, seed.wrapping_add(octave));
        total += strength * strength;
        strength *= gain;
        // Off the lattice of the octave before, where that is zero.
        q = q * 2.0 + Vec3::new(0.37, 0.61, 0.17);
    }
    sum / total.sqrt()
}

/// The distances of the nearest and of the second nearest of random points, one to each cell of edge one, at most 1; and the cell
/// of the nearest. With `jitter` 0 the points are the middles of the cells.
pub(super) fn nearest_points(p: Vec3, jitter: f32, seed: u32) -> (f32, f32, Vec3) {
    let home = p.floor();
    // Points farther away than 1 may lie in cells that are not looked at.
    let (mut first, mut second, mut owner) = (1.0f32, 1.0f32, home);
    for index in 0..27u32 {
        let cell = home + Vec3::new((index % 3) as f32, (index / 3 % 3) as f32, (index / 9) as f32) - 1.0;
        let point = cell + 0.5 + (random(cell, seed) - 0.5) * jitter;
        let distance = point.distance(p);
        second = second.min(distance.max(first));
        if distance < first {
            (first, owner) = (distance, cell);
        }
    }
    (first, second, owner)
}

/// From 0 at `from` to 1 at `to`, smooth at both ends.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
