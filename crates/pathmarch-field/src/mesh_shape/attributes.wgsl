/// Nodes whose children are still to be visited: the index of the first child, and two masks of bytes, one of the children
/// that the ray passes in its order, the other of the inner ones by their slots.
var<private> mesh_stack: array<vec2u, MESH_STACK>;

/// Matrix whose columns are the rows of an instance's local coordinates, divided by its scale.
fn instance_rows(instance: u32) -> mat3x3f {
    return mat3x3f(mesh_vector(instance + 4u), mesh_vector(instance + 7u), mesh_vector(instance + 10u));
}

/// Corners of a triangle: the first, and the offsets of the others from it.
fn triangle_edges(instance: u32, triangle: u32) -> mat3x3f {
    let at = mesh_word(mesh_word(instance + 13u) + 1u) + 9u * triangle;
    let a = mesh_vector(at);
    return mat3x3f(a, mesh_vector(at + 3u) - a, mesh_vector(at + 6u) - a);
}

/// Largest component of two vectors, above zero.
fn largest_of_edges(b: vec3f, c: vec3f) -> f32 {
    let size = max(abs(b), abs(c));
    return max(max(size.x, size.y), max(size.z, 1e-37));
}

/// Weights of a triangle's second and third corner at the foot of a point in the mesh's coordinates, from 0 to 1.
fn triangle_weights(corners: mat3x3f, p: vec3f) -> vec2f {
    let size = largest_of_edges(corners[1], corners[2]);
    let b = corners[1] / size;
    let c = corners[2] / size;
    let offset = (p - corners[0]) / size;
    let normal = cross(b, c);
    let inverse = 1.0 / max(dot(normal, normal), 1e-37);
    let v = clamp(dot(cross(offset, c), normal) * inverse, 0.0, 1.0);
    return vec2f(v, clamp(dot(cross(b, offset), normal) * inverse, 0.0, 1.0 - v));
}

/// Shading normal in world space at the point `p` of a triangle of the mesh of this leaf, on the side of `outward`, one of its
/// two geometric normals; that itself where the mesh has none.
fn mesh_shading_normal(leaf: u32, triangle: u32, p: vec3f, outward: vec3f) -> vec3f {
    let instance = mesh_word(mesh_word(2u) + leaf);
    let surface_offset = mesh_word(instance + 13u);
    let normals = mesh_word(surface_offset + 3u);
    if normals == 0u {
        return outward;
    }
    let rows = instance_rows(instance);
    let corners = triangle_edges(instance, triangle);
    let weights = triangle_weights(corners, (p - mesh_vector(instance)) * rows);
    let vertices = mesh_word(surface_offset + 2u) + 3u * triangle;
    let a = mesh_vector(normals + 3u * mesh_word(vertices));
    let b = mesh_vector(normals + 3u * mesh_word(vertices + 1u));
    let c = mesh_vector(normals + 3u * mesh_word(vertices + 2u));
    let size_of_edges = largest_of_edges(corners[1], corners[2]);
    let is_back = dot(rows * cross(corners[1] / size_of_edges, corners[2] / size_of_edges), outward) < 0.0;
    let scale = mesh_float(instance + 3u) * select(1.0, -1.0, is_back);
    let interpolated = rows * (a * (1.0 - weights.x - weights.y) + b * weights.x + c * weights.y) * scale;
    let size = length(interpolated);
    return select(interpolated / size, outward, dot(interpolated, outward) <= 1e-3 * size);
}

/// Texture coordinates of one set at the corners of a triangle: those of the first, and the offsets of the others.
fn triangle_uvs(surface_offset: u32, triangle: u32, uv_set: u32) -> mat3x2f {
    let uvs = mesh_word(surface_offset + 4u + uv_set);
    if uvs == 0u {
        return mat3x2f();
    }
    let vertices = mesh_word(surface_offset + 2u) + 3u * triangle;
    let a = uvs + 2u * mesh_word(vertices);
    let b = uvs + 2u * mesh_word(vertices + 1u);
    let c = uvs + 2u * mesh_word(vertices + 2u);
    let first = vec2f(mesh_float(a), mesh_float(a + 1u));
    return mat3x2f(first, vec2f(mesh_float(b), mesh_float(b + 1u)) - first, vec2f(mesh_float(c), mesh_float(c + 1u)) - first);
}

/// Weight of a corner, 0 to 2, from those of the last two.
fn corner_weight(weights: vec2f, corner: u32) -> f32 {
    return select(1.0 - weights.x - weights.y, weights[max(corner, 1u) - 1u], corner > 0u);
}

/// Linear colour and alpha of the vertices at a point of a triangle; white where there is none.
fn triangle_colour(surface_offset: u32, triangle: u32, weights: vec2f) -> vec4f {
    let colours = mesh_word(surface_offset + 9u);
    if colours == 0u {
        return vec4f(1.0);
    }
    let vertices = mesh_word(surface_offset + 2u) + 3u * triangle;
    var sum = vec4f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let at = colours + 2u * mesh_word(vertices + k);
        let colour = vec4f(unpack2x16unorm(mesh_word(at)), unpack2x16unorm(mesh_word(at + 1u)));
        sum += colour * corner_weight(weights, k);
    }
    return sum;
}

/// Linear colour and alpha of the vertices at a point in the mesh's coordinates.
fn mesh_colour(leaf: u32, triangle: u32, local: vec3f) -> vec4f {
    let instance = mesh_word(mesh_word(2u) + leaf);
    return triangle_colour(mesh_word(instance + 13u), triangle, triangle_weights(triangle_edges(instance, triangle), local));
}

/// Tangent in the mesh's coordinates, of any length, and sign of the bitangent, at a point in these coordinates; zero where
/// there is none.
fn mesh_tangent(leaf: u32, triangle: u32, local: vec3f) -> vec4f {
    let instance = mesh_word(mesh_word(2u) + leaf);
    let surface_offset = mesh_word(instance + 13u);
    let tangents = mesh_word(surface_offset + 8u);
    if tangents == 0u {
        return vec4f(0.0);
    }
    let weights = triangle_weights(triangle_edges(instance, triangle), local);
    let vertices = mesh_word(surface_offset + 2u) + 3u * triangle;
    var sum = vec4f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let at = tangents + 2u * mesh_word(vertices + k);
        let tangent = vec4f(unpack2x16snorm(mesh_word(at)), unpack2x16snorm(mesh_word(at + 1u)));
        sum += tangent * corner_weight(weights, k);
    }
    return sum;
}

/// Texture coordinates (xy) of one set at a point in the mesh's coordinates, and their length for a unit of those (z).
fn mesh_uv(leaf: u32, triangle: u32, local: vec3f, uv_set: u32) -> vec3f {
    let instance = mesh_word(mesh_word(2u) + leaf);
    let corners = triangle_edges(instance, triangle);
    let weights = triangle_weights(corners, local);
    let uvs = triangle_uvs(mesh_word(instance + 13u), triangle, uv_set);
    let area = length(cross(corners[1], corners[2]));
    let uv_area = abs(uvs[1].x * uvs[2].y - uvs[1].y * uvs[2].x);
    return vec3f(uvs[0] + uvs[1] * weights.x + uvs[2] * weights.y, sqrt(uv_area / max(area, 1e-37)));
}

/// Squared distance of a point to a triangle, given by its first corner and the offsets of the others: that to its plane
/// between the planes at its edges, else that to the nearest edge.
fn squared_triangle_distance(corners: mat3x3f, p: vec3f) -> f32 {
    let b = corners[1];
    let c = corners[2];
    let from_a = p - corners[0];
    let from_b = from_a - b;
    let from_c = from_a - c;
    let normal = cross(b, -c);
    let sides = vec3f(dot(cross(b, normal), from_a), dot(cross(c - b, normal), from_b), dot(cross(-c, normal), from_c));
    if dot(sign(sides), vec3f(1.0)) >= 2.0 {
        let height = dot(normal, from_a);
        return height * height / dot(normal, normal);
    }
    let to_ab = b * clamp(dot(b, from_a) / dot(b, b), 0.0, 1.0) - from_a;
    let to_bc = (c - b) * clamp(dot(c - b, from_b) / dot(c - b, c - b), 0.0, 1.0) - from_b;
    let to_ca = -c * clamp(dot(-c, from_c) / dot(c, c), 0.0, 1.0) - from_c;
    return min(dot(to_ab, to_ab), min(dot(to_bc, to_bc), dot(to_ca, to_ca)));
}

/// Bits of the children among four whose boxes are nearer than this squared distance: inner nodes from bit 24 on, triangles
/// below it.
fn near_children(node: u32, half: u32, p: vec3f, max_squared: f32) -> u32 {
    let slots = unpack4xU8(mesh_word(node + 6u + half));
    let exponents = unpack4xU8(mesh_word(node + 3u));
    let scale = vec3f(bitcast<f32>(exponents.x << 23u), bitcast<f32>(exponents.y << 23u), bitcast<f32>(exponents.z << 23u));
    let offset = mesh_vector(node) - p;
    let low_x = vec4f(unpack4xU8(mesh_word(node + 8u + half))) * scale.x + offset.x;
    let low_y = vec4f(unpack4xU8(mesh_word(node + 10u + half))) * scale.y + offset.y;
    let low_z = vec4f(unpack4xU8(mesh_word(node + 12u + half))) * scale.z + offset.z;
    let high_x = vec4f(unpack4xU8(mesh_word(node + 14u + half))) * scale.x + offset.x;
    let high_y = vec4f(unpack4xU8(mesh_word(node + 16u + half))) * scale.y + offset.y;
    let high_z = vec4f(unpack4xU8(mesh_word(node + 18u + half))) * scale.z + offset.z;
    let x = max(max(low_x, -high_x), vec4f(0.0));
    let y = max(max(low_y, -high_y), vec4f(0.0));
    let z = max(max(low_z, -high_z), vec4f(0.0));
    let bits = select(vec4u(0u), (slots >> vec4u(5u)) << (slots & vec4u(31u)), x * x + y * y + z * z <= vec4f(max_squared));
    return bits.x | bits.y | bits.z | bits.w;
}

/// Triangle of the mesh of an instance that is closest to a point in its coordinates.
fn nearest_triangle(instance: u32, p: vec3f) -> u32 {
    let surface_offset = mesh_word(instance + 13u);
    let nodes = mesh_word(surface_offset);
    let corners = mesh_word(surface_offset + 1u);
    // The field errs by less than two voxels.
    let grid = mesh_word(instance + 16u);
    let bound = abs(mesh_gradient(p, f32(grid)).w) + 2.0 * mesh_float(4u * grid + 3u);
    var nearest = 0u;
    var least = bound * bound;
    var group = vec2u(0u, 1u | 256u);
    var height = 0u;
    loop {
        if (group.y & 0xffu) == 0u {
            if height == 0u {
                break;
            }
            height -= 1u;
            group = mesh_stack[height];
        }
        let slot = firstTrailingBit(group.y & 0xffu);
        group.y ^= 1u << slot;
        let node = nodes + MESH_NODE_WORDS * (group.x + countOneBits((group.y >> 8u) & ((1u << slot) - 1u)));
        if (group.y & 0xffu) != 0u {
            mesh_stack[height] = group;
            height += 1u;
        }
        let bits = near_children(node, 0u, p, least) | near_children(node, 1u, p, least);
        group = vec2u(mesh_word(node + 4u), (bits >> 24u) | ((mesh_word(node + 3u) >> 24u) << 8u));
        let first = mesh_word(node + 5u);
        var triangles = bits & 0xffffffu;
        while triangles != 0u {
            let triangle = first + firstTrailingBit(triangles);
            let at = corners + 9u * triangle;
            let a = mesh_vector(at);
            let squared = squared_triangle_distance(mat3x3f(a, mesh_vector(at + 3u) - a, mesh_vector(at + 6u) - a), p);
            nearest = select(nearest, triangle, squared < least);
            least = min(least, squared);
            triangles &= triangles - 1u;
        }
    }
    return nearest;
}

/// Leaf of a triangle's material.
fn leaf_of_triangle(instance: u32, triangle: u32) -> u32 {
    let materials = mesh_word(mesh_word(instance + 13u) + 6u);
    if materials == 0u {
        return mesh_word(instance + 14u);
    }
    return mesh_word(instance + 14u) + min(mesh_word(materials + triangle), mesh_word(instance + 15u) - 1u);
}

/// Point in the coordinates of an instance, of one in the space of the modifier around it.
fn instance_point(instance: u32, p: vec3f) -> vec3f {
    return (p - mesh_vector(instance)) * instance_rows(instance);
}
