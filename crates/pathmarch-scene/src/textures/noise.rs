//! Random numbers of the cells of a lattice, and gradient noise.
//!
//! Both are pure functions of whole numbers and a seed, by an integer hash (pcg3d; Jarzynski and Olano 2020, "Hash Functions
//! for GPU Rendering"), so that the processor and the graphics card draw the same. Gradient noise is that of Perlin 1985
//! with the quintic blend of Perlin 2002; its gradients are uniform in a cube. Cost: eight hashes for a value of noise.

use pathmarch_field::number::{Real, Vec3};
use std::num::Wrapping;
use wide::{f32x8, i32x8, u32x8};

/// Lattice coordinates are clamped to this.
const FARTHEST: f32 = 1e9;

/// Numbers over which textures are written: one, or eight lanes. A lane has the same bits as one number.
pub(super) trait TextureNumber: Real {
    /// Power of a positive number.
    fn powf(self, exponent: f32) -> Self;

    /// Three uniform numbers in 0..1 of a cell.
    fn random(cell: Vec3<Self>, seed: u32) -> Vec3<Self>;
}

/// Three random words of a cell, from three whole numbers, as operations on these.
macro_rules! hash {
    ($cell:expr, $seed:expr, $word:expr) => {{
        let step = |v| v * $word(1_664_525) + $word(1_013_904_223);
        let [x, y, z] = $cell;
        let (mut x, mut y, mut z) = (step(x + $word($seed)), step(y), step(z));
        x += y * z;
        y += z * x;
        z += x * y;
        (x, y, z) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16));
        x += y * z;
        y += z * x;
        z += x * y;
        [x, y, z]
    }};
}

impl TextureNumber for f32 {
    #[inline(always)]
    fn powf(self, exponent: f32) -> Self {
        f32::powf(self, exponent)
    }

    #[inline(always)]
    fn random(Vec3 { x, y, z }: Vec3<Self>, seed: u32) -> Vec3<Self> {
        let whole = |v: f32| Wrapping(v.clamp(-FARTHEST, FARTHEST) as i32 as u32);
        let words = hash!([x, y, z].map(whole), seed.wrapping_mul(0x9e37_79b9), Wrapping);
        let [x, y, z] = words.map(|word| (word.0 >> 8) as f32 / 16_777_216.0);
        Vec3::new(x, y, z)
    }
}

impl TextureNumber for f32x8 {
    #[inline(always)]
    fn powf(self, exponent: f32) -> Self {
        f32x8::from(self.to_array().map(|base| base.powf(exponent)))
    }

    #[inline(always)]
    fn random(Vec3 { x, y, z }: Vec3<Self>, seed: u32) -> Vec3<Self> {
        let whole = |v: f32x8| -> u32x8 {
            let limited = Real::clamp(v, f32x8::splat(-FARTHEST), f32x8::splat(FARTHEST));
            bytemuck::cast(limited.fast_trunc_int())
        };
        let words = hash!([x, y, z].map(whole), seed.wrapping_mul(0x9e37_79b9), u32x8::splat);
        let unit = |word: u32x8| f32x8::from_i32x8(bytemuck::cast::<u32x8, i32x8>(word >> 8)) * (1.0 / 16_777_216.0);
        let [x, y, z] = words.map(unit);
        Vec3::new(x, y, z)
    }
}

/// Largest whole numbers not above the coordinates.
#[inline(always)]
pub(super) fn cell_of<N: Real>(p: Vec3<N>) -> Vec3<N> {
    Vec3::new(p.x.floor(), p.y.floor(), p.z.floor())
}

/// Gradient noise of a lattice of cells of edge one: zero at its points, mean zero, within -1 and 1.
#[inline(always)]
pub(super) fn noise<N: TextureNumber>(p: Vec3<N>, seed: u32) -> N {
    let [one, two] = [1.0, 2.0].map(N::constant);
    let cell = cell_of(p);
    let f = p - cell;
    let corner = |x: f32, y: f32, z: f32| {
        let offset = Vec3::constant([x, y, z]);
        (N::random(cell + offset, seed) * two - Vec3::splat(one)).dot(f - offset)
    };
    let blend = |t: N| t * t * t * (t * (t * N::constant(6.0) - N::constant(15.0)) + N::constant(10.0));
    let s = Vec3::new(blend(f.x), blend(f.y), blend(f.z));
    let mix = |a: N, b: N, t: N| a + (b - a) * t;
    let edge = |y: f32, z: f32| mix(corner(0.0, y, z), corner(1.0, y, z), s.x);
    mix(mix(edge(0.0, 0.0), edge(1.0, 0.0), s.y), mix(edge(0.0, 1.0), edge(1.0, 1.0), s.y), s.z).clamp(-one, one)
}

/// Octaves of noise, each of twice the frequency and `gain` times the strength of the one before; as strong as one alone.
#[inline(always)]
pub(super) fn octaves<N: TextureNumber>(p: Vec3<N>, count: f32, gain: f32, seed: u32) -> N {
    let (mut sum, mut strength, mut total) = (N::zero(), 1.0, 0.0f32);
    let mut q = p;
    for octave in 0..count as u32 {
        sum = sum + noise(q, seed.wrapping_add(octave)) * N::constant(strength);
        total += strength * strength;
        strength *= gain;
        // Off the lattice of the octave before, where that is zero.
        q = q * N::constant(2.0) + Vec3::constant([0.37, 0.61, 0.17]);
    }
    sum / N::constant(total.sqrt())
}

/// The distances of the nearest and of the second nearest of random points, one to each cell of edge one, at most 1; and the cell
/// of the nearest. With `jitter` 0 the points are the middles of the cells.
#[inline(always)]
pub(super) fn nearest_points<N: TextureNumber>(p: Vec3<N>, jitter: f32, seed: u32) -> (N, N, Vec3<N>) {
    let home = cell_of(p);
    let half = Vec3::splat(N::constant(0.5));
    // Points farther away than 1 may lie in cells that are not looked at.
    let (mut first, mut second, mut owner) = (N::one(), N::one(), home);
    for index in 0..27u32 {
        let offset = [index % 3, index / 3 % 3, index / 9].map(|step| step as f32 - 1.0);
        let cell = home + Vec3::constant(offset);
        let point = cell + half + (N::random(cell, seed) - half) * N::constant(jitter);
        let distance = (point - p).length();
        second = second.min(distance.max(first));
        let is_nearer = distance.lt(first);
        first = first.min(distance);
        owner = Vec3::select(is_nearer, cell, owner);
    }
    (first, second, owner)
}

/// From 0 at `from` to 1 at `to`, smooth at both ends.
#[inline(always)]
pub(super) fn smoothstep<N: Real>(from: f32, to: f32, x: N) -> N {
    let t = ((x - N::constant(from)) / N::constant(to - from)).clamp(N::zero(), N::one());
    t * t * (N::constant(3.0) - N::constant(2.0) * t)
}
