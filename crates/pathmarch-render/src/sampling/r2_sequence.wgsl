// import: sampling/r2_point
// Quasirandom numbers of the modes without noise. Twin of r2_sequence.rs, which explains them.

/// Index of a sample; all pixels have the same numbers.
struct PixelSampler {
    sample: u32,
}

/// Numbers of sample `sample`.
fn pixel_sampler(x: u32, y: u32, sample: u32, seed: u32) -> PixelSampler {
    return PixelSampler(sample);
}

/// Position of a sample in its pixel, the same for every pair of dimensions.
fn sample_2d(sampler: PixelSampler, pair: u32) -> vec2f {
    return r2_point(sampler.sample, vec2u(0x80000000u));
}

/// Blend weight above which a sample uses the second material of the blend `index`.
fn choice(sample: u32, index: u32) -> f32 {
    let multiple = sample * (2654435769u * (2u * index + 1u)) + 0x80000000u;
    return f32(multiple >> 8u) / 16777216.0;
}

/// Seed of `choice`.
fn unstratified_seed(sampler: PixelSampler, surface: u32) -> u32 {
    return sampler.sample;
}
