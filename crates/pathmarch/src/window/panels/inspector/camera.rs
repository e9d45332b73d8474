//! Camera controls.

use crate::window::app::App;
use egui::{ComboBox, DragValue, Slider, SliderClamping, Ui};
use pathmarch_render::exposure::suitable_stops;
use pathmarch_render::pathmarch_scene::settings;

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
        let camera = &mut open.view.camera;
        let mut auto_exposure = false;
        egui::Grid::new("camera").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
            let label = ui.label("field of view").on_hover_text("Vertical, degrees.");
            ui.add(Slider::new(&mut camera.fov, 5.0..=120.0).suffix("°").clamping(SliderClamping::Never))
                .labelled_by(label.id);
            ui.end_row();
            let label = ui.label("exposure").on_hover_text("In stops; affects the display, PNG and JPEG, never EXR.");
            ui.horizontal(|ui| {
                ui.add(Slider::new(&mut camera.exposure, -6.0..=6.0).suffix(" EV").clamping(SliderClamping::Never))
                    .labelled_by(label.id);
                let words = "Choose the exposure that makes the picture of middle brightness.";
                auto_exposure = ui.button("Auto").on_hover_text(words).clicked();
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
        if auto_exposure {
            self.choose_exposure();
        }
    }

    /// Sets the exposure of the view to one that suits the picture.
    fn choose_exposure(&mut self) {
        let answer = self.live.film().recv().unwrap_or_else(|_| Err("the renderer has stopped".to_owned()));
        match (answer.map(|(film, _)| suitable_stops(&film)), &mut self.open) {
            (Ok(Some(stops)), Some(open)) => {
                open.view.camera.exposure = stops.clamp(settings::EXPOSURE.min, settings::EXPOSURE.max);
            }
            (Ok(None), _) => self.show_message("The picture is black: it needs light."),
            (Err(why), _) => self.show_message(&format!("No exposure yet: {why}.")),
            (Ok(Some(_)), None) => {}
        }
    }
}
