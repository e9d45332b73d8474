//! Random numbers, points and parameters for the tests; the same in every run.
#![allow(dead_code)]

use naga::valid::{Capabilities, ValidationFlags, Validator};
use pathmarch_field::number::{Dual, Vec3};
use pathmarch_field::registry::shapes;
use pathmarch_field::wgsl::{Program, TABLE};
use pathmarch_field::{Aabb, Shape, Unit};
use wide::f32x8;

/// A small generator (SplitMix64; Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    /// A stream of its own for each seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }
    /// A stream for each name and number, so that tests over the registry use the same numbers for a shape whichever
    /// other shapes there are.
    pub fn named(name: &str, number: u64) -> Self {
        // FNV-1a (Fowler, Noll and Vo 1991).
        let hash = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        Self::new(name.bytes().fold(0xcbf2_9ce4_8422_2325, hash).wrapping_add(number))
    }
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// Uniform in `low..high`.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 40) as f32 / 16_777_216.0)
    }
    /// Uniform in the box.
    pub fn point(&mut self, bounds: Aabb) -> Vec3<f32> {
        let [x, y, z] = std::array::from_fn(|k| self.within(bounds.min[k], bounds.max[k]));
        Vec3::new(x, y, z)
    }
    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3<f32> {
        loop {
            let v = self.point(Aabb::centred(1.0, 1.0, 1.0));
            if (0.01..1.0).contains(&v.length()) {
                return v / v.length();
            }
        }
    }
}

/// A shape with numbers, and the box to sample it in.
pub struct Case {
    pub shape: &'static dyn Shape,
    pub params: Vec<f32>,
    /// Its bounds, cut to three metres where they have no end.
    pub bounds: Aabb,
    /// Longest edge of `bounds`, metres.
    pub size: f32,
}

impl Case {
    /// Distances and gradients of eight points side by side are those of each by itself, at this many random points.
    pub fn assert_lanes_equal_one(&self, count: usize, random: &mut Random) {
        // Iterations of fractals magnify the rounding by which lanes and single points differ.
        let gradient_tolerance = if self.shape.has_orbit() { 2e-3 } else { 1e-4 };
        for points in self.points(count, random).chunks(8) {
            let p = lanes(points);
            let distances = self.shape.distance(p, &self.params).to_array();
            let fields = self.shape.gradient(Dual::variables(p), &self.params);
            for (k, &point) in points.iter().enumerate() {
                let tolerance = 1e-6 * (point.length() + self.size);
                let field = self.gradient(point);
                assert!((distances[k] - self.distance(point)).abs() <= tolerance, "{} {point:?}", self.name());
                assert!((fields.value.to_array()[k] - field.value).abs() <= tolerance, "{} {point:?}", self.name());
                let [x, y, z] = [fields.gradient.x, fields.gradient.y, fields.gradient.z].map(|v| v.to_array()[k]);
                let apart = (Vec3::new(x, y, z) - field.gradient).length();
                assert!(apart < gradient_tolerance, "{} {point:?}: gradients {apart} apart", self.name());
            }
        }
    }
    /// From a shape and its numbers.
    pub fn new(shape: &'static dyn Shape, params: Vec<f32>) -> Self {
        let params = shape.coefficients(&params);
        let bounds = shape.bounds(&params).intersection(Aabb::centred(3.0, 3.0, 3.0));
        let size = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max);
        Self { shape, params, bounds, size }
    }
    /// Random numbers of the shape with its parameters.
    pub fn random(&self, number: u64) -> Random {
        Random::named(&self.name(), number)
    }
    /// What to print when something is wrong.
    pub fn name(&self) -> String {
        format!("{} {:?}", self.shape.info().name, &self.params[..self.params.len().min(12)])
    }
    pub fn distance(&self, p: Vec3<f32>) -> f32 {
        self.shape.distance(p, &self.params)
    }
    pub fn gradient(&self, p: Vec3<f32>) -> Dual<f32> {
        self.shape.gradient(Dual::variables(p), &self.params)
    }
    pub fn lipschitz(&self) -> f32 {
        self.shape.lipschitz(&self.params)
    }
    /// Half of the points around the shape, a quarter within its bounds, a quarter far away.
    pub fn points(&self, count: usize, random: &mut Random) -> Vec<Vec3<f32>> {
        (0..count)
            .map(|k| match k % 4 {
                0 => random.point(self.bounds),
                1 => random.direction() * (self.size * random.within(2.0, 20.0)),
                _ => random.point(self.bounds.expanded(self.size)),
            })
            .collect()
    }
    /// Points whose coordinates are the centre's, the bounds', almost or exactly zero, or huge, in all combinations.
    pub fn special_points(&self) -> Vec<Vec3<f32>> {
        let values: [Vec<f32>; 3] = std::array::from_fn(|k| {
            let (low, high) = (self.bounds.min[k], self.bounds.max[k]);
            vec![0.0, low, high, 0.5 * (low + high), 0.5 * low, 0.5 * high, 1e-20, -1e-8, 1e4, -self.size]
        });
        let [x, y, z] = &values;
        x.iter().flat_map(|&x| y.iter().flat_map(move |&y| z.iter().map(move |&z| Vec3::new(x, y, z)))).collect()
    }
    /// Points on the surface: random ones moved along the gradient.
    pub fn surface_points(&self, count: usize, random: &mut Random) -> Vec<Vec3<f32>> {
        let project = |mut p: Vec3<f32>| {
            for _ in 0..8 {
                let field = self.gradient(p);
                p = p - field.gradient * (field.value / field.gradient.dot(field.gradient).max(1e-6));
            }
            p
        };
        let points = self.points(count, random).into_iter().map(project);
        points.filter(|p| self.distance(*p).abs() < 1e-5 * self.size).collect()
    }
}

/// Every shape with its defaults and with `random_sets` further sets of parameters.
pub fn cases(random_sets: usize) -> Vec<Case> {
    let mut cases = Vec::new();
    for shape in shapes() {
        let mut random = Random::named(&shape.info().name, 0);
        let defaults: Vec<f32> = shape.params().iter().map(|p| p.default).collect();
        cases.push(Case::new(*shape, defaults));
        if !shape.params().is_empty() {
            cases.extend((0..random_sets).map(|_| Case::new(*shape, random_params(*shape, &mut random))));
        }
    }
    cases
}

/// Lengths between a fifth and three times the default, other numbers of a limited range within a tenth of it around the
/// default, counts anywhere in their range, angles any; a tube is thinner than its ring.
pub fn random_params(shape: &dyn Shape, random: &mut Random) -> Vec<f32> {
    let mut params: Vec<f32> = (shape.params().iter())
        .map(|param| match param.unit {
            Unit::Metres => param.default * random.within(0.2f32.ln(), 3f32.ln()).exp(),
            Unit::Degrees => random.within(-180.0, 180.0),
            Unit::Count => random.within(param.range.min, param.range.max + 1.0).floor().min(param.range.max),
            Unit::Ratio if param.range.max - param.range.min < f32::MAX => {
                param.default + random.within(-0.1, 0.1) * (param.range.max - param.range.min)
            }
            Unit::Ratio | Unit::Axis => param.default,
        })
        .zip(shape.params())
        .map(|(value, param)| value.clamp(param.range.min, param.range.max))
        .collect();
    let index = |name| shape.params().iter().position(|p| p.name == name);
    if let (Some(major), Some(minor)) = (index("major"), index("minor")) {
        params[minor] = params[minor].min(0.9 * params[major]);
    }
    params
}

/// Eight points side by side.
pub fn lanes(points: &[Vec3<f32>]) -> Vec3<f32x8> {
    let gather = |f: fn(&Vec3<f32>) -> f32| f32x8::from(std::array::from_fn(|k| f(&points[k])));
    Vec3::new(gather(|p| p.x), gather(|p| p.y), gather(|p| p.z))
}

/// The declaration that a program's code expects.
pub fn declared(program: &Program) -> String {
    let space = if program.is_uniform() { "uniform" } else { "storage, read" };
    program.declaration(&format!("@group(0) @binding(0) var<{space}>"))
}

/// What the functions of a shape that reads a table expect.
pub fn table() -> String {
    format!(
        "@group(0) @binding(0) var<storage, read> field_parameters: array<vec4f>;\nfn field_vector(index: u32) -> vec4f {{ return \
         field_parameters[index]; }}\nfn field_vector_count() -> u32 {{ return arrayLength(&field_parameters); }}\n{TABLE}"
    )
}

/// Fails with naga's message unless `source` is valid WGSL.
pub fn validate(source: &str) {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
}
