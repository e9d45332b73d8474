//! Dots on the faces of a shape that change its sizes, for example the radius of a lamp.
//!
//! **Idea.** No shape is known here: a length of a shape changes the sides of its bounds, and its dot is on the side that
//! it moves most. The rate at which it moves that side, a difference quotient, turns a movement of the dot into one of the
//! length.

use super::dots::{Dot, DotId, Way};
use super::transform::{Transform, local_transform, parent_transform, present_number, round_to};
use egui::Color32;
use glam::{DMat3, DQuat, DVec3};
use pathmarch_render::pathmarch_field::{Aabb, Param, Solid, Unit, registry};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value};
use std::borrow::Cow;

/// Least rate at which a length moves a side.
const LEAST_RATE: f64 = 1e-2;
/// Colours of the dots along x, y and z.
const COLOURS: [Color32; 3] =
    [Color32::from_rgb(255, 90, 150), Color32::from_rgb(90, 255, 150), Color32::from_rgb(90, 160, 255)];

/// A length that can be dragged.
struct Size {
    param: &'static Param,
    value: f64,
    /// Local axis of the side that it moves, and movement of the side per metre of the length.
    axis: usize,
    rate: f64,
}

/// Lengths of the selected shape.
pub(super) struct Sizes {
    sizes: Vec<Size>,
    bounds: Aabb,
    world: Transform,
}

impl Sizes {
    /// The lengths of a shape with finite bounds.
    pub(super) fn of(document: &Document, scene: &Scene, path: &Path) -> Option<Self> {
        let item = document.item(path).filter(|item| item.kind == ItemKind::Shape)?;
        let Some(Solid::Shape(shape)) = registry::solid(&item.word) else { return None };
        if shape.info().outline.is_some() {
            return None;
        }
        let number = |param: &Param| present_number(document, path, &param.name).map(|value| value as f32);
        let values: Vec<f32> = shape.params().iter().map(number).collect::<Option<_>>()?;
        let bounds = shape.bounds(&values);
        if !bounds.is_finite() || bounds.is_empty() {
            return None;
        }
        let mut sizes: Vec<Size> = Vec::new();
        for (index, param) in shape.params().iter().enumerate().filter(|(_, param)| param.unit == Unit::Metres) {
            let step = (1e-2 * values[index]).max(1e-3);
            let mut larger = values.clone();
            larger[index] += step;
            let grown = shape.bounds(&larger);
            let rates = [0, 1, 2].map(|axis| f64::from((grown.max[axis] - bounds.max[axis]) / step));
            // A side that no other length has taken yet, if there is one.
            let is_free = |axis: usize| sizes.iter().all(|size| size.axis != axis);
            let movable = [0, 1, 2].into_iter().filter(|axis| rates[*axis].abs() > LEAST_RATE && is_free(*axis));
            let Some(axis) = movable.min_by(|a, b| rates[*b].abs().total_cmp(&rates[*a].abs())) else { continue };
            sizes.push(Size { param, value: f64::from(values[index]), axis, rate: rates[axis] });
        }
        let world = world_transform(document, scene, path);
        (!sizes.is_empty()).then_some(Self { sizes, bounds, world })
    }

    /// Middle of the side that a length moves.
    fn place(&self, size: &Size) -> DVec3 {
        let middle = |axis: usize| 0.5 * f64::from(self.bounds.min[axis] + self.bounds.max[axis]);
        let mut local = DVec3::from_array([0, 1, 2].map(middle));
        local[size.axis] = f64::from(self.bounds.max[size.axis]);
        self.world.translation + self.world.rotation * (self.world.scale * local)
    }

    pub(super) fn dots(&self) -> Vec<Dot> {
        let dot = |(index, size): (usize, &Size)| {
            let axis = self.world.rotation * DVec3::AXES[size.axis];
            Dot { id: DotId::Size(index), at: self.place(size), way: Way::Line(axis), colour: COLOURS[size.axis] }
        };
        self.sizes.iter().enumerate().map(dot).collect()
    }

    /// Parameter and value with which a dot is at this point. With `snapping`, a multiple of 0.1 m.
    pub(super) fn change(&self, index: usize, at: DVec3, snapping: bool) -> Option<(Cow<'static, str>, Value)> {
        let size = self.sizes.get(index)?;
        let axis = self.world.rotation * DVec3::AXES[size.axis];
        let by = (at - self.place(size)).dot(axis) / self.world.scale / size.rate;
        let step = if snapping { 0.1 } else { 1e-3_f64.min(10_f64.powf(size.value.max(1e-6).log10().floor() - 2.0)) };
        let least = if size.param.range.accepts(0.0) { 0.0 } else { step };
        let value = round_to((size.value + by).max(least), step).max(least as f32);
        size.param.range.accepts(value).then(|| (size.param.name.clone(), Value::Number(value)))
    }
}

/// World transform of a shape, with its `normal`.
fn world_transform(document: &Document, scene: &Scene, path: &Path) -> Transform {
    let leaf = document.leaves_of(path).first().and_then(|leaf| scene.field.leaves().get(*leaf));
    match leaf.filter(|leaf| !leaf.modified && leaf.copy_of.is_none()) {
        Some(leaf) => {
            let axes = leaf.pose.axes.map(|axis| DVec3::from_array(axis.map(f64::from)));
            Transform {
                scale: f64::from(leaf.pose.scale),
                rotation: DQuat::from_mat3(&DMat3::from_cols(axes[0], axes[1], axes[2])).normalize(),
                translation: DVec3::from_array(leaf.pose.at.map(f64::from)),
            }
        }
        None => parent_transform(document, path).then_local(local_transform(document, path)),
    }
}
