// First hits of camera rays with a mesh: by its hierarchy, and from rasterised triangle ids. Traversal and tests of triangles
// are the renderer's, from the code of the field.

@group(0) @binding(1) var<storage, read> mesh_words: array<u32>;
/// First hit of each pixel: bits of its distance, and its triangle with a mark.
@group(0) @binding(2) var<storage, read_write> hits: array<vec2u>;
@group(0) @binding(3) var triangle_ids: texture_2d<u32>;
/// Near plane over distance; zero where there is no triangle.
@group(0) @binding(4) var depths: texture_depth_2d;

/// Distance of rays without a hit.
const AT_INFINITY = 1e30;
/// Triangle of rays without a hit.
const NO_HIT = 0x7fffffffu;
/// Mark of pixels whose rays have traversed the hierarchy although there are ids.
const FALLBACK = 0x80000000u;

struct Ray {
    origin: vec3f,
    /// Unit vector.
    direction: vec3f,
}

fn mesh_word(index: u32) -> u32 {
    return mesh_words[index];
}

/// Random word (PCG hash; Jarzynski and Olano 2020).
fn hash(seed: u32) -> u32 {
    let state = seed * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// Pixel of an invocation: eight consecutive lanes are 4x2 pixels, as in the renderer's kernels.
fn pixel_of(group: vec2u, lane: u32) -> vec2u {
    return 8u * group + vec2u((lane & 3u) | ((lane >> 1u) & 4u), ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u));
}

fn camera_ray(pixel: vec2u) -> Ray {
    var offset = view.raster_offset;
    if view.has_own_offsets != 0u {
        let bits = hash(pixel.y * view.width + pixel.x);
        offset = vec2f(vec2u(bits, hash(bits)) >> vec2u(8u)) / 16777216.0;
    }
    let across = 2.0 * (f32(pixel.x) + offset.x) / f32(view.width) - 1.0;
    let up = 1.0 - 2.0 * (f32(pixel.y) + offset.y) / f32(view.height);
    return Ray(view.position, normalize(view.forward + view.right * across + view.up * up));
}

fn hit_by_bvh(ray: Ray) -> vec2u {
    let hit = mesh_hit(ray.origin, ray.direction, AnalyticHit(AT_INFINITY, 0u, NO_TRIANGLE));
    return vec2u(bitcast<u32>(hit.t), hit.triangle & NO_HIT);
}

/// Hit of a ray with one triangle of the only mesh.
fn hit_with(triangle: u32, ray: Ray) -> vec2u {
    let instance = mesh_word(mesh_word(2u));
    let surface_offset = mesh_word(instance + 13u);
    let rows = instance_rows(instance);
    let local = mesh_ray((ray.origin - mesh_vector(instance)) * rows, ray.direction * rows, mesh_float(surface_offset + 7u));
    let hit = triangle_hit(surface_offset, mesh_word(surface_offset + 1u), 0u, triangle, local, TriangleHit(AT_INFINITY, NO_HIT));
    return vec2u(bitcast<u32>(hit.t), hit.triangle);
}

/// Depth of the pixel at an offset, at the rim of the picture that of the nearest pixel.
fn depth_beside(pixel: vec2u, x: i32, y: i32) -> f32 {
    let last = vec2i(vec2u(view.width, view.height)) - vec2i(1);
    return textureLoad(depths, clamp(vec2i(pixel) + vec2i(x, y), vec2i(0), last), 0);
}

/// Hit of the pixel's ray with the triangle of its id, if no edge is near; else that of the hierarchy.
fn hit_by_ids(pixel: vec2u) -> vec2u {
    let depth = depth_beside(pixel, 0, 0);
    let a = vec4f(depth_beside(pixel, -1, -1), depth_beside(pixel, 0, -1), depth_beside(pixel, 1, -1), depth_beside(pixel, -1, 0));
    let b = vec4f(depth_beside(pixel, 1, 1), depth_beside(pixel, 0, 1), depth_beside(pixel, -1, 1), depth_beside(pixel, 1, 0));
    if depth == 0.0 && all(a + b == vec4f(0.0)) {
        return vec2u(bitcast<u32>(AT_INFINITY), NO_HIT);
    }
    let ray = camera_ray(pixel);
    // The reciprocal of distance is linear on planes.
    if all(abs(a + b - 2.0 * depth) <= vec4f(view.max_bend * depth)) {
        let hit = hit_with(textureLoad(triangle_ids, pixel, 0).x - 1u, ray);
        if hit.y != NO_HIT {
            return hit;
        }
    }
    return hit_by_bvh(ray) | vec2u(0u, FALLBACK);
}

@compute @workgroup_size(8, 8)
fn by_bvh(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = pixel_of(group.xy, lane);
    if pixel.x < view.width && pixel.y < view.height {
        hits[pixel.y * view.width + pixel.x] = hit_by_bvh(camera_ray(pixel));
    }
}

@compute @workgroup_size(8, 8)
fn by_ids(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = pixel_of(group.xy, lane);
    if pixel.x < view.width && pixel.y < view.height {
        hits[pixel.y * view.width + pixel.x] = hit_by_ids(pixel);
    }
}
