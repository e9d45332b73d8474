//! Fields of a scene's own: what the evaluator computes, what is refused, and that nothing hangs.

use crate::fields::{self, declared};
use crate::sampling::{Case, Random, random_params};
use pathmarch_field::custom_sdf::{Code, CodeDiagnostic, budget};
use pathmarch_field::graph::Kind;
use pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_field::number::{Dual, Vec3};
use pathmarch_field::{CustomShape, Field, Node, Placement, ShapeRef};
use pathmarch_field::{EvalShape, Info, Param, Shape};
use std::sync::Arc;
use std::time::Instant;

/// Every field with its defaults and with further numbers. What is registered lives as long as the program, and so do these.
fn cases(random_sets: usize) -> Vec<Case> {
    let mut random = Random::new(40);
    let mut cases = Vec::new();
    for declared in declared() {
        let shape: &'static CustomShape = Box::leak(Box::new(declared.shape()));
        let mut sets = vec![shape.params().iter().map(|param| param.default).collect::<Vec<f32>>()];
        sets.extend((0..random_sets).map(|_| random_params(shape, &mut random)));
        cases.extend(sets.into_iter().map(|params| Case::new(shape, params)));
    }
    cases
}

#[test]
fn lanes_equal_one_point() {
    let mut random = Random::new(1);
    for case in cases(4) {
        case.assert_lanes_equal_one(256, &mut random);
    }
}

#[test]
fn distances_and_gradients_keep_the_declared_constant() {
    let mut random = Random::new(2);
    for case in cases(4) {
        let mut points = case.special_points();
        points.extend(case.points(1000, &mut random));
        for a in points {
            let field = case.gradient(a);
            let length = field.gradient.length();
            assert!(field.value.is_finite() && length.is_finite(), "{} {a:?}: {field:?}", case.name());
            // Differences of f32 over a 4,000th of the size.
            assert!(length <= 1.01, "{} {a:?}: |gradient| = {length}", case.name());
            let b = a + random.direction() * (case.size * 10f32.powf(random.within(-4.0, 1.0)));
            let difference = (case.distance(a) - case.distance(b)).abs();
            let allowed = (a - b).length() + 4e-6 * (a.length() + b.length() + case.size);
            assert!(difference <= allowed, "{} {a:?} {b:?}: {difference} > {allowed}", case.name());
        }
    }
}

#[test]
fn the_box_cuts_the_solid() {
    let mut random = Random::new(3);
    for case in cases(4) {
        let bounds = case.shape.bounds(&case.params);
        for p in case.points(1000, &mut random) {
            assert!(case.distance(p) > 0.0 || bounds.contains(p, 1e-5), "{} {p:?}", case.name());
        }
        assert!(case.points(4000, &mut random).iter().any(|p| case.distance(*p) < 0.0), "{} is empty", case.name());
    }
}

/// A field whose constant is declared too small is caught, and the constant that the survey gives is safe.
#[test]
fn a_survey_finds_false_declarations() {
    let gyroid = |lipschitz: f32| {
        let declared = fields::Declared { lipschitz, ..declared().swap_remove(0) };
        let shape = ShapeRef::Custom(Arc::new(declared.shape()));
        let kind = Kind::Shape { params: vec![0.8, 0.05], shape, tag: 0 };
        check_lipschitz(&Field::new(&[Node { kind, placement: Placement::default() }]), 4000)
    };
    let honest = gyroid(1.75);
    assert!(honest.safe_factor > 0.995 && honest.slope < 1.01, "{honest:?}");
    let lie = gyroid(0.5);
    assert!(lie.safe_factor < 0.8 && lie.slope > 2.0, "{lie:?}");
    let corrected = gyroid(0.5 * lie.slope * 1.02);
    assert!(corrected.safe_factor > 0.99 && corrected.slope < 1.01, "{corrected:?}");
}

/// Texts of random tokens and broken ones of good texts: refused or run, never a panic, and soon.
#[test]
fn hostile_texts_neither_panic_nor_hang() {
    const TOKENS: &[&str] = &[
        "fn",
        "distance",
        "(",
        ")",
        "{",
        "}",
        "p",
        ":",
        "vec3f",
        "->",
        "f32",
        "return",
        ";",
        "loop",
        "for",
        "while",
        "if",
        "else",
        "break",
        "continue",
        "continuing",
        "switch",
        "case",
        "default",
        "let",
        "var",
        "const",
        "struct",
        "ptr",
        "<",
        ">",
        "function",
        ",",
        "array",
        "1.0",
        "4",
        "0",
        "-",
        "*",
        "+",
        "/",
        "%",
        "&",
        "|",
        "=",
        "==",
        "<<",
        "[",
        "]",
        ".x",
        "@",
        "override",
        "alias",
        "i32",
        "u32",
        "1e38",
        "0x7fffffff",
        "select",
        "length",
        "mat3x3f",
        "!",
        "~",
        "q",
        "r",
        "\n",
        "k",
        "normalize",
        "pow",
        "true",
        "bitcast",
        "atomic",
        "enable f16;",
        "var<private>",
        "/*",
        "*/",
        "//",
    ];
    let start = Instant::now();
    let mut random = Random::new(7);
    let good: Vec<&str> = declared().iter().map(|declared| declared.text).collect();
    let mut ran = 0;
    for round in 0..1500 {
        let mut pick = |count: usize| (random.within(0.0, count as f32) as usize).min(count - 1);
        let text = if round % 3 == 0 {
            (0..pick(60) + 1).map(|_| TOKENS[pick(TOKENS.len())]).collect::<Vec<_>>().join(" ")
        } else {
            let mut words: Vec<&str> = good[pick(good.len())].split_inclusive([' ', '(', ')', ';', ',']).collect();
            for _ in 0..pick(4) + 1 {
                let (at, from) = (pick(words.len()), pick(words.len()));
                match pick(3) {
                    0 => drop(words.remove(at)),
                    1 => words[at] = words[from],
                    _ => words.insert(at, TOKENS[pick(TOKENS.len())]),
                }
            }
            words.concat()
        };
        let params = ["k", "cell", "wall", "depth", "width", "turn", "which"];
        if let Ok(code) = code(&params, &text) {
            ran += 1;
            let params = params.iter().map(|name| Param::any(name, 1.5, "")).collect();
            let field = CustomShape::new(Info::new("t", "", ""), params, 1.0, None, Arc::new(code));
            let numbers = field.coefficients(&[]);
            for p in [Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.0, 0.0, 0.0), Vec3::new(-1e6, 3.0, 1e-20)] {
                assert!(field.distance(p, &numbers).is_finite(), "{text}");
                assert!(field.gradient(Dual::variables(p), &numbers).gradient.length().is_finite(), "{text}");
            }
        }
    }
    println!("{ran} of 1500 ran, {:.1} s", start.elapsed().as_secs_f32());
    assert!(ran > 50, "{ran}");
}

/// Texts that are nested, chained or large without bound.
#[test]
fn deep_brackets_are_refused_with_a_reason() {
    for (open, close) in [("(", ")"), ("-(", ")"), ("{", "}")] {
        let (open, close) = (open.repeat(5000), close.repeat(5000));
        let text = match open.starts_with('{') {
            true => format!("fn distance(p: vec3f) -> f32 {{ {open}{close} return p.x; }}"),
            false => format!("fn distance(p: vec3f) -> f32 {{ return {open}p.x{close}; }}"),
        };
        let faults = code(&[], &text).err().expect("too deep");
        // Braces have a limit and a message of naga's own.
        let message = &faults[0].message;
        assert!(message.contains("nested too deeply") || message.contains("nesting limit"), "{faults:?}");
        assert!(faults[0].help.is_some());
    }
}

#[test]
fn large_texts_are_refused_or_run() {
    let start = Instant::now();
    let body = |body: &str| format!("fn distance(p: vec3f) -> f32 {{ {body} }}");
    let nested =
        |open: &str, inside: &str, close: &str, count: usize| open.repeat(count) + inside + &close.repeat(count);
    let sums: String = (1..2_000).map(|k| format!("const C{k} = C{0} + C{0};\n", k - 1)).collect();
    let structs: String = (1..1_000).map(|k| format!("struct S{k} {{ a: S{0}, b: S{0} }}\n", k - 1)).collect();
    for text in [
        body(&format!("return {};", nested("(", "p.x", ")", 20_000))),
        body(&format!("return {};", nested("-", "p.x", "", 60_000))),
        body(&format!("return p.x{};", " + p.y".repeat(8_000))),
        body(&format!("return p.x{};", " + p.y".repeat(2_000))),
        body(&format!("return p.x{};", " + 1".repeat(15_000))),
        body(&format!("return {};", nested("abs(", "p.x", ")", 10_000))),
        body(&(nested("{", "", "}", 20_000) + "return p.x;")),
        body(&(nested("if p.x > 0.0 {", "", "}", 3_000) + "return p.x;")),
        body(&("if p.x > 0.0 { }".to_owned() + &" else if p.x > 0.0 { }".repeat(2_500) + " return p.x;")),
        body(&(nested("for (var i = 0; i < 9; i++) {", "", "}", 1_000) + "return p.x;")),
        body(&(nested("for (var i = 0; i < 9; i++) {", "", "}", 60) + "return p.x;")),
        body(&(nested("loop {", "", "}", 100) + "return p.x;")),
        body("var a: array<f32, 100000000>; return a[i32(p.x)];"),
        body("let a = array<array<f32, 60000>, 60000>(); return a[5][5];"),
        body("const a = array<f32, 2000000000>(); return a[5];"),
        body(&format!("var a: {}; return p.x;", nested("array<", "f32", ",2>", 5_000))),
        body(&format!("var a: {}; return p.x;", nested("array<", "f32", ",2>", 14))),
        format!("const C0 = 1.0;\n{sums}{}", body("return C1999;")),
        format!("struct S0 {{ a: f32 }}\n{structs}{}", body("var s: S999; return p.x;")),
        "fn".repeat(30_000),
        "\u{0}\u{202e}é".repeat(1_000),
    ] {
        let was = Instant::now();
        let shown: String = text.chars().skip(30).take(60).collect();
        let result = code(&[], &text).map(|code| {
            let field = CustomShape::new(Info::new("t", "", ""), Vec::new(), 1.0, None, Arc::new(code));
            field.distance(Vec3::new(0.5, 0.25, 0.1), &field.coefficients(&[]))
        });
        let result = result.map_err(|faults| faults[0].message.clone());
        println!("{:6.0} ms {shown:?}: {result:?}", was.elapsed().as_secs_f32() * 1e3);
        assert!(result.is_ok() || result.is_err_and(|message| message.len() < 400), "{shown:?}");
    }
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

fn code(params: &[&str], text: &str) -> Result<Code, Vec<CodeDiagnostic>> {
    let params: Vec<String> = params.iter().map(|name| name.to_string()).collect();
    Code::new("test", &params, text)
}

fn field(params: &[&'static str], text: &str) -> CustomShape {
    let code = code(params, text).unwrap_or_else(|faults| panic!("{faults:#?}\n{text}"));
    let params = params.iter().map(|name| Param::any(name, 1.0, "")).collect();
    CustomShape::new(Info::new("test", "", ""), params, 1.0, None, Arc::new(code))
}

/// The value of a body of `distance` at a point, where the parameter `k` has this value.
fn value_at(text: &str, p: [f32; 3], k: f32) -> f32 {
    let field = field(&["k"], text);
    field.distance(Vec3::new(p[0], p[1], p[2]), &field.coefficients(&[k]))
}

fn value(body: &str) -> f32 {
    value_at(&format!("fn distance(p: vec3f) -> f32 {{ {body} }}"), [1.0, 2.0, 3.0], 4.0)
}

#[track_caller]
fn gives(body: &str, expected: f32) {
    let value = value(body);
    assert!((value - expected).abs() <= 1e-5 * expected.abs().max(1.0), "{body}: {value}, not {expected}");
}

#[test]
fn arithmetic() {
    gives("return p.x + p.y * p.z;", 7.0);
    gives("return length(p.xy) - 1.0;", 5_f32.sqrt() - 1.0);
    gives("let q = p * k; return q.z;", 12.0);
    gives("return dot(p, p.zyx);", 10.0);
    gives("return (p % vec3f(2.0)).z + -5.5 % 2.0;", 1.0 - 1.5);
    gives("let v = cross(p, vec3f(0.0, 1.0, 0.0)); return v.x * 10.0 + v.z;", -29.0);
    gives("return f32(7 / 2) + f32(-7 / 2) + f32(7u % 4u);", 3.0);
    gives("return f32(i32(-1.7)) + f32(u32(2.9));", 1.0);
    gives("return f32((6 & 3) | 8) + f32(1u << 4u) + f32(-16 >> 2u) + f32(5 ^ 1);", 10.0 + 16.0 - 4.0 + 4.0);
    gives("return select(1.0, 2.0, p.x < p.y) + select(vec3f(1.0), p, p > vec3f(1.5)).y;", 4.0);
    gives("return f32(all(p > vec3f(0.0)) && any(p > vec3f(2.5)) && !(p.x == 2.0));", 1.0);
    gives("return bitcast<f32>(bitcast<u32>(p.y) + 0x800000u);", 4.0);
    gives("let z = p.x - 1.0; let n = i32(z); return f32(5 / n) + f32(5 % n);", 5.0);
}

#[test]
fn functions_of_the_language() {
    gives("return clamp(p.z, 0.0, 2.0) + mix(1.0, p.z, 0.5) + smoothstep(0.0, 4.0, p.y) + step(2.0, p.y);", 5.5);
    gives(
        "return fract(2.75) + floor(-1.5) + ceil(1.2) + round(2.5) + trunc(-1.9) + sign(-3.0);",
        0.75 - 2.0 + 2.0 + 2.0 - 1.0 - 1.0,
    );
    gives("return pow(p.y, 3.0) + exp2(p.z) + log2(8.0) + sqrt(16.0) + inverseSqrt(4.0);", 8.0 + 8.0 + 3.0 + 4.0 + 0.5);
    gives(
        "return sin(p.x) + cos(p.x) + tan(p.x) + atan2(p.x, p.y);",
        1_f32.sin() + 1_f32.cos() + 1_f32.tan() + 1_f32.atan2(2.0),
    );
    gives(
        "return exp(p.x) + log(p.y) + sinh(p.x) + acos(0.5) + degrees(1.0) + radians(180.0);",
        1_f32.exp() + 2_f32.ln() + 1_f32.sinh() + 0.5_f32.acos() + 57.295_78 + std::f32::consts::PI,
    );
    gives("return length(normalize(p)) + length(p - vec3f(1.0, 2.0, 0.0));", 4.0);
    gives(
        "return reflect(p, vec3f(0.0, 1.0, 0.0)).y + faceForward(p, vec3f(0.0, 0.0, 1.0), vec3f(0.0, 0.0, 1.0)).z;",
        -5.0,
    );
    gives("return refract(vec3f(0.0, -1.0, 0.0), vec3f(0.0, 1.0, 0.0), 0.5).y;", -1.0);
    gives(
        "return f32(countOneBits(7u) + firstLeadingBit(16u)) + f32(abs(-3)) + f32(max(2, 5)) + f32(min(2u, 5u));",
        17.0,
    );
    gives("return fma(p.x, p.y, p.z) + saturate(7.0) + abs(-2.0) + max(p.x, p.z) + min(p.x, p.z);", 12.0);
}

#[test]
fn matrices() {
    gives("let m = mat2x2f(1.0, 2.0, 3.0, 4.0); return (m * p.xy).x * 100.0 + (p.xy * m).y;", 711.0);
    gives("let m = mat2x2f(1.0, 2.0, 3.0, 4.0); let n = m * transpose(m); return n[0][1] + n[1].y;", 14.0 + 20.0);
    gives("return determinant(mat3x3f(2.0, 0.0, 1.0, 1.0, 3.0, 2.0, 1.0, 1.0, 1.0));", 0.0);
    gives("return determinant(mat4x4f(2.0,0.0,0.0,0.0, 0.0,3.0,0.0,0.0, 0.0,0.0,4.0,1.0, 0.0,0.0,2.0,1.0));", 12.0);
    gives("var m = mat3x3f(); m[1] = p; let i = i32(k) - 3; return m[i].z + (m * 2.0)[1][1] + (m + m)[1][0];", 9.0);
}

#[test]
fn variables_and_control() {
    gives("var a = 0.0; for (var i = 0; i < 5; i++) { if i == 3 { continue; } a += f32(i); } return a;", 7.0);
    gives("var a = 1.0; while a < 100.0 { a *= 2.0; } return a;", 128.0);
    gives(
        "var a = 0.0; loop { a += 1.0; if a > p.z { break; } continuing { a += 0.5; break if a > 50.0; } } return a;",
        4.0,
    );
    gives(
        "var a = 0; switch i32(p.z) { case 1, 2: { a = 5; } case 3: { a = 7; } default: { a = 9; } } return f32(a);",
        7.0,
    );
    gives(
        "var a = 0; switch i32(p.z) { case 1: { a = 5; } default: { if p.x > 0.0 { break; } a = 9; } } return f32(a);",
        0.0,
    );
    gives(
        "for (var i = 0u; i < 9u; i++) { switch i { case 4u: { return f32(i); } default: { continue; } } } return -1.0;",
        4.0,
    );
    gives(
        "var a = array<f32, 4>(1.0, 2.0, 3.0, 4.0); a[i32(p.y)] = 9.0; return a[2] + a[3] + a[i32(k) + 50];",
        9.0 + 4.0 + 4.0,
    );
    gives("var v = p; v.y = 7.0; v[i32(p.y)] += 1.0; return v.x * 100.0 + v.y * 10.0 + v.z;", 174.0);
}

#[test]
fn functions_structures_and_pointers() {
    let text = "
        const HALF = 0.5;
        const AXES = array<vec3f, 2>(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0));
        struct Ball { at: vec3f, radius: f32 }
        fn turn(q: ptr<function, vec3f>, balls: ptr<function, array<Ball, 2>>) {
            *q = (*q).yzx;
            (*balls)[1].radius = k;
            (*q).x += HALF;
        }
        fn ball(p: vec3f, b: Ball) -> f32 { return length(p - b.at) - b.radius; }
        fn distance(p: vec3f) -> f32 {
            var q = p;
            var balls = array<Ball, 2>(Ball(vec3f(0.0), 1.0), Ball(p, 2.0));
            turn(&q, &balls);
            return q.x * 100.0 + q.z * 10.0 + ball(p, balls[1]) + dot(AXES[i32(q.z)], p);
        }";
    assert_eq!(value_at(text, [1.0, 2.0, 3.0], 4.0), 250.0 + 10.0 - 4.0 + 2.0);
}

/// Eight points go different ways at once.
#[test]
fn lanes_part() {
    use wide::f32x8;
    let text = "fn distance(p: vec3f) -> f32 {
        var a = p.x;
        for (var i = 0; i < 20; i++) {
            if a > 10.0 { return a; }
            if f32(i) > p.y { break; }
            switch i32(p.x) { case 2, 3: { a += 3.0; continue; } case 5: { a -= 1.0; } default: {} }
            a += 1.0;
        }
        return -a;
    }";
    let field = field(&[], text);
    let numbers = field.coefficients(&[]);
    let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    let y = [30.0, 2.0, 30.0, 1.0, 5.0, 30.0, 30.0, 0.0];
    let lanes = field.distance(Vec3::new(f32x8::from(x), f32x8::from(y), f32x8::splat(0.0)), &numbers);
    for (lane, value) in lanes.to_array().into_iter().enumerate() {
        let alone = field.distance(Vec3::new(x[lane], y[lane], 0.0), &numbers);
        assert_eq!(value, alone, "lane {lane}");
        // The same in Rust.
        let mut a = x[lane];
        let mut expected = None;
        for i in 0..20 {
            if a > 10.0 {
                expected = Some(a);
                break;
            }
            if i as f32 > y[lane] {
                break;
            }
            match x[lane] as i32 {
                2 | 3 => {
                    a += 3.0;
                    continue;
                }
                5 => a -= 1.0,
                _ => {}
            }
            a += 1.0;
        }
        assert_eq!(value, expected.unwrap_or(-a), "lane {lane}");
    }
}

/// Loops end when their budget is used up: nested ones, those of called functions, and those that never end.
#[test]
fn loops_share_a_budget() {
    gives("var n = 0.0; loop { n += 1.0; if n < 0.0 { break; } } return n;", budget::LOOP_BUDGET as f32);
    gives(
        "var n = 0.0; for (var i = 0; i < 10; i++) { for (var j = 0; j < 1000; j++) { n += 1.0; } } return n;",
        budget::LOOP_BUDGET as f32 - 1.0,
    );
    let called = "fn more(n: ptr<function, f32>) { loop { *n += 1.0; if *n < 0.0 { break; } } }
        fn distance(p: vec3f) -> f32 { var n = 0.0; more(&n); more(&n); return n; }";
    assert_eq!(value_at(called, [0.0; 3], 0.0), budget::LOOP_BUDGET as f32);
    // A body of many operations takes more.
    let long = "n += sin(n + k);".repeat(60);
    let passes =
        value(&format!("var n = 0.0; var m = 0.0; loop {{ {long} m += 1.0; if m < 0.0 {{ break; }} }} return m;"));
    assert!(passes > 10.0 && passes < budget::LOOP_BUDGET as f32 / 4.0, "{passes}");
}

/// A copy of an array takes as much of the budget as the array has elements, however it is made.
#[test]
fn copies_of_arrays_share_the_budget() {
    for copying in fields::copying() {
        let passes = value_at(&copying.text, [1.0, 2.0, 3.0], 4.0);
        let most = budget::LOOP_BUDGET * budget::OPERATIONS_PER_PASS;
        println!("{}: {passes} passes", copying.name);
        assert!(passes >= 2.0, "{}: {passes}", copying.name);
        assert!(passes as u32 * copying.copies <= most, "{}: {passes}", copying.name);
    }
}

/// Arrays that are too large, too many, or copied too often, are refused, and so is what grows without bound while it is read.
#[test]
fn large_arrays_are_refused() {
    let sum = |count: usize, size: usize| {
        let calls: String = (0..count).map(|k| format!("sum += g()[{}];", k % size)).collect();
        format!(
            "fn g() -> array<f32,{size}> {{ var a: array<f32,{size}>; return a; }}
            fn distance(p: vec3f) -> f32 {{ var sum = p.x; {calls} return sum; }}"
        )
    };
    let body = |top: &str, body: &str| format!("{top}\nfn distance(p: vec3f) -> f32 {{ {body} return p.x; }}");
    let doubled = |read: &str, first: &str, next: &dyn Fn(usize) -> String| {
        (1..25).fold(first.to_owned(), |all, k| all + &next(k))
            + &format!("fn distance(p: vec3f) -> f32 {{ let a = C24{read}; return p.x; }}")
    };
    let nested = |levels: usize| "array<".repeat(levels) + "f32" + &",300>".repeat(levels);
    let variables: String = (0..300).map(|k| format!("var a{k}: array<f32, 8>; a{k}[i32(p.x)] = p.y;")).collect();
    for (text, said, place) in [
        (sum(255, 10_000), "The variable `a` has 10000 numbers; a variable", "a"),
        (sum(255, 60), "arrays of this function come to", "distance"),
        (sum(250, 8), "arrays of this function come to", "distance"),
        (body("", "var a: array<array<f32, 65535>, 65535>;"), "`a` has 4294836225 numbers", "a"),
        (body("", "let a = array<array<f32, 60000>, 60000>();"), "has 3600000000 numbers", "array"),
        (body("", &format!("var a: {};", nested(4))), "more than 4 billion numbers", "a"),
        (body("", &variables), "arrays of this function come to 2400 numbers", "distance"),
        (body("struct S { a: array<vec4f, 600>, b: f32 }", "var s: S;"), "`s` has 2401 numbers", "s"),
        (body("fn f(a: array<f32, 3000>) -> f32 { return 1.0; }", ""), "The argument `a` of `f` has 3000", "f"),
        (
            body("fn f(a: ptr<function, array<f32, 3000>>) { (*a)[0] = 1.0; }", "var b: array<f32, 3000>; f(&b);"),
            "`b`",
            "b",
        ),
        (body("fn f() -> array<f32, 3000> { return array<f32, 3000>(); }", ""), "The result of `f` has 3000", "f"),
        (body("const A = array<f32, 3000>();", "let a = A[i32(p.x)];"), "The constant `A` has 3000 numbers", "A"),
        (
            doubled("[0]", "const C0 = array(array(1f, 2f), array(3f, 4f));", &|k| {
                format!("const C{k} = array(C{0}, C{0});", k - 1)
            }),
            "The constant `C",
            "C",
        ),
        (
            doubled(".a", "struct S0 { a: f32 }\nconst C0 = S0(1.0);", &|k| {
                format!("struct S{k} {{ a: S{0}, b: S{0} }}\nconst C{k} = S{k}(C{0}, C{0});", k - 1)
            }),
            "The constant `C",
            "C",
        ),
        (
            body(
                "const A = array<f32, 200>();",
                &"let a = A[1] + A[2];".repeat(300).replace("let a", "{ let a").replace(';', ";}"),
            ),
            "as often as it is named",
            "A",
        ),
        (
            body("const A = array<f32, 100>();", "let a = A[i32(p.x)] + A[i32(p.y)] + A[i32(p.z)];"),
            "300 numbers",
            "distance",
        ),
    ] {
        let fault = fault(&["k"], &text);
        println!("{}", fault.message);
        assert!(fault.message.contains(said), "{said}: {fault:?}");
        let found = fault.range.clone().map(|range| &text[range]);
        assert!(found.is_some_and(|found| found.contains(place)), "{said}: {found:?}");
        assert!(fault.help.is_some(), "{fault:?}");
    }
    // Operations: loads and stores of one array are no further memory, but work.
    let stores = "a = v; a[0] = a[i32(p.y)];".repeat(150);
    let refused = fault(&[], &body("", &format!("var a: array<f32, 60>; var b: array<f32, 60>; let v = b; {stores}")));
    assert!(refused.message.contains("operations"), "{refused:?}");
    let indexed: String = (0..300).map(|k| format!("a[i32(p.x * {k}.0)] = p.y;")).collect();
    let refused = fault(&[], &body("", &format!("var a: array<f32, 60>; {indexed}")));
    assert!(refused.message.contains("operations"), "{refused:?}");
    // What is said to be allowed is.
    value_at(&sum(5, 8), [1.0, 2.0, 3.0], 4.0);
    let table: String = (0..256).map(|k| format!("{k}.0, ")).collect();
    let table = format!("const TABLE = array<f32, 256>({table});");
    let reads = "var t = TABLE; return t[i32(p.x)] + t[i32(p.y)] + t[i32(p.z)] + t[i32(k)];";
    let value = value_at(&format!("{table} fn distance(p: vec3f) -> f32 {{ {reads} }}"), [1.0, 20.0, 255.0], 4.0);
    assert_eq!(value, 280.0);
}

fn fault(params: &[&str], text: &str) -> CodeDiagnostic {
    match code(params, text) {
        Ok(_) => panic!("accepted: {text}"),
        Err(faults) => faults[0].clone(),
    }
}

#[test]
fn what_is_refused_and_where() {
    let wrapped = |top: &str, body: &str| format!("{top}\nfn distance(p: vec3f) -> f32 {{ {body} return p.x; }}");
    for (text, place) in [
        (wrapped("", "let a = b;"), "b"),
        (wrapped("", "let a = p.x"), "return"),
        (wrapped("var<private> a: f32;", ""), "a"),
        (wrapped("@group(0) @binding(0) var<storage> a: array<f32>;", ""), "a"),
        (wrapped("override a: f32;", ""), "a"),
        (wrapped("@compute @workgroup_size(1) fn main() {}", ""), "fn main"),
        (wrapped("var<workgroup> a: atomic<u32>;", ""), "a"),
        (wrapped("", "let a = dpdx(p.x);"), "dpdx"),
        (wrapped("", "workgroupBarrier();"), "workgroupBarrier"),
        (wrapped("", "let a = pack4x8unorm(vec4f(p, 1.0));"), "pack4x8unorm"),
        (wrapped("", "var a = p; a = 1.0;"), "1.0"),
        (wrapped("fn f() -> f32 { return f(); }", ""), "f"),
        ("fn distance(p: vec2f) -> f32 { return p.x; }".to_owned(), "distance"),
    ] {
        let fault = fault(&["k"], &text);
        let found = fault.range.clone().map(|range| &text[range]);
        assert!(found.is_some_and(|found| found.contains(place)), "{text}\n{fault:?}\n{found:?}");
    }
    assert!(fault(&[], "fn other() {}").message.contains("`distance`"));
    assert!(fault(&["loop"], "fn distance(p: vec3f) -> f32 { return 1.0; }").range.is_none());
    let many: String = (0..200).map(|k| format!("fn one_{k}(x: f32) -> f32 {{ return x; }}\n")).collect();
    let calls: String = (0..200).map(|k| format!("let a{k} = one_{k}(p.x);")).collect();
    let fault_of_many = fault(&[], &wrapped(&many, &calls));
    assert!(fault_of_many.message.contains("functions"), "{fault_of_many:?}");
    // Calls of calls: two to the power of thirty.
    let doubling: String =
        (1..30).map(|k| format!("fn f{k}(x: f32) -> f32 {{ return f{0}(x) + f{0}(x + 1.0); }}\n", k - 1)).collect();
    let fault =
        fault(&[], &format!("fn f0(x: f32) -> f32 {{ return sin(x); }}\n{}", wrapped(&doubling, "let a = f29(1.0);")));
    assert!(fault.message.contains("operations"), "{fault:?}");
}

/// Names of one field are not those of another, and nothing of the kernel can be named.
#[test]
fn names_are_isolated() {
    let text = "struct Frame { a: f32 }\nconst PI = 3.0;\nfn helper(frame: Frame) -> f32 { return frame.a * PI; }\n\
                fn march(p: vec3f) -> f32 { return helper(Frame(p.x)); }\nfn distance(p: vec3f) -> f32 { return march(p); }";
    let shape = |identifier: &str| {
        let code = Code::new(identifier, &[], text).unwrap_or_else(|faults| panic!("{faults:?}"));
        CustomShape::new(Info::new("x", "", ""), Vec::new(), 1.0, Some([1.0; 3]), Arc::new(code))
    };
    let kernel = "struct Frame { a: vec3f }\nfn march(p: vec3f) -> Frame { return Frame(p); }\nfn distance_() {}\n";
    let fields: String =
        ["a", "a_1", "b"].map(|name| shape(name).wgsl_distance() + &shape(name).wgsl_gradient()).concat();
    let module = naga::front::wgsl::parse_str(&format!("{kernel}{fields}"))
        .unwrap_or_else(|error| panic!("{error:?}\n{fields}"));
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    validator.validate(&module).expect("valid");
    for named in
        ["march(p)", "frame.tolerance", "field_vector(0).x", "user_test_passes", "own_test_size(p, 1.0, 1.0, 1.0)"]
    {
        assert!(code(&[], &format!("fn distance(p: vec3f) -> f32 {{ return {named}; }}")).is_err(), "{named}");
    }
}

/// What is not finite is outside, and its gradient a direction.
#[test]
fn values_that_are_not_finite() {
    for body in [
        "return p.x / (p.y - p.y);",
        "return log(-1.0 - p.x * p.x);",
        "return sqrt(-1.0 - p.x * p.x);",
        "return normalize(p * 0.0).x;",
    ] {
        let code = Arc::new(code(&[], &format!("fn distance(p: vec3f) -> f32 {{ {body} }}")).expect("valid"));
        for edges in [None, Some([2.0; 3])] {
            let field = CustomShape::new(Info::new("x", "", ""), Vec::new(), 1.0, edges, code.clone());
            let numbers = field.coefficients(&[]);
            for p in [Vec3::new(0.5, 0.2, 0.1), Vec3::new(0.0, 0.0, 0.0), Vec3::new(30.0, 0.2, 0.1)] {
                let distance = field.distance(p, &numbers);
                assert!(distance.is_finite() && distance > 0.0, "{body} at {p:?}: {distance}");
                let gradient = field.gradient(Dual::variables(p), &numbers).gradient;
                assert!((1e-3..1.5).contains(&gradient.length()), "{body} at {p:?}: {gradient:?}");
            }
        }
    }
}
