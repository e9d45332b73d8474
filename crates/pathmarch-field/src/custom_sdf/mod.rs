//! Fields that a scene declares itself: a WGSL function `distance(p: vec3f) -> f32` as a shape like any other.
//!
//! naga reads and checks the text. Three things are made of it. The text for the GPU is printed from naga's tree under names that
//! nothing else has, its loops made to count ([`budget`]). For the CPU the tree is compiled (`compile`) and run for eight points
//! at once (`machine`), so that what needs the CPU (layers, meshes, the survey, machines without a driver) works with own fields,
//! too. And whatever one of the two cannot have is refused with the place in the text where it stands.
//!
//! The value is divided by the declared Lipschitz constant and cut by the declared box, so that a true declaration gives a safe
//! lower bound of slope one (Hart 1996, section 2.2). Where it is not finite, the point counts as outside, a hundredth of the size
//! from the surface: a march steps over a single bad point, and a bad region is empty.
//!
//! There is no dual number of a text, so the gradient is that of central differences, over a 4,000th of the size: the
//! edge of the box, or the distance to the origin of an endless field where that is larger. It costs seven evaluations, once for each
//! surface that is met. A gradient of zero counts as one upwards.

pub mod budget;
mod compile;
mod machine;
mod math;
mod module;
mod size;

use crate::bounds::Aabb;
use crate::expression::Function;
use crate::graph::Batch;
use crate::info::Info;
use crate::number::{Dual, Real, Vec3};
use crate::parameter::Param;
use crate::shapes::orbit;
use crate::shapes::{self, EvalShape, Shape, ShapeDef};
use machine::{Machine, Mask};
pub use module::Code;
use std::cell::RefCell;
use std::collections::HashSet;
use std::ops::Range;
use std::sync::{Arc, Mutex};
use wide::f32x8;

/// The longest text of a field, bytes.
pub const MAX_BYTES: usize = 64 << 10;
/// The most parameters of a field.
pub const MAX_PARAMS: usize = 32;

/// Something wrong in the text of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct CodeDiagnostic {
    /// One sentence.
    pub message: String,
    /// What is wrong at the place.
    pub label: String,
    /// Bytes of the text; the text as a whole where there is no place.
    pub range: Option<Range<usize>>,
    /// What to do about it.
    pub help: Option<String>,
}

fn range(span: naga::Span) -> Option<Range<usize>> {
    span.to_range().filter(|range| *range != (0..0))
}

/// A shape that a scene declares.
pub struct CustomShape {
    info: Info,
    params: Vec<Param>,
    lipschitz: f32,
    edges: Option<[f32; 3]>,
    code: Arc<Code>,
}

/// Bytes of all names and descriptions that a program ever gave to own shapes: more than a person types in a year.
const MAX_NAMES: usize = 64 << 20;

static NAMES: Mutex<(Option<HashSet<&'static str>>, usize)> = Mutex::new((None, 0));

/// A name or description as shapes have it: for as long as the program runs. The same text is kept once; nothing past 64 MiB
/// of different ones, which is far from what editing comes to.
pub fn keep(text: &str) -> Option<&'static str> {
    let mut names = NAMES.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let (known, bytes) = &mut *names;
    let known = known.get_or_insert_default();
    if let Some(name) = known.get(text) {
        return Some(name);
    }
    *bytes += text.len();
    if *bytes > MAX_NAMES {
        return None;
    }
    let name: &'static str = text.to_owned().leak();
    known.insert(name);
    Some(name)
}

/// Half an edge of what has no end.
const ENDLESS: f32 = 1e30;
/// Numbers besides the parameters: the Lipschitz constant and half the edges.
const MORE: usize = 4;
/// Share of the size over which differences are taken.
const STEP: f32 = 2.5e-4;
/// Share of the size that a point is from the surface where the value is not finite.
const LOST: f32 = 0.01;

thread_local! {
    /// Machines of the fields that were evaluated last.
    static MACHINES: RefCell<Vec<(u64, Machine)>> = const { RefCell::new(Vec::new()) };
}

/// Machines kept on a thread.
const KEPT: usize = 4;

impl CustomShape {
    /// The shape of this code, whose parameters `params` are. `lipschitz` is above zero; `edges` are those of a box around the
    /// origin that cuts the solid, `None` for an endless one.
    pub fn new(info: Info, params: Vec<Param>, lipschitz: f32, edges: Option<[f32; 3]>, code: Arc<Code>) -> Self {
        Self { info, params, lipschitz, edges, code }
    }

    fn half(numbers: &[f32]) -> [f32; 3] {
        let n = numbers.len();
        [numbers[n - 3], numbers[n - 2], numbers[n - 1]]
    }

    /// The length that steps and errors are measured against.
    fn size<N: Batch>(p: Vec3<N>, [x, y, z]: [f32; 3]) -> N {
        let edge = N::constant(2.0 * x.max(y).max(z));
        edge.min(p.abs().largest().max(N::one()))
    }

    /// The text's value over the Lipschitz constant, at the points in the mask.
    fn estimate(&self, p: Vec3<f32x8>, numbers: &[f32], mask: Mask) -> f32x8 {
        let program = &self.code.program;
        let params = &numbers[..numbers.len() - MORE];
        let slope = numbers[numbers.len() - MORE];
        let point = [p.x, p.y, p.z].map(|v| v.to_array().map(f32::to_bits));
        let values = MACHINES.with_borrow_mut(|machines| {
            let place = machines.iter().position(|(id, _)| *id == self.code.id);
            let (id, mut machine) = match place {
                Some(place) => machines.swap_remove(place),
                None => (self.code.id, Machine::new(program)),
            };
            let values = machine.run(program, point, params, mask);
            machines.truncate(KEPT - 1);
            machines.insert(0, (id, machine));
            values
        });
        let lost = Self::size(p, Self::half(numbers)).to_array();
        f32x8::from(std::array::from_fn(|lane| {
            let value = f32::from_bits(values[lane]);
            if value.is_finite() { value / slope } else { LOST * lost[lane] }
        }))
    }

    /// Central differences at one point and the value there; all points of it in one go.
    fn differences(&self, p: Vec3<f32>, numbers: &[f32]) -> Dual<f32> {
        let h = STEP * Self::size(p, Self::half(numbers));
        let along = |axis: usize, v: f32| {
            f32x8::from(std::array::from_fn(|lane| match lane {
                _ if lane / 2 != axis => v,
                _ if lane % 2 == 0 => v + h,
                _ => v - h,
            }))
        };
        let points = Vec3::new(along(0, p.x), along(1, p.y), along(2, p.z));
        let v = self.estimate(points, numbers, 0b0111_1111).to_array();
        let inverse = 1.0 / (2.0 * h);
        let gradient = Vec3::new((v[0] - v[1]) * inverse, (v[2] - v[3]) * inverse, (v[4] - v[5]) * inverse);
        Dual { value: v[6], gradient: upwards(gradient) }
    }
}

/// A gradient, but of zero one upwards.
fn upwards(gradient: Vec3<f32>) -> Vec3<f32> {
    if gradient.dot(gradient) < 1e-12 { Vec3::new(0.0, 1.0, 0.0) } else { gradient }
}

/// Distance to the box of half these edges.
#[inline(always)]
fn bound<N: Real>(p: Vec3<N>, half: [N; 3]) -> N {
    <shapes::Box as ShapeDef>::distance(p, half.map(|half| half + half))
}

/// How far outside the box the estimate counts.
#[inline(always)]
fn reach<N: Real>([x, y, z]: [N; 3]) -> N {
    x.max(y.max(z))
}

/// What is known of the distance at `p`: the estimate, cut by the box.
#[inline(always)]
fn cut<N: Real>(p: Vec3<N>, estimate: N, half: [N; 3]) -> N {
    orbit::within(estimate, bound(p, half), reach(half))
}

impl EvalShape<f32> for CustomShape {
    fn distance(&self, p: Vec3<f32>, numbers: &[f32]) -> f32 {
        let half = Self::half(numbers);
        let bound = bound(p, half);
        if !orbit::is_near(bound, reach(half)) {
            return bound;
        }
        let points = Vec3::new(f32x8::splat(p.x), f32x8::splat(p.y), f32x8::splat(p.z));
        cut(p, self.estimate(points, numbers, 1).to_array()[0], half)
    }
    fn gradient(&self, p: Vec3<Dual<f32>>, numbers: &[f32]) -> Dual<f32> {
        let (point, half) = (p.values(), Self::half(numbers));
        let estimate = match orbit::is_near(bound(point, half), reach(half)) {
            true => self.differences(point, numbers),
            false => Dual::independent(0.0),
        };
        let local = cut(Dual::variables(point), estimate, half.map(Dual::independent));
        Dual { value: local.value, gradient: p.pulled(local.gradient) }
    }
}

impl EvalShape<f32x8> for CustomShape {
    fn distance(&self, p: Vec3<f32x8>, numbers: &[f32]) -> f32x8 {
        let half = Self::half(numbers).map(f32x8::splat);
        let bound = bound(p, half);
        let near = orbit::is_near(bound, reach(half)).0.to_bitmask() as Mask;
        if near == 0 {
            return bound;
        }
        cut(p, self.estimate(p, numbers, near), half)
    }
    fn gradient(&self, p: Vec3<Dual<f32x8>>, numbers: &[f32]) -> Dual<f32x8> {
        let point = p.values();
        let [x, y, z] = [point.x, point.y, point.z].map(f32x8::to_array);
        let one = |lane: usize| self.gradient(Dual::variables(Vec3::new(x[lane], y[lane], z[lane])), numbers);
        let lanes: [Dual<f32>; 8] = std::array::from_fn(one);
        let gather = |of: &dyn Fn(&Dual<f32>) -> f32| f32x8::from(std::array::from_fn(|lane| of(&lanes[lane])));
        let gradient = Vec3::new(gather(&|d| d.gradient.x), gather(&|d| d.gradient.y), gather(&|d| d.gradient.z));
        Dual { value: gather(&|d| d.value), gradient: p.pulled(gradient) }
    }
}

impl Shape for CustomShape {
    fn info(&self) -> &Info {
        &self.info
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn is_trusted(&self) -> bool {
        false
    }
    fn declared_lipschitz(&self) -> Option<f32> {
        Some(self.lipschitz)
    }
    fn coefficients(&self, params: &[f32]) -> Vec<f32> {
        let half = self.edges.map_or([ENDLESS; 3], |edges| edges.map(|edge| 0.5 * edge));
        let given = self.params.iter().enumerate().map(|(k, param)| params.get(k).copied().unwrap_or(param.default));
        given.chain([self.lipschitz]).chain(half).collect()
    }
    fn bounds(&self, _params: &[f32]) -> Aabb {
        self.edges.map_or(Aabb::EVERYTHING, |[x, y, z]| Aabb::centred(0.5 * x, 0.5 * y, 0.5 * z))
    }
    fn lipschitz(&self, _params: &[f32]) -> f32 {
        1.0
    }
    fn wgsl_name(&self) -> String {
        format!("own_{}", self.code.identifier)
    }
    fn wgsl_distance(&self) -> String {
        self.code.wgsl_distance()
    }
    fn wgsl_gradient(&self) -> String {
        self.code.wgsl_gradient()
    }
}

/// The functions around the printed text, which has the function `entry`; the arguments of all are the point, the parameters,
/// the Lipschitz constant and half the edges.
fn wgsl_distance(name: &str, entry: &str, params: usize) -> String {
    let half = |inputs: &[crate::expression::Expr]| [inputs[0], inputs[1], inputs[2]];
    let point = |inputs: &[crate::expression::Expr]| Vec3::new(inputs[0], inputs[1], inputs[2]);
    let edges = [("x", "f32"), ("y", "f32"), ("z", "f32")];
    let function = |suffix: &str, doc: &str, more: &[(&'static str, &'static str)]| Function {
        name: format!("{name}_{suffix}"),
        doc: doc.to_owned(),
        parameters: [("p", "vec3f")].into_iter().chain(more.iter().copied()).chain(edges).collect(),
    };
    let bounds = function("bound", "Distance to the box of half these edges.", &[])
        .print(&|inputs| vec![bound(point(inputs), half(&inputs[3..]))]);
    let cuts = function("cut", "The estimate, cut by the box.", &[("estimate", "f32")])
        .print(&|inputs| vec![cut(point(inputs), inputs[3], half(&inputs[4..]))]);
    let signature = signature(params);
    let arguments: String = (0..params).map(|k| format!(", n{k}")).collect();
    format!(
        "{bounds}\n{cuts}\n\
         /// The length that steps and errors are measured against.\n\
         fn {name}_size(p: vec3f, x: f32, y: f32, z: f32) -> f32 {{\n    \
         let a = abs(p);\n    \
         return min(2.0 * max(x, max(y, z)), max(1.0, max(a.x, max(a.y, a.z))));\n}}\n\n\
         /// The scene's function over its Lipschitz constant.\n\
         fn {name}_estimate(p: vec3f{signature}) -> f32 {{\n    \
         let value = {entry}(p{arguments});\n    \
         if (bitcast<u32>(value) & 0x7f800000u) == 0x7f800000u {{\n        \
         return {LOST} * {name}_size(p, x, y, z);\n    }}\n    \
         return value / slope;\n}}\n\n\
         /// A shape of the scene's own.\n\
         fn {name}_distance(p: vec3f{signature}) -> f32 {{\n    \
         let bound = {name}_bound(p, x, y, z);\n    \
         if bound >= max(x, max(y, z)) {{\n        return bound;\n    }}\n    \
         return {name}_cut(p, {name}_estimate(p{arguments}, slope, x, y, z), x, y, z);\n}}\n"
    )
}

/// As [`wgsl_distance`], which must stand beside it.
fn wgsl_gradient(name: &str, params: usize) -> String {
    let parameters = [("p", "vec3f"), ("estimate", "vec4f"), ("x", "f32"), ("y", "f32"), ("z", "f32")];
    let doc = "Gradient (xyz) and distance (w) of the estimate, cut by the box.".to_owned();
    let cuts =
        Function { name: format!("{name}_cut_gradient"), doc, parameters: parameters.to_vec() }.print(&|inputs| {
            let p = Dual::variables(Vec3::new(inputs[0], inputs[1], inputs[2]));
            let estimate = Dual { value: inputs[6], gradient: Vec3::new(inputs[3], inputs[4], inputs[5]) };
            let result = cut(p, estimate, [inputs[7], inputs[8], inputs[9]].map(Dual::independent));
            vec![result.gradient.x, result.gradient.y, result.gradient.z, result.value]
        });
    let signature = signature(params);
    let arguments: String = (0..params).map(|k| format!(", n{k}")).collect();
    format!(
        "{cuts}\n/// Gradient (xyz) by central differences and distance (w) of a shape of the scene's own.\n\
         fn {name}_gradient(p: vec3f{signature}) -> vec4f {{\n    \
         var estimate = vec4f(0.0);\n    \
         if {name}_bound(p, x, y, z) < max(x, max(y, z)) {{\n        \
         let h = {STEP} * {name}_size(p, x, y, z);\n        \
         var gradient = vec3f(0.0);\n        \
         for (var axis = 0u; axis < 3u; axis++) {{\n            \
         let along = vec3f(f32(axis == 0u), f32(axis == 1u), f32(axis == 2u));\n            \
         let ahead = {name}_estimate(p + along * h{arguments}, slope, x, y, z);\n            \
         gradient += along * (ahead - {name}_estimate(p - along * h{arguments}, slope, x, y, z));\n        }}\n        \
         gradient /= 2.0 * h;\n        \
         if dot(gradient, gradient) < 1e-12 {{\n            gradient = vec3f(0.0, 1.0, 0.0);\n        }}\n        \
         estimate = vec4f(gradient, {name}_estimate(p{arguments}, slope, x, y, z));\n    }}\n    \
         return {name}_cut_gradient(p, estimate, x, y, z);\n}}\n"
    )
}

fn signature(params: usize) -> String {
    let params: String = (0..params).map(|k| format!(", n{k}: f32")).collect();
    format!("{params}, slope: f32, x: f32, y: f32, z: f32")
}
