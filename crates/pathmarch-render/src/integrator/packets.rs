//! Packets: the paths of eight pixels stay in SIMD lanes from the camera to their ends.
//!
//! **Idea.** [`path`](super::path) advances hundreds of paths side by side, so that lanes are full although rays and surfaces
//! differ: sphere-traced rays end at different steps, and materials are shaded in different ways. All that a path carries then
//! goes through memory between the parts. Where every ray is intersected in closed form, eight paths can instead do all of it
//! together: their random numbers, rays, surfaces and lights stay in registers, but for materials that are shaded one by one. A
//! path that has ended leaves its lane to one of another packet: before each surface, the packets of a tile become as few as
//! possible.
//!
//! The estimator is that of [`path`](super::path), which serves all other scenes ([`KernelConfig::packets`]) and pictures with
//! photons: radiances and guides are equal but for rounding.

use super::camera::{camera_rays_in_lanes, pixel_sampler};
use super::guides::{Guide, GuideRecorder};
use super::medium::transmittance;
use super::opaque_surfaces::{LightOfPaths, ScatteredPaths, ShadingInputs, kind_in_lanes, roulette, shade_lanes};
use super::participating_media::medium_after;
use super::path::{self, emission_towards, shade, with_shared_light};
use super::path_reuse::PathReuse;
use super::path_state::{Path, ROULETTE_DEPTH, clamped, clamped_lanes, escaped_radiance};
use super::shadow::{ShadowTest, direct_light};
use super::splitting::camera_ray_index;
use super::surface_samples::SurfaceSample;
use crate::intersect::ray::{Ray, Rays8, lane_of, mask_of, pack, set_bits, set_lane, unpack};
use crate::sampling::basis::Basis8;
use crate::sampling::sobol::{PixelSampler8, pair};
#[cfg(any(doc, test))]
use crate::scene::KernelConfig;
use crate::scene::material::{CLEAR, DELTA, EMITS, GLOWS};
use crate::scene::{Medium, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, Surfaces8};
use crate::shading::textured_point::{TexturedPoint, parameters_of_eight};
use glam::Vec3;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use pathmarch_scene::materials::{
    BsdfInLanes, BsdfParameters, DiffuseInLanes, KindInLanes, MetalInLanes, ParametersInLanes, PrincipledInLanes,
    SmoothInLanes, SmoothSampleInLanes,
};
use wide::f32x8;

/// Radiance of samples of these pixels, as [`path::trace`], which traces them where packets cannot.
pub(crate) fn trace(ctx: &TraceContext, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
    if !are_possible(ctx) {
        return path::trace(ctx, pixels, first, samples);
    }
    let packets = packets_at_camera(ctx, pixels, camera_ray_index(first, ctx.config.splitting));
    let mut records = Records { reuse: ctx.config.path_reuse.then(|| PathReuse::new(pixels, samples)), guides: None };
    let mut radiance = vec![Vec3::ZERO; pixels.len() * samples as usize];
    follow(ctx, packets, (first, samples), &mut radiance, &mut records);
    with_shared_light(ctx, records.reuse, radiance).0
}

/// Radiance of one sample of each of these pixels and their guides, as [`path::trace_with_guides`], which traces them where
/// packets cannot.
pub(crate) fn trace_with_guides(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> (Vec<Vec3>, Vec<Guide>) {
    if !are_possible(ctx) {
        return path::trace_with_guides(ctx, pixels, sample);
    }
    let packets = packets_at_camera(ctx, pixels, sample);
    let rays = packets.iter().flat_map(|packet| set_bits(packet.alive).map(|lane| packet.ray(lane))).collect();
    let mut records = Records {
        reuse: ctx.config.path_reuse.then(|| PathReuse::new(pixels, 1)),
        guides: Some(GuideRecorder::new(ctx, rays)),
    };
    let mut radiance = vec![Vec3::ZERO; pixels.len()];
    follow(ctx, packets, (sample, 1), &mut radiance, &mut records);
    let (radiance, shared) = with_shared_light(ctx, records.reuse, radiance);
    let guides = records.guides.map_or(Vec::new(), |guides| guides.into_guides(ctx, &radiance, shared.as_deref()));
    (radiance, guides)
}

/// Reports whether packets can trace a picture.
fn are_possible(ctx: &TraceContext) -> bool {
    ctx.config.packets && ctx.photons.is_none() && ctx.stats.is_none()
}

/// Packets of a sample of these pixels, at the camera.
fn packets_at_camera(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> Vec<Packet> {
    let start = |(k, chunk): (usize, &[(u32, u32)])| Packet::at_camera(ctx, chunk, 8 * k, sample);
    pixels.chunks(8).enumerate().map(start).collect()
}

/// What is recorded of paths beside their radiance.
struct Records<'a> {
    /// Light that pixels share.
    reuse: Option<PathReuse<'a>>,
    guides: Option<GuideRecorder>,
}

/// Follows paths from the camera to their ends: `samples` from index `first` on that share each camera ray. Adds their radiance.
fn follow(
    ctx: &TraceContext,
    mut at_camera: Vec<Packet>,
    (first, samples): (u32, u32),
    radiance: &mut [Vec3],
    records: &mut Records,
) {
    let surfaces: Vec<Option<Surfaces8>> = at_camera.iter_mut().map(|packet| packet.intersect(ctx, 0)).collect();
    for k in 0..samples {
        for part in 0..ctx.config.indirect_samples {
            let leave = |(packet, surfaces): (&Packet, &Option<Surfaces8>)| {
                let mut packet = *packet;
                for slot in &mut packet.slots {
                    *slot = *slot * samples + k;
                }
                if ctx.config.splitting > 1 {
                    packet.samplers = packet.samplers.with_sample(first + k);
                }
                packet.leave_first_surface(ctx, surfaces.as_ref(), part, records);
                packet
            };
            let mut packets: Vec<Packet> = at_camera.iter().zip(&surfaces).map(leave).collect();
            for surface_index in 1.. {
                compact(&mut packets, radiance);
                if packets.is_empty() {
                    break;
                }
                for packet in &mut packets {
                    if let Some(surfaces) = packet.intersect(ctx, surface_index) {
                        packet.pass_surface(ctx, &surfaces, surface_index, 0, records);
                    }
                }
            }
        }
    }
}

/// Adds the radiances of paths that have ended to those of their slots, and fills the lanes with paths of other packets.
fn compact(packets: &mut Vec<Packet>, radiance: &mut [Vec3]) {
    packets.retain_mut(|packet| {
        for lane in set_bits(packet.taken & !packet.alive) {
            radiance[packet.slots[lane] as usize] += lane_of(packet.radiance, lane);
        }
        packet.taken = packet.alive;
        packet.alive != 0
    });
    let mut first = 0;
    while first + 1 < packets.len() {
        let end = packets.len() - 1;
        let (before, last) = packets.split_at_mut(end);
        let (packet, last) = (&mut before[first], &mut last[0]);
        match set_bits(!packet.alive & 0xff).next() {
            None => first += 1,
            Some(lane) => {
                packet.take_path(lane, last);
                if last.alive == 0 {
                    packets.pop();
                }
            }
        }
    }
}

/// Eight paths; see [`Path`] for what they carry.
#[derive(Clone, Copy)]
struct Packet {
    /// Indices of the paths among those of the pixels.
    slots: [u32; 8],
    samplers: PixelSampler8,
    /// Lanes with a path whose radiance is not yet in its slot, a bit for each.
    taken: u32,
    /// Those of paths that have not ended.
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
    /// Lanes whose [`Path::lights_are_counted`], a bit for each.
    lights_are_counted: u32,
    index_square: f32x8,
    /// The media that absorb; those around the camera where none does.
    media: [Medium; 8],
    /// Radiance so far, W/(m² sr).
    radiance: FieldVec3<f32x8>,
}

impl Packet {
    /// Paths that start at the camera, one for each of these pixels, whose indices start at `first`.
    fn at_camera(ctx: &TraceContext, pixels: &[(u32, u32)], first: usize, sample: u32) -> Self {
        let samplers = std::array::from_fn(|lane| {
            let (x, y) = pixels[lane.min(pixels.len() - 1)];
            pixel_sampler(ctx, x, y, sample)
        });
        let samplers = PixelSampler8::new(&samplers);
        let Rays8 { origin, direction, .. } = camera_rays_in_lanes(ctx.frame, pixels, &samplers);
        let zero = FieldVec3::splat(f32x8::ZERO);
        Self {
            slots: std::array::from_fn(|lane| (first + lane) as u32),
            samplers,
            taken: (1 << pixels.len()) - 1,
            alive: (1 << pixels.len()) - 1,
            origin,
            direction,
            previous_vertex: origin,
            previous_normal: zero,
            has_previous_normal: 0,
            throughput: FieldVec3::splat(f32x8::ONE),
            length: f32x8::ZERO,
            scatter_pdf: f32x8::ZERO,
            lights_are_counted: 0,
            index_square: f32x8::ONE,
            media: [ctx.frame.camera_medium(); 8],
            radiance: zero,
        }
    }

    /// Ray of a lane.
    fn ray(&self, lane: usize) -> Ray {
        Ray { origin: lane_of(self.origin, lane), direction: lane_of(self.direction, lane) }
    }

    /// Path of a lane.
    fn path(&self, lane: usize) -> Path {
        let has_normal = self.has_previous_normal >> lane & 1 == 1;
        Path {
            slot: self.slots[lane] as usize,
            sampler: self.samplers.lane(lane),
            ray: self.ray(lane),
            previous_vertex: lane_of(self.previous_vertex, lane),
            previous_normal: has_normal.then(|| lane_of(self.previous_normal, lane)),
            throughput: lane_of(self.throughput, lane),
            length: self.length.as_array()[lane],
            scatter_pdf: self.scatter_pdf.as_array()[lane],
            medium: self.media[lane],
            lights_are_counted: self.lights_are_counted >> lane & 1 == 1,
            met_photons: false,
            index_square: self.index_square.as_array()[lane],
            wavelength: None,
        }
    }

    /// Puts a path that has left its surface back into its lane.
    fn put(&mut self, lane: usize, path: &Path) {
        set_lane(&mut self.origin, lane, path.ray.origin);
        set_lane(&mut self.direction, lane, path.ray.direction);
        set_lane(&mut self.previous_vertex, lane, path.previous_vertex);
        set_lane(&mut self.previous_normal, lane, path.previous_normal.unwrap_or_default());
        set_lane(&mut self.throughput, lane, path.throughput);
        self.scatter_pdf.as_mut_array()[lane] = path.scatter_pdf;
        self.index_square.as_mut_array()[lane] = path.index_square;
        self.media[lane] = path.medium;
        let with_bit = |bits: u32, bit: bool| bits & !(1 << lane) | u32::from(bit) << lane;
        self.has_previous_normal = with_bit(self.has_previous_normal, path.previous_normal.is_some());
        self.lights_are_counted = with_bit(self.lights_are_counted, path.lights_are_counted);
    }

    /// Moves the first path of another packet, whose sampler has the same sample, into a free lane.
    fn take_path(&mut self, lane: usize, other: &mut Self) {
        let from = other.alive.trailing_zeros() as usize;
        let path = other.path(from);
        self.put(lane, &path);
        self.slots[lane] = other.slots[from];
        self.samplers.put(lane, path.sampler);
        self.length.as_mut_array()[lane] = path.length;
        set_lane(&mut self.radiance, lane, lane_of(other.radiance, from));
        self.taken |= 1 << lane;
        self.alive |= 1 << lane;
        other.taken &= !(1 << from);
        other.alive &= !(1 << from);
    }

    /// Lanes in a medium that absorbs.
    #[inline(always)]
    fn absorbed(&self, ctx: &TraceContext) -> u32 {
        if !ctx.config.absorption {
            return 0;
        }
        (0..8).map(|lane| u32::from(self.media[lane].absorption != Vec3::ZERO) << lane).sum()
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
            let value = lane_of(sum, lane) + radiance(self, lane);
            set_lane(&mut sum, lane, value);
        }
        self.radiance = sum;
    }

    /// Intersects the rays. Paths without a hit end and receive the radiance of the sky. Returns the surfaces of the others, if
    /// there are any.
    #[inline(always)]
    fn intersect(&mut self, ctx: &TraceContext, surface_index: u32) -> Option<Surfaces8> {
        let limit = Real::select(mask_of(self.alive), f32x8::splat(ctx.frame.far), f32x8::splat(-1.0));
        let rays = Rays8 { origin: self.origin, direction: self.direction, limit };
        let (t, leaf) = ctx.scene.field.analytic_hit_before(limit, self.origin, self.direction);
        let hit = t.simd_lt(limit).to_bitmask() & self.alive;
        let missed = self.alive & !hit;
        for lane in set_bits(self.absorbed(ctx) & self.alive) {
            let length = if hit >> lane & 1 == 1 { t.as_array()[lane] } else { f32::INFINITY };
            let factor = transmittance(self.media[lane].absorption, length);
            let throughput = lane_of(self.throughput, lane) * factor;
            set_lane(&mut self.throughput, lane, throughput);
        }
        if missed != 0 {
            let sky = self.sky(ctx, missed);
            self.add(missed, clamped_lanes(ctx, self.throughput.times(sky), surface_index.saturating_sub(1)));
        }
        self.alive = hit;
        if hit == 0 {
            return None;
        }
        // Lanes without a hit take the leaf of another.
        let any = leaf.as_array()[hit.trailing_zeros() as usize];
        let leaf = Real::select(mask_of(hit), leaf, f32x8::splat(any));
        self.length += t;
        self.origin = self.origin + self.direction * t;
        Some(Surfaces8::at_analytic_hits(ctx, &rays, t, leaf))
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
            let are_counted = self.lights_are_counted >> lane & 1 == 1;
            sky[lane] = escaped_radiance(ctx, are_counted, directions[lane], pdfs[lane]);
        }
        pack(sky)
    }

    /// Lets the paths leave their first surfaces as part of several; only the first part receives the light that they emit.
    fn leave_first_surface(
        &mut self,
        ctx: &TraceContext,
        surfaces: Option<&Surfaces8>,
        part: u32,
        records: &mut Records,
    ) {
        let parts = ctx.config.indirect_samples;
        if part > 0 {
            self.radiance = FieldVec3::splat(f32x8::ZERO);
        }
        if let Some(surfaces) = surfaces {
            self.pass_surface(ctx, surfaces, 0, part, records);
        }
        if parts > 1 {
            self.samplers = self.samplers.part(part, parts);
            self.throughput = self.throughput / f32x8::splat(parts as f32);
        }
    }

    /// Adds the light that surfaces emit, and samples lights and the next rays, as part of several. Paths may end.
    fn pass_surface(
        &mut self,
        ctx: &TraceContext,
        surfaces: &Surfaces8,
        surface_index: u32,
        part: u32,
        records: &mut Records,
    ) {
        if let Some(guides) = &mut records.guides {
            self.record_guides(ctx, surfaces, surface_index, guides);
        }
        if let Some(reuse) = records.reuse.as_mut().filter(|_| surface_index < 2) {
            self.record(ctx, surfaces, surface_index, reuse);
        }
        let materials = MaterialsOfLanes::new(ctx, surfaces);
        if part == 0 {
            self.add_each(materials.emitting & self.alive, |packet, lane| {
                let interaction = packet.interaction(surfaces, lane);
                emission_towards(ctx, &packet.path(lane), &interaction, surface_index)
            });
        }
        self.alive &= !materials.ending;
        if surface_index > ctx.frame.bounces {
            self.alive = 0;
        }
        if self.alive != 0 {
            self.scatter(ctx, surfaces, &materials, (surface_index, part), records.guides.as_mut());
        }
        if let Some(guides) = &mut records.guides {
            for lane in set_bits(self.alive) {
                let (direction, radiance) = (lane_of(self.direction, lane), lane_of(self.radiance, lane));
                guides.reflections.go_on(self.slots[lane] as usize, direction, radiance);
            }
        }
    }

    /// Records surfaces for the guides of paths.
    fn record_guides(&self, ctx: &TraceContext, surfaces: &Surfaces8, surface_index: u32, guides: &mut GuideRecorder) {
        for lane in set_bits(self.alive) {
            let slot = self.slots[lane] as usize;
            guides.reflections.arrive(slot, self.length.as_array()[lane]);
            if guides.waits(slot) {
                let (path, interaction) = (self.path(lane), self.interaction(surfaces, lane));
                let (throughput, radiance) = (path.throughput, lane_of(self.radiance, lane));
                guides.record(ctx, &path, throughput, &interaction, surface_index, radiance);
            }
        }
    }

    /// Records first or second surfaces for the reuse of paths.
    fn record(&mut self, ctx: &TraceContext, surfaces: &Surfaces8, surface_index: u32, reuse: &mut PathReuse) {
        let radiance = unpack(self.radiance);
        let mut shared = 0;
        for lane in set_bits(self.alive) {
            let (path, interaction) = (self.path(lane), self.interaction(surfaces, lane));
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
        mut guides: Option<&mut GuideRecorder>,
    ) {
        let light_samples = match (surface_index, part) {
            (0, 0) => ctx.config.light_samples,
            (_, 0) => 1,
            _ => 0,
        };
        let random = |samplers: &PixelSampler8, pair| {
            samplers.sample_2d(pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index + pair)
        };
        let chooses = light_samples > 0 && (ctx.scene.lights.len() > 1 || surface_index > ROULETTE_DEPTH);
        let parts = if surface_index == 0 { ctx.config.indirect_samples } else { 1 };
        let samplers = self.samplers.part(part, parts);
        let [diffuse, metal, principled, smooth] =
            [materials.diffuse, materials.metal, materials.principled, materials.smooth]
                .map(|lanes| self.alive & lanes);
        let in_lanes = diffuse | metal | principled;
        let others = self.alive & !in_lanes & !smooth;
        let samples_lights = in_lanes & !materials.delta;
        let lobe = match ctx.config.chooses_lobes && (principled | smooth | others) != 0 {
            true => random(&samplers, pair::PAIR_LOBE),
            false => [f32x8::ZERO; 2],
        };
        let inputs = ShadingInputs {
            origin: surfaces.p + surfaces.normal_offset,
            normal: surfaces.normal,
            shading_normal: surfaces.normal,
            to_viewer: -self.direction,
            throughput: self.throughput,
            index_square: self.index_square,
            inside: surfaces.inside,
            choice: if chooses { random(&self.samplers, pair::PAIR_CHOICE) } else { [f32x8::ZERO; 2] },
            light: if light_samples > 0 { random(&self.samplers, pair::PAIR_LIGHT) } else { [f32x8::ZERO; 2] },
            scatter: random(&samplers, pair::PAIR_SCATTER),
            lobe: lobe[0],
        };
        let origin = inputs.origin;
        let leaving = Leaving { ctx, surfaces, inputs, light_samples, surface_index };
        self.alive = 0;
        let mut tests = Vec::new();
        if diffuse != 0 {
            self.scatter_kind::<DiffuseInLanes>(&leaving, diffuse, samples_lights & diffuse, &mut tests, None);
        }
        if metal != 0 {
            let guides = guides.as_deref_mut();
            self.scatter_kind::<MetalInLanes>(&leaving, metal, samples_lights & metal, &mut tests, guides);
        }
        if principled != 0 {
            let guides = guides.as_deref_mut();
            let samples_lights = samples_lights & principled;
            self.scatter_kind::<PrincipledInLanes>(&leaving, principled, samples_lights, &mut tests, guides);
        }
        if smooth != 0 {
            self.scatter_smooth(&leaving, smooth);
        }
        if others != 0 {
            self.scatter_each(&leaving, others, lobe[1], &mut tests);
        }
        self.origin = FieldVec3::select(mask_of(in_lanes), origin, self.origin);
        self.lights_are_counted &= smooth | others;
        self.has_previous_normal |= samples_lights;
        let samples_lights = mask_of(samples_lights);
        self.previous_vertex = FieldVec3::select(samples_lights, origin, self.previous_vertex);
        self.previous_normal = FieldVec3::select(samples_lights, surfaces.normal, self.previous_normal);
        if !tests.is_empty() {
            if let Some(guides) = &mut guides {
                guides.reflections.sample_lights(&tests, |test| self.slots[test.slot] as usize);
            }
            for (lane, light) in direct_light(ctx, tests, surface_index) {
                let light = clamped(ctx, light, surface_index);
                self.add_each(1 << lane, |_, _| light);
                if let Some(guides) = &mut guides {
                    guides.reflections.add_sampled(self.slots[lane] as usize, light);
                }
            }
        }
    }

    /// [`scatter`](Self::scatter) for the lanes with a kind of material.
    #[inline(always)]
    fn scatter_kind<B: BsdfInLanes>(
        &mut self,
        leaving: &Leaving,
        bits: u32,
        samples_lights: u32,
        tests: &mut Vec<ShadowTest>,
        mut guides: Option<&mut GuideRecorder>,
    ) {
        let &Leaving { ctx, surfaces, ref inputs, light_samples, surface_index } = leaving;
        let mut textured = [None; 8];
        self.texture(ctx, surfaces, bits, &mut textured);
        let parameters = parameters_of(ctx, surfaces, bits, &textured, B::PARAMETERS);
        let light_samples = (if samples_lights == 0 { 0 } else { light_samples }, samples_lights);
        let ScatteredPaths { direction, throughput, pdf, goes_on } =
            shade_lanes::<B>(ctx, inputs, &parameters, light_samples, surface_index, |light| {
                self.test_light(leaving, light, samples_lights, tests, guides.as_deref_mut());
            });
        let lanes = mask_of(bits);
        self.direction = FieldVec3::select(lanes, direction, self.direction);
        self.throughput = FieldVec3::select(lanes, throughput, self.throughput);
        self.scatter_pdf = Real::select(lanes, pdf, self.scatter_pdf);
        self.alive |= goes_on & bits;
    }

    /// [`scatter`](Self::scatter) for lanes with perfectly smooth glass, for which no light is sampled.
    #[inline(always)]
    fn scatter_smooth(&mut self, leaving: &Leaving, bits: u32) {
        let &Leaving { ctx, surfaces, ref inputs, surface_index, .. } = leaving;
        let first = surfaces.leaf[bits.trailing_zeros() as usize];
        let bsdf = ctx.scene.bsdfs[ctx.scene.leaves[first].material as usize];
        let Some(smooth) = bsdf.and_then(|bsdf| bsdf.smooth_in_lanes) else { return };
        let basis = Basis8::new(inputs.shading_normal);
        let wo = basis.local_viewer(inputs.to_viewer);
        let parameters = parameters_of(ctx, surfaces, bits, &[None; 8], SmoothInLanes::PARAMETERS);
        let SmoothSampleInLanes { wi, weight, eta } =
            (smooth.sample)(&parameters, wo, mask_of(inputs.inside), inputs.lobe);
        let direction = basis.to_world(wi).renormalized();
        let transmitted = Mask8(wi.z.simd_lt(f32x8::ZERO));
        let throughput = self.throughput.times(weight);
        let index_square = self.index_square * (eta * eta);
        let (throughput, survive) = roulette(throughput, index_square, inputs.choice[1], surface_index);
        let origin = FieldVec3::select(transmitted, surfaces.p - surfaces.normal_offset, inputs.origin);
        let transmitted = transmitted.0.to_bitmask() & bits;
        if ctx.config.fast_caustics {
            let has_sampled_lights = self.lights_are_counted | self.scatter_pdf.simd_gt(f32x8::ZERO).to_bitmask();
            self.lights_are_counted = self.lights_are_counted & !bits | has_sampled_lights & transmitted;
        }
        if ctx.config.absorption {
            for lane in set_bits(transmitted) {
                let is_inside = surfaces.inside >> lane & 1 == 1;
                self.media[lane] = medium_after(ctx, &self.media[lane], surfaces.leaf[lane], is_inside);
            }
        }
        let lanes = mask_of(bits);
        self.origin = FieldVec3::select(lanes, origin, self.origin);
        self.direction = FieldVec3::select(lanes, direction, self.direction);
        self.throughput = FieldVec3::select(lanes, throughput, self.throughput);
        self.index_square = Real::select(lanes, index_square, self.index_square);
        self.scatter_pdf = Real::select(lanes, f32x8::ZERO, self.scatter_pdf);
        self.alive |= survive & bits;
    }

    /// [`scatter`](Self::scatter) for lanes with materials that are shaded one by one.
    /// `wavelength` are the random numbers that choose these.
    fn scatter_each(&mut self, leaving: &Leaving, bits: u32, wavelength: f32x8, tests: &mut Vec<ShadowTest>) {
        let &Leaving { ctx, surfaces, ref inputs, light_samples, surface_index } = leaving;
        for lane in set_bits(bits) {
            let of_lane = |numbers: [f32x8; 2]| numbers.map(|number| number.as_array()[lane]);
            let samples = SurfaceSample {
                light_samples,
                choice: of_lane(inputs.choice),
                light: of_lane(inputs.light),
                scatter: of_lane(inputs.scatter),
                lobe: of_lane([inputs.lobe, wavelength]),
            };
            let interaction = self.interaction(surfaces, lane);
            let mut path = Path { slot: lane, ..self.path(lane) };
            // Only photons add radiance here.
            let mut radiance = Vec3::ZERO;
            let next_ray = shade(ctx, &mut path, &interaction, &samples, surface_index, &mut radiance, tests);
            self.put(lane, &path);
            self.alive |= u32::from(next_ray.is_some()) << lane;
        }
    }

    /// Adds the light of light samples that nothing occludes. Those that take more than a look for an occluder become `tests`.
    #[inline(always)]
    fn test_light(
        &mut self,
        leaving: &Leaving,
        light: &LightOfPaths,
        samples_lights: u32,
        tests: &mut Vec<ShadowTest>,
        guides: Option<&mut GuideRecorder>,
    ) {
        let &Leaving { ctx, surface_index, .. } = leaving;
        let origin = leaving.inputs.origin;
        let lit = light.lit & samples_lights;
        let has_target = (0..8).map(|lane| u32::from(light.shapes[lane].target().is_some()) << lane).sum::<u32>();
        let mut apart = lit & (has_target | self.absorbed(ctx));
        let in_lanes = lit & !apart;
        if in_lanes != 0 {
            let limit = light.distance.fast_min(f32x8::splat(ctx.frame.far));
            let limit = Real::select(mask_of(in_lanes), limit, f32x8::splat(-1.0));
            let (t, leaf) = ctx.scene.field.analytic_hit_before(limit, origin, light.direction);
            let hit = t.simd_lt(limit).to_bitmask() & in_lanes;
            if ctx.config.fast_caustics {
                let is_clear =
                    |lane: &usize| ctx.scene.material_of(leaf.as_array()[*lane] as usize).flags & CLEAR == CLEAR;
                apart |= set_bits(hit).filter(is_clear).map(|lane| 1 << lane).sum::<u32>();
            }
            let radiance = clamped_lanes(ctx, light.radiance * light.weight, surface_index);
            self.add(in_lanes & !hit, radiance);
            if let Some(guides) = guides {
                for lane in set_bits(in_lanes & !apart) {
                    let (slot, distance) = (self.slots[lane] as usize, light.distance.as_array()[lane]);
                    guides.reflections.sample_light(slot, lane_of(light.direction, lane), distance);
                    if hit >> lane & 1 == 0 {
                        guides.reflections.add_sampled(slot, lane_of(radiance, lane));
                    }
                }
            }
        }
        for lane in set_bits(apart) {
            let path = Path { slot: lane, ..self.path(lane) };
            tests.push(light.test(lane, &path, lane_of(origin, lane)));
        }
    }

    /// Parameters of the materials of these lanes where textures replace some.
    #[inline(always)]
    fn texture(&self, ctx: &TraceContext, surfaces: &Surfaces8, bits: u32, textured: &mut [Option<BsdfParameters>; 8]) {
        if !ctx.config.textures {
            return;
        }
        let point = |lane: usize| {
            let interaction = (bits >> lane & 1 == 1).then(|| self.interaction(surfaces, lane))?;
            TexturedPoint::new(ctx, &interaction, interaction.length)
        };
        let points: [Option<TexturedPoint>; 8] = std::array::from_fn(point);
        *textured = parameters_of_eight(&points, |lane| &ctx.scene.material_of(surfaces.leaf[lane]).parameters);
    }
}

/// The first `count` parameters of the materials of these lanes, or those that textures give; the others are those of any of them.
#[inline(always)]
fn parameters_of<'a>(
    ctx: &TraceContext<'a>,
    surfaces: &Surfaces8,
    bits: u32,
    textured: &'a [Option<BsdfParameters>; 8],
    count: usize,
) -> ParametersInLanes<'a> {
    let any = bits.trailing_zeros() as usize & 7;
    let of_lane = |lane: usize| {
        let lane = if bits >> lane & 1 == 1 { lane } else { any };
        textured[lane].as_ref().unwrap_or(&ctx.scene.material_of(surfaces.leaf[lane]).parameters)
    };
    ParametersInLanes::new(std::array::from_fn(of_lane), count)
}

/// Surfaces that paths leave.
struct Leaving<'a> {
    ctx: &'a TraceContext<'a>,
    surfaces: &'a Surfaces8,
    inputs: ShadingInputs,
    /// Number of light samples at each surface.
    light_samples: u32,
    surface_index: u32,
}

/// Lanes by what their materials do, a bit for each.
struct MaterialsOfLanes {
    /// Emits light.
    emitting: u32,
    /// Scatters no light.
    ending: u32,
    /// Samples no lights.
    delta: u32,
    diffuse: u32,
    metal: u32,
    principled: u32,
    /// Perfectly smooth glass without textures.
    smooth: u32,
}

impl MaterialsOfLanes {
    #[inline(always)]
    fn new(ctx: &TraceContext, surfaces: &Surfaces8) -> Self {
        let mut result = Self { emitting: 0, ending: 0, delta: 0, diffuse: 0, metal: 0, principled: 0, smooth: 0 };
        for lane in 0..8 {
            let material = ctx.scene.leaves[surfaces.leaf[lane]].material as usize;
            let flags = ctx.scene.materials[material].flags;
            let bit = |flag: u32| u32::from(flags & flag != 0) << lane;
            result.emitting |= bit(EMITS | GLOWS);
            result.ending |= bit(EMITS);
            result.delta |= bit(DELTA);
            let kind = kind_in_lanes(ctx, material);
            let is_kind = |other: KindInLanes| u32::from(kind == Some(other)) << lane;
            result.diffuse |= is_kind(KindInLanes::Diffuse);
            result.metal |= is_kind(KindInLanes::Metal);
            result.principled |= is_kind(KindInLanes::Principled);
            result.smooth |= u32::from(flags & CLEAR == CLEAR && is_smooth_in_lanes(ctx, material)) << lane;
        }
        result
    }
}

/// Reports whether a clear material is sampled in lanes.
fn is_smooth_in_lanes(ctx: &TraceContext, material: usize) -> bool {
    let smooth = ctx.scene.bsdfs[material].and_then(|bsdf| bsdf.smooth_in_lanes);
    let is_plain = !ctx.config.textures || ctx.scene.textured_materials[material].is_plain();
    is_plain && smooth.is_some_and(|smooth| (smooth.is_smooth)(&ctx.scene.materials[material].parameters))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Settings;
    use crate::backend::RenderInput;
    use pathmarch_scene::Scene;

    const LIGHT: &str = "point { at 2 3 2; intensity 20 }
        sky \"gradient\" { zenith 0.3 0.5 1; horizon 1; ground 0.1 }
        sun { direction 1 2 1; irradiance 2; angle 2 }";
    const SURFACES: &str = "material \"red\" { diffuse 0.8 0.3 0.2 }
        material \"steel\" { metal 0.9 0.8 0.7; roughness 0.3 }
        material \"mirror\" { metal 0.9; roughness 0 }
        material \"glass\" { glass 1 }
        material \"green\" { glass 0.9; absorb 2 0.5 2 }
        material \"frosted\" { glass 1; roughness 0.4 }
        material \"pane\" { glass 0.9; thin #true }
        material \"lacquer\" { principled 0.2 0.3 0.8; roughness 0.3 }
        material \"tiles\" { diffuse { checker size=0.5 { colour 0.9; colour 0.2 } } }
        object \"floor\" material=\"tiles\" { plane }
        object \"ball\" material=\"red\" { sphere 0.5 { at -1.2 0.5 0 } }
        object \"drum\" material=\"steel\" { cylinder 0.4 1 { at 0 0.5 -1 } }
        object \"cube\" material=\"mirror\" { box 0.6 { at 1.2 0.4 -1 } }
        object \"lens\" material=\"glass\" { sphere 0.5 { at 0 0.5 0.5 } }
        object \"jelly\" material=\"green\" { subtract { box 0.7; sphere 0.4; at 1.3 0.4 0.4 } }
        object \"bowl\" material=\"frosted\" { sphere 0.3 { at -0.6 0.3 1 } }
        object \"pane\" material=\"pane\" { box 0.5 0.8 0.02 { at 0.7 0.4 1.2 } }
        object \"block\" material=\"lacquer\" { box 0.5 { at -1 0.25 1.3 } }
        material \"lamp\" { emit 4 3 2 }
        object \"lamp\" material=\"lamp\" { sphere 0.3 { at 0.5 2 0.5 } }
        object \"panel\" material=\"lamp\" { rect 0.5 0.5 { normal 0 -1 0; at -1 2 0 } }";

    /// Input of a scene that packets trace.
    fn input_of(scene: &str) -> RenderInput {
        let text = format!("pathmarch 1\ncamera {{ position 0 1.5 5; target 0 0.5 0 }}\n{scene}");
        let scene = Scene::parse("test.kdl", &text).unwrap_or_else(|error| panic!("{error}"));
        let settings = Settings { size: [48, 27], bounces: 7, ..Settings::of(&scene) };
        let input = RenderInput::new(&scene, &settings);
        assert!(input.config.packets);
        input
    }

    fn pixels() -> Vec<(u32, u32)> {
        (0..27).flat_map(|y| (0..48).map(move |x| (x, y))).collect()
    }

    /// Pixels of samples 3 to 6 with and without packets.
    fn both(scene: &str, change: impl Fn(&mut KernelConfig)) -> [Vec<Vec3>; 2] {
        let mut input = input_of(scene);
        change(&mut input.config);
        [true, false].map(|packets| {
            input.config.packets = packets;
            let ctx = input.context(None);
            match input.config.splitting {
                1 => (3..6).flat_map(|sample| trace(&ctx, &pixels(), sample, 1)).collect(),
                count => trace(&ctx, &pixels(), 0, count),
            }
        })
    }

    #[test]
    fn an_empty_scene_has_the_light_of_its_sky() {
        let [packets, one_by_one] = both("sky 0.2 0.3 0.4", |_| {});
        assert_eq!(packets, one_by_one);
        assert!(packets.iter().all(|&radiance| radiance == Vec3::new(0.2, 0.3, 0.4)));
    }

    #[test]
    fn packets_have_the_light_of_paths_one_by_one() {
        let scene = |head: &str| format!("{head}\n{LIGHT}\n{SURFACES}");
        let plain = scene("");
        type Change = fn(&mut KernelConfig);
        let cases: [(&str, String, Change); 6] = [
            ("plain", plain.clone(), |_| {}),
            ("caustics", scene("render { caustics \"fast\" }"), |_| {}),
            ("limited", scene("render { clamp 0.5 }"), |_| {}),
            ("light samples", plain.clone(), |config| (config.light_samples, config.indirect_samples) = (3, 2)),
            ("splitting", plain.clone(), |config| config.splitting = 4),
            ("path reuse", plain, |config| config.path_reuse = true),
        ];
        for (name, scene, change) in cases {
            let [packets, one_by_one] = both(&scene, change);
            let differ = packets.iter().zip(&one_by_one).filter(|(a, b)| a != b).count();
            let largest = packets.iter().zip(&one_by_one).map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f32::max);
            let sum: Vec3 = packets.iter().sum();
            assert!(sum.min_element() > 1.0, "{name}: {sum}");
            // The order of sums differs.
            assert!(largest < 1e-5, "{name}: {differ} of {} differ, by {largest}", packets.len());
        }
    }

    #[test]
    fn shared_light_is_indirect_light_of_the_guides() {
        let mut input = input_of(&format!("{LIGHT}\n{SURFACES}"));
        let [apart, shared] = [false, true].map(|path_reuse| {
            input.config.path_reuse = path_reuse;
            let guides = |sample| trace_with_guides(&input.context(None), &pixels(), sample).1;
            // Where facets reflect, they have a share of it.
            let diffuse = (0..256).flat_map(guides).filter(|guide| !guide.is_glossy);
            diffuse.map(|guide| guide.indirect).sum::<Vec3>()
        });
        let ratio = shared / apart;
        assert!((ratio - 1.0).abs().max_element() < 0.02, "{ratio}");
    }

    #[test]
    fn packets_have_the_guides_of_paths_one_by_one() {
        for (head, path_reuse) in [("", false), ("", true), ("render { caustics \"fast\"; clamp 0.5 }", false)] {
            let mut input = input_of(&format!("{head}\n{LIGHT}\n{SURFACES}"));
            input.config.path_reuse = path_reuse;
            let [packets, one_by_one] = [true, false].map(|packets| {
                input.config.packets = packets;
                trace_with_guides(&input.context(None), &pixels(), 3)
            });
            let differs = |a: &[Vec3], b: &[Vec3]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f32::max) >= 1e-5
            };
            assert!(!differs(&packets.0, &one_by_one.0), "{head}, {path_reuse}");
            let without_guides = trace(&input.context(None), &pixels(), 3, 1);
            assert!(!differs(&packets.0, &without_guides), "{head}, {path_reuse}: other light without guides");
            let mut facets = 0;
            for (a, b) in packets.1.iter().zip(&one_by_one.1) {
                let kind = |guide: &Guide| (guide.class, guide.is_glossy, guide.object, guide.seen_object, guide.leaf);
                assert_eq!(kind(a), kind(b), "{a:?} {b:?}");
                let numbers = |guide: &Guide| {
                    let light = &guide.reflected;
                    assert!(guide.length.is_finite());
                    let (length, depth) = (Vec3::splat(guide.length), Vec3::new(light.depth, light.alpha, 0.0));
                    let surface =
                        [guide.normal, guide.seen_normal, guide.albedo, guide.position / guide.length, length];
                    let lights = [guide.indirect, light.radiance, depth];
                    surface.into_iter().chain(lights).collect::<Vec<Vec3>>()
                };
                for (x, y) in numbers(a).into_iter().zip(numbers(b)) {
                    assert!((x - y).abs().max_element() < 1e-5 * (1.0 + y.abs().max_element()), "{a:?} {b:?}");
                }
                facets += u32::from(a.has_facets());
            }
            assert!(facets > 50, "{facets}");
            let indirect: Vec3 = packets.1.iter().map(|guide| guide.indirect).sum();
            assert!(indirect.min_element() > 1.0, "{indirect}");
        }
    }
}
