// What a ray of a mode without noise has met. Twin of visible.rs.

struct Visible {
    /// On the surface.
    p: vec3f,
    leaf: u32,
    /// On the side that the ray comes from, of length one.
    normal: vec3f,
    /// Whether that side is the inside of the solid.
    inside: bool,
    /// From `p` to where rays start on this side.
    away: vec3f,
}

fn visible(ray: Ray, hit: Hit, random: Random) -> Visible {
    let reached = ray.origin + ray.direction * hit.t;
    let near = surface(reached, hit.met, random.sample);
    let steepness = max(length(near.gradient), 1e-6);
    let outward = near.gradient / steepness;
    let off = rounding_at(reached, leaves[near.leaf].at);
    let on_surface = hit.direct || abs(near.distance) <= off + frame.rounding * hit.t;
    let inside = select((near.distance < 0.0), (dot(outward, ray.direction) > 0.0), on_surface);
    let normal = select(outward, -outward, inside);
    let left = near.distance / steepness;
    return Visible(reached - outward * left, near.leaf, normal, inside, normal * start_offset(off, left));
}

/// Whether a leaf shines on the side of this normal: sheets do on one side only.
fn shines(leaf: u32, normal: vec3f) -> bool {
    return (leaves[leaf].flags & SHEET) == 0u || dot(normal, leaves[leaf].facing) > 0.0;
}
