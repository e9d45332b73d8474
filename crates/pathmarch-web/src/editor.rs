//! The text of a scene with its mistakes and controls.

use crate::controls::{Node, control, value};
use crate::report::reports;
use crate::viewpoint::CameraRecord;
use pathmarch_render::pathmarch_scene::document::Path;
use pathmarch_render::pathmarch_scene::{Document, Moment, Scene};
use pathmarch_render::scene_hash;
use serde_json::{Value as Json, json};
use wasm_bindgen::prelude::*;

/// Label of a step of typing, for undo.
const TYPING: &str = "Typing";

/// Text that is edited by typing and by controls.
#[wasm_bindgen]
pub struct Editor {
    document: Document,
}

#[wasm_bindgen]
impl Editor {
    /// Editor of a text. Files that it names are relative to `name`.
    #[wasm_bindgen(constructor)]
    pub fn new(name: &str, text: &str) -> Self {
        Self { document: Document::new(name, text) }
    }

    /// Replaces the text, as typed. Texts of one `gesture` are one step of undo; those of controls are others.
    pub fn set_text(&mut self, text: String, gesture: u32) {
        self.document.replace_text(text, TYPING, Some(2 * u64::from(gesture)));
    }

    /// The text.
    pub fn text(&self) -> String {
        self.document.text().to_owned()
    }

    /// Shows an animated scene at some seconds after its start.
    pub fn set_time(&mut self, seconds: f64) {
        let fps = self.document.last_good().map_or(24.0, |scene| scene.render.fps);
        self.document.set_moment(Moment::of_seconds(seconds, fps));
    }

    /// Mistakes, outline and scene, as JSON. `scene` is null while the text has mistakes.
    pub fn state(&self) -> String {
        let document = &self.document;
        let scene = document.scene().map(|scene| &**scene);
        let outline: Vec<Node> = document.outline().iter().map(Node::from).collect();
        json!({
            "reports": reports(document.text(), scene),
            "outline": outline,
            "scene": scene.ok().map(description),
            "undo": document.can_undo(),
            "redo": document.can_redo(),
            "revision": document.scene_revision(),
        })
        .to_string()
    }

    /// Controls of the node at a path, a JSON array of indexes, as JSON.
    ///
    /// # Errors
    /// If it is no path.
    pub fn controls(&self, path: &str) -> Result<String, JsError> {
        let controls: Vec<Json> = self.document.controls(&parsed(path)?).iter().map(control).collect();
        Ok(Json::from(controls).to_string())
    }

    /// Sets a control to a value, JSON. Sets of one `gesture` are one step of undo.
    ///
    /// # Errors
    /// If the scene would have a mistake, in words for people; the text stays.
    pub fn set(&mut self, path: &str, key: &str, new: &str, gesture: u32) -> Result<(), JsError> {
        let path = parsed(path)?;
        let control = self.document.control(&path, key);
        let control = control.ok_or_else(|| JsError::new(&format!("there is no `{key}` here")))?;
        let json: Json = serde_json::from_str(new)?;
        let new = value(&control.kind, &json).ok_or_else(|| JsError::new(&format!("`{key}` cannot be {json}")))?;
        Ok(self.document.set(&path, key, new, Some(2 * u64::from(gesture) + 1))?)
    }

    /// Writes a camera, JSON, into the first camera of the text.
    ///
    /// # Errors
    /// If the text has mistakes of form.
    pub fn write_camera(&mut self, camera: &str) -> Result<(), JsError> {
        let record: CameraRecord = serde_json::from_str(camera)?;
        let items = self.document.outline();
        let first = items.iter().find(|item| item.word == "camera").map(|item| item.path.clone());
        self.document.write_camera(&record.into(), first.as_ref())?;
        Ok(())
    }

    /// Undoes a step; returns false if there is none.
    pub fn undo(&mut self) -> bool {
        self.document.undo().is_some()
    }

    /// Redoes a step; returns false if there is none.
    pub fn redo(&mut self) -> bool {
        self.document.redo().is_some()
    }
}

/// What the page needs to know of a scene.
fn description(scene: &Scene) -> Json {
    let cameras: Vec<CameraRecord> = scene.cameras.iter().map(CameraRecord::from).collect();
    let render = &scene.render;
    json!({
        "cameras": cameras,
        "size": [render.size.0, render.size.1],
        "samples": render.samples,
        "bounces": render.bounces,
        "tonemap": render.tonemap.name(),
        "animated": scene.animated,
        "hash": scene_hash(scene),
    })
}

fn parsed(path: &str) -> Result<Path, JsError> {
    let indexes: Vec<usize> = serde_json::from_str(path)?;
    let mut indexes = indexes.into_iter();
    let first = indexes.next().ok_or_else(|| JsError::new("an empty path names no node"))?;
    Ok(indexes.fold(Path::top(first), |path, index| path.child(index)))
}
