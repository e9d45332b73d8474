//! Answers to dialogs: recovers work, starts renders, saves pictures.

use super::App;
use super::dialog::{Answer, Dialog};
use super::file_handlers::reason;
use super::requests::{For, purpose};
use crate::picture::Rendered;
use crate::window::background_render::{self, Export, Task};
use crate::window::file_dialog::Chooser;
use crate::window::files::recovery::Recovered;
use crate::window::open_scene::Open;
use pathmarch_render::Settings;
use pathmarch_render::aov::Layer;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::scene::read_text;
use std::path::{Path, PathBuf};

impl App {
    pub(crate) fn answer_dialog(&mut self, answer: Answer) {
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
        if let Err(why) = background_render::check_output(&first, &layers) {
            self.complain(&why);
            return;
        }
        let frames = render.sequence();
        let task = Task { scene, settings, display, layers, output, backend, adapter, frames };
        self.exports.push(Export::start(task, move || wake()));
        self.dialog = None;
    }

    /// Writes the picture as it is shown: what `render` gives for as many samples.
    pub(crate) fn save_picture(&mut self, path: &Path) {
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
            background_render::save_film(&rendered, path, &display, &layers)
        });
        match result {
            Ok(words) => self.say(&words),
            Err(why) => self.complain(&format!("The picture was not saved: {why}.")),
        }
    }
}
