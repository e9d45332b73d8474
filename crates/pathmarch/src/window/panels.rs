//! Menus, status, source, mistakes, plots, help: everything around picture, tree and controls.

use super::actions::{ACTIONS, Action, Entry, Menu, POINTER};
use super::app::App;
use super::files::After;
use super::open::Handles;
use egui::{Color32, Context, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};
use indicatif::HumanDuration;
use pathmarch_render::Mode;
use pathmarch_render::live::Shown;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Typing after such a pause is a new step of undo, seconds.
const TYPING_PAUSE: f64 = 1.0;
/// Pictures that the plots remember.
const REMEMBERED: usize = 240;

/// What the plots show.
#[derive(Default)]
pub(super) struct Plots {
    /// Milliseconds since the picture before, and samples of the whole picture each second.
    history: VecDeque<(f64, f64)>,
    last: Option<Instant>,
}

impl Plots {
    pub(super) fn picture(&mut self, shown: &Shown, samples_per_second: f64) {
        if let Some(last) = self.last {
            let milliseconds = shown.at.duration_since(last).as_secs_f64() * 1e3;
            self.history.push_back((milliseconds, samples_per_second));
            while self.history.len() > REMEMBERED {
                self.history.pop_front();
            }
        }
        self.last = Some(shown.at);
    }
}

impl App {
    pub(super) fn menu_bar(&mut self, ui: &mut Ui) {
        let mut asked = None;
        egui::Panel::top("menus").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                for menu in Menu::ALL {
                    ui.menu_button(menu.name(), |ui| {
                        for entry in ACTIONS.iter().filter(|entry| entry.menu == menu) {
                            if self.menu_entry(ui, entry) {
                                asked = Some(entry.action);
                            }
                            if entry.action == Action::Open {
                                self.recent_menu(ui);
                            }
                        }
                    });
                }
                if self.open.is_some() {
                    ui.separator();
                    asked = asked.or(self.tools(ui));
                }
            });
        });
        if let Some(action) = asked {
            let ctx = ui.ctx().clone();
            self.act(&ctx, action);
        }
    }

    /// An entry of a menu; whether it was chosen.
    fn menu_entry(&self, ui: &mut Ui, entry: &Entry) -> bool {
        let document = self.open.as_ref().map(|open| &open.document);
        let mut name = entry.name.to_owned();
        let mut enabled = document.is_some() || !entry.needs_scene;
        let has_selection = self.open.as_ref().is_some_and(|open| open.view.selection.is_some());
        match entry.action {
            Action::Undo | Action::Redo => {
                let label = document.and_then(|document| {
                    if entry.action == Action::Undo { document.can_undo() } else { document.can_redo() }
                });
                enabled = label.is_some();
                name = label.map_or(name, |label| format!("{}: {label}", entry.name));
            }
            Action::Duplicate | Action::Delete | Action::Group | Action::Ungroup => enabled &= has_selection,
            _ => {}
        }
        let mut button = egui::Button::new(name);
        if let Some(shortcut) = &entry.shortcut {
            button = button.shortcut_text(ui.ctx().format_shortcut(shortcut));
        }
        let chosen = ui.add_enabled(enabled, button).on_hover_text(entry.doc).clicked();
        if chosen {
            ui.close();
        }
        chosen
    }

    fn recent_menu(&mut self, ui: &mut Ui) {
        let recent = self.preferences.recent.clone();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Open recent", |ui| {
                for path in recent {
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                        self.unless_unsaved(After::OpenFile(path));
                        ui.close();
                    }
                }
            });
        });
    }

    /// Buttons for what is done all the time.
    fn tools(&mut self, ui: &mut Ui) -> Option<Action> {
        let open = self.open.as_mut()?;
        let mut asked = None;
        for (handles, name, action) in [
            (Handles::Move, "Move", Action::GizmoMove),
            (Handles::Turn, "Turn", Action::GizmoTurn),
            (Handles::Scale, "Scale", Action::GizmoScale),
        ] {
            let doc = ACTIONS.iter().find(|entry| entry.action == action).map_or("", |entry| entry.doc);
            if ui.selectable_label(open.view.handles == handles, name).on_hover_text(doc).clicked() {
                asked = Some(action);
            }
        }
        ui.separator();
        let previews = open.view.mode == Mode::Preview;
        if ui.selectable_label(previews, "Preview").on_hover_text(Mode::Preview.doc()).clicked() {
            asked = Some(Action::Preview);
        }
        let compares = open.view.kept.as_ref().is_some_and(|kept| kept.shown);
        if ui
            .selectable_label(compares, "Compare")
            .on_hover_text("Keep this picture and compare later ones with it.")
            .clicked()
        {
            asked = Some(Action::Compare);
        }
        ui.separator();
        let unsaved = open.has_unsaved_work();
        if ui.add_enabled(unsaved, egui::Button::new("Save")).on_hover_text("Write the scene to its file.").clicked() {
            asked = Some(Action::Save);
        }
        if ui.button("Render…").on_hover_text("Render with all samples to a file, in the background.").clicked() {
            asked = Some(Action::Render);
        }
        asked
    }

    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        let mut cancelled = None;
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                for (index, export) in self.exports.iter().enumerate() {
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
                    if ui.small_button("Stop and keep").on_hover_text("Write what is done so far.").clicked() {
                        export.stop_and_keep();
                    }
                    ui.separator();
                }
                self.renderer_status(ui);
            });
        });
        if let Some(export) = cancelled.and_then(|index| self.exports.get(index)) {
            export.cancel();
        }
    }

    fn renderer_status(&self, ui: &mut Ui) {
        let Some(open) = &self.open else {
            ui.weak("Choose a scene, or drag a .kdl file into the window. F1 shows keys and mouse.");
            return;
        };
        let status = self.live.status();
        let Some((_, _, [width, height])) = &open.view.picture else {
            ui.label(status.error.as_deref().unwrap_or("The first picture is on its way."));
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
            ui.monospace("sharpening");
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
        if open.view.has_moved_away() {
            ui.separator();
            ui.weak("own viewpoint")
                .on_hover_text("Home goes back to the scene's camera, Ctrl+K writes this one to it.");
        }
    }

    /// What is wrong with the text, line by line.
    pub(super) fn mistakes_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let error = match open.document.scene() {
            Err(error) => error,
            Ok(scene) if !scene.warnings.is_empty() && self.preferences.show_source => {
                let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
                egui::Panel::bottom("warnings").show(ui, |ui| {
                    for warning in warnings {
                        ui.colored_label(ui.visuals().warn_fg_color, format!("warning: {warning}"));
                    }
                });
                return;
            }
            Ok(_) => return,
        };
        let text = open.document.text();
        let mut lines: Vec<(usize, String, Option<String>)> = Vec::new();
        for mistake in error.mistakes() {
            let words = if mistake.label.is_empty() {
                mistake.message.clone()
            } else {
                format!("{} ({})", mistake.message, mistake.label)
            };
            // A place in a file that the scene includes is told in words: the text here is another.
            let source = &mistake.source_code;
            if source.name() == open.document.name() {
                lines.push((mistake.span.offset(), words, mistake.help.clone()));
            } else {
                let before = source.inner().get(..mistake.span.offset()).unwrap_or_default();
                let line = 1 + before.matches('\n').count();
                lines.push((0, format!("in {}, line {line}: {words}", source.name()), mistake.help.clone()));
            }
        }
        if lines.is_empty() {
            lines.push((0, error.to_string(), None));
        }
        egui::Panel::bottom("mistakes").resizable(true).default_size(130.0).max_size(360.0).show(ui, |ui| {
            let title = if lines.len() == 1 { "1 mistake".to_owned() } else { format!("{} mistakes", lines.len()) };
            ui.horizontal(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, RichText::new(title).strong());
                ui.weak("The picture is of the text as it was before them.");
            });
            egui::ScrollArea::vertical().show(ui, |ui| {
                for (offset, message, help) in &lines {
                    ui.horizontal_wrapped(|ui| {
                        let before = text.get(..*offset).unwrap_or(text);
                        let line = 1 + before.matches('\n').count();
                        let column = 1 + before.rsplit('\n').next().map_or(0, |line| line.chars().count());
                        ui.strong(format!("line {line}, column {column}"));
                        ui.label(message);
                        if let Some(help) = help {
                            ui.weak(help);
                        }
                    });
                    let shown = line_at(text, *offset);
                    ui.indent(("excerpt", offset), |ui| {
                        ui.monospace(RichText::new(shown).color(ui.visuals().warn_fg_color));
                    });
                }
            });
        });
    }

    /// The text itself.
    pub(super) fn source_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let mut text = open.document.text().to_owned();
        let line = open.view.selection.as_ref().and_then(|path| open.document.line_of(path));
        let mut changed = false;
        egui::Panel::bottom("source").resizable(true).default_size(220.0).max_size(600.0).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.strong("Source");
                if let Some(line) = line {
                    ui.weak(format!("the selection is in line {line}"));
                }
            });
            egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    let count = text.split('\n').count();
                    let numbers: Vec<String> = (1..=count).map(|line| format!("{line:>4}")).collect();
                    ui.add(egui::Label::new(RichText::new(numbers.join("\n")).monospace().weak()).selectable(false));
                    // Lines stay whole, so that they are beside their numbers.
                    let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| {
                        let font = egui::TextStyle::Monospace.resolve(ui.style());
                        let colour = ui.visuals().widgets.inactive.text_color();
                        ui.fonts_mut(|fonts| fonts.layout_no_wrap(text.as_str().to_owned(), font, colour))
                    };
                    let edit = egui::TextEdit::multiline(&mut text).code_editor().layouter(&mut layout);
                    let edit = edit.frame(egui::Frame::NONE);
                    let response = ui.add(edit.desired_width(f32::INFINITY).margin(egui::Margin::ZERO));
                    response
                        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::MultilineTextInput, true, "Scene text"));
                    changed = response.changed();
                });
            });
        });
        if changed {
            let now = ui.input(|input| input.time);
            if now - self.typed_at > TYPING_PAUSE {
                self.gesture += 1;
            }
            self.typed_at = now;
            let gesture = self.gesture;
            self.edit(|open| {
                open.document.replace_text(text, "Typing", Some(gesture));
                Ok(())
            });
        }
    }

    pub(super) fn plots_panel(&mut self, ui: &mut Ui) {
        egui::Panel::bottom("plots").resizable(true).default_size(130.0).show(ui, |ui| {
            let plot = |ui: &mut Ui, name: &str, unit: &str, width: f32, value: fn(&(f64, f64)) -> f64| {
                ui.vertical(|ui| {
                    let last = self.plots.history.back().map_or(0.0, value);
                    ui.label(format!("{name}: {last:.2} {unit}"));
                    let points: PlotPoints =
                        self.plots.history.iter().enumerate().map(|(k, both)| [k as f64, value(both)]).collect();
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
                plot(ui, "time between pictures", "ms", width, |both| both.0);
                plot(ui, "samples of the whole picture", "/s", width, |both| both.1);
            });
        });
    }

    pub(super) fn help_window(&mut self, ctx: &Context) {
        let mut is_open = self.help;
        let room = ctx.content_rect();
        let window = egui::Window::new("Keys and mouse").open(&mut is_open).collapsible(false).vscroll(true);
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

    pub(super) fn show_toasts(&mut self, ctx: &Context) {
        let now = Instant::now();
        self.toasts.retain(|toast| toast.until > now);
        let Some(next) = self.toasts.iter().map(|toast| toast.until).min() else { return };
        ctx.request_repaint_after(next - now);
        let mut closed = None;
        egui::Area::new(egui::Id::unique("messages"))
            .anchor(egui::Align2::CENTER_TOP, [0.0, 34.0])
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

/// The line of a text that holds a byte.
fn line_at(text: &str, offset: usize) -> &str {
    let offset = (0..=offset.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |at| offset + at);
    text[start..end].trim()
}
