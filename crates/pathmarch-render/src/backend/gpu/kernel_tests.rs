//! Tests that every kernel is valid WGSL, and that every backend of wgpu can translate it. They need no adapter.
//!
//! There are two groups of scenes: every scene of the gallery, and sets of the features below. Every two features occur
//! together and apart in these sets, because their declarations may collide although each is valid alone. All modes are
//! tested. naga parses and validates each kernel and translates it to MSL, HLSL, GLSL ES and SPIR-V; views of the gallery
//! and of single features are not translated, as those of sets are. If `spirv-val` (SPIRV-Tools) is installed, it checks
//! the SPIR-V.

use super::{KernelSource, KernelTarget};
use crate::backend::RenderInput;
use crate::integrator::emitter_edges::EmitterEdges;
use crate::integrator::sample_counts_choice::BestCounts;
use crate::mode::Mode;
use crate::settings::Settings;
use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use pathmarch_field::registry::{modifiers, operators, shapes};
use pathmarch_scene::{Scene, textures};
use rayon::prelude::*;
use std::collections::HashSet;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

/// Part of a scene that adds code to a kernel.
struct Feature {
    name: String,
    /// Nodes at the top level of the scene file.
    text: String,
    /// True for a sky: a scene has only one.
    sky: bool,
    /// Settings inside `render { }`.
    render: &'static str,
}

impl Feature {
    fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into(), sky: false, render: "" }
    }

    fn object(name: &str, solid: &str) -> Self {
        Self::new(name, format!("object \"{name}\" {{ {solid} }}"))
    }

    /// Material on a box and on a blend, so that the kernel needs it for analytic and sphere-traced hits.
    fn material(name: &str, material: &str) -> Self {
        let text = format!(
            "material \"{name}\" {{ {material} }}\nobject \"{name} box\" material=\"{name}\" {{ box 0.5 }}\n\
             object \"{name} blend\" material=\"{name}\" {{ union smooth=0.1 {{ box 0.5; mandelbulb }} }}"
        );
        Self::new(name, text)
    }
}

/// All features that change the kernel; `picture` is the path of an image file.
fn features(picture: &Path) -> Vec<Feature> {
    let mut all = Vec::new();
    for shape in shapes() {
        let info = shape.info();
        let solid = match info.profile {
            true => format!("extrude {{ {} }}", info.name),
            false => info.name.to_string(),
        };
        all.push(Feature::object(info.name.as_ref(), &solid));
    }
    for operator in operators() {
        let name = &*operator.info().name;
        all.push(Feature::object(name, &format!("{name} {{ sphere 1; box 1 }}")));
    }
    for profile in ["soft", "round", "chamfer", "stairs"] {
        let solids = format!("union smooth=0.2 profile=\"{profile}\" {{ sphere 1; box 1.2 }}");
        let text = format!(
            "material \"m {profile}\" {{ metal }}\nobject \"{profile}\" {{ {solids} }}\nobject \"cut {profile}\" \
             {{ subtract smooth=0.1 profile=\"{profile}\" {{ box 1; sphere 0.6 material=\"m {profile}\" }} }}"
        );
        all.push(Feature::new(profile, text));
    }
    for modifier in modifiers() {
        let name = &*modifier.info().name;
        let inside = if matches!(name, "extrude" | "revolve") { "star" } else { "torus 0.5 0.1" };
        all.push(Feature::object(&format!("modifier {name}"), &format!("{name} {{ {inside} }}")));
    }
    for kind in textures::kinds() {
        let name = kind.name;
        let (number, bump) = (format!("{name} as a number"), format!("{name} as bump"));
        all.push(Feature::material(name, &format!("diffuse {{ {name} {{ colour 1; colour 0.1 0.2 0.3 }} }}")));
        all.push(Feature::material(&number, &format!("principled 0.5; roughness {{ {name} }}")));
        all.push(Feature::material(&bump, &format!("metal 0.8; bump {{ {name} height=0.01 }}")));
    }
    let picture = picture.display();
    all.push(Feature::material("picture", &format!("diffuse {{ picture \"{picture}\" }}")));
    all.push(Feature::material(
        "picture as bump",
        &format!("diffuse 0.5; bump {{ picture \"{picture}\" height=0.01 }}"),
    ));
    all.extend(mesh_features(&picture.to_string()));
    for (name, material) in [
        ("diffuse", "diffuse 0.5"),
        ("metal", "metal 1 0.8 0.4; roughness 0.3"),
        ("mirror", "metal 1; roughness 0"),
        ("clear glass", "glass 1; ior 1.5"),
        ("frosted glass", "glass 1; roughness 0.3; absorb 1 2 3"),
        ("milk", "glass 1; roughness 0.3; scatter 3 2 1; anisotropy 0.5; glow 0 0.1 0"),
        ("smoke", "medium 2; absorb 0.5"),
        ("nested glass", "glass 1; ior 1.4; priority 2; absorb 1"),
        ("thin glass", "glass 1; thin #true"),
        ("nested principled", "principled 0.8; transmission 0.5; priority 1"),
        ("principled", "principled 0.8; coat 1; metallic 0.5; transmission 0.3"),
        ("orbit trap", "diffuse 0.8; orbit-trap \"point\" { colour 1; colour 0 }"),
    ] {
        all.push(Feature::material(name, material));
    }
    let lamp = |name: &str, solid: &str| {
        let text = format!("material \"m {name}\" {{ emit 3 }}\nobject \"{name}\" material=\"m {name}\" {{ {solid} }}");
        Feature::new(name, text)
    };
    all.push(lamp("sphere lamp", "sphere 0.2 { at 0 3 0 }"));
    all.push(lamp("rect lamp", "rect 1 1 { normal 0 -1 0; at 0 4 0 }"));
    all.push(lamp("disc lamp", "disc 0.5 { normal 0 -1 0; at 1 4 0 }"));
    all.push(lamp("box lamp", "box 0.3 { at 1 3 0 }"));
    all.push(lamp("torus lamp", "torus 0.3 0.1 { at -1 3 0 }"));
    all.push(lamp("blended lamp", "union smooth=0.1 { sphere 0.3; box 0.3 material=\"m blended lamp\" }"));
    all.push(lamp("many lamps", &"sphere 0.1 { at 0 2 0 }; ".repeat(3)));
    all.push(Feature::new("point", "point { at 1 4 2; intensity 20 }"));
    all.push(Feature::new("point with penumbra", "point { at 1 4 2; intensity 20; penumbra 16 }"));
    all.push(Feature::new("fog", "fog { scatter 0.1; absorb 0.02; glow 0.01; anisotropy 0.3 }"));
    all.push(Feature::new("sun", "sun { direction 1 2 1; irradiance 2; angle 1 }"));
    all.push(Feature::new("sun without size", "sun { direction 1 2 1; irradiance 2; angle 0 }"));
    all.push(Feature::new("sun with penumbra", "sun { direction 1 2 1; irradiance 2; penumbra 8 }"));
    let gradient = "sky \"gradient\" { zenith 0.2 0.4 0.8; horizon 0.8 0.85 0.9 }";
    for (name, text) in [("gradient sky", gradient), ("day sky", "sky \"day\" elevation=30")] {
        all.push(Feature { sky: true, ..Feature::new(name, text) });
    }
    for (name, render) in
        [("caustics", "caustics \"fast\""), ("clamp", "clamp 2"), ("sampler", "sampler \"independent\"")]
    {
        all.push(Feature { render, ..Feature::new(name, "") });
    }
    let mirror = "material \"polished\" { metal 1 }\nobject \"polished\" material=\"polished\" { box 1 2 0.1 { at 0 1 -2 } }\n\
                  point { at 2 4 2; intensity 9 }";
    all.push(Feature { render: "caustics \"traced\"", ..Feature::new("traced caustics", mirror) });
    let custom = r#"field "egg" {
        param size 0.5 min=0.1 max=4 doc="Radius, metres."
        bounds 4
        wgsl """
            fn helper(v: vec3f) -> f32 {
                var sum = 0.0;
                for (var k = 0; k < 3; k++) {
                    sum += abs(v[k]);
                }
                return sum;
            }
            fn distance(p: vec3f) -> f32 {
                return max(length(p), 0.5 * helper(p)) - size;
            }
            """
    }
    object "egg" { egg size=0.4 }"#;
    all.push(Feature::new("custom field", custom));
    let copies = |count: usize, before: &str, after: &str| {
        (0..count).map(|k| format!("{before}{k}{after}")).collect::<Vec<_>>().join("\n")
    };
    let spheres = copies(30, "sphere 0.1 { at 0.", " 0 0 }");
    all.push(Feature::object("union of many spheres", &format!("union {{ {spheres} }}")));
    all.push(Feature::object("blend of many spheres", &format!("union smooth=0.05 {{ {spheres} }}")));
    all.push(Feature::new("many objects", copies(60, "object \"o", "\" { sphere 0.1 }")));
    all.push(Feature::new("many sphere-traced objects", copies(30, "object \"torus ", "\" { torus 0.3 0.1 }")));
    all
}

/// Features of meshes; `picture` is the path of an image file.
fn mesh_features(picture: &str) -> Vec<Feature> {
    let model = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-mesh/tests/data").join(name);
    let (plain, smooth) = (model("BoxVertexColors.glb"), model("suzanne.glb"));
    let (plain, smooth) = (plain.display(), smooth.display());
    let field = |path: &dyn Display| format!("mesh \"{path}\" as=\"field\" resolution=16");
    let at_uvs = |name: &str, solid: &str| {
        let material = format!("material \"m {name}\" {{ diffuse {{ picture \"{picture}\" uv=#true }} }}");
        Feature::new(name, format!("{material}\nobject \"{name}\" material=\"m {name}\" {{ {solid} }}"))
    };
    vec![
        Feature::object("triangles", &format!("mesh \"{plain}\"")),
        Feature::object("smooth triangles", &format!("mesh \"{smooth}\" {{ rotate 0 30 0; scale 0.5 }}")),
        Feature::object("mesh field", &format!("union smooth=0.1 {{ sphere 0.5; {} }}", field(&smooth))),
        Feature::object("lit triangles", &format!("mesh \"{smooth}\" as=\"lit-by-field\" resolution=16")),
        at_uvs("uv triangles", &format!("mesh \"{plain}\"")),
        at_uvs("uv field", &format!("twist 0.1 {{ {} }}", field(&plain))),
        at_uvs("uv box", "box 1"),
    ]
}

/// Scene with all of these features; of several skies, or values of a setting, it has the first.
fn scene_of(features: &[&Feature], path: &str) -> Scene {
    let first_sky = features.iter().position(|feature| feature.sky);
    let mut text = String::from("pathmarch 1\ncamera { position 0 1 5; target 0 0.5 0 }\n");
    let mut words = HashSet::new();
    let settings = features.iter().map(|feature| feature.render).filter(|text| !text.is_empty());
    let settings: Vec<_> = settings.filter(|text| words.insert(text.split(' ').next())).collect();
    text += &format!("render {{ {} }}\n", settings.join("; "));
    if first_sky.is_none() {
        text += "sky 0.5\n";
    }
    for (index, feature) in features.iter().enumerate() {
        if !feature.sky || first_sky == Some(index) {
            text += &feature.text;
            text.push('\n');
        }
    }
    let names: Vec<_> = features.iter().map(|feature| feature.name.as_str()).collect();
    Scene::parse(path, &text).unwrap_or_else(|error| panic!("{names:?}: {error:?}\n{text}"))
}

/// Kernel sources of a scene in a mode. With four paths for each camera ray, pixels share light where that is possible, and
/// numbers are constants. Where a path starts alone, there are also a kernel for coverage by emitters if the scene has any, one
/// for albedos of pixels if it has textures, one that records guides while pixels share light, one that samples several lights,
/// and one for edges of emitters.
fn kernels(scene: &Scene, mode: Mode, splitting: Option<u32>, software: bool) -> Vec<String> {
    let settings = Settings { size: [8, 8], mode, splitting, path_reuse: Some(true), ..Settings::of(scene) };
    let mut input = RenderInput::new(scene, &settings).with_guides();
    if splitting == Some(4) {
        input.choose_path_reuse(&settings, settings.samples, &BestCounts::one(), 1.0);
        input.config.constant_numbers = true;
    }
    let source = KernelSource::for_target(&input, KernelTarget::new(software));
    let sources = [Some(source.code), source.coverage, source.albedos];
    let mut sources: Vec<String> = sources.into_iter().flatten().collect();
    if !software && input.records_guides() && input.can_reuse_paths(&settings) {
        input.config.path_reuse = true;
        sources.push(KernelSource::for_target(&input, KernelTarget::new(software)).code);
    }
    if mode == Mode::Path && splitting.unwrap_or(1) == 1 && !input.config.media {
        let mut input = RenderInput::new(scene, &settings);
        (input.config.light_samples, input.config.indirect_samples) = (4, 2);
        input.edges = Some(Arc::new(EmitterEdges::at(8, vec![5, 12])));
        let source = KernelSource::for_target(&input, KernelTarget::new(software));
        sources.extend([Some(source.code), source.edges].into_iter().flatten());
    }
    sources
}

/// Parses and validates a kernel; returns the mistake with its line if it is not valid.
fn validated(code: &str) -> Result<(Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(code).map_err(|error| error.emit_to_string(code))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| error.emit_to_string(code))?;
    Ok((module, info))
}

/// Translates a kernel to the languages of all backends; returns its SPIR-V words.
fn translated(module: &Module, info: &ModuleInfo) -> Result<Vec<u32>, String> {
    let options = msl::Options { lang_version: (2, 0), ..msl::Options::default() };
    msl::write_string(module, info, &options, &msl::PipelineOptions::default())
        .map_err(|error| format!("MSL: {error}"))?;

    let mut text = String::new();
    let options = hlsl::Options::default();
    hlsl::Writer::new(&mut text, &options, &hlsl::PipelineOptions::default())
        .write(module, info, None)
        .map_err(|error| format!("HLSL: {error}"))?;

    text.clear();
    let options = glsl::Options { version: glsl::Version::new_gles(310), ..glsl::Options::default() };
    let entry =
        glsl::PipelineOptions { shader_stage: ShaderStage::Compute, entry_point: "trace".to_owned(), multiview: None };
    glsl::Writer::new(&mut text, module, info, &options, &entry, BoundsCheckPolicies::default())
        .and_then(|mut writer| writer.write())
        .map_err(|error| format!("GLSL ES: {error}"))?;

    let options = spv::Options { lang_version: (1, 3), ..spv::Options::default() };
    spv::write_vec(module, info, &options, None).map_err(|error| format!("SPIR-V: {error}"))
}

/// Checks SPIR-V with `spirv-val`, if it is installed. It must be installed if `PATHMARCH_REQUIRE_GPU` is set.
fn check_spirv(words: &[u32], folder: &Path, number: usize) -> Result<(), String> {
    let file = folder.join(format!("{number}.spv"));
    std::fs::write(&file, bytemuck::cast_slice(words)).map_err(|error| error.to_string())?;
    let output = Command::new("spirv-val").args(["--target-env", "vulkan1.1"]).arg(&file).output();
    let _ = std::fs::remove_file(&file);
    match output {
        Ok(output) if !output.status.success() => {
            Err(format!("spirv-val: {}", String::from_utf8_lossy(&output.stderr)))
        }
        Err(error) if std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some() => Err(format!("spirv-val: {error}")),
        _ => Ok(()),
    }
}

/// Kernel to check.
struct Kernel {
    /// What it renders.
    name: String,
    code: String,
    /// True if it is also translated for the backends.
    is_translated: bool,
}

/// Checks all distinct kernels; returns their number.
fn check_all(kernels: Vec<Kernel>) -> usize {
    let mut seen = HashSet::new();
    let different: Vec<_> = kernels.into_iter().filter(|kernel| seen.insert(kernel.code.clone())).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let faults: Vec<String> = different
        .par_iter()
        .enumerate()
        .filter_map(|(number, Kernel { name, code, is_translated })| {
            let result = validated(code).and_then(|(module, info)| match is_translated {
                true => check_spirv(&translated(&module, &info)?, folder.path(), number),
                false => Ok(()),
            });
            result.err().map(|fault| format!("{name}: {fault}"))
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{} of {} kernels:\n{}",
        faults.len(),
        different.len(),
        faults[..faults.len().min(5)].join("\n")
    );
    different.len()
}

/// Scene files of the gallery.
fn gallery() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut files = Vec::new();
    for folder in ["", "thesis", "fractals", "benchmarks"] {
        for file in std::fs::read_dir(root.join(folder)).expect("the scenes are there") {
            let path = file.expect("a file").path();
            if path.extension().is_some_and(|extension| extension == "kdl") {
                files.push(path);
            }
        }
    }
    files
}

#[test]
fn slow_every_scene_of_the_gallery_compiles_in_every_mode() {
    let kernels = gallery().into_par_iter().flat_map_iter(|file| {
        let scene = Scene::load(&file).expect("a valid scene");
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let in_mode = move |mode: Mode| {
            let splits = if mode == Mode::Path { vec![Some(1), Some(2), Some(4)] } else { vec![Some(1)] };
            // Views are translated by the other test.
            let is_translated = mode == Mode::Path;
            let named = |(splitting, software)| {
                let name = format!("{name} in {}", mode.name());
                let codes = kernels(&scene, mode, splitting, software).into_iter();
                codes.map(move |code| Kernel { name: name.clone(), code, is_translated })
            };
            splits.into_iter().flat_map(|s| [(s, false), (s, true)]).flat_map(named).collect::<Vec<_>>()
        };
        Mode::ALL.into_iter().flat_map(in_mode)
    });
    let count = check_all(kernels.collect());
    println!("{count} kernels");
    assert!(count > 500);
}

/// Sets of features such that every two of them occur together, and each without the other. A bit of a hash decides whether a
/// set contains a feature.
fn covering_sets(features: usize) -> Vec<Vec<usize>> {
    const SETS: u32 = 40;
    // PCG hash (Jarzynski and Olano 2020).
    let hash = |x: u32| {
        let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    let takes = |set: u32, feature: usize| hash(hash(feature as u32) ^ set) & 1 == 1;
    let sets: Vec<Vec<usize>> =
        (0..SETS).map(|set| (0..features).filter(|&feature| takes(set, feature)).collect()).collect();
    for a in 0..features {
        for b in (0..features).filter(|&b| b != a) {
            let together = sets.iter().any(|set| set.contains(&a) && set.contains(&b));
            let apart = sets.iter().any(|set| set.contains(&a) && !set.contains(&b));
            assert!(together && apart, "features {a} and {b} are not covered: more sets are needed");
        }
    }
    sets
}

#[test]
fn slow_every_pair_of_features_compiles_in_every_mode() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = folder.path().join("picture.png");
    image::RgbImage::from_pixel(4, 4, image::Rgb([200, 100, 50])).save(&picture).expect("is written");
    let features = features(&picture);
    let path = folder.path().join("test.kdl").display().to_string();
    let alone = (0..features.len()).map(|feature| vec![feature]);
    let sets: Vec<Vec<usize>> = alone.chain(covering_sets(features.len())).collect();
    let kernels = sets.into_par_iter().enumerate().flat_map_iter(|(number, set)| {
        let scene = scene_of(&set.iter().map(|&feature| &features[feature]).collect::<Vec<_>>(), &path);
        let name = if set.len() == 1 { features[set[0]].name.clone() } else { format!("set {number}: {set:?}") };
        let in_mode = move |mode: Mode| {
            let name = format!("{name} in {}", mode.name());
            // What a view needs of a feature alone, it also needs of that feature among others.
            let is_translated = mode == Mode::Path || set.len() > 1;
            let codes = kernels(&scene, mode, None, number % 2 == 0).into_iter();
            codes.map(move |code| Kernel { name: name.clone(), code, is_translated })
        };
        Mode::ALL.into_iter().flat_map(in_mode).collect::<Vec<_>>()
    });
    let count = check_all(kernels.collect());
    println!("{count} kernels of {} features", features.len());
    assert!(count > 10 * features.len() / 2);
}
