// import: backend/gpu/film, integrator/path, loop_check
// One sample of a pixel. If the adapter ends loops, the next dispatch resumes the path.

/// Number of surfaces of a path that has ended.
const FINISHED = 0xffffffffu;

fn resumed(saved: SuspendedPath, sampler: PixelSampler) -> Path {
    var path: Path;
    path.ray = Ray(saved.origin, saved.direction);
    path.sampler = sampler;
    path.length = saved.length;
    path.scatter_pdf = saved.scatter_pdf;
    path.previous_vertex = saved.previous_vertex;
    path.previous_normal = saved.previous_normal;
    path.index_square = saved.index_square;
    path.throughput = saved.throughput;
    path.surfaces = saved.surfaces;
    path.radiance = saved.radiance;
    path.lights_are_counted = (saved.flags & 1u) != 0u;
    path.met_photons = (saved.flags & 2u) != 0u;
    path.medium = resumed_medium(
        saved.medium,
        saved.medium_forward,
        saved.medium_scattering,
        saved.medium_solids,
        saved.medium_emission,
        saved.medium_around,
    );
    path.wavelength = saved.wavelength;
    return path;
}

fn suspend(slot: u32, path: Path) {
    suspended.paths[slot] = SuspendedPath(
        path.ray.origin,
        path.length,
        path.ray.direction,
        path.scatter_pdf,
        path.previous_vertex,
        path.index_square,
        path.throughput,
        path.surfaces,
        path.radiance,
        select(0u, 1u, path.lights_are_counted) | select(0u, 2u, path.met_photons),
        absorption_of(path.medium),
        path.wavelength,
        path.previous_normal,
        solids_of(path.medium),
        scattering_of(path.medium),
        forward_of(path.medium),
        emission_of(path.medium),
        around_of(path.medium),
    );
    atomicAdd(&suspended.count, 1u);
}

/// Adds the slice's sample of a pixel to those before, unless its path is suspended.
fn add_samples(before: vec4f, x: u32, y: u32) -> vec4f {
    let slot = slice.first_slot + (y - slice.first_row) * slice.columns + x - slice.first_column;
    let sampler = pixel_sampler(x, y, slice.sample, frame.seed);
    var path: Path;
    if suspended.round == 0u {
        path = path_from(camera_ray(x, y, sampler), sampler);
    } else {
        if suspended.paths[slot].surfaces == FINISHED {
            return before;
        }
        path = resumed(suspended.paths[slot], sampler);
    }
    loop {
        let last = path;
        let goes_on = path_intersect(&path) && path_scatter(&path);
        if loops_ended() {
            suspend(slot, last);
            return before;
        }
        if !goes_on {
            break;
        }
    }
    suspended.paths[slot].surfaces = FINISHED;
    return before + kept(film_value(path.radiance));
}
