//! Textures at a surface interaction: parameters of the BSDF and the shading normal.
//!
//! **Bump maps.** The normal follows the slope of a height: n' = n - (∇h - n (n·∇h)), normalised (Blinn 1978, "Simulation of
//! Wrinkled Surfaces"; in this form Mikkelsen 2010). It is then turned back towards the geometric normal as far as needed for the
//! mirrored view to leave the surface, so that no mirror shows black (Schüßler et al. 2017, section 3, describe the problem;
//! Cycles turns the normal back, too). Light that scatters through the geometric surface to the wrong side is lost. Bump maps
//! change neither outlines nor shadows.
//!
//! **Space.** Textures are evaluated in the coordinates of the leaf ([`Field::coordinates`](pathmarch_field::Field::coordinates)).
//! A height scales with the shape. **Cost.** One evaluation for each texture, four for a bump map; nothing for materials without.

use crate::scene::TraceContext;
use crate::scene::preview_material::{PREVIEW_PARAMETERS, PreviewParameters, channel};
use crate::scene::textured_material::{Change, KNOTS, Source, TexturedMaterial};
use glam::Vec3;
use pathmarch_field::graph::Coordinates;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::Numbers;
use pathmarch_scene::textures::{Spot, ramp};

/// The two knots around a value, and its place between them.
fn interval<T>(knots: &[T], value: f32) -> (&T, &T, f32) {
    let place = value * (KNOTS - 1) as f32;
    let first = (place as usize).min(KNOTS - 2);
    (&knots[first], &knots[first + 1], place - first as f32)
}

/// Point on a textured surface.
pub(crate) struct TexturedPoint<'p> {
    material: &'p TexturedMaterial,
    spot: Spot,
    here: Coordinates,
    orbit: Option<[f32; 5]>,
    /// Local unit in world metres.
    size: f32,
}

impl<'p> TexturedPoint<'p> {
    /// The point `p` of a leaf, with its outward normal, at the end of a path of this length; `None` where the material has no
    /// textures.
    #[inline]
    pub(crate) fn new(ctx: &TraceContext<'p>, leaf: usize, p: Vec3, outward: Vec3, length: f32) -> Option<Self> {
        let scene = ctx.scene;
        let material = scene.textured_materials.get(scene.leaves[leaf].material as usize)?;
        if material.is_plain() {
            return None;
        }
        Self::textured(material, ctx, leaf, p, outward, length)
    }

    /// Separate, so that materials without textures cost no call.
    fn textured(
        material: &'p TexturedMaterial,
        ctx: &TraceContext,
        leaf: usize,
        p: Vec3,
        outward: Vec3,
        length: f32,
    ) -> Option<Self> {
        let p = FieldVec3::new(p.x, p.y, p.z);
        let here = ctx.scene.field.coordinates(leaf, p)?;
        let vector = |v: FieldVec3<f32>| Vec3::new(v.x, v.y, v.z);
        let [x, y, z] = here.gradients.map(vector);
        // Normals turn by the transposed inverse.
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let determinant = x.dot(cofactors[0]);
        let size = determinant.abs().max(1e-30).cbrt().recip();
        let across = Vec3::from_array(cofactors.map(|cofactor| cofactor.dot(outward)));
        let normal = (across * determinant.signum()).normalize_or(Vec3::Y);
        let covered = ctx.frame.pixel * length;
        let spot = Spot { p: vector(here.point), normal, footprint: covered / size };
        let orbit = if material.has_orbit() { ctx.scene.field.orbit(leaf, p) } else { None };
        Some(Self { material, spot, here, orbit, size })
    }

    /// Value of a source; `None` where it has none at this point.
    fn value(&self, source: &Source) -> Option<f32> {
        match source {
            Source::Orbit(trap) => self.orbit.as_ref().map(|orbit| trap.place(orbit)),
            Source::Texture(texture) => Some(texture.value(&self.spot)),
        }
    }

    fn colour_of(&self, source: &Source, ramp_colours: Option<&Vec<[f32; 3]>>) -> Option<Vec3> {
        match (ramp_colours, source) {
            (None, Source::Texture(texture)) => Some(texture.colour(&self.spot)),
            (Some(colours), _) => Some(ramp(colours, self.value(source)?).into()),
            (None, Source::Orbit(_)) => None,
        }
    }

    /// Parameters of the BSDF at this point.
    pub(crate) fn numbers(&self, numbers: &Numbers) -> Numbers {
        let mut own = *numbers;
        for layer in &self.material.layers {
            match &layer.change {
                Change::Colour { first, ramp } => {
                    if let Some(colour) = self.colour_of(&layer.source, ramp.as_ref()) {
                        own[*first..*first + 3].copy_from_slice(&colour.to_array());
                    }
                }
                Change::Parameters { indices, knots } => {
                    let Some(value) = self.value(&layer.source) else { continue };
                    let (a, b, part) = interval(knots, value);
                    for ((index, a), b) in indices.iter().zip(a).zip(b) {
                        own[*index] = a + (b - a) * part;
                    }
                }
            }
        }
        own
    }

    /// Colour of the material, its first parameter, where it varies.
    pub(crate) fn colour(&self) -> Option<Vec3> {
        let mut colours = self.material.layers.iter().filter_map(|layer| match &layer.change {
            Change::Colour { first: 0, ramp } => self.colour_of(&layer.source, ramp.as_ref()),
            _ => None,
        });
        colours.next_back()
    }

    /// Parameters of the preview material at this point.
    pub(crate) fn preview(&self, preview: PreviewParameters) -> PreviewParameters {
        let mut own = preview;
        for layer in &self.material.layers {
            match &layer.change {
                Change::Colour { ramp, .. } => {
                    let Some(colour) = self.colour_of(&layer.source, ramp.as_ref()) else { continue };
                    let change = colour - Vec3::from(layer.base);
                    (0..PREVIEW_PARAMETERS).for_each(|k| own[k] += layer.previews[0][k] * change[channel(k)]);
                }
                Change::Parameters { .. } => {
                    let Some(value) = self.value(&layer.source) else { continue };
                    let (a, b, part) = interval(&layer.previews, value);
                    (0..PREVIEW_PARAMETERS).for_each(|k| own[k] += a[k] + (b[k] - a[k]) * part);
                }
            }
        }
        own
    }

    /// Shading normal on the side of the geometric `normal`; `view` points away from the surface.
    pub(crate) fn normal(&self, outward: Vec3, normal: Vec3, view: Vec3) -> Vec3 {
        let Some(bump) = &self.material.bump else { return normal };
        let slope = bump.texture.slope(&self.spot) * bump.height;
        let [x, y, z] = self.here.gradients.map(|g| Vec3::new(g.x, g.y, g.z));
        let gradient = (x * slope.x + y * slope.y + z * slope.z) * self.size;
        let along = gradient - outward * outward.dot(gradient);
        let side = if normal.dot(outward) < 0.0 { -1.0 } else { 1.0 };
        visible_normal((outward - along).normalize() * side, normal, view)
    }
}

/// Normal nearest to `bent`, between it and the geometric normal, that mirrors the view to the side of the geometric one.
///
/// In the plane of both normals, with θ the angle between them, the view at φ from the geometric normal and |view| = A there, the
/// mirrored view is at 2θ - φ: it is at least t above the surface for cos(2θ - φ) ≥ t/A.
fn visible_normal(bent: Vec3, normal: Vec3, view: Vec3) -> Vec3 {
    let above = view.dot(normal).max(1e-5);
    let height = bent.dot(normal);
    let aside = bent - normal * height;
    let tilt = aside.length();
    if tilt < 1e-6 {
        return normal;
    }
    let aside = aside / tilt;
    let sideways = view.dot(aside);
    let least = (0.9 * above).min(0.01);
    let steepest = 0.5 * (sideways.atan2(above) + (least / sideways.hypot(above)).acos());
    let angle = tilt.atan2(height).min(steepest);
    normal * angle.cos() + aside * angle.sin()
}
