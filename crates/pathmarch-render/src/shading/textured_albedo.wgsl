// What varies of the colour that people are shown. Twin of `Painted::colour` in paint.rs.

/// Of the surface that was met last; w is 0 where it does not vary.
var<private> painted_colour: vec4f;

fn start_paint(m: u32) {
    painted_colour = vec4f(0.0);
}

fn apply_layer(layer: u32, shown: vec4f) {
    if tables[layer + 1u] != PACKED_LAYER && tables[layer + 2u] == 0u {
        painted_colour = vec4f(layer_colour(layer, shown), 1.0);
    }
}
