// import: intersect/ray
// Exact shadows only. Takes the place of penumbra.wgsl.

fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {
    return 1.0;
}
