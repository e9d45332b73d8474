// import: integrator/participating_media
// Nested dielectrics. Twin of scene/nested_dielectrics.rs, which explains them.

/// Index of the object of a leaf.
fn object_of(leaf: u32) -> u32 {
    return scene_data[OBJECT_DATA + leaf];
}

/// Word of the dielectric of a leaf: its index, the difference between the lines F and C, its priority.
fn dielectric_word(leaf: u32, k: u32) -> u32 {
    return scene_data[MEDIUM_DATA + MEDIUM_WORDS * (leaves[leaf].material + 1u) + DIELECTRIC + k];
}

/// True if every surface of the material of a leaf is a sheet.
fn is_thin(leaf: u32) -> bool {
    return THIN_GLASS && stored_medium(leaves[leaf].material + 1u).solids == 0u;
}

/// Refractive index of the solid of a leaf, at an offset.
fn own_index(leaf: u32, offset: f32) -> f32 {
    return max(bitcast<f32>(dielectric_word(leaf, 0u)) + bitcast<f32>(dielectric_word(leaf, 1u)) * offset, 1.0);
}

/// Priority of the solid of a leaf.
fn priority_of(leaf: u32) -> i32 {
    let is_boundary = (materials[leaves[leaf].material].flags & BOUNDARY) != 0u;
    return select(bitcast<i32>(dielectric_word(leaf, 2u)), NO_PRIORITY, is_boundary);
}

/// Solids other than that of a leaf.
fn without_solid(around: vec4u, leaf: u32) -> vec4u {
    var others = around;
    let object = object_of(leaf);
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if others[k] > 0u && object_of(others[k] - 1u) == object {
            others[k] = 0u;
        }
    }
    return others;
}

/// These solids and that of a leaf.
fn with_solid(around: vec4u, leaf: u32) -> vec4u {
    var all_solids = without_solid(around, leaf);
    var lowest = 0u;
    var lowest_rank = priority_of(leaf);
    var is_found = false;
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        var rank = NO_PRIORITY - 1;
        if all_solids[k] > 0u {
            rank = priority_of(all_solids[k] - 1u);
        }
        if rank < lowest_rank {
            lowest = k;
            lowest_rank = rank;
            is_found = true;
        }
    }
    if is_found {
        all_solids[lowest] = leaf + 1u;
    }
    return all_solids;
}

/// Highest priority of these solids.
fn highest_priority(around: vec4u) -> i32 {
    var highest = NO_PRIORITY;
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if around[k] > 0u {
            highest = max(highest, priority_of(around[k] - 1u));
        }
    }
    return highest;
}

/// Refractive index within these solids, at an offset.
fn index_within(around: vec4u, offset: f32) -> f32 {
    let priority = highest_priority(around);
    var index = 1.0;
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if around[k] > 0u && priority_of(around[k] - 1u) == priority {
            index *= own_index(around[k] - 1u, offset);
        }
    }
    return index;
}

/// Sum of the media of the solids that fill the space, and of media without a surface.
fn medium_within(around: vec4u) -> Medium {
    let priority = highest_priority(around);
    var sum: Medium;
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if around[k] > 0u {
            let own = priority_of(around[k] - 1u);
            if own == priority || own == NO_PRIORITY {
                sum = sum_of_media(sum, stored_medium(leaves[around[k] - 1u].material + 1u));
            }
        }
    }
    sum.around = around;
    return sum;
}

/// Medium beyond a surface that a path crosses.
fn medium_across(medium: Medium, leaf: u32, inside: bool) -> Medium {
    if is_thin(leaf) {
        return medium;
    }
    if inside {
        return medium_within(without_solid(medium.around, leaf));
    }
    return medium_within(with_solid(medium.around, leaf));
}

/// Reports whether the surface of a leaf is a false intersection: a solid of higher priority fills both its sides.
fn is_skipped(medium: Medium, leaf: u32) -> bool {
    let refracts = (materials[leaves[leaf].material].flags & (TRANSMITS | BOUNDARY)) == TRANSMITS;
    return refracts && !is_thin(leaf) && highest_priority(without_solid(medium.around, leaf)) > priority_of(leaf);
}

/// Refractive index of the solid of a leaf at its surface, relative to what is outside.
fn relative_index(medium: Medium, leaf: u32, offset: f32) -> f32 {
    let outside = without_solid(medium.around, leaf);
    let index = own_index(leaf, offset);
    if is_thin(leaf) || priority_of(leaf) > highest_priority(outside) {
        return index / index_within(outside, offset);
    }
    return index;
}

/// Reports whether the index at the surface of a leaf depends on the wavelength.
fn disperses_at(medium: Medium, leaf: u32) -> bool {
    var disperses = bitcast<f32>(dielectric_word(leaf, 1u)) != 0.0;
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if medium.around[k] > 0u {
            disperses = disperses || bitcast<f32>(dielectric_word(medium.around[k] - 1u, 1u)) != 0.0;
        }
    }
    return disperses;
}

/// Square of the refractive index around the camera.
fn camera_index_square() -> f32 {
    let index = index_within(camera_medium().around, 0.0);
    return index * index;
}
