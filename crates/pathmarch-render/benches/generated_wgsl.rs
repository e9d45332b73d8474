//! Speed of WGSL printed from Rust compared with WGSL written by hand, and of dual-number gradients compared with differences.
//!
//! Five very different distances, each printed by the generic route and written by hand as a shader author would, run
//! over the same points in turn; prints the median milliseconds of each and their ratio. Then shapes by their printed gradient
//! and by four taps of their distance in a loop (Quilez 2015, "Normals for an SDF"). `cargo bench -p pathmarch-render
//! --bench generated_wgsl`.

use pathmarch_render::pathmarch_field::BlendProfile;
use pathmarch_render::pathmarch_field::number::{Real, Vec3};
use pathmarch_render::pathmarch_field::registry::{operator, shape};
use pathmarch_render::pathmarch_field::wgsl::distance_function;
use std::time::Instant;

const SIDE: u32 = 1024;
const EVALUATIONS: u32 = 64;
const ROUNDS: usize = 15;

/// Loop of four iterations: a Menger-like sponge by repeated folding.
fn sponge<N: Real>(p: Vec3<N>) -> N {
    let half = N::constant(0.5);
    let cube = p.abs() - Vec3::splat(half);
    let solid = cube.largest();
    let [distance, ..] = N::iterate(N::constant(4.0), 4, [solid, N::one()], |[distance, scale]| {
        let fold = |v: N| {
            let cell = v * scale + half;
            N::one() - N::constant(3.0) * ((cell - cell.floor()) - half).abs() * N::constant(2.0)
        };
        let (x, y, z) = (fold(p.x).abs(), fold(p.y).abs(), fold(p.z).abs());
        let cross = x.max(y).min(y.max(z)).min(z.max(x)) - N::one();
        let scale = scale * N::constant(3.0);
        ([distance.max(cross / scale), scale], N::truth(true))
    });
    distance
}

const SPONGE: &str = "fn hand(p: vec3f) -> f32 {
    let q = abs(p) - 0.5;
    var d = max(q.x, max(q.y, q.z));
    var s = 1.0;
    for (var i = 0; i < 4; i++) {
        let a = fract(p * s + 0.5) - 0.5;
        s *= 3.0;
        let r = abs(1.0 - 6.0 * abs(a));
        let c = (min(max(r.x, r.y), min(max(r.y, r.z), max(r.z, r.x))) - 1.0) / s;
        d = max(d, c);
    }
    return d;
}";

const SPHERE: &str = "fn hand(p: vec3f) -> f32 { return length(p) - parameters[0].x; }";

const BOX: &str = "fn hand(p: vec3f) -> f32 {
    let q = abs(p) - parameters[0].xyz * 0.5;
    return length(max(q, vec3f(0.0))) + min(max(q.x, max(q.y, q.z)), 0.0);
}";

const PRISM: &str = "fn hand(p: vec3f) -> f32 {
    let k = 1.7320508;
    let h = parameters[0].x * 0.5;
    var q = vec2f(abs(p.x) - h, p.y + h / k);
    if q.x + k * q.y > 0.0 {
        q = vec2f(q.x - k * q.y, -k * q.x - q.y) * 0.5;
    }
    q.x -= clamp(q.x, -2.0 * h, 0.0);
    let d = -length(q) * select(1.0, -1.0, q.y < 0.0);
    let w = vec2f(d, abs(p.z) - parameters[0].y * 0.5);
    return min(max(w.x, w.y), 0.0) + length(max(w, vec2f(0.0)));
}";

const SMOOTH_UNION: &str = "fn hand(p: vec3f) -> f32 {
    let a = length(p) - parameters[0].x;
    let q = abs(p - vec3f(0.5, 0.5, 0.0)) - parameters[0].xyz * 0.5;
    let b = length(max(q, vec3f(0.0))) + min(max(q.x, max(q.y, q.z)), 0.0);
    let h = max(parameters[0].w - abs(a - b), 0.0) / parameters[0].w;
    return min(a, b) - h * h * parameters[0].w * 0.25;
}";

fn printed(name: &str) -> String {
    shape(name).map(|shape| shape.wgsl_distance()).unwrap_or_default()
}

fn cases() -> Vec<(&'static str, String, String)> {
    let x = "parameters[0].x";
    let boxed = "box_distance(p - vec3f(0.5, 0.5, 0.0), parameters[0].x, parameters[0].y, parameters[0].z)";
    let generated = |call: &str| format!("fn generated(p: vec3f) -> f32 {{ return {call}; }}");
    let smooth = operator("union").map(|union| union.wgsl_distance(Some(BlendProfile::Soft))).unwrap_or_default();
    vec![
        ("sphere", printed("sphere") + &generated(&format!("sphere_distance(p, {x})")), SPHERE.into()),
        (
            "box",
            printed("box") + &generated(&format!("box_distance(p, {x}, parameters[0].y, parameters[0].z)")),
            BOX.into(),
        ),
        ("prism", printed("prism") + &generated(&format!("prism_distance(p, {x}, parameters[0].y)")), PRISM.into()),
        (
            "smooth union",
            printed("sphere")
                + &printed("box")
                + &smooth
                + &generated(&format!("soft_union_distance(sphere_distance(p, {x}), {boxed}, parameters[0].w)")),
            SMOOTH_UNION.into(),
        ),
        ("4-iteration loop", distance_function("generated", "Sponge.", &[], |p, _| sponge(p)), SPONGE.into()),
    ]
}

/// Printed gradient of a shape, and the same gradient by a loop of four taps of its distance.
fn gradient_case(name: &str) -> Option<(String, String)> {
    let any = shape(name)?;
    let values: Vec<f32> = any.params().iter().map(|param| param.default).collect();
    let shape = any.variant(&values).unwrap_or(any);
    let (name, distance) = (shape.wgsl_name(), shape.wgsl_distance());
    let arguments: String = values.iter().map(|value| format!(", {value:?}")).collect();
    let dual = format!(
        "{}fn generated(p: vec3f) -> f32 {{
    let g = {name}_gradient(p{arguments});
    return g.w + 0.001 * dot(g.xyz, vec3f(1.0, 2.0, 3.0));
}}",
        shape.wgsl_gradient()
    );
    let taps = format!(
        "{distance}fn hand(p: vec3f) -> f32 {{
    var gradient = vec3f(0.0);
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {{
        let e = vec3f(f32(((i + 3u) >> 1u) & 1u), f32((i >> 1u) & 1u), f32(i & 1u)) * 2.0 - 1.0;
        let d = {name}_distance(p + 0.0005 * e{arguments});
        gradient += e * d;
        sum += d;
    }}
    return 0.25 * sum + 0.5 * dot(gradient, vec3f(1.0, 2.0, 3.0));
}}"
    );
    Some((dual, taps))
}

fn kernel(code: &str, function: &str) -> String {
    format!(
        "@group(0) @binding(0) var<uniform> parameters: array<vec4f, 1>;
@group(0) @binding(1) var<storage, read_write> sums: array<f32>;
{code}
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {{
    var p = vec3f(vec2f(id.xy) / {SIDE}.0 * 4.0 - 2.0, -2.0);
    var sum = 0.0;
    for (var i = 0u; i < {EVALUATIONS}u; i++) {{
        let d = {function}(p);
        sum += d;
        p.z += 0.03 + 0.01 * abs(d);
    }}
    sums[id.y * {SIDE}u + id.x] = sum;
}}"
    )
}

struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    parameters: wgpu::Buffer,
    sums: wgpu::Buffer,
}

impl Gpu {
    fn pipeline(&self, source: &str) -> (wgpu::ComputePipeline, wgpu::BindGroup) {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        // The layout of a function that reads no parameters has no binding for them.
        let mut entries = vec![wgpu::BindGroupEntry { binding: 1, resource: self.sums.as_entire_binding() }];
        if source.matches("parameters[").count() > 0 {
            entries.push(wgpu::BindGroupEntry { binding: 0, resource: self.parameters.as_entire_binding() });
        }
        let bindings = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        (pipeline, bindings)
    }

    /// Time of one dispatch, milliseconds.
    fn time(&self, (pipeline, bindings): &(wgpu::ComputePipeline, wgpu::BindGroup)) -> f64 {
        let started = Instant::now();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(SIDE / 8, SIDE / 8, 1);
        }
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
        started.elapsed().as_secs_f64() * 1e3
    }
}

impl Gpu {
    /// Measures two functions in turn and prints their times.
    fn compare(&self, name: &str, generated: &str, hand: &str) {
        let printed = self.pipeline(&kernel(generated, "generated"));
        let written = self.pipeline(&kernel(hand, "hand"));
        let (mut a, mut b) = (Vec::new(), Vec::new());
        self.time(&printed);
        self.time(&written);
        for _ in 0..ROUNDS {
            a.push(self.time(&printed));
            b.push(self.time(&written));
        }
        let ratios = a.iter().zip(&b).map(|(a, b)| a / b).collect();
        println!("{name:<18} {:>10.2} {:>10.2} {:>8.3}", median(a), median(b), median(ratios));
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    use wgpu::util::DeviceExt;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let Ok(adapter) = pollster::block_on(instance.request_adapter(&Default::default())) else {
        println!("no GPU adapter: nothing measured");
        return;
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).expect("the adapter opens");
    let parameters = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&[1.0f32, 0.8, 1.2, 0.3]),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let sums = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIDE * SIDE * 4),
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let gpu = Gpu { device, queue, parameters, sums };
    if std::env::args().any(|argument| argument == "--text") {
        cases().iter().for_each(|(name, generated, hand)| println!("// {name}\n{generated}\n{hand}\n"));
    }
    println!("{}: {SIDE}x{SIDE} invocations of {EVALUATIONS} evaluations, median of {ROUNDS}", adapter.get_info().name);
    println!("{:<18} {:>10} {:>10} {:>8}", "distance", "printed ms", "by hand ms", "ratio");
    for (name, generated, hand) in cases() {
        gpu.compare(name, &generated, &hand);
    }
    println!("{:<18} {:>10} {:>10} {:>8}", "gradient", "dual ms", "4 taps ms", "ratio");
    for name in ["sphere", "box", "torus", "ellipsoid", "prism", "mandelbulb", "mandelbox", "julia", "menger"] {
        if let Some((dual, taps)) = gradient_case(name) {
            gpu.compare(name, &dual, &taps);
        }
    }
}
