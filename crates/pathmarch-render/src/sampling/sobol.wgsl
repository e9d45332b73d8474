// Random numbers: Owen-scrambled Sobol' points with blue noise over the pixels. Twin of sobol.rs, which explains them.

/// Random numbers of one sample of a pixel.
struct PixelSampler {
    base: u32,
    place: u32,
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

fn pixel_sampler(x: u32, y: u32, sample: u32, seed: u32) -> PixelSampler {
    let morton = reverseBits(spread(x) | (spread(y) << 1u));
    let turned = (scramble_reversed(morton, 0x9e3779b9u) ^ morton) & 0x55555555u;
    let swap = (morton ^ (morton >> 1u)) & turned;
    return PixelSampler(hash(seed), morton ^ swap ^ (swap << 1u), sample);
}

fn sample_2d(sampler: PixelSampler, pair: u32) -> vec2f {
    let seed = hash(sampler.base ^ (pair * 0x9e3779b9u));
    if SAMPLER == INDEPENDENT {
        let x = hash(sampler.sample ^ hash(sampler.place ^ seed));
        return vec2f(unit(x), unit(hash(x ^ seed)));
    }
    let index = reverseBits(scramble_reversed(reverseBits(sampler.sample), seed));
    let place = scramble_reversed(sampler.place, rotate_left(seed, 24u)) >> 16u;
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

fn unstratified_seed(sampler: PixelSampler, surface: u32) -> u32 {
    return hash(hash(sampler.place ^ sampler.base) ^ hash(sampler.sample ^ (surface * 0x85ebca6bu)));
}
