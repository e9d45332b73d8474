//! Scene texts that are edited without losing comments, order or formatting.
//!
//! Idea: the text is the scene. A [`Document`] contains the text and the tree of its nodes with their places; an edit
//! through a control is a *patch* of the few bytes that change, so that comments, order and formatting stay. After each
//! edit the reader of scene files reads the text again: there is no second description of a scene that could diverge
//! from its text. The ranges of controls come from the registries of shapes, operators and materials and from the
//! tables of settings.
//!
//! Undo: a step contains what its patches removed and inserted, so that history costs memory in proportion to the
//! changes and has no limit. Sets of one gesture, such as the drag of a slider, are one step.
//!
//! Rules. A text that is a scene stays one: an edit that would make a mistake is refused, the text stays unchanged, and
//! [`EditError`] has the reason and help. A text with mistakes may be edited as long as the edit adds none. A removed
//! node takes a comment after it on its line with it; comments on lines of their own stay. A moved node carries both, a
//! duplicate neither.
//!
//! Cost: an edit of a parameter parses the node that it changes, and builds the scene anew: about a millisecond for 1,000
//! shapes. Other edits read the whole text, in a scene of 10,000 objects (0.7 MB) some 30 ms; an edit of the tree reads the
//! form of the text once more for each step. Pictures of the sky and computed days are kept from one reading to the next.

mod control;
mod edits;
mod error;
mod history;
pub mod key;
pub mod mesh_import;
mod parameters;
mod text;
mod tree;

use crate::assets::Assets;
use crate::diagnostic::SceneError;
use crate::language;
use crate::language::syntax::reparse::{Change, reparse};
use crate::language::tree::Block;
use crate::language::{Read, Values};
use crate::scene::{Camera, Moment, Scene};
pub use control::{Addition, Control, ControlKind, Group, NumberRange, Value};
pub use edits::outline_points::ControlPoint;
pub use edits::presets::{PRESETS, Preset};
pub use edits::ramp::Ramp;
use edits::transaction::Transaction;
use edits::write::check::{check, keeping_formulas};
use edits::{additions, camera, combine, keyframes, kinds, outline_points, presets, ramp, structure};
pub use error::EditError;
use history::History;
use parameters::{Parameter, Place, parameters};
use std::sync::Arc;
use text::layout::{Style, bytes};
pub(crate) use text::literals::{numbers, quoted};
use text::patch::{Hunk, Patch, difference};
use tree::outline;
pub use tree::outline::{Item, ItemKind};
pub use tree::path::Path;

/// A scene text with its tree, controls and history.
pub struct Document {
    name: String,
    text: String,
    moment: Moment,
    saved: String,
    is_saved: bool,
    reading: Reading,
    last_good: Option<Arc<Scene>>,
    revision: u64,
    scene_revision: u64,
    history: History,
    assets: Assets,
}

/// Result of reading a text.
struct Reading {
    /// `None` where it was refused as a whole.
    file: Option<Block<'static>>,
    scene: Result<Arc<Scene>, SceneError>,
    /// Values of the formulas, and declarations.
    values: Values,
    outline: Vec<Item>,
    style: Style,
}

impl Reading {
    fn new(name: &str, text: &str, moment: Moment, assets: &mut Assets) -> Self {
        let Read { file, scene, values } = language::read(name, text, moment, assets);
        let file = file.map(Block::into_owned);
        let outline = file.as_ref().map_or_else(Vec::new, |file| outline::outline(file, &values.included));
        let style = Style::of(text, file.as_ref());
        Self { file, scene: scene.map(Arc::new), values, outline, style }
    }
    /// Reading of an edited text, of which these ranges differ, with the nodes of this reading, which then is left without any.
    /// `None` if more than the arguments of one node has changed, or if a mistake was made.
    fn after_edit(
        &mut self,
        (name, text): (&str, &str),
        hunks: &[Hunk],
        moment: Moment,
        assets: &mut Assets,
    ) -> Option<Self> {
        let (first, last) = (hunks.first()?, hunks.last()?);
        if self.scene.is_err() || !language::is_read(text) {
            return None;
        }
        let mut file = self.file.take()?;
        let header = reparse(&file, text, &(first.old.start..last.old.end), &(first.new.start..last.new.end));
        let Some(mut header) = header.filter(|header| header.change != Change::Nothing) else {
            self.file = Some(file);
            return None;
        };
        header.swap(&mut file);
        let (scene, values) = language::read_again((name, text), &file, moment, assets);
        let Ok(scene) = scene else {
            header.swap(&mut file);
            self.file = Some(file);
            return None;
        };
        let outline = match header.change {
            Change::Numbers => std::mem::take(&mut self.outline),
            _ => outline::outline(&file, &values.included),
        };
        let style = Style::of(text, Some(&file));
        Some(Self { file: Some(file), scene: Ok(Arc::new(scene)), values, outline, style })
    }
    /// Number of mistakes.
    fn mistakes(&self) -> usize {
        match &self.scene {
            Ok(_) => 0,
            Err(SceneError::Mistakes { total, .. }) => *total,
            Err(SceneError::Unreadable { .. }) => usize::MAX,
        }
    }
}

impl Document {
    /// A document of `text`, which came from `name`: a path, for pictures of the sky and for reports. A text with mistakes
    /// is a document, too. It counts as saved.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self::with_assets(name.into(), text.into(), Assets::default())
    }
    /// The same, but it reads no file outside the folder of the text: for scenes of strangers.
    pub fn confined(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self::with_assets(name.into(), text.into(), Assets::confined())
    }
    fn with_assets(name: String, text: String, mut assets: Assets) -> Self {
        let moment = Moment::default();
        let reading = Reading::new(&name, &text, moment, &mut assets);
        let last_good = reading.scene.as_ref().ok().cloned();
        let saved = text.clone();
        let history = History::default();
        Self {
            name,
            text,
            moment,
            saved,
            is_saved: true,
            reading,
            last_good,
            revision: 0,
            scene_revision: 0,
            history,
            assets,
        }
    }
    /// Path or name of the text.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Sets the path of the text and reads it again, because other files are relative to it.
    pub fn set_name(&mut self, name: impl Into<String>) {
        self.name = name.into();
        self.refresh();
    }
    /// True if no file outside the folder of the text is read.
    pub fn is_confined(&self) -> bool {
        self.assets.confined
    }
    /// Reads files outside the folder of the text from now on, and reads the text again.
    pub fn allow_files(&mut self) {
        self.assets.confined = false;
        self.refresh();
    }
    /// Reads the text again, because files that it names may have changed.
    pub fn refresh(&mut self) {
        self.reading = Reading::new(&self.name, &self.text, self.moment, &mut self.assets);
        self.keep_scene();
    }
    /// Moment of the scene.
    pub fn moment(&self) -> Moment {
        self.moment
    }
    /// Reads the scene at another moment. The text stays unchanged.
    pub fn set_moment(&mut self, moment: Moment) {
        if moment == self.moment {
            return;
        }
        self.moment = moment;
        match (&self.reading.file, &self.reading.scene) {
            // Without mistakes, the nodes are those of the text.
            (Some(file), Ok(_)) => {
                let source = (&*self.name, &*self.text);
                let (scene, values) = language::read_again(source, file, moment, &mut self.assets);
                (self.reading.scene, self.reading.values) = (scene.map(Arc::new), values);
                self.keep_scene();
            }
            _ => self.refresh(),
        }
    }
    /// Nodes and values of the text, and the files that it has read, which [`Self::take_back`] returns.
    pub(crate) fn lend(&mut self) -> (Option<Block<'static>>, Values, Assets) {
        (self.reading.file.clone(), self.reading.values.clone(), std::mem::take(&mut self.assets))
    }
    pub(crate) fn take_back(&mut self, assets: Assets) {
        self.assets = assets;
    }
    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }
    /// The scene, or every mistake of the text.
    pub fn scene(&self) -> Result<&Arc<Scene>, &SceneError> {
        self.reading.scene.as_ref()
    }
    /// The scene of the last text that was one.
    pub fn last_good(&self) -> Option<&Arc<Scene>> {
        self.last_good.as_ref()
    }
    /// A number that rises whenever the text has changed, or has been read again.
    pub fn revision(&self) -> u64 {
        self.revision
    }
    /// A number that rises whenever [`Self::last_good`] may look different: not while comments and layout of the text
    /// change.
    pub fn scene_revision(&self) -> u64 {
        self.scene_revision
    }
    /// The nodes at the top of the file, in its order.
    pub fn outline(&self) -> &[Item] {
        &self.reading.outline
    }
    /// The node of this path.
    pub fn item(&self, path: &Path) -> Option<&Item> {
        let (&first, rest) = path.indexes().split_first()?;
        rest.iter().try_fold(self.reading.outline.get(first)?, |item, &index| item.children.get(index))
    }
    /// Number of objects, shapes and operators that name a material.
    pub fn uses_of_material(&self, name: &str) -> usize {
        self.reading.file.as_ref().map_or(0, |file| structure::uses_of(&file.nodes, name))
    }
    /// Controls of a node; none for an unknown path.
    pub fn controls(&self, path: &Path) -> Vec<Control> {
        self.parameters(path).into_iter().map(|parameter| parameter.control).collect()
    }
    /// The control of this key.
    pub fn control(&self, path: &Path, key: &str) -> Option<Control> {
        self.controls(path).into_iter().find(|control| control.key == key)
    }
    /// Sets a parameter; [`Value::None`] resets it. Sets in a row with the same `gesture` are one step of undo, called as
    /// the first of them. The value that it has already changes nothing.
    pub fn set(&mut self, path: &Path, key: &str, value: Value, gesture: Option<u64>) -> Result<(), EditError> {
        let transaction = self.transaction()?;
        if key == key::PICTURE && transaction.find(path)?.kind == ItemKind::Sky {
            let Value::Text(file) = &value else {
                return Err(EditError::WrongValue { label: key.to_owned(), expected: "a text".to_owned() });
            };
            return self
                .edit("Change picture of sky", gesture, |transaction| kinds::set_picture(transaction, path, file));
        }
        let parameter = transaction.parameter(path, key)?;
        if value == Value::None {
            return self.erase(path, parameter, gesture);
        }
        check(&parameter, &value)?;
        let value = keyframes::keyed(&parameter.control, &value, self.moment.seconds).unwrap_or(value);
        let value = keeping_formulas(&parameter, value)?;
        if value == parameter.control.value {
            return Ok(());
        }
        let label = format!("Change {} of {}", parameter.control.label, self.title(path));
        match (&parameter.place, &value) {
            (Place::Name, Value::Text(name)) => {
                let label = format!("Rename {} to {name}", self.title(path));
                self.edit(&label, gesture, |transaction| structure::rename(transaction, path, name))
            }
            (Place::Kind, Value::Text(kind)) => {
                let label = format!("Make {} {kind}", self.title(path));
                self.edit(&label, gesture, |transaction| kinds::set_kind(transaction, path, kind))
            }
            _ => self.edit(&label, gesture, |transaction| {
                let patches = transaction.writer(transaction.find(path)?).write(&parameter, &value)?;
                transaction.last(patches);
                Ok(())
            }),
        }
    }
    /// Sets a key of a parameter: its present value at the present moment, as in `keys(t, 0, 1, 2, 5)`. From then on,
    /// [`Self::set`] sets keys of it, too.
    pub fn set_key(&mut self, path: &Path, key: &str, gesture: Option<u64>) -> Result<(), EditError> {
        let parameter = self.transaction()?.parameter(path, key)?;
        let value = keyframes::with_keys(&parameter.control, self.moment.seconds)?;
        self.set(path, key, value, gesture)
    }
    /// Times of the keys of a node's parameters in seconds, each once and in order.
    pub fn key_times(&self, path: &Path) -> Vec<f64> {
        let mut times: Vec<f64> = self.controls(path).iter().flat_map(keyframes::times).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
    /// Removes a parameter from the text, so that it has its default; an argument that others follow is given that. What
    /// must be given cannot be reset.
    pub fn reset(&mut self, path: &Path, key: &str) -> Result<(), EditError> {
        self.reset_in(path, key, None)
    }
    /// The same as a part of an undo step, as in [`Self::set`].
    pub fn reset_in(&mut self, path: &Path, key: &str, undo_group: Option<u64>) -> Result<(), EditError> {
        let parameter = self.transaction()?.parameter(path, key)?;
        self.erase(path, parameter, undo_group)
    }
    /// Control points of a polygon or a curve, in their order; none of other nodes, and none if the text has no points.
    pub fn control_points(&self, path: &Path) -> Vec<ControlPoint> {
        let found = self.reading.file.as_ref().and_then(|file| outline::find(file, path));
        let shapes = found.filter(|found| found.kind == ItemKind::Shape);
        shapes.map_or_else(Vec::new, |found| outline_points::control_points(found.node, &self.reading.values))
    }
    /// Moves a control point; a coordinate that is a formula stays. `undo_group` is that of [`Self::set`].
    pub fn move_point(
        &mut self,
        path: &Path,
        point: usize,
        at: [f32; 2],
        undo_group: Option<u64>,
    ) -> Result<(), EditError> {
        let label = format!("Move point {} of {}", point + 1, self.title(path));
        self.edit(&label, undo_group, |transaction| outline_points::set(transaction, path, point, at))
    }
    /// Adds a control point, which then has this index.
    pub fn add_point(
        &mut self,
        path: &Path,
        point: usize,
        at: [f32; 2],
        undo_group: Option<u64>,
    ) -> Result<(), EditError> {
        let label = format!("Add point to {}", self.title(path));
        self.edit(&label, undo_group, |transaction| outline_points::add(transaction, path, point, at))
    }
    /// Removes a control point. Refused for one of the last three of an area, or the last two of a line.
    pub fn remove_point(&mut self, path: &Path, point: usize) -> Result<(), EditError> {
        let label = format!("Remove point {} of {}", point + 1, self.title(path));
        self.edit(&label, None, |transaction| outline_points::remove(transaction, path, point))
    }
    /// Makes a curve have a corner at a control point, or be smooth there.
    pub fn set_corner(&mut self, path: &Path, point: usize, is_corner: bool) -> Result<(), EditError> {
        let verb = if is_corner { "Make a corner at" } else { "Smooth" };
        let label = format!("{verb} point {} of {}", point + 1, self.title(path));
        self.edit(&label, None, |transaction| outline_points::set_corner(transaction, path, point, is_corner))
    }
    /// Colour ramps of a material, also those without colours in the text.
    pub fn ramps(&self, path: &Path) -> Vec<Ramp> {
        ramp::ramps(&self.parameters(path))
    }
    /// Gives a ramp of a material its first colours, evenly spaced.
    pub fn start_ramp(&mut self, path: &Path, ramp: &Ramp, colours: &[[f32; 3]]) -> Result<(), EditError> {
        let label = format!("Add colours to {}", ramp.name);
        let colours: Vec<_> = colours.iter().map(|colour| (*colour, None)).collect();
        self.edit(&label, None, |transaction| ramp::add(transaction, path, ramp.owner, 0, &colours))
    }
    /// Removes a colour of a ramp.
    pub fn remove_colour(&mut self, path: &Path, ramp: &Ramp, index: usize) -> Result<(), EditError> {
        let label = format!("Remove colour {} of {}", index + 1, ramp.name);
        self.edit(&label, None, |transaction| ramp::remove(transaction, path, ramp.owner, index))
    }
    /// Moves a colour of a ramp to another value, from 0 to 1, but not past its neighbours. Colours between others whose
    /// positions the text does not give stay where they are. `undo_group` is that of [`Self::set`].
    pub fn place_colour(
        &mut self,
        path: &Path,
        ramp: &Ramp,
        index: usize,
        position: f32,
        undo_group: u64,
    ) -> Result<(), EditError> {
        let neighbour = |index: Option<usize>| index.and_then(|index| ramp.positions.get(index)).copied();
        let lowest = neighbour(index.checked_sub(1)).unwrap_or(0.0);
        let position = position.clamp(lowest, neighbour(Some(index + 1)).unwrap_or(1.0).max(lowest));
        self.pin_colours(path, ramp, undo_group)?;
        self.set(path, &ramp.position_key(index), Value::Number(position), Some(undo_group))
    }
    /// Adds a colour to a ramp at a value, from 0 to 1. Colours between others stay where they are.
    pub fn add_colour_at(
        &mut self,
        path: &Path,
        ramp: &Ramp,
        colour: [f32; 3],
        position: f32,
        undo_group: u64,
    ) -> Result<(), EditError> {
        self.pin_colours(path, ramp, undo_group)?;
        let index = ramp.positions.iter().take_while(|before| **before <= position).count();
        // An end without a position would no longer be one.
        if index == 0 || index == ramp.positions.len() {
            let end = index.saturating_sub(1);
            if let (Some(None), Some(at)) = (ramp.given.get(end), ramp.positions.get(end)) {
                self.set(path, &ramp.position_key(end), Value::Number(*at), Some(undo_group))?;
            }
        }
        let label = format!("Add colour to {}", ramp.name);
        let colours = [(colour, Some(position))];
        self.edit(&label, Some(undo_group), |transaction| ramp::add(transaction, path, ramp.owner, index, &colours))
    }
    /// Gives all colours between the ends of a ramp their positions.
    fn pin_colours(&mut self, path: &Path, ramp: &Ramp, undo_group: u64) -> Result<(), EditError> {
        let last = ramp.given.len().saturating_sub(1);
        for index in (1..last).filter(|index| ramp.given[*index].is_none()) {
            let position = (ramp.positions[index] * 1e3).round() / 1e3;
            self.set(path, &ramp.position_key(index), Value::Number(position), Some(undo_group))?;
        }
        Ok(())
    }
    /// The scene without a node, and without what is empty then; `None` if that is no scene.
    pub fn scene_without(&mut self, path: &Path) -> Option<Arc<Scene>> {
        let mut path = path.clone();
        while let Some(parent) =
            path.parent().filter(|parent| self.item(parent).is_some_and(|item| item.children.len() == 1))
        {
            path = parent;
        }
        let mut transaction = self.transaction().ok()?;
        transaction.take_out(&path, false).ok()?;
        let (text, _) = transaction.finish();
        let read = language::read(&self.name, &text, self.moment, &mut self.assets);
        read.scene.ok().map(Arc::new)
    }
    /// Additions to a node, or to the file.
    pub fn additions(&self, parent: Option<&Path>) -> Vec<Addition> {
        let Ok(transaction) = self.transaction() else { return Vec::new() };
        match parent {
            Some(parent) => {
                self.item(parent).map_or_else(Vec::new, |item| additions::additions(&transaction, Some(item.kind)))
            }
            None => additions::additions(&transaction, None),
        }
    }
    /// Adds something to a node, or to the file. Returns its path.
    pub fn add(&mut self, parent: Option<&Path>, addition: &Addition) -> Result<Path, EditError> {
        let label = format!("Add {}", addition.name);
        self.edit(&label, None, |transaction| additions::add(transaction, parent, addition))
    }
    /// Adds imported nodes to the file in one step. Returns their paths.
    pub fn add_imported(&mut self, label: &str, nodes: &[mesh_import::ImportedNode]) -> Result<Vec<Path>, EditError> {
        self.edit(label, None, |transaction| additions::add_imported(transaction, nodes))
    }
    /// Removes a node with its children. Refused for the version, the only camera, a material in use, and the only
    /// child of an object or an operator.
    pub fn remove(&mut self, path: &Path) -> Result<(), EditError> {
        let label = format!("Remove {}", self.title(path));
        self.edit(&label, None, |transaction| structure::remove(transaction, path))
    }
    /// Renames a camera, a material, an object, a parameter or a shape, and its uses.
    pub fn rename(&mut self, path: &Path, new_name: &str) -> Result<(), EditError> {
        let label = format!("Rename {} to {new_name}", self.title(path));
        self.edit(&label, None, |transaction| structure::rename(transaction, path, new_name))
    }
    /// Moves a node, with its comments, into `new_parent` (the file without one), where it then has this `index`; one past
    /// the end is the end. An object that is moved into another or into an operator becomes its shapes; a shape that is
    /// moved to the file becomes an object. They keep their materials, and what is empty without them is removed. Returns
    /// the new path.
    pub fn move_to(&mut self, path: &Path, new_parent: Option<&Path>, index: usize) -> Result<Path, EditError> {
        let label = format!("Move {}", self.title(path));
        self.edit(&label, None, |transaction| combine::move_to(transaction, path, new_parent, index))
    }
    /// Puts siblings into the braces of a new operator, which takes the place of the first of them.
    pub fn group(&mut self, paths: &[Path], operator: &str) -> Result<Path, EditError> {
        let label = format!("Group into {operator}");
        self.edit(&label, None, |transaction| structure::group(transaction, paths, operator))
    }
    /// Combines shapes, operators and objects by an operator, in the place of the first of them; the others follow it in
    /// their order, so that `subtract` removes them from the first. They keep their materials; what is empty without
    /// them is removed, with its comments. Returns the operator. Refused if a placed operator or a modifier is around some of them.
    pub fn combine(&mut self, paths: &[Path], operator: &str) -> Result<Path, EditError> {
        let label = format!("Combine into {operator}");
        self.edit(&label, None, |transaction| combine::combine(transaction, paths, operator))
    }
    /// Replaces an operator by its children, with its material where they have none. Returns their paths. Refused for
    /// an operator with a placement, because the children would move.
    pub fn ungroup(&mut self, path: &Path) -> Result<Vec<Path>, EditError> {
        let label = format!("Ungroup {}", self.title(path));
        self.edit(&label, None, |transaction| structure::ungroup(transaction, path))
    }
    /// Copies a node and puts the copy behind it, under a free name if it has one.
    pub fn duplicate(&mut self, path: &Path) -> Result<Path, EditError> {
        let label = format!("Duplicate {}", self.title(path));
        self.edit(&label, None, |transaction| structure::duplicate(transaction, path))
    }
    /// Makes a material or a sky one of another kind, or a shape or an operator another. Parameters that the new one has,
    /// too, are kept where it takes their values.
    pub fn set_kind(&mut self, path: &Path, kind: &str) -> Result<(), EditError> {
        let label = format!("Make {} {kind}", self.title(path));
        self.edit(&label, None, |transaction| kinds::set_kind(transaction, path, kind))
    }
    /// Makes a material one of [`PRESETS`]; comments and textures in its braces are lost.
    pub fn apply_preset(&mut self, path: &Path, preset: &str) -> Result<(), EditError> {
        let label = format!("Make {} {preset}", self.title(path));
        self.edit(&label, None, |transaction| presets::apply(transaction, path, preset))
    }
    /// Gives objects, shapes and operators a material that is made of one of [`PRESETS`], and added unless it is there.
    pub fn give_preset(&mut self, paths: &[Path], preset: &str) -> Result<(), EditError> {
        self.edit(&format!("Give {preset}"), None, |transaction| presets::give(transaction, paths, preset))
    }
    /// Gives a node that uses a material a copy of it, so that other users of the material stay as they are. Returns the
    /// copy.
    pub fn copy_material(&mut self, user: &Path, material: &Path) -> Result<Path, EditError> {
        let label = format!("Copy {}", self.title(material));
        self.edit(&label, None, |transaction| structure::copy_material(transaction, user, material))
    }
    /// Sets the material of an object, a shape or an operator; `None` removes it.
    pub fn set_material(&mut self, path: &Path, material: Option<&str>) -> Result<(), EditError> {
        self.set_material_in(path, material, None)
    }
    /// The same as a part of an undo step, as in [`Self::set`].
    pub fn set_material_in(
        &mut self,
        path: &Path,
        material: Option<&str>,
        undo_group: Option<u64>,
    ) -> Result<(), EditError> {
        let value = material.map_or(Value::None, |name| Value::Text(name.to_owned()));
        self.set(path, key::MATERIAL, value, undo_group)
    }
    /// Writes a camera into the text: into the camera node `into`, which keeps its name, or as a new one, under its own
    /// name or the nearest free one.
    pub fn write_camera(&mut self, camera: &Camera, into: Option<&Path>) -> Result<Path, EditError> {
        let name = into.and_then(|path| self.item(path)).map_or(&*camera.name, |item| item.title());
        let label = format!("Write camera {name}");
        self.edit(&label, None, |transaction| camera::write_camera(transaction, camera, into))
    }
    /// Replaces the text, as when the file has changed on disk. It may have mistakes. Replacements in a row with the same
    /// `gesture`, as of a run of typing, are one step of undo, called `label`.
    pub fn replace_text(&mut self, text: String, label: &str, gesture: Option<u64>) {
        if text == self.text {
            return;
        }
        let patch = difference(&self.text, &text);
        let new = patch.range.start..patch.range.start + patch.text.len();
        self.history.push(label, gesture, &self.text, &text, &[Hunk { old: patch.range, new }]);
        self.become_text(text);
    }
    /// Undoes the last step. Returns its label, as in "Change radius of sphere".
    pub fn undo(&mut self) -> Option<String> {
        let (text, label) = self.history.undo(&self.text)?;
        self.become_text(text);
        Some(label)
    }
    /// Redoes the step that was undone last. Returns its label.
    pub fn redo(&mut self) -> Option<String> {
        let (text, label) = self.history.redo(&self.text)?;
        self.become_text(text);
        Some(label)
    }
    /// Label of the step that [`Self::undo`] would undo.
    pub fn can_undo(&self) -> Option<&str> {
        self.history.next_undo()
    }
    /// Label of the step that [`Self::redo`] would redo.
    pub fn can_redo(&self) -> Option<&str> {
        self.history.next_redo()
    }
    /// True if the text is the one that was saved last.
    pub fn is_saved(&self) -> bool {
        self.is_saved
    }
    /// Marks the text as saved.
    pub fn mark_saved(&mut self) {
        self.saved.clone_from(&self.text);
        self.is_saved = true;
    }
    /// The node of the shape with this index in the field's leaves, while the text is a scene.
    pub fn path_of_leaf(&self, leaf: usize) -> Option<Path> {
        fn find(items: &[Item], leaf: usize) -> Option<&Item> {
            let item = items.iter().find(|item| (item.leaves.0..item.leaves.0 + item.leaves.1).contains(&leaf))?;
            if matches!(item.kind, ItemKind::Shape | ItemKind::Instance) {
                Some(item)
            } else {
                find(&item.children, leaf)
            }
        }
        find(&self.reading.outline, leaf).map(|item| item.path.clone())
    }
    /// The node of the object with this index in the scene, while the text is a scene.
    pub fn path_of_object(&self, object: usize) -> Option<Path> {
        let mut objects = self.reading.outline.iter().filter(|item| item.kind == ItemKind::Object && !item.hidden);
        objects.nth(object).map(|item| item.path.clone())
    }
    /// Indexes of the field's leaves that are in this node.
    pub fn leaves_of(&self, path: &Path) -> Vec<usize> {
        self.item(path).map_or_else(Vec::new, |item| (item.leaves.0..item.leaves.0 + item.leaves.1).collect())
    }
    /// The line that a node starts on; the first is 1.
    pub fn line_of(&self, path: &Path) -> Option<usize> {
        let found = outline::find(self.reading.file.as_ref()?, path)?;
        Some(1 + self.text[..found.node.whole.start as usize].matches('\n').count())
    }
    /// Text of a node, without what follows it on its line.
    pub fn text_of(&self, path: &Path) -> Option<&str> {
        let found = outline::find(self.reading.file.as_ref()?, path)?;
        self.text.get(bytes(found.node.whole))
    }
    /// The innermost node around a byte of the text.
    pub fn path_at(&self, byte: usize) -> Option<Path> {
        let mut block = self.reading.file.as_ref()?;
        let (mut parent, mut path) = (None, None::<Path>);
        loop {
            let inside = |node: &language::tree::Node| bytes(node.whole).contains(&byte);
            let shown = outline::shown(block, parent).enumerate().find(|(_, (_, node))| inside(node));
            let Some((index, (_, node))) = shown else { return path };
            let next = path.map_or_else(|| Path::top(index), |path| path.child(index));
            parent = self.item(&next).map(|item| item.kind);
            path = Some(next);
            let Some(children) = &node.children else { return path };
            block = children;
        }
    }

    fn keep_scene(&mut self) {
        if let Ok(scene) = &mut self.reading.scene {
            // Nobody else has the scene yet.
            if let (Some(scene), Some(old)) = (Arc::get_mut(scene), &self.last_good) {
                scene.field.follow(&old.field);
            }
            self.last_good = Some(scene.clone());
            self.scene_revision += 1;
        }
        self.revision += 1;
        self.is_saved = self.text == self.saved;
    }
    fn become_text(&mut self, text: String) {
        let Patch { range, text: inserted } = difference(&self.text, &text);
        let hunk = Hunk { new: range.start..range.start + inserted.len(), old: range };
        let reading = self.read_edited(&text, &[hunk]);
        self.become_reading(text, reading);
    }
    /// Reads a text that differs from the present one in these ranges.
    fn read_edited(&mut self, text: &str, hunks: &[Hunk]) -> Reading {
        let source = (&*self.name, text);
        let edited = self.reading.after_edit(source, hunks, self.moment, &mut self.assets);
        edited.unwrap_or_else(|| Reading::new(&self.name, text, self.moment, &mut self.assets))
    }
    fn become_reading(&mut self, text: String, reading: Reading) {
        let same = match (&reading.file, &self.reading.file) {
            (Some(new), Some(old)) => self.reading.scene.is_ok() && new.has_same_nodes(old),
            _ => false,
        };
        let before = self.scene_revision;
        (self.text, self.reading) = (text, reading);
        self.keep_scene();
        if same {
            self.scene_revision = before;
        }
    }

    fn title(&self, path: &Path) -> String {
        self.item(path).map_or_else(String::new, |item| item.title().to_owned())
    }
    fn parameters(&self, path: &Path) -> Vec<Parameter> {
        let found = self.reading.file.as_ref().and_then(|file| Some((file, outline::find(file, path)?)));
        found.map_or_else(Vec::new, |(file, found)| parameters(file, &self.reading.values, found.kind, found.node))
    }
    fn transaction(&self) -> Result<Transaction<'_>, EditError> {
        match &self.reading.file {
            Some(file) => Ok(Transaction::new(&self.text, file, &self.reading.values, &self.reading.style)),
            None => Err(EditError::Unreadable("the scene".to_owned())),
        }
    }

    /// Makes an edit, unless it adds mistakes to the text.
    fn edit<T>(
        &mut self,
        label: &str,
        gesture: Option<u64>,
        make: impl FnOnce(&mut Transaction) -> Result<T, EditError>,
    ) -> Result<T, EditError> {
        let mut transaction = self.transaction()?;
        let result = make(&mut transaction)?;
        let (text, hunks) = transaction.finish();
        if text == self.text {
            return Ok(result);
        }
        let reading = self.read_edited(&text, &hunks);
        if reading.mistakes() > self.reading.mistakes() {
            return Err(match &reading.scene {
                Err(SceneError::Unreadable { reason, help, .. }) => {
                    EditError::Mistake { message: format!("{reason}."), help: Some(help.clone()) }
                }
                Err(error) => {
                    let first = error.mistakes().first();
                    let message = first.map_or_else(String::new, |mistake| mistake.message.clone());
                    EditError::Mistake { message, help: first.and_then(|mistake| mistake.help.clone()) }
                }
                Ok(_) => EditError::Unreadable("the scene".to_owned()),
            });
        }
        self.history.push(label, gesture, &self.text, &text, &hunks);
        self.become_reading(text, reading);
        Ok(result)
    }

    fn erase(&mut self, path: &Path, parameter: Parameter, gesture: Option<u64>) -> Result<(), EditError> {
        let control = &parameter.control;
        if control.required {
            let label = &control.label;
            return Err(EditError::Needed(format!("`{label}` must be given. Set it to another value instead.")));
        }
        if !control.given {
            return Ok(());
        }
        let label = format!("Reset {} of {}", control.label, self.title(path));
        self.edit(&label, gesture, |transaction| {
            let patches = transaction.writer(transaction.find(path)?).erase(&parameter)?;
            transaction.last(patches);
            Ok(())
        })
    }
}
