// Albedo without textures. Takes the place of textured_albedo.wgsl.

const textured_albedo = vec4f(0.0);
