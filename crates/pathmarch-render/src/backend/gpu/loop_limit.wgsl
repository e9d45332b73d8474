// Limit that some software adapters set to the loops of an invocation; see loop_limit.rs.

/// Suspended paths of a submission, one element for each path.
struct Suspended {
    /// Number of invocations whose loops were ended.
    count: atomic<u32>,
    /// Number of times that the paths were resumed.
    round: u32,
    /// Two; in storage memory, so that the compiler does not know the value.
    iterations: u32,
    paths: array<SuspendedPath>,
}

@group(0) @binding(9) var<storage, read_write> suspended: Suspended;

/// Reports whether the adapter has ended loops of this invocation early: it then ends every loop after one iteration.
fn loops_ended() -> bool {
    var iterations = 0u;
    for (var k = 0u; k < suspended.iterations; k++) {
        iterations += 1u;
    }
    return iterations < suspended.iterations;
}

/// Rejects and counts a sample that was computed after loops were ended.
fn checked(sample: vec4f) -> vec4f {
    if loops_ended() {
        atomicAdd(&suspended.count, 1u);
        return vec4f(0.0);
    }
    return sample;
}
