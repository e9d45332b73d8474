//! Palette of materials: those of the scene and presets, to be dragged onto shapes.

use super::inspector::LEAST_WINDOW;
use crate::window::app::App;
use crate::window::material_balls::Shown;
use egui::{Align2, Color32, Context, FontId, Rect, Response, Sense, Stroke, Ui, Vec2};
use pathmarch_render::pathmarch_scene::document::{ItemKind, PRESETS, Path};

/// Side of a ball in the palette, points.
const BALL: f32 = 56.0;
/// Side of the ball beside the controls of a material, points.
const LARGE_BALL: f32 = 72.0;

/// Material that is dragged from the palette.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DraggedMaterial {
    /// Name of a material of the scene.
    Scene(String),
    /// Name of a preset.
    Preset(&'static str),
}

impl App {
    pub(crate) fn material_palette(&mut self, ctx: &Context) {
        let mut is_open = self.palette;
        if !is_open || self.open.is_none() {
            return;
        }
        let screen = ctx.content_rect();
        let window = egui::Window::new("Materials").open(&mut is_open).default_width(4.0 * (BALL + 12.0)).vscroll(true);
        let window = window.default_height((screen.height() - 160.0).clamp(120.0, 420.0));
        // In a narrow window, where properties float, it leaves their title free.
        let is_narrow = screen.width() < LEAST_WINDOW;
        let place = if is_narrow { screen.left_top() } else { screen.right_top() - Vec2::new(308.0, 0.0) };
        window.default_pos(place + Vec2::new(6.0, 34.0)).show(ctx, |ui| {
            ui.weak("Drag a material onto a shape, or click it to give it to the selection.");
            let names: Vec<String> = self
                .open
                .iter()
                .flat_map(|open| open.document.outline())
                .filter(|item| item.kind == ItemKind::Material)
                .filter_map(|item| item.name.clone())
                .collect();
            ui.strong("This scene");
            ui.horizontal_wrapped(|ui| {
                for name in names {
                    self.palette_entry(ui, &name, DraggedMaterial::Scene(name.clone()));
                }
            });
            ui.strong("Presets");
            ui.horizontal_wrapped(|ui| {
                for preset in PRESETS {
                    self.palette_entry(ui, preset.name, DraggedMaterial::Preset(preset.name));
                }
            });
        });
        self.palette = is_open;
        // The dragged ball follows the pointer.
        if let (Some(dragged), Some(at)) =
            (egui::DragAndDrop::payload::<DraggedMaterial>(ctx), ctx.input(|input| input.pointer.latest_pos()))
        {
            let rect = Rect::from_center_size(at, Vec2::splat(0.6 * BALL));
            let painter =
                ctx.layer_painter(egui::LayerId::new(egui::Order::Tooltip, egui::Id::unique("dragged material")));
            match self.ball(ctx, &dragged) {
                Some(ball) => drop(painter.image(ball, rect, UNIT, Color32::WHITE)),
                None => drop(painter.circle_filled(rect.center(), 10.0, Color32::GRAY)),
            }
        }
    }

    fn palette_entry(&mut self, ui: &mut Ui, name: &str, material: DraggedMaterial) {
        let (rect, response) = ui.allocate_exact_size(Vec2::new(BALL + 4.0, BALL + 18.0), Sense::click_and_drag());
        let kind = if matches!(material, DraggedMaterial::Scene(_)) { "Material" } else { "Preset" };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{kind} {name}")));
        let picture = Rect::from_min_size(rect.min + Vec2::splat(2.0), Vec2::splat(BALL));
        self.draw_ball(ui, picture, &material);
        if response.hovered() {
            ui.painter().rect_stroke(picture, 4.0, ui.visuals().selection.stroke, egui::StrokeKind::Outside);
        }
        let font = FontId::proportional(11.0);
        let at = rect.center_bottom();
        let painter = ui.painter_at(rect);
        painter.text(at, Align2::CENTER_BOTTOM, name, font, ui.visuals().text_color());
        if response.drag_started() {
            response.dnd_set_drag_payload(material.clone());
        }
        if response.on_hover_text(name).clicked() {
            let paths = self.open.as_ref().map_or(&[][..], |open| open.view.selection.paths()).to_vec();
            if paths.is_empty() {
                self.show_message("Select a shape or an object first, or drag the material onto one.");
            } else {
                self.give_material(&paths, &material);
            }
        }
    }

    /// Draws the ball of a material of the scene, beside its controls.
    pub(crate) fn ball_of(&mut self, ui: &mut Ui, name: &str) {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(LARGE_BALL), Sense::hover());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Preview of {name}")));
        self.draw_ball(ui, rect, &DraggedMaterial::Scene(name.to_owned()));
    }

    fn draw_ball(&mut self, ui: &Ui, rect: Rect, material: &DraggedMaterial) {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        if ui.is_rect_visible(rect)
            && let Some(ball) = self.ball(ui.ctx(), material)
        {
            ui.painter().image(ball, rect, UNIT, Color32::WHITE);
        }
    }

    /// Picture of a material, if it has been rendered.
    fn ball(&mut self, ctx: &Context, material: &DraggedMaterial) -> Option<egui::TextureId> {
        let ball = match material {
            DraggedMaterial::Preset(name) => {
                let preset = PRESETS.iter().find(|preset| preset.name == *name)?;
                let place = format!("preset {name}");
                self.material_balls.get(ctx, &self.waker, &place, preset.text(), || Shown::Preset(preset))
            }
            DraggedMaterial::Scene(name) => {
                let open = self.open.as_ref()?;
                let scene = open.document.last_good()?;
                let found = scene.materials.iter().find(|material| material.name == *name)?;
                let is_it = |item: &&pathmarch_render::pathmarch_scene::document::Item| {
                    item.kind == ItemKind::Material && item.name.as_ref() == Some(name)
                };
                let path = &open.document.outline().iter().find(is_it)?.path;
                // Parameters and formulas change the values, and textures the text.
                let text = format!("{:?} {}", found.values, open.document.text_of(path).unwrap_or_default());
                let place = format!("scene {name}");
                self.material_balls.get(ctx, &self.waker, &place, &text, || Shown::Scene(Box::new(found.clone())))
            }
        };
        ball.map(|ball| ball.id())
    }

    /// Gives nodes a material, in one undo step.
    pub(crate) fn give_material(&mut self, paths: &[Path], material: &DraggedMaterial) {
        self.undo_group += 1;
        let undo_group = Some(self.undo_group);
        match material {
            DraggedMaterial::Scene(name) => {
                for path in paths {
                    if self.edit(|open| open.document.set_material_in(path, Some(name), undo_group)).is_none() {
                        return;
                    }
                }
            }
            DraggedMaterial::Preset(name) => {
                self.edit(|open| open.document.give_preset(paths, name));
            }
        }
    }

    /// Gives the shape under the pointer the material that is dropped on the picture. `target` finds it.
    pub(crate) fn drop_material(
        &mut self,
        ui: &Ui,
        response: &Response,
        target: impl Fn(&Self) -> Option<(Path, Rect)>,
    ) {
        if response.dnd_hover_payload::<DraggedMaterial>().is_none() {
            return;
        }
        let found = target(self);
        if let Some((_, rect)) = &found {
            let stroke = Stroke::new(2.0, ui.visuals().selection.stroke.color);
            ui.painter().rect_stroke(*rect, 3.0, stroke, egui::StrokeKind::Outside);
        }
        if let Some(material) = response.dnd_release_payload::<DraggedMaterial>() {
            match found {
                Some((path, _)) => self.give_material(&[path], &material),
                None => self.show_message("There is no shape here."),
            }
        }
    }
}

/// The whole of a texture.
const UNIT: Rect = Rect { min: egui::Pos2::ZERO, max: egui::Pos2::new(1.0, 1.0) };
