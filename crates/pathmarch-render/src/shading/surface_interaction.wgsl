// import: intersect/march
// Surface interactions: position, normal, side and leaf of a hit. Twin of surface_interaction.rs.

struct SurfaceInteraction {
    /// Position on the surface, in world space.
    p: vec3f,
    /// Leaf of the field; of blended leaves the one that shows.
    leaf: u32,
    /// Unit geometric normal on the side of the ray's origin.
    normal: vec3f,
    /// Whether that side is the inside of the solid.
    inside: bool,
    /// Distance from `p` along `normal` to the origin of rays that leave on this side, metres.
    offset: f32,
}

/// Surface interaction of a hit. `seed` decides which of two blended materials shows.
fn surface_interaction(ray: Ray, hit: Hit, seed: u32) -> SurfaceInteraction {
    let reached = ray.origin + ray.direction * hit.t;
    let near = surface(reached, hit.hit_id, seed);
    let steepness = max(length(near.gradient), 1e-6);
    let outward = near.gradient / steepness;
    let rounding = rounding_at(reached, leaves[near.leaf].at);
    // Within rounding of the surface, the direction of the ray decides the side; elsewhere the sign of the field does.
    let on_surface = hit.analytic || abs(near.distance) <= rounding + frame.rounding * hit.t;
    let inside = select((near.distance < 0.0), (dot(outward, ray.direction) > 0.0), on_surface);
    let left = near.distance / steepness;
    let normal = select(outward, -outward, inside);
    return SurfaceInteraction(reached - outward * left, near.leaf, normal, inside, start_offset(rounding, left));
}

/// Unit normal that points out of the solid.
fn outward_normal(at: SurfaceInteraction) -> vec3f {
    return select(at.normal, -at.normal, at.inside);
}

/// Origin of rays that leave on this side of the surface, or on the other one.
fn spawn_origin(at: SurfaceInteraction, other_side: bool) -> vec3f {
    return at.p + at.normal * select(at.offset, -at.offset, other_side);
}

/// Whether a leaf emits on the side of this normal: sheets do on one side only.
fn emits_towards(leaf: u32, normal: vec3f) -> bool {
    return (leaves[leaf].flags & SHEET) == 0u || dot(normal, leaves[leaf].facing) > 0.0;
}
