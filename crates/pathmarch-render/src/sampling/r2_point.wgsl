// Points of the sequence R2. Twin of `point` in r2_sequence.rs, which explains it.

/// Point of the sequence from this start, in parts of 2^32; both coordinates are from 0 to 1.
fn r2_point(index: u32, start: vec2u) -> vec2f {
    return vec2f((vec2u(index) * vec2u(R2_STEP_X, R2_STEP_Y) + start) >> vec2u(8u)) / 16777216.0;
}
