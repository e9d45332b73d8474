// Buffers of every kernel. bindings.rs declares the frame, the leaves, the materials and the lights in the memory that suits
// the device.

@group(0) @binding(1) var<uniform> slice: Slice;
/// Sums of radiance in xyz; w counts rejected samples, which are not finite.
@group(0) @binding(6) var<storage, read_write> film: array<vec4f>;
/// Tables of 32-bit words, at offsets that are constants of the kernel.
@group(0) @binding(7) var<storage, read> scene_data: array<u32>;
/// Texels of the environment map, row by row from the zenith; behind them the light tree, if it is not in uniform memory.
@group(0) @binding(8) var<storage, read> scene_vectors: array<vec4f>;
