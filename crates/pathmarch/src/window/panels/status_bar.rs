//! Status bar: progress of renders, samples, backend and adapter.

use crate::window::app::App;
use egui::{RichText, Ui};
use indicatif::HumanDuration;
use std::time::Duration;

impl App {
    pub(crate) fn status_bar(&mut self, ui: &mut Ui) {
        let mut cancelled = None;
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                for (index, export) in self.renders.iter().enumerate() {
                    let progress = export.progress();
                    let share = (progress.samples / progress.of.max(1.0)) as f32;
                    let left = progress.remaining.map_or(String::new(), |left| {
                        let left = HumanDuration(Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX));
                        format!(", {left:#} left")
                    });
                    let name = export.output().file_name().unwrap_or_default().to_string_lossy();
                    let words = if progress.writing {
                        format!("{name}: writing")
                    } else {
                        format!("{name}: {:.0} %{left}", 100.0 * share)
                    };
                    ui.add(egui::ProgressBar::new(share).text(words).desired_width(240.0));
                    if ui.small_button("Cancel").on_hover_text("Stop this render; no file is written.").clicked() {
                        cancelled = Some(index);
                    }
                    if ui
                        .small_button("Stop and keep")
                        .on_hover_text("Stop, and write the samples done so far.")
                        .clicked()
                    {
                        export.stop_and_keep();
                    }
                    ui.separator();
                }
                self.renderer_status(ui);
            });
        });
        if let Some(export) = cancelled.and_then(|index| self.renders.get(index)) {
            export.cancel();
        }
    }

    fn renderer_status(&self, ui: &mut Ui) {
        let Some(open) = &self.open else {
            ui.weak("Choose a scene, or drop a .kdl file onto the window. Press F1 for help.");
            return;
        };
        let status = self.live.status();
        let Some((_, _, [width, height])) = &open.view.picture else {
            let waits = match open.document.last_good() {
                Some(_) => "Rendering the first image…",
                None => "No picture: the scene has errors.",
            };
            ui.label(status.error.as_deref().unwrap_or(waits));
            return;
        };
        let target = open.document.last_good().map_or(0, |scene| open.view.mode.samples(scene.render.samples));
        let samples = status.samples.floor();
        ui.monospace(format!("{width}×{height}"));
        ui.separator();
        if status.samples > 0.0 {
            ui.monospace(format!("{samples:>4} of {target} samples"));
            if !status.resting && status.samples_per_second > 0.0 {
                ui.weak(format!("{:.2}/s", status.samples_per_second));
            }
        } else {
            ui.monospace("refining");
        }
        ui.separator();
        ui.label(format!("{} ({})", status.backend, status.adapter));
        if status.compiling {
            ui.separator();
            ui.add(egui::Spinner::new().size(12.0));
            ui.label("compiling");
        }
        if let Some(error) = status.error {
            ui.colored_label(ui.visuals().error_fg_color, error);
        } else if let Some(notice) = status.notice {
            ui.separator();
            ui.add(egui::Label::new(RichText::new(notice).color(ui.visuals().warn_fg_color)).truncate());
        }
        if open.view.is_camera_modified() {
            ui.separator();
            ui.weak("Free view (not saved)")
                .on_hover_text("Home returns to the scene's camera; Ctrl+K saves this view to it.");
        }
    }
}
