//! The scene as a tree: select, rename, add, remove, move.
//!
//! Only the rows that are in sight are built, so that ten thousand objects cost no more than ten.

use super::app::App;
use super::inspector::heading;
use egui::{Align2, Color32, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_field::registry::solids;
use pathmarch_render::pathmarch_scene::document::{Addition, Group, Item, ItemKind, Path};
use std::collections::BTreeMap;

/// Points of a level.
const INDENT: f32 = 16.0;

/// A row in sight.
struct Row<'a> {
    depth: usize,
    item: &'a Item,
    /// Whether its children are shown; none where it has none.
    is_open: Option<bool>,
}

/// What a person asks of the tree.
enum Ask {
    Select(Path),
    Open(Path, bool),
    Add(Option<Path>, Addition),
    Rename(Path, String),
    Duplicate(Path),
    Delete(Path),
    Group(Path, &'static str),
    Ungroup(Path),
    Move(Path, Option<Path>, usize),
}

impl App {
    pub(super) fn tree_panel(&mut self, ui: &mut Ui) {
        let most = (0.27 * ui.ctx().content_rect().width()).clamp(100.0, 480.0);
        let panel = egui::Panel::left("tree").default_size(235.0_f32.min(most)).min_size(100.0).max_size(most);
        panel.show(ui, |ui| {
            let mut asks = Vec::new();
            ui.horizontal(|ui| {
                ui.heading("Scene");
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.menu_button("Add…", |ui| self.add_menu(ui, None, &mut asks))
                        .response
                        .on_hover_text("Add an object, a material, a light or a camera.");
                });
            });
            ui.separator();
            self.rows(ui, &mut asks);
            for ask in asks {
                self.do_ask(ask);
            }
        });
    }

    /// What may be added to a node, or to the scene.
    fn add_menu(&self, ui: &mut Ui, parent: Option<&Path>, asks: &mut Vec<Ask>) {
        let Some(open) = &self.open else { return };
        let mut groups: BTreeMap<Group, Vec<Addition>> = BTreeMap::new();
        for addition in open.document.additions(parent) {
            groups.entry(addition.group).or_default().push(addition);
        }
        for (group, additions) in groups {
            ui.menu_button(group.name(), |ui| {
                egui::ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
                    for addition in additions {
                        if ui.button(addition.name).on_hover_text(addition.doc).clicked() {
                            asks.push(Ask::Add(parent.cloned(), addition));
                            ui.close();
                        }
                    }
                });
            });
        }
    }

    fn rows(&self, ui: &mut Ui, asks: &mut Vec<Ask>) {
        let Some(open) = &self.open else { return };
        let mut rows = Vec::new();
        let id = ui.scope_id();
        for item in open.document.outline() {
            gather(&open.folded, item, 0, &mut rows);
        }
        let selection = open.view.selection.clone();
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
                self.row(ui, id, row, selection.as_ref() == Some(&row.item.path), asks);
            }
        });
        let top = shown.state.clamped_offset().y;
        ui.data_mut(|data| data.insert_temp(id.with("sight"), (top, top + shown.inner_rect.height())));
    }

    fn row(&self, ui: &mut Ui, id: egui::Id, row: &Row<'_>, selected: bool, asks: &mut Vec<Ask>) {
        let Row { depth, item, is_open } = row;
        let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let indent = 4.0 + INDENT * *depth as f32;
        let row_id = id.with(("row", &item.path));
        if let Some(is_open) = is_open {
            let arrow = Rect::from_min_size(rect.min + Vec2::new(indent, 0.0), Vec2::new(INDENT, size.y));
            let response = ui.interact(arrow, row_id.with("arrow"), Sense::click());
            let colour = ui.style().interact(&response).fg_stroke.color;
            ui.painter().add(triangle(arrow.center(), *is_open, colour));
            let what = if *is_open { "Close" } else { "Open" };
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{what} {}", heading(item)))
            });
            if response.clicked() {
                asks.push(Ask::Open(item.path.clone(), !is_open));
            }
        }
        let body = Rect::from_min_max(rect.min + Vec2::new(indent + INDENT, 0.0), rect.max);
        let renaming = ui.data(|data| data.get_temp::<String>(row_id));
        if let Some(typed) = renaming {
            rename(ui, body, row_id, item, typed, asks);
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
        let at = Pos2::new(body.min.x + 4.0, body.center().y);
        let drawn = painter.text(at, Align2::LEFT_CENTER, label(item), font.clone(), visuals.text_color());
        if let Some(material) = &item.material {
            let at = Pos2::new(drawn.max.x + 7.0, body.center().y);
            painter.text(at, Align2::LEFT_CENTER, material, font, ui.visuals().weak_text_color());
        }
        if response.clicked() {
            asks.push(Ask::Select(item.path.clone()));
        }
        if response.double_clicked() {
            if item.name.is_some() {
                let name = item.name.clone().unwrap_or_default();
                ui.data_mut(|data| data.insert_temp(row_id, name));
            } else if let Some(is_open) = is_open {
                asks.push(Ask::Open(item.path.clone(), !is_open));
            }
        }
        drag(ui, &response, item, asks);
        response.context_menu(|ui| self.context_menu(ui, row_id, item, asks));
    }

    fn context_menu(&self, ui: &mut Ui, row_id: egui::Id, item: &Item, asks: &mut Vec<Ask>) {
        let path = &item.path;
        asks.push(Ask::Select(path.clone()));
        if item.kind.holds_shapes() {
            ui.menu_button("Add…", |ui| self.add_menu(ui, Some(path), asks));
        }
        let named = item.kind.is_named();
        if named && ui.button("Rename").clicked() {
            let name = item.name.clone().unwrap_or_default();
            ui.data_mut(|data| data.insert_temp(row_id, name));
            ui.close();
        }
        if ui.button("Duplicate").clicked() {
            asks.push(Ask::Duplicate(path.clone()));
            ui.close();
        }
        if item.kind.is_solid() {
            ui.menu_button("Group into", |ui| {
                for operator in solids().filter(|solid| solid.is_operator()) {
                    let info = operator.info();
                    if ui.button(&*info.name).on_hover_text(&*info.doc).clicked() {
                        asks.push(Ask::Group(path.clone(), &info.name));
                        ui.close();
                    }
                }
            });
        }
        if item.kind == ItemKind::Operator && ui.button("Ungroup").clicked() {
            asks.push(Ask::Ungroup(path.clone()));
            ui.close();
        }
        let index = path.index();
        let first = usize::from(path.parent().is_none());
        if index > first && ui.button("Move up").clicked() {
            asks.push(Ask::Move(path.clone(), path.parent(), index - 1));
            ui.close();
        }
        if index + 1 < self.siblings(path) && ui.button("Move down").clicked() {
            asks.push(Ask::Move(path.clone(), path.parent(), index + 1));
            ui.close();
        }
        ui.separator();
        if ui.button("Delete").clicked() {
            asks.push(Ask::Delete(path.clone()));
            ui.close();
        }
    }

    /// How many nodes stand beside a node, and itself.
    fn siblings(&self, path: &Path) -> usize {
        let Some(open) = &self.open else { return 0 };
        match path.parent() {
            Some(parent) => open.document.item(&parent).map_or(0, |item| item.children.len()),
            None => open.document.outline().len(),
        }
    }

    fn do_ask(&mut self, ask: Ask) {
        match ask {
            Ask::Select(path) => self.select(Some(path)),
            Ask::Open(path, is_open) => {
                if let Some(open) = &mut self.open {
                    open.folded.retain(|folded| *folded != path);
                    if !is_open {
                        open.folded.push(path);
                    }
                }
            }
            Ask::Add(parent, addition) => {
                let path = self.edit(|open| open.document.add(parent.as_ref(), &addition));
                self.select(path);
            }
            Ask::Rename(path, name) => drop(self.edit(|open| open.document.rename(&path, &name))),
            Ask::Duplicate(path) => {
                let path = self.edit(|open| open.document.duplicate(&path));
                self.select(path);
            }
            Ask::Delete(path) => drop(self.edit(|open| open.document.remove(&path))),
            Ask::Group(path, operator) => {
                let path = self.edit(|open| open.document.group(&[path], operator));
                self.select(path);
            }
            Ask::Ungroup(path) => {
                let paths = self.edit(|open| open.document.ungroup(&path));
                self.select(paths.and_then(|paths| paths.into_iter().next()));
            }
            Ask::Move(path, parent, index) => {
                let path = self.edit(|open| open.document.move_to(&path, parent.as_ref(), index));
                self.select(path);
            }
        }
    }
}

/// Points down where what is in a row is shown, else to the right.
fn triangle(centre: Pos2, is_open: bool, colour: Color32) -> egui::Shape {
    let points =
        if is_open { [(-4.0, -2.5), (4.0, -2.5), (0.0, 3.5)] } else { [(-2.5, -4.0), (3.5, 0.0), (-2.5, 4.0)] };
    let points = points.map(|(x, y)| centre + Vec2::new(x, y)).to_vec();
    egui::Shape::convex_polygon(points, colour, Stroke::NONE)
}

/// What a row says.
fn label(item: &Item) -> String {
    match (&item.name, item.kind) {
        (Some(name), ItemKind::Camera) => format!("camera {name}"),
        (Some(name), _) => name.clone(),
        (None, ItemKind::Version) => "version".to_owned(),
        (None, _) => item.word.clone(),
    }
}

/// The rows of an item and of what is in it.
fn gather<'a>(folded: &[Path], item: &'a Item, depth: usize, rows: &mut Vec<Row<'a>>) {
    if item.kind == ItemKind::Version {
        return;
    }
    let is_open = (!item.children.is_empty()).then(|| !folded.contains(&item.path));
    rows.push(Row { depth, item, is_open });
    if is_open == Some(true) {
        for child in &item.children {
            gather(folded, child, depth + 1, rows);
        }
    }
}

fn rename(ui: &mut Ui, body: Rect, row_id: egui::Id, item: &Item, mut typed: String, asks: &mut Vec<Ask>) {
    let edit = ui.put(body, egui::TextEdit::singleline(&mut typed).id(row_id.with("name")));
    edit.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "New name"));
    if !edit.has_focus() && !edit.lost_focus() {
        edit.request_focus();
    }
    if edit.lost_focus() {
        ui.data_mut(|data| data.remove_temp::<String>(row_id));
        let cancelled = ui.input(|input| input.key_pressed(egui::Key::Escape));
        if !cancelled && item.name.as_deref() != Some(typed.as_str()) {
            asks.push(Ask::Rename(item.path.clone(), typed));
        }
    } else {
        ui.data_mut(|data| data.insert_temp(row_id, typed));
    }
}

/// Rows are dragged to other places: between others, or into objects and operators.
fn drag(ui: &Ui, response: &Response, item: &Item, asks: &mut Vec<Ask>) {
    if response.drag_started() {
        response.dnd_set_drag_payload(item.path.clone());
    }
    let Some(dragged) = response.dnd_hover_payload::<Path>() else { return };
    let Some(pointer) = ui.input(|input| input.pointer.hover_pos()) else { return };
    if item.path.is_within(&dragged) {
        return;
    }
    let rect = response.rect;
    let height = (pointer.y - rect.min.y) / rect.height();
    let holds = item.kind.holds_shapes() && dragged.parent().is_some();
    let into = holds && (0.25..0.75).contains(&height);
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
            // Its own place does not count once it is gone.
            let own = dragged.is_sibling_of(&item.path) && dragged.index() < before;
            (item.path.parent(), before - usize::from(own))
        };
        asks.push(Ask::Move((*dragged).clone(), target.0, target.1));
    }
}
