// import: backend/gpu/buffers
// Camera rays of samples. Twin of `camera_ray_index` in splitting.rs.

/// Index of the camera ray of a sample.
fn camera_ray_index(sample: u32) -> u32 {
    let unsplit = min(sample, UNSPLIT_SAMPLES);
    return unsplit + (sample - unsplit) / SPLITTING;
}
