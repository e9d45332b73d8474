//! Playback of an animation: play, pause, and step through frames.
//!
//! The document is evaluated at another time; its text stays as it is. Playback keeps real time: if a picture takes
//! longer than a frame, frames are skipped.

use super::App;
use egui::Context;
use pathmarch_render::pathmarch_scene::Moment;
use std::time::Duration;

impl App {
    /// Starts or stops playback.
    pub(crate) fn play_or_pause(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        if !open.document.last_good().is_some_and(|scene| scene.animated) {
            self.show_message("This scene is not animated: use a formula of t, such as rotate 0 \"90*t\" 0.");
            return;
        }
        open.playback.playing = match open.playback.playing {
            Some(_) => None,
            None => Some((ctx.input(|input| input.time), open.document.moment().frame)),
        };
    }

    /// Stops playback and shows the next or the previous frame.
    pub(crate) fn step_frame(&mut self, forwards: bool) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().filter(|scene| scene.animated) else { return };
        let (fps, count) = (scene.render.fps, open.playback.last + 1);
        let frame = open.document.moment().frame;
        open.playback.playing = None;
        self.show_frame((if forwards { frame + 1 } else { frame + count - 1 }) % count, fps);
    }

    /// Shows the frame that is due, during playback.
    pub(crate) fn advance_playback(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good() else { return };
        let fps = scene.render.fps;
        if !scene.animated {
            open.playback.playing = None;
        }
        let Some((frame, left)) = open.playback.due(ctx.input(|input| input.time), fps) else { return };
        ctx.request_repaint_after(Duration::from_secs_f64(left));
        self.show_frame(frame, fps);
    }

    /// Shows a frame. A camera that the user has moved stays where it is.
    pub(crate) fn show_frame(&mut self, frame: u32, fps: f32) {
        let Some(open) = &mut self.open else { return };
        let moment = Moment::of_frame(frame, fps);
        if moment == open.document.moment() {
            return;
        }
        open.document.set_moment(moment);
        if let Some(scene) = open.document.last_good().cloned()
            && !open.view.is_camera_modified()
        {
            open.view.sync_camera(&scene);
        }
        open.view.mark_moving();
    }
}
