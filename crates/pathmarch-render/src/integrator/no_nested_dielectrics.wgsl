// Scenes without priorities. Takes the place of nested_dielectrics.wgsl.

/// No solids: only their media are known.
fn solids_from(leaves_around: vec4u) -> Solids {
    return Solids(vec4u(0u), vec4u(0u));
}

/// Never called: all materials have one priority.
fn medium_across(medium: Medium, leaf: u32, inside: bool) -> Medium {
    return medium;
}

/// Every surface counts.
fn is_skipped(medium: Medium, leaf: u32) -> bool {
    return false;
}

/// Never called: the parameters of BSDFs have the index.
fn own_index(leaf: u32, offset: f32) -> f32 {
    return 1.0;
}

/// Refractive index of glass at its surface.
fn relative_index(medium: Medium, leaf: u32, offset: f32) -> f32 {
    return material_parameter(leaf_at(leaf).material, 1u).x;
}

/// Never called: materials have the flag DISPERSES.
fn disperses_at(medium: Medium, leaf: u32) -> bool {
    return false;
}

/// Square of the refractive index around the camera; paths count it from there.
fn camera_index_square() -> f32 {
    return 1.0;
}
