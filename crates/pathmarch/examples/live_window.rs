//! A window of your own with a live picture: `cargo run --release --example live_window [SCENE]`. Drag to orbit.
//!
//! `Live` renders on its own thread and wakes the window when there is a new picture. The window copies the picture and
//! enlarges it while it is smaller than the window. Any toolkit that can show pixels works as well as winit and
//! softbuffer.

use glam::{Quat, Vec3};
use pathmarch_render::live::{Live, RenderRequest};
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Settings};
use softbuffer::{Context, Surface};
use std::error::Error;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Duration;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, OwnedDisplayHandle};
use winit::window::{Window, WindowId};

/// Orbit angle per pixel of mouse movement, radians.
const TURN: f32 = 0.005;

/// Event: there is a new picture.
#[derive(Debug)]
struct NewPicture;

struct Viewer {
    scene: Arc<Scene>,
    camera: Camera,
    live: Live,
    surface: Option<Surface<OwnedDisplayHandle, Arc<Window>>>,
    dragging: bool,
    failure: Option<Box<dyn Error>>,
}

impl Viewer {
    /// Orders the renderer to show the current view.
    fn order(&mut self) {
        let Some(surface) = &self.surface else { return };
        let size = surface.window().inner_size();
        if size.width == 0 || size.height == 0 {
            return;
        }
        let settings = Settings {
            size: [size.width, size.height],
            viewpoint: Some(self.camera.clone()),
            ..Settings::of(&self.scene)
        };
        let display = Display { tonemap: self.scene.render.tonemap, exposure_stops: self.camera.exposure };
        self.live.show(RenderRequest {
            scene: self.scene.clone(),
            settings,
            display,
            auto_exposure: self.camera.auto_exposure,
            moving: self.dragging,
            frame_time: Duration::from_millis(33),
            reconstruct: Some(Default::default()),
        });
    }

    /// Orbits the camera around its target.
    fn turn(&mut self, [x, y]: [f32; 2]) {
        let target = Vec3::from(self.camera.target);
        let offset = Vec3::from(self.camera.position) - target;
        let pole_angle = offset.angle_between(Vec3::Y);
        let pitch = (-TURN * y).clamp(0.05 - pole_angle, std::f32::consts::PI - 0.05 - pole_angle);
        let side = Vec3::Y.cross(offset).normalize_or(Vec3::X);
        let turned = Quat::from_rotation_y(-TURN * x) * Quat::from_axis_angle(side, pitch) * offset;
        self.camera.position = (target + turned).into();
        self.order();
    }

    /// Copies the newest picture to the window.
    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        let (Some(surface), Some(shown)) = (&mut self.surface, self.live.picture()) else { return Ok(()) };
        let size = surface.window().inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else {
            return Ok(());
        };
        surface.resize(width, height)?;
        let mut buffer = surface.buffer_mut()?;
        let (width, height) = (size.width as usize, size.height as usize);
        let [across, down] = shown.size.map(|side| side as usize);
        for (y, row) in buffer.chunks_exact_mut(width).enumerate() {
            for (x, pixel) in row.iter_mut().enumerate() {
                let from = 4 * (y * down / height * across + x * across / width);
                let [r, g, b] = [0, 1, 2].map(|channel| u32::from(shown.codes[from + channel]));
                *pixel = r << 16 | g << 8 | b;
            }
        }
        buffer.present()?;
        Ok(())
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let attributes =
            Window::default_attributes().with_title("live").with_inner_size(LogicalSize::new(640.0, 360.0));
        let window = Arc::new(event_loop.create_window(attributes)?);
        self.surface = Some(Surface::new(&Context::new(event_loop.owned_display_handle())?, window)?);
        self.order();
        Ok(())
    }

    fn end_if_failed(&mut self, result: Result<(), Box<dyn Error>>, event_loop: &ActiveEventLoop) {
        if let Err(error) = result {
            self.failure = Some(error);
            event_loop.exit();
        }
    }
}

impl ApplicationHandler<NewPicture> for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let opened = self.open(event_loop);
        self.end_if_failed(opened, event_loop);
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, _: NewPicture) {
        if let Some(surface) = &self.surface {
            surface.window().request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) => self.order(),
            WindowEvent::RedrawRequested => {
                let drawn = self.draw();
                self.end_if_failed(drawn, event_loop);
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.dragging = state == ElementState::Pressed;
                self.order();
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _event_loop: &ActiveEventLoop, _id: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta: (x, y) } = event
            && self.dragging
        {
            self.turn([x as f32, y as f32]);
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = match std::env::args().nth(1) {
        Some(path) => Scene::load(path)?,
        None => {
            let example = pathmarch_gallery::EXAMPLES.iter().find(|example| example.name == "ten-lines");
            Scene::parse("ten-lines.kdl", example.ok_or("the gallery has no such scene")?.text)?
        }
    };
    let event_loop = EventLoop::<NewPicture>::with_user_event().build()?;
    let proxy = event_loop.create_proxy();
    // Fails only when the loop has ended, and then the program ends.
    let live = Live::new(Backend::Auto, None, move || drop(proxy.send_event(NewPicture)));
    let camera = scene.cameras[0].clone();
    let mut viewer = Viewer { scene: Arc::new(scene), camera, live, surface: None, dragging: false, failure: None };
    event_loop.run_app(&mut viewer)?;
    viewer.failure.map_or(Ok(()), Err)
}
