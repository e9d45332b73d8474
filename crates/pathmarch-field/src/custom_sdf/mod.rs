//! Custom shapes: a scene declares a WGSL function `distance(p: vec3f) -> f32` as a shape like any other.
//!
//! naga parses and validates the code (`module`). For the GPU its tree is printed again under unique names, with a budget for
//! loops ([`budget`]). For the CPU it is compiled (`compile`) and interpreted for eight points at once (`machine`), so that
//! layers, meshes, the Lipschitz check and machines without a driver support custom shapes, too. Code that either of the two
//! does not support is refused, with its place in the text.
//!
//! The value is divided by the declared Lipschitz constant and clipped to the declared box, so that a true declaration gives a
//! safe lower bound of slope one (Hart 1996, section 2.2). If it is not finite, the point is outside, a hundredth of the size
//! from the surface: sphere tracing steps over a single bad point, and a bad region is empty.
//!
//! The code has no dual numbers, so the gradient is that of central differences, over a 4,000th of the size: the edge of the
//! box, or the distance to the origin of an unbounded shape if that is larger. It costs seven evaluations for each hit. A zero
//! gradient is replaced by one upwards.

pub mod budget;
mod compile;
pub mod glsl;
mod machine;
mod math;
mod messages;
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
use std::ops::Range;
use std::sync::Arc;
use wide::f32x8;

/// Largest length of the code of a custom shape, bytes.
pub const MAX_BYTES: usize = 64 << 10;
/// Largest number of parameters of a custom shape.
pub const MAX_PARAMS: usize = 32;

/// Mistake in the code of a custom shape.
#[derive(Clone, Debug, PartialEq)]
pub struct CodeDiagnostic {
    /// One sentence.
    pub message: String,
    /// Label of the place.
    pub label: String,
    /// Byte range in the code; `None` for the code as a whole.
    pub range: Option<Range<usize>>,
    /// Suggested remedy.
    pub help: Option<String>,
}

fn range(span: naga::Span) -> Option<Range<usize>> {
    span.to_range().filter(|range| *range != (0..0))
}

/// Shape that a scene declares.
pub struct CustomShape {
    info: Info,
    params: Vec<Param>,
    lipschitz: f32,
    edges: Option<[f32; 3]>,
    code: Arc<Code>,
}

/// Half edge of the box of an unbounded shape, metres.
const UNBOUNDED: f32 = 1e30;
/// Number of coefficients behind the parameters: the Lipschitz constant and the half edges.
const EXTRA_COEFFICIENTS: usize = 4;
/// Step of central differences, as a fraction of the size.
const DIFFERENCE_STEP: f32 = 2.5e-4;
/// Distance where the value is not finite, as a fraction of the size.
const NON_FINITE_DISTANCE: f32 = 0.01;

thread_local! {
    /// Machines of the shapes that were evaluated last, the most recent first.
    static MACHINES: RefCell<Vec<(u64, Machine)>> = const { RefCell::new(Vec::new()) };
}

/// Machines kept on a thread.
const MAX_MACHINES: usize = 4;

impl CustomShape {
    /// Makes a shape of its code and parameters. `lipschitz` is above zero; `edges` are those of the box around the origin that
    /// clips the solid, metres, `None` for an unbounded one.
    pub fn new(info: Info, params: Vec<Param>, lipschitz: f32, edges: Option<[f32; 3]>, code: Arc<Code>) -> Self {
        Self { info, params, lipschitz, edges, code }
    }

    /// Half edges of the box, from the coefficients.
    fn half(numbers: &[f32]) -> [f32; 3] {
        let n = numbers.len();
        [numbers[n - 3], numbers[n - 2], numbers[n - 1]]
    }

    /// Length by which steps and errors are measured, metres.
    fn size<N: Batch>(p: Vec3<N>, [x, y, z]: [f32; 3]) -> N {
        let edge = N::constant(2.0 * x.max(y).max(z));
        edge.min(p.abs().largest().max(N::one()))
    }

    /// Value of the code over the Lipschitz constant, at the points in the mask.
    fn estimate(&self, p: Vec3<f32x8>, numbers: &[f32], mask: Mask) -> f32x8 {
        let program = &self.code.program;
        let params = &numbers[..numbers.len() - EXTRA_COEFFICIENTS];
        let slope = numbers[numbers.len() - EXTRA_COEFFICIENTS];
        let point = [p.x, p.y, p.z].map(|v| v.to_array().map(f32::to_bits));
        let values = MACHINES.with_borrow_mut(|machines| {
            let place = machines.iter().position(|(id, _)| *id == self.code.id);
            let (id, mut machine) = match place {
                Some(place) => machines.swap_remove(place),
                None => (self.code.id, Machine::new(program)),
            };
            let values = machine.run(program, point, params, mask);
            machines.truncate(MAX_MACHINES - 1);
            machines.insert(0, (id, machine));
            values
        });
        let size = Self::size(p, Self::half(numbers)).to_array();
        f32x8::from(std::array::from_fn(|lane| {
            let value = f32::from_bits(values[lane]);
            if value.is_finite() { value / slope } else { NON_FINITE_DISTANCE * size[lane] }
        }))
    }

    /// Value and central differences at one point, evaluated for all their points at once.
    fn differences(&self, p: Vec3<f32>, numbers: &[f32]) -> Dual<f32> {
        let h = DIFFERENCE_STEP * Self::size(p, Self::half(numbers));
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

/// Replaces a zero gradient by one upwards.
fn upwards(gradient: Vec3<f32>) -> Vec3<f32> {
    if gradient.dot(gradient) < 1e-12 { Vec3::new(0.0, 1.0, 0.0) } else { gradient }
}

/// Distance to the box with these half edges, metres.
#[inline(always)]
fn bound<N: Real>(p: Vec3<N>, half: [N; 3]) -> N {
    <shapes::Box as ShapeDef>::distance(p, half.map(|half| half + half))
}

/// Distance outside the box up to which the estimate is used, metres.
#[inline(always)]
fn reach<N: Real>([x, y, z]: [N; 3]) -> N {
    x.max(y.max(z))
}

/// Distance at `p`: the estimate, clipped to the box.
#[inline(always)]
fn clip<N: Real>(p: Vec3<N>, estimate: N, half: [N; 3]) -> N {
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
        clip(p, self.estimate(points, numbers, 1).to_array()[0], half)
    }
    fn gradient(&self, p: Vec3<Dual<f32>>, numbers: &[f32]) -> Dual<f32> {
        let (point, half) = (p.values(), Self::half(numbers));
        let estimate = match orbit::is_near(bound(point, half), reach(half)) {
            true => self.differences(point, numbers),
            false => Dual::independent(0.0),
        };
        let local = clip(Dual::variables(point), estimate, half.map(Dual::independent));
        Dual { value: local.value, gradient: p.pulled_back(local.gradient) }
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
        clip(p, self.estimate(p, numbers, near), half)
    }
    fn gradient(&self, p: Vec3<Dual<f32x8>>, numbers: &[f32]) -> Dual<f32x8> {
        let point = p.values();
        let [x, y, z] = [point.x, point.y, point.z].map(f32x8::to_array);
        let one = |lane: usize| self.gradient(Dual::variables(Vec3::new(x[lane], y[lane], z[lane])), numbers);
        let lanes: [Dual<f32>; 8] = std::array::from_fn(one);
        let gather = |of: &dyn Fn(&Dual<f32>) -> f32| f32x8::from(std::array::from_fn(|lane| of(&lanes[lane])));
        let gradient = Vec3::new(gather(&|d| d.gradient.x), gather(&|d| d.gradient.y), gather(&|d| d.gradient.z));
        Dual { value: gather(&|d| d.value), gradient: p.pulled_back(gradient) }
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
        let half = self.edges.map_or([UNBOUNDED; 3], |edges| edges.map(|edge| 0.5 * edge));
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
        format!("custom_{}", self.code.identifier)
    }
    fn wgsl_distance(&self) -> String {
        self.code.wgsl_distance()
    }
    fn wgsl_gradient(&self) -> String {
        self.code.wgsl_gradient()
    }
}

/// Prints the distance function around the code's function `entry`. Its arguments are the point, the parameters, the Lipschitz
/// constant and the half edges.
fn wgsl_distance(name: &str, entry: &str, params: usize) -> String {
    let half = |inputs: &[crate::expression::Expr]| [inputs[0], inputs[1], inputs[2]];
    let point = |inputs: &[crate::expression::Expr]| Vec3::new(inputs[0], inputs[1], inputs[2]);
    let edges = [("x", "f32"), ("y", "f32"), ("z", "f32")];
    let function = |suffix: &str, doc: &str, more: &[(&'static str, &'static str)]| Function {
        name: format!("{name}_{suffix}"),
        doc: doc.to_owned(),
        parameters: [("p", "vec3f")].into_iter().chain(more.iter().copied()).chain(edges).collect(),
    };
    let bounds = function("bound", "Distance to the box with these half edges.", &[])
        .print(&|inputs| vec![bound(point(inputs), half(&inputs[3..]))]);
    let clips = function("clip", "Estimate, clipped to the box.", &[("estimate", "f32")])
        .print(&|inputs| vec![clip(point(inputs), inputs[3], half(&inputs[4..]))]);
    let signature = signature(params);
    let arguments: String = (0..params).map(|k| format!(", n{k}")).collect();
    format!(
        "{bounds}\n{clips}\n\
         /// Length by which steps and errors are measured, metres.\n\
         fn {name}_size(p: vec3f, x: f32, y: f32, z: f32) -> f32 {{\n    \
         let a = abs(p);\n    \
         return min(2.0 * max(x, max(y, z)), max(1.0, max(a.x, max(a.y, a.z))));\n}}\n\n\
         /// Value of the code over the Lipschitz constant.\n\
         fn {name}_estimate(p: vec3f{signature}) -> f32 {{\n    \
         let value = {entry}(p{arguments});\n    \
         if (bitcast<u32>(value) & 0x7f800000u) == 0x7f800000u {{\n        \
         return {NON_FINITE_DISTANCE} * {name}_size(p, x, y, z);\n    }}\n    \
         return value / slope;\n}}\n\n\
         /// Signed distance of a custom shape.\n\
         fn {name}_distance(p: vec3f{signature}) -> f32 {{\n    \
         let bound = {name}_bound(p, x, y, z);\n    \
         if bound >= max(x, max(y, z)) {{\n        return bound;\n    }}\n    \
         return {name}_clip(p, {name}_estimate(p{arguments}, slope, x, y, z), x, y, z);\n}}\n"
    )
}

/// Prints the gradient function, which calls those of [`wgsl_distance`].
fn wgsl_gradient(name: &str, params: usize) -> String {
    let parameters = [("p", "vec3f"), ("estimate", "vec4f"), ("x", "f32"), ("y", "f32"), ("z", "f32")];
    let doc = "Gradient (xyz) and distance (w) of the estimate, clipped to the box.".to_owned();
    let clips =
        Function { name: format!("{name}_clip_gradient"), doc, parameters: parameters.to_vec() }.print(&|inputs| {
            let p = Dual::variables(Vec3::new(inputs[0], inputs[1], inputs[2]));
            let estimate = Dual { value: inputs[6], gradient: Vec3::new(inputs[3], inputs[4], inputs[5]) };
            let result = clip(p, estimate, [inputs[7], inputs[8], inputs[9]].map(Dual::independent));
            vec![result.gradient.x, result.gradient.y, result.gradient.z, result.value]
        });
    let signature = signature(params);
    let arguments: String = (0..params).map(|k| format!(", n{k}")).collect();
    format!(
        "{clips}\n/// Gradient (xyz) by central differences and distance (w) of a custom shape.\n\
         fn {name}_gradient(p: vec3f{signature}) -> vec4f {{\n    \
         var estimate = vec4f(0.0);\n    \
         if {name}_bound(p, x, y, z) < max(x, max(y, z)) {{\n        \
         let h = {DIFFERENCE_STEP} * {name}_size(p, x, y, z);\n        \
         var gradient = vec3f(0.0);\n        \
         for (var axis = 0u; axis < 3u; axis++) {{\n            \
         let along = vec3f(f32(axis == 0u), f32(axis == 1u), f32(axis == 2u));\n            \
         let ahead = {name}_estimate(p + along * h{arguments}, slope, x, y, z);\n            \
         gradient += along * (ahead - {name}_estimate(p - along * h{arguments}, slope, x, y, z));\n        }}\n        \
         gradient /= 2.0 * h;\n        \
         if dot(gradient, gradient) < 1e-12 {{\n            gradient = vec3f(0.0, 1.0, 0.0);\n        }}\n        \
         estimate = vec4f(gradient, {name}_estimate(p{arguments}, slope, x, y, z));\n    }}\n    \
         return {name}_clip_gradient(p, estimate, x, y, z);\n}}\n"
    )
}

/// Declarations of the arguments behind the point.
fn signature(params: usize) -> String {
    let params: String = (0..params).map(|k| format!(", n{k}: f32")).collect();
    format!("{params}, slope: f32, x: f32, y: f32, z: f32")
}
