// import: intersect/march, mesh_fields
// Surface interactions: position, normal, side and leaf of a hit. Twin of surface_interaction.rs.

/// Interaction of a ray with a surface.
struct SurfaceInteraction {
    /// Position on the surface, in world space.
    p: vec3f,
    /// Leaf of the field; where leaves blend, the chosen one.
    leaf: u32,
    /// Unit geometric normal on the side of the ray's origin.
    normal: vec3f,
    /// True if that side is the inside of the solid.
    inside: bool,
    /// Triangle of a mesh, or NO_TRIANGLE.
    triangle: u32,
    /// True if the ray hit that triangle, not a field to which it is closest.
    is_triangle_hit: bool,
    /// Distance from `p` along `normal` to the origin of rays that leave on this side, metres.
    offset: f32,
}

/// Surface interaction of a hit. `seed` chooses one of two blended materials.
fn surface_interaction(ray: Ray, hit: Hit, seed: u32) -> SurfaceInteraction {
    let hit_point = ray.origin + ray.direction * hit.t;
    let surface_at_hit = with_nearest_triangle(surface(hit_point, hit.hit_id, hit.triangle, seed), hit_point);
    let inverse = 1.0 / max(length(surface_at_hit.gradient), 1e-6);
    let outward = surface_at_hit.gradient * inverse;
    let rounding = rounding_at(hit_point, leaf_at(surface_at_hit.leaf).origin);
    // Within rounding of the surface, the direction of the ray decides the side; elsewhere the sign of the field does.
    let on_surface = hit.analytic || abs(surface_at_hit.distance) <= rounding + frame.rounding * hit.t;
    let inside = select((surface_at_hit.distance < 0.0), (dot(outward, ray.direction) > 0.0), on_surface);
    let residual = surface_at_hit.distance * inverse;
    let normal = select(outward, -outward, inside);
    let is_turned = (leaf_at(surface_at_hit.leaf).flags & TWO_SIDED) != 0u;
    return SurfaceInteraction(
        hit_point - outward * residual,
        surface_at_hit.leaf,
        normal,
        inside && !is_turned,
        surface_at_hit.triangle,
        hit.triangle != NO_TRIANGLE,
        start_offset(rounding, residual) + clearance(hit.hit_id, hit.triangle),
    );
}

/// Unit normal that points out of the solid.
fn outward_normal(interaction: SurfaceInteraction) -> vec3f {
    return select(interaction.normal, -interaction.normal, interaction.inside);
}

/// Origin of rays that leave on the side of the normal, or on the other side.
fn spawn_origin(interaction: SurfaceInteraction, other_side: bool) -> vec3f {
    return interaction.p + interaction.normal * select(interaction.offset, -interaction.offset, other_side);
}

/// Reports whether a leaf emits on the side of this normal: sheets emit on one side only.
fn emits_towards(leaf: u32, normal: vec3f) -> bool {
    return (leaf_at(leaf).flags & SHEET) == 0u || dot(normal, leaf_at(leaf).facing) > 0.0;
}
