//! Kernels as a device has compiled them, kept so that what was shown once is shown again at once.

use super::Device;
use super::kernel::{kernel, program};
use super::memory::{self, Memory};
use crate::error::RenderError;
use crate::frame::Prepared;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Kernels that a device keeps: more than a person goes back and forth between.
const KEPT: usize = 24;

/// A scene's kernel as text, and the numbers of its field. Scenes of one structure have the same text.
pub(crate) struct Printed {
    pub(super) code: String,
    pub(super) parameters: Vec<[f32; 4]>,
    pub(crate) memory: Memory,
    /// Whether no text of a user is in the code.
    trusted: bool,
}

impl Printed {
    /// As it suits a device.
    pub(crate) fn new(prepared: &Prepared, device: &Device) -> Self {
        Self::for_adapter(prepared, device.is_software())
    }

    /// Kernel for a software adapter or for a real GPU.
    pub(super) fn for_adapter(prepared: &Prepared, software: bool) -> Self {
        let mut program = program(prepared);
        if let Some(preview) = &prepared.preview {
            program.write_object_sets(&prepared.field, &preview.counted());
        }
        let trusted = prepared.field.leaves().iter().all(|leaf| leaf.shape.is_trusted());
        let memory = Memory::new(prepared, &program, software);
        let code = kernel(prepared, &program, &memory);
        Self { code, parameters: program.parameters, memory, trusted }
    }

    /// Whether the device has it ready.
    pub(crate) fn is_compiled(&self, device: &Device) -> bool {
        device.kernels.get(&self.code).is_some_and(|kernel| kernel.is_warm())
    }
}

/// A kernel that a device has compiled.
pub(super) struct Kernel {
    code: String,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// Whether it was dispatched once: many drivers compile then.
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

/// The kernels of a device, the one used last at the end.
#[derive(Default)]
pub(crate) struct Kernels(Mutex<Vec<Arc<Kernel>>>);

impl Kernels {
    fn get(&self, code: &str) -> Option<Arc<Kernel>> {
        let mut kernels = self.0.lock().ok()?;
        let place = kernels.iter().position(|kernel| kernel.code == code)?;
        let kernel = kernels.remove(place);
        kernels.push(kernel.clone());
        Some(kernel)
    }

    /// The kernel of this text, compiled if it is new.
    pub(super) fn compile(&self, device: &Device, printed: &Printed) -> Result<Arc<Kernel>, RenderError> {
        if let Some(kernel) = self.get(&printed.code) {
            return Ok(kernel);
        }
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = gpu.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let layout = bind_group_layout(gpu, &printed.memory);
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some("trace"),
            source: wgpu::ShaderSource::Wgsl(printed.code.as_str().into()),
        };
        let module = match printed.trusted {
            // SAFETY: every loop of the kernel counts to a constant or to `bounces`, lights or iterations checked on the
            // CPU, and every index comes from tables built together with it; no text of a user is in it.
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
            compilation_options: Default::default(),
            cache: None,
        });
        for scope in [memory, validation] {
            if let Some(error) = pollster::block_on(scope.pop()) {
                return Err(device.error(error));
            }
        }
        let kernel = Arc::new(Kernel { code: printed.code.clone(), pipeline, layout, warm: AtomicBool::new(false) });
        if let Ok(mut kernels) = self.0.lock() {
            if kernels.len() == KEPT {
                kernels.remove(0);
            }
            kernels.push(kernel.clone());
        }
        Ok(kernel)
    }
}

fn bind_group_layout(gpu: &wgpu::Device, memory: &Memory) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = memory
        .bindings()
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: match binding {
                    memory::SLICE => wgpu::BufferBindingType::Uniform,
                    memory::FILM | memory::SUSPENDED => wgpu::BufferBindingType::Storage { read_only: false },
                    _ if memory.is_uniform(binding) => wgpu::BufferBindingType::Uniform,
                    _ => wgpu::BufferBindingType::Storage { read_only: true },
                },
                has_dynamic_offset: binding == memory::SLICE,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("trace"), entries: &entries })
}
