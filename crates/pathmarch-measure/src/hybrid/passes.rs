//! Passes on a GPU: triangle ids by the rasteriser, and first hits by the hierarchy or from the ids.

use super::torus::{MeshScene, Offsets, ViewUniform};
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_field::wgsl::Program;
use std::time::Instant;
use wgpu::util::DeviceExt;

const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Triangle of rays without a hit, as in `visibility.wgsl`.
pub const NO_HIT: u32 = 0x7fff_ffff;
/// Mark of pixels that have traversed the hierarchy although there are ids, as in `visibility.wgsl`.
const FALLBACK: u32 = 0x8000_0000;
/// Milliseconds of work in a submission, so that its latency does not count.
const MEASURED_MILLISECONDS: f64 = 20.0;

/// First hit of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelHit {
    /// Distance, metres.
    pub t: f32,
    /// Triangle in the order of kernels, or [`NO_HIT`].
    pub triangle: u32,
    /// True if the ray has traversed the hierarchy although there are ids.
    pub is_fallback: bool,
}

/// Way to the first hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Each ray traverses the hierarchy.
    Bvh,
    /// Triangle ids and depths by the rasteriser.
    Raster,
    /// Each ray is intersected with the triangle of its pixel's id, or traverses the hierarchy.
    Ids,
}

/// Opened device.
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Largest storage buffer of a kernel, bytes.
    pub max_binding: u64,
}

impl Gpu {
    /// Opens the adapter of this name.
    pub fn open(name: &str) -> Result<Self, Failure> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        descriptor.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(descriptor);
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        let adapter = adapters.into_iter().find(|adapter| adapter.get_info().name == name);
        let adapter = adapter.ok_or_else(|| Failure::Other(format!("{name} has no Vulkan, Metal or Direct3D 12")))?;
        let required_features = wgpu::Features::PRIMITIVE_INDEX;
        if !adapter.features().contains(required_features) {
            return Err(Failure::Other(format!("{name} does not support indices of triangles in fragment shaders")));
        }
        let limits = adapter.limits();
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            required_features,
            required_limits: limits.clone(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request).map_err(Failure::other)?;
        Ok(Self { device, queue, max_binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) })
    }

    fn buffer(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    }

    fn wait(&self) -> Result<(), Failure> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(Failure::other)
    }
}

/// Compute pass with its buffers.
struct Kernel {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// All passes for a picture of a mesh.
pub struct Passes<'a> {
    gpu: &'a Gpu,
    size: [u32; 2],
    raster: wgpu::RenderPipeline,
    raster_group: wgpu::BindGroup,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    ids: wgpu::TextureView,
    depths: wgpu::TextureView,
    hits: wgpu::Buffer,
    /// The kernels of [`Pass::Bvh`] and [`Pass::Ids`]; `None` if the hierarchy does not fit.
    kernels: Option<[Kernel; 2]>,
}

impl<'a> Passes<'a> {
    /// Uploads a mesh and compiles the passes. With `culls_back`, the raster leaves out triangles seen from behind, as
    /// closed meshes allow.
    pub fn new(gpu: &'a Gpu, mesh: &MeshScene, size: [u32; 2], offsets: Offsets, culls_back: bool) -> Self {
        let view = ViewUniform::new(&mesh.scene.cameras[0], size, offsets);
        let view = gpu.buffer(bytemuck::bytes_of(&view), wgpu::BufferUsages::UNIFORM);
        let triangles = mesh.triangles_in_kernel_order();
        let positions: Vec<[f32; 3]> = mesh.mesh().positions.iter().map(|p| p.to_array()).collect();
        let raster = raster_pipeline(&gpu.device, culls_back);
        let raster_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &raster.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() }],
        });
        let [ids, depths] = [ID_FORMAT, DEPTH_FORMAT].map(|format| target(&gpu.device, size, format));
        let hits = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 8 * u64::from(size[0]) * u64::from(size[1]),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let kernels = (mesh.bvh_bytes() <= gpu.max_binding).then(|| {
            let program = mesh.program();
            let words = gpu.buffer(bytemuck::cast_slice(program.mesh_words()), wgpu::BufferUsages::STORAGE);
            let buffers = [&view, &words, &hits].map(wgpu::Buffer::as_entire_binding);
            let textures = [&ids, &depths].map(wgpu::BindingResource::TextureView);
            kernels(&gpu.device, &program, &buffers, &textures)
        });
        Self {
            gpu,
            size,
            raster,
            raster_group,
            positions: gpu.buffer(bytemuck::cast_slice(&positions), wgpu::BufferUsages::VERTEX),
            indices: gpu.buffer(bytemuck::cast_slice(&triangles), wgpu::BufferUsages::INDEX),
            index_count: 3 * triangles.len() as u32,
            ids,
            depths,
            hits,
            kernels,
        }
    }

    /// Passes that the adapter can run.
    pub fn possible(&self) -> &'static [Pass] {
        if self.kernels.is_some() { &[Pass::Bvh, Pass::Raster, Pass::Ids] } else { &[Pass::Raster] }
    }

    fn record(&self, pass: Pass, encoder: &mut wgpu::CommandEncoder) {
        match (pass, &self.kernels) {
            (Pass::Raster, _) => self.record_raster(encoder),
            (Pass::Bvh, Some([kernel, _])) | (Pass::Ids, Some([_, kernel])) => {
                let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                compute.set_pipeline(&kernel.pipeline);
                compute.set_bind_group(0, &kernel.group, &[]);
                compute.dispatch_workgroups(self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1);
            }
            (_, None) => {}
        }
    }

    fn record_raster(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.ids,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
                depth_slice: None,
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depths,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.raster);
        pass.set_bind_group(0, &self.raster_group, &[]);
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.index_count, 0, 0..1);
    }

    /// Milliseconds of a pass, the mean of `repeats` in one submission.
    fn time(&self, pass: Pass, repeats: u32) -> Result<f64, Failure> {
        let began = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        (0..repeats).for_each(|_| self.record(pass, &mut encoder));
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        Ok(began.elapsed().as_secs_f64() * 1e3 / f64::from(repeats))
    }

    /// Median milliseconds of passes that take turns with other work, `beside`. Two runs of each pass are warm-up.
    pub fn time_interleaved(
        &self,
        passes: &[Pass],
        rounds: u32,
        beside: &mut dyn FnMut() -> Result<(), Failure>,
    ) -> Result<Vec<f64>, Failure> {
        let mut repeats = Vec::new();
        for &pass in passes {
            self.time(pass, 1)?;
            repeats.push((MEASURED_MILLISECONDS / self.time(pass, 1)?).clamp(1.0, 1000.0).ceil() as u32);
        }
        let mut times = vec![Vec::new(); passes.len()];
        for _ in 0..rounds {
            for ((&pass, &repeats), times) in passes.iter().zip(&repeats).zip(&mut times) {
                times.push(self.time(pass, repeats)?);
            }
            beside()?;
        }
        Ok(times.into_iter().map(median).collect())
    }

    /// First hits of all pixels by the hierarchy, or by the raster and its ids.
    pub fn hits(&self, pass: Pass) -> Result<Vec<PixelHit>, Failure> {
        self.time(Pass::Raster, 1)?;
        self.time(pass, 1)?;
        let readback = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: self.hits.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.hits, 0, &readback, 0, self.hits.size());
        self.gpu.queue.submit([encoder.finish()]);
        readback.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.gpu.wait()?;
        let bytes = readback.slice(..).get_mapped_range().map_err(Failure::other)?.to_vec();
        let hit = |&[t, id]: &[u32; 2]| PixelHit {
            t: f32::from_bits(t),
            triangle: id & NO_HIT,
            is_fallback: id & FALLBACK != 0,
        };
        Ok(bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&bytes).iter().map(hit).collect())
    }
}

/// Median of at least one time.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn target(device: &wgpu::Device, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

fn raster_pipeline(device: &wgpu::Device, culls_back: bool) -> wgpu::RenderPipeline {
    let code = concat!("enable primitive_index;\n\n", include_str!("view.wgsl"), include_str!("triangle_ids.wgsl"));
    let source = wgpu::ShaderSource::Wgsl(code.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("triangle ids"), source });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("triangle ids"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState { cull_mode: culls_back.then_some(wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(ID_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Kernels of [`Pass::Bvh`] and [`Pass::Ids`], over the code of the field.
fn kernels(
    device: &wgpu::Device,
    program: &Program,
    buffers: &[wgpu::BindingResource; 3],
    textures: &[wgpu::BindingResource; 2],
) -> [Kernel; 2] {
    let declared = program.declaration("@group(1) @binding(0) var<storage>");
    let code = [include_str!("view.wgsl"), include_str!("visibility.wgsl"), &declared, &program.code].concat();
    let descriptor =
        wgpu::ShaderModuleDescriptor { label: Some("visibility"), source: wgpu::ShaderSource::Wgsl(code.into()) };
    // SAFETY: as in the renderer's kernels: traversal ends after each node of the hierarchy, and every index comes from tables
    // that were built with the kernel, or from the raster of the same triangles.
    let module = unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) };
    ["by_bvh", "by_ids"].map(|entry_point| {
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: None,
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            cache: None,
        });
        let textures = if entry_point == "by_ids" { &textures[..] } else { &[] };
        let resources = buffers.iter().chain(textures).cloned();
        let entries: Vec<_> =
            (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Kernel { pipeline, group }
    })
}
