//! Time in the window: the frames of a scene whose formulas know the time, shown one by one or played.
//!
//! The document is read as of another moment, its text stays as it is. Frames are shown when their time has come: where
//! pictures take longer than a frame, some are left out, so that what moves keeps its speed.

use super::app::App;
use super::dialogs::{Dialog, RenderDialog};
use egui::{Context, DragValue, Slider, SliderClamping, Ui};
use pathmarch_render::pathmarch_scene::Moment;
use std::time::Duration;

/// How time goes on.
pub(super) struct Timeline {
    /// The last frame; playing goes on with frame 0.
    pub(super) last: u32,
    /// Since when it plays, seconds, and with which frame it began.
    playing: Option<(f64, u32)>,
}

impl Default for Timeline {
    fn default() -> Self {
        Self { last: 119, playing: None }
    }
}

/// The largest number of a frame.
pub(super) const LAST_FRAME: u32 = 999_999;

impl Timeline {
    pub(super) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// The frame that is to be shown at this time, and seconds until the next one is, while it plays.
    fn due(&self, now: f64, fps: f32) -> Option<(u32, f64)> {
        let (since, first) = self.playing?;
        let frames = (now - since).max(0.0) * f64::from(fps);
        let frame = (u64::from(first) + frames as u64) % (u64::from(self.last) + 1);
        Some((frame as u32, (1.0 - frames.fract()) / f64::from(fps)))
    }
}

impl App {
    /// Begins to play, or stops.
    pub(super) fn play_or_pause(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        if !open.document.last_good().is_some_and(|scene| scene.animated) {
            self.say("Nothing in this scene depends on the time: write a formula with t, as in rotate 0 \"90*t\" 0.");
            return;
        }
        open.timeline.playing = match open.timeline.playing {
            Some(_) => None,
            None => Some((ctx.input(|input| input.time), open.document.moment().frame)),
        };
    }

    /// Shows the next frame, or the one before, and plays no longer.
    pub(super) fn step_frame(&mut self, forwards: bool) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().filter(|scene| scene.animated) else { return };
        let (fps, count) = (scene.render.fps, open.timeline.last + 1);
        let frame = open.document.moment().frame;
        open.timeline.playing = None;
        self.look_at((if forwards { frame + 1 } else { frame + count - 1 }) % count, fps);
    }

    /// While it plays, goes to the frame that is due.
    pub(super) fn keep_time(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good() else { return };
        let fps = scene.render.fps;
        if !scene.animated {
            open.timeline.playing = None;
        }
        let Some((frame, left)) = open.timeline.due(ctx.input(|input| input.time), fps) else { return };
        ctx.request_repaint_after(Duration::from_secs_f64(left));
        self.look_at(frame, fps);
    }

    /// Shows a frame. A viewpoint of one's own stays.
    fn look_at(&mut self, frame: u32, fps: f32) {
        let Some(open) = &mut self.open else { return };
        let moment = Moment::of_frame(frame, fps);
        if moment == open.document.moment() {
            return;
        }
        open.document.set_moment(moment);
        if let Some(scene) = open.document.last_good().cloned()
            && !open.view.has_moved_away()
        {
            open.view.follow(&scene);
        }
        open.view.touch();
    }

    /// The frames, where there is more than one to be seen.
    pub(super) fn timeline_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().filter(|scene| scene.animated) else { return };
        let (fps, moment, plays) = (scene.render.fps, open.document.moment(), open.timeline.is_playing());
        let (mut frame, mut last) = (moment.frame, open.timeline.last);
        let (mut toggled, mut rendered) = (false, false);
        egui::Panel::bottom("timeline").show(ui, |ui| {
            ui.horizontal(|ui| {
                let words = if plays { "Pause" } else { "Play" };
                toggled = ui.button(words).on_hover_text("Space; comma and full stop go frame by frame.").clicked();
                ui.monospace(format!("{:7.3} s", moment.seconds));
                let label = ui.label("Frame");
                ui.spacing_mut().slider_width = (ui.available_width() - 420.0).max(80.0);
                ui.add(Slider::new(&mut frame, 0..=last).clamping(SliderClamping::Always)).labelled_by(label.id);
                let label = ui.label("Last frame").on_hover_text("Playing goes on with frame 0 after it.");
                ui.add(DragValue::new(&mut last).range(1..=LAST_FRAME)).labelled_by(label.id);
                ui.weak(format!("{fps} a second"));
                rendered = ui.button("Render frames…").on_hover_text("Each to a file, in the background.").clicked();
            });
        });
        open.timeline.last = last;
        if toggled {
            let ctx = ui.ctx().clone();
            self.play_or_pause(&ctx);
        } else if frame != moment.frame {
            open.timeline.playing = None;
            self.look_at(frame.min(last), fps);
        }
        if rendered {
            self.dialog = self.open.as_ref().and_then(RenderDialog::of_frames).map(Dialog::Render);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_due_when_their_time_has_come() {
        let timeline = Timeline { last: 9, playing: Some((100.0, 4)) };
        assert_eq!(timeline.due(100.0, 25.0).map(|(frame, _)| frame), Some(4));
        let (frame, left) = timeline.due(100.05, 25.0).expect("it plays");
        assert!(frame == 5 && (left - 0.03).abs() < 1e-9, "{frame} {left}");
        // After frame 9 comes frame 0.
        assert_eq!(timeline.due(100.21, 25.0).map(|(frame, _)| frame), Some(9));
        assert_eq!(timeline.due(100.25, 25.0).map(|(frame, _)| frame), Some(0));
        assert_eq!(Timeline::default().due(5.0, 25.0), None);
    }
}
