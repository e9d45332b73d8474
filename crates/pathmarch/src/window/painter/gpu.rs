//! GPU painter of the window, with a device of its own.

use super::{PaintError, Textures};
use egui::ClippedPrimitive;
use egui::epaint::textures::TexturesDelta;
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

pub(super) struct GpuPainter {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
    lost: Arc<AtomicBool>,
    failure: Arc<Mutex<Option<String>>>,
    /// Largest side of a window, pixels.
    limit: u32,
}

/// Reason why there is no GPU painter.
pub(super) struct OpenError(pub(super) String);

impl From<String> for OpenError {
    fn from(why: String) -> Self {
        Self(why)
    }
}

impl GpuPainter {
    /// Creates the painter; returns it with its adapter's name.
    pub(super) fn new(
        window: &Arc<Window>,
        display: OwnedDisplayHandle,
        textures: &Textures,
        accept_software: bool,
    ) -> Result<(Self, String), OpenError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display));
        descriptor.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(window.clone()).map_err(|error| error.to_string())?;
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..Default::default()
        }))
        .map_err(|error| error.to_string())?;
        let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        if is_software && !accept_software {
            return Err(OpenError(format!("{} is a software adapter", adapter.get_info().name)));
        }
        let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        let limit = limits.max_texture_dimension_2d;
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("window"),
            required_limits: limits,
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request).map_err(|error| error.to_string())?;
        let lost = Arc::new(AtomicBool::new(false));
        let failure = Arc::new(Mutex::new(None));
        let keep = |slot: &Mutex<Option<String>>, message: String| {
            slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
        };
        let (flag, slot) = (lost.clone(), failure.clone());
        device.set_device_lost_callback(move |_, message| {
            keep(&slot, message);
            flag.store(true, Ordering::Release);
        });
        let (flag, slot) = (lost.clone(), failure.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            keep(&slot, error.to_string());
            flag.store(true, Ordering::Release);
        }));
        let size = window.inner_size();
        let mut configuration = surface
            .get_default_config(&adapter, size.width.clamp(1, limit), size.height.clamp(1, limit))
            .ok_or_else(|| format!("{} cannot draw into this window", adapter.get_info().name))?;
        // Colours are encoded already: an sRGB format would encode them twice.
        let formats = surface.get_capabilities(&adapter).formats;
        let plain = formats
            .iter()
            .copied()
            .find(|format| matches!(format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm));
        configuration.format = plain.unwrap_or(configuration.format);
        configuration.desired_maximum_frame_latency = 1;
        surface.configure(&device, &configuration);
        // On a software adapter, dithering would take CPU time from the renderer.
        let options = RendererOptions { dithering: !is_software, ..RendererOptions::default() };
        let mut renderer = Renderer::new(&device, configuration.format, options);
        for (id, whole) in &textures.0 {
            renderer.update_texture(&device, &queue, *id, whole);
        }
        let painter = Self { surface, configuration, device, queue, renderer, lost, failure, limit };
        Ok((painter, adapter.get_info().name))
    }

    /// Largest side of a texture, pixels.
    pub(super) fn max_texture_side(&self) -> usize {
        self.limit as usize
    }

    /// Destroys the device as a driver restart would; used to test recovery.
    pub(super) fn lose_device(&self) {
        self.device.destroy();
    }

    /// Draws a frame at the size of the window. Texture updates are applied in any case.
    pub(super) fn paint(
        &mut self,
        window: &Window,
        primitives: &[ClippedPrimitive],
        mut changes: TexturesDelta,
        pixels_per_point: f32,
        kept: &mut Textures,
    ) -> Result<(), PaintError> {
        for (id, deltas) in changes.set.drain() {
            for delta in deltas {
                kept.apply(id, &delta);
                if !self.is_lost() {
                    self.renderer.update_texture(&self.device, &self.queue, id, &delta);
                }
            }
        }
        let result = self.paint_primitives(window, primitives, pixels_per_point);
        for id in changes.free.drain() {
            kept.0.remove(&id);
            self.renderer.free_texture(&id);
        }
        result?;
        if self.is_lost() { Err(self.why_lost()) } else { Ok(()) }
    }

    fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }

    fn why_lost(&self) -> PaintError {
        let why = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone();
        PaintError::Lost(why.unwrap_or_else(|| "the graphics device was lost".to_owned()))
    }

    fn paint_primitives(
        &mut self,
        window: &Window,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<(), PaintError> {
        let size = window.inner_size();
        if size.width == 0 || size.height == 0 {
            return Ok(());
        }
        if self.is_lost() {
            return Err(self.why_lost());
        }
        let size = [size.width.min(self.limit), size.height.min(self.limit)];
        if [self.configuration.width, self.configuration.height] != size {
            [self.configuration.width, self.configuration.height] = size;
            self.surface.configure(&self.device, &self.configuration);
        }
        let texture = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => texture,
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => return Ok(()),
            wgpu::CurrentSurfaceTexture::Outdated => {
                self.surface.configure(&self.device, &self.configuration);
                window.request_redraw();
                return Ok(());
            }
            wgpu::CurrentSurfaceTexture::Lost => {
                return Err(PaintError::Lost("the window's surface was lost".to_owned()));
            }
            wgpu::CurrentSurfaceTexture::Validation => return Err(self.why_lost()),
        };
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        let buffers = self.renderer.update_buffers(&self.device, &self.queue, &mut encoder, primitives, &screen);
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                    depth_slice: None,
                })],
                depth_stencil_attachment: None,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            self.renderer.render(&mut pass.forget_lifetime(), primitives, &screen);
        }
        self.queue.submit(buffers.into_iter().chain([encoder.finish()]));
        window.pre_present_notify();
        self.queue.present(texture);
        Ok(())
    }
}
