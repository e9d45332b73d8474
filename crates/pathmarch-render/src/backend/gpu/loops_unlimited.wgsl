// Adapters without a limit of loops: no check. Implements the same interface as loop_limit.wgsl.

fn checked(sample: vec4f) -> vec4f {
    return sample;
}
