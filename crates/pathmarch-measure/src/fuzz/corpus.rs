//! Inputs that random ones are made of.

use super::targets::Target;
use pathmarch_render::image::{ImageFormat, Picture, Provenance, encode};
use pathmarch_render::tonemap::Display;
use std::path::Path;

const TRIANGLE: [&[u8]; 3] = [
    b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\n",
    b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
];

const CODES: [&str; 3] = [
    "fn distance(p: vec3f) -> f32 { return length(p) - 1.0; }",
    "fn distance(p: vec3f) -> f32 { var d = 1e9; for (var k = 0; k < 8; k++) { let q = p * f32(k + 1); d = min(d, length(q) - 1.0 / f32(k + 1)); } return d; }",
    "struct S { a: vec3f, b: array<f32, 4> }\nconst K = array<f32, 3>(1.0, 2.0, 3.0);\nfn f(s: ptr<function, S>, k: i32) -> f32 { (*s).b[k] = (*s).a.x; return (*s).b[k & 3]; }\nfn distance(p: vec3f) -> f32 { var s: S; s.a = p; var m = mat3x3f(p, p.yzx, p.zxy); let d = m * p; loop { if d.x > 1.0 { break; } return f(&s, i32(p.x)) + K[u32(p.y)]; } return d.x; }",
];

const SHADERS: [&str; 3] = [
    "#define R(a) mat2(cos(a),sin(a),-sin(a),cos(a))\nfloat map(vec3 p) { p.xy *= R(iTime); float d = 1e9, e[2], f; for (int i = 0; i < 5; i++) { e[i & 1] = length(p) - .1 * float(i); d = min(d, e[0]); } return d; }",
    "#include \"a.frag\"\nuniform vec3 A; slider[(0,0,0),(1,2,3),(4,4,4)]\nuniform int N; slider[0,3,9]\n#define providesInit\nmat3 m;\nvoid init() { m = rotationMatrix3(A, 30.0); }\nfloat DE(vec3 z) { int n = 0; while (n < N) { z = abs(z * m) - 0.5; if (z.x < z.y) z.xy = z.yx; n++; } return smin(length(z), 1.0, 0.1); }\n#preset Default\nN = 4\n#endpreset\n",
    "#ifdef X\n#else\nstruct S { vec3 a; float b; };\n#endif\nconst float K[3] = float[3](1., 2., 3.);\nvoid f(inout S s, const int k) { s.a.xz = s.a.zx; s.b += K[k]; }\nvec2 map(vec3 p) { S s = S(p, 0.); f(s, int(p.x) & 1); switch (int(p.y)) { case 1: return vec2(1); default: break; } return s.b > 1. ? s.a.xy : inverse(mat2(1., 0., 0., 1.)) * mod(p, 2.).xy; }",
];

const SKY: &[u8] =
    b"pathmarch 1\ncamera { position 0 1 4 }\nsky \"day\" elevation=35 azimuth=140\nobject \"a\" { sphere }\n";

/// Small pictures of all formats.
fn pictures() -> Vec<Vec<u8>> {
    let picture = Picture::from_fn(9, 7, |x, y| [x as f32 / 9.0, y as f32 / 7.0, 0.5]);
    let (path, display, provenance) = (Path::new("a"), Display::default(), Provenance::default());
    let formats = [ImageFormat::Exr, ImageFormat::Png, ImageFormat::Jpeg];
    formats
        .iter()
        .filter_map(|format| encode(path, *format, &picture, Vec::new(), &display, &provenance).ok())
        .collect()
}

/// A small film.
fn films() -> Vec<Vec<u8>> {
    let header = r#"{"size":[3,2],"samples":[0,20],"identity":{"a":"b"},"engines":["CPU"],"notes":{},"regions":[{"rect":[0,0,3,2],"blocks":[],"layers":[[0,4],[9,1]]}]}"#;
    let check = |bytes: &[u8]| crc32fast::hash(bytes).to_le_bytes();
    let chunk: Vec<u8> = (0..4 + 12 + 12).flat_map(|plane: u8| [0, plane]).collect();
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    let film = [
        b"PMFILM01".as_slice(),
        &length(header.as_bytes()),
        header.as_bytes(),
        &check(header.as_bytes()),
        &length(&chunk),
        &check(&chunk),
        &chunk,
        b"PMFILM.E",
    ];
    vec![film.concat()]
}

/// Inputs of a target.
pub(super) fn corpus(target: Target) -> Vec<Vec<u8>> {
    match target {
        Target::Scene | Target::Field | Target::GpuField => {
            // Long ones, and skies that are computed, take most of the time and show nothing more.
            let texts = pathmarch_gallery::EXAMPLES.iter().map(|example| example.text);
            let short = texts.filter(|text| text.len() < 1500 && !text.contains("\"day\""));
            short.map(|text| text.as_bytes().to_vec()).chain([SKY.to_vec()]).collect()
        }
        Target::Picture => pictures(),
        Target::Film => films(),
        Target::Mesh => TRIANGLE.iter().map(|bytes| bytes.to_vec()).collect(),
        Target::Wgsl => CODES.iter().map(|code| code.as_bytes().to_vec()).collect(),
        Target::Glsl => SHADERS.iter().map(|code| code.as_bytes().to_vec()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    /// Otherwise nothing beyond the first check would be tried.
    #[test]
    fn inputs_of_every_corpus_are_accepted() {
        let scratch = tempfile::tempdir().expect("a directory");
        for target in
            Target::value_variants().iter().filter(|target| !matches!(target, Target::Field | Target::GpuField))
        {
            let accepted = corpus(*target).iter().filter(|input| target.run(input, scratch.path()) == Ok(true)).count();
            assert!(accepted > 0, "{target:?}");
        }
    }
}
