// import: integrator/participating_media
// Nested dielectrics. Twin of scene/nested_dielectrics.rs, which explains them.

/// Key of the solid of a leaf: its rank in the upper byte, one more than its object in the others. 0 without an inside.
fn key_of(leaf: u32) -> u32 {
    return scene_word(DIELECTRIC_DATA + DIELECTRIC_WORDS * leaf);
}

/// Refractive index of the solid of a leaf, at an offset.
fn own_index(leaf: u32, offset: f32) -> f32 {
    let first = DIELECTRIC_DATA + DIELECTRIC_WORDS * leaf;
    return max(bitcast<f32>(scene_word(first + 1u)) + bitcast<f32>(scene_word(first + 2u)) * offset, 1.0);
}

/// Solids around a path, from their leaves.
fn solids_from(leaves_around: vec4u) -> Solids {
    var keys = vec4u(0u);
    for (var k = 0u; k < MAX_SOLIDS; k++) {
        if leaves_around[k] > 0u {
            keys[k] = key_of(leaves_around[k] - 1u);
        }
    }
    return Solids(leaves_around, keys);
}

/// Solids other than that of this key.
fn without_solid(solids: Solids, key: u32) -> Solids {
    let same = (solids.keys << vec4u(8u)) == vec4u(key << 8u);
    return Solids(select(solids.leaves, vec4u(0u), same), select(solids.keys, vec4u(0u), same));
}

/// These solids and that of a leaf.
fn with_solid(solids: Solids, leaf: u32, key: u32) -> Solids {
    let others = without_solid(solids, key);
    let ranks = others.keys >> vec4u(24u);
    let lowest = min(min(ranks.x, ranks.y), min(ranks.z, ranks.w));
    if lowest >= key >> 24u {
        return others;
    }
    let slot = select(select(select(3u, 2u, ranks.z == lowest), 1u, ranks.y == lowest), 0u, ranks.x == lowest);
    let chosen = vec4u(0u, 1u, 2u, 3u) == vec4u(slot);
    return Solids(select(others.leaves, vec4u(leaf + 1u), chosen), select(others.keys, vec4u(key), chosen));
}

/// Highest rank of these solids.
fn highest_rank(solids: Solids) -> u32 {
    return max(max(solids.keys.x, solids.keys.y), max(solids.keys.z, solids.keys.w)) >> 24u;
}

/// Index of one of the solids around if it fills the space, else 1.
fn filling_index(entry: u32, key: u32, rank: u32, offset: f32) -> f32 {
    if entry > 0u && key >> 24u == rank {
        return own_index(entry - 1u, offset);
    }
    return 1.0;
}

/// Refractive index within these solids, at an offset.
fn index_within(solids: Solids, offset: f32) -> f32 {
    let rank = highest_rank(solids);
    return filling_index(solids.leaves.x, solids.keys.x, rank, offset)
        * filling_index(solids.leaves.y, solids.keys.y, rank, offset)
        * filling_index(solids.leaves.z, solids.keys.z, rank, offset)
        * filling_index(solids.leaves.w, solids.keys.w, rank, offset);
}

/// Adds the medium of one of the solids around if it fills the space, or has no surface.
fn with_filling(sum: Medium, entry: u32, key: u32, rank: u32) -> Medium {
    let own = key >> 24u;
    if entry > 0u && (own == rank || own == BOUNDARY_RANK) {
        return sum_of_media(sum, stored_medium(leaf_at(entry - 1u).material + 1u));
    }
    return sum;
}

/// Sum of the media of the solids that fill the space, and of media without a surface.
fn medium_within(solids: Solids) -> Medium {
    let rank = highest_rank(solids);
    var sum: Medium;
    sum = with_filling(sum, solids.leaves.x, solids.keys.x, rank);
    sum = with_filling(sum, solids.leaves.y, solids.keys.y, rank);
    sum = with_filling(sum, solids.leaves.z, solids.keys.z, rank);
    sum = with_filling(sum, solids.leaves.w, solids.keys.w, rank);
    sum.around = solids;
    return sum;
}

/// Medium beyond a surface that a path crosses.
fn medium_across(medium: Medium, leaf: u32, inside: bool) -> Medium {
    let key = key_of(leaf);
    if key == 0u {
        return medium;
    }
    if inside {
        return medium_within(without_solid(medium.around, key));
    }
    return medium_within(with_solid(medium.around, leaf, key));
}

/// Reports whether the surface of a leaf is a false intersection: a solid of higher priority fills both its sides.
fn is_skipped(medium: Medium, leaf: u32) -> bool {
    let key = key_of(leaf);
    return key >> 24u > BOUNDARY_RANK && highest_rank(without_solid(medium.around, key)) > key >> 24u;
}

/// Refractive index of the solid of a leaf at its surface, relative to what is outside.
fn relative_index(medium: Medium, leaf: u32, offset: f32) -> f32 {
    let key = key_of(leaf);
    var outside = medium.around;
    if key != 0u {
        outside = without_solid(outside, key);
    }
    let index = own_index(leaf, offset);
    if key == 0u || key >> 24u > highest_rank(outside) {
        return index / index_within(outside, offset);
    }
    return index;
}

/// Reports whether the index of a leaf depends on the wavelength.
fn disperses(entry: u32) -> bool {
    return entry > 0u && scene_word(DIELECTRIC_DATA + DIELECTRIC_WORDS * (entry - 1u) + 2u) != 0u;
}

/// Reports whether the index at the surface of a leaf depends on the wavelength.
fn disperses_at(medium: Medium, leaf: u32) -> bool {
    let around = medium.around.leaves;
    return disperses(leaf + 1u) || disperses(around.x) || disperses(around.y) || disperses(around.z)
        || disperses(around.w);
}

/// Square of the refractive index around the camera.
fn camera_index_square() -> f32 {
    let index = index_within(camera_medium().around, 0.0);
    return index * index;
}
