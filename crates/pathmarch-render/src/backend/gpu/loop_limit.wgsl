// Limit that some software adapters set to the loops of an invocation. loop_limit.rs explains it.

/// Shared by the paths of a submission, one place for each.
struct Suspended {
    /// Invocations whose loops were ended.
    count: atomic<u32>,
    /// 0 where paths begin, else how often they were resumed.
    round: u32,
    /// Two. Read from storage, so that no compiler knows it.
    turns: u32,
    paths: array<SuspendedPath>,
}

@group(0) @binding(9) var<storage, read_write> suspended: Suspended;

/// Reports whether the adapter has ended loops of this invocation before their time: then it ends every loop after one turn.
fn loops_ended() -> bool {
    var turns = 0u;
    for (var k = 0u; k < suspended.turns; k++) {
        turns += 1u;
    }
    return turns < suspended.turns;
}

/// Leaves out what was computed after loops were ended, and counts it.
fn checked(sample: vec4f) -> vec4f {
    if loops_ended() {
        atomicAdd(&suspended.count, 1u);
        return vec4f(0.0);
    }
    return sample;
}
