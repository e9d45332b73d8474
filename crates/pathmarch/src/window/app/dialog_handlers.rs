//! Handlers of dialog answers: recover work, start renders, save pictures.

use super::App;
use super::dialog::{Answer, Dialog};
use super::file_handlers::reason;
use super::requests::{FileRequest, file_dialog_options};
use crate::picture::Rendered;
use crate::window::background_render::{self, BackgroundRender, RenderRequest};
use crate::window::file_dialog::FileDialog;
use crate::window::files::recovery::{RecoveredWork, find_abandoned_work};
use crate::window::open_scene::OpenScene;
use pathmarch_render::aov::Layer;
use pathmarch_render::exposure::camera_stops;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::read_text;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{BackendInfo, Settings};
use std::path::{Path, PathBuf};

impl App {
    pub(crate) fn answer_dialog(&mut self, answer: Answer) {
        match answer {
            Answer::None => {}
            Answer::Close | Answer::AskLater => self.dialog = None,
            Answer::Save(after) => {
                self.dialog = None;
                if self.save(Some(after.clone())) {
                    self.run_pending(after);
                }
            }
            Answer::Discard(after) => {
                self.dialog = None;
                self.run_pending(after);
            }
            Answer::KeepMine => {
                self.dialog = None;
                if let Some(open) = &mut self.open {
                    open.keep_mine();
                }
                // The recovery file is now based on the other version.
                self.document_changed();
                self.show_message("Kept your version. The file is unchanged until you save.");
            }
            Answer::TakeTheirs => {
                self.dialog = None;
                if let Some(open) = &mut self.open
                    && let Some(Ok(text)) = open.conflict.take()
                {
                    open.reload_from_disk(text);
                    self.document_changed();
                    self.show_message("Loaded the file's version. Undo brings yours back.");
                }
            }
            Answer::SaveMineAs => {
                self.dialog = None;
                let options = file_dialog_options("Save your version as", &["kdl"]);
                let name = self.open.as_ref().map_or_else(String::new, OpenScene::file_name);
                let name = format!("{}-mine.kdl", name.trim_end_matches(".kdl"));
                self.file_dialog = Some((
                    self.with_bookmarks(FileDialog::save(&self.directory(), &name, options)),
                    FileRequest::SaveAs,
                ));
            }
            Answer::Recover(index) | Answer::DiscardRecovered(index) => {
                let Some(Dialog::Recovered(left)) = &mut self.dialog else { return };
                let one = left.remove(index);
                let others = !left.is_empty();
                if matches!(answer, Answer::Recover(_)) && one.text.is_ok() {
                    // Opening a second one would replace this one before it is saved.
                    self.dialog = None;
                    self.recover(one);
                    if others {
                        self.show_message("The other recovered scenes will be offered at the next start.");
                    }
                    return;
                }
                if !others {
                    self.dialog = None;
                }
                if matches!(answer, Answer::Recover(_)) {
                    self.recover(one);
                } else if let Err(why) = one.discard() {
                    self.show_error(&why);
                }
            }
            Answer::CancelRendersAndQuit => {
                self.dialog = None;
                self.renders.clear();
                self.request_quit();
            }
            Answer::StartRender => self.start_render(),
            Answer::ChooseOutput => {
                let Some(Dialog::Render(render)) = &self.dialog else { return };
                let options = file_dialog_options("Render to", &["png", "exr", "jpg"]);
                let path = PathBuf::from(&render.output);
                let folder = path.parent().filter(|folder| folder.is_dir()).map(Path::to_owned);
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let folder = folder.unwrap_or_else(|| self.directory());
                self.file_dialog =
                    Some((self.with_bookmarks(FileDialog::save(&folder, &name, options)), FileRequest::Render));
            }
        }
    }

    /// Lists the unsaved work of programs that have ended.
    pub(super) fn offer_recovery(&mut self) {
        let left = find_abandoned_work(&self.recovery_dir);
        match left.is_empty() {
            true => self.show_message("There is no unsaved work to recover."),
            false => self.dialog = Some(Dialog::Recovered(left)),
        }
    }

    /// Opens recovered work as unsaved changes of its file. Asks the user if the file is no longer the version that the
    /// work is based on.
    fn recover(&mut self, one: RecoveredWork) {
        let text = match &one.text {
            Ok(text) => text.clone(),
            Err(why) => return self.show_error(why),
        };
        let mut open = match one.scene_path.clone() {
            Some(path) => {
                let theirs = read_text(&path).map_err(|error| reason(&error));
                let is_based_on = theirs.as_ref().is_ok_and(|theirs| one.is_based_on(theirs));
                OpenScene::recovered(path, text, theirs, is_based_on, self.options.allow_files)
            }
            None => {
                let mut open = OpenScene::new("scene.kdl", String::new(), None);
                open.document.replace_text(text, "Recovery", None);
                open
            }
        };
        open.start_watching(&self.waker);
        let (must_decide, is_unsaved) = (open.conflict.is_some(), open.has_unsaved_work());
        self.show_scene(open);
        self.document_changed();
        self.recovery.flush();
        if let Err(why) = one.discard() {
            self.show_error(&why);
        }
        if must_decide {
            self.dialog = Some(Dialog::Conflict);
            self.show_message("Recovered, but its file has changed since.");
        } else if is_unsaved {
            self.show_message("Recovered. Save it to keep it.");
        } else {
            self.show_message("Recovered; its file is already up to date.");
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
            self.show_error(&why);
            return;
        }
        let frames = render.sequence();
        let confined = open.document.is_confined();
        let task = RenderRequest { scene, settings, display, layers, output, backend, adapter, frames, confined };
        self.renders.push(BackgroundRender::start(task, move || wake()));
        self.dialog = None;
    }

    /// Saves the displayed picture; the file equals that of `pathmarch render` with as many samples.
    pub(crate) fn save_picture(&mut self, path: &Path) {
        let Some(open) = &self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let display = App::display(open, &scene);
        let answer = self.live.film().recv().unwrap_or_else(|_| Err("the renderer has stopped".to_owned()));
        let status = self.live.status();
        let auto = open.view.mode.has_auto_exposure(&open.view.camera);
        let result = answer.and_then(|(film, settings)| {
            let display = if auto {
                Display { exposure_stops: camera_stops(&open.view.camera, Some(&film)), ..display }
            } else {
                display
            };
            let layers = match ImageFormat::from_path(path).map_err(|error| error.to_string())? {
                ImageFormat::Exr => Layer::ALL.to_vec(),
                _ => Vec::new(),
            };
            let backend = BackendInfo { name: status.backend, adapter: status.adapter, notice: status.notice };
            let rendered =
                Rendered { scene: &scene, settings: &settings, film: &film, backend: &backend, denoised: None };
            background_render::save_film(&rendered, path, &display, &layers)
        });
        match result {
            Ok(words) => self.show_message(&words),
            Err(why) => self.show_error(&format!("The picture was not saved: {why}.")),
        }
    }
}
