// import: texture_target
// Textured materials. Twin of textured_point.rs, which explains them. The mode decides what a layer changes: `apply_layer`.

/// Gradient of the bump map in world space, metres per metre.
var<private> bump_gradient: vec3f;

fn texture_number(at: u32) -> f32 {
    return bitcast<f32>(scene_data[at]);
}

fn texture_vector(at: u32) -> vec3f {
    return vec3f(texture_number(at), texture_number(at + 1u), texture_number(at + 2u));
}

/// Coordinates of `p` in the space of a leaf.
fn leaf_coordinates(leaf: u32, p: vec3f) -> Coordinates {
    let at = TEXTURE_DATA + LEAF_WORDS * leaf;
    let outer = modifier_coordinates(scene_data[at + 12u], p);
    let x = texture_vector(at + 3u);
    let y = texture_vector(at + 6u);
    let z = texture_vector(at + 9u);
    let offset = outer.p - texture_vector(at);
    return coordinates_inside(outer, vec3f(dot(x, offset), dot(y, offset), dot(z, offset)), x, y, z);
}

/// Colour and value of a texture; the value is below 0 where it has none.
fn texture_at(at: u32, leaf: u32, of_shape: Spot) -> vec4f {
    let kind = scene_data[at];
    if HAS_ORBITS && kind == ORBIT_SOURCE {
        if !has_orbit(leaf) {
            return vec4f(0.0, 0.0, 0.0, -1.0);
        }
        var values = orbit(leaf, of_shape.p);
        let from_ = texture_number(at + TEXTURE_PARAMETERS + 1u);
        let to = texture_number(at + TEXTURE_PARAMETERS + 2u);
        let span = select(to - from_, 1e-20, to == from_);
        return vec4f(clamp((values[scene_data[at + TEXTURE_PARAMETERS]] - from_) / span, 0.0, 1.0));
    }
    let x = texture_vector(at + TEXTURE_ROWS);
    let y = texture_vector(at + TEXTURE_ROWS + 3u);
    let z = texture_vector(at + TEXTURE_ROWS + 6u);
    let scale = texture_number(at + TEXTURE_SCALE);
    let offset = of_shape.p - texture_vector(at + TEXTURE_POSITION);
    let n = of_shape.normal;
    let p = vec3f(dot(x, offset), dot(y, offset), dot(z, offset));
    let spot = Spot(p, vec3f(dot(x, n), dot(y, n), dot(z, n)) * scale, of_shape.footprint / scale);
    if HAS_PICTURES && kind == PICTURE_SOURCE {
        let picture = TexturePicture(scene_data[at + TEXTURE_PARAMETERS], scene_data[at + TEXTURE_PARAMETERS + 1u], scene_data[at + TEXTURE_PARAMETERS + 2u], scene_data[at + TEXTURE_PARAMETERS + 3u], scene_data[at + TEXTURE_PARAMETERS + 5u] != 0u);
        let colour = picture_projected(picture, spot, texture_number(at + TEXTURE_PARAMETERS + 4u));
        return vec4f(colour, clamp(dot(colour, vec3f(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
    }
    var parameters: array<f32, 8>;
    for (var k = 0u; k < 8u; k++) {
        parameters[k] = texture_number(at + TEXTURE_PARAMETERS + k);
    }
    let value = computed_texture(kind, spot, parameters);
    // NaN becomes 0.
    return vec4f(select(0.0, min(value, 1.0), value > 0.0));
}

/// Colour of a layer, for the colour and value of its texture.
fn layer_colour(layer: u32, shown: vec4f) -> vec3f {
    if scene_data[layer + LAYER_KIND] == OWN_COLOURS_LAYER {
        return shown.xyz;
    }
    let last = scene_data[layer + LAYER_CONTENTS];
    let place = shown.w * f32(last);
    let first = min(u32(place), max(last, 1u) - 1u);
    let a = texture_vector(layer + LAYER_CONTENTS + 1u + 3u * first);
    let b = texture_vector(layer + LAYER_CONTENTS + 1u + 3u * min(first + 1u, last));
    return a + (b - a) * (place - f32(first));
}

/// Evaluates the textures of material `m` at `p` on a leaf with this outward normal, at the end of a path of this length.
fn evaluate_textures(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) {
    bump_gradient = vec3f(0.0);
    begin_textures(m);
    let material = scene_data[TEXTURE_DATA + LEAF_WORDS * LEAF_COUNT + m];
    if material == 0u {
        return;
    }
    let here = leaf_coordinates(leaf, p);
    let cofactors = mat3x3f(cross(here.y, here.z), cross(here.z, here.x), cross(here.x, here.y));
    let determinant = dot(here.x, cofactors[0]);
    let size = pow(max(abs(determinant), 1e-30), -1.0 / 3.0);
    let across = (outward * cofactors) * select(1.0, -1.0, determinant < 0.0);
    let normal = select(vec3f(0.0, 1.0, 0.0), normalize(across), dot(across, across) > 0.0);
    let spot = Spot(here.p, normal, frame.pixel * path_length / size);
    let layers = scene_data[material];
    let bump = scene_data[material + 1u];
    var step = 1.0;
    if HAS_BUMP && bump != 0u {
        let texture = scene_data[bump];
        step = max(texture_number(texture + TEXTURE_STEP) * texture_number(texture + TEXTURE_SCALE), 0.5 * spot.footprint);
    }
    var heights = vec4f(0.0);
    // The bump map is evaluated at four points. One loop, so that the code of every texture occurs once.
    for (var k = 0u; k < layers + select(0u, 4u, HAS_BUMP && bump != 0u); k++) {
        var looked = spot;
        let layer = select(bump, scene_data[material + 2u + min(k, max(layers, 1u) - 1u)], k < layers);
        if k > layers {
            looked.p += step * vec3f(f32(k == layers + 1u), f32(k == layers + 2u), f32(k == layers + 3u));
        }
        let shown = texture_at(scene_data[layer], leaf, looked);
        if k >= layers {
            heights[k - layers] = shown.w;
        } else if shown.w >= 0.0 {
            apply_layer(layer, shown);
        }
    }
    if HAS_BUMP && bump != 0u {
        let slope = (heights.yzw - heights.x) * (texture_number(bump + 1u) / step);
        bump_gradient = mat3x3f(here.x, here.y, here.z) * slope * size;
    }
}

/// Shading normal on the side of the geometric `normal`, after `evaluate_textures`.
fn shading_normal(outward: vec3f, normal: vec3f, view: vec3f) -> vec3f {
    if !HAS_BUMP || all(bump_gradient == vec3f(0.0)) {
        return normal;
    }
    let along = bump_gradient - outward * dot(outward, bump_gradient);
    let bent = normalize(outward - along) * select(1.0, -1.0, dot(normal, outward) < 0.0);
    let above = max(dot(view, normal), 1e-5);
    let height = dot(bent, normal);
    let sheer = bent - normal * height;
    let tilt = length(sheer);
    if tilt < 1e-6 {
        return normal;
    }
    let aside = sheer / tilt;
    let sideways = dot(view, aside);
    let least = min(0.9 * above, 0.01);
    let steepest = 0.5 * (atan2(sideways, above) + acos(least / length(vec2f(sideways, above))));
    let angle = min(atan2(tilt, height), steepest);
    return normal * cos(angle) + aside * sin(angle);
}
