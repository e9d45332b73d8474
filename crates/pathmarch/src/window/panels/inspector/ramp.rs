//! Colour ramp: a bar on which colours are added, dragged to another place and removed.

use egui::{Color32, Mesh, Pos2, Rect, Response, Rgba, Sense, Shape, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_scene::document::{Path, Ramp};
use pathmarch_render::pathmarch_scene::textures::ramp as colour_at;

/// Size of the bar, and height of the marks below it, points.
const BAR: Vec2 = Vec2::new(190.0, 16.0);
const MARK: f32 = 9.0;
/// Vertices along the bar.
const COLUMNS: u32 = 48;

/// A change of a ramp.
pub(super) enum RampChange {
    /// Adds a colour, which then has this index.
    Add(usize, [f32; 3]),
    Remove(usize),
    /// Moves a colour to another index.
    Move(usize, usize),
}

/// Place of a colour on the bar.
fn place(bar: Rect, index: usize, count: usize) -> Pos2 {
    let share = if count < 2 { 0.5 } else { index as f32 / (count - 1) as f32 };
    Pos2::new(egui::lerp(bar.x_range(), share), bar.max.y)
}

/// The colour whose mark is nearest to the pointer.
fn nearest(bar: Rect, count: usize, at: Pos2) -> usize {
    let share = ((at.x - bar.min.x) / bar.width()).clamp(0.0, 1.0);
    (share * count.saturating_sub(1) as f32).round() as usize
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
    let mut mesh = Mesh::default();
    for column in 0..=COLUMNS {
        let share = column as f32 / COLUMNS as f32;
        let x = egui::lerp(bar.x_range(), share);
        for y in [bar.min.y, bar.max.y] {
            mesh.colored_vertex(Pos2::new(x, y), shown(colour_at(&ramp.colours, share)));
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
        let index = nearest(bar, count, at);
        ((at.x - place(bar, index, count).x).abs() <= 0.7 * MARK).then_some(index)
    };
    if response.drag_started()
        && let Some(index) = ui.input(|input| input.pointer.press_origin()).and_then(on_mark)
    {
        ui.data_mut(|data| data.insert_temp(held, index));
    }
    let dragged = ui.data(|data| data.get_temp::<usize>(held)).filter(|index| *index < count);
    if let (Some(index), Some(at), true) = (dragged, at, response.dragged()) {
        let to = nearest(bar, count, at);
        if to != index {
            ui.data_mut(|data| data.insert_temp(held, to));
            change = Some(RampChange::Move(index, to));
        }
    }
    if !response.dragged() {
        ui.data_mut(|data| data.remove_temp::<usize>(held));
    }
    let (clicked, removed) = (response.clicked(), response.secondary_clicked());
    match at.or(response.hover_pos()).map(|at| (at, on_mark(at))) {
        Some((_, Some(index))) if removed && count > 1 => change = Some(RampChange::Remove(index)),
        Some((at, None)) if clicked => {
            let share = ((at.x - bar.min.x) / bar.width()).clamp(0.0, 1.0);
            let colour = colour_at(&ramp.colours, share).map(|v| (v * 1e3).round() / 1e3);
            let before = (share * count.saturating_sub(1) as f32).floor() as usize;
            change = Some(RampChange::Add(before + 1, colour));
        }
        _ => {}
    }
    let marked = dragged.or_else(|| response.hover_pos().and_then(on_mark));
    for (index, colour) in ramp.colours.iter().enumerate() {
        let tip = place(bar, index, count);
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
