// Buffers of every kernel. bindings.rs declares the frame, the film and the tables of the scene in the memory that suits the
// device, and functions that read them: `film_sum(pixel)` and `store_film(pixel, sum)` for sums of radiance in xyz and the
// number of rejected samples, which are not finite, in w; `scene_word(index)` for tables of 32-bit words, at offsets that are
// constants of the kernel; `scene_vector(index)` for texels of the environment map, row by row from the zenith, behind them the
// light tree, if it is not in uniform memory, and photons.

@group(0) @binding(1) var<uniform> slice: Slice;
