//! Plots of frame time and sample rate.

use crate::window::app::App;
use egui::Ui;
use egui_plot::{Line, Plot, PlotPoints};

impl App {
    pub(crate) fn plots_panel(&mut self, ui: &mut Ui) {
        egui::Panel::bottom("plots").resizable(true).default_size(130.0).show(ui, |ui| {
            let plot = |ui: &mut Ui, name: &str, unit: &str, width: f32, value: fn(&(f64, f64)) -> f64| {
                ui.vertical(|ui| {
                    let last = self.performance.history.back().map_or(0.0, value);
                    ui.label(format!("{name}: {last:.2} {unit}"));
                    let points: PlotPoints =
                        self.performance.history.iter().enumerate().map(|(k, both)| [k as f64, value(both)]).collect();
                    Plot::new(name)
                        .width(width)
                        .include_y(0.0)
                        .show_x(false)
                        .show_axes([false, true])
                        .allow_drag(false)
                        .allow_zoom(false)
                        .allow_scroll(false)
                        .show(ui, |plot| plot.line(Line::new(name, points)));
                });
            };
            ui.horizontal_top(|ui| {
                let width = 0.5 * ui.available_width() - 12.0;
                plot(ui, "frame time", "ms", width, |both| both.0);
                plot(ui, "sample rate", "/s", width, |both| both.1);
            });
        });
    }
}
