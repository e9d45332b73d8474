// Light tree in storage memory, as vectors.

fn light_node(index: u32) -> LightNode {
    let start = LIGHT_TREE_DATA + 4u * index;
    let sphere_a = scene_vector(start);
    let sphere_b = scene_vector(start + 1u);
    let axis_a = scene_vector(start + 2u);
    let axis_b = scene_vector(start + 3u);
    return LightNode(sphere_a.xyz, sphere_a.w, sphere_b.xyz, sphere_b.w, axis_a.xyz, axis_a.w, axis_b.xyz, axis_b.w);
}
