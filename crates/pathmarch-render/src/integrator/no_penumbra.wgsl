// import: intersect/ray
// Exact shadows only.

fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {
    return 1.0;
}
