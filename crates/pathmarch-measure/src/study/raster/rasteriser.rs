//! A rasteriser of meshes on the default GPU adapter.

use bytemuck::{Pod, Zeroable};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::image::Picture;
use pathmarch_render::pathmarch_field::Mesh;
use pathmarch_render::pathmarch_scene::{Light, Scene, Sky};
use std::time::Instant;
use wgpu::util::DeviceExt;

const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const NEAR: f32 = 0.05;
const FAR: f32 = 200.0;

/// Uniforms of `phong.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SceneUniform {
    clip_from_world: [[f32; 4]; 4],
    eye: [f32; 4],
    light: [f32; 4],
    light_colour: [f32; 4],
    ambient: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct VertexRecord {
    position: [f32; 3],
    normal: [f32; 3],
    colour: [f32; 3],
}

/// Opened device with its pipeline and targets.
pub struct Rasteriser {
    /// Name of the adapter.
    pub device: String,
    gpu: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    colour: wgpu::Texture,
    depth: wgpu::TextureView,
    size: [u32; 2],
}

impl Rasteriser {
    /// Opens the default adapter for pictures of a size.
    pub fn open(size: [u32; 2]) -> Result<Self, String> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.map_err(|error| error.to_string())?;
        let request =
            adapter.request_device(&wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() });
        let (gpu, queue) = pollster::block_on(request).map_err(|error| error.to_string())?;
        let module = gpu.create_shader_module(wgpu::include_wgsl!("phong.wgsl"));
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3];
        let pipeline = gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("phong"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<VertexRecord>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &attributes,
                })],
            },
            primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(COLOUR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let texture = |format, usage| {
            gpu.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let colour = texture(COLOUR_FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC);
        let depth = texture(DEPTH_FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT).create_view(&Default::default());
        Ok(Self { device: adapter.get_info().name, gpu, queue, pipeline, colour, depth, size })
    }

    /// Draws a mesh of the scene with the first of the three terms of Phong's model: ambient light, diffuse light,
    /// highlights. Returns the picture and the median milliseconds of a frame.
    pub fn draw(
        &self,
        mesh: &Mesh,
        scene: &Scene,
        settings: &Settings,
        terms: u32,
        frames: u32,
    ) -> Result<(Picture, f64), Failure> {
        let uniform = uniform(scene, settings, terms);
        let vertices: Vec<VertexRecord> = mesh
            .positions
            .iter()
            .zip(&mesh.normals)
            .zip(&mesh.colours)
            .map(|((position, normal), colour)| VertexRecord { position: *position, normal: *normal, colour: *colour })
            .collect();
        let buffer = |contents: &[u8], usage| {
            self.gpu.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let uniforms = buffer(bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
        let vertices = buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX);
        let indices = buffer(bytemuck::cast_slice(&mesh.triangles), wgpu::BufferUsages::INDEX);
        let group = self.gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
        });
        let view = self.colour.create_view(&Default::default());
        let [r, g, b] = background(scene).map(f64::from);
        let mut times = Vec::new();
        for frame in 0..=frames {
            let began = Instant::now();
            let mut encoder = self.gpu.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &view,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                            store: wgpu::StoreOp::Store,
                        },
                        depth_slice: None,
                    })],
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &self.depth,
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(1.0),
                            store: wgpu::StoreOp::Store,
                        }),
                        stencil_ops: None,
                    }),
                    ..Default::default()
                });
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.set_vertex_buffer(0, vertices.slice(..));
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..3 * mesh.triangles.len() as u32, 0, 0..1);
            }
            self.queue.submit([encoder.finish()]);
            self.gpu.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::other)?;
            if frame > 0 {
                times.push(began.elapsed().as_secs_f64() * 1e3);
            }
        }
        times.sort_by(f64::total_cmp);
        Ok((self.read()?, times[times.len() / 2]))
    }

    /// The picture that was drawn last.
    fn read(&self) -> Result<Picture, Failure> {
        let [width, height] = self.size;
        let stride = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(stride) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.gpu.create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.colour.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            self.colour.size(),
        );
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.gpu.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::other)?;
        let bytes = buffer.slice(..).get_mapped_range().map_err(Failure::other)?.to_vec();
        Ok(Picture::from_fn(width, height, |x, y| {
            let start = (y * stride + 16 * x) as usize;
            std::array::from_fn(|k| f32::from_le_bytes(std::array::from_fn(|byte| bytes[start + 4 * k + byte])))
        }))
    }
}

/// Mean radiance of the sky, which is behind the mesh and its ambient light.
fn background(scene: &Scene) -> [f32; 3] {
    match &scene.sky {
        Sky::Constant(radiance) => *radiance,
        Sky::Gradient { horizon, .. } => *horizon,
        Sky::Map(_) => [0.5; 3],
    }
}

fn uniform(scene: &Scene, settings: &Settings, terms: u32) -> SceneUniform {
    let camera = settings.camera_of(scene);
    let (eye, target, up) = (camera.position.into(), camera.target.into(), camera.up.into());
    let aspect = settings.size[0] as f32 / settings.size[1] as f32;
    let projection = glam::camera::rh::proj::directx::perspective(camera.fov.to_radians(), aspect, NEAR, FAR);
    let view = glam::camera::rh::view::look_at_mat4(eye, target, up);
    let (light, colour) = match scene.lights.first() {
        Some(Light::Sun { direction, irradiance, .. }) => {
            (glam::Vec3::from(*direction).extend(0.0), glam::Vec3::from(*irradiance) / std::f32::consts::PI)
        }
        Some(Light::Point { at, intensity, .. } | Light::Spot { at, intensity, .. }) => {
            let at = glam::Vec3::from(*at);
            // Phong's light does not fall off: it has the strength that reaches the target.
            (at.extend(1.0), glam::Vec3::from(*intensity) / ((at - target).length_squared() * std::f32::consts::PI))
        }
        None => (glam::Vec4::Y, glam::Vec3::ONE),
    };
    let [r, g, b] = background(scene).map(|channel| 0.5 * channel);
    SceneUniform {
        clip_from_world: (projection * view).to_cols_array_2d(),
        eye: eye.extend(1.0).into(),
        light: light.into(),
        light_colour: colour.extend(0.0).into(),
        ambient: [r, g, b, terms as f32],
    }
}
