// import: integrator/guide
// Where samples are beside emitters. Twin of emitter_coverage.rs.

/// Samples of an emitter in a square of samples, in the low bits, whether the square has an edge, and whether an emitter far
/// out of focus may be seen in its middle.
const HAS_EMITTER_EDGE = 256u;
const HAS_LENS_TARGET = 512u;

/// Second and third words of a guide, which tell its emitter.
struct EmitterWords {
    second: vec4u,
    third: vec4u,
}

/// True if the camera sees an emitter.
fn shows_emitter(words: EmitterWords) -> bool {
    return (words.third.x >> CLASS_SHIFT) == GUIDE_EMITTER && (words.third.z & MIRROR_BIT) == 0u;
}

/// Emitters and edges at a sample beside another.
fn emitter_relation(here: EmitterWords, there: EmitterWords) -> u32 {
    if !shows_emitter(there) {
        return HAS_EMITTER_EDGE;
    }
    let a = bitcast<vec3f>(vec3u(here.second.zw, here.third.w));
    let b = bitcast<vec3f>(vec3u(there.second.zw, there.third.w));
    return 1u + select(0u, HAS_EMITTER_EDGE, colours_differ(a, b, EMITTER_CONTRAST));
}

/// Emitters and edges of two parts of a square.
fn joined_relations(a: u32, b: u32) -> u32 {
    let bits = HAS_EMITTER_EDGE | HAS_LENS_TARGET;
    return ((a & (HAS_EMITTER_EDGE - 1u)) + (b & (HAS_EMITTER_EDGE - 1u))) | ((a | b) & bits);
}

/// Place of a sample in whose square are these emitters and edges.
fn emitter_place(here: EmitterWords, relations: u32) -> u32 {
    let has_emitter = (relations & (HAS_EMITTER_EDGE - 1u)) >= MIN_EMITTER_SAMPLES;
    let is_edge = (relations & HAS_EMITTER_EDGE) != 0u || (here.third.y & MIXED_BIT) != 0u;
    if has_emitter && !is_edge {
        return WITHIN_EMITTERS;
    }
    if (relations & HAS_LENS_TARGET) != 0u {
        return IN_LENS_TARGET;
    }
    return select(OUTSIDE_EMITTERS, AT_EMITTER_EDGE, has_emitter);
}
