// Random numbers: Owen-scrambled Sobol' points with blue noise over the pixels. Twin of sobol.rs, which explains them.

/// Random numbers of one sample of a pixel.
struct PixelSampler {
    /// Hash of the seed.
    seed_hash: u32,
    /// Index of the pixel on a space-filling curve, bits reversed.
    curve_index: u32,
    sample: u32,
}

/// Hash of a word (PCG output permutation).
fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// Owen scrambling of reversed bits.
fn scramble_reversed(bits: u32, seed: u32) -> u32 {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// Uniform number in 0..1 from the high 24 bits.
fn unit(x: u32) -> f32 {
    return f32(x >> 8u) / 16777216.0;
}

/// Polynomial with these eight digits in base Q, the coarsest in the two lowest bits.
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

/// Bits of a number below 2^16 with a zero between each two.
fn spread_bits(bits: u32) -> u32 {
    var x = bits;
    x = (x | (x << 8u)) & 0x00ff00ffu;
    x = (x | (x << 4u)) & 0x0f0f0f0fu;
    x = (x | (x << 2u)) & 0x33333333u;
    return (x | (x << 1u)) & 0x55555555u;
}

/// Group of a pixel among four.
fn interleaved_group(pixel: vec2u) -> vec2u {
    let flips = hash((pixel.x / 2u) ^ hash(pixel.y / 2u));
    return (pixel ^ vec2u(flips, flips >> 1u)) & vec2u(1u);
}

/// Pixel of which a pixel has the random numbers where pixels of a group are to be stratified together.
fn place_by_group(pixel: vec2u) -> vec2u {
    return (pixel & vec2u(~7u)) | (interleaved_group(pixel) << vec2u(2u)) | (pixel & vec2u(2u)) | ((pixel >> vec2u(2u)) & vec2u(1u));
}

/// Random numbers of sample `sample` of a pixel.
fn pixel_sampler(x: u32, y: u32, sample: u32, seed: u32) -> PixelSampler {
    let place = select(vec2u(x, y), place_by_group(vec2u(x, y)), PATH_REUSE);
    let morton = reverseBits(spread_bits(place.x) | (spread_bits(place.y) << 1u));
    let flips = (scramble_reversed(morton, 0x9e3779b9u) ^ morton) & 0x55555555u;
    let swap = (morton ^ (morton >> 1u)) & flips;
    return PixelSampler(hash(seed), morton ^ swap ^ (swap << 1u), sample);
}

/// Point of a pair of dimensions, uniform in the unit square.
fn sample_2d(sampler: PixelSampler, pair: u32) -> vec2f {
    let seed = hash(sampler.seed_hash ^ (pair * 0x9e3779b9u));
    if SAMPLER == INDEPENDENT {
        let x = hash(sampler.sample ^ hash(sampler.curve_index ^ seed));
        return vec2f(unit(x), unit(hash(x ^ seed)));
    }
    let index = reverseBits(scramble_reversed(reverseBits(sampler.sample), seed));
    let curve_index = scramble_reversed(sampler.curve_index, rotate_left(seed, 24u)) >> 16u;
    let at_zero = index ^ (index << 8u) ^ (index << 16u) ^ from_base_q(curve_index);
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

/// Seed of choices that need no stratification, different for each surface of the path.
fn unstratified_seed(sampler: PixelSampler, surface: u32) -> u32 {
    return hash(hash(sampler.curve_index ^ sampler.seed_hash) ^ hash(sampler.sample ^ (surface * 0x85ebca6bu)));
}
