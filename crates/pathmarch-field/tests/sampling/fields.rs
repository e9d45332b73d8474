//! Own fields for the tests, as people write them: true to their declarations.
#![allow(dead_code)]

use pathmarch_field::custom_sdf::Code;
use pathmarch_field::custom_sdf::glsl::Shader;
use pathmarch_field::{CustomShape, Info, Param, Unit};
use std::sync::Arc;

/// A field as it is declared.
pub struct Declared {
    pub name: &'static str,
    pub params: Vec<Param>,
    pub lipschitz: f32,
    pub edges: Option<[f32; 3]>,
    pub text: &'static str,
}

impl Declared {
    pub fn shape(&self) -> CustomShape {
        let names: Vec<String> = self.params.iter().map(|param| param.name.to_string()).collect();
        let code =
            Code::new(self.name, &names, self.text).unwrap_or_else(|faults| panic!("{}: {faults:#?}", self.name));
        let info = Info::new(self.name, "A field.", "a test").inexact();
        CustomShape::new(info, self.params.clone(), self.lipschitz, self.edges, Arc::new(code))
    }
}

/// A lattice, a fractal with a loop that ends early, helpers with structures and pointers, matrices, and a switch.
pub fn declared() -> Vec<Declared> {
    vec![
        Declared {
            name: "gyroid",
            params: vec![
                Param::between("cell", 0.8, 0.2, 4.0, "Edge of a cell."),
                Param::between("wall", 0.05, 0.0, 0.5, "Half the thickness of the wall."),
            ],
            lipschitz: 1.75,
            edges: Some([2.0, 1.5, 2.0]),
            text: "fn distance(p: vec3f) -> f32 {
                let k = 6.2831853 / cell;
                return abs(dot(sin(p * k), cos(p.yzx * k))) / k - wall;
            }",
        },
        Declared {
            name: "sponge",
            params: vec![Param::between("depth", 3.0, 1.0, 4.0, "How often it is cut.")],
            lipschitz: 1.0,
            edges: Some([2.2, 2.2, 2.2]),
            text: "fn cube(p: vec3f, h: f32) -> f32 {
                let q = abs(p) - h;
                return length(max(q, vec3f(0.0))) + min(max(q.x, max(q.y, q.z)), 0.0);
            }
            fn distance(p: vec3f) -> f32 {
                var d = cube(p, 1.0);
                var s = 1.0;
                for (var i = 0; i < i32(depth); i++) {
                    let a = fract(p * s * 0.5 + 0.5) * 2.0 - 1.0;
                    s *= 3.0;
                    let r = abs(1.0 - 3.0 * abs(a));
                    let c = (min(max(r.x, r.y), min(max(r.y, r.z), max(r.z, r.x))) - 1.0) / s;
                    if c < -2.0 { break; }
                    d = max(d, c);
                }
                return d;
            }",
        },
        Declared {
            name: "blend",
            params: vec![Param::between("width", 0.3, 0.01, 1.0, "Of the blend.")],
            lipschitz: 1.0,
            edges: None,
            text: "struct Ball { at: vec3f, radius: f32 }
            const BALLS = array<Ball, 3>(
                Ball(vec3f(0.0, 0.0, 0.0), 0.6), Ball(vec3f(0.7, 0.2, 0.0), 0.4), Ball(vec3f(-0.3, 0.7, 0.3), 0.3));
            fn join(all: ptr<function, f32>, d: f32) {
                let h = max(width - abs(*all - d), 0.0) / width;
                *all = min(*all, d) - h * h * width * 0.25;
            }
            fn distance(p: vec3f) -> f32 {
                var all = 1e9;
                var balls = BALLS;
                for (var i = 0u; i < 3u; i++) {
                    join(&all, length(p - balls[i].at) - balls[i].radius);
                }
                return all;
            }",
        },
        Declared {
            name: "folded",
            params: vec![Param::any("turn", 0.7, "Radians.")],
            lipschitz: 1.0,
            edges: Some([3.0, 3.0, 3.0]),
            text: "fn rotation(a: f32) -> mat2x2f { return mat2x2f(cos(a), sin(a), -sin(a), cos(a)); }
            fn distance(p: vec3f) -> f32 {
                var q = p;
                let m = rotation(turn);
                for (var i = 0; i < 3; i++) {
                    let r = m * q.xz;
                    q = vec3f(abs(r.x) - 0.3, q.y, r.y);
                    q = vec3f(q.y, q.x, q.z);
                }
                return length(vec2f(length(q.xz) - 0.5, q.y)) - 0.15;
            }",
        },
        Declared {
            name: "choice",
            params: vec![Param::between("which", 1.0, 0.0, 3.0, "0 to 3.")],
            lipschitz: 1.0,
            edges: Some([2.0, 2.0, 2.0]),
            text: "fn distance(p: vec3f) -> f32 {
                switch i32(which) {
                    case 0: { return length(p) - 0.7; }
                    case 1, 2: {
                        var n = 0u;
                        loop {
                            n += 1u;
                            if n > 3u { break; }
                            continuing { n += select(0u, 1u, which > 1.5); }
                        }
                        return max(abs(p.x), max(abs(p.y), abs(p.z))) - f32(n) * 0.2;
                    }
                    default: { return dot(p, normalize(vec3f(1.0, 2.0, 0.5))); }
                }
            }",
        },
    ]
}

/// A field whose value is how many passes a loop had in which arrays are copied.
pub struct Copying {
    pub name: &'static str,
    pub text: String,
    /// How many scalars and vectors each pass copies at least.
    pub copies: u32,
}

/// Every way to copy an array, in a loop that never ends by itself.
pub fn copying() -> Vec<Copying> {
    let copying = |name: &'static str, top: &str, before: &str, pass: &str| Copying {
        name,
        text: format!(
            "{top}
            fn distance(p: vec3f) -> f32 {{
                var n = 0.0;
                {before}
                loop {{
                    n += 1.0;
                    {pass}
                    if n > 1e9 {{ break; }}
                }}
                return n;
            }}"
        ),
        copies: 80,
    };
    let two = "var a: array<f32, 80>; var b: array<f32, 80>;";
    let taking = "fn taken(a: array<f32, 80>, k: f32) -> f32 { return a[3] + k; }";
    let giving = "fn given(k: f32) -> array<f32, 80> { var a: array<f32, 80>; a[3] = k; return a; }";
    let pointed = "fn copied(a: ptr<function, array<f32, 80>>, b: ptr<function, array<f32, 80>>) { *a = *b; }";
    let held = "struct Held { a: array<f32, 80>, b: f32 }";
    vec![
        copying("stored", "", two, "b[i32(n)] = n; a = b; b[0] = a[7];"),
        copying("cleared", "", "", "var a: array<f32, 80>; a[i32(n)] = n; n += 0.0 * a[79];"),
        copying("an argument", taking, "var a: array<f32, 80>;", "n += 0.0 * taken(a, n);"),
        copying("a result", giving, "", "n += 0.0 * given(n)[2];"),
        copying("through pointers", pointed, two, "b[i32(n)] = n; copied(&a, &b); b[0] = a[7];"),
        copying("of a structure", held, "var a: Held; var b: Held;", "b.a[i32(n)] = n; a = b; b.b = a.a[7];"),
        copying("composed", held, "var a: array<f32, 80>;", "a[i32(n)] = n; let held = Held(a, n); n += 0.0 * held.b;"),
        copying(
            "of arrays of matrices",
            "",
            "var a: array<array<mat2x2f, 5>, 4>; var b: array<array<mat2x2f, 5>, 4>;",
            // The columns of 20 matrices, read and stored.
            "b[i32(n)][1][1].x = n; a = b; b[0][1][0].y = a[1][2][1].x;",
        ),
        copying("a value with an index", "", "var a: array<f32, 80>;", "let b = a; a[0] = b[i32(n)];"),
        copying("a constant with an index", "const A = array<f32, 80>();", "", "n += A[i32(n)];"),
    ]
}

/// Shape of a shader of `tests/glsl`, with its uniforms as parameters.
pub fn shader_shape(name: &str, lipschitz: f32) -> CustomShape {
    let text = shader_text(name);
    let shader = Shader::read(&text, None, &[]).unwrap_or_else(|faults| panic!("{name}: {faults:#?}"));
    let code = Code::of_shader("shader", &shader).unwrap_or_else(|faults| panic!("{name}: {faults:#?}"));
    let param = |param: &pathmarch_field::custom_sdf::glsl::ShaderParam| Param {
        name: param.name.clone().into(),
        unit: Unit::Ratio,
        default: param.default,
        range: param.range,
        doc: "A uniform.".into(),
    };
    let params = shader.params.iter().map(param).collect();
    CustomShape::new(Info::new("shader", "", "").inexact(), params, lipschitz, Some([4.0; 3]), Arc::new(code))
}

/// Shaders in many styles, kept for tests, and Lipschitz constants of their distances.
pub const SHADERS: [(&str, f32); 10] = [
    ("blob", 1.0),
    ("lattice", 1.0),
    ("columns", 1.5),
    ("mandelbulb", 2.0),
    ("menger", 1.0),
    ("mandelbox", 1.5),
    ("sierpinski", 1.0),
    ("materials", 1.0),
    ("minimal", 1.5),
    ("overloads", 1.0),
];

/// Shaders written fast, with the habits of their authors.
pub const QUICK_SHADERS: [&str; 10] = [
    "quick/weird",
    "quick/ternary",
    "quick/ifdefs",
    "quick/loops",
    "quick/arrays",
    "quick/vectors",
    "quick/locals",
    "quick/hash",
    "quick/unused",
    "quick/fragm",
];

pub fn shader_text(name: &str) -> String {
    let file = format!("{}/../pathmarch-field/tests/glsl/{name}.frag", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file}: {error}"))
}
