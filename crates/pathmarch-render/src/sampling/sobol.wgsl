// Random numbers: Owen-scrambled Sobol' points, their error blue noise over the pixels. Twin of random.rs, which
// explains them.

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
    place: u32,
    sample: u32,
}

// SAMPLER: the order is that of `Sampler`.
const INDEPENDENT = 1u;

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

fn from_base_q(digits: u32) -> u32 {
    var sum = digits;
    var high = (sum >> 2u) & 0x3333u;
    sum ^= high ^ (high << 1u);
    high = (sum >> 4u) & 0x0f0fu;
    sum ^= high ^ (high << 2u);
    high = sum >> 8u;
    return sum ^ high ^ (high << 4u);
}

fn rotate_left(x: u32, bits: u32) -> u32 {
    return (x << bits) | (x >> (32u - bits));
}

fn spread(bits: u32) -> u32 {
    var x = bits;
    x = (x | (x << 8u)) & 0x00ff00ffu;
    x = (x | (x << 4u)) & 0x0f0f0f0fu;
    x = (x | (x << 2u)) & 0x33333333u;
    return (x | (x << 1u)) & 0x55555555u;
}

fn random_new(x: u32, y: u32, sample: u32, seed: u32) -> Random {
    let morton = reverseBits(spread(x) | (spread(y) << 1u));
    let turned = (scramble_reversed(morton, 0x9e3779b9u) ^ morton) & 0x55555555u;
    let swap = (morton ^ (morton >> 1u)) & turned;
    return Random(hash(seed), morton ^ swap ^ (swap << 1u), sample);
}

fn random_pair(random: Random, pair: u32) -> vec2f {
    let seed = hash(random.base ^ (pair * 0x9e3779b9u));
    if SAMPLER == INDEPENDENT {
        let x = hash(random.sample ^ hash(random.place ^ seed));
        return vec2f(unit(x), unit(hash(x ^ seed)));
    }
    let index = reverseBits(scramble_reversed(reverseBits(random.sample), seed));
    let place = scramble_reversed(random.place, rotate_left(seed, 24u)) >> 16u;
    let at_zero = index ^ (index << 8u) ^ (index << 16u) ^ from_base_q(place);
    var at_one = at_zero;
    at_one ^= (at_one >> 1u) & 0x55555555u;
    at_one ^= (at_one >> 2u) & 0x33333333u;
    at_one ^= (at_one >> 4u) & 0x0f0f0f0fu;
    at_one ^= (at_one >> 8u) & 0x00ff00ffu;
    at_one ^= (at_one >> 16u) & 0x0000ffffu;
    let x = reverseBits(scramble_reversed(at_zero, rotate_left(seed, 8u)));
    let y = reverseBits(scramble_reversed(at_one, rotate_left(seed, 16u)));
    return vec2f(unit(x), unit(y));
}

fn random_loose(random: Random, surface: u32) -> u32 {
    return hash(hash(random.place ^ random.base) ^ hash(random.sample ^ (surface * 0x85ebca6bu)));
}
