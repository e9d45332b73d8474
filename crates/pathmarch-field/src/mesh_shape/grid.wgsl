/// Float of the words of meshes.
fn mesh_float(index: u32) -> f32 {
    return bitcast<f32>(mesh_word(index));
}

/// Three floats of the words of meshes.
fn mesh_vector(index: u32) -> vec3f {
    return vec3f(mesh_float(index), mesh_float(index + 1u), mesh_float(index + 2u));
}

/// Index in an array whose x varies fastest.
fn grid_index(at: vec3u, size: vec3u) -> u32 {
    return at.x + size.x * (at.y + size.y * at.z);
}

/// Sample of a brick.
fn brick_sample(bricks: u32, index: u32) -> f32 {
    let pair = mesh_word(bricks + (index >> 1u));
    return f32(i32(pair << select(16u, 0u, (index & 1u) == 1u)) >> 16u);
}

/// Gradient (xyz) and distance (w) of a mesh with this grid: trilinear within its box, a lower bound beyond it.
fn mesh_gradient(p: vec3f, grid_offset: f32) -> vec4f {
    let grid = 4u * u32(grid_offset);
    let origin = mesh_vector(grid);
    let voxel = mesh_float(grid + 3u);
    let blocks = vec3u(mesh_word(grid + 4u), mesh_word(grid + 5u), mesh_word(grid + 6u));
    let nearest = clamp(p, origin, origin + voxel * vec3f(blocks * GRID_BLOCK));
    let voxels = max((nearest - origin) / voxel, vec3f(0.0));
    let block = min(vec3u(voxels / f32(GRID_BLOCK)), blocks - 1u);
    let place = min(voxels - vec3f(block * GRID_BLOCK), vec3f(f32(GRID_BLOCK)));
    let brick = mesh_word(mesh_word(grid + 9u) + grid_index(block, blocks));
    let is_coarse = brick == NO_BRICK;
    let spacing = select(1u, GRID_COARSE, is_coarse);
    let scaled = place / f32(spacing);
    let cell = min(vec3u(scaled), vec3u(GRID_BLOCK / spacing - 1u));
    let t = scaled - vec3f(cell);
    // The first corner of the cell, and the steps along the axes.
    let coarse_size = blocks * (GRID_BLOCK / GRID_COARSE) + 1u;
    let size = select(vec3u(GRID_SIDE), coarse_size, is_coarse);
    let first = grid_index(select(cell, block * (GRID_BLOCK / GRID_COARSE) + cell, is_coarse), size);
    let side = vec2u(size.x, size.x * size.y);
    var near: vec4f;
    var far: vec4f;
    if is_coarse {
        let at = mesh_word(grid + 8u) + first;
        near = vec4f(mesh_float(at), mesh_float(at + side.x), mesh_float(at + side.y), mesh_float(at + side.x + side.y));
        far = vec4f(mesh_float(at + 1u), mesh_float(at + side.x + 1u), mesh_float(at + side.y + 1u), mesh_float(at + side.x + side.y + 1u));
    } else {
        let bricks = mesh_word(grid + 10u);
        let at = brick * GRID_SIDE * GRID_SIDE * GRID_SIDE + first;
        let unit = mesh_float(grid + 7u);
        near = unit * vec4f(brick_sample(bricks, at), brick_sample(bricks, at + side.x), brick_sample(bricks, at + side.y), brick_sample(bricks, at + side.x + side.y));
        far = unit * vec4f(brick_sample(bricks, at + 1u), brick_sample(bricks, at + side.x + 1u), brick_sample(bricks, at + side.y + 1u), brick_sample(bricks, at + side.x + side.y + 1u));
    }
    let along_x = near + t.x * (far - near);
    let slope_x = far - near;
    let along_y = along_x.xz + t.y * (along_x.yw - along_x.xz);
    let slope_x_along_y = slope_x.xz + t.y * (slope_x.yw - slope_x.xz);
    let slope_y = along_x.yw - along_x.xz;
    let distance = along_y.x + t.z * (along_y.y - along_y.x);
    let cell_gradient = vec3f(
        slope_x_along_y.x + t.z * (slope_x_along_y.y - slope_x_along_y.x),
        slope_y.x + t.z * (slope_y.y - slope_y.x),
        along_y.y - along_y.x,
    );
    let gradient = cell_gradient / (f32(spacing) * voxel);
    let beyond = p - nearest;
    if all(beyond == vec3f(0.0)) {
        return vec4f(gradient, distance);
    }
    let inner = max(distance, 0.0);
    let outer = length(vec4f(beyond, inner));
    return vec4f((beyond + inner * select(vec3f(0.0), gradient, beyond == vec3f(0.0))) / outer, outer);
}
