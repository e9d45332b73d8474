// Light tree in uniform memory.

fn light_node(index: u32) -> LightNode {
    return light_nodes[index];
}
