// Adapters that let loops run: nothing is to be checked. Takes the place of loop_limit.wgsl.

fn checked(sample: vec4f) -> vec4f {
    return sample;
}
