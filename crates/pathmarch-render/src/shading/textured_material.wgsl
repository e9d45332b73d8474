// import: mesh_uvs, shading/surface_interaction, texture_target
// Textured materials. Twin of textured_point.rs, which explains them. Each mode implements `apply_layer`.

/// Gradient of the bump map in world space, metres per metre.
var<private> bump_gradient: vec3f;

/// Normal in tangent space of the normal map at the interaction that was evaluated last; zero without one.
var<private> map_normal: vec3f;
/// Tangent in world space, of any length, and sign of the bitangent.
var<private> map_tangent: vec4f;
/// The interaction in the coordinates of the scene, for decals that are placed there.
var<private> world_spot: Spot;
/// Emitted radiance at the interaction that was evaluated last, if a texture varies it.
var<private> textured_emission: vec3f;

/// Emitted radiance of material `m` at the interaction that was evaluated last.
fn emission_at(m: u32) -> vec3f {
    if HAS_EMISSION_TEXTURES {
        let material = scene_word(TEXTURE_DATA + LEAF_WORDS * LEAF_COUNT + m);
        if material != 0u && scene_word(material + 3u) != 0u {
            return textured_emission;
        }
    }
    return material_at(m).emission;
}

/// Emitted radiance of a leaf at a point of one of its triangles, in the mesh's coordinates.
fn emission_on_mesh(leaf: u32, triangle: u32, local: vec3f) -> vec3f {
    if HAS_EMISSION_TEXTURES {
        let material = scene_word(TEXTURE_DATA + LEAF_WORDS * LEAF_COUNT + leaf_at(leaf).material);
        if material != 0u && scene_word(material + 3u) != 0u {
            let texture = scene_word(scene_word(material + 3u));
            begin_uvs(leaf, triangle, local);
            return uv_picture(texture, texture_picture(texture), 0.0).xyz;
        }
    }
    return material_at(leaf_at(leaf).material).emission;
}

/// Float at an offset in the scene data.
fn texture_number(index: u32) -> f32 {
    return bitcast<f32>(scene_word(index));
}

/// Three floats at an offset in the scene data.
fn texture_vector(index: u32) -> vec3f {
    return vec3f(texture_number(index), texture_number(index + 1u), texture_number(index + 2u));
}

/// Coordinates of `p` in the space of a leaf.
fn leaf_coordinates(leaf: u32, p: vec3f) -> Coordinates {
    let leaf_offset = TEXTURE_DATA + LEAF_WORDS * leaf;
    let outer = modifier_coordinates(scene_word(leaf_offset + 12u), p);
    let x = texture_vector(leaf_offset + 3u);
    let y = texture_vector(leaf_offset + 6u);
    let z = texture_vector(leaf_offset + 9u);
    let offset = outer.p - texture_vector(leaf_offset);
    return coordinates_inside(outer, vec3f(dot(x, offset), dot(y, offset), dot(z, offset)), x, y, z);
}

/// Picture of the texture at this offset.
fn texture_picture(texture: u32) -> TexturePicture {
    let at = texture + TEXTURE_PARAMETERS;
    return TexturePicture(scene_word(at), scene_word(at + 1u), scene_word(at + 2u), scene_word(at + 3u), scene_word(at + 5u) != 0u);
}

/// Colour (xyz) and value (w) of the texture at offset `texture_offset`; of a decal, colour times alpha and alpha. The value
/// of an orbit trap is below 0 on a shape without orbit.
fn texture_at(texture_offset: u32, leaf: u32, spot_of_leaf: Spot) -> vec4f {
    let kind = scene_word(texture_offset);
    var leaf_spot = spot_of_leaf;
    if HAS_DECALS && kind == WORLD_DECAL_SOURCE {
        leaf_spot = world_spot;
    }
    if HAS_ORBITS && kind == ORBIT_SOURCE {
        if !has_orbit(leaf) {
            return vec4f(0.0, 0.0, 0.0, -1.0);
        }
        var values = orbit(leaf, leaf_spot.p, texture_vector(texture_offset + TEXTURE_PARAMETERS + 3u));
        let range_start = texture_number(texture_offset + TEXTURE_PARAMETERS + 1u);
        let to = texture_number(texture_offset + TEXTURE_PARAMETERS + 2u);
        let range = select(to - range_start, 1e-20, to == range_start);
        return vec4f(clamp((values[scene_word(texture_offset + TEXTURE_PARAMETERS)] - range_start) / range, 0.0, 1.0));
    }
    let x = texture_vector(texture_offset + TEXTURE_ROWS);
    let y = texture_vector(texture_offset + TEXTURE_ROWS + 3u);
    let z = texture_vector(texture_offset + TEXTURE_ROWS + 6u);
    let scale = texture_number(texture_offset + TEXTURE_SCALE);
    let offset = leaf_spot.p - texture_vector(texture_offset + TEXTURE_POSITION);
    let n = leaf_spot.normal;
    let p = vec3f(dot(x, offset), dot(y, offset), dot(z, offset));
    let spot = Spot(p, vec3f(dot(x, n), dot(y, n), dot(z, n)) * scale, leaf_spot.footprint / scale);
    if HAS_PICTURES && (kind == PICTURE_SOURCE || kind == UV_PICTURE_SOURCE) {
        let picture = texture_picture(texture_offset);
        if kind == UV_PICTURE_SOURCE {
            return uv_picture(texture_offset, picture, leaf_spot.footprint);
        }
        let colour = picture_projected(picture, spot, texture_number(texture_offset + TEXTURE_PARAMETERS + 4u));
        return vec4f(colour, clamp(dot(colour, vec3f(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
    }
    if HAS_DECALS && (kind == DECAL_SOURCE || kind == WORLD_DECAL_SOURCE) {
        let at = texture_offset + TEXTURE_PARAMETERS;
        let picture = TexturePicture(scene_word(at), scene_word(at + 1u), scene_word(at + 2u), scene_word(at + 3u), true);
        let depth = texture_number(at + 5u);
        return decal_at(picture, spot, texture_number(at + 4u), depth, texture_number(at + 6u), texture_number(at + 7u));
    }
    var parameters: array<f32, 8>;
    for (var k = 0u; k < 8u; k++) {
        parameters[k] = texture_number(texture_offset + TEXTURE_PARAMETERS + k);
    }
    let value = computed_texture(kind, spot, parameters);
    // NaN becomes 0.
    return vec4f(select(0.0, min(value, 1.0), value > 0.0));
}

/// Colour of a layer over the colour `below`, from the colour and value of its texture.
fn layer_colour(layer: u32, texel: vec4f, below: vec3f) -> vec3f {
    let kind = scene_word(layer + LAYER_KIND);
    if kind == OWN_COLOURS_LAYER {
        return texel.xyz;
    }
    if HAS_DECALS && kind == DECAL_LAYER {
        return below * (1.0 - texel.w) + texel.xyz;
    }
    let last = scene_word(layer + LAYER_CONTENTS);
    if kind == POSITIONED_RAMP_LAYER {
        return positioned_colour(layer + LAYER_CONTENTS + 1u, last, texel.w);
    }
    let position = texel.w * f32(last);
    let first = min(u32(position), max(last, 1u) - 1u);
    let a = texture_vector(layer + LAYER_CONTENTS + 1u + 3u * first);
    let b = texture_vector(layer + LAYER_CONTENTS + 1u + 3u * min(first + 1u, last));
    return a + (b - a) * (position - f32(first));
}

/// Colour of a value on a ramp of `last` + 1 colours, which start at `colours`, with their positions after them.
fn positioned_colour(colours: u32, last: u32, value: f32) -> vec3f {
    let positions = colours + 3u * (last + 1u);
    var above = 0u;
    while above <= last && texture_number(positions + above) <= value {
        above++;
    }
    if above == 0u || above > last {
        return texture_vector(colours + 3u * min(above, last));
    }
    let start = texture_number(positions + above - 1u);
    let part = (value - start) / (texture_number(positions + above) - start);
    let a = texture_vector(colours + 3u * (above - 1u));
    return a + (texture_vector(colours + 3u * above) - a) * part;
}

/// Evaluates the textures of material `m` at an interaction, at the end of a path of this length.
fn evaluate_textures(m: u32, interaction: SurfaceInteraction, path_length: f32) {
    let leaf = interaction.leaf;
    let outward = outward_normal(interaction);
    bump_gradient = vec3f(0.0);
    map_normal = vec3f(0.0);
    begin_textures(m);
    let material = scene_word(TEXTURE_DATA + LEAF_WORDS * LEAF_COUNT + m);
    if material == 0u {
        return;
    }
    let coordinates = leaf_coordinates(leaf, interaction.p);
    begin_uvs(leaf, interaction.triangle, coordinates.p);
    let cofactors = mat3x3f(cross(coordinates.y, coordinates.z), cross(coordinates.z, coordinates.x), cross(coordinates.x, coordinates.y));
    let determinant = dot(coordinates.x, cofactors[0]);
    let unit_length = pow(max(abs(determinant), 1e-30), -1.0 / 3.0);
    let local_normal = (outward * cofactors) * select(1.0, -1.0, determinant < 0.0);
    let normal = select(vec3f(0.0, 1.0, 0.0), normalize(local_normal), dot(local_normal, local_normal) > 0.0);
    let spot = Spot(coordinates.p, normal, frame.pixel * path_length / unit_length);
    if HAS_DECALS {
        world_spot = Spot(interaction.p, outward, frame.pixel * path_length);
    }
    let layers = scene_word(material);
    let bump = scene_word(material + 1u);
    var step = 1.0;
    if HAS_BUMP && bump != 0u {
        let texture = scene_word(bump);
        step = max(texture_number(texture + TEXTURE_STEP) * texture_number(texture + TEXTURE_SCALE), 0.5 * spot.footprint);
    }
    var normal_map = 0u;
    var emission = 0u;
    if HAS_NORMAL_MAPS {
        normal_map = scene_word(material + 2u);
    }
    if HAS_EMISSION_TEXTURES {
        emission = scene_word(material + 3u);
    }
    var heights = vec4f(0.0);
    // The bump map is evaluated at four points. A single loop keeps one copy of the code of every texture in the
    // kernel.
    let bump_end = layers + select(0u, 4u, HAS_BUMP && bump != 0u);
    let map_end = bump_end + select(0u, 1u, normal_map != 0u);
    for (var k = 0u; k < map_end + select(0u, 1u, emission != 0u); k++) {
        var sample_spot = spot;
        var layer = select(bump, scene_word(material + 4u + min(k, max(layers, 1u) - 1u)), k < layers);
        if k > layers && k < bump_end {
            sample_spot.p += step * vec3f(f32(k == layers + 1u), f32(k == layers + 2u), f32(k == layers + 3u));
        }
        if k >= bump_end {
            layer = select(emission, normal_map, k < map_end);
        }
        let texel = texture_at(scene_word(layer), leaf, sample_spot);
        if k >= map_end {
            textured_emission = texel.xyz;
        } else if k >= bump_end {
            let v = texel.xyz * 2.0 - 1.0;
            let scale = texture_number(normal_map + 1u);
            map_normal = vec3f(v.xy * scale, max(v.z, 1e-3));
        } else if k >= layers {
            heights[k - layers] = texel.w;
        } else if texel.w >= 0.0 {
            apply_layer(layer, texel);
        }
    }
    if HAS_NORMAL_MAPS && normal_map != 0u {
        let local = uv_tangent();
        map_tangent = vec4f(mat3x3f(coordinates.x, coordinates.y, coordinates.z) * local.xyz, local.w);
    }
    if HAS_BUMP && bump != 0u {
        let local_gradient = (heights.yzw - heights.x) * (texture_number(bump + 1u) / step);
        bump_gradient = mat3x3f(coordinates.x, coordinates.y, coordinates.z) * local_gradient * unit_length;
    }
}

/// Normal `outward`, replaced by that of the normal map, after `evaluate_textures`.
fn mapped_normal(outward: vec3f) -> vec3f {
    if !HAS_NORMAL_MAPS || all(map_normal == vec3f(0.0)) {
        return outward;
    }
    let tangent = map_tangent.xyz - outward * dot(outward, map_tangent.xyz);
    // Without texture coordinates there is no tangent.
    if dot(tangent, tangent) <= 1e-12 * dot(map_tangent.xyz, map_tangent.xyz) {
        return outward;
    }
    let t = normalize(tangent);
    let b = cross(outward, t) * select(1.0, -1.0, map_tangent.w < 0.0);
    return normalize(t * map_normal.x + b * map_normal.y + outward * map_normal.z);
}

/// Normal `smooth_normal`, replaced by the normal map and bent by the bump map, after `evaluate_textures`.
fn bumped_normal(smooth_normal: vec3f) -> vec3f {
    let outward = mapped_normal(smooth_normal);
    if !HAS_BUMP || all(bump_gradient == vec3f(0.0)) {
        return outward;
    }
    return normalize(outward - (bump_gradient - outward * dot(outward, bump_gradient)));
}
