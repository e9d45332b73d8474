//! Colour ramp: a bar on which colours are added, dragged to another place and removed.

use egui::{Color32, Mesh, Pos2, Rect, Response, Rgba, Sense, Shape, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_scene::document::{Path, Ramp};

/// Size of the bar, and height of the marks below it, points.
const BAR: Vec2 = Vec2::new(190.0, 16.0);
const MARK: f32 = 9.0;
/// Vertices along the bar.
const COLUMNS: u32 = 48;

/// A change of a ramp.
pub(super) enum RampChange {
    /// Adds a colour at a position.
    Add([f32; 3], f32),
    Remove(usize),
    /// Moves a colour to another position.
    Place(usize, f32),
}

/// Place of a position on the bar.
fn place(bar: Rect, position: f32) -> Pos2 {
    Pos2::new(egui::lerp(bar.x_range(), position), bar.max.y)
}

/// Position of a place on the bar, to three decimals.
fn position(bar: Rect, at: Pos2) -> f32 {
    (((at.x - bar.min.x) / bar.width()).clamp(0.0, 1.0) * 1e3).round() / 1e3
}

/// Draws the bar of a ramp with colours; returns a change.
pub(super) fn bar(ui: &mut Ui, path: &Path, ramp: &Ramp, label: &Response) -> Option<RampChange> {
    let count = ramp.colours.len();
    // A grid does not know how much room is left in its last column.
    let room = ui.clip_rect().max.x - ui.cursor().min.x - 2.0 * MARK;
    let size = Vec2::new(BAR.x.min(room).max(40.0), BAR.y);
    let (rect, response) = ui.allocate_exact_size(size + Vec2::new(MARK, MARK), Sense::click_and_drag());
    let name = format!("{} ramp", ramp.name);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name.clone()));
    let response = response.labelled_by(label.id);
    let bar = Rect::from_min_size(rect.min + Vec2::new(0.5 * MARK, 0.0), size);
    let gradient = ramp.gradient();
    let mut mesh = Mesh::default();
    for column in 0..=COLUMNS {
        let share = column as f32 / COLUMNS as f32;
        let x = egui::lerp(bar.x_range(), share);
        for y in [bar.min.y, bar.max.y] {
            mesh.colored_vertex(Pos2::new(x, y), shown(gradient.colour(share)));
        }
        if column > 0 {
            let first = 2 * (column - 1);
            mesh.add_triangle(first, first + 1, first + 2);
            mesh.add_triangle(first + 1, first + 2, first + 3);
        }
    }
    ui.painter().add(Shape::mesh(mesh));

    let held = ui.scope_id().with(("ramp", path, &ramp.name));
    let mut change = None;
    let at = response.interact_pointer_pos();
    let on_mark = |at: Pos2| {
        let distance = |index: &usize| (at.x - place(bar, ramp.positions[*index]).x).abs();
        let nearest = (0..count).rev().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(&nearest) <= 0.7 * MARK).then_some(nearest)
    };
    if response.drag_started()
        && let Some(index) = ui.input(|input| input.pointer.press_origin()).and_then(on_mark)
    {
        ui.data_mut(|data| data.insert_temp(held, index));
    }
    let dragged = ui.data(|data| data.get_temp::<usize>(held)).filter(|index| *index < count);
    if let (Some(index), Some(at), true) = (dragged, at, response.dragged()) {
        let to = position(bar, at);
        if to != ramp.positions[index] {
            change = Some(RampChange::Place(index, to));
        }
    }
    if !response.dragged() {
        ui.data_mut(|data| data.remove_temp::<usize>(held));
    }
    let (clicked, removed) = (response.clicked(), response.secondary_clicked());
    match at.or(response.hover_pos()).map(|at| (at, on_mark(at))) {
        Some((_, Some(index))) if removed && count > 1 => change = Some(RampChange::Remove(index)),
        Some((at, None)) if clicked => {
            let at = position(bar, at);
            change = Some(RampChange::Add(gradient.colour(at).map(|v| (v * 1e3).round() / 1e3), at));
        }
        _ => {}
    }
    let marked = dragged.or_else(|| response.hover_pos().and_then(on_mark));
    for (index, colour) in ramp.colours.iter().enumerate() {
        let tip = place(bar, ramp.positions[index]);
        let half = 0.45 * MARK;
        let corners = vec![tip, tip + Vec2::new(half, MARK), tip + Vec2::new(-half, MARK)];
        let stroke = if marked == Some(index) { Color32::WHITE } else { ui.visuals().text_color() };
        ui.painter().add(Shape::convex_polygon(corners, shown(*colour), Stroke::new(1.0, stroke)));
    }
    response.on_hover_text("Click to add a colour, drag a mark to move it, right click on a mark to remove it.");
    change
}

fn shown([r, g, b]: [f32; 3]) -> Color32 {
    Rgba::from_rgb(r, g, b).into()
}
