//! Modal dialogs: unsaved work, file conflict, recovered work, render settings.

use crate::window::app::App;
use crate::window::app::dialog::{Answer, Dialog, RenderDialog};
use crate::window::app::requests::PendingAction;
use crate::window::files::recovery::RecoveredWork;
use crate::window::files::relative_time::relative_time;
use crate::window::open_scene::playback::LAST_FRAME;
use egui::{Context, Frame, Id, Key, Modal, RichText, Ui};
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::settings::{self, SettingKind};
use std::time::SystemTime;

impl App {
    pub(crate) fn show_dialog(&mut self, ctx: &Context) {
        let Some(dialog) = &mut self.dialog else { return };
        if self.file_dialog.is_some() {
            return;
        }
        let mut answer = Answer::None;
        let frame = Frame::popup(&ctx.global_style()).inner_margin(16.0);
        let modal = Modal::new(Id::unique("dialog")).frame(frame).show(ctx, |ui| {
            ui.set_max_width(520.0);
            match dialog {
                Dialog::Unsaved(after) => unsaved(ui, after, &mut answer),
                Dialog::Conflict => {
                    let theirs = self.open.as_ref().and_then(|open| open.conflict.as_ref());
                    conflict(ui, theirs.and_then(|theirs| theirs.as_ref().err()), &mut answer);
                }
                Dialog::Recovered(left) => recovered(ui, left, &mut answer),
                Dialog::Render(render) => render_settings(ui, render, self.typing, &mut answer),
                Dialog::Busy => busy(ui, &mut answer),
            }
        });
        if matches!(answer, Answer::None) && modal.should_close() && !matches!(dialog, Dialog::Conflict) {
            answer = Answer::Close;
        }
        self.answer_dialog(answer);
    }
}

fn unsaved(ui: &mut Ui, after: &PendingAction, answer: &mut Answer) {
    ui.heading("Save changes?");
    ui.label("The scene has unsaved changes.");
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button(RichText::new("Save").strong()).clicked() {
            *answer = Answer::Save(after.clone());
        }
        if ui.button("Discard").clicked() {
            *answer = Answer::Discard(after.clone());
        }
        if ui.button("Cancel").clicked() {
            *answer = Answer::Close;
        }
    });
}

fn busy(ui: &mut Ui, answer: &mut Answer) {
    ui.heading("A render is still running");
    ui.label("Quitting cancels it; no file is written.");
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button(RichText::new("Keep rendering").strong()).clicked() {
            *answer = Answer::Close;
        }
        if ui.button("Cancel render and quit").clicked() {
            *answer = Answer::CancelRendersAndQuit;
        }
    });
}

/// Asks which of two versions to keep. `unreadable`: the reason if the version on disk cannot be read.
fn conflict(ui: &mut Ui, unreadable: Option<&String>, answer: &mut Answer) {
    match unreadable {
        None => {
            ui.heading("The file changed on disk");
            ui.label(
                "The file changed on disk while you had unsaved changes. Nothing is lost. Which version do you want?",
            );
        }
        Some(why) => {
            ui.heading("The file can no longer be read");
            ui.label(format!("Reason: {why}. Your unsaved changes are still open."));
        }
    }
    ui.add_space(8.0);
    ui.horizontal_wrapped(|ui| {
        if ui.button("Keep mine").on_hover_text("The file is unchanged until you save.").clicked() {
            *answer = Answer::KeepMine;
        }
        if unreadable.is_none()
            && ui.button("Reload from disk").on_hover_text("Undo brings your version back.").clicked()
        {
            *answer = Answer::TakeTheirs;
        }
        if ui.button("Save mine as…").on_hover_text("Save your version to another file.").clicked() {
            *answer = Answer::SaveMineAs;
        }
    });
}

fn recovered(ui: &mut Ui, left: &[RecoveredWork], answer: &mut Answer) {
    ui.heading("Unsaved work found");
    ui.label("The program ended without saving it.");
    ui.add_space(6.0);
    for (index, one) in left.iter().enumerate() {
        ui.horizontal(|ui| {
            let name = one.scene_path.as_ref().map_or("an unsaved scene".to_owned(), |path| path.display().to_string());
            ui.label(format!("{name}, {}", relative_time(one.saved_at, SystemTime::now())));
            if ui.button(RichText::new("Open").strong()).clicked() {
                *answer = Answer::Recover(index);
            }
            if ui.button("Discard").clicked() {
                *answer = Answer::DiscardRecovered(index);
            }
        });
    }
    ui.add_space(6.0);
    if ui.button("Decide later").clicked() {
        *answer = Answer::AskLater;
    }
}

/// Row of a grid for a render setting of whole numbers; label, range and help are those of the table of settings.
fn setting_row(ui: &mut Ui, name: &str, values: &mut [&mut u32]) {
    let Some(setting) = settings::RENDER.iter().find(|setting| setting.name == name) else { return };
    let (SettingKind::Whole { range, .. } | SettingKind::Size { range, .. }) = setting.kind else { return };
    let label = ui.label(setting.label).on_hover_text(setting.doc);
    ui.horizontal(|ui| {
        for value in values {
            ui.add(egui::DragValue::new(*value).range(range.0..=range.1)).labelled_by(label.id);
        }
    });
    ui.end_row();
}

/// `typing`: a text field had the focus before this frame, and Enter belongs to it.
fn render_settings(ui: &mut Ui, render: &mut RenderDialog, typing: bool, answer: &mut Answer) {
    ui.heading("Render to file");
    ui.add_space(8.0);
    egui::Grid::new("render").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        let label = ui.label("file");
        ui.horizontal(|ui| {
            ui.add(egui::TextEdit::singleline(&mut render.output).desired_width(300.0)).labelled_by(label.id);
            if ui.button("Choose…").on_hover_text("Choose directory and file name.").clicked() {
                *answer = Answer::ChooseOutput;
            }
        });
        ui.end_row();
        let [width, height] = &mut render.size;
        setting_row(ui, "size", &mut [width, height]);
        setting_row(ui, "samples", &mut [&mut render.samples]);
        setting_row(ui, "bounces", &mut [&mut render.bounces]);
        if render.may_choose_viewpoint {
            let label = ui.label("camera");
            ui.horizontal(|ui| {
                ui.radio_value(&mut render.own_viewpoint, true, "Free view").labelled_by(label.id);
                ui.radio_value(&mut render.own_viewpoint, false, "Scene camera").labelled_by(label.id);
            });
            ui.end_row();
        }
        if let Some([mut first, mut last]) = render.frames {
            let label = ui.label("frames");
            ui.horizontal(|ui| {
                let mut all = render.all_frames;
                if ui.checkbox(&mut all, "from").labelled_by(label.id).changed() {
                    render.render_frames(all);
                }
                ui.add_enabled_ui(all, |ui| {
                    ui.add(egui::DragValue::new(&mut first).range(0..=last)).labelled_by(label.id);
                    ui.label("to");
                    ui.add(egui::DragValue::new(&mut last).range(first..=LAST_FRAME)).labelled_by(label.id);
                    ui.checkbox(&mut render.skip_existing, "skip existing");
                });
            });
            render.frames = Some([first, last]);
            ui.end_row();
        }
        if matches!(render.format(), Ok(ImageFormat::Exr)) {
            let label = ui.label("layers");
            ui.checkbox(&mut render.layers, "albedo, normal, depth, ids").labelled_by(label.id);
            ui.end_row();
        }
    });
    let problem = render.problem();
    if let Some(why) = &problem {
        ui.colored_label(ui.visuals().error_fg_color, why);
    }
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let start = ui.add_enabled(problem.is_none(), egui::Button::new(RichText::new("Start").strong()));
        // Enter starts, too, unless it presses another button.
        let is_taken = typing || ui.memory(|memory| memory.focused()).is_some();
        let enter = !is_taken && ui.input(|input| input.key_pressed(Key::Enter));
        if start.clicked() || enter && problem.is_none() {
            *answer = Answer::StartRender;
        }
        if ui.button("Cancel").clicked() {
            *answer = Answer::Close;
        }
    });
}
