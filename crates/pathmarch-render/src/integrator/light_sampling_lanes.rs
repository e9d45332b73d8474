//! Light sampling in SIMD lanes: lights and directions to them from eight points, as [`light_sampling`](super::light_sampling)
//! samples them for one point.
//!
//! Spheres, rectangles and points are sampled side by side, lights of other kinds one by one.

use super::light_sampling::{
    ChosenLight, SHADOW_RAY_SHARE, choose_light_outside_tree, power_heuristic, sample_direction,
};
use crate::intersect::ray::{mask_of, pack, set_bits, transposed, unpack};
use crate::sampling::basis::Basis8;
use crate::scene::TraceContext;
use crate::scene::light::{LightShape, PointLight, SheetLight, SphereLight};
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3, unit_circle};
use pathmarch_scene::DirectLighting;
use std::f32::consts::TAU;
use wide::f32x8;

/// Light samples of eight points; see [`LightSample`](super::light_sampling::LightSample).
pub(super) struct LightSamples {
    pub(super) direction: FieldVec3<f32x8>,
    pub(super) distance: f32x8,
    pub(super) irradiance: FieldVec3<f32x8>,
    pub(super) pdf: f32x8,
    /// Lanes with a sample.
    pub(super) exist: Mask8,
}

impl LightSamples {
    /// Replaces lanes.
    fn set(&mut self, lanes: Mask8, sample: &Self) {
        let select = |new: f32x8, old: f32x8| Real::select(lanes, new, old);
        self.direction = FieldVec3::select(lanes, sample.direction, self.direction);
        self.irradiance = FieldVec3::select(lanes, sample.irradiance, self.irradiance);
        self.distance = select(sample.distance, self.distance);
        self.pdf = select(sample.pdf, self.pdf);
        self.exist = self.exist | lanes & sample.exist;
    }
}

/// Lights that are chosen for eight points, with the probabilities of choosing them.
pub(super) struct ChosenLights<'a> {
    /// Indices among the lights of the scene.
    indices: [usize; 8],
    /// The environment in lanes without a light.
    pub(super) shapes: [&'a LightShape; 8],
    pmf: f32x8,
    inverse_pmf: f32x8,
    /// Lanes with a light, a bit for each.
    exist: u32,
}

impl<'a> ChosenLights<'a> {
    const NONE: Self = Self {
        indices: [0; 8],
        shapes: [&LightShape::Environment; 8],
        pmf: f32x8::ZERO,
        inverse_pmf: f32x8::ZERO,
        exist: 0,
    };

    /// Puts the lights that are found for these lanes into them.
    #[inline(always)]
    fn put(&mut self, lanes: u32, light: impl Fn(usize) -> Option<ChosenLight<'a>>) {
        let (mut pmf, mut inverse_pmf) = (self.pmf.to_array(), self.inverse_pmf.to_array());
        for lane in set_bits(lanes) {
            if let Some(light) = light(lane) {
                (self.indices[lane], self.shapes[lane]) = (light.index, light.shape);
                (pmf[lane], inverse_pmf[lane]) = (light.pmf, light.inverse_pmf);
                self.exist |= 1 << lane;
            }
        }
        (self.pmf, self.inverse_pmf) = (pmf.into(), inverse_pmf.into());
    }

    fn get(&self, lane: usize) -> ChosenLight<'a> {
        let [pmf, inverse_pmf] = [self.pmf, self.inverse_pmf].map(|values| values.to_array()[lane]);
        ChosenLight { index: self.indices[lane], shape: self.shapes[lane], pmf, inverse_pmf }
    }

    /// Lights of one kind, where the others are replaced by one of them, and the lanes of this kind. `None` if there is none.
    #[inline(always)]
    fn of_kind<T>(&self, kind: impl Fn(&'a LightShape) -> Option<&'a T>) -> Option<([&'a T; 8], Mask8)> {
        let any = self.shapes.iter().find_map(|shape| kind(shape))?;
        let lanes = (0..8).map(|lane| u32::from(kind(self.shapes[lane]).is_some()) << lane).sum();
        Some((self.shapes.map(|shape| kind(shape).unwrap_or(any)), mask_of(lanes)))
    }
}

/// Sphere that is sampled in the cone that it subtends.
fn sphere(shape: &LightShape) -> Option<&SphereLight> {
    match shape {
        LightShape::Sphere(sphere) | LightShape::Bounded(sphere) => Some(sphere),
        _ => None,
    }
}

fn rect(shape: &LightShape) -> Option<&SheetLight> {
    if let LightShape::Rect(sheet) = shape { Some(sheet) } else { None }
}

fn point(shape: &LightShape) -> Option<&PointLight> {
    if let LightShape::Point(point) = shape { Some(point) } else { None }
}

/// Chooses a light for each point whose bit is set in `wanted`, as [`choose_light`](super::light_sampling::choose_light) does. Surfaces with these unit normals are
/// lit on one side only.
pub(super) fn choose_lights<'a>(
    ctx: &TraceContext<'a>,
    p: FieldVec3<f32x8>,
    normal: FieldVec3<f32x8>,
    choice: f32x8,
    wanted: u32,
) -> ChosenLights<'a> {
    let mut chosen = ChosenLights::NONE;
    let mut alone = wanted;
    if let Some(tree) = &ctx.scene.light_tree {
        let share = f32x8::splat(tree.share);
        let in_tree = wanted & choice.simd_lt(share).to_bitmask();
        alone = wanted & !in_tree;
        let (leaves, probability) = tree.sample_in_lanes(p, normal, choice / share, mask_of(in_tree));
        chosen.pmf = probability * share;
        chosen.inverse_pmf = f32x8::ONE / chosen.pmf;
        chosen.exist = in_tree & chosen.pmf.simd_gt(f32x8::ZERO).to_bitmask();
        for lane in set_bits(chosen.exist) {
            let index = tree.first + leaves[lane];
            (chosen.indices[lane], chosen.shapes[lane]) = (index, &ctx.scene.lights[index].shape);
        }
    }
    if alone != 0 {
        let choices = choice.to_array();
        chosen.put(alone, |lane| choose_light_outside_tree(ctx, choices[lane]));
    }
    chosen
}

/// Samples a direction from each point to its light. Lanes without a light have no sample.
pub(super) fn sample_directions(
    ctx: &TraceContext,
    lights: &ChosenLights,
    p: FieldVec3<f32x8>,
    position: [f32x8; 2],
) -> LightSamples {
    let zero = FieldVec3::splat(f32x8::ZERO);
    let mut samples =
        LightSamples { direction: zero, irradiance: zero, distance: f32x8::ZERO, pdf: f32x8::ZERO, exist: mask_of(0) };
    if let Some((spheres, lanes)) = lights.of_kind(sphere) {
        let bounded = mask_of((0..8).map(|lane| u32::from(lights.shapes[lane].target().is_some()) << lane).sum());
        samples.set(lanes, &sample_spheres(spheres, bounded, p, position));
    }
    if let Some((sheets, lanes)) = lights.of_kind(rect) {
        samples.set(lanes, &sample_rects(sheets, p, position));
    }
    if let Some((points, lanes)) = lights.of_kind(point) {
        samples.set(lanes, &sample_points(points, p));
    }
    samples.pdf *= lights.pmf;
    samples.irradiance = samples.irradiance * lights.inverse_pmf;
    let is_other = |&lane: &usize| {
        let shape = lights.shapes[lane];
        sphere(shape).is_none() && rect(shape).is_none() && point(shape).is_none()
    };
    let mut others = set_bits(lights.exist).filter(is_other).peekable();
    if others.peek().is_some() {
        sample_others(ctx, lights, others, &mut samples, p, position);
    }
    samples
}

/// Samples spheres in the cones that they subtend; see [`sample_direction`]. The choice of the lights is not in pdf and irradiance.
fn sample_spheres(
    spheres: [&SphereLight; 8],
    bounded: Mask8,
    p: FieldVec3<f32x8>,
    position: [f32x8; 2],
) -> LightSamples {
    let (zero, one, two) = (f32x8::ZERO, f32x8::ONE, f32x8::splat(2.0));
    let row = |&SphereLight { centre, radius, radiance, .. }: &SphereLight| {
        [centre.x, centre.y, centre.z, radius, radiance.x, radiance.y, radiance.z, 0.0]
    };
    let [x, y, z, radius, red, green, blue, _] = transposed(spheres.map(row));
    let offset = FieldVec3::new(x, y, z) - p;
    let square = offset.dot(offset);
    let sine_square = radius * radius / square.fast_max(f32x8::splat(1e-30));
    let is_inside = Mask8(sine_square.simd_ge(one));
    let outside = sine_square / (one + (one - sine_square).fast_max(zero).sqrt());
    let one_minus_cos = Real::select(is_inside, two, outside);
    let axis = normalize_or_up(offset, square);
    let one_minus_cos_theta = one_minus_cos * position[0];
    let sine = (one_minus_cos_theta * (two - one_minus_cos_theta)).fast_max(zero).sqrt();
    let [cos_phi, sin_phi] = unit_circle(position[1]);
    let local = FieldVec3::new(sine * cos_phi, sine * sin_phi, one - one_minus_cos_theta);
    let direction = Basis8::new(axis).to_world(local).renormalized();
    let along = offset.dot(direction);
    let across = offset - direction * along;
    let half_chord = (radius * radius - across.dot(across)).fast_max(zero).sqrt();
    let entry = Real::select(Mask8(along.simd_gt(half_chord)), along - half_chord, along + half_chord);
    let solid_angle = f32x8::splat(TAU) * one_minus_cos;
    LightSamples {
        direction,
        distance: Real::select(bounded, f32x8::splat(f32::INFINITY), entry * f32x8::splat(SHADOW_RAY_SHARE)),
        irradiance: FieldVec3::new(red, green, blue) * solid_angle,
        pdf: one / solid_angle,
        exist: f32x8::truth(true),
    }
}

/// Unit vectors along `offset`, whose squared lengths are `square`; up where it has no length.
fn normalize_or_up(offset: FieldVec3<f32x8>, square: f32x8) -> FieldVec3<f32x8> {
    let is_long = Mask8(square.simd_gt(f32x8::ZERO));
    let inverse = Real::select(is_long, f32x8::ONE / square.sqrt(), f32x8::ZERO);
    let unit = offset * inverse;
    FieldVec3::new(unit.x, Real::select(is_long, unit.y, f32x8::ONE), unit.z)
}

/// Samples rectangles by area, like [`sample_spheres`].
fn sample_rects(sheets: [&SheetLight; 8], p: FieldVec3<f32x8>, position: [f32x8; 2]) -> LightSamples {
    let [u, v] = position.map(|value| value + value - f32x8::ONE);
    let row =
        |&SheetLight { centre, axes: [x, z], .. }: &SheetLight| [centre.x, centre.y, centre.z, x.x, x.y, x.z, z.x, z.y];
    let [cx, cy, cz, xx, xy, xz, zx, zy] = transposed(sheets.map(row));
    let row = |&SheetLight { axes: [_, z], normal: n, area, radiance, .. }: &SheetLight| {
        [z.z, n.x, n.y, n.z, area, radiance.x, radiance.y, radiance.z]
    };
    let [zz, nx, ny, nz, area, red, green, blue] = transposed(sheets.map(row));
    let offset = FieldVec3::new(cx, cy, cz) + FieldVec3::new(xx, xy, xz) * u + FieldVec3::new(zx, zy, zz) * v - p;
    let square = offset.dot(offset);
    let distance = square.sqrt();
    let direction = offset * (f32x8::ONE / distance);
    let cosine = -FieldVec3::new(nx, ny, nz).dot(direction);
    let solid_angle = area * cosine / square;
    LightSamples {
        direction,
        distance: distance * f32x8::splat(SHADOW_RAY_SHARE),
        irradiance: FieldVec3::new(red, green, blue) * solid_angle,
        pdf: f32x8::ONE / solid_angle,
        exist: Mask8(cosine.simd_gt(f32x8::ZERO)),
    }
}

/// Directions to points, like [`sample_spheres`].
fn sample_points(points: [&PointLight; 8], p: FieldVec3<f32x8>) -> LightSamples {
    let offset = pack(points.map(|point| point.position)) - p;
    let distance = offset.length();
    let inverse = f32x8::ONE / distance;
    LightSamples {
        direction: offset * inverse,
        distance,
        irradiance: pack(points.map(|point| point.radiant_intensity)) * (inverse * inverse),
        pdf: f32x8::ZERO,
        exist: f32x8::truth(true),
    }
}

/// Samples the lights of these lanes one by one.
#[cold]
fn sample_others(
    ctx: &TraceContext,
    lights: &ChosenLights,
    others: impl Iterator<Item = usize>,
    samples: &mut LightSamples,
    p: FieldVec3<f32x8>,
    position: [f32x8; 2],
) {
    let (p, [u, v]) = (unpack(p), position.map(f32x8::to_array));
    let (mut direction, mut irradiance) = (unpack(samples.direction), unpack(samples.irradiance));
    let (mut distance, mut pdf, mut exist) = (samples.distance.to_array(), samples.pdf.to_array(), 0);
    for lane in others {
        if let Some(sample) = sample_direction(ctx, &lights.get(lane), p[lane], [u[lane], v[lane]]) {
            (direction[lane], irradiance[lane]) = (sample.direction, sample.irradiance);
            (distance[lane], pdf[lane]) = (sample.distance, sample.pdf);
            exist |= 1 << lane;
        }
    }
    (samples.direction, samples.irradiance) = (pack(direction), pack(irradiance));
    (samples.distance, samples.pdf) = (distance.into(), pdf.into());
    samples.exist = samples.exist | mask_of(exist);
}

/// MIS weights of light sampling; see [`sample_weight`](super::light_sampling::sample_weight).
pub(super) fn sample_weights(search: DirectLighting, light_pdf: f32x8, scatter_pdf: f32x8) -> f32x8 {
    let weight = match search {
        DirectLighting::Mis => power_heuristic(light_pdf, scatter_pdf),
        DirectLighting::LightSampling => f32x8::ONE,
        DirectLighting::BsdfSampling => f32x8::ZERO,
    };
    Real::select(Mask8(light_pdf.simd_le(f32x8::ZERO)), f32x8::ONE, weight)
}
