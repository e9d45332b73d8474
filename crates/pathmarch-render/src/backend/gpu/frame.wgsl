// What every ray of a picture shares: the bindings of the kernel. Twin of the records in frame.rs.

struct Frame {
    position: vec3f,
    lens_radius: f32,
    right: vec3f,
    focus: f32,
    up: vec3f,
    tolerance: f32,
    forward: vec3f,
    rounding: f32,
    /// What the camera stands in absorbs, per metre.
    medium: vec3f,
    step_factor: f32,
    bounds_min: vec3f,
    far: f32,
    bounds_max: vec3f,
    light_count: u32,
    width: u32,
    height: u32,
    bounces: u32,
    seed: u32,
    /// The largest contribution of light that bounced.
    clamp: f32,
    /// Lights that are suns; they come first.
    sun_count: u32,
    sampler: u32,
    sky_width: u32,
    /// Straight up, or everywhere.
    sky_zenith: vec3f,
    sky_height: u32,
    sky_horizon: vec3f,
    /// Density of a direction of the picture over the mean luminance of the texels around it.
    sky_density: f32,
    sky_ground: vec3f,
    /// Sine of the depth at which the ground has its own colour.
    sky_edge: f32,
    /// Of the picture's turn.
    sky_sine: f32,
    sky_cosine: f32,
    /// What a pixel covers at the end of a path of one metre.
    pixel: f32,
}

/// Which samples of which rows a dispatch computes.
struct Slice {
    /// The first of them.
    sample: u32,
    /// How many; one, but for those that share a ray of the camera.
    samples: u32,
    first_row: u32,
    rows: u32,
    first_column: u32,
    /// How many columns.
    columns: u32,
    /// Place of the first path among those that may be suspended.
    first_slot: u32,
}

/// What is known of a leaf of the field.
struct LeafRecord {
    /// Where a sheet faces.
    facing: vec3f,
    material: u32,
    at: vec3f,
    flags: u32,
}

/// A surface without thickness, which emits on one side.
const SHEET = 1u;
/// Rays meet it in closed form.
const DIRECT = 2u;
/// Where one more than the index of the leaf's light starts in the flags.
const LIGHT_SHIFT = 3u;
/// The leaf is in one solid with a material that transmits, so that paths come to it from inside.
const IN_GLASS = 4u;

struct Material {
    emission: vec3f,
    flags: u32,
    /// What the inside absorbs, per metre.
    absorption: vec3f,
    kind: u32,
    /// What its scattering functions read, by way of `packed`.
    numbers: array<vec4f, 8>,
}

const EMITS = 1u;
/// Scatters in single directions only: no light is sampled there.
const DELTA = 2u;
/// Light passes to the other side.
const TRANSMITS = 4u;

// gpu/memory.rs declares the frame, the leaves and the materials, in the memory that suits the device.

@group(0) @binding(1) var<uniform> slice: Slice;
/// Sums of radiance; the fourth number counts samples that were not finite and were left out.
@group(0) @binding(6) var<storage, read_write> film: array<vec4f>;
/// Tables of numbers, at the places that the constants of the scene say.
@group(0) @binding(7) var<storage, read> tables: array<u32>;
/// The sky's picture, row by row from straight up.
@group(0) @binding(8) var<storage, read> sky_texels: array<vec4f>;
