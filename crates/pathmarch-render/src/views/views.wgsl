// import: intersect/march, march_stats, sampler, shading/surface_interaction, textures
// Views: attributes of the first hit of camera rays. Twin of views/mod.rs, which explains them.

/// Number of the lookup table of the view.
fn view_number(k: u32) -> f32 {
    return bitcast<f32>(scene_word(MODE_DATA + k));
}

/// Colour of the lookup table of the view.
fn view_colour(k: u32) -> vec3f {
    return vec3f(view_number(3u * k), view_number(3u * k + 1u), view_number(3u * k + 2u));
}

/// Decodes sRGB codes to linear light.
fn srgb_decode(code: vec3f) -> vec3f {
    let bright = pow((code + vec3f(0.055)) / 1.055, vec3f(2.4));
    return select(bright, code / 12.92, code <= vec3f(0.04045));
}

/// Film value of one sample of a pixel.
fn estimate(ray: Ray, sampler: PixelSampler) -> vec3f {
    let hit = march(ray, 0.0, AT_INFINITY);
    if VIEW == VIEW_STEPS {
        return view_colour(steps);
    }
    if VIEW == VIEW_VIOLATIONS {
        let index = clamp(round(steepest * VIOLATION_SCALE), 0.0, MAX_VIOLATION);
        return select(vec3f(0.0), view_colour(u32(index)), steps > 0u);
    }
    if hit.t < 0.0 {
        return vec3f(0.0);
    }
    let interaction = surface_interaction(ray, hit, unstratified_seed(sampler, 0u));
    if VIEW == VIEW_NORMAL {
        return srgb_decode(vec3f(0.5) + 0.5 * interaction.normal);
    }
    if VIEW == VIEW_DEPTH {
        let beyond = max(dot(interaction.p - frame.position, frame.forward) - view_number(0u), 0.0) / view_number(1u);
        return srgb_decode(vec3f(1.0 / (1.0 + beyond * beyond)));
    }
    var colour = view_colour(interaction.leaf);
    if HAS_TEXTURES {
        evaluate_textures(leaf_at(interaction.leaf).material, interaction, hit.t);
        colour = select(colour, textured_albedo.xyz, textured_albedo.w > 0.0);
    }
    let is_dark_side = VIEW == VIEW_ALBEDO && (material_at(leaf_at(interaction.leaf).material).flags & EMITS) != 0u && !emits_towards(interaction.leaf, interaction.normal);
    return select(colour, vec3f(0.0), is_dark_side);
}
