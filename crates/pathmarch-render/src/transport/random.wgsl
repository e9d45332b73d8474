// Random numbers: Owen-scrambled Sobol' points, two dimensions at a time. Twin of random.rs, which explains them.

const PAIR_PIXEL = 0u;
const PAIR_LENS = 1u;
const PAIR_SURFACE = 2u;
const PAIR_SCATTER = 0u;
const PAIR_CHOICE = 1u;
const PAIR_LIGHT = 2u;
const PAIR_LOBE = 3u;
const PAIRS_PER_SURFACE = 4u;

struct Random {
    base: u32,
    sample: u32,
}

fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn scramble_reversed(bits: u32, seed: u32) -> u32 {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

fn unit(x: u32) -> f32 {
    return f32(x >> 8u) / 16777216.0;
}

fn random_new(x: u32, y: u32, sample: u32, seed: u32) -> Random {
    return Random(hash(x ^ hash(y ^ hash(seed))), sample);
}

fn random_pair(random: Random, pair: u32) -> vec2f {
    let seed = hash(random.base ^ (pair * 0x9e3779b9u));
    let index = reverseBits(scramble_reversed(reverseBits(random.sample), seed));
    var second = index;
    second ^= (second >> 1u) & 0x55555555u;
    second ^= (second >> 2u) & 0x33333333u;
    second ^= (second >> 4u) & 0x0f0f0f0fu;
    second ^= (second >> 8u) & 0x00ff00ffu;
    second ^= (second >> 16u) & 0x0000ffffu;
    let x = reverseBits(scramble_reversed(index, hash(seed ^ 0x68bc21ebu)));
    let y = reverseBits(scramble_reversed(second, hash(seed ^ 0x02e5be93u)));
    return vec2f(unit(x), unit(y));
}

fn random_loose(random: Random, surface: u32) -> u32 {
    return hash(random.base ^ hash(random.sample ^ (surface * 0x85ebca6bu)));
}
