//! Light tree: chooses a light by its contribution to a point (Conty Estevez and Kulla 2018, "Importance Sampling of Many
//! Lights with Adaptive Tree Splitting"; Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section
//! 12.6.3).
//!
//! **Idea.** The lights with a position are the leaves of a binary tree. Each half of a node has a bounding sphere, a cone of
//! the directions that its lights face, and an intensity. From these follows the importance of the half at a point, an estimate
//! of its irradiance: the intensity by the squared distance, times the cosines at the receiver and at the lights. A walk from
//! the root chooses one half in proportion to its importance, rescales the random number, and ends at one light. So stratified
//! numbers stay stratified, and the probability of a light is the product of the choices. An importance is zero only if no light
//! of the half can contribute; if both are zero, no light is chosen.
//!
//! **Order.** The halves of a node have no order of their own, so each is laid out forwards or backwards, whichever brings lights
//! of like colours side by side. Numbers of a stratum then choose between lights that differ less.
//!
//! **Media.** For a segment of a path in a medium, the importance of a half is about its intensity, integrated over the segment by
//! the squared distance.
//!
//! **Differences.** Nodes contain bounding spheres instead of boxes, because the importance uses only these. It is a mean, not an
//! upper bound: the kernel h/d³ of a point at height h and distance d, softened by a share of the squared radius, as in
//! simulations of gravity (Plummer 1911). With the bounds of the sources, large nodes close to the point get too much: for 400
//! lamps in a room, the relative variance of the irradiance at random points is 1.6 with them and 0.5 with means; for a grid of
//! 1,000 lamps above a floor 0.9 and 0.15. Every light here emits into the hemisphere around its normal or into all directions, so
//! one angle describes a cone. There is no splitting of a choice into several lights.
//!
//! **Layout.** Nodes are in depth-first order, and lights in the order of the leaves. A subtree of `n` lights has `n - 1`
//! nodes, so a node stores no links, only the number of lights in its first half: 64 bytes for two halves. The index of a light is
//! its way down the tree.
//!
//! **Cost.** Two importances for each level, in lanes for eight points at once. Built in O(n log n).

use crate::intersect::ray::Ray;
use crate::sampling::ONE_MINUS_EPSILON;
use crate::wgsl::{shared_constants, shared_struct};
use glam::Vec3;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use std::f32::consts::{FRAC_PI_2, PI};
use wide::f32x8;

shared_struct! {
    /// Node of the light tree, with its two halves `a` and `b`.
    pub(crate) struct LightNode as LightNode {
        /// Bounding sphere of a half, in world space, metres.
        centre_a: [f32; 3],
        radius_a: f32,
        centre_b: [f32; 3],
        radius_b: f32,
        /// Axis of the cone of normals in world space. Its length is 2 plus the cosine of the cone's half angle: 3 for one
        /// direction, 1 for all.
        axis_a: [f32; 3],
        /// Intensity of half `b` divided by that of half `a`.
        intensity_ratio: f32,
        axis_b: [f32; 3],
        /// Number of lights in half `a`.
        count_a: f32,
    }
}

/// Light, as the tree sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// Bounding sphere in world space, metres.
    pub(super) centre: Vec3,
    pub(super) radius: f32,
    /// Normals of the emitting surfaces.
    pub(super) normals: NormalCone,
    /// Largest radiant intensity by channel. Its length is its strength, by which lights are chosen.
    pub(super) intensity: Vec3,
}

/// Lights of a half of a node.
struct Half {
    /// Bounding sphere in world space, metres.
    centre: Vec3,
    radius: f32,
    /// Normals of the emitting surfaces.
    normals: NormalCone,
    /// Sum of the strengths of the lights.
    strength: f64,
}

/// Cone of unit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalCone {
    /// Unit vector in world space.
    pub(super) axis: Vec3,
    /// Cosine of the half angle.
    pub(super) cosine: f32,
}

impl NormalCone {
    /// All directions.
    pub(super) const ALL: Self = Self { axis: Vec3::Y, cosine: -1.0 };

    /// One direction.
    pub(super) fn of(axis: Vec3) -> Self {
        Self { axis, cosine: 1.0 }
    }

    /// Smallest cone around this one and another.
    pub(super) fn union(self, other: Self) -> Self {
        if self.cosine <= -1.0 || other.cosine <= -1.0 {
            return Self::ALL;
        }
        let [angle, other_angle] = [self, other].map(|cone| cone.cosine.clamp(-1.0, 1.0).acos());
        let between = self.axis.cross(other.axis).length().atan2(self.axis.dot(other.axis));
        if between + other_angle <= angle {
            return self;
        }
        if between + angle <= other_angle {
            return other;
        }
        let half_angle = 0.5 * (angle + between + other_angle) + ROUNDING;
        let across = (other.axis - self.axis * self.axis.dot(other.axis)).normalize_or_zero();
        if half_angle >= PI || across == Vec3::ZERO {
            return Self::ALL;
        }
        let (sine, cosine) = (half_angle - angle).sin_cos();
        Self { axis: (self.axis * cosine + across * sine).normalize(), cosine: half_angle.cos() }
    }

    /// Integral of the largest cosine to a normal of the cone over all directions, divided by 4π: 1 for all directions, 1/4 for
    /// one (Conty Estevez and Kulla 2018, section 4.1).
    fn measure(self) -> f32 {
        let angle = self.cosine.clamp(-1.0, 1.0).acos();
        let (sine, cosine) = angle.sin_cos();
        let end = (angle + FRAC_PI_2).min(PI);
        let beyond = 2.0 * end * sine - (angle - 2.0 * end).cos() - 2.0 * angle * sine + cosine;
        0.5 * (1.0 - cosine) + 0.125 * beyond
    }
}

/// Margin of a cone for rounding errors, radians.
const ROUNDING: f32 = 1e-3;

/// Lights of a part of a node, for the choice of a split.
#[derive(Clone, Copy)]
struct Group {
    min: Vec3,
    max: Vec3,
    /// `None` without lights.
    normals: Option<NormalCone>,
    strength: f64,
}

impl Group {
    const NOTHING: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, normals: None, strength: 0.0 };

    fn of(light: &LightBounds) -> Self {
        let radius = Vec3::splat(light.radius);
        Self {
            min: light.centre - radius,
            max: light.centre + radius,
            normals: Some(light.normals),
            strength: f64::from(light.intensity.length()),
        }
    }

    fn union(self, other: Self) -> Self {
        let normals = match (self.normals, other.normals) {
            (Some(a), Some(b)) => Some(a.union(b)),
            (a, b) => a.or(b),
        };
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            normals,
            strength: self.strength + other.strength,
        }
    }

    /// Cost of a half in the surface area orientation heuristic, with the square of the radius as the area.
    fn cost(&self) -> f64 {
        let Some(normals) = self.normals else { return 0.0 };
        self.strength * f64::from(normals.measure()) * f64::from((self.max - self.min).length_squared())
    }

    /// Half with these lights.
    fn half(&self, lights: &[LightBounds], order: &[u32]) -> Half {
        let normals = self.normals.unwrap_or(NormalCone::ALL);
        let (centre, radius) = if let &[light] = order {
            let LightBounds { centre, radius, .. } = lights[light as usize];
            (centre, radius)
        } else {
            let centre = 0.5 * self.min + 0.5 * self.max;
            let reach = |&light: &u32| lights[light as usize].centre.distance(centre) + lights[light as usize].radius;
            (centre, order.iter().map(reach).fold(0.0, f32::max) * (1.0 + 4.0 * f32::EPSILON))
        };
        Half { centre, radius, normals, strength: self.strength }
    }
}

/// Number of bins of a split along each axis.
const BINS: usize = 12;
/// Depth from which nodes are split into halves of equal number, so that no walk is long.
const MAX_BINNED_DEPTH: u32 = 48;
/// Largest ratio of the intensities of two halves, so that products stay finite.
const MAX_RATIO: f64 = 1e15;

/// Tree over the lights of a scene that have a position.
#[derive(Clone, Debug)]
pub(crate) struct LightTree {
    /// Nodes in depth-first order; one less than lights.
    pub(crate) nodes: Vec<LightNode>,
    /// Number of lights.
    pub(crate) count: usize,
    /// Index of the first light.
    pub(crate) first: usize,
    /// Probability of choosing one of these lights, and not a sun or the environment.
    pub(crate) share: f32,
    /// True if some light emits on one side only.
    pub(crate) has_facing_lights: bool,
}

impl LightTree {
    /// Builds the tree over these lights. Returns it and the indices of the lights in the order of its leaves.
    pub(super) fn new(lights: &[LightBounds], first: usize, share: f32) -> (Self, Vec<u32>) {
        let mut nodes = Vec::with_capacity(lights.len().saturating_sub(1));
        let mut order = Vec::with_capacity(lights.len());
        if !lights.is_empty() {
            let mut unordered: Vec<u32> = (0..lights.len() as u32).collect();
            Subtree::new(lights, &mut unordered, 0).append(false, &mut nodes, &mut order);
        }
        let has_facing_lights = lights.iter().any(|light| light.normals.cosine > -1.0);
        (Self { nodes, count: lights.len(), first, share, has_facing_lights }, order)
    }

    /// Chooses a light for a point with a uniform number. `normal` is the unit normal of a surface that is lit on this side
    /// only; `None` for other surfaces and for points in a medium. Returns the index of the leaf and its probability; `None` if
    /// no light can contribute at the end of the walk.
    pub(crate) fn sample(&self, p: Vec3, normal: Option<Vec3>, random: f32) -> Option<(usize, f32)> {
        self.walk(random, |node| self.share_a(node, p, normal))
    }

    /// Chooses a light for the medium on a segment of this length, metres, which scatters light into its ray. Returns the index of
    /// the leaf and its probability, which is above zero for every light.
    pub(crate) fn sample_along(&self, ray: &Ray, length: f32, random: f32) -> Option<(usize, f32)> {
        self.walk(random, |node| Some(self.share_a_along(node, ray, length)))
    }

    /// Walks from the root to a leaf with a uniform number; `share_a` is the probability of half `a` of a node. Returns the index
    /// of the leaf and its probability.
    #[inline(always)]
    fn walk(&self, mut random: f32, share_a: impl Fn(usize) -> Option<f32>) -> Option<(usize, f32)> {
        let (mut node, mut first, mut count, mut probability) = (0, 0, self.count, 1.0f32);
        while count > 1 {
            let count_a = self.nodes[node].count_a as usize;
            let share_a = share_a(node)?;
            if random < share_a {
                random /= share_a;
                probability *= share_a;
                count = count_a;
                node += 1;
            } else {
                random = (random - share_a) / (1.0 - share_a);
                probability *= 1.0 - share_a;
                first += count_a;
                count -= count_a;
                node += count_a;
            }
            random = random.min(ONE_MINUS_EPSILON);
        }
        Some((first, probability))
    }

    /// Probability that [`sample`](Self::sample) chooses this leaf.
    pub(crate) fn probability(&self, leaf: usize, p: Vec3, normal: Option<Vec3>) -> f32 {
        let (mut node, mut first, mut count, mut probability) = (0, 0, self.count, 1.0f32);
        while count > 1 {
            let count_a = self.nodes[node].count_a as usize;
            let Some(share_a) = self.share_a(node, p, normal) else { return 0.0 };
            if leaf < first + count_a {
                probability *= share_a;
                count = count_a;
                node += 1;
            } else {
                probability *= 1.0 - share_a;
                first += count_a;
                count -= count_a;
                node += count_a;
            }
        }
        probability
    }
}

shared_constants! {
    /// Smallest squared distance in an importance, square metres.
    const MIN_SQUARE: f32 = 1e-20;
    /// Weight of the distance in [`length_by_importance`]: 1/π, that of an endless line.
    const LINE_SHARE: f32 = 0.318_309_87;
    /// Mean square of the distances of lights from the centre of their bounding sphere, in radii of the sphere.
    const SOFTENING: f32 = 0.15;
    /// Height of lights near the horizon, as a share of the height of the top of their bounding sphere.
    const HORIZON_SHARE: f32 = 0.2;
    /// Cosine of half the angle of a cone below which it counts as all directions.
    const FULL_CONE: f32 = -0.9999;
}

/// Node with its numbers for one point, or in lanes for eight, each at a node of its own.
struct Halves<N> {
    centres: [FieldVec3<N>; 2],
    radii: [N; 2],
    /// See [`LightNode`]; not read without lights that face one side.
    axes: [FieldVec3<N>; 2],
    intensity_ratio: N,
}

impl<N: Real> Halves<N> {
    /// Halves of a node, from its 16 numbers.
    #[inline(always)]
    fn new([first, second]: [[N; 8]; 2]) -> Self {
        let [ax, ay, az, radius_a, bx, by, bz, radius_b] = first;
        let [i, j, k, intensity_ratio, l, m, n, _] = second;
        Self {
            centres: [FieldVec3::new(ax, ay, az), FieldVec3::new(bx, by, bz)],
            radii: [radius_a, radius_b],
            axes: [FieldVec3::new(i, j, k), FieldVec3::new(l, m, n)],
            intensity_ratio,
        }
    }

    /// Importances of both halves at a point. The normal is `None` for a point that is lit from all sides.
    #[inline(always)]
    fn importances(self, p: FieldVec3<N>, normal: Option<FieldVec3<N>>, has_facing_lights: bool) -> [N; 2] {
        let Self { centres: [centre_a, centre_b], radii, axes, intensity_ratio } = self;
        let axes = axes.map(|axis| has_facing_lights.then_some(axis));
        let a = importance(centre_a - p, radii[0], axes[0], normal);
        let b = importance(centre_b - p, radii[1], axes[1], normal);
        [a, b * intensity_ratio]
    }
}

impl LightTree {
    /// Probability of half `a` of a node; `None` if neither half lights the point.
    fn share_a(&self, node: usize, p: Vec3, normal: Option<Vec3>) -> Option<f32> {
        let halves = Halves::new(bytemuck::cast(self.nodes[node]));
        let [a, b] = halves.importances(p.into(), normal.map(FieldVec3::from), self.has_facing_lights);
        (a + b > 0.0).then(|| a / (a + b))
    }

    /// Probability of half `a` of a node for the medium on a segment.
    fn share_a_along(&self, node: usize, ray: &Ray, length: f32) -> f32 {
        let LightNode { centre_a, radius_a, centre_b, radius_b, intensity_ratio, .. } = self.nodes[node];
        let [a, b] = [(centre_a, radius_a), (centre_b, radius_b)].map(|(centre, radius)| {
            length_by_importance(Vec3::from(centre) - ray.origin, radius, ray.direction, length)
        });
        b / (b + a * intensity_ratio)
    }

    /// Nodes of eight lanes, and the number of lights in half `a` of each.
    #[inline(always)]
    fn halves_in_lanes(&self, nodes: [u32; 8]) -> (Halves<f32x8>, f32x8) {
        let mut rows = [[f32x8::ZERO; 8]; 2];
        for (lane, node) in nodes.into_iter().enumerate() {
            let numbers: &[[f32; 8]; 2] = bytemuck::cast_ref(&self.nodes[node as usize]);
            (rows[0][lane], rows[1][lane]) = (f32x8::from(numbers[0]), f32x8::from(numbers[1]));
        }
        let second = f32x8::transpose(rows[1]);
        (Halves::new([f32x8::transpose(rows[0]), second]), second[7])
    }

    /// Chooses a light for each of eight points as [`sample`](Self::sample) does, for surfaces that are lit on one side. Returns
    /// the indices of the leaves, and their probabilities, which are 0 where no light can contribute and where `active` is not
    /// set.
    pub(crate) fn sample_in_lanes(
        &self,
        p: FieldVec3<f32x8>,
        normal: FieldVec3<f32x8>,
        mut random: f32x8,
        active: Mask8,
    ) -> ([usize; 8], f32x8) {
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        // Whole numbers below 2^24, exact in `f32`.
        let (mut node, mut first, mut count) = (zero, zero, f32x8::splat(self.count as f32));
        let mut probability = Real::select(active, one, zero);
        loop {
            let walks = Mask8(count.simd_gt(one)) & Mask8(probability.simd_gt(zero));
            if walks.0.to_bitmask() == 0 {
                break;
            }
            // Lanes at their end read some node.
            let within = node.fast_min(f32x8::splat(self.nodes.len() as f32 - 1.0));
            let (halves, count_a) = self.halves_in_lanes(within.to_array().map(|node| node as u32));
            let [a, b] = halves.importances(p, Some(normal), self.has_facing_lights);
            let sum = a + b;
            let is_lit = Mask8(sum.simd_gt(zero));
            let share_a = a / Real::select(is_lit, sum, one);
            let takes_a = Mask8(random.simd_lt(share_a));
            let share = Real::select(takes_a, share_a, one - share_a);
            let rest = Real::select(takes_a, random, random - share_a) / share;
            let step = |a: f32x8, b: f32x8| Real::select(takes_a, a, b);
            let walk = |new: f32x8, old: f32x8| Real::select(walks, new, old);
            random = walk(rest.fast_min(f32x8::splat(ONE_MINUS_EPSILON)), random);
            probability = walk(Real::select(is_lit, probability * share, zero), probability);
            first = walk(step(first, first + count_a), first);
            node = walk(node + step(one, count_a), node);
            count = walk(step(count_a, count - count_a), count);
        }
        (first.to_array().map(|leaf| leaf as usize), probability)
    }
}

/// Estimate of the irradiance by lights of unit intensity in a sphere with its centre at `offset`; zero only if none arrives.
/// `axis` is that of a [`LightNode`], `None` if all lights emit in all directions.
#[inline(always)]
fn importance<N: Real>(offset: FieldVec3<N>, radius: N, axis: Option<FieldVec3<N>>, normal: Option<FieldVec3<N>>) -> N {
    let square = offset.dot(offset);
    let inverse = N::one() / (square + N::constant(SOFTENING) * radius * radius).max(N::constant(MIN_SQUARE)).sqrt();
    let mut value = inverse * inverse;
    if let Some(normal) = normal {
        value = value * (mean_height(normal.dot(offset), radius) * inverse);
    }
    if let Some(axis) = axis {
        let length = axis.length();
        let cos_cone = (length - N::constant(2.0)).min(N::one());
        let (height, distance) = (-axis.dot(offset) / length, square.sqrt());
        let across = (square - height * height).max(N::zero()).sqrt();
        let beside_cone = height * cos_cone + across * (N::one() - cos_cone * cos_cone).max(N::zero()).sqrt();
        // Along the normal of the cone that faces the point most.
        let facing_height = N::select(height.lt(distance * cos_cone), beside_cone, distance);
        let facing = mean_height(facing_height, radius) * inverse;
        value = value * N::select(N::constant(FULL_CONE).lt(cos_cone), facing, N::one());
    }
    value
}

/// Length of a segment, divided by the importance for its medium of lights of unit intensity in a sphere with its centre at
/// `offset` from the origin. The importance is about the integral of the inverse square of the distance along the segment: its
/// length by the square of the least distance where that is large, and π by the distance for an endless line.
fn length_by_importance(offset: Vec3, radius: f32, direction: Vec3, length: f32) -> f32 {
    let nearest = offset - direction * offset.dot(direction).clamp(0.0, length);
    let square = (nearest.length_squared() + SOFTENING * radius * radius).max(MIN_SQUARE);
    square + LINE_SHARE * length * square.sqrt()
}

/// Mean height above a plane of the parts of a sphere that are above it, roughly; zero if none is. `height` is that of its centre.
#[inline(always)]
fn mean_height<N: Real>(height: N, radius: N) -> N {
    height.max(N::constant(HORIZON_SHARE) * (height + radius)).max(N::zero())
}

/// Subtree, before its lights have their order.
struct Subtree {
    lights: Half,
    count: usize,
    /// Colours of the first and of the last light.
    ends: [Vec3; 2],
    parts: Parts,
}

enum Parts {
    Light(u32),
    /// Two halves, each with its lights in reverse order or not.
    Halves(Box<[(Subtree, bool); 2]>),
}

impl Subtree {
    /// Subtree over these lights; `order` is partitioned on the way.
    fn new(lights: &[LightBounds], order: &mut [u32], depth: u32) -> Self {
        let group = order.iter().fold(Group::NOTHING, |all, &light| all.union(Group::of(&lights[light as usize])));
        let (half, count) = (group.half(lights, order), order.len());
        if let &mut [light] = order {
            let colour = lights[light as usize].intensity.normalize_or_zero();
            return Self { lights: half, count, ends: [colour; 2], parts: Parts::Light(light) };
        }
        let count_a = split(lights, order, depth);
        let (first, second) = order.split_at_mut(count_a);
        let [a, b] = [first, second].map(|part| Self::new(lights, part, depth + 1));
        // The end of each half that is next to the other.
        let gap = |[reverses_a, reverses_b]: [bool; 2]| {
            a.ends[usize::from(!reverses_a)].distance_squared(b.ends[usize::from(reverses_b)])
        };
        let ways = [[false, true], [true, false], [true, true]];
        let nearest = |best, way| if gap(way) < gap(best) { way } else { best };
        let [reverses_a, reverses_b] = ways.into_iter().fold([false, false], nearest);
        let ends = [a.ends[usize::from(reverses_a)], b.ends[usize::from(!reverses_b)]];
        Self { lights: half, count, ends, parts: Parts::Halves(Box::new([(a, reverses_a), (b, reverses_b)])) }
    }

    /// Appends the nodes, and the lights in the order of the leaves.
    fn append(&self, is_reversed: bool, nodes: &mut Vec<LightNode>, order: &mut Vec<u32>) {
        let halves = match &self.parts {
            Parts::Light(light) => return order.push(*light),
            Parts::Halves(halves) => halves,
        };
        let [first, second] = halves.as_ref();
        let [(a, reverses_a), (b, reverses_b)] = if is_reversed { [second, first] } else { [first, second] };
        let ratio = b.lights.strength / a.lights.strength.max(f64::MIN_POSITIVE);
        let scaled_axis = |cone: NormalCone| (cone.axis * (2.0 + cone.cosine)).into();
        nodes.push(LightNode {
            centre_a: a.lights.centre.into(),
            radius_a: a.lights.radius,
            centre_b: b.lights.centre.into(),
            radius_b: b.lights.radius,
            axis_a: scaled_axis(a.lights.normals),
            intensity_ratio: ratio.clamp(1.0 / MAX_RATIO, MAX_RATIO) as f32,
            axis_b: scaled_axis(b.lights.normals),
            count_a: a.count as f32,
        });
        a.append(*reverses_a != is_reversed, nodes, order);
        b.append(*reverses_b != is_reversed, nodes, order);
    }
}

/// Partitions lights into two halves by the surface area orientation heuristic over bins. Returns the number in the first.
fn split(lights: &[LightBounds], order: &mut [u32], depth: u32) -> usize {
    let centre = |light: u32| lights[light as usize].centre;
    let (min, max) = order.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &light| {
        (min.min(centre(light)), max.max(centre(light)))
    });
    let extent = max - min;
    let half = order.len() / 2;
    let longest = extent.max_position();
    if depth >= MAX_BINNED_DEPTH {
        order.select_nth_unstable_by(half, |&a, &b| centre(a)[longest].total_cmp(&centre(b)[longest]).then(a.cmp(&b)));
        return half;
    }
    let bin_of = |light: u32, axis: usize| {
        let along = (centre(light)[axis] - min[axis]) / extent[axis];
        ((along * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        // Infinite or zero for coinciding lights.
        if !(extent[axis] > 0.0 && extent[axis].is_finite()) {
            continue;
        }
        let mut bins = [Group::NOTHING; BINS];
        for &light in order.iter() {
            let bin = bin_of(light, axis);
            bins[bin] = bins[bin].union(Group::of(&lights[light as usize]));
        }
        let mut second = [Group::NOTHING; BINS];
        let mut group = Group::NOTHING;
        for bin in (1..BINS).rev() {
            group = group.union(bins[bin]);
            second[bin] = group;
        }
        // Thin halves of a long node are avoided.
        let thinness = f64::from(extent[longest] / extent[axis]);
        let mut first = Group::NOTHING;
        for end in 1..BINS {
            first = first.union(bins[end - 1]);
            if first.normals.is_none() || second[end].normals.is_none() {
                continue;
            }
            let cost = thinness * (first.cost() + second[end].cost());
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, end));
            }
        }
    }
    let Some((_, axis, end)) = best else { return half };
    let (first, second): (Vec<u32>, Vec<u32>) = order.iter().partition(|&&light| bin_of(light, axis) < end);
    order[..first.len()].copy_from_slice(&first);
    order[first.len()..].copy_from_slice(&second);
    first.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::ray::{mask_of, pack};
    use crate::sampling::sobol::PixelSampler;

    /// Uniform numbers in 0..1, four for each index.
    fn random(index: u32) -> [f32; 4] {
        let sampler = PixelSampler::new(3, 7, index, 11);
        let ([a, b], [c, d]) = (sampler.sample_2d(0), sampler.sample_2d(1));
        [a, b, c, d]
    }

    fn direction(u: f32, v: f32) -> Vec3 {
        let (sine, cosine) = (2.0 * PI * v).sin_cos();
        let z = 2.0 * u - 1.0;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cosine, radius * sine, z)
    }

    /// Points, balls, and sheets that face one way, of intensities from 1 to 1,000 W/sr.
    fn lights(count: u32) -> Vec<LightBounds> {
        let light = |k: u32| {
            let ([x, y, z, size], [u, v, kind, power]) = (random(2 * k), random(2 * k + 1));
            let normals = if kind < 0.5 { NormalCone::of(direction(u, v)) } else { NormalCone::ALL };
            let radius = if kind < 0.75 { 0.2 * size } else { 0.0 };
            LightBounds {
                centre: Vec3::new(4.0 * x, 3.0 * y, 5.0 * z),
                radius,
                normals,
                intensity: direction(u, power).abs() * 1000f32.powf(power),
            }
        };
        (0..count).map(light).collect()
    }

    fn tree(lights: &[LightBounds]) -> (LightTree, Vec<u32>) {
        LightTree::new(lights, 0, 1.0)
    }

    /// Number of nodes on the way to the deepest leaf.
    fn depth(tree: &LightTree, node: usize, count: usize) -> usize {
        if count < 2 {
            return 0;
        }
        let count_a = tree.nodes[node].count_a as usize;
        1 + depth(tree, node + 1, count_a).max(depth(tree, node + count_a, count - count_a))
    }

    #[test]
    fn lights_are_chosen_with_their_probability() {
        const SAMPLES: u32 = 20_000;
        for count in [1u32, 2, 3, 7, 40] {
            let (tree, order) = tree(&lights(count));
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..count), "every light is one leaf");
            for place in 0..12 {
                let [x, y, z, u] = random(1000 + place);
                // Some points are among the lights, some far away.
                let p = Vec3::new(x - 0.2, y - 0.2, z - 0.2) * if place < 8 { 5.0 } else { 100.0 };
                let normal = (place % 3 > 0).then(|| direction(u, x));
                let expected: Vec<f32> = (0..count as usize).map(|leaf| tree.probability(leaf, p, normal)).collect();
                let mut counts = vec![0u32; count as usize];
                for k in 0..SAMPLES {
                    if let Some((leaf, probability)) = tree.sample(p, normal, (k as f32 + 0.5) / SAMPLES as f32) {
                        assert_eq!(probability, expected[leaf], "the walk to a leaf has its probability");
                        counts[leaf] += 1;
                    }
                }
                // The numbers are evenly spaced, so counts are off by one at each end of an interval.
                for (leaf, (&counted, &expected)) in counts.iter().zip(&expected).enumerate() {
                    let difference = (counted as f32 - expected * SAMPLES as f32).abs();
                    assert!(difference < 2.5, "{count} lights, place {place}, leaf {leaf}: {counted}, {expected}");
                }
                let none = 1.0 - counts.iter().sum::<u32>() as f32 / SAMPLES as f32;
                let total = expected.iter().sum::<f32>() + none;
                assert!((total - 1.0).abs() < 1e-3, "{count} lights, place {place}: {total}");
                if normal.is_none() && tree.nodes.iter().all(|node| Vec3::from(node.axis_a).length() < 1.001) {
                    assert_eq!(none, 0.0);
                }
            }
        }
    }

    #[test]
    fn lights_are_chosen_for_segments_with_their_probability() {
        const SAMPLES: u32 = 20_000;
        for count in [1u32, 2, 7, 40] {
            let (tree, _) = tree(&lights(count));
            for (place, length) in (0..).zip([0.0, 1e-6, 0.5, 4.0, 1e7]) {
                let ([x, y, z, _], [u, v, ..]) = (random(1000 + place), random(2000 + place));
                let ray = Ray { origin: Vec3::new(x - 0.2, y - 0.2, z - 0.2) * 5.0, direction: direction(u, v) };
                // Probability and number of the samples of each light.
                let mut found = vec![(0.0f32, 0u32); count as usize];
                for k in 0..SAMPLES {
                    let number = (k as f32 + 0.5) / SAMPLES as f32;
                    let (leaf, probability) = tree.sample_along(&ray, length, number).expect("a light");
                    found[leaf] = (probability, found[leaf].1 + 1);
                }
                let sum: f32 = found.iter().map(|(probability, _)| probability).sum();
                // Lights of a probability below one in 20,000 may not be found.
                assert!((sum - 1.0).abs() < 3e-3, "{count} lights, {length} m: {sum}");
                for (probability, counted) in found {
                    let difference = (counted as f32 - probability * SAMPLES as f32).abs();
                    assert!(difference < 2.5, "{count} lights, {length} m: {counted}, {probability}");
                }
            }
        }
    }

    #[test]
    fn lights_close_to_a_segment_are_preferred() {
        let at =
            |x: f32| LightBounds { centre: Vec3::X * x, radius: 0.0, normals: NormalCone::ALL, intensity: Vec3::X };
        let (tree, order) = tree(&[at(0.0), at(10.0), at(20.0), at(30.0)]);
        let ray = Ray { origin: Vec3::new(20.0, -50.0, 0.5), direction: Vec3::Y };
        // The segment passes the third light if it is long, and ends far away from all of them if it is short.
        let [passes, ends] = [100.0, 1.0].map(|length| {
            let of_third = |k: u32| {
                let (leaf, probability) = tree.sample_along(&ray, length, k as f32 / 64.0).expect("a light");
                (order[leaf] == 2).then_some(probability)
            };
            (0..64).find_map(of_third).expect("it is found")
        });
        assert!(passes > 0.7 && (0.2..0.35).contains(&ends), "{passes} {ends}");
    }

    #[test]
    fn eight_points_walk_as_one() {
        for count in [1u32, 2, 7, 40] {
            let all = lights(count);
            // With and without lights that face one side.
            let everywhere = all.iter().map(|light| LightBounds { normals: NormalCone::ALL, ..*light }).collect();
            for lights in [all, everywhere] {
                let (tree, _) = tree(&lights);
                for block in 0..40 {
                    let numbers: [[f32; 4]; 8] = std::array::from_fn(|lane| random(3000 + 8 * block + lane as u32));
                    let points = numbers.map(|[x, y, z, _]| Vec3::new(x - 0.2, y - 0.2, z - 0.2) * 5.0);
                    let normals = numbers.map(|[x, .., u]| direction(u, x));
                    let choices: [f32; 8] = std::array::from_fn(|lane| random(7000 + 8 * block + lane as u32)[0]);
                    let active = |lane: usize| lane as u32 != block % 9;
                    let mask = mask_of((0..8).map(|lane| u32::from(active(lane)) << lane).sum());
                    let (leaves, probabilities) =
                        tree.sample_in_lanes(pack(points), pack(normals), choices.into(), mask);
                    for (lane, probability) in probabilities.to_array().into_iter().enumerate() {
                        let alone = tree.sample(points[lane], Some(normals[lane]), choices[lane]);
                        let alone = alone.filter(|_| active(lane));
                        let together = (probability > 0.0).then_some((leaves[lane], probability));
                        assert_eq!(together, alone, "{count} lights, block {block}, lane {lane}");
                    }
                }
            }
        }
    }

    /// A light that can contribute, from any point of its sphere to the point with this normal, has a probability.
    #[test]
    fn only_lights_without_a_contribution_are_never_chosen() {
        let lights = lights(60);
        let (tree, order) = tree(&lights);
        let (mut never, mut contributing) = (0, 0);
        for place in 0..200 {
            let [x, y, z, u] = random(5000 + place);
            let (p, normal) = (Vec3::new(4.0 * x, 3.0 * y, 5.0 * z), direction(u, x));
            for (leaf, &light) in order.iter().enumerate() {
                let light = &lights[light as usize];
                let is_lit = (0..24).any(|k| {
                    let [u, v, w, _] = random(9000 + k);
                    let offset = light.centre + direction(u, v) * (0.99 * w * light.radius) - p;
                    let towards = offset.normalize();
                    let facing = light.normals.cosine < 0.0 || -light.normals.axis.dot(towards) > 1e-3;
                    normal.dot(towards) > 1e-3 && facing
                });
                let probability = tree.probability(leaf, p, Some(normal));
                assert!(probability > 0.0 || !is_lit, "place {place}, light {light:?}");
                never += u32::from(probability == 0.0);
                contributing += u32::from(is_lit);
            }
        }
        println!("never chosen {never}, contributing {contributing} of {}", 200 * 60);
        assert!(never > 3000 && contributing > 3000, "{never} {contributing}");
    }

    #[test]
    fn close_lights_are_preferred() {
        let at =
            |x: f32| LightBounds { centre: Vec3::X * x, radius: 0.0, normals: NormalCone::ALL, intensity: Vec3::X };
        let (tree, order) = tree(&[at(0.0), at(10.0), at(20.0), at(30.0)]);
        let second = order.iter().position(|&light| light == 1).expect("a leaf");
        let probability = tree.probability(second, Vec3::new(10.0, 1.0, 0.0), None);
        assert!(probability > 0.8, "{probability}");
    }

    #[test]
    fn lights_of_like_colours_are_neighbours() {
        let lights: Vec<LightBounds> = (0..256)
            .map(|k| {
                let [u, v, ..] = random(k);
                let centre = Vec3::new((k % 16) as f32, 0.0, (k / 16) as f32);
                LightBounds { centre, radius: 0.0, normals: NormalCone::ALL, intensity: direction(u, v).abs() }
            })
            .collect();
        let mean_gap = |order: &[u32]| {
            let colours = order.iter().map(|&light| lights[light as usize].intensity);
            let gaps = colours.clone().zip(colours.skip(1)).map(|(a, b)| a.distance_squared(b));
            gaps.sum::<f32>() / 255.0
        };
        let by_chance = mean_gap(&(0..256).collect::<Vec<_>>());
        let ordered = mean_gap(&tree(&lights).1);
        assert!(ordered < 0.75 * by_chance, "{ordered} {by_chance}");
    }

    #[test]
    fn lights_in_one_point_are_chosen_by_their_intensity() {
        let light = LightBounds { centre: Vec3::ONE, radius: 0.0, normals: NormalCone::ALL, intensity: Vec3::X * 2.0 };
        let (tree, _) = tree(&[light; 10_000]);
        assert!(depth(&tree, 0, tree.count) < 16);
        for p in [Vec3::ONE, Vec3::ZERO, Vec3::new(1e6, 0.0, 0.0)] {
            for leaf in [0, 1234, 9999] {
                let probability = tree.probability(leaf, p, None);
                assert!((probability * 1e4 - 1.0).abs() < 1e-3, "{probability}");
            }
        }
    }

    #[test]
    fn walks_are_short() {
        // Every light is at half the distance of the one before, so that bins separate few at a time.
        let near = |k: i32| LightBounds {
            centre: Vec3::new(2f32.powi(-k), 0.0, 0.0),
            radius: 0.0,
            normals: NormalCone::ALL,
            intensity: Vec3::X * 4f32.powi(k % 20),
        };
        let lights: Vec<_> = (0..120).flat_map(|k| [near(k); 40]).collect();
        let (tree, _) = tree(&lights);
        let depth = depth(&tree, 0, tree.count);
        assert!(depth <= MAX_BINNED_DEPTH as usize + 13, "{depth}");
        let sum: f32 = (0..tree.count).map(|leaf| tree.probability(leaf, Vec3::new(0.1, 0.2, 0.0), None)).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn cones_contain_their_parts() {
        for k in 0..300 {
            let ([a, b, c, d], [e, f, ..]) = (random(2 * k), random(2 * k + 1));
            let cone = |axis, angle: f32| NormalCone { axis, cosine: (1.5 * angle).cos() };
            let parts = [cone(direction(a, b), c), cone(direction(d, e), f)];
            let union = parts[0].union(parts[1]);
            for part in parts {
                let between = union.axis.dot(part.axis).clamp(-1.0, 1.0).acos();
                let end = (between + part.cosine.acos()).min(PI);
                assert!(union.cosine <= -1.0 || end <= union.cosine.acos() + 1e-3, "{parts:?} {union:?}");
            }
        }
    }
}
