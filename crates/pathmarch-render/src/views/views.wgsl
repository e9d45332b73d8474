// import: intersect/march, march_stats, sampler, shading/surface_interaction, textures
// Views of the first hit of camera rays. Twin of views/mod.rs, which explains them.

/// Number of the table of a view.
fn view_number(k: u32) -> f32 {
    return bitcast<f32>(scene_data[MODE_DATA + k]);
}

fn view_colour(k: u32) -> vec3f {
    return vec3f(view_number(3u * k), view_number(3u * k + 1u), view_number(3u * k + 2u));
}

/// Linear light of these sRGB codes.
fn light_of_code(code: vec3f) -> vec3f {
    let bright = pow((code + vec3f(0.055)) / 1.055, vec3f(2.4));
    return select(bright, code / 12.92, code <= vec3f(0.04045));
}

/// Value of one sample of a pixel, for the film.
fn estimate(ray: Ray, sampler: PixelSampler) -> vec3f {
    let hit = march(ray, 0.0, AT_INFINITY);
    if VIEW == VIEW_STEPS {
        return view_colour(steps);
    }
    if VIEW == VIEW_VIOLATIONS {
        let place = clamp(round(steepest * VIOLATIONS_UNIT), 0.0, VIOLATIONS);
        return select(vec3f(0.0), view_colour(u32(place)), steps > 0u);
    }
    if hit.t < 0.0 {
        return vec3f(0.0);
    }
    let at = surface_interaction(ray, hit, unstratified_seed(sampler, 0u));
    if VIEW == VIEW_NORMAL {
        return light_of_code(vec3f(0.5) + 0.5 * at.normal);
    }
    if VIEW == VIEW_DEPTH {
        let beyond = max(dot(at.p - frame.position, frame.forward) - view_number(0u), 0.0) / view_number(1u);
        return light_of_code(vec3f(1.0 / (1.0 + beyond * beyond)));
    }
    var shown = view_colour(at.leaf);
    if HAS_TEXTURES {
        evaluate_textures(leaves[at.leaf].material, at.leaf, at.p, outward_normal(at), hit.t);
        shown = select(shown, textured_albedo.xyz, textured_albedo.w > 0.0);
    }
    let dark = VIEW == VIEW_ALBEDO && (materials[leaves[at.leaf].material].flags & EMITS) != 0u && !emits_towards(at.leaf, at.normal);
    return select(shown, vec3f(0.0), dark);
}
