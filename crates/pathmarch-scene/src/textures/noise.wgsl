// Random numbers of the cells of a lattice, and gradient noise. Twin of noise.rs, which explains them.

/// Where a texture is looked at, in its own coordinates.
struct Spot {
    p: vec3f,
    /// Of length one.
    normal: vec3f,
    /// What a pixel covers here, metres.
    footprint: f32,
}

fn lattice_hash(cell: vec3f, seed: u32) -> vec3u {
    var v = bitcast<vec3u>(vec3i(clamp(cell, vec3f(-1e9), vec3f(1e9))));
    v.x += seed * 0x9e3779b9u;
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

fn lattice_random(cell: vec3f, seed: u32) -> vec3f {
    return vec3f(lattice_hash(cell, seed) >> vec3u(8u)) / 16777216.0;
}

fn lattice_corner(cell: vec3f, f: vec3f, offset: vec3f, seed: u32) -> f32 {
    return dot(lattice_random(cell + offset, seed) * 2.0 - 1.0, f - offset);
}

fn lattice_noise(p: vec3f, seed: u32) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    var edges: array<f32, 4>;
    for (var k = 0u; k < 4u; k++) {
        let y = f32(k & 1u);
        let z = f32(k >> 1u);
        let a = lattice_corner(cell, f, vec3f(0.0, y, z), seed);
        let b = lattice_corner(cell, f, vec3f(1.0, y, z), seed);
        edges[k] = a + (b - a) * s.x;
    }
    let low = edges[0] + (edges[1] - edges[0]) * s.y;
    let high = edges[2] + (edges[3] - edges[2]) * s.y;
    return clamp(low + (high - low) * s.z, -1.0, 1.0);
}

fn lattice_octaves(p: vec3f, count: f32, gain: f32, seed: u32) -> f32 {
    var sum = 0.0;
    var strength = 1.0;
    var total = 0.0;
    var q = p;
    for (var octave = 0u; octave < u32(count); octave++) {
        sum += strength * lattice_noise(q, seed + octave);
        total += strength * strength;
        strength *= gain;
        q = q * 2.0 + vec3f(0.37, 0.61, 0.17);
    }
    return sum / sqrt(total);
}

struct NearestPoints {
    first: f32,
    second: f32,
    owner: vec3f,
}

fn nearest_points(p: vec3f, jitter: f32, seed: u32) -> NearestPoints {
    let home = floor(p);
    var found = NearestPoints(1.0, 1.0, home);
    for (var index = 0u; index < 27u; index++) {
        let cell = home + vec3f(f32(index % 3u), f32(index / 3u % 3u), f32(index / 9u)) - 1.0;
        let point = cell + 0.5 + (lattice_random(cell, seed) - 0.5) * jitter;
        let apart = distance(point, p);
        found.second = min(found.second, max(apart, found.first));
        if apart < found.first {
            found.first = apart;
            found.owner = cell;
        }
    }
    return found;
}
