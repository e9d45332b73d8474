//! Live picture: sends orders to the renderer and uploads its pictures.

use super::App;
use crate::window::open_scene::OpenScene;
use egui::{ColorImage, Context, TextureOptions};
use pathmarch_render::Settings;
use pathmarch_render::live::RenderRequest;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use std::time::Duration;

impl App {
    /// Uploads a new picture as a texture.
    pub(super) fn upload_picture(&mut self, ctx: &Context) {
        let (Some(open), Some(shown)) = (&mut self.open, self.live.picture()) else { return };
        let is_other_scene = self.first_order.is_none_or(|first| shown.request < first);
        if is_other_scene || open.view.picture.as_ref().is_some_and(|(_, serial, _)| *serial == shown.serial) {
            return;
        }
        let size = shown.size.map(|side| side as usize);
        let image = ColorImage::from_rgba_premultiplied(size, &shown.codes);
        match &mut open.view.picture {
            Some((texture, serial, old)) => {
                texture.set(image, TextureOptions::LINEAR);
                (*serial, *old) = (shown.serial, shown.size);
            }
            slot => {
                let texture = ctx.load_texture("picture", image, TextureOptions::LINEAR);
                *slot = Some((texture, shown.serial, shown.size));
            }
        }
        self.performance.picture(&shown, self.live.status().samples_per_second);
    }

    /// Sends the renderer a new order if the scene or the view has changed.
    pub(super) fn order_picture(&mut self, ctx: &Context) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let moving = open.view.time_until_still();
        if open.view.available_pixels.contains(&0) {
            return;
        }
        let order = RenderRequest {
            settings: Self::settings(open, &scene),
            display: Self::display(open, &scene),
            auto_exposure: open.view.mode.has_auto_exposure(&open.view.camera),
            scene,
            moving: moving.is_some(),
            frame_time: Duration::from_secs_f32(1.0 / self.preferences.frame_rate.clamp(1.0, 240.0)),
            reconstruct: self.preferences.reconstruct.then_some(self.reconstruct_options),
        };
        let same = self.ordered.as_ref().is_some_and(|old| {
            self.ordered_revision == open.document.scene_revision()
                && old.settings == order.settings
                && old.display == order.display
                && old.auto_exposure == order.auto_exposure
                && old.moving == order.moving
                && old.frame_time == order.frame_time
                && old.reconstruct == order.reconstruct
        });
        if !same {
            let number = self.live.show(order.clone());
            self.first_order.get_or_insert(number);
            self.ordered = Some(order);
            self.ordered_revision = open.document.scene_revision();
        }
        if let Some(left) = moving {
            ctx.request_repaint_after(left + Duration::from_millis(5));
        }
    }

    /// Discards the picture of the previous scene.
    pub(crate) fn discard_picture(&mut self) {
        (self.ordered, self.first_order) = (None, None);
    }

    /// Render settings of the live picture.
    pub(crate) fn settings(open: &OpenScene, scene: &Scene) -> Settings {
        let asked = Settings::of(scene);
        let mode = open.view.mode;
        Settings {
            size: open.view.picture_size(scene),
            samples: mode.samples(asked.samples),
            viewpoint: Some(open.view.camera.clone()),
            mode,
            preview_steps: open.view.preview_steps,
            ..asked
        }
    }

    /// Tone curve and exposure of the view; without a film, an automatic exposure is 0.
    pub(crate) fn display(open: &OpenScene, scene: &Scene) -> Display {
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: open.view.camera.exposure };
        open.view.mode.display(display)
    }
}
