//! Camera controls.

use crate::window::app::App;
use egui::{ComboBox, DragValue, Slider, SliderClamping, Ui};
use pathmarch_render::pathmarch_scene::{Camera, settings};

impl App {
    /// Controls of the view: it starts as the scene's camera and stays separate until it is written to the scene.
    pub(super) fn camera_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        ui.horizontal(|ui| {
            ui.heading("Camera");
            let mut chosen = None;
            ComboBox::from_id_salt("cameras")
                .selected_text(open.view.camera_name())
                .show_ui(ui, |ui| {
                    for camera in &scene.cameras {
                        let is_it = camera.name == open.view.camera_name();
                        if ui.selectable_label(is_it, &camera.name).clicked() {
                            chosen = Some(camera);
                        }
                    }
                })
                .response
                .on_hover_text("The cameras of the scene.");
            if let Some(camera) = chosen {
                open.view.use_camera(camera);
            }
        });
        let before = open.view.camera.clone();
        let shown_stops = self.live.picture().map_or(0.0, |picture| picture.exposure_stops);
        let camera = &mut open.view.camera;
        egui::Grid::new("camera").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
            let label = ui.label("field of view").on_hover_text("Vertical, degrees.");
            ui.add(Slider::new(&mut camera.fov, 5.0..=120.0).suffix("°").clamping(SliderClamping::Never))
                .labelled_by(label.id);
            ui.end_row();
            let label = ui.label("exposure").on_hover_text("In stops; affects the display, PNG and JPEG, never EXR.");
            ui.horizontal(|ui| {
                let mut stops =
                    if camera.auto_exposure { (shown_stops * 10.0).round() / 10.0 } else { camera.exposure };
                let slider = Slider::new(&mut stops, -6.0..=6.0).suffix(" EV").clamping(SliderClamping::Never);
                if ui.add(slider).labelled_by(label.id).changed() {
                    (camera.exposure, camera.auto_exposure) = (stops, false);
                }
                let words = "Follow the picture: its mean becomes middle grey.";
                if ui.toggle_value(&mut camera.auto_exposure, "Auto").on_hover_text(words).clicked() {
                    // The picture stays as it is when it no longer follows.
                    camera.exposure = if camera.auto_exposure { 0.0 } else { stops };
                }
            });
            ui.end_row();
            let label =
                ui.label("lens radius").on_hover_text("In metres; 0 is a pinhole camera, without depth of field.");
            let lens = Slider::new(&mut camera.lens_radius, 0.0..=0.5).suffix(" m").logarithmic(true);
            ui.add(lens.smallest_positive(1e-3).clamping(SliderClamping::Never)).labelled_by(label.id);
            ui.end_row();
            let label = ui.label("focus distance").on_hover_text("Distance in focus; by default that of the target.");
            ui.horizontal(|ui| {
                let mut distance = camera
                    .focus
                    .unwrap_or_else(|| glam::Vec3::from(camera.position).distance(glam::Vec3::from(camera.target)));
                let speed = 0.01 * f64::from(distance.max(0.01));
                let value = DragValue::new(&mut distance).speed(speed).suffix(" m").range(1e-3..=1e6);
                if ui.add(value).labelled_by(label.id).changed() {
                    camera.focus = Some(distance);
                }
                ui.toggle_value(&mut open.view.focus_click, "Pick in view")
                    .on_hover_text("Click a surface to focus on it.");
            });
            ui.end_row();
        });
        // A typed value can be infinite or NaN.
        for (value, before) in [
            (&mut camera.fov, before.fov),
            (&mut camera.lens_radius, before.lens_radius),
            (&mut camera.exposure, before.exposure),
        ] {
            if !value.is_finite() {
                *value = before;
            }
        }
        camera.focus = camera.focus.filter(|focus| focus.is_finite());
        camera.fov = camera.fov.clamp(0.1, 179.0);
        camera.lens_radius = camera.lens_radius.max(0.0);
        camera.exposure = camera.exposure.clamp(settings::EXPOSURE.min, settings::EXPOSURE.max);
        // The exposure changes nothing but the display.
        let before = Camera { exposure: camera.exposure, auto_exposure: camera.auto_exposure, ..before };
        if *camera != before {
            open.view.mark_moving();
        }
        let (moved, mut write, mut back) = (open.view.is_camera_modified(), false, false);
        ui.horizontal(|ui| {
            ui.add_enabled_ui(moved, |ui| {
                let words = "Set the scene's camera to the current view.";
                write = ui.button("Save view to camera").on_hover_text(words).clicked();
                back = ui.button("Reset").on_hover_text("Return to the scene's camera.").clicked();
            });
        });
        if back && let Some(camera) = scene.cameras.iter().find(|camera| camera.name == open.view.camera_name()) {
            open.view.use_camera(camera);
        }
        if write {
            self.write_camera();
        }
    }
}
