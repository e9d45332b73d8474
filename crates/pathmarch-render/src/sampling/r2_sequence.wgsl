// What stands for random numbers in modes without noise. Twin of steady.rs, which explains it.

const PAIR_PIXEL = 0u;
const PAIR_LENS = 1u;

struct Random {
    sample: u32,
}

fn random_new(x: u32, y: u32, sample: u32, seed: u32) -> Random {
    return Random(sample);
}

/// The sample's point of the sequence.
fn random_pair(random: Random, pair: u32) -> vec2f {
    let point = vec2u(random.sample) * vec2u(3242174889u, 2447445413u) + vec2u(0x80000000u);
    return vec2f(point >> vec2u(8u)) / 16777216.0;
}

/// The weight above which the second material of a blend shows in this sample.
fn choice(sample: u32, index: u32) -> f32 {
    let place = sample * (2654435769u * (2u * index + 1u)) + 0x80000000u;
    return f32(place >> 8u) / 16777216.0;
}
