// Segments of paths in scenes without participating media. Part of path.wgsl.

/// Intersects the ray of a path and adds emitted light, or that of the sky. Returns false if the path ends.
fn path_intersect(path: ptr<function, Path>) -> bool {
    let hit = march((*path).ray, (*path).length, AT_INFINITY);
    if ABSORPTION {
        (*path).throughput *= transmittance((*path).medium, select(hit.t, UNBOUNDED_LENGTH, hit.t < 0.0));
    }
    if hit.t < 0.0 {
        add_escaped_radiance(path);
        return false;
    }
    return arrive(path, hit);
}

/// Never called: no medium scatters.
fn scatter_in_medium(path: ptr<function, Path>) -> bool {
    return false;
}
