// Guides in memory: twelve 32-bit words for each pixel. Twin of `Guide` in guides.rs.

/// Bit of a glossy surface beside the index of its object.
const GLOSSY_BIT = 0x20000000u;
/// Bit of mixed surfaces beside the index of the object that is seen.
const MIXED_BIT = 0x80000000u;
/// First bit of the class of a guide beside the index of its object.
const CLASS_SHIFT = 30u;

/// Guide of a pixel.
struct Guide {
    /// Position in world space, or that of the mirror image; far away for the sky.
    position: vec3f,
    /// Mean square of the luminance of the samples, each divided by its albedo.
    square: f32,
    /// Unit normal on the side of the camera, mirrored as the position is.
    normal: vec3f,
    /// Unit normal of the surface that is seen through glass; elsewhere the normal itself.
    seen_normal: vec3f,
    /// Class, see guides.rs.
    guide_class: u32,
    /// Albedo times the reflectance of mirrors; the radiance of an emitter; 1 for the sky and for glass. Mean over the samples.
    albedo: vec3f,
    /// Index of the object. The kernel writes the index of the leaf, which the first pass replaces.
    object: u32,
    /// The same of what is seen through glass; elsewhere the object itself.
    seen_object: u32,
    /// Index of the leaf of `position`; `NO_LEAF` for the sky and for mirror images.
    leaf: u32,
    is_glossy: bool,
    /// True if the samples show several surfaces.
    is_mixed: bool,
}

/// Unit vector in two numbers from -1 to 1: an octahedral map (Meyer et al. 2010).
fn octahedral(v: vec3f) -> vec2f {
    let flat = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    let folded = (1.0 - abs(flat.yx)) * select(vec2f(-1.0), vec2f(1.0), flat >= vec2f(0.0));
    return select(flat, folded, v.z < 0.0);
}

/// Inverse of `octahedral`.
fn from_octahedral(flat: vec2f) -> vec3f {
    let z = 1.0 - abs(flat.x) - abs(flat.y);
    let overhang = max(-z, 0.0);
    return normalize(vec3f(flat - select(vec2f(-overhang), vec2f(overhang), flat >= vec2f(0.0)), z));
}

fn packed_guide(guide: Guide) -> array<vec4u, 3> {
    let albedo = bitcast<vec3u>(guide.albedo);
    return array<vec4u, 3>(
        bitcast<vec4u>(vec4f(guide.position, guide.square)),
        vec4u(pack2x16snorm(octahedral(guide.normal)), pack2x16snorm(octahedral(guide.seen_normal)), albedo.xy),
        vec4u(
            guide.object | select(0u, GLOSSY_BIT, guide.is_glossy) | (guide.guide_class << CLASS_SHIFT),
            guide.seen_object | select(0u, MIXED_BIT, guide.is_mixed),
            guide.leaf,
            albedo.z,
        ),
    );
}

fn unpacked_guide(words: array<vec4u, 3>) -> Guide {
    let place = bitcast<vec4f>(words[0]);
    var guide: Guide;
    guide.position = place.xyz;
    guide.square = place.w;
    guide.normal = from_octahedral(unpack2x16snorm(words[1].x));
    guide.seen_normal = from_octahedral(unpack2x16snorm(words[1].y));
    guide.albedo = bitcast<vec3f>(vec3u(words[1].zw, words[2].w));
    guide.guide_class = words[2].x >> CLASS_SHIFT;
    guide.is_glossy = (words[2].x & GLOSSY_BIT) != 0u;
    guide.object = words[2].x & (GLOSSY_BIT - 1u);
    guide.seen_object = words[2].y & (MIXED_BIT - 1u);
    guide.is_mixed = (words[2].y & MIXED_BIT) != 0u;
    guide.leaf = words[2].z;
    return guide;
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
