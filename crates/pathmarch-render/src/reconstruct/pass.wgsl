// import: integrator/guide, integrator/medium_light
// Buffers of all passes, and what they share. Twin of mod.rs and of the geometry in temporal.rs.

@group(0) @binding(0) var<storage, read> uniforms: PassUniforms;
/// Sums of radiance in xyz; w counts rejected samples.
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> guides: array<vec4u>;
@group(0) @binding(3) var<storage, read> past_guides: array<vec4u>;
@group(0) @binding(4) var<storage, read> leaf_motions: array<LeafMotion>;
@group(0) @binding(5) var<storage, read_write> history: array<History>;
@group(0) @binding(6) var<storage, read> past_history: array<History>;
/// Irradiance, and the variance of its luminance or another number. Passes read one and write the other.
@group(0) @binding(7) var<storage, read_write> estimates: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> next_estimates: array<vec4f>;
@group(0) @binding(9) var<storage, read> past_colours: array<vec4f>;
@group(0) @binding(10) var<storage, read_write> colours: array<vec4f>;
@group(0) @binding(11) var<storage, read_write> screen: array<u32>;
/// Position of the point of each pixel in the earlier scene, and its normal in the last word.
@group(0) @binding(12) var<storage, read_write> earlier_points: array<vec4u>;

/// Filtered irradiance without the light of facets.
@group(0) @binding(14) var<storage, read> base: array<vec4f>;
/// Images of what the facets of each pixel mirror: depth and reach, see reflections.rs, and the least and largest plausible
/// luminance.
@group(0) @binding(15) var<storage, read_write> images: array<vec4f>;

/// Coverages of the pixels of the picture by emitters, see `Coverage` in emitter_coverage.rs.
@group(0) @binding(16) var<storage, read> coverages: array<vec4f>;

/// Albedos of the pixels of the picture, with 1 in w where they are not those of the guides, see pixel_albedo.rs.
@group(0) @binding(20) var<storage, read> albedos: array<vec4f>;

/// Mean of a pixel.
struct History {
    irradiance: vec3f,
    /// Number of samples in the mean.
    length: f32,
    /// Means of the luminance and of its square, over samples.
    moments: vec2f,
    /// Position of the pixel's point in the last picture, pixels of its samples; negative where it was hidden.
    before: vec2f,
}

/// True if the light of facets of the surface is recorded apart.
fn has_facets(guide: Guide) -> bool {
    return guide.alpha > 0.0 && !has_medium(guide);
}

/// True if the light of media in front of the surface is recorded apart.
fn has_medium(guide: Guide) -> bool {
    return guide.alpha == MEDIUM_ALPHA;
}

fn guide_at(pixel: u32) -> Guide {
    let first = 4u * pixel;
    return unpacked_guide(array<vec4u, 4>(guides[first], guides[first + 1u], guides[first + 2u], guides[first + 3u]));
}

fn past_guide_at(pixel: u32) -> Guide {
    let first = 4u * pixel;
    return unpacked_guide(
        array<vec4u, 4>(past_guides[first], past_guides[first + 1u], past_guides[first + 2u], past_guides[first + 3u]),
    );
}

/// Mean of the samples of a pixel of the film.
fn film_mean(position: vec2u, pixel: u32) -> vec3f {
    let sum = film[pixel];
    let has_more = position.y < uniforms.row || (position.y < uniforms.row + 8u && position.x < uniforms.column);
    let samples = f32(uniforms.samples + select(0u, uniforms.begun, has_more)) - sum.w;
    return sum.xyz / max(samples, 1.0);
}

/// True if the picture is larger than its samples.
fn is_enlarged() -> bool {
    return uniforms.shown_width != uniforms.width || uniforms.shown_height != uniforms.height;
}

/// True if a position is inside the picture of the samples.
fn is_inside(position: vec2i) -> bool {
    return all(position >= vec2i(0)) && all(position < vec2i(i32(uniforms.width), i32(uniforms.height)));
}

fn pixel_index(position: vec2i) -> u32 {
    return u32(position.y) * uniforms.width + u32(position.x);
}

/// Position of a point in the picture of the samples, in pixels from its top left corner; negative behind the camera.
fn project(point: vec3f) -> vec2f {
    let size = vec2f(f32(uniforms.width), f32(uniforms.height));
    return projection(point - uniforms.position, uniforms.right, uniforms.up, uniforms.forward, size);
}

/// The same in the last picture.
fn project_before(point: vec3f) -> vec2f {
    let size = vec2f(f32(uniforms.past_width), f32(uniforms.past_height));
    return projection(
        point - uniforms.past_position,
        uniforms.past_right,
        uniforms.past_up,
        uniforms.past_forward,
        size,
    );
}

fn projection(v: vec3f, right: vec3f, up: vec3f, forward: vec3f, size: vec2f) -> vec2f {
    let depth = dot(v, forward);
    if depth <= 1e-6 * length(v) {
        return vec2f(-1e9);
    }
    let across = dot(v, right) / (dot(right, right) * depth);
    let upwards = dot(v, up) / (dot(up, up) * depth);
    return 0.5 * vec2f(across + 1.0, 1.0 - upwards) * size;
}

/// The guide of a pixel at its point in the earlier scene.
fn earlier(guide: Guide, pixel: u32) -> Guide {
    var moved = guide;
    let point = earlier_points[pixel];
    moved.position = bitcast<vec3f>(point.xyz);
    moved.normal = from_octahedral(unpack2x16snorm(point.w));
    return moved;
}

/// Point on a surface.
struct SurfacePoint {
    position: vec3f,
    normal: vec3f,
}

/// Words of the point of a pixel in the earlier scene.
fn earlier_words(point: SurfacePoint) -> vec4u {
    return vec4u(bitcast<vec3u>(point.position), pack2x16snorm(octahedral(point.normal)));
}

/// Point of a guide where its object was in the earlier scene.
fn moved_back(guide: Guide) -> SurfacePoint {
    if guide.leaf == NO_LEAF || leaf_motions[guide.leaf].moves == 0u {
        return SurfacePoint(guide.position, guide.normal);
    }
    let motion = leaf_motions[guide.leaf];
    let rows = mat3x3f(motion.x, motion.y, motion.z);
    let offset = vec3f(motion.offset_x, motion.offset_y, motion.offset_z);
    return SurfacePoint(guide.position * rows * motion.scale + offset, guide.normal * rows);
}

/// True if a guide and one of the last picture show one place of one surface, to within a few sides of a pixel.
fn same_point(a: Guide, b: Guide, pixel: f32) -> bool {
    // A medium in front of a surface takes light from it.
    if a.guide_class != b.guide_class || a.object != b.object || has_medium(a) != has_medium(b) {
        return false;
    }
    if a.guide_class == GUIDE_SKY {
        let turned = a.normal - b.normal;
        let tolerance = POINT_TOLERANCE * max(uniforms.pixel, uniforms.past_pixel);
        return a.object == OBJECT_BITS || dot(turned, turned) <= tolerance * tolerance;
    }
    let apart = a.position - b.position;
    let along = min(abs(dot(a.normal, apart)), abs(dot(b.normal, apart)));
    // Seen at a grazing angle, a pixel covers more of the plane.
    let cosine = abs(dot(b.normal, normalize(b.position - uniforms.past_position)));
    let stretched = pixel * POINT_TOLERANCE / max(cosine, MIN_GRAZING_COSINE);
    return along <= PLANE_TOLERANCE * pixel && dot(apart, apart) <= stretched * stretched
        && dot(a.normal, b.normal) >= MIN_NORMAL_COSINE;
}

/// Normal of the first surface of a pixel.
fn normal_at(pixel: u32) -> vec3f {
    return from_octahedral(unpack2x16snorm(guides[4u * pixel + 1u].x));
}

/// True if two pixels, of which the first has this normal, show one side of an object: if the bits of this mask are equal in the
/// words of their objects.
fn are_one_side(here: u32, normal: vec3f, there: u32, mask: u32) -> bool {
    let objects = (guides[4u * here + 2u].x ^ guides[4u * there + 2u].x) & mask;
    return objects == 0u && dot(normal, normal_at(there)) >= MIN_NORMAL_COSINE;
}

/// Length of the path from the camera to the point of a guide, metres.
fn path_length(guide: Guide) -> f32 {
    return distance(guide.position, uniforms.position);
}

/// Side of a pixel at the distance of a guide, metres: that of the coarser one of both pictures.
fn coarser_pixel(guide: Guide) -> f32 {
    return path_length(guide) * max(uniforms.pixel, uniforms.past_pixel);
}
