//! Controls of viewport, render settings and sky.

use crate::window::app::App;
use crate::window::exposure::{BARS, Histogram};
use crate::window::open_scene::view_state::Resolution;
use egui::{Color32, ComboBox, Pos2, Rect, Sense, Slider, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_scene::document::ItemKind;
use pathmarch_render::reconstruct::{Buffer, ReconstructOptions};
use pathmarch_render::{Mode, PreviewStep};

/// Switches of the stages of reconstruction, and the buffer that is shown.
fn reconstruction_stages(ui: &mut Ui, options: &mut ReconstructOptions) {
    let ReconstructOptions {
        reprojection,
        firefly_filter,
        spatial_filter,
        emitter_edges,
        texture_filter,
        antialiasing,
        upscaling,
        buffer,
    } = options;
    for (stage, name, doc) in [
        (reprojection, "reprojection", "Continues the mean of each point of the last picture."),
        (
            firefly_filter,
            "firefly filter",
            "Spreads the energy of samples that are far brighter than their neighbours.",
        ),
        (spatial_filter, "spatial filter", "Averages neighbours on the same surface."),
        (emitter_edges, "edges of emitters", "Finds the edges of lamps by further camera rays."),
        (texture_filter, "texture filter", "Averages textures over the pixels."),
        (antialiasing, "anti-aliasing", "Averages the picture with the last one."),
        (upscaling, "upscaling", "Shows the moving picture at up to twice the resolution of its samples."),
    ] {
        ui.checkbox(stage, name).on_hover_text(doc);
    }
    ui.horizontal(|ui| {
        let label = ui.label("shown buffer");
        ComboBox::from_id_salt("buffer")
            .selected_text(buffer.name())
            .show_ui(ui, |ui| {
                for choice in Buffer::ALL {
                    ui.selectable_value(buffer, choice, choice.name());
                }
            })
            .response
            .labelled_by(label.id);
    });
}

/// Draws the bars of red, green and blue above each other.
fn draw_histogram(ui: &mut Ui, histogram: &Histogram) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(ui.available_width().min(256.0), 64.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, Color32::from_gray(12));
    let width = rect.width() / BARS as f32;
    let colours = [[220, 60, 60], [60, 190, 70], [80, 110, 240]];
    for (bars, [r, g, b]) in histogram.bars.iter().zip(colours) {
        // Light adds up: where all three are, it is grey.
        let colour = Color32::from_rgb_additive(r, g, b);
        for (index, share) in bars.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let left = rect.min.x + index as f32 * width;
            let top = rect.max.y - share * rect.height();
            let bar = Rect::from_min_max(Pos2::new(left, top), Pos2::new(left + width, rect.max.y));
            ui.painter().rect_filled(bar, 0.0, colour);
        }
    }
    ui.painter().rect_stroke(rect, 2.0, Stroke::new(1.0, Color32::from_gray(90)), egui::StrokeKind::Inside);
    let words = format!("{:.1} % of the pixels are overexposed.", 100.0 * histogram.clipped);
    ui.weak(words);
}

impl App {
    /// Histogram of the displayed picture, which costs nothing while it is collapsed.
    pub(super) fn histogram_of_picture(&mut self, ui: &mut Ui) {
        let shown = egui::CollapsingHeader::new("Histogram").show(ui, |ui| {
            if let Some(picture) = self.live.picture()
                && self.histogram.as_ref().is_none_or(|known| known.serial != picture.serial)
            {
                self.histogram = Some(Histogram::new(picture.serial, &picture.codes));
            }
            if let Some(histogram) = &self.histogram {
                draw_histogram(ui, histogram);
            }
        });
        if shown.fully_closed() {
            self.histogram = None;
        }
    }

    /// Mode and resolution of the viewport, render settings, background.
    pub(super) fn picture_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        ui.heading("Viewport");
        egui::Grid::new("picture").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
            let label = ui.label("mode").on_hover_text("Path-traced light, quick preview, or a data layer.");
            ComboBox::from_id_salt("mode")
                .selected_text(open.view.mode.name())
                .show_ui(ui, |ui| {
                    for mode in Mode::ALL {
                        ui.selectable_value(&mut open.view.mode, mode, mode.name()).on_hover_text(mode.doc());
                    }
                })
                .response
                .labelled_by(label.id);
            ui.end_row();
            let label =
                ui.label("resolution").on_hover_text("Resolution of the viewport. Renders have the scene's size.");
            ComboBox::from_id_salt("resolution")
                .selected_text(open.view.resolution.name())
                .show_ui(ui, |ui| {
                    for resolution in Resolution::ALL {
                        ui.selectable_value(&mut open.view.resolution, resolution, resolution.name());
                    }
                })
                .response
                .labelled_by(label.id);
            ui.end_row();
            let label = ui
                .label("target frame rate")
                .on_hover_text("While the view moves, the resolution adapts to this rate.");
            let rate = Slider::new(&mut self.preferences.frame_rate, 5.0..=120.0).suffix(" /s").integer();
            ui.add(rate).labelled_by(label.id);
            ui.end_row();
            let label = ui
                .label("reconstruction")
                .on_hover_text("Denoises the moving view. A still view converges to the unaltered picture.");
            ui.checkbox(&mut self.preferences.reconstruct, "").labelled_by(label.id);
            ui.end_row();
        });
        if self.preferences.reconstruct && open.view.mode == Mode::Path {
            egui::CollapsingHeader::new("Stages of reconstruction")
                .show(ui, |ui| reconstruction_stages(ui, &mut self.reconstruct_options));
        }
        if open.view.mode == Mode::Preview {
            egui::CollapsingHeader::new("Steps of the preview").show(ui, |ui| {
                for step in PreviewStep::ALL {
                    let mut is_on = open.view.preview_steps.has(step);
                    if ui.checkbox(&mut is_on, step.name()).on_hover_text(step.doc()).changed() {
                        open.view.preview_steps.set(step, is_on);
                    }
                }
            });
        }
        for (kind, none) in [(ItemKind::Render, "render"), (ItemKind::Sky, "sky")] {
            let Some(open) = &self.open else { return };
            let item = open.document.outline().iter().find(|item| item.kind == kind).cloned();
            match item {
                Some(item) => {
                    let title = if kind == ItemKind::Render { "Render settings" } else { "Background" };
                    egui::CollapsingHeader::new(title).default_open(kind == ItemKind::Render).show(ui, |ui| {
                        self.controls_of(ui, &item.path);
                    });
                }
                None => self.missing(ui, none),
            }
        }
    }

    /// Offers to add a node that the scene lacks.
    fn missing(&mut self, ui: &mut Ui, word: &str) {
        let Some(open) = &self.open else { return };
        let additions = open.document.additions(None);
        let group = if word == "render" { "Render" } else { "Sky" };
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            ui.weak(if word == "render" { "Samples, bounces, size:" } else { "Background:" });
            for addition in additions.iter().filter(|addition| addition.group.name() == group) {
                if ui.button(format!("Add {}", addition.name)).on_hover_text(&*addition.doc).clicked() {
                    chosen = Some(addition.clone());
                }
            }
        });
        if let Some(addition) = chosen {
            let path = self.edit(|open| open.document.add(None, &addition));
            self.select(path);
        }
    }
}
