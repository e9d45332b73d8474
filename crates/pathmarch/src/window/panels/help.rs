//! Help window: mouse, keyboard and all actions.

use crate::window::app::App;
use crate::window::app::actions::{ACTIONS, Menu, POINTER};
use egui::Context;

impl App {
    pub(crate) fn help_window(&mut self, ctx: &Context) {
        let mut is_open = self.help;
        let room = ctx.content_rect();
        let window = egui::Window::new("Keyboard and mouse").open(&mut is_open).collapsible(false).scroll(true);
        let window = window.default_width(660.0).default_height((room.height() - 120.0).max(200.0));
        window.default_pos(room.center() - egui::vec2(340.0, 0.5 * room.height() - 40.0)).show(ctx, |ui| {
            egui::Grid::new("pointer").num_columns(2).striped(true).spacing([18.0, 4.0]).show(ui, |ui| {
                for (what, does) in POINTER {
                    ui.strong(*what);
                    ui.label(*does);
                    ui.end_row();
                }
            });
            for menu in Menu::ALL {
                ui.add_space(6.0);
                ui.heading(menu.name());
                egui::Grid::new(menu.name()).num_columns(3).striped(true).spacing([18.0, 4.0]).show(ui, |ui| {
                    for entry in ACTIONS.iter().filter(|entry| entry.menu == menu) {
                        let shortcut = entry.shortcut.map(|shortcut| ui.ctx().format_shortcut(&shortcut));
                        ui.strong(shortcut.unwrap_or_default());
                        ui.label(entry.name);
                        ui.weak(entry.doc);
                        ui.end_row();
                    }
                });
            }
        });
        self.help = is_open;
    }
}
