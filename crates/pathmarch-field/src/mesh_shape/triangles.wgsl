/// Bit that marks the id of a hit as an instance of triangles, not a leaf.
const MESH = 0x40000000u;

/// Bits of a byte of slots in the order in which a ray of this octant passes them.
fn in_ray_order(slots: u32, octant: u32) -> u32 {
    var bits = slots;
    bits = select(bits, ((bits & 0xaau) >> 1u) | ((bits & 0x55u) << 1u), (octant & 1u) != 0u);
    bits = select(bits, ((bits & 0xccu) >> 2u) | ((bits & 0x33u) << 2u), (octant & 2u) != 0u);
    return select(bits, ((bits & 0xf0u) >> 4u) | ((bits & 0x0fu) << 4u), (octant & 4u) != 0u);
}

/// Coordinates with the longest one of the ray last.
fn with_long_axis_last(v: vec3f, long_axis: u32) -> vec3f {
    return select(select(v.zxy, v.yzx, long_axis == 0u), v, long_axis == 2u);
}

/// Edge function of two sheared corners, equal but for its sign in either direction: both triangles at an edge do the same
/// operations.
fn edge_function(p: vec2f, q: vec2f) -> f32 {
    let is_swapped = p.x > q.x || (p.x == q.x && p.y > q.y);
    let a = select(p, q, is_swapped);
    let b = select(q, p, is_swapped);
    let value = a.x * b.y - a.y * b.x;
    return select(value, -value, is_swapped);
}

/// Ray in a mesh's coordinates, with what its tests need.
struct MeshRay {
    origin: vec3f,
    inverse: vec3f,
    /// Bound of the rounding errors of the planes of boxes, along the ray.
    margin: vec3f,
    octant: u32,
    long_axis: u32,
    /// Origin with the longest axis last.
    turned_origin: vec3f,
    shear: vec3f,
    /// Hash for random opacity.
    seed: u32,
}

fn mesh_ray(origin: vec3f, direction: vec3f, largest_coordinate: f32) -> MeshRay {
    let magnitude = abs(direction);
    var long_axis = select(2u, 1u, magnitude.y > magnitude.z);
    long_axis = select(long_axis, 0u, magnitude.x >= max(magnitude.y, magnitude.z));
    let d = with_long_axis_last(direction, long_axis);
    let safe = select(direction, vec3f(1e-30), magnitude < vec3f(1e-30));
    let inverse = 1.0 / safe;
    let octant = u32(safe.x < 0.0) | (u32(safe.y < 0.0) << 1u) | (u32(safe.z < 0.0) << 2u);
    let margin = abs(inverse) * (1e-6 * (abs(origin) + largest_coordinate));
    return MeshRay(origin, inverse, margin, octant, long_axis, with_long_axis_last(origin, long_axis), vec3f(d.xy / d.z, 1.0 / d.z), ray_seed(origin, direction));
}

/// First hit of a ray with the triangles of a surface: its parameter, and the triangle in the order of the leaves.
struct TriangleHit {
    t: f32,
    triangle: u32,
}

/// Hit with a triangle, if it is nearer.
fn triangle_hit(surface_offset: u32, corners: u32, opacity: u32, triangle: u32, ray: MeshRay, nearest: TriangleHit) -> TriangleHit {
    let at = corners + 9u * triangle;
    let p = with_long_axis_last(mesh_vector(at), ray.long_axis) - ray.turned_origin;
    let q = with_long_axis_last(mesh_vector(at + 3u), ray.long_axis) - ray.turned_origin;
    let r = with_long_axis_last(mesh_vector(at + 6u), ray.long_axis) - ray.turned_origin;
    let a = p.xy - ray.shear.xy * p.z;
    let b = q.xy - ray.shear.xy * q.z;
    let c = r.xy - ray.shear.xy * r.z;
    let edges = vec3f(edge_function(c, b), edge_function(a, c), edge_function(b, a));
    let determinant = edges.x + edges.y + edges.z;
    let has_both_signs = any(edges < vec3f(0.0)) && any(edges > vec3f(0.0));
    let t = dot(edges, ray.shear.z * vec3f(p.z, q.z, r.z)) / determinant;
    var is_hit = !has_both_signs && determinant != 0.0 && t > 0.0 && t < nearest.t;
    if HAS_OPACITY && is_hit && opacity != 0u {
        let toward = vec3f(ray.shear.xy, 1.0) * ray.shear.z;
        let is_back = dot(cross(q - p, r - p), toward) > 0.0;
        is_hit = is_present(opacity, surface_offset, triangle, edges.yz / determinant, is_back, ray.seed);
    }
    return TriangleHit(select(nearest.t, t, is_hit), select(nearest.triangle, triangle, is_hit));
}

/// Bits of the children among four that the ray passes: inner nodes from bit 24 on, triangles below it.
fn passed_children(node: u32, half: u32, ray: MeshRay, t_max: f32) -> u32 {
    let slots = unpack4xU8(mesh_word(node + 6u + half));
    let origin = mesh_vector(node);
    let exponents = unpack4xU8(mesh_word(node + 3u));
    let scale = vec3f(bitcast<f32>(exponents.x << 23u), bitcast<f32>(exponents.y << 23u), bitcast<f32>(exponents.z << 23u));
    var enter = vec4f(0.0);
    var leave = vec4f(t_max);
    let step = scale * ray.inverse;
    let start = (origin - ray.origin) * ray.inverse;
    let low_x = vec4f(unpack4xU8(mesh_word(node + 8u + half))) * step.x + start.x;
    let low_y = vec4f(unpack4xU8(mesh_word(node + 10u + half))) * step.y + start.y;
    let low_z = vec4f(unpack4xU8(mesh_word(node + 12u + half))) * step.z + start.z;
    let high_x = vec4f(unpack4xU8(mesh_word(node + 14u + half))) * step.x + start.x;
    let high_y = vec4f(unpack4xU8(mesh_word(node + 16u + half))) * step.y + start.y;
    let high_z = vec4f(unpack4xU8(mesh_word(node + 18u + half))) * step.z + start.z;
    enter = max(max(enter, min(low_x, high_x) - ray.margin.x), max(min(low_y, high_y) - ray.margin.y, min(low_z, high_z) - ray.margin.z));
    leave = min(min(leave, max(low_x, high_x) + ray.margin.x), min(max(low_y, high_y) + ray.margin.y, max(low_z, high_z) + ray.margin.z));
    let bits = select(vec4u(0u), (slots >> vec4u(5u)) << (slots & vec4u(31u)), enter <= leave);
    return bits.x | bits.y | bits.z | bits.w;
}

/// First hit of a ray with a surface before `t_max` (Ylitie et al. 2017; Woop et al. 2013).
fn surface_hit(surface_offset: u32, opacity: u32, origin: vec3f, direction: vec3f, t_max: f32) -> TriangleHit {
    let nodes = mesh_word(surface_offset);
    let corners = mesh_word(surface_offset + 1u);
    let ray = mesh_ray(origin, direction, mesh_float(surface_offset + 7u));
    var nearest = TriangleHit(t_max, 0u);
    // The root is the only child of a group of its own.
    var group = vec2u(0u, 1u | (256u << ray.octant));
    var height = 0u;
    loop {
        if (group.y & 0xffu) == 0u {
            if height == 0u {
                break;
            }
            height -= 1u;
            group = mesh_stack[height];
        }
        let order = firstTrailingBit(group.y & 0xffu);
        group.y ^= 1u << order;
        let before = (group.y >> 8u) & ((1u << (order ^ ray.octant)) - 1u);
        let node = nodes + MESH_NODE_WORDS * (group.x + countOneBits(before));
        if (group.y & 0xffu) != 0u {
            mesh_stack[height] = group;
            height += 1u;
        }
        let bits = passed_children(node, 0u, ray, nearest.t) | passed_children(node, 1u, ray, nearest.t);
        group = vec2u(mesh_word(node + 4u), in_ray_order(bits >> 24u, ray.octant) | ((mesh_word(node + 3u) >> 24u) << 8u));
        let first = mesh_word(node + 5u);
        var triangles = bits & 0xffffffu;
        while triangles != 0u {
            nearest = triangle_hit(surface_offset, corners, opacity, first + firstTrailingBit(triangles), ray, nearest);
            triangles &= triangles - 1u;
        }
    }
    return nearest;
}

/// True while a camera ray is traced: it intersects the triangles of meshes that are lit by their field.
var<private> is_camera_ray: bool = true;

/// Distance from the triangles of an instance at which other rays start off, metres: above zero if it is lit by its field.
fn mesh_clearance(instance: u32) -> f32 {
    return mesh_float(instance + 19u);
}

/// First hit of a ray with the triangles of all meshes, or the one found before.
fn mesh_hit(origin: vec3f, direction: vec3f, before: AnalyticHit) -> AnalyticHit {
    var nearest = before;
    let inverse = 1.0 / select(direction, vec3f(1e-12), abs(direction) < vec3f(1e-12));
    var node = mesh_word(0u);
    let end = mesh_word(1u);
    while node < end {
        let a = (mesh_vector(node) - origin) * inverse;
        let b = (mesh_vector(node + 4u) - origin) * inverse;
        let first = min(a, b);
        let last = max(a, b);
        let enters = max(max(first.x, first.y), max(first.z, 0.0));
        let leaves = min(min(last.x, last.y), min(last.z, nearest.t));
        // The margin keeps flat boxes.
        let is_passed = enters < leaves + abs(leaves) * 1e-6 + 1e-30;
        let instance = mesh_word(node + 7u);
        loop {
            if !is_passed || instance == 0u {
                break;
            }
            if HAS_LIT_BY_FIELD && !is_camera_ray && mesh_clearance(instance) > 0.0 {
                break;
            }
            let rows = instance_rows(instance);
            let opacity = mesh_word(instance + 18u);
            let hit = surface_hit(mesh_word(instance + 13u), opacity, (origin - mesh_vector(instance)) * rows, direction * rows, nearest.t);
            if hit.t < nearest.t {
                nearest = AnalyticHit(hit.t, MESH + instance, hit.triangle);
            }
            break;
        }
        node = select(mesh_word(node + 3u), node + TOP_NODE_WORDS, is_passed);
    }
    return nearest;
}

/// Surface at a hit of a triangle.
fn mesh_surface(p: vec3f, instance: u32, triangle: u32) -> Surface {
    let rows = instance_rows(instance);
    let scale = mesh_float(instance + 3u);
    let corners = triangle_edges(instance, triangle);
    let size = largest_of_edges(corners[1], corners[2]);
    let normal = normalize(cross(corners[1] / size, corners[2] / size));
    let local = (p - mesh_vector(instance)) * rows;
    return Surface(rows * normal * scale, dot(normal, local - corners[0]) * scale, leaf_of_triangle(instance, triangle), triangle);
}
