// import: mesh_normals, shading/surface_interaction, textures
// Shading normals. Twin of `shading_normal` in textured_point.rs.

/// Normal nearest to `bumped`, between it and the geometric normal, whose mirrored view direction leaves the surface.
fn visible_shading_normal(bumped: vec3f, normal: vec3f, view: vec3f) -> vec3f {
    let view_height = max(dot(view, normal), 1e-5);
    let bumped_height = dot(bumped, normal);
    let tangential_part = bumped - normal * bumped_height;
    let tangent_length = length(tangential_part);
    if tangent_length < 1e-6 {
        return normal;
    }
    let tangent = tangential_part / tangent_length;
    let view_tangent = dot(view, tangent);
    let min_height = min(0.9 * view_height, 0.01);
    let max_angle = 0.5 * (atan2(view_tangent, view_height) + acos(min_height / length(vec2f(view_tangent, view_height))));
    let angle = min(atan2(tangent_length, bumped_height), max_angle);
    return normal * cos(angle) + tangent * sin(angle);
}

/// Shading normal of an interaction, on the side of its geometric normal, after `evaluate_textures`; `view` is the unit
/// vector towards the viewer.
fn shading_normal(interaction: SurfaceInteraction, view: vec3f) -> vec3f {
    if !SHADING_NORMALS {
        return interaction.normal;
    }
    let bumped = bumped_normal(smooth_outward(interaction));
    return visible_shading_normal(select(bumped, -bumped, interaction.inside), interaction.normal, view);
}
