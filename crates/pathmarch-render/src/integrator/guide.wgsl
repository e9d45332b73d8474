// import: integrator/first_mirror
// Guides in memory: sixteen 32-bit words for each pixel. Twin of `Guide` in guides.rs.

/// Bits of the index of an object. All are set for the sky, unless a mirror shows it.
const OBJECT_BITS = 0x1fffffffu;
/// Bit of a glossy surface beside the index of its object.
const GLOSSY_BIT = 0x20000000u;
/// Bit of mixed surfaces beside the index of the object that is seen.
const MIXED_BIT = 0x80000000u;
/// First bit of the class of a guide beside the index of its object.
const CLASS_SHIFT = 30u;

/// Bit of facets that reflect in the colour of the surface, beside it.
const COLOURED_BIT = 0x40000000u;

/// Guide of a pixel.
struct Guide {
    /// Position in world space, or that of the mirror image; far away for the sky.
    position: vec3f,
    /// Mean square of the luminance of the samples, each divided by its albedo.
    square: f32,
    /// Unit normal on the side of the camera, mirrored as the position is. For the sky, the negative of the direction in which
    /// the last segment of the path leaves the scene.
    normal: vec3f,
    /// Unit normal of the surface that is seen through glass; elsewhere the normal itself.
    seen_normal: vec3f,
    /// Class, see guides.rs.
    guide_class: u32,
    /// Albedo times the reflectance of mirrors; the radiance of an emitter; 1 for the sky and for glass. Mean over the samples.
    albedo: vec3f,
    /// Index of the object, see guides.rs. The kernel writes the index of the leaf, which the first pass replaces.
    object: u32,
    /// The same of what is seen through glass; elsewhere the object itself.
    seen_object: u32,
    /// Index of the leaf of `position`; `NO_LEAF` for the sky and for mirror images.
    leaf: u32,
    /// Word of the mirror in front of the surface, see first_mirror.rs.
    mirror: u32,
    is_glossy: bool,
    /// True if the samples show several surfaces.
    is_mixed: bool,
    /// Light that the facets of a glossy surface reflect, see reflected_light.rs.
    reflected: vec3f,
    reflected_square: f32,
    depth: f32,
    alpha: f32,
    has_coloured_facets: bool,
    /// Light that other surfaces have scattered to one that scatters light, without that of facets; 0 elsewhere, and on
    /// fractals.
    indirect: vec3f,
}

/// Numbers from 0 to 1 of the facets of a guide in one word: the depth and the squared mean over the mean square in 12 bits
/// each, the root of alpha in 8, which is 0 only without facets.
fn packed_facets(guide: Guide) -> u32 {
    let mean = luminance(guide.reflected / reflection_divisor(guide));
    let ratio = select(1.0, clamp(mean * mean / guide.reflected_square, 0.0, 1.0), guide.reflected_square > 0.0);
    let numbers = vec2u(vec2f(guide.depth, ratio) * 4095.0 + 0.5);
    let roughness = select(0u, max(u32(sqrt(guide.alpha) * 255.0 + 0.5), 1u), guide.alpha > 0.0);
    return numbers.x | (numbers.y << 12u) | (roughness << 24u);
}

/// Depth in packed facets.
fn depth_of_facets(facets: u32) -> f32 {
    return f32(facets & 4095u) / 4095.0;
}

/// Exponent of light in one word: its largest channel is below two to this power.
fn packed_exponent(light: vec3f) -> i32 {
    let largest = clamp(max(max(light.r, light.g), light.b), 0.0, MAX_PACKED_LIGHT);
    return clamp(i32(bitcast<u32>(largest) >> 23u) - 126, -15, 16);
}

/// Difference between neighbouring numbers of a word of light.
fn packed_step(light: vec3f) -> f32 {
    return power_of_two(packed_exponent(light) - 9);
}

/// Light in one word: nine bits for each channel and a common exponent. Twin of `rounded` in guides.rs.
fn packed_light(light: vec3f) -> u32 {
    let kept = clamp(light, vec3f(0.0), vec3f(MAX_PACKED_LIGHT));
    let exponent = packed_exponent(light);
    let channels = vec3u(kept * power_of_two(9 - exponent));
    return channels.r | (channels.g << 9u) | (channels.b << 18u) | (u32(exponent + 15) << 27u);
}

/// Inverse of `packed_light`.
fn unpacked_light(word: u32) -> vec3f {
    let channels = vec3f(vec3u(word, word >> 9u, word >> 18u) & vec3u(511u));
    return channels * power_of_two(i32(word >> 27u) - 24);
}

fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

/// A surface that scatters light is not seen through another: its indirect light takes the place of the seen normal.
fn packed_guide(guide: Guide) -> array<vec4u, 4> {
    let albedo = bitcast<vec3u>(guide.albedo);
    let seen_normal = pack2x16snorm(octahedral(guide.seen_normal));
    let seen = select(seen_normal, packed_light(guide.indirect), guide.guide_class == GUIDE_SURFACE);
    return array<vec4u, 4>(
        bitcast<vec4u>(vec4f(guide.position, guide.square)),
        vec4u(pack2x16snorm(octahedral(guide.normal)), seen, albedo.xy),
        vec4u(
            guide.object | select(0u, GLOSSY_BIT, guide.is_glossy) | (guide.guide_class << CLASS_SHIFT),
            guide.seen_object | select(0u, MIXED_BIT, guide.is_mixed) | select(0u, COLOURED_BIT, guide.has_coloured_facets),
            select(guide.leaf, guide.mirror, guide.leaf == NO_LEAF),
            albedo.z,
        ),
        vec4u(bitcast<vec3u>(guide.reflected), packed_facets(guide)),
    );
}

fn unpacked_guide(words: array<vec4u, 4>) -> Guide {
    let place = bitcast<vec4f>(words[0]);
    var guide: Guide;
    guide.position = place.xyz;
    guide.square = place.w;
    guide.normal = from_octahedral(unpack2x16snorm(words[1].x));
    guide.albedo = bitcast<vec3f>(vec3u(words[1].zw, words[2].w));
    guide.guide_class = words[2].x >> CLASS_SHIFT;
    let is_surface = guide.guide_class == GUIDE_SURFACE;
    guide.seen_normal = select(from_octahedral(unpack2x16snorm(words[1].y)), guide.normal, is_surface);
    guide.indirect = select(vec3f(0.0), unpacked_light(words[1].y), is_surface);
    guide.is_glossy = (words[2].x & GLOSSY_BIT) != 0u;
    guide.object = words[2].x & OBJECT_BITS;
    guide.seen_object = words[2].y & (COLOURED_BIT - 1u);
    guide.is_mixed = (words[2].y & MIXED_BIT) != 0u;
    let has_leaf = (words[2].z & MIRROR_BIT) == 0u;
    guide.leaf = select(NO_LEAF, words[2].z, has_leaf);
    guide.mirror = select(words[2].z, MIRROR_BIT, has_leaf);
    guide.has_coloured_facets = (words[2].y & COLOURED_BIT) != 0u;
    guide.reflected = bitcast<vec3f>(words[3].xyz);
    let facets = words[3].w;
    guide.depth = depth_of_facets(facets);
    let roughness = f32(facets >> 24u) / 255.0;
    guide.alpha = roughness * roughness;
    let mean = luminance(guide.reflected / reflection_divisor(guide));
    guide.reflected_square = mean * mean * 4095.0 / max(f32((facets >> 12u) & 4095u), 1.0);
    return guide;
}

/// True if the camera sees an emitter itself, not its mirror image.
fn is_seen_emitter(guide: Guide) -> bool {
    return guide.guide_class == GUIDE_EMITTER && guide.leaf != NO_LEAF;
}

/// True if the largest difference between the channels of two colours, in their largest channel, is above this contrast.
fn colours_differ(a: vec3f, b: vec3f, contrast: f32) -> bool {
    let apart = abs(a - b);
    let larger = max(a, b);
    return max(max(apart.x, apart.y), apart.z) > contrast * max(max(larger.x, larger.y), larger.z);
}

/// Luminance of a linear Rec. 709 colour.
fn luminance(colour: vec3f) -> f32 {
    return dot(colour, vec3f(0.2126, 0.7152, 0.0722));
}

/// Factor between radiance and irradiance.
fn divisor(guide: Guide) -> vec3f {
    let is_divided = guide.guide_class == GUIDE_EMITTER || guide.guide_class == GUIDE_SURFACE;
    return select(vec3f(1.0), max(guide.albedo, vec3f(MIN_ALBEDO)), is_divided);
}

/// Factor between the radiance that facets reflect and what is filtered.
fn reflection_divisor(guide: Guide) -> vec3f {
    return select(vec3f(1.0), divisor(guide), guide.has_coloured_facets);
}
