//! Event loop of the window (winit): input events, frames, and recovery from a lost graphics device.

use super::app::{App, Options};
use super::painter::{Drawing, PaintError, Painter, Textures};
use pathmarch_cli::{DONE, Failure};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

/// Request for a frame from another thread.
#[derive(Debug)]
struct Wake;

/// Delay before a failed graphics device is reopened, and maximum number of attempts in a row.
const RETRY_AFTER: Duration = Duration::from_millis(500);
const RETRIES: u32 = 20;
/// Initial window size, points.
const SIZE: (f64, f64) = (1360.0, 860.0);

/// Opens the window; returns when it is closed.
pub fn run(options: Options, drawing: Drawing) -> Result<u8, Failure> {
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|error| {
        let error = error.to_string();
        // The error begins with a place in the library's source; drop it.
        let why = error.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*error, |(_, why)| why);
        let why = why.trim_end_matches('.');
        Failure::Other(format!("no window can be opened: {why}; `pathmarch render` works without one"))
    })?;
    let proxy = event_loop.create_proxy();
    let waker = Arc::new(move || {
        // Fails only when the loop has ended, and then the program ends.
        let _ = proxy.send_event(Wake);
    });
    let ctx = egui::Context::default();
    let mut handler = WindowHandler {
        app: App::new(&ctx, options, waker),
        ctx,
        window: None,
        drawing,
        painter: None,
        textures: Textures::default(),
        retry: None,
        failures: 0,
        repaint_at: None,
        failure: None,
    };
    event_loop.run_app(&mut handler).map_err(|error| Failure::Other(format!("the window failed: {error}")))?;
    handler.app.shut_down();
    handler.failure.map_or(Ok(DONE), Err)
}

struct WindowHandler {
    app: App,
    ctx: egui::Context,
    window: Option<(Arc<Window>, egui_winit::State, String)>,
    drawing: Drawing,
    painter: Option<Painter>,
    textures: Textures,
    /// Time of the next attempt to open a painter.
    retry: Option<Instant>,
    failures: u32,
    repaint_at: Option<Instant>,
    failure: Option<Failure>,
}

impl WindowHandler {
    fn open_window(&mut self, event_loop: &ActiveEventLoop) -> Result<(), String> {
        let title = self.app.title();
        let attributes = Window::default_attributes()
            .with_title(&title)
            .with_inner_size(LogicalSize::new(SIZE.0, SIZE.1))
            .with_min_inner_size(LogicalSize::new(480.0, 320.0));
        let window = Arc::new(event_loop.create_window(attributes).map_err(|error| error.to_string())?);
        let scale = window.scale_factor() as f32;
        let theme = window.theme();
        let id = egui::ViewportId::ROOT;
        let state = egui_winit::State::new(self.ctx.clone(), id, &window, Some(scale), theme, None);
        self.window = Some((window, state, title));
        self.open_painter(event_loop)
    }

    fn open_painter(&mut self, event_loop: &ActiveEventLoop) -> Result<(), String> {
        self.retry = None;
        let Some((window, state, _)) = &mut self.window else { return Ok(()) };
        // A window has one surface: drop the old painter first.
        self.painter = None;
        let painter = Painter::new(self.drawing, window, event_loop.owned_display_handle(), &self.textures)?;
        state.set_max_texture_side(painter.max_texture_side());
        self.app.log_milestone("window on", &painter.adapter);
        self.painter = Some(painter);
        window.request_redraw();
        Ok(())
    }

    /// Handles a failure of the window's graphics device: schedules another attempt, or gives up with all work kept.
    fn painter_failed(&mut self, event_loop: &ActiveEventLoop, why: String) {
        self.painter = None;
        self.failures += 1;
        self.app.flush_recovery();
        if self.failures > RETRIES {
            let kept = self.app.recovery_note();
            self.failure = Some(Failure::Other(format!(
                "the window cannot be drawn: {why}; try `--drawing cpu`, or use `pathmarch render`, which works without a \
                 window{kept}"
            )));
            event_loop.exit();
            return;
        }
        eprintln!("pathmarch: the window's graphics device failed: {why}; trying again");
        self.retry = Some(Instant::now() + RETRY_AFTER);
    }

    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let Some((window, state, shown_title)) = &mut self.window else { return };
        let size = window.inner_size();
        if size.width == 0 || size.height == 0 {
            // Minimised: nothing to draw, but background work continues.
            self.repaint_at = Some(Instant::now() + Duration::from_millis(250));
            return;
        }
        let begun = Instant::now();
        let input = state.take_egui_input(window);
        let app = &mut self.app;
        let output = self.ctx.run_ui(input, |ui| app.ui(ui));
        state.handle_platform_output(window, output.platform_output);
        if app.take_device_reset()
            && let Some(painter) = &self.painter
        {
            painter.lose_device();
        }
        let title = app.title();
        if *shown_title != title {
            window.set_title(&title);
            *shown_title = title;
        }
        let primitives = self.ctx.tessellate(output.shapes, output.pixels_per_point);
        let root = egui::ViewportId::ROOT;
        let delay = output.viewport_output.get(&root).map_or(Duration::MAX, |viewport| viewport.repaint_delay);
        self.repaint_at = Instant::now().checked_add(delay);
        let mut changes = output.textures_delta;
        let painted = match &mut self.painter {
            Some(painter) => painter.paint(window, &primitives, changes, output.pixels_per_point, &mut self.textures),
            None => {
                self.textures.apply_all(&mut changes);
                Ok(())
            }
        };
        match painted {
            Ok(()) => {
                self.failures = 0;
                self.app.frame_drawn(begun.elapsed());
            }
            Err(PaintError::Lost(why)) => self.painter_failed(event_loop, why),
        }
        if self.app.should_quit() {
            event_loop.exit();
        }
    }
}

impl ApplicationHandler<Wake> for WindowHandler {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_some() {
            return;
        }
        if let Err(why) = self.open_window(event_loop) {
            if self.window.is_some() {
                // If there is no adapter at all, do not retry.
                self.failures = RETRIES;
            }
            self.painter_failed(event_loop, why.clone());
            if self.failure.is_none() {
                self.failure = Some(Failure::Other(format!("no window can be opened: {why}")));
                event_loop.exit();
            }
        }
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, _event: Wake) {
        if let Some((window, ..)) = &self.window {
            window.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        let Some((window, state, _)) = &mut self.window else { return };
        match event {
            WindowEvent::RedrawRequested => return self.frame(event_loop),
            WindowEvent::CloseRequested => {
                self.app.request_quit();
                window.request_redraw();
            }
            _ => {
                if state.on_window_event(window, &event).repaint {
                    window.request_redraw();
                }
            }
        }
        if let WindowEvent::Resized(_) = event {
            window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = Instant::now();
        if self.retry.is_some_and(|at| now >= at)
            && let Err(why) = self.open_painter(event_loop)
        {
            self.painter_failed(event_loop, why);
        }
        if self.repaint_at.is_some_and(|at| now >= at) {
            self.repaint_at = None;
            if let Some((window, ..)) = &self.window {
                window.request_redraw();
            }
        }
        let next = [self.retry, self.repaint_at].into_iter().flatten().min();
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
