//! Custom distance fields of a scene: they agree on the CPU and the GPU, and hang neither.

#[path = "../../pathmarch-field/tests/sampling/fields.rs"]
mod fields;

use crate::common::{on_both_backends, on_each_backend, parse, render, with_gpu};
use fields::{SHADERS, copying, declared, shader_shape};
use pathmarch_render::image::PictureKind;
use pathmarch_render::metrics::compare;
use pathmarch_render::pathmarch_field::custom_sdf::{Code, budget};
use pathmarch_render::pathmarch_field::number::{Dual, Vec3};
use pathmarch_render::pathmarch_field::{CustomShape, EvalShape, Info, Shape};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Mode, Renderer, Settings};
use pathmarch_testing::{plain, tests};
use std::sync::Arc;
use std::time::Instant;
use wgpu::util::DeviceExt;

const POINTS: usize = 4096;

/// Computes gradient and distance of a shape at points on a device.
fn on_device(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    shape: &dyn Shape,
    numbers: &[f32],
    points: &[[f32; 4]],
) -> Vec<[f32; 4]> {
    let name = shape.wgsl_name();
    let arguments: String = (0..numbers.len()).map(|k| format!(", numbers[{k}]")).collect();
    let code = format!(
        "{}\n{}\n@group(0) @binding(0) var<storage> points: array<vec4f>;\n\
         @group(0) @binding(1) var<storage> numbers: array<f32>;\n\
         @group(0) @binding(2) var<storage, read_write> results: array<vec4f>;\n\
         @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{\n    \
         let p = points[id.x].xyz;\n    \
         results[id.x] = vec4f({name}_gradient(p{arguments}).xyz, {name}_distance(p{arguments}));\n}}\n",
        shape.wgsl_distance(),
        shape.wgsl_gradient(),
    );
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(code.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let bytes = size_of_val(points) as u64;
    let buffer = |contents: &[u8]| {
        let usage = wgpu::BufferUsages::STORAGE;
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let make = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false })
    };
    let (points, numbers) = (buffer(bytemuck::cast_slice(points)), buffer(bytemuck::cast_slice(numbers)));
    let results = make(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = make(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: points.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: numbers.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 2, resource: results.as_entire_binding() },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((POINTS / 64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&results, 0, &read, 0, bytes);
    queue.submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let view = read.slice(..).get_mapped_range().expect("mapped");
    bytemuck::cast_slice(&view).to_vec()
}

fn device() -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).expect("an adapter");
    pollster::block_on(adapter.request_device(&Default::default())).expect("a device")
}

/// Reproducible random number in 0..1.
fn random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    (*state >> 8) as f32 / 16_777_216.0
}

fn the_cpu_and_the_gpu_agree_at_random_points() {
    let (device, queue) = device();
    let mut state = 1;
    for declared in declared() {
        let shape = declared.shape();
        let numbers = shape.coefficients(&[]);
        let points: Vec<[f32; 4]> = (0..POINTS)
            .map(|_| std::array::from_fn(|k| if k < 3 { 5.0 * random(&mut state) - 2.5 } else { 0.0 }))
            .collect();
        let results = on_device(&device, &queue, &shape, &numbers, &points);
        let (mut distance_apart, mut gradients_apart) = (0.0_f32, 0);
        for (point, result) in points.iter().zip(&results) {
            let p = Vec3::new(point[0], point[1], point[2]);
            let field = shape.gradient(Dual::variables(p), &numbers);
            distance_apart = distance_apart.max((result[3] - shape.distance(p, &numbers)).abs());
            let apart = (field.gradient - Vec3::new(result[0], result[1], result[2])).length();
            gradients_apart += u32::from(apart > 0.02);
        }
        println!("{}: {distance_apart:.1e} apart, {gradients_apart} gradients of {POINTS} differ", declared.name);
        assert!(distance_apart < 2e-5, "{}", declared.name);
        // At edges, rounding decides on which side the differences are taken.
        assert!(gradients_apart < POINTS as u32 / 50, "{}", declared.name);
    }
}

/// Shaders in GLSL compute the same on both backends.
fn shaders_agree_on_the_cpu_and_the_gpu() {
    let (device, queue) = device();
    let mut state = 3;
    for (name, lipschitz) in SHADERS {
        let shape = shader_shape(name, lipschitz);
        let numbers = shape.coefficients(&[]);
        let point = |state: &mut u32| std::array::from_fn(|k| if k < 3 { 2.4 * random(state) - 1.2 } else { 0.0 });
        let points: Vec<[f32; 4]> = (0..POINTS).map(|_| point(&mut state)).collect();
        let results = on_device(&device, &queue, &shape, &numbers, &points);
        let far = points
            .iter()
            .zip(&results)
            .filter(|(p, result)| (shape.distance(Vec3::new(p[0], p[1], p[2]), &numbers) - result[3]).abs() > 1e-4);
        let far = far.count();
        println!("{name}: {far} of {POINTS} points differ");
        // Fractals amplify rounding errors.
        assert!(far <= POINTS / 50, "{name}: {far}");
    }
}

/// The loop budget counts copies of arrays on a device as on the CPU: a loop has as many passes.
fn copies_of_arrays_are_counted_alike() {
    let (device, queue) = device();
    let points = vec![[1.0, 2.0, 3.0, 0.0]; POINTS];
    for copying in copying() {
        let code = Code::new("copying", &[], &copying.text).unwrap_or_else(|faults| panic!("{faults:#?}"));
        let shape = CustomShape::new(Info::new("copying", "", ""), Vec::new(), 1.0, None, Arc::new(code));
        let numbers = shape.coefficients(&[]);
        let passes = shape.distance(Vec3::new(1.0, 2.0, 3.0), &numbers);
        let most = budget::LOOP_BUDGET * budget::OPERATIONS_PER_PASS;
        assert!(passes >= 2.0 && passes as u32 * copying.copies <= most, "{}: {passes}", copying.name);
        let results = on_device(&device, &queue, &shape, &numbers, &points);
        assert!(results.iter().all(|result| result[3] == passes), "{}: {passes}, {:?}", copying.name, results[0]);
    }
}

/// Parsing refuses arrays that would take a device minutes and gigabytes.
fn scenes_of_large_arrays_are_refused() {
    let calls: String = (0..255).map(|k| format!("sum += g()[{}];", k % 60)).collect();
    for (size, said) in [(10_000, "`a` has 10000 numbers"), (60, "arrays of this function come to")] {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0 }}\nfield \"f\" {{ bounds 2 2 2; wgsl \"             fn g() -> array<f32,{size}> {{ var a: array<f32,{size}>; return a; }}              fn distance(p: vec3f) -> f32 {{ var sum = p.x; {calls} return sum; }}\" }}\nobject \"solid\" {{ f }}"
        );
        let error = Scene::parse("large.kdl", &text).err().unwrap_or_else(|| panic!("accepted: {size}"));
        let mistakes: Vec<String> = error.mistakes().iter().map(|mistake| mistake.to_string()).collect();
        assert!(mistakes.iter().any(|mistake| mistake.contains(said)), "{mistakes:?}");
    }
}

/// Scene with a custom field; `solid` is the content of an object.
fn scene(field: &str, solid: &str) -> pathmarch_render::pathmarch_scene::Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 1 2 5; target 0 0 0; fov 35 }}\nsky 0.3 0.375 0.5\n\
         sun {{ direction 1 2 1.5; irradiance 2; angle 0 }}\n{field}\nobject \"floor\" {{ plane {{ at 0 -1.2 0 }} }}\n\
         object \"solid\" {{ {solid} }}"
    ))
}

fn fields_render_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let gyroid = "field \"gyroid\" { param cell 0.8; param wall 0.05; lipschitz 1.75; bounds 2 2 2; wgsl \"fn distance(p: vec3f) -> \
                  f32 { let k = 6.2831853 / cell; return abs(dot(sin(p * k), cos(p.yzx * k))) / k - wall; }\" }";
    for solid in [
        "gyroid cell=0.7 { rotate 25 30 10; scale 1.1 }",
        "intersect { gyroid; sphere 1 }",
        "union smooth=0.2 { gyroid 0.9 0.06; sphere 0.4 { at 0 1 0 } }",
        "repeat 2.5 0 0 count=3 { intersect { gyroid; sphere 0.9 } }",
        "twist 0.1 { gyroid { scale 0.7 } }",
    ] {
        let scene = scene(gyroid, solid);
        let settings = Settings { size: [96, 54], samples: 16, ..Settings::of(&scene) };
        let [cpu, gpu] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
        let result = compare(&cpu, &gpu, PictureKind::Hdr).expect("equal sizes");
        println!("{solid}: CPU against GPU relMSE {:.1e}", result.relmse);
        assert!(result.relmse < 5e-4, "{solid}: {:.1e}", result.relmse);
    }
}

/// Fields with values that are not finite, or with endless loops, are rendered in limited time.
fn hostile_fields_are_rendered(renderer: &Renderer) {
    for text in [
        "fn distance(p: vec3f) -> f32 { return p.x / (p.y - p.y); }",
        "fn distance(p: vec3f) -> f32 { return sqrt(p.x) - 0.5; }",
        "fn distance(p: vec3f) -> f32 { return -log(0.0 * p.x); }",
        "fn distance(p: vec3f) -> f32 { var n = 0.0; loop { n += sin(n + p.x); if n > 1e9 { break; } } return n; }",
        "fn distance(p: vec3f) -> f32 { var n = p.x; for (var i = 0; i < 2000000000; i++) { for (var j = 0; j < 2000000000; j++) { n = \
         cos(n); } } return n; }",
        "fn distance(p: vec3f) -> f32 { return fract(sin(dot(p, vec3f(12.9, 78.2, 37.7))) * 43758.5) - 0.5; }",
        // Copied arrays: without a loop, and in an endless loop.
        "fn distance(p: vec3f) -> f32 { var a: array<f32, 24>; var b: array<f32, 24>; a[i32(p.x * 1e3)] = p.y; b = a; \
         a[i32(p.z)] = 1.0; return b[i32(p.y * 1e3)] + length(p) - 0.5; }",
        "fn distance(p: vec3f) -> f32 { var a: array<f32, 24>; var b: array<f32, 24>; loop { a[i32(p.x * 1e3)] = p.y; b = a; \
         a[3] = b[i32(p.z * 1e3)]; if a[3] > 1e9 { break; } } return b[i32(p.y * 1e3)] + length(p) - 0.5; }",
        "fn distance(p: vec3f) -> f32 { var a = array<f32, 4>(); a[i32(p.x * 1e9)] = 1.0; return a[i32(p.y * 1e9)] - 0.5; }",
    ] {
        let scene = scene(&format!("field \"f\" {{ bounds 2 2 2; wgsl \"{text}\" }}"), "f");
        for mode in [Mode::Path, Mode::Normal] {
            let settings = Settings { size: [64, 36], samples: 2, mode, ..Settings::of(&scene) };
            let start = Instant::now();
            let film = renderer.render(&scene, &settings).expect("renders");
            let finite = film.mean().pixels.iter().flatten().all(|v| v.is_finite());
            let seconds = start.elapsed().as_secs_f32();
            println!("{}: {seconds:.2} s, {} not finite: {text:.80}", renderer.backend().name, film.non_finite());
            assert!(finite && film.non_finite() == 0, "{text}");
            assert!(seconds < 30.0, "{text}");
        }
    }
}

/// The examples of the documentation are rendered, and one of them equals a scene of the gallery.
fn the_examples_of_the_documentation_are_rendered(renderer: &Renderer) {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = std::fs::read_to_string(root.join("docs/own-fields.md")).expect("the page");
    let blocks: Vec<&str> =
        docs.split("```kdl\n").skip(1).map(|rest| rest.split("```").next().expect("an end")).collect();
    let port = std::fs::read_to_string(root.join("scenes/columns.kdl")).expect("the scene");
    assert!(blocks.contains(&port.as_str()), "docs/own-fields.md shows another scenes/columns.kdl");
    for block in blocks {
        let scene = parse(block);
        let settings = Settings { size: [96, 54], samples: 4, bounces: 2, ..Settings::of(&scene) };
        let picture = render(renderer, &scene, &settings).mean();
        let brightness = picture.mean_colour()[1];
        assert!(brightness > 0.01, "{}: {brightness}", renderer.backend().name);
    }
}

tests! {
    on_each_backend: [the_examples_of_the_documentation_are_rendered],
    on_each_backend slow: [hostile_fields_are_rendered],
    on_both_backends slow: [fields_render_alike_on_both_backends],
    with_gpu: [
        the_cpu_and_the_gpu_agree_at_random_points,
        copies_of_arrays_are_counted_alike,
        shaders_agree_on_the_cpu_and_the_gpu,
    ],
    plain: [scenes_of_large_arrays_are_refused],
}
