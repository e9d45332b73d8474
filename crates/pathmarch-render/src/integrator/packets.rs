//! Packets: the paths of eight pixels stay in SIMD lanes from the camera to their ends.
//!
//! **Idea.** [`path`](super::path) advances hundreds of paths side by side, so that lanes are full although rays and surfaces
//! differ: sphere-traced rays end at different steps, and materials are shaded in different ways. All that a path carries then
//! goes through memory between the parts. Where every ray is intersected in closed form and every surface is shaded in lanes,
//! eight paths can instead do all of it together: their random numbers, rays, surfaces and lights stay in registers. A path
//! that has ended leaves its lane empty.
//!
//! The estimator is that of [`path`](super::path), which serves all other scenes: radiances are equal but for rounding.

use super::camera::{camera_rays_in_lanes, pixel_sampler};
use super::opaque_surfaces::{LightOfPaths, ScatteredPaths, ShadingInputs, shade_lanes};
use super::path::emission_towards;
use super::path_reuse::PathReuse;
use super::path_state::{Path, ROULETTE_DEPTH, clamped_lanes, sky_and_suns};
use super::splitting::camera_ray_index;
use crate::intersect::ray::{Ray, Rays8, lane_of, mask_of, pack, set_bits, transposed, unpack};
use crate::sampling::sobol::{PixelSampler8, pair};
use crate::scene::material::{DELTA, EMITS, GLOWS, LAMBERTIAN};
use crate::scene::{KernelConfig, RenderScene, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, Surfaces8};
use crate::shading::textured_point::TexturedPoint;
use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
use pathmarch_scene::materials::{BsdfInLanes, DiffuseInLanes, MetalInLanes, ParametersInLanes};
use wide::f32x8;

/// Reports whether [`trace`] serves a scene without photons: all of it is intersected in closed form and shaded in lanes.
pub(crate) fn are_possible(scene: &RenderScene, config: &KernelConfig) -> bool {
    let has_surfaces_in_lanes =
        scene.bsdfs.iter().zip(&scene.materials).all(|(bsdf, material)| {
            material.emits() || bsdf.is_some_and(|bsdf| bsdf.in_lanes.is_some())
        });
    let is_closed_form = !scene.is_sphere_traced() && !scene.field.has_triangles() && !config.mesh_fields;
    let is_plain = !config.media && !config.absorption && !config.penumbra && !config.shading_normals;
    has_surfaces_in_lanes && is_closed_form && is_plain && !config.transmission
}

/// Radiance of samples of these pixels, as [`path::trace`](super::path::trace).
pub(super) fn trace(
    ctx: &TraceContext,
    pixels: &[(u32, u32)],
    first: u32,
    samples: u32,
    mut reuse: Option<PathReuse>,
) -> Vec<Vec3> {
    let mut radiance = vec![Vec3::ZERO; pixels.len() * samples as usize];
    let ray_index = camera_ray_index(first, ctx.config.splitting);
    for (chunk_index, chunk) in pixels.chunks(8).enumerate() {
        let mut camera_packet = Packet::at_camera(ctx, chunk, ray_index);
        let surfaces = camera_packet.intersect(ctx, 0);
        for k in 0..samples {
            let slot = |lane: usize| (8 * chunk_index + lane) * samples as usize + k as usize;
            let mut packet = camera_packet;
            packet.first_slot = slot(0);
            packet.slot_step = samples as usize;
            if ctx.config.splitting > 1 {
                packet.samplers = packet.samplers.with_sample(first + k);
            }
            packet.follow(ctx, surfaces, 0, reuse.as_mut());
            for (lane, value) in unpack(packet.radiance).into_iter().enumerate().take(chunk.len()) {
                radiance[slot(lane)] = value;
            }
        }
    }
    if let Some(reuse) = reuse {
        reuse.share(ctx, &mut radiance);
    }
    radiance
}

/// Eight paths; see [`Path`] for what they carry.
#[derive(Clone, Copy)]
struct Packet {
    /// Index of the first path among those of the pixels, and the step to that of the next lane.
    first_slot: usize,
    slot_step: usize,
    samplers: PixelSampler8,
    /// Paths that have not ended, a bit for each.
    alive: u32,
    /// Origins of the rays; behind [`intersect`](Self::intersect) the points that they hit.
    origin: FieldVec3<f32x8>,
    direction: FieldVec3<f32x8>,
    previous_vertex: FieldVec3<f32x8>,
    previous_normal: FieldVec3<f32x8>,
    /// Lanes with a previous normal.
    has_previous_normal: u32,
    throughput: FieldVec3<f32x8>,
    length: f32x8,
    scatter_pdf: f32x8,
    /// Radiance so far, W/(m² sr).
    radiance: FieldVec3<f32x8>,
}

impl Packet {
    /// Paths that start at the camera, one for each of these pixels.
    fn at_camera(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> Self {
        let samplers = std::array::from_fn(|lane| {
            let (x, y) = pixels[lane.min(pixels.len() - 1)];
            pixel_sampler(ctx, x, y, sample)
        });
        let samplers = PixelSampler8::new(&samplers);
        let Rays8 { origin, direction, .. } = camera_rays_in_lanes(ctx.frame, pixels, &samplers);
        let zero = FieldVec3::splat(f32x8::ZERO);
        Self {
            first_slot: 0,
            slot_step: 1,
            samplers,
            alive: (1 << pixels.len()) - 1,
            origin,
            direction,
            previous_vertex: origin,
            previous_normal: zero,
            has_previous_normal: 0,
            throughput: FieldVec3::splat(f32x8::ONE),
            length: f32x8::ZERO,
            scatter_pdf: f32x8::ZERO,
            radiance: zero,
        }
    }

    /// Path of a lane.
    fn path(&self, ctx: &TraceContext, lane: usize) -> Path {
        let has_normal = self.has_previous_normal >> lane & 1 == 1;
        Path {
            slot: self.first_slot + lane * self.slot_step,
            sampler: self.samplers.lane(lane),
            ray: Ray { origin: lane_of(self.origin, lane), direction: lane_of(self.direction, lane) },
            previous_vertex: lane_of(self.previous_vertex, lane),
            previous_normal: has_normal.then(|| lane_of(self.previous_normal, lane)),
            throughput: lane_of(self.throughput, lane),
            length: self.length.as_array()[lane],
            scatter_pdf: self.scatter_pdf.as_array()[lane],
            medium: ctx.frame.camera_medium(),
            lights_are_counted: false,
            met_photons: false,
            index_square: 1.0,
            wavelength: None,
        }
    }

    /// Adds radiance to lanes.
    #[inline(always)]
    fn add(&mut self, lanes: u32, radiance: FieldVec3<f32x8>) {
        let zero = FieldVec3::splat(f32x8::ZERO);
        self.radiance = self.radiance + FieldVec3::select(mask_of(lanes), radiance, zero);
    }

    /// Adds the radiances of these lanes, one by one.
    #[inline(always)]
    fn add_each(&mut self, bits: u32, radiance: impl Fn(&Self, usize) -> Vec3) {
        let mut sum = self.radiance;
        for lane in set_bits(bits) {
            let value = radiance(self, lane);
            sum.x.as_mut_array()[lane] += value.x;
            sum.y.as_mut_array()[lane] += value.y;
            sum.z.as_mut_array()[lane] += value.z;
        }
        self.radiance = sum;
    }

    /// Intersects the rays. Paths without a hit end and receive the radiance of the sky. Returns the surfaces of the others.
    #[inline(always)]
    fn intersect(&mut self, ctx: &TraceContext, surface_index: u32) -> Surfaces8 {
        let limit = Real::select(mask_of(self.alive), f32x8::splat(ctx.frame.far), f32x8::splat(-1.0));
        let rays = Rays8 { origin: self.origin, direction: self.direction, limit };
        let (t, leaf) = ctx.scene.field.analytic_hit_before(limit, self.origin, self.direction);
        let hit = t.simd_lt(limit).to_bitmask() & self.alive;
        let missed = self.alive & !hit;
        if missed != 0 {
            let sky = self.sky(ctx, missed);
            self.add(missed, clamped_lanes(ctx, self.throughput.times(sky), surface_index.saturating_sub(1)));
        }
        self.alive = hit;
        // Lanes without a hit take the leaf of another.
        let any = leaf.as_array()[hit.trailing_zeros() as usize & 7].max(0.0);
        let leaf = Real::select(mask_of(hit), leaf, f32x8::splat(any));
        self.length += t;
        self.origin = self.origin + self.direction * t;
        Surfaces8::at_analytic_hits(ctx, &rays, t, leaf)
    }

    /// Radiance of the sky and the suns in these lanes, times its MIS weight.
    #[inline(always)]
    fn sky(&self, ctx: &TraceContext, bits: u32) -> FieldVec3<f32x8> {
        if let Some(radiance) = ctx.scene.sky.constant().filter(|_| ctx.frame.sun_count == 0) {
            return FieldVec3::constant(radiance);
        }
        let mut sky = [Vec3::ZERO; 8];
        let (directions, pdfs) = (unpack(self.direction), self.scatter_pdf.to_array());
        for lane in set_bits(bits) {
            sky[lane] = sky_and_suns(ctx, directions[lane], pdfs[lane]);
        }
        pack(sky)
    }

    /// Follows the paths from these surfaces to their ends.
    fn follow(
        &mut self,
        ctx: &TraceContext,
        mut surfaces: Surfaces8,
        first_surface: u32,
        mut reuse: Option<&mut PathReuse>,
    ) {
        for surface_index in first_surface.. {
            if self.alive == 0 {
                return;
            }
            if let Some(reuse) = reuse.as_deref_mut().filter(|_| surface_index < 2) {
                self.record(ctx, &surfaces, surface_index, reuse);
            }
            let materials = MaterialsOfLanes::new(ctx, &surfaces);
            self.add_each(materials.emitting & self.alive, |packet, lane| {
                let interaction = packet.interaction(&surfaces, lane);
                emission_towards(ctx, &packet.path(ctx, lane), &interaction, surface_index)
            });
            self.alive &= !materials.ending;
            if self.alive == 0 || surface_index > ctx.frame.bounces {
                return;
            }
            let parts = if surface_index == 0 { ctx.config.indirect_samples } else { 1 };
            if parts > 1 {
                let arriving = Self { radiance: FieldVec3::splat(f32x8::ZERO), ..*self };
                for part in 0..parts {
                    let mut leaving = arriving;
                    leaving.scatter(ctx, &surfaces, &materials, (surface_index, part));
                    leaving.samplers = leaving.samplers.part(part, parts);
                    leaving.throughput = leaving.throughput / f32x8::splat(parts as f32);
                    let surfaces = leaving.intersect(ctx, surface_index + 1);
                    leaving.follow(ctx, surfaces, surface_index + 1, None);
                    self.radiance = self.radiance + leaving.radiance;
                }
                return;
            }
            self.scatter(ctx, &surfaces, &materials, (surface_index, 0));
            surfaces = self.intersect(ctx, surface_index + 1);
        }
    }

    /// Records first or second surfaces for the reuse of paths.
    fn record(&mut self, ctx: &TraceContext, surfaces: &Surfaces8, surface_index: u32, reuse: &mut PathReuse) {
        let radiance = unpack(self.radiance);
        let mut shared = 0;
        for lane in set_bits(self.alive) {
            let (path, interaction) = (self.path(ctx, lane), self.interaction(surfaces, lane));
            shared |= u32::from(reuse.record(ctx, &path, &interaction, surface_index, radiance[lane])) << lane;
        }
        let shared = mask_of(shared);
        self.radiance = FieldVec3::select(shared, FieldVec3::splat(f32x8::ZERO), self.radiance);
        self.throughput = FieldVec3::select(shared, FieldVec3::splat(f32x8::ONE), self.throughput);
    }

    /// Surface of a lane.
    fn interaction(&self, surfaces: &Surfaces8, lane: usize) -> SurfaceInteraction {
        SurfaceInteraction { length: self.length.as_array()[lane], ..surfaces.interaction(lane) }
    }

    /// Samples a light and the next ray of each path, as part of several. Paths may end.
    #[inline(always)]
    fn scatter(
        &mut self,
        ctx: &TraceContext,
        surfaces: &Surfaces8,
        materials: &MaterialsOfLanes,
        (surface_index, part): (u32, u32),
    ) {
        let light_samples = match (surface_index, part) {
            (0, 0) => ctx.config.light_samples,
            (_, 0) => 1,
            _ => 0,
        };
        let random =
            |samplers: &PixelSampler8, pair| samplers.sample_2d(pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index + pair);
        let chooses = light_samples > 0 && (ctx.scene.lights.len() > 1 || surface_index > ROULETTE_DEPTH);
        let samples_lights = self.alive & !materials.delta;
        let parts = if surface_index == 0 { ctx.config.indirect_samples } else { 1 };
        let inputs = ShadingInputs {
            origin: surfaces.p + surfaces.normal_offset,
            normal: surfaces.normal,
            shading_normal: surfaces.normal,
            to_viewer: -self.direction,
            throughput: self.throughput,
            index_square: f32x8::ONE,
            choice: if chooses { random(&self.samplers, pair::PAIR_CHOICE) } else { [f32x8::ZERO; 2] },
            light: if light_samples > 0 { random(&self.samplers, pair::PAIR_LIGHT) } else { [f32x8::ZERO; 2] },
            scatter: random(&self.samplers.part(part, parts), pair::PAIR_SCATTER),
        };
        let arriving = *self;
        self.alive = 0;
        let (diffuse, metal) = (arriving.alive & materials.diffuse, arriving.alive & !materials.diffuse);
        if diffuse != 0 {
            let samples = (light_samples, samples_lights & diffuse);
            self.scatter_kind::<DiffuseInLanes>(ctx, &arriving, surfaces, &inputs, diffuse, samples, surface_index);
        }
        if metal != 0 {
            let samples = (light_samples, samples_lights & metal);
            self.scatter_kind::<MetalInLanes>(ctx, &arriving, surfaces, &inputs, metal, samples, surface_index);
        }
        self.has_previous_normal |= samples_lights;
        let samples_lights = mask_of(samples_lights);
        self.previous_vertex = FieldVec3::select(samples_lights, inputs.origin, self.previous_vertex);
        self.previous_normal = FieldVec3::select(samples_lights, inputs.shading_normal, self.previous_normal);
        self.origin = inputs.origin;
    }

    /// [`scatter`](Self::scatter) for the lanes with a kind of material.
    #[inline(always)]
    fn scatter_kind<B: BsdfInLanes>(
        &mut self,
        ctx: &TraceContext,
        arriving: &Self,
        surfaces: &Surfaces8,
        inputs: &ShadingInputs,
        bits: u32,
        (light_samples, samples_lights): (u32, u32),
        surface_index: u32,
    ) {
        let parameters = arriving.parameters::<B>(ctx, surfaces, bits);
        let light_samples = (if samples_lights == 0 { 0 } else { light_samples }, samples_lights);
        let ScatteredPaths { direction, throughput, pdf, goes_on } =
            shade_lanes::<B>(ctx, inputs, &parameters, light_samples, surface_index, |light| {
                self.test_light(ctx, inputs.origin, light, samples_lights, surface_index);
            });
        let lanes = mask_of(bits);
        self.direction = FieldVec3::select(lanes, direction, self.direction);
        self.throughput = FieldVec3::select(lanes, throughput, self.throughput);
        self.scatter_pdf = Real::select(lanes, pdf, self.scatter_pdf);
        self.alive |= goes_on & bits;
    }

    /// Adds the light of light samples that nothing occludes.
    #[inline(always)]
    fn test_light(
        &mut self,
        ctx: &TraceContext,
        origin: FieldVec3<f32x8>,
        light: &LightOfPaths,
        samples_lights: u32,
        surface_index: u32,
    ) {
        let lit = light.lit & samples_lights;
        if lit == 0 {
            return;
        }
        let limit = light.distance.fast_min(f32x8::splat(ctx.frame.far));
        let limit = Real::select(mask_of(lit), limit, f32x8::splat(-1.0));
        let (t, leaf) = ctx.scene.field.analytic_hit_before(limit, origin, light.direction);
        let hit = t.simd_lt(limit).to_bitmask();
        let mut seen = lit & !hit;
        for lane in set_bits(lit) {
            if let Some(target) = light.shapes[lane].target() {
                let is_target = hit >> lane & 1 == 1
                    && leaf.as_array()[lane] as u32 == target
                    && ctx.scene.emits_towards(target as usize, -lane_of(light.direction, lane));
                seen = seen & !(1 << lane) | u32::from(is_target) << lane;
            }
        }
        self.add(seen, clamped_lanes(ctx, light.radiance * light.weight, surface_index));
    }

    /// Parameters of the materials of these lanes.
    #[inline(always)]
    fn parameters<B: BsdfInLanes>(&self, ctx: &TraceContext, surfaces: &Surfaces8, bits: u32) -> ParametersInLanes {
        let any = bits.trailing_zeros() as usize & 7;
        let material = |lane: usize| {
            let lane = if bits >> lane & 1 == 1 { lane } else { any };
            ctx.scene.material_of(surfaces.leaf[lane])
        };
        let mut rows = [[0.0; 8]; 8];
        for (lane, row) in rows.iter_mut().enumerate() {
            row.copy_from_slice(&material(lane).parameters[..8]);
        }
        let mut parameters = transposed(rows);
        if ctx.config.textures {
            for lane in set_bits(bits) {
                let interaction = self.interaction(surfaces, lane);
                if let Some(textured) = TexturedPoint::new(ctx, &interaction, interaction.length) {
                    let own = textured.parameters(&material(lane).parameters);
                    for (parameter, value) in parameters.iter_mut().zip(&own[..B::PARAMETERS]) {
                        parameter.as_mut_array()[lane] = *value;
                    }
                }
            }
        }
        parameters
    }
}

/// Lanes by what their materials do, a bit for each.
struct MaterialsOfLanes {
    /// Emits light.
    emitting: u32,
    /// Scatters no light.
    ending: u32,
    /// Samples no lights.
    delta: u32,
    /// Diffuse; the others that scatter are metal.
    diffuse: u32,
}

impl MaterialsOfLanes {
    #[inline(always)]
    fn new(ctx: &TraceContext, surfaces: &Surfaces8) -> Self {
        let mut result = Self { emitting: 0, ending: 0, delta: 0, diffuse: 0 };
        for lane in 0..8 {
            let flags = ctx.scene.material_of(surfaces.leaf[lane]).flags;
            let bit = |flag: u32| u32::from(flags & flag != 0) << lane;
            result.emitting |= bit(EMITS | GLOWS);
            result.ending |= bit(EMITS);
            result.delta |= bit(DELTA);
            result.diffuse |= bit(LAMBERTIAN);
        }
        result
    }
}
