// import: light_nodes
// Choice of a light by its contribution to a point or to the medium on a segment. Twin of scene/light_tree.rs and of
// `choose_light` in light_sampling.rs, which explain it.

/// Walk down the tree: a uniform number, the probability of the way so far, and the lights below a node.
struct Walk {
    random: f32,
    probability: f32,
    node: u32,
    first: u32,
    count: u32,
}

/// Walk at the root, for a number that does not choose from the table.
fn first_step(choice: f32) -> Walk {
    let first = frame.table_lights;
    return Walk(choice / frame.tree_share, frame.tree_share, 0u, first, frame.light_count - first);
}

/// Walk after a choice between the halves of its node, of which `a` has this number of lights and this probability.
fn next_step(walk: Walk, count_a: u32, share_a: f32) -> Walk {
    if walk.random < share_a {
        let random = min(walk.random / share_a, ONE_MINUS_EPSILON);
        return Walk(random, walk.probability * share_a, walk.node + 1u, walk.first, count_a);
    }
    let random = min((walk.random - share_a) / (1.0 - share_a), ONE_MINUS_EPSILON);
    let probability = walk.probability * (1.0 - share_a);
    return Walk(random, probability, walk.node + count_a, walk.first + count_a, walk.count - count_a);
}

/// Index of the light that a uniform number chooses from the table.
fn chosen_from_table(choice: f32) -> u32 {
    let cell = (choice - frame.tree_share) / (1.0 - frame.tree_share) * f32(frame.table_lights);
    let index = min(u32(cell), frame.table_lights - 1u);
    if cell - f32(index) >= light_at(index).threshold {
        return light_at(index).alias_light;
    }
    return index;
}

/// Light that the uniform number `choice` chooses for a point, with its probability there. `normal` is the unit normal of a
/// surface that is lit on this side only, or zero. The light has no emission if none contributes.
fn chosen_light(p: vec3f, normal: vec3f, choice: f32) -> Light {
    if choice >= frame.tree_share {
        return light_at(chosen_from_table(choice));
    }
    var walk = first_step(choice);
    while walk.count > 1u {
        let halves = light_node(walk.node);
        let share_a = share_of_half_a(halves, p, normal);
        if share_a < 0.0 {
            walk.probability = 0.0;
            break;
        }
        walk = next_step(walk, u32(halves.count_a), share_a);
    }
    return light_with(walk.first, walk.probability);
}

/// Light that the uniform number `choice` chooses for the medium on a segment of this length, metres.
fn chosen_light_along(ray: Ray, length: f32, choice: f32) -> LightAlong {
    if choice >= frame.tree_share {
        let index = chosen_from_table(choice);
        return LightAlong(light_at(index), index);
    }
    var walk = first_step(choice);
    while walk.count > 1u {
        let halves = light_node(walk.node);
        let a = length_by_importance(halves.centre_a - ray.origin, halves.radius_a, ray.direction, length);
        let b = length_by_importance(halves.centre_b - ray.origin, halves.radius_b, ray.direction, length);
        walk = next_step(walk, u32(halves.count_a), b / (b + a * halves.intensity_ratio));
    }
    return LightAlong(light_with(walk.first, walk.probability), walk.first);
}

/// Light with the probability that it is chosen for a point.
fn light_from(index: u32, p: vec3f, normal: vec3f) -> Light {
    if index < frame.table_lights {
        return light_at(index);
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
    var light = light_at(index);
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

/// Length of a segment, divided by the importance of lights for its medium, see scene/light_tree.rs.
fn length_by_importance(offset: vec3f, radius: f32, direction: vec3f, length: f32) -> f32 {
    let nearest = offset - direction * clamp(dot(offset, direction), 0.0, length);
    let square = max(dot(nearest, nearest) + SOFTENING * radius * radius, MIN_SQUARE);
    return square + LINE_SHARE * length * sqrt(square);
}

/// Mean height above a plane of the parts of a sphere that are above it, roughly; zero if none is. `height` is that of its centre.
fn mean_height(height: f32, radius: f32) -> f32 {
    return max(max(height, HORIZON_SHARE * (height + radius)), 0.0);
}
