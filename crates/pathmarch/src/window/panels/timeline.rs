//! Timeline: play button, frame slider, and the button that renders all frames.

use crate::window::app::App;
use crate::window::app::dialog::{Dialog, RenderDialog};
use crate::window::gizmo;
use crate::window::open_scene::playback::LAST_FRAME;
use egui::style::HandleShape;
use egui::{DragValue, Pos2, Rect, Shape, Slider, SliderClamping, Stroke, Ui, Vec2};

/// Handle of the frame slider.
const HANDLE: HandleShape = HandleShape::Rect { aspect_ratio: 0.4 };

impl App {
    /// Draws the timeline of an animated scene.
    pub(crate) fn timeline_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().filter(|scene| scene.animated) else { return };
        let (fps, moment, plays) = (scene.render.fps, open.document.moment(), open.playback.is_playing());
        let (mut frame, mut last) = (moment.frame, open.playback.last);
        let (mut toggled, mut rendered) = (false, false);
        let selected =
            open.view.selection.active().map(|path| gizmo::target_node(&open.document, path).unwrap_or(path.clone()));
        let times = selected.map_or_else(Vec::new, |path| open.document.key_times(&path));
        let frames_of_keys: Vec<f32> = times.iter().map(|time| *time as f32 * fps).collect();
        egui::Panel::bottom("timeline").show(ui, |ui| {
            ui.horizontal(|ui| {
                let words = if plays { "Pause" } else { "Play" };
                toggled = ui.button(words).on_hover_text("Space. Comma and full stop step through frames.").clicked();
                ui.monospace(format!("{:7.3} s", moment.seconds));
                let label = ui.label("Frame");
                ui.spacing_mut().slider_width = (ui.available_width() - 420.0).max(80.0);
                let slider = Slider::new(&mut frame, 0..=last).clamping(SliderClamping::Always).handle_shape(HANDLE);
                let width = ui.spacing().slider_width;
                let slider = ui.add(slider).labelled_by(label.id);
                draw_keys(ui, slider.rect, width, &frames_of_keys, last);
                let label = ui.label("Last frame").on_hover_text("Playback continues with frame 0.");
                ui.add(DragValue::new(&mut last).range(1..=LAST_FRAME)).labelled_by(label.id);
                ui.weak(format!("{fps} fps"));
                rendered = ui
                    .button("Render frames…")
                    .on_hover_text("Render each frame to a file, in the background.")
                    .clicked();
            });
        });
        open.playback.last = last;
        if toggled {
            let ctx = ui.ctx().clone();
            self.play_or_pause(&ctx);
        } else if frame != moment.frame {
            open.playback.playing = None;
            self.show_frame(frame.min(last), fps);
        }
        if rendered {
            self.dialog = self.open.as_ref().and_then(RenderDialog::of_frames).map(Dialog::Render);
        }
    }
}

/// Draws the keys of the selection on the frame slider.
fn draw_keys(ui: &Ui, slider: Rect, width: f32, frames: &[f32], last: u32) {
    let colour = ui.visuals().warn_fg_color;
    let radius = 0.5 * slider.height() * 0.8 * 0.4;
    let track = slider.min.x + radius..=slider.min.x + width - radius;
    for frame in frames.iter().filter(|frame| **frame >= 0.0 && **frame <= last as f32) {
        let x = egui::lerp(track.clone(), frame / last as f32);
        let middle = Pos2::new(x, slider.max.y - 2.5);
        let corners = [Vec2::UP, Vec2::RIGHT, Vec2::DOWN, Vec2::LEFT].map(|way| middle + 3.5 * way);
        ui.painter().add(Shape::convex_polygon(corners.to_vec(), colour, Stroke::NONE));
    }
}
