// import: light_nodes
// Choice of a light by its contribution to a point. Twin of scene/light_tree.rs and of `choose_light` in light_sampling.rs, which
// explain it.

/// Light that the uniform number `choice` chooses for a point, with its probability there. `normal` is the unit normal of a
/// surface that is lit on this side only, or zero. The light has no emission if none contributes.
fn chosen_light(p: vec3f, normal: vec3f, choice: f32) -> Light {
    if choice >= frame.tree_share {
        let cell = (choice - frame.tree_share) / (1.0 - frame.tree_share) * f32(frame.table_lights);
        var index = min(u32(cell), frame.table_lights - 1u);
        if cell - f32(index) >= lights[index].threshold {
            index = lights[index].alias_light;
        }
        return lights[index];
    }
    var random = choice / frame.tree_share;
    var probability = frame.tree_share;
    var node = 0u;
    var first = frame.table_lights;
    var count = frame.light_count - first;
    while count > 1u {
        let halves = light_node(node);
        let share_a = share_of_half_a(halves, p, normal);
        let count_a = u32(halves.count_a);
        if share_a < 0.0 {
            probability = 0.0;
            break;
        }
        if random < share_a {
            random /= share_a;
            probability *= share_a;
            count = count_a;
            node += 1u;
        } else {
            random = (random - share_a) / (1.0 - share_a);
            probability *= 1.0 - share_a;
            first += count_a;
            count -= count_a;
            node += count_a;
        }
        random = min(random, ONE_MINUS_EPSILON);
    }
    return light_with(first, probability);
}

/// Light with the probability that it is chosen for a point.
fn light_from(index: u32, p: vec3f, normal: vec3f) -> Light {
    if index < frame.table_lights {
        return lights[index];
    }
    var probability = frame.tree_share;
    var node = 0u;
    var first = frame.table_lights;
    var count = frame.light_count - first;
    while count > 1u {
        let halves = light_node(node);
        let share_a = share_of_half_a(halves, p, normal);
        let count_a = u32(halves.count_a);
        if share_a < 0.0 {
            probability = 0.0;
            break;
        }
        if index < first + count_a {
            probability *= share_a;
            count = count_a;
            node += 1u;
        } else {
            probability *= 1.0 - share_a;
            first += count_a;
            count -= count_a;
            node += count_a;
        }
    }
    return light_with(index, probability);
}

/// Light with this probability.
fn light_with(index: u32, probability: f32) -> Light {
    var light = lights[index];
    light.pmf = probability;
    light.inverse_pmf = select(0.0, 1.0 / probability, probability > 0.0);
    return light;
}

/// Probability of half `a` of a node; negative if neither half lights the point.
fn share_of_half_a(node: LightNode, p: vec3f, normal: vec3f) -> f32 {
    let a = importance(node.centre_a - p, node.radius_a, node.axis_a, normal);
    let b = importance(node.centre_b - p, node.radius_b, node.axis_b, normal) * node.intensity_ratio;
    return select(-1.0, a / (a + b), a + b > 0.0);
}

/// Estimate of the irradiance by lights of unit intensity in a sphere with its centre at `offset`; zero only if none arrives.
/// `axis` is that of a `LightNode`.
fn importance(offset: vec3f, radius: f32, axis: vec3f, normal: vec3f) -> f32 {
    let square = dot(offset, offset);
    let inverse = 1.0 / sqrt(max(square + SOFTENING * radius * radius, MIN_SQUARE));
    var value = inverse * inverse;
    value *= select(mean_height(dot(normal, offset), radius) * inverse, 1.0, all(normal == vec3f(0.0)));
    if HAS_FACING_LIGHTS {
        let axis_length = length(axis);
        let cos_cone = min(axis_length - 2.0, 1.0);
        let height = -dot(axis, offset) / axis_length;
        let distance = sqrt(square);
        let across = sqrt(max(square - height * height, 0.0));
        let beside_cone = height * cos_cone + across * sqrt(max(1.0 - cos_cone * cos_cone, 0.0));
        // Along the normal of the cone that faces the point most.
        let facing_height = select(beside_cone, distance, height >= distance * cos_cone);
        value *= select(mean_height(facing_height, radius) * inverse, 1.0, cos_cone <= FULL_CONE);
    }
    return value;
}

/// Mean height above a plane of the parts of a sphere that are above it, roughly; zero if none is. `height` is that of its centre.
fn mean_height(height: f32, radius: f32) -> f32 {
    return max(max(height, HORIZON_SHARE * (height + radius)), 0.0);
}
