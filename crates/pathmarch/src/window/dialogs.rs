//! Questions that must be answered before anything else: unsaved work, a file changed by others, what a crash left, and
//! the settings of a final render.

use super::age::age;
use super::app::App;
use super::chooser::Chooser;
use super::export::{self, Export, Sequence, Task};
use super::files::{After, For, purpose, reason};
use super::open::Open;
use super::recovery::Recovered;
use super::timeline::LAST_FRAME;
use crate::frames::{self, Frames};
use crate::picture::Rendered;
use egui::{Context, Id, Modal, RichText, Ui};
use pathmarch_render::Settings;
use pathmarch_render::aov::Layer;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::read_text;
use pathmarch_render::pathmarch_scene::settings;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A question.
pub(super) enum Dialog {
    /// Unsaved work stands in the way.
    Unsaved(After),
    /// The file was changed by someone else while there were unsaved changes here.
    Conflict,
    /// What programs that ended without saving have left.
    Recovered(Vec<Recovered>),
    /// A final render is to be started.
    Render(RenderDialog),
    /// Renders are on their way, and the program is to end.
    Busy,
}

/// Stands in the name of a file for the digits of a frame's number.
const DIGITS: &str = "-####";

/// Settings of a final render.
pub(super) struct RenderDialog {
    pub(super) output: String,
    size: [u32; 2],
    samples: u32,
    bounces: u32,
    layers: bool,
    /// From where one looks now, not from where the scene's camera stands.
    own_viewpoint: bool,
    may_choose_viewpoint: bool,
    /// First and last frame, where something moves, and whether these are rendered rather than the frame that is shown.
    frames: Option<[u32; 2]>,
    all_frames: bool,
    skip_existing: bool,
}

impl RenderDialog {
    pub(super) fn new(open: &Open) -> Option<Self> {
        let scene = open.document.last_good()?;
        let settings = Settings::of(scene);
        let path = open.path.clone().unwrap_or_else(|| PathBuf::from("picture.kdl"));
        let output = std::path::absolute(path.with_extension("png")).unwrap_or(path);
        Some(Self {
            output: output.display().to_string(),
            size: settings.size,
            samples: open.view.mode.samples(settings.samples),
            bounces: settings.bounces,
            layers: false,
            own_viewpoint: open.view.has_moved_away(),
            may_choose_viewpoint: open.view.has_moved_away(),
            frames: scene.animated.then_some([0, open.timeline.last]),
            all_frames: false,
            skip_existing: false,
        })
    }

    /// As [`Self::new`], for all frames.
    pub(super) fn of_frames(open: &Open) -> Option<Self> {
        let mut dialog = Self::new(open)?;
        dialog.render_frames(true);
        Some(dialog)
    }

    /// Renders frames, or the picture that is shown; the name of the file follows.
    fn render_frames(&mut self, all: bool) {
        self.all_frames = all;
        let path = Path::new(&self.output);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let named = match (all, stem.strip_suffix(DIGITS)) {
            (true, None) if !stem.contains('#') => format!("{stem}{DIGITS}"),
            (false, Some(without)) => without.to_owned(),
            _ => return,
        };
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        self.output = path.with_file_name(format!("{named}.{extension}")).display().to_string();
    }

    /// The frames to render, where it is not one picture.
    fn sequence(&self) -> Option<Sequence> {
        let [first, last] = self.frames.filter(|_| self.all_frames)?;
        Some(Sequence { frames: Frames::from_to(first, last), skip_existing: self.skip_existing })
    }

    /// What is wrong with it, in words.
    fn problem(&self) -> Option<String> {
        let Some(sequence) = self.sequence() else { return self.format().err() };
        self.format().err().or_else(|| frames::check_pattern(Path::new(&self.output), sequence.frames).err())
    }

    fn format(&self) -> Result<ImageFormat, String> {
        ImageFormat::from_path(Path::new(&self.output)).map_err(|error| error.to_string())
    }
}

/// What was answered.
enum Answer {
    None,
    Close,
    Save(After),
    Drop(After),
    KeepMine,
    TakeTheirs,
    SaveMineElsewhere,
    Recover(usize),
    Forget(usize),
    Later,
    Start,
    Choose,
    /// Without the renders.
    Leave,
}

impl App {
    pub(super) fn dialogs(&mut self, ctx: &Context) {
        let Some(dialog) = &mut self.dialog else { return };
        if self.chooser.is_some() {
            return;
        }
        let mut answer = Answer::None;
        let modal = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
            ui.set_max_width(520.0);
            match dialog {
                Dialog::Unsaved(after) => unsaved(ui, after, &mut answer),
                Dialog::Conflict => {
                    let theirs = self.open.as_ref().and_then(|open| open.conflict.as_ref());
                    conflict(ui, theirs.and_then(|theirs| theirs.as_ref().err()), &mut answer);
                }
                Dialog::Recovered(left) => recovered(ui, left, &mut answer),
                Dialog::Render(render) => render_settings(ui, render, &mut answer),
                Dialog::Busy => busy(ui, &mut answer),
            }
        });
        if matches!(answer, Answer::None) && modal.should_close() && !matches!(dialog, Dialog::Conflict) {
            answer = Answer::Close;
        }
        self.answer_dialog(answer);
    }

    fn answer_dialog(&mut self, answer: Answer) {
        match answer {
            Answer::None => {}
            Answer::Close | Answer::Later => self.dialog = None,
            Answer::Save(after) => {
                self.dialog = None;
                if self.save(Some(after.clone())) {
                    self.proceed(after);
                }
            }
            Answer::Drop(after) => {
                self.dialog = None;
                self.proceed(after);
            }
            Answer::KeepMine => {
                self.dialog = None;
                if let Some(open) = &mut self.open {
                    open.keep_mine();
                }
                // What is kept for after a crash is based on the other version from now on.
                self.changed();
                self.say("Your version stays; the file keeps the other one until you save.");
            }
            Answer::TakeTheirs => {
                self.dialog = None;
                if let Some(open) = &mut self.open
                    && let Some(Ok(text)) = open.conflict.take()
                {
                    open.take_from_disk(text);
                    self.changed();
                    self.say("This is what the file says now; undo brings your version back.");
                }
            }
            Answer::SaveMineElsewhere => {
                self.dialog = None;
                let purpose = purpose("Save your version as", &["kdl"]);
                let name = self.open.as_ref().map_or_else(String::new, Open::name);
                let name = format!("{}-mine.kdl", name.trim_end_matches(".kdl"));
                self.chooser = Some((self.with_places(Chooser::save(&self.directory(), &name, purpose)), For::SaveAs));
            }
            Answer::Recover(index) | Answer::Forget(index) => {
                let Some(Dialog::Recovered(left)) = &mut self.dialog else { return };
                let one = left.remove(index);
                let others = !left.is_empty();
                if matches!(answer, Answer::Recover(_)) && one.text.is_ok() {
                    // Another one would take the place of this one, which is not saved.
                    self.dialog = None;
                    self.recover(one);
                    if others {
                        self.say("What else was found is offered at the next start.");
                    }
                    return;
                }
                if !others {
                    self.dialog = None;
                }
                if matches!(answer, Answer::Recover(_)) {
                    self.recover(one);
                } else if let Err(why) = one.discard() {
                    self.complain(&why);
                }
            }
            Answer::Leave => {
                self.dialog = None;
                self.exports.clear();
                self.ask_to_leave();
            }
            Answer::Start => self.start_render(),
            Answer::Choose => {
                let Some(Dialog::Render(render)) = &self.dialog else { return };
                let purpose = purpose("Render to", &["png", "exr", "jpg"]);
                let path = PathBuf::from(&render.output);
                let folder = path.parent().filter(|folder| folder.is_dir()).map(Path::to_owned);
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let folder = folder.unwrap_or_else(|| self.directory());
                self.chooser = Some((self.with_places(Chooser::save(&folder, &name, purpose)), For::Render));
            }
        }
    }

    /// Opens what a program that ended without saving has left, as unsaved changes of its file. Asks where the file is no
    /// longer the version that the work is based on.
    fn recover(&mut self, one: Recovered) {
        let text = match &one.text {
            Ok(text) => text.clone(),
            Err(why) => return self.complain(why),
        };
        let mut open = match one.scene_path.clone() {
            Some(path) => {
                let theirs = read_text(&path).map_err(|error| reason(&error));
                let is_based_on = theirs.as_ref().is_ok_and(|theirs| one.is_based_on(theirs));
                Open::recovered(path, text, theirs, is_based_on)
            }
            None => {
                let mut open = Open::new("scene.kdl", String::new(), None);
                open.document.replace_text(text, "Recovery", None);
                open
            }
        };
        open.watch(&self.waker);
        let (must_decide, is_unsaved) = (open.conflict.is_some(), open.has_unsaved_work());
        self.show_scene(open);
        self.changed();
        self.recovery.flush();
        if let Err(why) = one.discard() {
            self.complain(&why);
        }
        if must_decide {
            self.dialog = Some(Dialog::Conflict);
            self.say("Recovered, but its file is not what it was.");
        } else if is_unsaved {
            self.say("Recovered. Save it to keep it.");
        } else {
            self.say("Recovered: its file holds all of it.");
        }
    }

    fn start_render(&mut self) {
        let Some(Dialog::Render(render)) = &self.dialog else { return };
        let Some(open) = &self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let camera = scene.cameras.iter().position(|camera| camera.name == open.view.camera_name()).unwrap_or(0);
        let settings = Settings {
            size: render.size,
            samples: render.samples,
            bounces: render.bounces,
            camera,
            viewpoint: render.own_viewpoint.then(|| open.view.camera.clone()),
            ..App::settings(open, &scene)
        };
        let display = App::display(open, &scene);
        let layers = match render.format() {
            Ok(ImageFormat::Exr) if render.layers => Layer::ALL.to_vec(),
            _ => Vec::new(),
        };
        let (backend, adapter) = (self.options.backend, self.options.adapter.clone());
        let wake = self.waker.clone();
        let output = PathBuf::from(&render.output);
        let first = render.sequence().map_or(output.clone(), |sequence| sequence.file(&output));
        if let Err(why) = export::check_output(&first, &layers) {
            self.complain(&why);
            return;
        }
        let frames = render.sequence();
        let task = Task { scene, settings, display, layers, output, backend, adapter, frames };
        self.exports.push(Export::start(task, move || wake()));
        self.dialog = None;
    }

    /// Writes the picture as it is shown: what `render` gives for as many samples.
    pub(super) fn save_picture(&mut self, path: &Path) {
        let Some(open) = &self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let display = App::display(open, &scene);
        let answer = self.live.film().recv().unwrap_or_else(|_| Err("the renderer has stopped".to_owned()));
        let status = self.live.status();
        let result = answer.and_then(|(film, settings)| {
            let layers = match ImageFormat::from_path(path).map_err(|error| error.to_string())? {
                ImageFormat::Exr => Layer::ALL.to_vec(),
                _ => Vec::new(),
            };
            let (backend, adapter) = (status.backend, status.adapter);
            let rendered = Rendered { scene: &scene, settings: &settings, film: &film, backend, adapter };
            export::save_film(&rendered, path, &display, &layers)
        });
        match result {
            Ok(words) => self.say(&words),
            Err(why) => self.complain(&format!("The picture was not saved: {why}.")),
        }
    }
}

fn unsaved(ui: &mut Ui, after: &After, answer: &mut Answer) {
    ui.heading("Save the changes?");
    ui.label("The scene has changes that are in no file yet.");
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button(RichText::new("Save").strong()).clicked() {
            *answer = Answer::Save(after.clone());
        }
        if ui.button("Discard them").clicked() {
            *answer = Answer::Drop(after.clone());
        }
        if ui.button("Cancel").clicked() {
            *answer = Answer::Close;
        }
    });
}

fn busy(ui: &mut Ui, answer: &mut Answer) {
    ui.heading("A render is not finished");
    ui.label("It would end without a file.");
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button(RichText::new("Stay").strong()).clicked() {
            *answer = Answer::Close;
        }
        if ui.button("Cancel it and quit").clicked() {
            *answer = Answer::Leave;
        }
    });
}

/// Asks which of two versions is to stay. `unreadable` says why there is nothing to be had of the file's.
fn conflict(ui: &mut Ui, unreadable: Option<&String>, answer: &mut Answer) {
    match unreadable {
        None => {
            ui.heading("The file has changed as well");
            ui.label("Someone else has changed the file while there were unsaved changes here. Both are still there.");
        }
        Some(why) => {
            ui.heading("The file cannot be read any more");
            ui.label(format!("There are unsaved changes here, and of the file: {why}. Your version is still there."));
        }
    }
    ui.add_space(8.0);
    ui.horizontal_wrapped(|ui| {
        if ui.button("Keep mine").on_hover_text("The file stays as it is until you save.").clicked() {
            *answer = Answer::KeepMine;
        }
        if unreadable.is_none() && ui.button("Take the file's").on_hover_text("Undo brings yours back.").clicked() {
            *answer = Answer::TakeTheirs;
        }
        if ui.button("Save mine as…").on_hover_text("Leaves the file as it is.").clicked() {
            *answer = Answer::SaveMineElsewhere;
        }
    });
}

fn recovered(ui: &mut Ui, left: &[Recovered], answer: &mut Answer) {
    ui.heading("Unsaved work was found");
    ui.label("The program ended without saving it.");
    ui.add_space(6.0);
    for (index, one) in left.iter().enumerate() {
        ui.horizontal(|ui| {
            let name = one.scene_path.as_ref().map_or("an unsaved scene".to_owned(), |path| path.display().to_string());
            ui.label(format!("{name}, {}", age(one.saved_at, SystemTime::now())));
            if ui.button(RichText::new("Open").strong()).clicked() {
                *answer = Answer::Recover(index);
            }
            if ui.button("Discard").clicked() {
                *answer = Answer::Forget(index);
            }
        });
    }
    ui.add_space(6.0);
    if ui.button("Ask again next time").clicked() {
        *answer = Answer::Later;
    }
}

fn render_settings(ui: &mut Ui, render: &mut RenderDialog, answer: &mut Answer) {
    ui.heading("Render to a file");
    egui::Grid::new("render").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        let label = ui.label("file");
        ui.horizontal(|ui| {
            ui.add(egui::TextEdit::singleline(&mut render.output).desired_width(300.0)).labelled_by(label.id);
            if ui.button("Choose…").on_hover_text("Choose folder and name.").clicked() {
                *answer = Answer::Choose;
            }
        });
        ui.end_row();
        let label = ui.label("size");
        ui.horizontal(|ui| {
            for side in &mut render.size {
                ui.add(egui::DragValue::new(side).range(settings::SIDE.0..=settings::SIDE.1)).labelled_by(label.id);
            }
        });
        ui.end_row();
        let label = ui.label("samples");
        ui.add(egui::DragValue::new(&mut render.samples).range(settings::SAMPLES.0..=settings::SAMPLES.1))
            .labelled_by(label.id);
        ui.end_row();
        let label = ui.label("bounces");
        ui.add(egui::DragValue::new(&mut render.bounces).range(settings::BOUNCES.0..=settings::BOUNCES.1))
            .labelled_by(label.id);
        ui.end_row();
        if render.may_choose_viewpoint {
            let label = ui.label("seen from");
            ui.horizontal(|ui| {
                ui.radio_value(&mut render.own_viewpoint, true, "here").labelled_by(label.id);
                ui.radio_value(&mut render.own_viewpoint, false, "the scene's camera").labelled_by(label.id);
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
                    ui.checkbox(&mut render.skip_existing, "skip those that are there");
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
        if ui.add_enabled(problem.is_none(), egui::Button::new(RichText::new("Start").strong())).clicked() {
            *answer = Answer::Start;
        }
        if ui.button("Cancel").clicked() {
            *answer = Answer::Close;
        }
    });
}
