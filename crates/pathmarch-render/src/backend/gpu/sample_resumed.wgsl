// One sample of a pixel whose path goes on in the next dispatch where the adapter ended its loops.

const FINISHED = 0xffffffffu;

fn resumed(saved: SuspendedPath, random: Random) -> Path {
    var path: Path;
    path.ray = Ray(saved.origin, saved.direction);
    path.random = random;
    path.length = saved.length;
    path.scatter_pdf = saved.scatter_pdf;
    path.reference = saved.reference;
    path.index_square = saved.index_square;
    path.throughput = saved.throughput;
    path.surfaces = saved.surfaces;
    path.radiance = saved.radiance;
    path.passing = saved.passing != 0u;
    path.medium = saved.medium;
    return path;
}

fn suspend(slot: u32, path: Path) {
    suspended.paths[slot] = SuspendedPath(
        path.ray.origin,
        path.length,
        path.ray.direction,
        path.scatter_pdf,
        path.reference,
        path.index_square,
        path.throughput,
        path.surfaces,
        path.radiance,
        select(0u, 1u, path.passing),
        path.medium,
    );
    atomicAdd(&suspended.count, 1u);
}

fn samples_of(x: u32, y: u32) -> vec4f {
    let slot = slice.first_slot + (y - slice.first_row) * slice.columns + x - slice.first_column;
    let random = random_new(x, y, slice.sample, frame.seed);
    var path: Path;
    if suspended.round == 0u {
        path = path_from(camera_ray(x, y, random), random);
    } else {
        if suspended.paths[slot].surfaces == FINISHED {
            return vec4f(0.0);
        }
        path = resumed(suspended.paths[slot], random);
    }
    loop {
        let before = path;
        let goes_on = path_arrive(&path) && path_scatter(&path);
        if loops_ended() {
            suspend(slot, before);
            return vec4f(0.0);
        }
        if !goes_on {
            break;
        }
    }
    suspended.paths[slot].surfaces = FINISHED;
    return kept(as_filmed(path.radiance));
}
