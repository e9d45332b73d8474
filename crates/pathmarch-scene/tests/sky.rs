//! Skies: pictures as files hold them, what is wrong with them, and the light of a computed day.

use image::{Rgb, Rgb32FImage};
use miette::{GraphicalReportHandler, GraphicalTheme};
use pathmarch_scene::{Day, Environment, Light, Scene, Sky};
use std::path::{Path, PathBuf};

/// A folder of this name for files, empty at first.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pathmarch-sky").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("the folder for temporary files is writable");
    folder
}

fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("the folder is writable");
}

fn encoded(picture: &Rgb32FImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("a small picture can be encoded");
    bytes.into_inner()
}

fn hdr(picture: &Rgb32FImage) -> Vec<u8> {
    encoded(picture, image::ImageFormat::Hdr)
}

fn exr(picture: &Rgb32FImage) -> Vec<u8> {
    encoded(picture, image::ImageFormat::OpenExr)
}

/// Every texel another colour that RGBE holds exactly.
fn coloured(width: u32, height: u32) -> Rgb32FImage {
    Rgb32FImage::from_fn(width, height, |x, y| Rgb([0.5 + x as f32 / 128.0, 0.5 + y as f32 / 128.0, 0.75]))
}

/// The scene in `folder` with this sky.
fn scene(folder: &Path, sky: &str) -> Result<Scene, pathmarch_scene::SceneError> {
    let name = folder.join("scene.kdl").display().to_string();
    Scene::parse(
        &name,
        &format!("pathmarch 1\ncamera {{ position 0 1 5; target 0 1 0 }}\n{sky}\nobject \"a\" {{ sphere }}"),
    )
}

fn environment(folder: &Path, sky: &str) -> std::sync::Arc<Environment> {
    match scene(folder, sky).map(|scene| scene.sky) {
        Ok(Sky::Map(environment)) => environment,
        other => panic!("{other:?}"),
    }
}

/// The report without colours, 100 columns wide, and without the name of the folder.
fn rendered(diagnostic: &dyn miette::Diagnostic, folder: &Path) -> String {
    let mut out = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(100);
    handler.render_report(&mut out, diagnostic).expect("a string takes all text");
    let out = out.replace(&format!("{}/", folder.display()), "");
    out.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

#[test]
fn pictures() {
    let folder = folder("pictures");
    let picture = coloured(16, 8);
    write(&folder.join("a.hdr"), &hdr(&picture));
    write(&folder.join("b.exr"), &exr(&picture));
    let expected: Vec<[f32; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
    for name in ["a.hdr", "b.exr"] {
        let sky = environment(&folder, &format!("sky \"{name}\""));
        assert_eq!((sky.width, sky.height, sky.rotate), (16, 8, 0.0));
        assert_eq!(sky.texels, expected, "{name}");
        let sky = environment(&folder, &format!("sky \"{name}\" strength=4 rotate=-90"));
        assert_eq!((sky.texels[3], sky.rotate), (expected[3].map(|v| 4.0 * v), -90.0));
    }
    assert!(scene(&folder, "sky \"a.hdr\"").expect("nothing is wrong").warnings.is_empty());
    let dim = environment(&folder, "sky \"a.hdr\" strength=1e38");
    assert!(dim.texels.as_flattened().iter().all(|&v| v == 1e12));
}

/// Radiance is in the file times EXPOSURE, and is had without it.
#[test]
fn exposure_of_radiance_files() {
    let folder = folder("exposure");
    let head = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n\n-Y 1 +X 2\n";
    write(&folder.join("a.hdr"), &[&head[..], &[128, 128, 128, 131, 128, 64, 0, 131]].concat());
    assert_eq!(environment(&folder, "sky \"a.hdr\"").texels, [[1.0; 3], [1.0, 0.5, 0.0]]);
}

/// The module's text on directions, in numbers.
#[test]
fn directions() {
    let texels = |bright: usize| (0..32).map(|index| [f32::from(index == bright); 3]).collect();
    // The first and the last column of the second of four rows: around -z, above the horizon.
    for (column, across) in [(0, 1.0_f32), (7, -1.0)] {
        let sky = Environment { width: 8, height: 4, texels: texels(8 + column), rotate: 0.0 };
        let (azimuth, elevation) = (across * 22.5_f32.to_radians(), 22.5_f32.to_radians());
        let direction =
            |azimuth: f32| [azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos()];
        assert!((sky.radiance(direction(azimuth))[0] - 1.0).abs() < 1e-5, "column {column}");
        assert!((sky.radiance(direction(0.0))[0] - 0.5).abs() < 1e-5, "across the edge of the picture");
        // Turned by 90 degrees about +y, right-handed, -z becomes -x.
        let turned = Environment { rotate: 90.0, ..sky };
        let azimuth = azimuth - 90.0_f32.to_radians();
        assert!((turned.radiance(direction(azimuth))[0] - 1.0).abs() < 1e-5, "column {column}, turned");
    }
    let up = Environment { width: 8, height: 4, texels: texels(0), rotate: 0.0 };
    assert!(up.radiance([0.0, 1.0, 0.0])[0] <= 1.0 && up.radiance([0.0, -1.0, 0.0])[0] == 0.0);
    // +z is the middle, +x a quarter from the left.
    let ramp = Environment { width: 360, height: 1, texels: (0..360).map(|i| [i as f32; 3]).collect(), rotate: 0.0 };
    assert!((ramp.radiance([1.0, 0.0, 0.0])[0] - 89.5).abs() < 1e-2);
    assert!((ramp.radiance([0.0, 0.0, 1.0])[0] - 179.5).abs() < 1e-2);
    assert!((ramp.radiance([-1.0, 0.0, 0.0])[0] - 269.5).abs() < 1e-2);
}

#[test]
fn large_pictures_are_averaged() {
    let folder = folder("large");
    let mut picture = Rgb32FImage::from_pixel(5000, 2500, Rgb([1.0; 3]));
    for (x, y) in [(2, 4), (3, 4), (2, 5), (3, 5), (4999, 2499)] {
        picture.put_pixel(x, y, Rgb([3.0, 1.0, 0.0]));
    }
    write(&folder.join("a.exr"), &exr(&picture));
    let sky = environment(&folder, "sky \"a.exr\"");
    assert_eq!((sky.width, sky.height), (2500, 1250));
    assert_eq!(sky.texels[2 * 2500 + 1], [3.0, 1.0, 0.0]);
    assert_eq!(sky.texels[2500 * 1250 - 1], [1.5, 1.0, 0.75]);
    assert_eq!(sky.texels[0], [1.0; 3]);
}

#[test]
fn odd_texels_are_repaired() {
    let folder = folder("odd");
    let mut picture = coloured(4, 2);
    picture.put_pixel(0, 0, Rgb([f32::NAN, 1.0, -1.0]));
    picture.put_pixel(1, 0, Rgb([f32::INFINITY, 7.0, f32::NEG_INFINITY]));
    write(&folder.join("a.exr"), &exr(&picture));
    let scene = scene(&folder, "sky \"a.exr\"").expect("only a warning");
    let Sky::Map(sky) = &scene.sky else { panic!("no picture") };
    assert_eq!(sky.texels[..2], [[0.0, 1.0, 0.0], [7.0, 7.0, 0.0]]);
    assert_eq!(scene.warnings.len(), 1);
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("sky_bad_texels", rendered(&scene.warnings[0], &folder));
    });
}

#[test]
fn stretched() {
    let folder = folder("stretched");
    write(&folder.join("a.hdr"), &hdr(&coloured(16, 9)));
    let scene = scene(&folder, "sky \"a.hdr\"").expect("only a warning");
    assert_eq!(scene.warnings.len(), 1);
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("sky_stretched", rendered(&scene.warnings[0], &folder));
    });
}

#[test]
fn black_pictures_light_nothing() {
    let folder = folder("black");
    write(&folder.join("a.hdr"), &hdr(&Rgb32FImage::new(4, 2)));
    let scene = scene(&folder, "sky \"a.hdr\"").expect("only a warning");
    assert_eq!(scene.warnings.iter().map(|warning| warning.code).collect::<Vec<_>>(), ["pathmarch::no_light"]);
}

/// Every way in which a file is no sky, as people see it.
#[test]
fn picture_mistakes() {
    let folder = folder("mistakes");
    let nan = exr(&Rgb32FImage::from_pixel(4, 2, Rgb([f32::NAN; 3])));
    let (hdr, exr) = (hdr(&coloured(16, 8)), exr(&coloured(16, 8)));
    std::fs::create_dir(folder.join("folder.hdr")).expect("the folder is writable");
    write(&folder.join("empty.hdr"), b"");
    write(&folder.join("screen.png"), b"\x89PNG\r\n\x1a\n");
    write(&folder.join("renamed.hdr"), b"\xff\xd8\xff\xe0 a JPEG");
    write(&folder.join("short.hdr"), &hdr[..hdr.len() / 2]);
    write(&folder.join("short.exr"), &exr[..exr.len() / 2]);
    write(&folder.join("head.exr"), &exr[..6]);
    write(&folder.join("wide.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 32769\n");
    write(&folder.join("large.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32768 +X 32768\n");
    write(&folder.join("xyz.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n");
    write(&folder.join("nothing.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n");
    write(&folder.join("nan.exr"), &nan);
    let mut out = String::new();
    for name in [
        "missing.hdr",
        "missing.png",
        "folder.hdr",
        "empty.hdr",
        "screen.png",
        "renamed.hdr",
        "short.hdr",
        "short.exr",
        "head.exr",
        "wide.hdr",
        "large.hdr",
        "xyz.hdr",
        "nothing.hdr",
        "nan.exr",
    ] {
        let Err(error) = scene(&folder, &format!("sky \"{name}\"")) else { panic!("{name} is no sky") };
        assert_eq!(error.mistakes().len(), 1, "{name}");
        out += &rendered(&error.mistakes()[0], &folder);
        out += "\n";
    }
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("sky_pictures", out);
    });
}

/// Whatever bytes are in a file: a picture or a mistake, no panic, no long wait.
#[test]
fn any_bytes() {
    let folder = folder("any");
    let small = coloured(16, 8);
    let mut state = 1_u32;
    let mut random = |below: usize| {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as usize % below
    };
    for (name, bytes) in [("a.hdr", hdr(&small)), ("a.exr", exr(&small))] {
        let start = std::time::Instant::now();
        let mut right = 0;
        for _ in 0..2000 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + random(4) {
                let at = random(bytes.len());
                match random(3) {
                    0 => bytes[at] = random(256) as u8,
                    1 => bytes[at] ^= 1 << random(8),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            write(&folder.join(name), &bytes);
            right += u32::from(scene(&folder, &format!("sky \"{name}\"")).is_ok());
        }
        println!("{name}: {right} of 2000 damaged files could be read, {:.2?}", start.elapsed());
    }
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn irradiance(sun: Option<Light>) -> [f32; 3] {
    match sun {
        Some(Light::Sun { irradiance, .. }) => irradiance,
        _ => [0.0; 3],
    }
}

/// Irradiance of level ground from the upper half of the sky.
fn from_sky(sky: &Environment) -> f32 {
    let texel = |index: usize| {
        let row = index as u32 / sky.width;
        let elevation = |row: u32| std::f32::consts::PI * (0.5 - row as f32 / sky.height as f32);
        let (upper, lower) = (elevation(row).sin(), elevation(row + 1).sin());
        luminance(sky.texels[index]) * std::f32::consts::PI * (upper * upper - lower * lower) / sky.width as f32
    };
    (0..sky.texels.len() / 2).map(texel).sum()
}

#[test]
fn day_is_bright() {
    let (sky, sun) = Day { elevation: 60.0, ..Day::default() }.bake();
    let (sun, sky) = (luminance(irradiance(sun)), from_sky(&sky));
    println!("sun {sun} W/m2 facing it, sky {sky} W/m2");
    assert!((3.5..4.5).contains(&sun), "of 5 above the air");
    assert!((0.1..0.25).contains(&(sky / (sun * 0.75_f32.sqrt()))), "of that of the sun on level ground");
}

#[test]
fn day_has_the_colours_of_a_sky() {
    for elevation in [60.0, 20.0, 5.0, 0.0, -5.0] {
        let (sky, _) = Day { elevation, azimuth: 90.0, ..Day::default() }.bake();
        let zenith = sky.radiance([0.0, 1.0, 0.0]);
        assert!(zenith[2] > 1.2 * zenith[0], "blue above, sun at {elevation}: {zenith:?}");
        if elevation <= 5.0 {
            let below = sky.radiance([0.9998, 0.02, 0.0]);
            assert!(below[0] > 2.0 * below[2], "red near the sun, sun at {elevation}: {below:?}");
        }
    }
    let noon = irradiance(Day { elevation: 60.0, ..Day::default() }.bake().1);
    let evening = irradiance(Day { elevation: 3.0, ..Day::default() }.bake().1);
    assert!(evening[0] / evening[2] > 3.0 * noon[0] / noon[2]);
}

/// Finite, not negative, and the same on both sides of the sun, which is where it should be.
#[test]
fn day_is_whole_and_symmetric() {
    for (elevation, haze) in
        [(90.0, 1.0), (60.0, 0.0), (20.0, 20.0), (0.2, 1.0), (0.0, 5.0), (-0.2, 1.0), (-12.0, 1.0), (-20.0, 20.0)]
    {
        let day = Day { elevation, haze, azimuth: 30.0, ground: [0.0, 0.5, 1.0], ..Day::default() };
        let (sky, sun) = day.bake();
        assert!(sky.texels.as_flattened().iter().all(|v| v.is_finite() && *v >= 0.0));
        let row = |row: u32| &sky.texels[(row * sky.width) as usize..((row + 1) * sky.width) as usize];
        for index in 0..sky.height {
            assert!(row(index).iter().eq(row(index).iter().rev()), "row {index}, sun at {elevation}");
        }
        assert_eq!(sun.is_some(), elevation > -0.26, "sun at {elevation}");
        let across = |turn: f32| {
            let azimuth = (30.0 + turn).to_radians();
            luminance(sky.radiance([azimuth.sin() * 0.8, 0.6, -azimuth.cos() * 0.8]))
        };
        assert!((across(40.0) - across(-40.0)).abs() <= 1e-3 * across(40.0));
        assert!(elevation != 20.0 || across(0.0) > across(180.0), "brighter towards the sun");
    }
}

#[test]
fn day_in_a_scene() {
    let folder = folder("day");
    let full = scene(&folder, "sky \"day\" elevation=30 azimuth=90 haze=2 strength=2 { ground 0 }").expect("right");
    let Light::Sun { direction, irradiance, angle, .. } = full.lights[0] else { panic!("no sun") };
    let half = 0.5_f32;
    assert!((direction[0] - 0.75_f32.sqrt()).abs() < 1e-6 && (direction[1] - half).abs() < 1e-6);
    assert!(direction[2].abs() < 1e-6 && angle == 0.53);
    let day = Day { elevation: 30.0, azimuth: 90.0, haze: 2.0, strength: 1.0, ground: [0.0; 3] };
    let (single, sun) = day.bake();
    let Some(Light::Sun { irradiance: once, .. }) = sun else { panic!("no sun") };
    assert!((irradiance[1] - 2.0 * once[1]).abs() < 1e-5 * once[1]);
    let Sky::Map(sky) = &full.sky else { panic!("no picture") };
    assert!((sky.texels[0][2] - 2.0 * single.texels[0][2]).abs() < 1e-5);
    assert_eq!(sky.radiance([0.0, -1.0, 0.0]), [0.0; 3]);
    // Brightest below and above the sun, not opposite.
    assert!(sky.radiance([0.8, 0.6, 0.0])[0] > sky.radiance([-0.8, 0.6, 0.0])[0]);
    let alone = scene(&folder, "sky \"day\" elevation=30 sun=#false").expect("right");
    assert!(alone.lights.is_empty() && alone.warnings.is_empty());
}

#[test]
fn gradients() {
    let folder = folder("gradient");
    let sky = |text: &str| scene(&folder, text).expect("right").sky;
    let (zenith, horizon) = ([0.25, 0.5, 1.0], [1.0, 0.5, 0.25]);
    let two = sky("sky \"gradient\" { zenith 0.25 0.5 1; horizon 1 0.5 0.25 }");
    assert_eq!(two, Sky::Gradient { zenith, horizon, ground: horizon });
    let three = sky("sky \"gradient\" { ground 0.5; zenith 0.25 0.5 1; horizon 1 0.5 0.25 }");
    assert_eq!(three, Sky::Gradient { zenith, horizon, ground: [0.5; 3] });
}
