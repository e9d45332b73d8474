//! Timeline: play button, frame slider, and the button that renders all frames.

use crate::window::app::App;
use crate::window::app::dialog::{Dialog, RenderDialog};
use crate::window::open_scene::playback::LAST_FRAME;
use egui::{DragValue, Slider, SliderClamping, Ui};

impl App {
    /// Draws the timeline of an animated scene.
    pub(crate) fn timeline_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().filter(|scene| scene.animated) else { return };
        let (fps, moment, plays) = (scene.render.fps, open.document.moment(), open.playback.is_playing());
        let (mut frame, mut last) = (moment.frame, open.playback.last);
        let (mut toggled, mut rendered) = (false, false);
        egui::Panel::bottom("timeline").show(ui, |ui| {
            ui.horizontal(|ui| {
                let words = if plays { "Pause" } else { "Play" };
                toggled = ui.button(words).on_hover_text("Space. Comma and full stop step through frames.").clicked();
                ui.monospace(format!("{:7.3} s", moment.seconds));
                let label = ui.label("Frame");
                ui.spacing_mut().slider_width = (ui.available_width() - 420.0).max(80.0);
                ui.add(Slider::new(&mut frame, 0..=last).clamping(SliderClamping::Always)).labelled_by(label.id);
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
