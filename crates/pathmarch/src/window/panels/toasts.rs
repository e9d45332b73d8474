//! Toasts at the bottom of the window, where they cover no title.

use crate::window::app::App;
use egui::{Color32, Context, RichText};
use std::time::Instant;

impl App {
    pub(crate) fn show_toasts(&mut self, ctx: &Context) {
        let now = Instant::now();
        self.toasts.retain(|toast| toast.until > now);
        let Some(next) = self.toasts.iter().map(|toast| toast.until).min() else { return };
        ctx.request_repaint_after(next - now);
        let mut closed = None;
        egui::Area::new(egui::Id::unique("messages"))
            .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -40.0])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                for (index, toast) in self.toasts.iter().enumerate() {
                    let fill = if toast.is_error { Color32::from_rgb(110, 28, 28) } else { Color32::from_gray(45) };
                    egui::Frame::popup(ui.style()).fill(fill).show(ui, |ui| {
                        ui.set_max_width(640.0);
                        ui.horizontal(|ui| {
                            ui.add(egui::Label::new(RichText::new(&toast.text).color(Color32::WHITE)).wrap());
                            if ui.small_button("×").on_hover_text("Close this message.").clicked() {
                                closed = Some(index);
                            }
                        });
                    });
                }
            });
        if let Some(index) = closed {
            self.toasts.remove(index);
        }
    }
}
