//! Textures at a surface interaction: parameters of the BSDF and the shading normal.
//!
//! **Bump maps.** The normal follows the slope of a height: n' = n - (∇h - n (n·∇h)), normalised (Blinn 1978,
//! "Simulation of Wrinkled Surfaces"; in this form Mikkelsen 2010). It is then rotated towards the geometric normal
//! until the mirrored view direction leaves the surface, so that no mirror is black (Schüßler et al. 2017, section 3,
//! describe the problem; Cycles also rotates the normal). Light that scatters through the geometric surface to the
//! wrong side is lost. Bump maps change neither silhouettes nor shadows.
//!
//! **Normal maps** of meshes give the normal in the frame of the interpolated normal and tangent (glTF 2.0, section 3.7.2.1).
//!
//! **Space.** Textures are evaluated in the coordinates of the leaf
//! ([`Field::coordinates`](pathmarch_field::Field::coordinates)). Heights scale with the shape.
//!
//! **Cost.** One evaluation for each texture, four for a bump map, none for materials without textures.

use super::surface_interaction::SurfaceInteraction;
use crate::intersect::ray::set_bits;
use crate::scene::preview_material::{PREVIEW_PARAMETERS, PreviewParameters, channel};
use crate::scene::textured_material::{Change, KNOTS, Layer, Source, TexturedMaterial};
use crate::scene::{KernelConfig, TraceContext};
use glam::Vec3;
use pathmarch_field::graph::Coordinates;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::BsdfParameters;
use pathmarch_scene::textures::{Decal, DecalSpace, MeshAttributes, Ramp, Spot};
use wide::f32x8;

/// Two knots around a value, and the interpolation weight of the second.
fn interval<T>(knots: &[T], value: f32) -> (&T, &T, f32) {
    let position = value * (KNOTS - 1) as f32;
    let first = (position as usize).min(KNOTS - 2);
    (&knots[first], &knots[first + 1], position - first as f32)
}

/// Point on a textured surface.
pub(crate) struct TexturedPoint<'p> {
    material: &'p TexturedMaterial,
    /// The point in the coordinates of its shape.
    spot: Spot,
    /// The point in the coordinates of the scene.
    world_spot: Spot,
    coordinates: Coordinates,
    orbit: Option<[f32; 6]>,
}

impl<'p> TexturedPoint<'p> {
    /// Texture coordinates of an interaction, at the end of a path of this length. `None` for a material without textures.
    #[inline]
    pub(crate) fn new(ctx: &TraceContext<'p>, interaction: &SurfaceInteraction, path_length: f32) -> Option<Self> {
        let &SurfaceInteraction { leaf, p, attributes, .. } = interaction;
        Self::at(ctx, leaf, (p, interaction.outward(), attributes), path_length)
    }

    /// [`new`](Self::new) for a point of a leaf, with its outward normal and vertex attributes.
    #[inline]
    pub(crate) fn at(
        ctx: &TraceContext<'p>,
        leaf: usize,
        (p, outward, attributes): (Vec3, Vec3, MeshAttributes),
        path_length: f32,
    ) -> Option<Self> {
        let scene = ctx.scene;
        let material = scene.textured_materials.get(scene.leaves[leaf].material as usize)?;
        if material.is_plain() {
            return None;
        }
        Self::textured(material, ctx, leaf, (p, outward, attributes), path_length)
    }

    /// Separate from [`new`](Self::new), so that materials without textures need no call.
    fn textured(
        material: &'p TexturedMaterial,
        ctx: &TraceContext,
        leaf: usize,
        (p, outward, attributes): (Vec3, Vec3, MeshAttributes),
        path_length: f32,
    ) -> Option<Self> {
        let footprint = ctx.frame.pixel * path_length;
        let world_spot = Spot { p, normal: outward, footprint, attributes };
        let p = FieldVec3::new(p.x, p.y, p.z);
        let coordinates = ctx.scene.field.coordinates(leaf, p)?;
        let vector = |v: FieldVec3<f32>| Vec3::new(v.x, v.y, v.z);
        let [x, y, z] = coordinates.gradients.map(vector);
        // Normals transform by the inverse transpose.
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let determinant = x.dot(cofactors[0]);
        let local_normal = Vec3::from_array(cofactors.map(|cofactor| cofactor.dot(outward)));
        let normal = (local_normal * determinant.signum()).normalize_or(Vec3::Y);
        let spot =
            Spot { p: vector(coordinates.point), normal, footprint: footprint / coordinates.unit_length, attributes };
        let centre = material.trap_centre().map(|[x, y, z]| FieldVec3::new(x, y, z));
        let orbit = centre.and_then(|centre| ctx.scene.field.orbit(leaf, p, centre));
        Some(Self { material, spot, world_spot, coordinates, orbit })
    }

    /// Value of a source at this point; `None` for an orbit trap on a shape without orbit.
    fn value(&self, source: &Source) -> Option<f32> {
        match source {
            Source::Orbit(trap) => self.orbit.as_ref().map(|orbit| trap.place(orbit)),
            Source::Texture(texture) => Some(texture.value(&self.spot)),
            // It has no value, and layers of numbers have none.
            Source::Decal(_) => None,
        }
    }

    /// This point in the coordinates of a decal's placement.
    fn spot_of(&self, decal: &Decal) -> &Spot {
        match decal.space {
            DecalSpace::Shape => &self.spot,
            DecalSpace::World => &self.world_spot,
        }
    }

    /// Colour of a source of this value at this point: that of the ramp, or of the texture without a ramp, or of a decal over the
    /// colour `below`.
    fn source_colour(
        &self,
        source: &Source,
        value: impl FnOnce() -> Option<f32>,
        ramp: Option<&Ramp>,
        below: Vec3,
    ) -> Option<Vec3> {
        match (ramp, source) {
            (_, Source::Decal(decal)) => Some(decal.over(below, self.spot_of(decal))),
            (None, Source::Texture(texture)) if texture.is_computed() => Some(Vec3::splat(value()?)),
            (None, Source::Texture(texture)) => Some(texture.colour(&self.spot)),
            (Some(ramp), _) => Some(ramp.colour(value()?).into()),
            (None, Source::Orbit(_)) => None,
        }
    }

    /// Parameters of the BSDF at this point.
    pub(crate) fn parameters(&self, parameters: &BsdfParameters) -> BsdfParameters {
        let mut parameters = *parameters;
        for layer in &self.material.layers {
            self.apply(layer, || self.value(&layer.source), &mut parameters);
        }
        parameters
    }

    /// Applies a layer whose source has this value.
    fn apply(&self, layer: &Layer, value: impl FnOnce() -> Option<f32>, parameters: &mut BsdfParameters) {
        match &layer.change {
            Change::Colour { first, ramp } => {
                let below = Vec3::from_slice(&parameters[*first..]);
                if let Some(colour) = self.source_colour(&layer.source, value, ramp.as_ref(), below) {
                    parameters[*first..*first + 3].copy_from_slice(&colour.to_array());
                }
            }
            Change::Parameters { indices, knots } => {
                let Some(value) = value() else { return };
                let (a, b, weight) = interval(knots, value);
                for ((index, a), b) in indices.iter().zip(a).zip(b) {
                    parameters[*index] = a + (b - a) * weight;
                }
            }
        }
    }

    /// Colour of the material, its first parameter; `None` if no texture replaces it.
    pub(crate) fn colour(&self) -> Option<Vec3> {
        let mut found: Option<Vec3> = None;
        for layer in &self.material.layers {
            if let Change::Colour { first: 0, ramp } = &layer.change {
                let below = found.unwrap_or(layer.base.into());
                found = self.source_colour(&layer.source, || self.value(&layer.source), ramp.as_ref(), below).or(found);
            }
        }
        found
    }

    /// Colours of the material, as [`colour`](Self::colour), at these offsets from the point, in world space; `None` if no texture
    /// replaces it. The coordinates of the shape are taken to be as straight as at the point.
    pub(crate) fn colours_beside(&self, offsets: FieldVec3<f32x8>) -> Option<FieldVec3<f32x8>> {
        let along = |axis: FieldVec3<f32>| FieldVec3::constant([axis.x, axis.y, axis.z]).dot(offsets);
        let [x, y, z] = self.coordinates.gradients.map(along);
        let positions = FieldVec3::constant(self.spot.p.into()) + FieldVec3::new(x, y, z);
        let mut found = None;
        for layer in &self.material.layers {
            if let (Change::Colour { first: 0, ramp }, Source::Texture(texture)) = (&layer.change, &layer.source) {
                found = Some(match ramp {
                    Some(ramp) => ramp.colours(texture.values_around(&self.spot, positions)),
                    None => texture.colours_around(&self.spot, positions),
                });
            }
        }
        found
    }

    /// Parameters of the preview material at this point.
    pub(crate) fn preview(&self, preview: PreviewParameters) -> PreviewParameters {
        let mut parameters = preview;
        // Colour of the first parameter so far.
        let mut first_colour: Option<Vec3> = None;
        for layer in &self.material.layers {
            match &layer.change {
                Change::Colour { first, ramp } => {
                    let below = first_colour.filter(|_| *first == 0).unwrap_or(layer.base.into());
                    let value = || self.value(&layer.source);
                    let Some(colour) = self.source_colour(&layer.source, value, ramp.as_ref(), below) else { continue };
                    let change = colour - below;
                    if *first == 0 {
                        first_colour = Some(colour);
                    }
                    (0..PREVIEW_PARAMETERS).for_each(|k| parameters[k] += layer.previews[0][k] * change[channel(k)]);
                }
                Change::Parameters { .. } => {
                    let Some(value) = self.value(&layer.source) else { continue };
                    let (a, b, weight) = interval(&layer.previews, value);
                    (0..PREVIEW_PARAMETERS).for_each(|k| parameters[k] += a[k] + (b[k] - a[k]) * weight);
                }
            }
        }
        parameters
    }

    /// Emitted radiance, if a texture varies it.
    pub(crate) fn emission(&self) -> Option<Vec3> {
        self.material.emission.as_ref().map(|texture| texture.colour(&self.spot))
    }

    /// Normal `outward`, replaced by that of the normal map.
    fn mapped(&self, outward: Vec3) -> Vec3 {
        let Some(map) = &self.material.normal_map else { return outward };
        let [x, y, z] = self.coordinates.gradients.map(|g| Vec3::new(g.x, g.y, g.z));
        let local = self.spot.attributes.tangent;
        let along = x * local.x + y * local.y + z * local.z;
        let tangent = along - outward * outward.dot(along);
        // Without texture coordinates there is no tangent.
        if tangent.length_squared() <= 1e-12 * along.length_squared() {
            return outward;
        }
        let tangent = tangent.normalize();
        let bitangent = outward.cross(tangent) * if local.w < 0.0 { -1.0 } else { 1.0 };
        let normal = map.normal(map.texture.colour(&self.spot));
        (tangent * normal.x + bitangent * normal.y + outward * normal.z).normalize()
    }

    /// Normal `outward`, bent by the bump map.
    fn bumped(&self, outward: Vec3) -> Vec3 {
        let Some(bump) = &self.material.bump else { return outward };
        let local_gradient = bump.texture.slope(&self.spot) * bump.height;
        let [x, y, z] = self.coordinates.gradients.map(|g| Vec3::new(g.x, g.y, g.z));
        let gradient =
            (x * local_gradient.x + y * local_gradient.y + z * local_gradient.z) * self.coordinates.unit_length;
        let tangential_gradient = gradient - outward * outward.dot(gradient);
        (outward - tangential_gradient).normalize()
    }
}

/// Parameters of the BSDFs at eight points, where they are textured, from those without textures, which a function gives for a
/// point. Points of one material are evaluated together.
pub(crate) fn parameters_of_eight<'a>(
    points: &[Option<TexturedPoint>; 8],
    untextured: impl Fn(usize) -> &'a BsdfParameters,
) -> [Option<BsdfParameters>; 8] {
    let bits_where = |holds: &dyn Fn(&TexturedPoint) -> bool| {
        (0..8).map(|lane| u32::from(points[lane].as_ref().is_some_and(holds)) << lane).sum::<u32>()
    };
    let mut parameters = [None; 8];
    let mut left = bits_where(&|_| true);
    while let Some(first) = points.get(left.trailing_zeros() as usize).and_then(Option::as_ref) {
        let material = first.material;
        let group = left & bits_where(&|point| std::ptr::eq(point.material, material));
        left &= !group;
        for lane in set_bits(group) {
            parameters[lane] = Some(*untextured(lane));
        }
        let spots = std::array::from_fn(|lane| match &points[lane] {
            Some(point) if group >> lane & 1 == 1 => &point.spot,
            _ => &first.spot,
        });
        for layer in &material.layers {
            let together = match &layer.source {
                Source::Texture(texture) if texture.is_computed() && group.count_ones() > 1 => {
                    Some(texture.values(spots).to_array())
                }
                _ => None,
            };
            for lane in set_bits(group) {
                if let (Some(point), Some(parameters)) = (&points[lane], &mut parameters[lane]) {
                    let value = || together.map_or_else(|| point.value(&layer.source), |values| Some(values[lane]));
                    point.apply(layer, value, parameters);
                }
            }
        }
    }
    parameters
}

/// Shading normal of an interaction, on the side of its geometric normal; `view` is the unit vector towards the viewer.
#[inline]
pub(crate) fn shading_normal(
    config: &KernelConfig,
    textured: Option<&TexturedPoint>,
    interaction: &SurfaceInteraction,
    view: Vec3,
) -> Vec3 {
    if !config.shading_normals {
        return interaction.normal;
    }
    let smooth = interaction.shading_outward;
    let bumped = textured.map_or(smooth, |textured| textured.bumped(textured.mapped(smooth)));
    let side = if interaction.inside { -1.0 } else { 1.0 };
    visible_normal(bumped * side, interaction.normal, view)
}

/// Normal nearest to `bumped`, between it and the geometric normal, whose mirrored view direction leaves the surface.
///
/// In the plane of both normals, θ is the angle between them, φ that from the geometric normal to the view, and A the
/// length of the projected view. The mirrored view is at 2θ - φ. It is at least t above the surface if cos(2θ - φ) ≥
/// t/A.
fn visible_normal(bumped: Vec3, normal: Vec3, view: Vec3) -> Vec3 {
    let view_height = view.dot(normal).max(1e-5);
    let bumped_height = bumped.dot(normal);
    let tangent = bumped - normal * bumped_height;
    let tangent_length = tangent.length();
    if tangent_length < 1e-6 {
        return normal;
    }
    let tangent = tangent / tangent_length;
    let view_tangent = view.dot(tangent);
    let min_height = (0.9 * view_height).min(0.01);
    let max_angle = 0.5 * (view_tangent.atan2(view_height) + (min_height / view_tangent.hypot(view_height)).acos());
    let angle = tangent_length.atan2(bumped_height).min(max_angle);
    normal * angle.cos() + tangent * angle.sin()
}
