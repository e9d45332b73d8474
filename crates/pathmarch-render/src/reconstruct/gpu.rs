//! Reconstruction on the GPU: the passes of the `.wgsl` files of this folder, within the default limits of WebGPU.
//!
//! **Idea.** Every pass is a kernel over pixels. A pass reads what the one before wrote; guides, histories and pictures are
//! there twice, for the present film and for the one before. All of it stays on the device; the picture comes back as four
//! bytes a pixel.
//!
//! **Cost.** 404 bytes of memory for each pixel, those of the tracer's guides included; 500 in scenes with glossy surfaces,
//! and 16 more where emitters may be seen.
//! A film whose buffers the device cannot allocate is not reconstructed.

use super::gpu_buffers::{Buffers, COLOUR_BYTES, GUIDE_BYTES, SCREEN_BYTES};
use super::gpu_passes::{
    DeformationPass, FacetPasses, Layer, PassRecorder, PassSources, PassUniforms, Passes, Target, pass_times,
};
use super::motion::Motion;
use super::temporal::camera_moves;
use super::{Changes, PassTime, PixelHistory, ReconstructOptions, antialiasing, settles};
use crate::backend::RenderInput;
use crate::backend::gpu::{GpuContext, GpuTimer, ReconstructedFilm};
use crate::error::RenderError;
use crate::output::tonemap::Display;
use crate::scene::material::{DELTA, GLOSSY};
use crate::scene::{FrameUniforms, RenderScene};
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::wgsl::Program;
use std::sync::Arc;

/// What a film showed.
struct Shown {
    scene: Arc<RenderScene>,
    frame: FrameUniforms,
    /// Size of the picture, pixels.
    size: [u32; 2],
    has_facets: bool,
}

/// State between the pictures of a sequence.
pub(super) struct GpuReconstruction {
    device: Arc<GpuContext>,
    passes: Passes,
    /// Passes for the light of facets; `None` before there is any.
    facet_passes: Option<FacetPasses>,
    /// Pass for objects that deform; `None` before there were any.
    deformation: Option<DeformationPass>,
    uniforms: wgpu::Buffer,
    /// Those of passes at half the resolution.
    half_uniforms: wgpu::Buffer,
    buffers: Option<Buffers>,
    /// Index of the present film's buffers.
    turn: usize,
    past: Option<Shown>,
    present: Option<Shown>,
    changes: Changes,
    /// Timer of the passes of sequences; `None` in windows, and on adapters without timestamps.
    timer: Option<GpuTimer>,
    /// Passes of the last picture, if there is a timer.
    pub(super) passes_done: Vec<PassTime>,
}

impl GpuReconstruction {
    pub(super) fn new(device: &Arc<GpuContext>) -> Result<Self, RenderError> {
        let uniforms = || {
            device.allocate(&wgpu::BufferDescriptor {
                label: Some("reconstruction"),
                size: size_of::<PassUniforms>() as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Ok(Self {
            passes: Passes::new(device)?,
            facet_passes: None,
            deformation: None,
            device: device.clone(),
            uniforms: uniforms()?,
            half_uniforms: uniforms()?,
            buffers: None,
            turn: 0,
            past: None,
            present: None,
            changes: Changes::default(),
            timer: None,
            passes_done: Vec::new(),
        })
    }

    /// Times the passes of all further pictures, if the adapter can.
    pub(super) fn time_passes(&mut self) -> Result<(), RenderError> {
        self.timer = GpuTimer::new(&self.device)?;
        Ok(())
    }

    /// True if it runs on this device.
    pub(super) fn is_on(&self, device: &Arc<GpuContext>) -> bool {
        Arc::ptr_eq(&self.device, device)
    }

    /// Starts another film: of another view, size or moment, or of a changed scene.
    pub(super) fn start_film(&mut self, scene_changed: bool) {
        let present = self.present.take();
        self.changes.start_film(present.is_some(), scene_changed);
        if present.is_some() {
            self.past = present;
            self.turn = 1 - self.turn;
        }
    }

    /// Reconstructs a film and tone-maps it: red, green, blue and 255 for each pixel. `None` without memory.
    pub(super) fn show(
        &mut self,
        film: &ReconstructedFilm,
        input: &RenderInput,
        weight: f32,
        size: [u32; 2],
        options: &ReconstructOptions,
        display: &Display,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        let is_glossy = input.scene.materials.iter().any(|material| material.has(GLOSSY) && !material.has(DELTA));
        let has_facets = is_glossy || input.config.media;
        if !self.reserve(size, has_facets) {
            return Ok(None);
        }
        if has_facets && self.facet_passes.is_none() {
            self.facet_passes = Some(FacetPasses::new(&self.device)?);
        }
        let changed_past = self.past.as_ref().filter(|_| self.changes.scene);
        let motion = changed_past.map_or_else(Motion::default, |past| Motion::new(&past.scene, &input.scene));
        let earlier_field = motion.earlier_field.as_ref();
        let field_parameters = earlier_field.map(|field| self.start_deformation(field)).transpose()?;
        let uniforms = PassUniforms {
            has_facets: u32::from(has_facets),
            ..self.uniforms_of(film, &input.frame, weight, size, options, display)
        };
        self.device.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        self.device.queue.write_buffer(&self.half_uniforms, 0, bytemuck::bytes_of(&uniforms.at_half_the_size()));
        let records = motion.records(&input.scene);
        let leaf_motions = self.uploaded("leaf motions", &records)?;
        let codes = self.run(film, &leaf_motions, field_parameters.as_ref(), &uniforms, options)?;
        self.present = Some(Shown { scene: input.scene.clone(), frame: input.frame, size, has_facets });
        Ok(codes)
    }

    /// Buffer with records, of at least one.
    fn uploaded<T: bytemuck::Pod>(&self, label: &str, records: &[T]) -> Result<wgpu::Buffer, RenderError> {
        let buffer = self.device.allocate(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size_of_val(records).max(size_of::<T>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })?;
        self.device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(records));
        Ok(buffer)
    }

    /// Compiles the pass for the objects of an earlier field, unless it is that of the last picture, and uploads their numbers.
    fn start_deformation(&mut self, earlier_field: &Field) -> Result<wgpu::Buffer, RenderError> {
        let program = Program::new(earlier_field);
        let code = DeformationPass::code(&program);
        if self.deformation.as_ref().is_none_or(|pass| pass.code != code) {
            self.deformation = Some(DeformationPass::new(&self.device, code)?);
        }
        self.uploaded("earlier field", &program.parameters)
    }

    /// Colours of the last picture.
    pub(super) fn colours(&self) -> Result<Vec<Vec3>, RenderError> {
        let (Some(buffers), Some(Shown { size, .. })) = (&self.buffers, &self.present) else { return Ok(Vec::new()) };
        let colours = self.read_back::<[f32; 4]>(&buffers.estimates[0], *size)?;
        Ok(colours.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)).collect())
    }

    /// Histories of all pixels of the last picture.
    pub(super) fn histories(&self) -> Result<Vec<PixelHistory>, RenderError> {
        let (Some(buffers), Some(Shown { frame, .. })) = (&self.buffers, &self.present) else { return Ok(Vec::new()) };
        let histories = self.read_back::<[f32; 8]>(&buffers.films[self.turn].history, frame.size())?;
        let of =
            |[_, _, _, length, _, _, x, y]: [f32; 8]| PixelHistory { before: (x > -1e8).then_some([x, y]), length };
        Ok(histories.into_iter().map(of).collect())
    }

    /// Records of all pixels in a buffer.
    fn read_back<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, size: [u32; 2]) -> Result<Vec<T>, RenderError> {
        let bytes = size_of::<T>() as u64 * u64::from(size[0]) * u64::from(size[1]);
        let copy = self.device.allocate(&wgpu::BufferDescriptor {
            label: Some("copy"),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })?;
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("copy") });
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
        self.device.queue.submit([encoder.finish()]);
        self.device.read(&copy, bytes, |bytes| bytemuck::cast_slice(bytes).to_vec())
    }

    /// Allocates buffers for pictures of this size; returns false if the device cannot.
    fn reserve(&mut self, size: [u32; 2], has_facets: bool) -> bool {
        let product = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let pixels = [product(size), product(size.map(|side| side.div_ceil(2)))];
        let suffices = |buffers: &Buffers| {
            let is_large = (0..2).all(|k| buffers.pixels[k] >= pixels[k]);
            is_large && (buffers.facets.is_some() || !has_facets)
        };
        if self.buffers.as_ref().is_some_and(suffices) {
            return true;
        }
        let larger = |buffers: &Buffers| std::array::from_fn(|k| buffers.pixels[k].max(pixels[k]));
        let pixels = self.buffers.as_ref().map_or(pixels, larger);
        let Some(new) = Buffers::new(&self.device, pixels, has_facets) else {
            (self.buffers, self.past, self.present) = (None, None, None);
            return false;
        };
        if let Some(old) = &self.buffers {
            new.copy_films(&self.device, old);
        }
        self.buffers = Some(new);
        true
    }

    fn uniforms_of(
        &self,
        film: &ReconstructedFilm,
        frame: &FrameUniforms,
        weight: f32,
        size: [u32; 2],
        options: &ReconstructOptions,
        display: &Display,
    ) -> PassUniforms {
        let past = self.past.as_ref();
        let (past_frame, past_size) = past.map_or((frame, size), |past| (&past.frame, past.size));
        let reprojects = past.is_some() && options.reprojection;
        PassUniforms {
            position: frame.position,
            width: frame.width,
            right: frame.right,
            height: frame.height,
            up: frame.up,
            pixel: frame.pixel,
            forward: frame.forward,
            max_history: if reprojects { self.changes.max_history * (1.0 - weight) } else { 0.0 },
            past_position: past_frame.position,
            past_width: past_frame.width,
            past_right: past_frame.right,
            past_height: past_frame.height,
            past_up: past_frame.up,
            past_pixel: past_frame.pixel,
            past_forward: past_frame.forward,
            weight,
            shown_width: size[0],
            shown_height: size[1],
            past_shown_width: past_size[0],
            past_shown_height: past_size[1],
            samples: film.samples,
            begun: film.begun,
            row: film.row,
            column: film.column,
            scene_changed: u32::from(self.changes.scene),
            camera_moves: u32::from(camera_moves(past_frame, frame)),
            antialiases: u32::from(past.is_some() && options.antialiasing),
            buffer: options.buffer as u32,
            gain: display.gain(),
            tonemap: display.tonemap as u32,
            settles: u32::from(settles(film.samples)) << u32::from(frame.size() == size),
            new_weight: antialiasing::new_weight(film.samples, self.changes.scene),
            has_facets: 0,
            past_has_facets: u32::from(past.is_some_and(|past| past.has_facets)),
            has_emitters: u32::from(film.coverages.is_some()),
            has_albedos: u32::from(film.albedos.is_some()),
            far: frame.far,
            padding: 0,
            more_padding: [0; 2],
        }
    }

    /// Runs all passes and reads the codes of the picture back.
    fn run(
        &mut self,
        film: &ReconstructedFilm,
        leaf_motions: &wgpu::Buffer,
        field_parameters: Option<&wgpu::Buffer>,
        uniforms: &PassUniforms,
        options: &ReconstructOptions,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        let Some(buffers) = &self.buffers else { return Ok(None) };
        let gpu = &self.device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let traced = [uniforms.width, uniforms.height];
        let size = [uniforms.shown_width, uniforms.shown_height];
        let facets = buffers.facets.as_ref().filter(|_| uniforms.has_facets != 0);
        let mut recorder = PassRecorder {
            gpu,
            encoder: gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("reconstruct") }),
            timer: self.timer.take(),
            names: Vec::new(),
            sources: PassSources {
                uniforms: &self.uniforms,
                half_uniforms: &self.half_uniforms,
                film: film.film,
                leaf_motions,
                field_parameters,
                buffers,
                facets,
                coverages: film.coverages,
                albedos: film.albedos,
                films: [&buffers.films[self.turn], &buffers.films[1 - self.turn]],
                turn: self.turn,
            },
        };
        let pixels = u64::from(traced[0]) * u64::from(traced[1]);
        let present = &buffers.films[self.turn];
        recorder.encoder.copy_buffer_to_buffer(film.guides, 0, &present.guides, 0, GUIDE_BYTES * pixels);
        let passes = &self.passes;
        let target = Target { layer: Layer::Base, source: 0, size: traced };
        recorder.run("division by the albedo", &passes.divide, &[0, 1, 2, 4, 7, 12], target);
        if let (Some(pass), Some(_)) = (&self.deformation, field_parameters) {
            recorder.run("deformation", &pass.pipeline, &[0, 2, 4, 12, 13], target);
        }
        recorder.spread_fireflies(passes, options, target);
        recorder.run("reprojection", &passes.accumulate, &[0, 2, 3, 5, 6, 7, 12], target);
        let has_changed = uniforms.scene_changed != 0 && uniforms.max_history > 0.0;
        if has_changed {
            recorder.join_changed_light("reprojection", &passes.changed_light, target);
        }
        recorder.filter(&passes.filter, options, target);
        let half = Target { layer: Layer::Half, source: 0, size: traced.map(|side| side.div_ceil(2)) };
        recorder.run("indirect light", &passes.halve, &[0, 1, 2, 4, 17, 18, 19], Target { layer: Layer::Base, ..half });
        if let (Some(pass), Some(_)) = (&self.deformation, field_parameters) {
            recorder.run("deformation", &pass.pipeline, &[0, 2, 4, 12, 13], half);
        }
        recorder.spread_fireflies(passes, options, half);
        recorder.run("indirect light", &passes.accumulate, &[0, 2, 3, 5, 6, 7, 12], half);
        if has_changed {
            recorder.join_changed_light("indirect light", &passes.changed_light, half);
        }
        recorder.filter(&passes.filter_half, options, half);
        recorder.run("indirect light", &passes.add_indirect, &[0, 2, 7, 17, 18], target);
        if let (Some(facets), Some(facet_passes)) = (facets, &self.facet_passes) {
            let (bytes, target) = (COLOUR_BYTES * pixels, Target { layer: Layer::Facets, ..target });
            recorder.encoder.copy_buffer_to_buffer(&buffers.estimates[0], 0, &facets.base, 0, bytes);
            recorder.run("reflections", &facet_passes.divide, &[0, 2, 7], target);
            recorder.spread_fireflies(passes, options, target);
            recorder.run("reflections", &facet_passes.add_up_rows, &[0, 2, 5, 7, 15], target);
            recorder.run("reflections", &facet_passes.find_images, &[0, 2, 5, 8, 15], target);
            recorder.encoder.copy_buffer_to_buffer(&buffers.estimates[1], 0, &facets.images, 0, bytes);
            recorder.run("reflections", &facet_passes.accumulate, &[0, 2, 3, 5, 6, 7, 12, 15], target);
            if has_changed && uniforms.past_has_facets != 0 {
                recorder.join_changed_light("reflections", &facet_passes.changed_light, target);
            }
            recorder.filter(&facet_passes.filter, options, target);
        }
        recorder.run("emitters", &passes.remove_emitters, &[0, 2, 7, 8, 14, 16, 20], target);
        let target = Target { size, ..target };
        recorder.run("anti-aliasing", &passes.antialias, &[0, 2, 3, 7, 9, 10, 12, 20], Target { source: 1, ..target });
        if settles(film.samples) && traced == size {
            recorder.run("mix with the film", &passes.compare_with_film, &[0, 1, 2, 8, 10, 16], target);
        }
        recorder.run("mix with the film", &passes.mix_with_film, &[0, 1, 2, 7, 8, 10, 16], target);
        recorder.run("display", &passes.show, &[0, 5, 7, 11], target);
        let bytes = SCREEN_BYTES * u64::from(size[0]) * u64::from(size[1]);
        let PassRecorder { mut encoder, timer, names, .. } = recorder;
        encoder.copy_buffer_to_buffer(&buffers.screen, 0, &buffers.copy, 0, bytes);
        self.device.queue.submit([encoder.finish()]);
        self.device.end_scope(validation)?;
        self.timer = timer;
        if let Some(timer) = &mut self.timer {
            self.passes_done = pass_times(&names, &timer.read_passes(&self.device)?);
        }
        self.device.read(&buffers.copy, bytes, <[u8]>::to_vec).map(Some)
    }
}
