//! Scene tree (outliner): select, rename, add, delete and reorder nodes.
//!
//! Only visible rows are built: ten thousand objects cost no more than ten.

use super::inspector::heading;
use super::materials::DraggedMaterial;
use crate::window::app::App;
use egui::{Align2, Color32, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_field::registry::solids;
use pathmarch_render::pathmarch_scene::document::{Addition, Group, Item, ItemKind, Path};
use std::collections::BTreeMap;

/// Indentation of a level, points.
const INDENT: f32 = 16.0;

/// A visible row.
struct Row<'a> {
    depth: usize,
    item: &'a Item,
    /// Expanded or collapsed; `None` for a node without children.
    is_expanded: Option<bool>,
}

/// A change that the user requests in the tree.
enum TreeAction {
    Select(Path),
    /// Adds a node to the selection, or removes it.
    Toggle(Path),
    /// Selects the rows from the active one to this one.
    SelectTo(Path),
    Expand(Path, bool),
    Add(Option<Path>, Addition),
    Rename(Path, String),
    Duplicate(Path),
    Delete(Path),
    Group(Path, &'static str),
    Combine(&'static str),
    Ungroup(Path),
    Move(Path, Option<Path>, usize),
    Hide(Path, bool),
    Lock(String, bool),
    GiveMaterial(Path, DraggedMaterial),
}

impl App {
    pub(crate) fn tree_panel(&mut self, ui: &mut Ui) {
        let most = (0.27 * ui.ctx().content_rect().width()).clamp(100.0, 480.0);
        let panel = egui::Panel::left("tree").default_size(235.0_f32.min(most)).min_size(100.0).max_size(most);
        panel.show(ui, |ui| {
            let mut actions = Vec::new();
            ui.horizontal(|ui| {
                ui.heading("Scene");
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.menu_button("Add…", |ui| self.add_menu(ui, None, &mut actions))
                        .response
                        .on_hover_text("Add an object, a material, a light or a camera.");
                });
            });
            if let Some(open) = &mut self.open {
                let search = egui::TextEdit::singleline(&mut open.tree_search).hint_text("Search");
                let search = ui.add(search.desired_width(f32::INFINITY));
                search.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SearchInput, true, "Search the scene"));
            }
            ui.separator();
            self.rows(ui, &mut actions);
            for action in actions {
                self.apply_action(action);
            }
        });
    }

    /// Menu of nodes that can be added to a node, or to the scene.
    fn add_menu(&self, ui: &mut Ui, parent: Option<&Path>, actions: &mut Vec<TreeAction>) {
        let Some(open) = &self.open else { return };
        let mut groups: BTreeMap<Group, Vec<Addition>> = BTreeMap::new();
        for addition in open.document.additions(parent) {
            groups.entry(addition.group).or_default().push(addition);
        }
        for (group, additions) in groups {
            ui.menu_button(group.name(), |ui| {
                egui::ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
                    for addition in additions {
                        if ui.button(&*addition.name).on_hover_text(&*addition.doc).clicked() {
                            actions.push(TreeAction::Add(parent.cloned(), addition));
                            ui.close();
                        }
                    }
                });
            });
        }
    }

    fn rows(&self, ui: &mut Ui, actions: &mut Vec<TreeAction>) {
        let Some(open) = &self.open else { return };
        let mut rows = Vec::new();
        let id = ui.scope_id();
        for item in open.document.outline() {
            gather(&open.collapsed, &open.tree_search, item, 0, &mut rows);
        }
        let selection = open.view.selection.active().cloned();
        let height = ui.spacing().interact_size.y;
        let to_selection = ui.data(|data| data.get_temp::<Option<Path>>(id.with("seen"))).flatten() != selection;
        ui.data_mut(|data| data.insert_temp(id.with("seen"), selection.clone()));
        let mut area = egui::ScrollArea::vertical().auto_shrink([false, false]);
        if to_selection && let Some(at) = rows.iter().position(|row| Some(&row.item.path) == selection.as_ref()) {
            let top = at as f32 * (height + ui.spacing().item_spacing.y);
            let seen = ui.data(|data| data.get_temp::<(f32, f32)>(id.with("sight"))).unwrap_or((0.0, f32::MAX));
            if top < seen.0 || top + height > seen.1 {
                area = area.vertical_scroll_offset((top - 80.0).max(0.0));
            }
        }
        let shown = area.show_rows(ui, height, rows.len(), |ui, range| {
            for row in &rows[range] {
                self.row(ui, id, row, open.view.selection.contains(&row.item.path), actions);
            }
        });
        let top = shown.state.clamped_offset().y;
        ui.data_mut(|data| data.insert_temp(id.with("sight"), (top, top + shown.inner_rect.height())));
    }

    fn row(&self, ui: &mut Ui, id: egui::Id, row: &Row<'_>, selected: bool, actions: &mut Vec<TreeAction>) {
        let Row { depth, item, is_expanded } = row;
        let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let indent = 4.0 + INDENT * *depth as f32;
        let row_id = id.with(("row", &item.path));
        if let Some(is_expanded) = is_expanded {
            let arrow = Rect::from_min_size(rect.min + Vec2::new(indent, 0.0), Vec2::new(INDENT, size.y));
            let response = ui.interact(arrow, row_id.with("arrow"), Sense::click());
            let colour = ui.style().interact(&response).fg_stroke.color;
            ui.painter().add(triangle(arrow.center(), *is_expanded, colour));
            let what = if *is_expanded { "Collapse" } else { "Expand" };
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{what} {}", heading(item)))
            });
            if response.clicked() {
                actions.push(TreeAction::Expand(item.path.clone(), !is_expanded));
            }
        }
        let body = Rect::from_min_max(rect.min + Vec2::new(indent + INDENT, 0.0), rect.max);
        let renaming = ui.data(|data| data.get_temp::<String>(row_id));
        if let Some(typed) = renaming {
            rename(ui, body, row_id, item, typed, actions);
            return;
        }
        let response = ui.interact(body, row_id.with("body"), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::TreeItem, true, selected, heading(item)));
        let visuals = ui.style().interact_selectable(&response, selected);
        if selected || response.hovered() {
            ui.painter().rect_filled(body, 3.0, visuals.weak_bg_fill);
        }
        let painter = ui.painter_at(body);
        let font = egui::TextStyle::Button.resolve(ui.style());
        let at = Pos2::new(body.min.x + 8.0, body.center().y);
        sign(&painter, at, item.kind, ui.visuals().weak_text_color());
        let at = at + Vec2::new(10.0, 0.0);
        let is_locked = self.open.as_ref().is_some_and(|open| open.is_locked(&item.path));
        let colour = if item.hidden { ui.visuals().weak_text_color() } else { visuals.text_color() };
        let drawn = painter.text(at, Align2::LEFT_CENTER, label(item), font.clone(), colour);
        if item.hidden {
            painter.hline(drawn.x_range(), drawn.center().y, Stroke::new(1.0, colour));
        }
        if is_locked && path_is_top(&item.path) {
            lock(&painter, Pos2::new(body.max.x - 8.0, body.center().y), ui.visuals().weak_text_color());
        }
        if let Some(material) = &item.material {
            let at = Pos2::new(drawn.max.x + 7.0, body.center().y);
            painter.text(at, Align2::LEFT_CENTER, material, font, ui.visuals().weak_text_color());
        }
        if response.clicked() {
            let modifiers = ui.input(|input| input.modifiers);
            let select = match (modifiers.command, modifiers.shift) {
                (true, _) => TreeAction::Toggle,
                (_, true) => TreeAction::SelectTo,
                _ => TreeAction::Select,
            };
            actions.push(select(item.path.clone()));
        }
        if response.double_clicked() {
            if item.name.is_some() {
                let name = item.name.clone().unwrap_or_default();
                ui.data_mut(|data| data.insert_temp(row_id, name));
            } else if let Some(is_expanded) = is_expanded {
                actions.push(TreeAction::Expand(item.path.clone(), !is_expanded));
            }
        }
        drag(ui, &response, item, actions);
        response.context_menu(|ui| self.context_menu(ui, row_id, item, actions));
    }

    fn context_menu(&self, ui: &mut Ui, row_id: egui::Id, item: &Item, actions: &mut Vec<TreeAction>) {
        let path = &item.path;
        let is_selected = self.open.as_ref().is_some_and(|open| open.view.selection.contains(path));
        if !is_selected {
            actions.push(TreeAction::Select(path.clone()));
        }
        if item.kind.holds_shapes() {
            ui.menu_button("Add…", |ui| self.add_menu(ui, Some(path), actions));
        }
        let named = item.kind.is_named();
        if named && ui.button("Rename").clicked() {
            let name = item.name.clone().unwrap_or_default();
            ui.data_mut(|data| data.insert_temp(row_id, name));
            ui.close();
        }
        if ui.button("Duplicate").clicked() {
            actions.push(TreeAction::Duplicate(path.clone()));
            ui.close();
        }
        if item.kind.is_solid() {
            ui.menu_button("Group into", |ui| {
                for operator in solids().filter(|solid| solid.is_operator()) {
                    let info = operator.info();
                    if ui.button(&*info.name).on_hover_text(&*info.doc).clicked() {
                        actions.push(TreeAction::Group(path.clone(), &info.name));
                        ui.close();
                    }
                }
            });
        }
        let several = self.open.as_ref().is_some_and(|open| open.view.selection.paths().len() > 1);
        for (name, operator) in [("Unite", "union"), ("Subtract", "subtract"), ("Intersect", "intersect")] {
            if is_selected && several && ui.button(name).clicked() {
                actions.push(TreeAction::Combine(operator));
                ui.close();
            }
        }
        if item.kind == ItemKind::Operator && ui.button("Ungroup").clicked() {
            actions.push(TreeAction::Ungroup(path.clone()));
            ui.close();
        }
        if item.kind.can_hide() && ui.button(if item.hidden { "Show" } else { "Hide" }).clicked() {
            actions.push(TreeAction::Hide(path.clone(), !item.hidden));
            ui.close();
        }
        if let (ItemKind::Object, Some(name), Some(open)) = (item.kind, &item.name, &self.open) {
            let is_locked = open.locked.contains(name);
            if ui.button(if is_locked { "Unlock" } else { "Lock" }).clicked() {
                actions.push(TreeAction::Lock(name.clone(), !is_locked));
                ui.close();
            }
        }
        let index = path.index();
        let first = usize::from(path.parent().is_none());
        if index > first && ui.button("Move up").clicked() {
            actions.push(TreeAction::Move(path.clone(), path.parent(), index - 1));
            ui.close();
        }
        if index + 1 < self.siblings(path) && ui.button("Move down").clicked() {
            actions.push(TreeAction::Move(path.clone(), path.parent(), index + 1));
            ui.close();
        }
        ui.separator();
        if ui.button("Delete").clicked() {
            actions.push(TreeAction::Delete(path.clone()));
            ui.close();
        }
    }

    /// Selects the rows between the active one and another, which becomes active.
    fn select_rows_to(&mut self, path: Path) {
        let Some(open) = &self.open else { return };
        let search = open.tree_search.clone();
        let mut rows = Vec::new();
        open.document.outline().iter().for_each(|item| gather(&open.collapsed, &search, item, 0, &mut rows));
        let row_of = |wanted: &Path| rows.iter().position(|row| row.item.path == *wanted);
        let from = open.view.selection.active().and_then(row_of);
        let (Some(from), Some(to)) = (from, row_of(&path)) else { return self.select(Some(path)) };
        let mut paths: Vec<Path> = rows[from.min(to)..=from.max(to)].iter().map(|row| row.item.path.clone()).collect();
        if to < from {
            paths.reverse();
        }
        self.select_all(paths);
    }

    /// Number of siblings of a node, itself included.
    fn siblings(&self, path: &Path) -> usize {
        let Some(open) = &self.open else { return 0 };
        match path.parent() {
            Some(parent) => open.document.item(&parent).map_or(0, |item| item.children.len()),
            None => open.document.outline().len(),
        }
    }

    fn apply_action(&mut self, action: TreeAction) {
        match action {
            TreeAction::Select(path) => self.select(Some(path)),
            TreeAction::GiveMaterial(path, material) => self.give_material(&[path], &material),
            TreeAction::Toggle(path) => {
                if let Some(open) = &mut self.open {
                    open.view.selection.toggle(&open.document, path);
                }
            }
            TreeAction::SelectTo(path) => self.select_rows_to(path),
            TreeAction::Expand(path, is_expanded) => {
                if let Some(open) = &mut self.open {
                    open.collapsed.retain(|collapsed| *collapsed != path);
                    if !is_expanded {
                        open.collapsed.push(path);
                    }
                }
            }
            TreeAction::Add(parent, addition) => {
                let path = self.edit(|open| open.document.add(parent.as_ref(), &addition));
                self.select(path);
            }
            TreeAction::Rename(path, name) => drop(self.edit(|open| open.document.rename(&path, &name))),
            TreeAction::Duplicate(path) => {
                let path = self.edit(|open| open.document.duplicate(&path));
                self.select(path);
            }
            TreeAction::Delete(path) => drop(self.edit(|open| open.document.remove(&path))),
            TreeAction::Group(path, operator) => {
                let path = self.edit(|open| open.document.group(&[path], operator));
                self.select(path);
            }
            TreeAction::Combine(operator) => self.combine(operator),
            TreeAction::Ungroup(path) => {
                let paths = self.edit(|open| open.document.ungroup(&path));
                self.select(paths.and_then(|paths| paths.into_iter().next()));
            }
            TreeAction::Hide(path, hidden) => self.set_hidden(vec![path], hidden),
            TreeAction::Lock(name, locked) => {
                let Some(open) = &mut self.open else { return };
                if locked {
                    open.locked.insert(name);
                } else {
                    open.locked.remove(&name);
                }
            }
            TreeAction::Move(path, parent, index) => {
                let path = self.edit(|open| open.document.move_to(&path, parent.as_ref(), index));
                self.select(path);
            }
        }
    }
}

fn path_is_top(path: &Path) -> bool {
    path.indexes().len() == 1
}

/// Draws the sign of a lock.
fn lock(painter: &egui::Painter, at: Pos2, colour: Color32) {
    painter.rect_filled(Rect::from_center_size(at + Vec2::new(0.0, 2.0), Vec2::new(8.0, 6.0)), 1.0, colour);
    painter.circle_stroke(at + Vec2::new(0.0, -1.5), 2.5, Stroke::new(1.2, colour));
}

/// Disclosure triangle: down if expanded, else right.
fn triangle(centre: Pos2, is_expanded: bool, colour: Color32) -> egui::Shape {
    let points =
        if is_expanded { [(-4.0, -2.5), (4.0, -2.5), (0.0, 3.5)] } else { [(-2.5, -4.0), (3.5, 0.0), (-2.5, 4.0)] };
    let points = points.map(|(x, y)| centre + Vec2::new(x, y)).to_vec();
    egui::Shape::convex_polygon(points, colour, Stroke::NONE)
}

/// Label of a row.
fn label(item: &Item) -> String {
    match (&item.name, item.kind) {
        (Some(name), ItemKind::Camera) => format!("camera {name}"),
        (Some(name), _) => name.clone(),
        (None, ItemKind::Version) => "version".to_owned(),
        (None, _) => item.word.clone(),
    }
}

/// True if an item or something in it contains the search text in its word, name or material.
fn is_found(search: &str, item: &Item) -> bool {
    let wanted = search.trim().to_lowercase();
    let texts = [Some(&item.word), item.name.as_ref(), item.material.as_ref()];
    wanted.is_empty()
        || texts.into_iter().flatten().any(|text| text.to_lowercase().contains(&wanted))
        || item.children.iter().any(|child| is_found(search, child))
}

/// Draws the sign of a node's kind: a disc for a shape, a ring for an operator, a square for an object, a filled
/// triangle for a camera, a star of rays for a light, and a half disc for a material.
fn sign(painter: &egui::Painter, at: Pos2, kind: ItemKind, colour: Color32) {
    let stroke = Stroke::new(1.5, colour);
    match kind {
        ItemKind::Shape | ItemKind::Instance => {
            painter.circle_filled(at, 3.5, colour);
        }
        ItemKind::Operator => {
            painter.circle_stroke(at, 3.5, stroke);
        }
        ItemKind::Object | ItemKind::Declaration | ItemKind::Field => {
            painter.rect_filled(Rect::from_center_size(at, Vec2::splat(7.0)), 1.0, colour);
        }
        ItemKind::Camera => {
            painter.add(triangle(at, false, colour));
        }
        ItemKind::Sun | ItemKind::Point | ItemKind::Spot | ItemKind::Sky | ItemKind::Fog => {
            for turn in 0..3 {
                let out = Vec2::angled(std::f32::consts::PI / 3.0 * turn as f32) * 4.5;
                painter.line_segment([at - out, at + out], stroke);
            }
        }
        ItemKind::Material => {
            painter.circle_stroke(at, 3.5, stroke);
            painter.circle_filled(at + Vec2::new(1.0, 1.0), 2.0, colour);
        }
        _ => {}
    }
}

/// Collects the rows of an item and of its visible children.
fn gather<'a>(collapsed: &[Path], search: &str, item: &'a Item, depth: usize, rows: &mut Vec<Row<'a>>) {
    if item.kind == ItemKind::Version || !is_found(search, item) {
        return;
    }
    // A search looks into collapsed nodes, too.
    let is_expanded = (!item.children.is_empty()).then(|| !search.trim().is_empty() || !collapsed.contains(&item.path));
    rows.push(Row { depth, item, is_expanded });
    if is_expanded == Some(true) {
        for child in &item.children {
            gather(collapsed, search, child, depth + 1, rows);
        }
    }
}

fn rename(ui: &mut Ui, body: Rect, row_id: egui::Id, item: &Item, mut typed: String, actions: &mut Vec<TreeAction>) {
    let edit = ui.put(body, egui::TextEdit::singleline(&mut typed).id(row_id.with("name")));
    edit.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "New name"));
    if !edit.has_focus() && !edit.lost_focus() {
        edit.request_focus();
    }
    if edit.lost_focus() {
        ui.data_mut(|data| data.remove_temp::<String>(row_id));
        let cancelled = ui.input(|input| input.key_pressed(egui::Key::Escape));
        if !cancelled && item.name.as_deref() != Some(typed.as_str()) {
            actions.push(TreeAction::Rename(item.path.clone(), typed));
        }
    } else {
        ui.data_mut(|data| data.insert_temp(row_id, typed));
    }
}

/// Drags a row to another place: between rows, or into an object or operator.
fn drag(ui: &Ui, response: &Response, item: &Item, actions: &mut Vec<TreeAction>) {
    if response.drag_started() {
        response.dnd_set_drag_payload(item.path.clone());
    }
    if (item.kind == ItemKind::Object || item.kind.is_solid())
        && response.dnd_hover_payload::<DraggedMaterial>().is_some()
    {
        let stroke = Stroke::new(2.0, ui.visuals().selection.stroke.color);
        ui.painter().rect_stroke(response.rect, 3.0, stroke, egui::StrokeKind::Inside);
        if let Some(material) = response.dnd_release_payload::<DraggedMaterial>() {
            actions.push(TreeAction::GiveMaterial(item.path.clone(), (*material).clone()));
        }
    }
    let Some(dragged) = response.dnd_hover_payload::<Path>() else { return };
    let Some(pointer) = ui.input(|input| input.pointer.hover_pos()) else { return };
    if item.path.is_within(&dragged) {
        return;
    }
    let rect = response.rect;
    let height = (pointer.y - rect.min.y) / rect.height();
    let accepts = item.kind.holds_shapes();
    let into = accepts && (0.25..0.75).contains(&height);
    let stroke = Stroke::new(2.0, ui.visuals().selection.stroke.color);
    if into {
        ui.painter().rect_stroke(rect, 3.0, stroke, egui::StrokeKind::Inside);
    } else {
        ui.painter().hline(rect.x_range(), if height < 0.5 { rect.min.y } else { rect.max.y }, stroke);
    }
    if response.dnd_release_payload::<Path>().is_some() {
        let target = if into {
            (Some(item.path.clone()), usize::MAX)
        } else {
            let before = item.path.index() + usize::from(height >= 0.5);
            // Removing the dragged row shifts the rows after it.
            let own = dragged.is_sibling_of(&item.path) && dragged.index() < before;
            (item.path.parent(), before - usize::from(own))
        };
        actions.push(TreeAction::Move((*dragged).clone(), target.0, target.1));
    }
}
