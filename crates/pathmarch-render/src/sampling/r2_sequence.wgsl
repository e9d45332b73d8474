// What stands for random numbers in modes without noise. Twin of r2_sequence.rs, which explains it.

/// Index of the sample; all pixels have the same numbers.
struct PixelSampler {
    sample: u32,
}

fn pixel_sampler(x: u32, y: u32, sample: u32, seed: u32) -> PixelSampler {
    return PixelSampler(sample);
}

/// The sample's point of the sequence.
fn sample_2d(sampler: PixelSampler, pair: u32) -> vec2f {
    let point = vec2u(sampler.sample) * vec2u(3242174889u, 2447445413u) + vec2u(0x80000000u);
    return vec2f(point >> vec2u(8u)) / 16777216.0;
}

/// The weight above which the second material of a blend shows in this sample.
fn choice(sample: u32, index: u32) -> f32 {
    let place = sample * (2654435769u * (2u * index + 1u)) + 0x80000000u;
    return f32(place >> 8u) / 16777216.0;
}

/// Seed of choices between blended materials.
fn unstratified_seed(sampler: PixelSampler, surface: u32) -> u32 {
    return sampler.sample;
}
