//! Cache of compiled kernels, so that a device compiles each kernel once.

use super::bindings::{self, Bindings};
use super::compose::{KernelKind, kernel, program};
use super::device::{Device, KernelTarget};
use super::encode::SceneData;
use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::integrator::pixel_albedo;
use crate::scene::MaterialRecord;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Capacity of the cache: more kernels than a user switches between.
const CAPACITY: usize = 24;

/// Source of a scene's kernel, and the data that it reads. Scenes of the same structure have the same source.
pub(crate) struct KernelSource {
    pub(crate) code: String,
    /// Source of the kernel for edges of emitters, if there are any. It has the same bindings.
    pub(super) edges: Option<String>,
    /// Source of the kernel for coverage by emitters, if a live picture may show some. It has the same bindings, but writes
    /// coverages instead of the film.
    pub(super) coverage: Option<String>,
    /// Source of the kernel for albedos of pixels, if textures may be finer than these. It has the same bindings, but writes
    /// albedos instead of the film.
    pub(super) albedos: Option<String>,
    pub(super) parameters: Vec<[f32; 4]>,
    pub(super) data: SceneData,
    pub(crate) bindings: Bindings,
    /// True if the code contains no code of a user.
    trusted: bool,
}

impl KernelSource {
    /// Composes the kernel for a device.
    pub(crate) fn new(input: &RenderInput, device: &Device) -> Self {
        Self::for_target(input, device.kernel_target())
    }

    /// Composes the kernel for a kind of adapter.
    pub(crate) fn for_target(input: &RenderInput, target: KernelTarget) -> Self {
        let program = program(input, target.is_software);
        let trusted = input.scene.field.leaves().iter().all(|leaf| leaf.shape.is_trusted());
        let bindings = Bindings::new(input, &program, target);
        let stored_tree = input.light_tree().filter(|_| !bindings.is_uniform(bindings::LIGHT_TREE));
        let data = SceneData::new(input, &program, stored_tree);
        let source = |kind| kernel(kind, input, &program, &bindings, &data);
        let code = source(KernelKind::Samples);
        let edges = input.edges.as_ref().map(|_| source(KernelKind::EmitterEdges));
        let has_emitters = input.scene.materials.iter().any(MaterialRecord::emits);
        let shows_emitters = bindings.has_guides && !input.config.media && has_emitters;
        let coverage = shows_emitters.then(|| source(KernelKind::EmitterCoverage));
        let has_fine_textures =
            bindings.has_guides && !input.config.media && pixel_albedo::has_fine_textures(&input.scene);
        let albedos = has_fine_textures.then(|| source(KernelKind::PixelAlbedo));
        Self { code, edges, coverage, albedos, parameters: program.parameters, data, bindings, trusted }
    }

    /// True if the device has compiled this kernel and dispatched it once.
    pub(crate) fn is_compiled(&self, kernels: &KernelCache) -> bool {
        kernels.get(&self.code).is_some_and(|kernel| kernel.is_warm())
    }
}

/// Compiled kernel.
pub(super) struct Kernel {
    code: String,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// True after the first dispatch, at which many drivers compile.
    warm: AtomicBool,
}

impl Kernel {
    pub(super) fn is_warm(&self) -> bool {
        self.warm.load(Ordering::Acquire)
    }
    pub(super) fn set_warm(&self) {
        self.warm.store(true, Ordering::Release);
    }
}

/// Compiled kernels of a device, the last used at the end.
#[derive(Default)]
pub(crate) struct KernelCache(Mutex<Vec<Arc<Kernel>>>);

impl KernelCache {
    fn get(&self, code: &str) -> Option<Arc<Kernel>> {
        let mut kernels = self.0.lock().ok()?;
        let index = kernels.iter().position(|kernel| kernel.code == code)?;
        let kernel = kernels.remove(index);
        kernels.push(kernel.clone());
        Some(kernel)
    }

    /// Returns the kernel of a source with this code; compiles it if it is not in the cache.
    pub(super) fn compile(
        &self,
        device: &Device,
        source: &KernelSource,
        code: &str,
    ) -> Result<Arc<Kernel>, RenderError> {
        if let Some(kernel) = self.get(code) {
            return Ok(kernel);
        }
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = gpu.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let layout = bind_group_layout(gpu, &source.bindings);
        let descriptor =
            wgpu::ShaderModuleDescriptor { label: Some("trace"), source: wgpu::ShaderSource::Wgsl(code.into()) };
        let module = match source.trusted {
            // SAFETY: every loop of the kernel counts to a constant, or to a number of bounces, lights or iterations that the
            // CPU has checked. Every index comes from tables that were built with the kernel. It contains no code of a user.
            true => unsafe { gpu.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) },
            false => gpu.create_shader_module(descriptor),
        };
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("trace"),
            layout: Some(&gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("trace"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })),
            module: &module,
            entry_point: Some("trace"),
            // The kernels write their workgroup memory before they read it.
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        for scope in [memory, validation] {
            device.end_scope(scope)?;
        }
        let kernel = Arc::new(Kernel { code: code.to_owned(), pipeline, layout, warm: AtomicBool::new(false) });
        if let Ok(mut kernels) = self.0.lock() {
            if kernels.len() == CAPACITY {
                kernels.remove(0);
            }
            kernels.push(kernel.clone());
        }
        Ok(kernel)
    }
}

fn bind_group_layout(gpu: &wgpu::Device, bindings: &Bindings) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = bindings
        .all()
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: match bindings.texel(binding) {
                Some(element) => element.binding_type(match binding {
                    bindings::FILM => wgpu::StorageTextureAccess::ReadWrite,
                    _ => wgpu::StorageTextureAccess::ReadOnly,
                }),
                None => wgpu::BindingType::Buffer {
                    ty: match binding {
                        bindings::SLICE => wgpu::BufferBindingType::Uniform,
                        bindings::FILM | bindings::SUSPENDED | bindings::GUIDES => {
                            wgpu::BufferBindingType::Storage { read_only: false }
                        }
                        _ if bindings.is_uniform(binding) => wgpu::BufferBindingType::Uniform,
                        _ => wgpu::BufferBindingType::Storage { read_only: true },
                    },
                    has_dynamic_offset: binding == bindings::SLICE,
                    min_binding_size: None,
                },
            },
            count: None,
        })
        .collect();
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("trace"), entries: &entries })
}
