//! Kernels of reconstruction on the GPU, and how a picture's passes are recorded.

use super::gpu_buffers::{Buffers, FacetBuffers, FilmBuffers};
use super::motion::LeafMotion;
use super::spatial::{DIRECT_REACH, SMOOTH_REACH, STEPS};
use super::{
    PassTime, ReconstructOptions, antialiasing, changed_light, fireflies, indirect, motion, reflections, spatial,
    surfaces, temporal,
};
use crate::backend::gpu::shaders::{ShaderFile, shader_files, with_imports};
use crate::backend::gpu::{Device, GpuTimer};
use crate::error::RenderError;
use crate::integrator::emitter_coverage;
use crate::output::tonemap;
use crate::wgsl::{declaration, shared_struct};
use pathmarch_field::wgsl::Program;
use std::time::Duration;

shared_struct! {
    /// Uniforms of all passes: both frames, the film and the options.
    pub(crate) struct PassUniforms as PassUniforms {
        pub(super) position: [f32; 3],
        pub(super) width: u32,
        pub(super) right: [f32; 3],
        pub(super) height: u32,
        pub(super) up: [f32; 3],
        /// Side of a pixel at distance one, metres.
        pub(super) pixel: f32,
        pub(super) forward: [f32; 3],
        /// Longest history, samples; 0 if there is none.
        pub(super) max_history: f32,
        pub(super) past_position: [f32; 3],
        pub(super) past_width: u32,
        pub(super) past_right: [f32; 3],
        pub(super) past_height: u32,
        pub(super) past_up: [f32; 3],
        pub(super) past_pixel: f32,
        pub(super) past_forward: [f32; 3],
        /// Weight of the film's means in the picture.
        pub(super) weight: f32,
        /// Size of the picture, pixels; that of the samples is `width` and `height`.
        pub(super) shown_width: u32,
        pub(super) shown_height: u32,
        pub(super) past_shown_width: u32,
        pub(super) past_shown_height: u32,
        /// Samples of every pixel.
        pub(super) samples: u32,
        /// Further samples of the pixels above `row`, and in the eight rows from there of those left of `column`.
        pub(super) begun: u32,
        pub(super) row: u32,
        pub(super) column: u32,
        /// Not 0 if the scene has changed since the last film.
        pub(super) scene_changed: u32,
        pub(super) camera_moves: u32,
        /// Not 0 if the picture is averaged with the last one.
        pub(super) antialiases: u32,
        /// Index of the buffer to show.
        pub(super) buffer: u32,
        /// Factor of radiance before the tone curve.
        pub(super) gain: f32,
        /// Index of the tone curve.
        pub(super) tonemap: u32,
        /// Not 0 if the film has samples enough to show edges; 2 if it is also mixed with the picture.
        pub(super) settles: u32,
        /// Weight of a new picture in the average with the last one.
        pub(super) new_weight: f32,
        /// Not 0 if light of facets or media is filtered apart; and in the last picture.
        pub(super) has_facets: u32,
        pub(super) past_has_facets: u32,
        /// Not 0 if emitters are laid over the picture.
        pub(super) has_emitters: u32,
        /// Far end of all rays, metres.
        pub(super) far: f32,
        /// Not 0 if pixels have albedos beside those of their samples.
        pub(super) has_albedos: u32,
        pub(super) padding: u32,
        pub(super) more_padding: [u32; 2],
    }
}

impl PassUniforms {
    /// Uniforms of the passes for pictures of half the size.
    pub(super) fn at_half_the_size(&self) -> Self {
        Self {
            width: self.width.div_ceil(2),
            height: self.height.div_ceil(2),
            pixel: 2.0 * self.pixel,
            past_width: self.past_width.div_ceil(2),
            past_height: self.past_height.div_ceil(2),
            past_pixel: 2.0 * self.past_pixel,
            ..*self
        }
    }
}

pub(super) static FILES: &[ShaderFile] = shader_files![
    "reconstruct/antialiasing" shares antialiasing::shared_wgsl,
    "reconstruct/base",
    "reconstruct/changed_light" shares changed_light::shared_wgsl,
    "reconstruct/deformation",
    "reconstruct/direct",
    "reconstruct/emitters",
    "reconstruct/facets",
    "reconstruct/history",
    "reconstruct/indirect" shares indirect::shared_wgsl,
    "reconstruct/pass" shares || {
        [declaration::<PassUniforms>(), declaration::<LeafMotion>(), super::shared_wgsl(), temporal::shared_wgsl(),
            surfaces::shared_wgsl(), spatial::shared_wgsl(), fireflies::shared_wgsl(), motion::shared_wgsl(),
            emitter_coverage::shared_wgsl()]
        .concat()
    },
    "reconstruct/reflections" shares reflections::shared_wgsl,
    "reconstruct/show" shares tonemap::wgsl,
    "reconstruct/spatial",
    "reconstruct/temporal",
];

/// Kernels of the passes, in the order in which they run.
pub(super) struct Passes {
    pub(super) divide: wgpu::ComputePipeline,
    pub(super) find_fireflies: wgpu::ComputePipeline,
    pub(super) spread_fireflies: wgpu::ComputePipeline,
    pub(super) accumulate: wgpu::ComputePipeline,
    /// After a change of the scene.
    pub(super) changed_light: ChangedLightPasses,
    pub(super) filter: FilterPasses,
    pub(super) halve: wgpu::ComputePipeline,
    /// Filter of the indirect light.
    pub(super) filter_half: FilterPasses,
    pub(super) add_indirect: wgpu::ComputePipeline,
    pub(super) remove_emitters: wgpu::ComputePipeline,
    pub(super) antialias: wgpu::ComputePipeline,
    pub(super) compare_with_film: wgpu::ComputePipeline,
    pub(super) mix_with_film: wgpu::ComputePipeline,
    pub(super) show: wgpu::ComputePipeline,
}

/// Kernels that join new samples with a past in other light.
pub(super) struct ChangedLightPasses {
    add_up: wgpu::ComputePipeline,
    scale: wgpu::ComputePipeline,
    join: wgpu::ComputePipeline,
}

impl ChangedLightPasses {
    /// Kernels for a layer.
    fn new(gpu: &wgpu::Device, layer: &'static str) -> Self {
        let module = module(gpu, "reconstruct/changed_light", layer);
        let pipeline = |entry_point: &str| pipeline(gpu, &module, entry_point, &[]);
        Self { add_up: pipeline("add_up_light"), scale: pipeline("scale_past"), join: pipeline("join_past") }
    }
}

/// Kernels of the spatial filter of one layer of light.
pub(super) struct FilterPasses {
    pub(super) start: wgpu::ComputePipeline,
    pub(super) smooth_variance: wgpu::ComputePipeline,
    pub(super) filter: [wgpu::ComputePipeline; STEPS.len()],
}

impl FilterPasses {
    /// Kernels for a layer; `reach` is that of the luminance.
    pub(super) fn new(gpu: &wgpu::Device, layer: &'static str, reach: f32) -> Self {
        let module = module(gpu, "reconstruct/spatial", layer);
        let constants = |step: i32| [("STEP", f64::from(step)), ("LUMINANCE_REACH", f64::from(reach))];
        Self {
            start: pipeline(gpu, &module, "start_filter", &[]),
            smooth_variance: pipeline(gpu, &module, "smooth_variance", &[]),
            filter: STEPS.map(|step| pipeline(gpu, &module, "filter_once", &constants(step))),
        }
    }
}

/// Kernels for the light of facets.
pub(super) struct FacetPasses {
    pub(super) divide: wgpu::ComputePipeline,
    pub(super) add_up_rows: wgpu::ComputePipeline,
    pub(super) find_images: wgpu::ComputePipeline,
    pub(super) accumulate: wgpu::ComputePipeline,
    /// After a change of the scene.
    pub(super) changed_light: ChangedLightPasses,
    pub(super) filter: FilterPasses,
}

impl FacetPasses {
    pub(super) fn new(device: &Device) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = module(gpu, "reconstruct/reflections", FACETS);
        let passes = Self {
            divide: pipeline(gpu, &module, "divide_reflected", &[]),
            add_up_rows: pipeline(gpu, &module, "add_up_rows", &[]),
            find_images: pipeline(gpu, &module, "find_images", &[]),
            accumulate: pipeline(gpu, &module, "accumulate_reflected", &[]),
            changed_light: ChangedLightPasses::new(gpu, FACETS),
            filter: FilterPasses::new(gpu, FACETS, SMOOTH_REACH),
        };
        device.end_scope(validation)?;
        Ok(passes)
    }
}

/// Files of the layers of light.
pub(super) const BASE: &str = "reconstruct/base";
pub(super) const FACETS: &str = "reconstruct/facets";

/// Kernel that finds the points of objects that deform on their earlier surface; it is that of one structure of them.
pub(super) struct DeformationPass {
    pub(super) code: String,
    pub(super) pipeline: wgpu::ComputePipeline,
}

impl DeformationPass {
    /// Code for the objects of an earlier field.
    pub(super) fn code(program: &Program) -> String {
        let parameters = program.declaration("@group(0) @binding(13) var<storage, read>");
        [&parameters, &program.code, &code("reconstruct/deformation", BASE)].map(String::as_str).concat()
    }

    pub(super) fn new(device: &Device, code: String) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let source = wgpu::ShaderSource::Wgsl(code.as_str().into());
        let label = Some("reconstruct/deformation");
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("find_earlier_surface"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        device.end_scope(validation)?;
        Ok(Self { code, pipeline })
    }
}

/// Code of a shader file with its imports, for a layer of light.
pub(super) fn code(file: &str, layer: &'static str) -> String {
    with_imports(file, FILES, &|name| (name == "layer").then_some(layer))
}

pub(super) fn module(gpu: &wgpu::Device, file: &str, layer: &'static str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(code(file, layer).into());
    gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(file), source })
}

pub(super) fn pipeline(
    gpu: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: None,
        module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

impl Passes {
    pub(super) fn new(device: &Device) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = |file: &str| module(gpu, file, BASE);
        let pipeline = |module: &wgpu::ShaderModule, entry_point: &str| pipeline(gpu, module, entry_point, &[]);
        let [temporal, spatial, indirect, show] =
            ["reconstruct/temporal", "reconstruct/spatial", "reconstruct/indirect", "reconstruct/show"].map(module);
        let passes = Self {
            divide: pipeline(&temporal, "divide"),
            find_fireflies: pipeline(&spatial, "find_fireflies"),
            spread_fireflies: pipeline(&spatial, "spread_fireflies"),
            accumulate: pipeline(&temporal, "accumulate"),
            changed_light: ChangedLightPasses::new(gpu, BASE),
            filter: FilterPasses::new(gpu, BASE, DIRECT_REACH),
            halve: pipeline(&indirect, "halve"),
            filter_half: FilterPasses::new(gpu, BASE, SMOOTH_REACH),
            add_indirect: pipeline(&indirect, "add_indirect"),
            remove_emitters: pipeline(&module("reconstruct/emitters"), "remove_emitters"),
            antialias: pipeline(&module("reconstruct/antialiasing"), "antialias"),
            compare_with_film: pipeline(&show, "compare_with_film"),
            mix_with_film: pipeline(&show, "mix_with_film"),
            show: pipeline(&show, "show"),
        };
        device.end_scope(validation)?;
        Ok(passes)
    }
}

/// Light that a pass works on.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Layer {
    Base,
    Facets,
    /// Indirect light, at half the resolution.
    Half,
}

/// Where a pass works: the layer, the estimates that it reads, and the size of the picture.
#[derive(Clone, Copy)]
pub(super) struct Target {
    pub(super) layer: Layer,
    pub(super) source: usize,
    pub(super) size: [u32; 2],
}

/// Buffers that passes bind.
pub(super) struct PassSources<'a> {
    /// Uniforms of the passes, and of those at half the resolution.
    pub(super) uniforms: &'a wgpu::Buffer,
    pub(super) half_uniforms: &'a wgpu::Buffer,
    pub(super) film: &'a wgpu::Buffer,
    pub(super) leaf_motions: &'a wgpu::Buffer,
    pub(super) field_parameters: Option<&'a wgpu::Buffer>,
    pub(super) buffers: &'a Buffers,
    pub(super) facets: Option<&'a FacetBuffers>,
    pub(super) coverages: Option<&'a wgpu::Buffer>,
    pub(super) albedos: Option<&'a wgpu::Buffer>,
    /// Those of the present film and of the one before.
    pub(super) films: [&'a FilmBuffers; 2],
    pub(super) turn: usize,
}

impl PassSources<'_> {
    fn buffer(&self, binding: u32, target: Target) -> &wgpu::Buffer {
        let ([present, past], buffers) = (self.films, self.buffers);
        let half = &buffers.half;
        let [half_present, half_past] = [&half.films[self.turn], &half.films[1 - self.turn]];
        if target.layer == Layer::Half {
            match binding {
                0 => return self.half_uniforms,
                2 => return &half_present.guides,
                3 => return &half_past.guides,
                5 => return &half_present.history,
                6 => return &half_past.history,
                7 => return &half.estimates[target.source],
                8 => return &half.estimates[1 - target.source],
                12 => return &half.earlier,
                _ => {}
            }
        }
        let [history, past_history] = match (target.layer, self.facets) {
            (Layer::Facets, Some(facets)) => [&facets.histories[self.turn], &facets.histories[1 - self.turn]],
            _ => [&present.history, &past.history],
        };
        match binding {
            0 => self.uniforms,
            1 => self.film,
            2 => &present.guides,
            3 => &past.guides,
            4 => self.leaf_motions,
            5 => history,
            6 => past_history,
            7 => &buffers.estimates[target.source],
            8 => &buffers.estimates[1 - target.source],
            9 => &past.colours,
            10 => &present.colours,
            11 => &buffers.screen,
            12 => &buffers.earlier,
            13 => self.field_parameters.unwrap_or(self.uniforms),
            // Without light of facets, nothing reads it.
            14 => self.facets.map_or(&past.colours, |facets| &facets.base),
            15 => self.facets.map_or(&past.colours, |facets| &facets.images),
            // Without emitters, nothing reads it.
            16 => self.coverages.unwrap_or(&past.colours),
            17 => &half_present.guides,
            18 => &half.estimates[0],
            19 => &half.earlier,
            // Without textures, nothing reads it.
            _ => self.albedos.unwrap_or(&past.colours),
        }
    }
}

/// Recorder of the passes of a picture.
pub(super) struct PassRecorder<'a> {
    pub(super) gpu: &'a wgpu::Device,
    pub(super) encoder: wgpu::CommandEncoder,
    pub(super) timer: Option<GpuTimer>,
    pub(super) names: Vec<&'static str>,
    pub(super) sources: PassSources<'a>,
}

impl PassRecorder<'_> {
    pub(super) fn run(
        &mut self,
        name: &'static str,
        pipeline: &wgpu::ComputePipeline,
        bindings: &[u32],
        target: Target,
    ) {
        let entry = |&binding: &u32| wgpu::BindGroupEntry {
            binding,
            resource: self.sources.buffer(binding, target).as_entire_binding(),
        };
        let entries: Vec<_> = bindings.iter().map(entry).collect();
        let layout = pipeline.get_bind_group_layout(0);
        let group = self.gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("reconstruct"),
            layout: &layout,
            entries: &entries,
        });
        self.names.push(name);
        let timestamp_writes = self.timer.as_mut().map(GpuTimer::next);
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        let mut pass = self.encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(target.size[0].div_ceil(8), target.size[1].div_ceil(8), 1);
    }

    pub(super) fn spread_fireflies(&mut self, passes: &Passes, options: &ReconstructOptions, target: Target) {
        if options.firefly_filter {
            self.run("fireflies", &passes.find_fireflies, &[0, 2, 7, 8], target);
            self.run("fireflies", &passes.spread_fireflies, &[0, 2, 7, 8], target);
        }
    }

    /// Joins the past that was found after a change of the scene with the new samples.
    pub(super) fn join_changed_light(&mut self, name: &'static str, passes: &ChangedLightPasses, target: Target) {
        self.run(name, &passes.add_up, &[0, 2, 5, 7, 8, 10], target);
        self.run(name, &passes.scale, &[0, 2, 5, 7, 8, 10], target);
        self.run(name, &passes.join, &[0, 2, 5, 7], target);
    }

    /// Filters the means of a layer: the last pass writes the estimates of index 0.
    pub(super) fn filter(&mut self, passes: &FilterPasses, options: &ReconstructOptions, target: Target) {
        let images = if target.layer == Layer::Facets { &[15][..] } else { &[] };
        let [first, others] = [[0, 2, 5, 7], [0, 2, 7, 8]].map(|bindings| [&bindings, images].concat());
        let filters = std::iter::once(&passes.smooth_variance).chain(&passes.filter);
        let filters: Vec<&wgpu::ComputePipeline> = filters.filter(|_| options.spatial_filter).collect();
        let start = filters.len() % 2;
        self.run("spatial filter", &passes.start, &first, Target { source: start, ..target });
        for (k, pipeline) in filters.into_iter().enumerate() {
            self.run("spatial filter", pipeline, &others, Target { source: (start + k) % 2, ..target });
        }
    }
}

/// Times of passes, those of one name added up.
pub(super) fn pass_times(names: &[&'static str], times: &[Duration]) -> Vec<PassTime> {
    let mut passes: Vec<PassTime> = Vec::new();
    for (name, time) in names.iter().zip(times) {
        match passes.iter_mut().find(|pass| pass.name == *name) {
            Some(pass) => pass.seconds += time.as_secs_f64(),
            None => passes.push(PassTime { name, seconds: time.as_secs_f64() }),
        }
    }
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wgsl::check_layout;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use pathmarch_scene::Scene;

    #[test]
    fn structures_have_one_layout_in_both_languages() {
        check_layout::<PassUniforms>();
        check_layout::<LeafMotion>();
    }

    #[test]
    fn passes_are_valid_and_within_the_default_limits() {
        let scene = "pathmarch 1\ncamera { position 0 1 5; target 0 0 0 }\nsky 1\nobject \"drops\" {\n\
            union smooth=0.3 { sphere 0.5 { at 0.5 1 0 }; twist 0.25 { box 0.5 } } }\nobject \"fractal\" { mandelbulb }";
        let field = Scene::parse("test.kdl", scene).expect("a scene").field;
        let deformation = DeformationPass::code(&Program::new(&field.of_objects(&[0, 1])));
        for (file, layer) in FILES.iter().flat_map(|file| [(file, BASE), (file, FACETS)]) {
            let code =
                if file.name == "reconstruct/deformation" { deformation.clone() } else { code(file.name, layer) };
            let module =
                naga::front::wgsl::parse_str(&code).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
            let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
            let info = info.unwrap_or_else(|error| panic!("{}: {error:?}", file.name));
            for (k, entry) in module.entry_points.iter().enumerate() {
                let used =
                    module.global_variables.iter().filter(|(handle, _)| !info.get_entry_point(k)[*handle].is_empty());
                let buffers = used.count() as u32;
                assert!(
                    buffers <= wgpu::Limits::default().max_storage_buffers_per_shader_stage,
                    "{}: {buffers}",
                    entry.name
                );
            }
        }
    }

    #[test]
    fn every_file_is_listed() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/reconstruct");
        for entry in std::fs::read_dir(folder).expect("is readable") {
            let name = entry.expect("is readable").file_name().into_string().expect("is Unicode");
            if let Some(name) = name.strip_suffix(".wgsl") {
                assert!(FILES.iter().any(|file| file.name == format!("reconstruct/{name}")), "{name}");
            }
        }
    }
}
