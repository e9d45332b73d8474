//! Shaders in GLSL as fields: what they compute, and how mistakes are reported.

use crate::fields::{QUICK_SHADERS, SHADERS, shader_shape};
use crate::sampling::{Random, validate};
use pathmarch_field::custom_sdf::glsl::{Shader, ShaderParam};
use pathmarch_field::custom_sdf::{Code, CodeDiagnostic};
use pathmarch_field::graph::Kind;
use pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_field::number::Vec3;
use pathmarch_field::{CustomShape, EvalShape, Field, Info, Node, Param, Placement, Shape, ShapeRef};
use std::sync::Arc;

type Point = [f64; 3];

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn box3(p: Point, b: Point) -> f64 {
    let q: [f64; 3] = std::array::from_fn(|k| p[k].abs() - b[k]);
    length(&q.map(|x| x.max(0.0))) + q[0].max(q[1]).max(q[2]).min(0.0)
}

fn blob([x, y, z]: Point) -> f64 {
    let (s, c) = (0.25 * std::f64::consts::PI).sin_cos();
    // `q.xz *= m` is `q.xz * m`.
    let q = [x * c + z * s, y, -x * s + z * c];
    let (a, b, k) = (box3(q, [0.5, 0.3, 0.4]) - 0.05, length(&[x, y - 0.45, z]) - 0.35, 0.2);
    let h = (k - (a - b).abs()).max(0.0) / k;
    let hole = length(&[x - 0.45, y - 0.2, z - 0.45]) - 0.3;
    (a.min(b) - 0.25 * h * h * k).max(-hole)
}

fn lattice(p: Point) -> f64 {
    let q = p.map(|x| (x + 0.75).rem_euclid(1.5) - 0.75);
    let strut = |a: f64, b: f64| a.abs().max(b.abs()) - 0.08;
    let struts = strut(q[0], q[1]).min(strut(q[1], q[2])).min(strut(q[2], q[0]));
    0.9 * (length(&q) - 0.35).min(struts)
}

fn menger(p: Point) -> f64 {
    let (mut d, mut s) = (box3(p, [1.0; 3]), 1.0);
    for _ in 0..4 {
        let a = p.map(|x| (x * s).rem_euclid(2.0) - 1.0);
        s *= 3.0;
        let r = a.map(|x| (1.0 - 3.0 * x.abs()).abs());
        let c = r[0].max(r[1]).min(r[1].max(r[2])).min(r[2].max(r[0]));
        d = d.max((c - 1.0) / s);
    }
    d
}

fn materials([x, y, z]: Point) -> f64 {
    let ring = length(&[length(&[x, z]) - 0.7, y + 0.1]) - 0.1;
    (y + 0.5).min(length(&[x, y - 0.1, z]) - 0.5).min(ring)
}

fn overloads([x, y, z]: Point) -> f64 {
    let mut d = box3([x, y, z], [0.3, 0.5, 0.3]).min((length(&[x, z]) - 0.2).max(y.abs() - 0.9));
    for (a, b) in [(0.7, 0.0), (0.0, 0.7), (-0.7, 0.0), (0.0, -0.7)] {
        d = d.min((length(&[x - a, z - b]) - 0.1).max(y.abs() - 0.6));
    }
    d
}

fn minimal([x, y, z]: Point) -> f64 {
    let shifts = [[0.0; 3], [0.4, 0.1, 0.9], [1.1, 0.7, 0.2]];
    let wave = |(k, shift): (usize, &Point)| {
        let s = 4.0 * 1.5_f64.powi(k as i32);
        let [a, b, c] = [s * x + shift[0], s * y + shift[1], s * z + shift[2]];
        0.5_f64.powi(k as i32) * (a.sin() * b.cos() + b.sin() * c.cos() + c.sin() * a.cos())
    };
    let sum: f64 = shifts.iter().enumerate().map(wave).sum();
    (sum.abs() / 20.0 - 0.02).max(length(&[x, y, z]) - 1.2)
}

fn mandelbulb(p: Point) -> f64 {
    let (mut z, mut dr, mut r) = (p, 1.0, 0.0);
    for _ in 0..6 {
        r = length(&z);
        if r > 4.0 {
            break;
        }
        let (theta, phi) = (8.0 * (z[2] / r).acos(), 8.0 * z[1].atan2(z[0]));
        dr = r.powf(7.0) * 8.0 * dr + 1.0;
        let zr = r.powf(8.0);
        let turned = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        z = std::array::from_fn(|k| zr * turned[k] + p[k]);
    }
    0.5 * r.ln() * r / dr
}

/// Name of a shader, tolerance, and the same function in f64.
type Reference = (&'static str, f64, fn(Point) -> f64);

/// Values of the shaders are those of the same functions in Rust, in f64.
#[test]
fn shaders_agree_with_references() {
    let references: [Reference; 7] = [
        ("blob", 1e-5, blob),
        ("lattice", 1e-5, lattice),
        ("menger", 1e-5, menger),
        ("materials", 1e-5, materials),
        ("overloads", 1e-5, overloads),
        ("minimal", 1e-5, minimal),
        ("mandelbulb", 1e-3, mandelbulb),
    ];
    let mut random = Random::new(7);
    for (name, tolerance, reference) in references {
        let shape = shader_shape(name, 1.0);
        let numbers = shape.coefficients(&[]);
        let mut far = 0;
        for _ in 0..1000 {
            let p: [f32; 3] = std::array::from_fn(|_| random.within(-1.2, 1.2));
            let value = f64::from(shape.distance(Vec3::new(p[0], p[1], p[2]), &numbers));
            far += u32::from((value - reference(p.map(f64::from))).abs() > tolerance);
        }
        // The fractal's rounding errors grow with every iteration, where points escape late.
        let allowed = if name == "mandelbulb" { 20 } else { 0 };
        assert!(far <= allowed, "{name}: {far} of 1000 points differ");
    }
}

#[test]
fn shaders_of_all_styles_are_accepted_and_finite() {
    let mut random = Random::new(8);
    for name in SHADERS.iter().map(|(name, _)| *name).chain(QUICK_SHADERS) {
        let shape = shader_shape(name, 1.0);
        let numbers = shape.coefficients(&[]);
        let values: Vec<f32> = (0..200)
            .map(|_| {
                let [x, y, z] = std::array::from_fn(|_| random.within(-2.0, 2.0));
                shape.distance(Vec3::new(x, y, z), &numbers)
            })
            .collect();
        assert!(values.iter().all(|value| value.is_finite()), "{name}");
        assert!(values.iter().any(|value| *value != values[0]), "{name} is constant");
    }
}

/// The declared constants of the shaders are true, so that no step passes a surface.
#[test]
fn shaders_keep_their_constants() {
    for (name, lipschitz) in SHADERS {
        let shape = shader_shape(name, lipschitz);
        let params = shape.params().iter().map(|param| param.default).collect();
        let kind = Kind::Shape { shape: ShapeRef::Custom(Arc::new(shape)), params, tag: 0 };
        let report = check_lipschitz(&Field::new(&[Node { kind, placement: Placement::default() }]), 4000);
        println!("{name}: {report:?}");
        assert!(report.safe_factor > 0.99, "{name}: {report:?}");
    }
}

fn faults(text: &str) -> Vec<CodeDiagnostic> {
    let read = Shader::read(text, None, &[]).and_then(|shader| Code::of_shader("t", &shader).map(drop));
    read.err().unwrap_or_else(|| panic!("accepted: {text}"))
}

#[track_caller]
fn refused(text: &str, place: &str, message: &str) {
    let faults = faults(text);
    let found = faults[0].range.clone().map_or("", |range| &text[range]);
    assert!(faults[0].message.contains(message) && found == place, "{found:?} {faults:#?}");
}

#[test]
fn mistakes_are_reported_at_their_places() {
    refused("float map(vec3 p) { return lenght(p) - 1.; }", "lenght(p)", "no function `lenght`");
    refused("float map(vec3 p) { return radius; }", "radius", "no variable `radius`");
    refused("#define A p.w\nfloat map(vec3 p) { return A; }", "A", "swizzle");
    refused("float map(vec3 p) { return texture(iChannel0, p.xy).x; }", "texture", "`texture` is not for a field");
    refused("float map(vec3 p) { return p.x + iDate.x; }", "iDate", "`iDate` is not for a field");
    refused("layout(std140) uniform B { float a; };\nfloat map(vec3 p) { return a; }", "B", "Blocks of uniforms");
    refused("float map(vec3 p) { return p.x }", "}", "found `}`");
    refused("float map(vec3 p) { return (p.x; }", "}", "closes nothing");
    refused("fn map(p: vec3f) -> f32 { return p.x; }", "fn map", "This is WGSL");
    refused("float f(vec3 p) { return p.x; }", "", "no distance function");
    refused("float map(vec2 p) { return p.x; }", "map", "no distance function");
    refused("#foo\nfloat map(vec3 p) { return p.x; }", "foo", "`#foo` is not known");
    refused("uniform mat3 m;\nfloat map(vec3 p) { return (m*p).x; }", "m", "no uniform of the type `mat3`");
    refused("float map(vec3 p) { float a[100000]; return a[0]; }", "100000", "too large");
}

#[test]
fn recursion_is_refused() {
    let faults = faults("float f(float x) { return x > 0. ? f(x - 1.) : 0.; } float map(vec3 p) { return f(p.x); }");
    assert!(faults[0].message.contains("`f`"), "{faults:#?}");
}

#[test]
fn parameters_of_the_scene_are_numbers_of_the_code() {
    let text = "uniform float a; // slider[0,2,4]\nfloat map(vec3 p) { return p.x * a + b; }";
    let names = ["b".to_owned()];
    let shader = Shader::read(text, None, &names).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let code = Code::of_shader("t", &shader).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let params = vec![Param::any("b", 1.0, ""), Param::any("a", 2.0, "")];
    let shape = CustomShape::new(Info::new("t", "", ""), params, 1.0, None, Arc::new(code));
    let value = |params: &[f32]| shape.distance(Vec3::new(3.0, 0.0, 0.0), &shape.coefficients(params));
    assert_eq!(value(&[]), 7.0);
    assert_eq!(value(&[10.0, 0.5]), 11.5);
}

/// A variable outside functions starts anew for each point.
#[test]
fn variables_outside_functions_start_anew() {
    let text = "float sum = 0.5, count; float map(vec3 p) { sum += p.x; count++; return sum + count; }";
    let shader = Shader::read(text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let code = Code::of_shader("t", &shader).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let shape = CustomShape::new(Info::new("t", "", ""), Vec::new(), 1.0, None, Arc::new(code));
    let numbers = shape.coefficients(&[]);
    let value = || shape.distance(Vec3::new(2.0, 0.0, 0.0), &numbers);
    assert_eq!((value(), value()), (3.5, 3.5));
}

#[test]
fn a_variable_that_only_other_functions_set_is_reported() {
    let text = "float t; float map(vec3 p) { return p.x + t; } void mainImage() { t = 1.; }";
    let shader = Shader::read(text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    assert_eq!(shader.warnings.len(), 1);
    assert!(shader.warnings[0].message.contains("only `mainImage` sets it"), "{:?}", shader.warnings);
}

fn uniform(param: &ShaderParam) -> Param {
    Param { name: param.name.clone().into(), ..Param::any("", param.default, "") }
}

/// Shape of a shader without a name of its own.
#[track_caller]
fn shape(name: &str, text: &str) -> CustomShape {
    let shader = Shader::read(text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let params = shader.params.iter().map(uniform).collect();
    let code = Code::of_shader(name, &shader).unwrap_or_else(|faults| panic!("{faults:#?}"));
    CustomShape::new(Info::new("t", "", ""), params, 1.0, None, Arc::new(code))
}

/// Value of a shader at (0.5, -1, 2).
#[track_caller]
fn value(text: &str) -> f32 {
    let shape = shape("t", text);
    shape.distance(Vec3::new(0.5, -1.0, 2.0), &shape.coefficients(&[]))
}

#[track_caller]
fn gives(expression: &str, expected: f32) {
    let found = value(&format!("float map(vec3 p) {{ return {expression}; }}"));
    assert!((found - expected).abs() < 1e-5, "{expression}: {found}, not {expected}");
}

/// The mouse of Shadertoy is a parameter, zero as before the first click.
#[test]
fn a_mouse_is_a_parameter() {
    let text = "float map(vec3 p) { return p.x + iMouse.x / iResolution.x; }";
    assert_eq!(value(text), 0.5);
    let shader = Shader::read(text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    assert_eq!(shader.params.iter().map(|param| param.name.as_str()).collect::<Vec<_>>()[0], "iMouse_x");
}

#[test]
fn a_matrix_may_have_one_argument() {
    gives("(mat2(vec4(1, 2, 3, 4)) * vec2(1, 10)).y", 42.0);
    gives("(mat2(cos(vec4(0, 0, 0, 0) + p.xxxx * 0.)) * vec2(1, 10)).y", 11.0);
    gives("mat2(mat3(1, 2, 3, 4, 5, 6, 7, 8, 9))[1].x + mat2(3)[1].y + mat2(p.x)[0].x", 7.5);
}

/// The conventions of Fragmentarium: `m * v` turns clockwise, `v * m` counterclockwise.
#[test]
fn functions_of_fragmentarium_are_known() {
    gives("(rotationMatrix3(vec3(0, 0, 1), 90.) * vec3(1, 0, 0)).y", -1.0);
    gives("(vec3(1, 0, 0) * rotationMatrix3(vec3(0, 0, 1), 90.)).y", 1.0);
    gives("(rotationMatrix(vec3(1, 0, 0), 90.) * vec4(0, 1, 0, 1)).z", -1.0);
    gives("(translate(vec3(1, 2, 3)) * scale4(2.) * vec4(p, 1)).y", 0.0);
    gives("cMul(vec2(1, 2), vec2(3, -1)).y", 5.0);
    gives("cSqr(vec2(1, 2)).x", -3.0);
    gives("cMul(cDiv(vec2(5, 1), vec2(2, 3)), vec2(2, 3)).x", 5.0);
    gives("cMul(cInverse(vec2(2, 3)), vec2(2, 3)).x", 1.0);
    gives("cExp(cLog(vec2(0.3, 0.4))).y", 0.4);
    gives("cLog(vec2(0, 1)).y", -1.5 * std::f32::consts::PI);
    gives("cPower(vec2(1, 1), 2.).y", 2.0);
    gives("cPower2(vec2(1, 1), vec2(2, 0)).y", 2.0);
    gives("length(cSin(p.xy)) * length(cSin(p.xy)) + length(cCos(p.xy)) * length(cCos(p.xy))", 2.0_f32.cosh());
    gives("udRoundBox(p, vec3(.5, .5, 1), .1)", 1.25_f32.sqrt() - 0.1);
    gives("sdTorus(p, vec2(2, .5))", (4.25_f32.sqrt() - 2.0).hypot(1.0) - 0.5);
    gives("sdTorus88(vec3(3, 0, 0), vec2(2, .5))", 0.5);
    gives("opS(sdSphere(p, 1.), sdPlane(p, vec4(0, 1, 0, .5)))", -0.5);
}

/// Gradient noise is zero at the points of its lattice, continuous, and the same wherever only unused coordinates differ.
#[test]
fn noise_is_that_of_a_lattice_of_gradients() {
    gives("abs(cnoise(vec3(3, -4, 5))) + abs(cnoise(vec2(7, 8))) + abs(cnoise(vec4(1, 2, 3, 4)))", 0.0);
    for call in ["vec2(x, .3)", "vec3(.4, x, .3)", "vec4(.4, .2, x, .3)"] {
        let at = |x: f32| value(&format!("float map(vec3 p) {{ float x = float({x:?}); return cnoise({call}); }}"));
        let values: Vec<f32> = (0..40).map(|k| at(-3.0 + 0.17 * k as f32)).collect();
        assert!(values.iter().all(|value| value.abs() < 1.0), "{call}: {values:?}");
        assert!(values.iter().any(|value| *value > 0.1) && values.iter().any(|value| *value < -0.1), "{values:?}");
        assert!((at(1.999_99) - at(2.000_01)).abs() < 1e-3, "{call}");
    }
}

#[test]
fn matrices_of_all_sizes_have_an_inverse() {
    let m = "mat4 m = mat4(2,1,0,3, 0,1,4,1, 5,0,1,2, 1,1,0,2); mat4 i = inverse(m) * m; mat4 o = outerProduct(vec4(1,2,3,4), vec4(5,6,7,8));";
    let off =
        "float e = 0.; for (int k = 0; k < 4; k++) for (int l = 0; l < 4; l++) e += abs(i[k][l] - (k == l ? 1. : 0.));";
    assert!(value(&format!("float map(vec3 p) {{ {m} {off} return e; }}")).abs() < 1e-5);
    assert_eq!(value(&format!("float map(vec3 p) {{ {m} return o[3][1]; }}")), 16.0);
}

#[test]
fn names_may_have_any_underscores() {
    for name in ["a", "a_b", "box_2", "while_x", "a9"] {
        let text = "struct my__s { float d_; }; const float a__b = 2.; float f__(float x_) { return x_ * a__b; } float map(vec3 p) { my__s s = my__s(f__(p.x)); return s.d_; }";
        let shape = shape(name, text);
        validate(&(shape.wgsl_distance() + &shape.wgsl_gradient()));
        assert_eq!(shape.distance(Vec3::new(3.0, 0.0, 0.0), &shape.coefficients(&[])), 6.0);
    }
}

#[test]
fn the_overload_with_the_point_alone_is_the_distance() {
    assert_eq!(value("float DE(vec3 p, int k) { return 9.; } float DE(vec3 p) { return DE(p, 1) + p.x; }"), 9.5);
    let text = "float DE(vec3 p, int kind) { return kind == 0 ? p.x : 9.; }";
    assert_eq!(value(text), 0.5);
    let shader = Shader::read(text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    assert!(shader.warnings[0].message.contains("they are 0"), "{:?}", shader.warnings);
    refused("float DE(vec3 p, vec3 q) { return p.x; }", "DE", "no distance function");
}

/// Code that runs once for a picture in Fragmentarium sets variables of the distance function.
#[test]
fn code_for_the_vertices_sets_what_the_distance_reads() {
    let text = "#vertex\n#group G\nuniform float K; slider[0,3,9]\nvarying float sum;\nfloat f(float x) { return x * 2.; }\nvoid init() \
                { sum = f(K); }\n#endvertex\nvarying float sum;\nfloat f(float x) { return x * 2.; }\nfloat DE(vec3 p) { return p.x + sum; }";
    assert_eq!(value(text), 6.5);
    refused("varying float sum; float map(vec3 p) { return p.x + sum; }", "sum", "no variable `sum`");
}

#[test]
fn controls_of_unneeded_uniforms_may_be_anything() {
    assert_eq!(
        value("uniform sampler2D tex; file[texture.jpg]\nuniform float k; knob[1]\nfloat DE(vec3 p) { return p.x; }"),
        0.5
    );
    refused("uniform float k; knob[1]\nfloat DE(vec3 p) { return k; }", "knob", "no control of a uniform");
}

#[test]
fn uniforms_beyond_the_limit_are_constants() {
    let declared: String = (0..40).map(|k| format!("uniform float u{k}; slider[-9,{k}.5,99]\n")).collect();
    let sum = (0..40).map(|k| format!("u{k}")).collect::<Vec<_>>().join(" + ");
    let text = format!("{declared}float map(vec3 p) {{ return {sum}; }}");
    assert_eq!(value(&text), 800.0);
    let shader = Shader::read(&text, None, &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    assert_eq!(shader.params.len(), 32);
    assert!(shader.warnings[0].message.contains("`u39`") && !shader.warnings[0].message.contains("`u31`"));
}

#[test]
fn arrays_have_the_size_of_their_values() {
    assert_eq!(value("vec3 v[] = vec3[](vec3(1), vec3(0, 2, 3)); float map(vec3 p) { return v[1].y; }"), 2.0);
    assert_eq!(value("const float[] v = float[](1., 2., 3.); float map(vec3 p) { return v[2]; }"), 3.0);
    assert_eq!(value("float map(vec3 p) { float v[] = float[](4., p.x), w = 1.; return v[1] + w; }"), 1.5);
}

#[test]
fn components_of_columns_can_be_set() {
    let text = "float map(vec3 p) { mat2 j = mat2(1.); j[0].x = 3.; j[1].y *= 4.; j[1].g += 1.; j[0][1] = 7.; \
                return j[0].x * 100. + j[1].y * 10. + j[0].y; }";
    assert_eq!(value(text), 357.0);
    refused("float map(vec3 p) { mat3 m = mat3(1.); m[1].xy = p.xy; return m[1].x; }", ".xy", "Can't lookup field");
}

#[test]
fn a_loop_may_have_its_condition_behind() {
    let text = "float map(vec3 p) { int i = 0; float s = 0.; do { i++; if (i == 2) continue; s += float(i); } while (i < 4); \
                do s += .5; while (s < 0.); return s; }";
    assert_eq!(value(text), 8.5);
}

#[test]
fn the_function_can_be_named() {
    let text = "float map(vec3 p) { return p.x; } float other(vec3 p) { return p.y; }";
    let shader = Shader::read(text, Some("other"), &[]).unwrap_or_else(|faults| panic!("{faults:#?}"));
    assert_eq!(shader.function, "other");
    assert!(Shader::read(text, Some("third"), &[]).is_err());
}
