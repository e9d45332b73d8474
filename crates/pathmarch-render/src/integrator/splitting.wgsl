// Samples of a pixel that share a ray of the camera. Twin of splitting.rs, which explains them.

const OWN_RAYS = 16u;

/// The ray of the camera that a sample belongs to.
fn ray_of(sample: u32) -> u32 {
    let own = min(sample, OWN_RAYS);
    return own + (sample - own) / SPLITTING;
}

fn samples_of(x: u32, y: u32) -> vec4f {
    let random = random_new(x, y, ray_of(slice.sample), frame.seed);
    var first = path_from(camera_ray(x, y, random), random);
    if !path_arrive(&first) {
        return checked(kept(first.radiance) * f32(slice.samples));
    }
    var sum = vec4f(0.0);
    var taken = 0u;
    var path = first;
    path.random.sample = slice.sample;
    // A lane whose path has ended takes its next one, so that those that run together do not wait for each other.
    loop {
        if !path_scatter(&path) || !path_arrive(&path) {
            sum += kept(path.radiance);
            taken++;
            if taken >= slice.samples {
                break;
            }
            path = first;
            path.random.sample = slice.sample + taken;
        }
    }
    return checked(sum);
}
