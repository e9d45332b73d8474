//! Image files and metrics: round trips, damaged files, and FLIP compared with NVIDIA's implementation.

use pathmarch_testing::{plain, tests};
use std::fs;
use std::path::{Path, PathBuf};

use pathmarch_render::image::{
    Channel, ChannelValues, Display, ImageError, ImageFormat, Loaded, Picture, PictureKind, Provenance, load, save,
    save_with,
};
use pathmarch_render::metrics::{self, flip};
use pathmarch_render::tonemap::{Tonemap, srgb_decode};

fn provenance() -> Provenance {
    Provenance {
        scene_hash: "c0ffee".to_owned(),
        samples: 256,
        first_sample: 64,
        seed: u32::MAX,
        bounces: 4,
        mode: "preview".to_owned(),
        adapter: "llvmpipe (LLVM 15, 256 bits)".to_owned(),
        backend: "vulkan".to_owned(),
        version: "0.1.0".to_owned(),
        denoiser: Some("regression".to_owned()),
    }
}

/// Radiance over many orders of magnitude; all pixels differ.
fn radiance(width: u32, height: u32) -> Picture {
    Picture::from_fn(width, height, |x, y| {
        let value = ((x as f32 * 0.37 + y as f32 * 0.11).sin() * 12.0).exp2();
        [value, value / 3.0, x as f32 + y as f32 / 7.0]
    })
}

fn srgb() -> Display {
    Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 }
}

fn saved(directory: &Path, name: &str, picture: &Picture) -> PathBuf {
    let path = directory.join(name);
    save(&path, picture, &srgb(), &provenance()).expect("writable");
    path
}

fn names_in(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).expect("readable");
    entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect()
}

fn exr_keeps_every_bit_and_the_provenance() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    for (width, height) in [(1, 1), (67, 41), (300, 16)] {
        let mut picture = radiance(width, height);
        picture.pixels[0] = [-0.0, f32::INFINITY, 1e-40];
        let path = saved(directory.path(), "out.exr", &picture);
        let loaded = load(&path).expect("just written");
        assert_eq!(loaded.kind, PictureKind::Hdr);
        assert_eq!(loaded.provenance, Some(provenance()));
        assert_eq!((loaded.picture.width, loaded.picture.height), (width, height));
        for (found, expected) in loaded.picture.pixels.iter().zip(&picture.pixels) {
            assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits));
        }
    }
    assert_eq!(names_in(directory.path()), ["out.exr"], "temporary files are left");
    let flat = saved(directory.path(), "flat.exr", &Picture::new(256, 256));
    assert!(fs::metadata(flat).expect("written").len() < 20_000, "not compressed");
}

fn exr_of_other_programs_is_read_in_every_number_type_and_layout() {
    use exr::prelude::*;
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("out.exr");
    // Values that half floats represent exactly.
    let pixel = |at: Vec2<usize>| [at.x() as f32, at.y() as f32 / 4.0, -0.5].map(f16::from_f32);
    for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::PIZ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let channels = SpecificChannels::rgba(|at| {
                let [r, g, b] = pixel(at);
                (r, g, b, f16::from_f32(0.25))
            });
            let layer = Layer::new((41, 37), LayerAttributes::default(), encoding, channels);
            Image::from_layer(layer).write().to_file(&path).expect("writable");
            let loaded = load(&path).expect("a valid file");
            assert_eq!((loaded.kind, loaded.provenance), (PictureKind::Hdr, None));
            let expected = Picture::from_fn(41, 37, |x, y| [x as f32, y as f32 / 4.0, -0.5]);
            assert_eq!(loaded.picture, expected, "{compression:?} {blocks:?}");
        }
    }
    let depth = SpecificChannels::build().with_channel("Z").with_pixel_fn(|_| (1.0f32,));
    Image::from_channels((8, 8), depth).write().to_file(&path).expect("writable");
    let error = load(&path).expect_err("no colour");
    assert!(error.to_string().contains("no channels named R, G and B"), "{error}");
}

fn exr_stores_further_channels_unchanged() {
    use exr::prelude::*;
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("out.exr");
    let picture = radiance(67, 41);
    let depths: Vec<f32> = (0..67 * 41).map(|k| if k % 5 == 0 { f32::INFINITY } else { k as f32 / 3.0 }).collect();
    let ids: Vec<u32> = (0..67 * 41).map(|k| u32::MAX - k).collect();
    let channel = |name: &str, values| Channel { name: name.to_owned(), values };
    let channels = vec![
        channel("objectId.X", ChannelValues::U32(ids.clone())),
        channel("depth.Z", ChannelValues::F32(depths.clone())),
    ];
    save_with(&path, &picture, channels.clone(), &srgb(), &provenance()).expect("writable");

    let loaded = load(&path).expect("just written");
    assert_eq!((loaded.picture, loaded.provenance), (picture.clone(), Some(provenance())));
    let image = read_all_flat_layers_from_file(&path).expect("just written");
    assert_eq!(image.layer_data.len(), 1, "one part");
    let found = &image.layer_data[0].channel_data.list;
    let names: Vec<String> = found.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "depth.Z", "objectId.X"], "in the order that the format asks for");
    assert_eq!(found[3].sample_data, FlatSamples::F32(depths));
    assert_eq!(found[4].sample_data, FlatSamples::U32(ids));

    let before = fs::read(&path).expect("just written");
    let twice = vec![channels[0].clone(), channels[0].clone()];
    for wrong in [vec![channel("depth.Z", ChannelValues::F32(vec![0.0; 3]))], twice] {
        let error = save_with(&path, &picture, wrong, &srgb(), &provenance());
        assert!(matches!(error, Err(ImageError::Encode { .. })), "{error:?}");
    }
    assert_eq!(fs::read(&path).expect("still there"), before);
    let error = save_with(&directory.path().join("out.png"), &picture, channels, &srgb(), &provenance());
    assert!(error.is_err_and(|error| error.to_string().contains(".exr")));
}

fn odd_text_in_the_provenance_is_stored_as_far_as_exr_can() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("out.exr");
    let mut odd = provenance();
    odd.adapter = "Grafik™ \u{0}5000".to_owned();
    odd.scene_hash = String::new();
    save(&path, &radiance(4, 4), &srgb(), &odd).expect("writable");
    odd.adapter = "Grafik? ?5000".to_owned();
    assert_eq!(load(&path).expect("just written").provenance, Some(odd));
}

fn png_and_jpeg_show_the_picture_through_tone_curve_and_exposure() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let picture = Picture::from_fn(64, 48, |x, y| [x as f32 / 63.0, y as f32 / 47.0, (x + y) as f32 / 220.0]);
    for tonemap in Tonemap::ALL {
        let display = Display { tonemap, exposure_stops: 1.0 };
        let expected = picture.pixels.iter().map(|&pixel| display.encode(pixel));
        // JPEG halves the resolution of chroma: single pixels may be off, the mean may not.
        for (name, code_tolerance, mean_tolerance) in
            [("a.png", 0.5 / 255.0, 2e-4), ("a.jpg", 0.1, 2e-3), ("a.JPEG", 0.1, 2e-3)]
        {
            let path = directory.path().join(name);
            save(&path, &picture, &display, &provenance()).expect("writable");
            let Loaded { picture: found, kind, provenance } = load(&path).expect("just written");
            assert_eq!((kind, provenance), (PictureKind::Ldr, None));
            let mut error_sum = 0.0;
            for (found, codes) in found.pixels.iter().zip(expected.clone()) {
                for channel in 0..3 {
                    let low = srgb_decode(codes[channel] - code_tolerance) - 1e-6;
                    let high = srgb_decode(codes[channel] + code_tolerance) + 1e-6;
                    assert!((low..=high).contains(&found[channel]), "{name} {tonemap:?}: {found:?}, {codes:?}");
                    error_sum += f64::from(found[channel] - srgb_decode(codes[channel]));
                }
            }
            let bias = error_sum / (3.0 * 64.0 * 48.0);
            assert!(bias.abs() < mean_tolerance, "{name} {tonemap:?}: {bias}");
        }
    }
}

fn png_declares_srgb() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let bytes = fs::read(saved(directory.path(), "a.png", &radiance(5, 4))).expect("just written");
    assert_eq!(&bytes[12..16], b"IHDR");
    // Length, name, rendering intent and the checksum, which the strict decoder in `load` verifies as well.
    assert_eq!(&bytes[33..46], b"\0\0\0\x01sRGB\0\xae\xce\x1c\xe9");
    assert!(load(&directory.path().join("a.png")).is_ok());
}

fn writing_chooses_the_format_by_extension_and_reading_by_content() {
    for (name, format) in [
        ("a.exr", ImageFormat::Exr),
        ("b/a.PNG", ImageFormat::Png),
        ("a.jpg", ImageFormat::Jpeg),
        ("x.y.Jpeg", ImageFormat::Jpeg),
    ] {
        assert_eq!(ImageFormat::from_path(Path::new(name)).expect("known"), format);
    }
    for name in ["a.tiff", "png", "a.", ".exr", ""] {
        let message = ImageFormat::from_path(Path::new(name)).expect_err(name).to_string();
        for accepted in [".exr", ".png", ".jpg", ".jpeg"] {
            assert!(message.contains(accepted), "{message}");
        }
    }
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = saved(directory.path(), "a.exr", &radiance(5, 4));
    let renamed = directory.path().join("a.png");
    fs::rename(path, &renamed).expect("renamed");
    assert_eq!(load(&renamed).expect("an EXR under another name").picture, radiance(5, 4));
}

#[cfg(unix)]
fn a_saved_file_has_the_permissions_of_any_other() {
    use std::os::unix::fs::PermissionsExt;
    let directory = tempfile::tempdir().expect("a temporary directory");
    let other = directory.path().join("other");
    fs::write(&other, "x").expect("writable");
    let mode = |path: &Path| fs::metadata(path).expect("written").permissions().mode();
    for name in ["a.exr", "a.png", "a.jpg"] {
        assert_eq!(mode(&saved(directory.path(), name, &radiance(4, 4))), mode(&other), "{name}");
    }
}

fn a_save_that_fails_leaves_the_old_file_and_nothing_else() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = saved(directory.path(), "a.exr", &radiance(4, 4));
    let before = fs::read(&path).expect("just written");
    let mut torn = radiance(4, 4);
    torn.pixels.pop();
    assert!(matches!(save(&path, &torn, &srgb(), &provenance()), Err(ImageError::Encode { .. })));
    assert!(matches!(save(&path, &Picture::new(0, 4), &srgb(), &provenance()), Err(ImageError::BadSize { .. })));
    assert!(matches!(save(&path, &Picture::new(1, 20_000), &srgb(), &provenance()), Err(ImageError::BadSize { .. })));
    assert_eq!(fs::read(&path).expect("still there"), before);
    assert_eq!(names_in(directory.path()), ["a.exr"]);

    let missing = directory.path().join("no/such/a.png");
    let error = save(&missing, &radiance(4, 4), &srgb(), &provenance()).expect_err("no directory");
    assert!(matches!(error, ImageError::MissingDirectory { .. }));
    let message = error.to_string();
    assert!(
        message.contains("no/such/a.png") && message.contains("does not exist") && message.contains("create"),
        "{message}"
    );

    fs::create_dir(directory.path().join("taken.png")).expect("created");
    let error = save(&directory.path().join("taken.png"), &radiance(4, 4), &srgb(), &provenance());
    assert!(matches!(error, Err(ImageError::Write { .. })));
    assert_eq!(names_in(directory.path()).len(), 2);
}

#[cfg(target_os = "linux")]
fn a_read_only_directory_is_reported() {
    // /proc takes no new files, not even from root.
    let error = save(Path::new("/proc/a.exr"), &radiance(4, 4), &srgb(), &provenance()).expect_err("not writable");
    assert!(error.to_string().starts_with("/proc/a.exr: cannot be written: "), "{error}");
}

fn files_other_than_images_are_refused_by_name() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("note.exr");
    assert!(matches!(load(&path), Err(ImageError::Read { .. })));
    assert!(load(directory.path()).is_err());
    for content in [&b""[..], b"v", b"not a picture, but long enough to be one", b"\x89PN"] {
        fs::write(&path, content).expect("writable");
        let error = load(&path).expect_err("no image");
        assert!(matches!(error, ImageError::NotAnImage { .. }), "{error}");
        assert!(error.to_string().contains("note.exr"), "{error}");
    }
}

fn truncated_files_are_errors() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    for name in ["a.exr", "a.png", "a.jpg"] {
        let path = saved(directory.path(), name, &radiance(40, 40));
        let bytes = fs::read(&path).expect("just written");
        for keep in [9, bytes.len() / 4, bytes.len() / 2, bytes.len() - bytes.len() / 8] {
            fs::write(&path, &bytes[..keep]).expect("writable");
            let error = load(&path).map(|_| ()).expect_err(name);
            assert!(matches!(error, ImageError::Decode { .. }), "{name} {keep}: {error}");
        }
    }
}

fn absurd_sizes_are_refused_before_anything_is_allocated() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = saved(directory.path(), "a.exr", &radiance(8, 8));
    let mut bytes = fs::read(&path).expect("just written");
    // Value of dataWindow: four little-endian integers after its name, type and length.
    let name = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = bytes.windows(name.len()).position(|window| window == name).expect("every EXR has one") + name.len();
    bytes[at + 8..at + 12].copy_from_slice(&100_000i32.to_le_bytes());
    fs::write(&path, &bytes).expect("writable");
    let error = load(&path).expect_err("absurd");
    assert!(matches!(error, ImageError::BadSize { width: 100_001, .. }), "{error}");
    assert!(error.to_string().contains("16384"), "{error}");

    let path = saved(directory.path(), "a.png", &radiance(8, 8));
    let mut bytes = fs::read(&path).expect("just written");
    bytes[16..20].copy_from_slice(&1_000_000u32.to_be_bytes());
    fs::write(&path, &bytes).expect("writable");
    assert!(load(&path).is_err());
}

fn damaged_files_are_errors_or_pictures_never_a_panic() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let mut state = 0x1234_5678_9abc_def0u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below
    };
    for name in ["a.exr", "a.png", "a.jpg"] {
        let path = saved(directory.path(), name, &radiance(20, 20));
        let whole = fs::read(&path).expect("just written");
        let mut refused = 0;
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random(4) {
                // Half of the damage is in the header.
                let range = if random(2) == 0 { bytes.len().min(600) } else { bytes.len() };
                let at = random(range);
                bytes[at] = [0, 1, 0x7f, 0x80, 0xff, random(256) as u8][random(6)];
            }
            fs::write(&path, &bytes).expect("writable");
            match load(&path) {
                Ok(loaded) => assert!(loaded.picture.pixels.len() <= 1 << 28),
                Err(_) => refused += 1,
            }
        }
        println!("{name}: {refused} of 1500 damaged files refused");
        assert!(refused > 100);
    }
}

// ---- FLIP ------------------------------------------------------------------------------------------------------------

const WIDTH: u32 = 96;
const HEIGHT: u32 = 64;

fn picture(pixel: impl Fn(f64, f64) -> [f64; 3]) -> Picture {
    Picture::from_fn(WIDTH, HEIGHT, |x, y| pixel(f64::from(x), f64::from(y)).map(|channel| channel as f32))
}

fn constant(colour: [f64; 3]) -> Picture {
    picture(|_, _| colour)
}

fn gradient() -> Picture {
    picture(|x, y| [x / 95.0, y / 63.0, (x + y) / 158.0])
}

fn soft_gradient() -> Picture {
    picture(|x, y| [(x / 95.0).powi(2), (y / 63.0).powi(2), 0.5 * (x + y) / 158.0])
}

fn checker(cell: u32, odd: [f64; 3], even: [f64; 3]) -> Picture {
    picture(|x, y| if (x as u32 / cell + y as u32 / cell) % 2 == 1 { odd } else { even })
}

fn disc(centre_x: f64, colour: [f64; 3], background: [f64; 3]) -> Picture {
    picture(|x, y| {
        let cover = (12.5 - (x - centre_x).hypot(y - 32.0)).clamp(0.0, 1.0);
        [0, 1, 2].map(|channel| background[channel] + (colour[channel] - background[channel]) * cover)
    })
}

fn ramp(gain: f64) -> Picture {
    picture(|x, y| {
        let value = gain * (x / 95.0 * 12.0 - 6.0).exp2();
        [value * (0.5 + 0.5 * y / 63.0), value * 0.8, value * (1.0 - 0.5 * y / 63.0)]
    })
}

/// The expected means are those of NVIDIA's `flip-evaluator` 1.7 (PyPI) for the same formulas, at its default viewing
/// distance, given linear RGB: `evaluate(reference, test, "LDR" or "HDR", inputsRGB=False, applyMagma=False)`.
fn flip_agrees_with_the_implementation_of_its_authors() {
    use PictureKind::{Hdr, Ldr};
    const NIGHT: [f64; 3] = [0.05, 0.1, 0.2];
    let orange = [1.0, 0.8, 0.2];
    let fire = [40.0, 30.0, 8.0];
    let cases = [
        ("gradient", Ldr, soft_gradient(), gradient(), 0.599021),
        (
            "checker",
            Ldr,
            checker(8, [0.2, 0.6, 0.9], [0.8, 0.3, 0.1]),
            checker(8, [0.25, 0.55, 0.9], [0.8, 0.3, 0.2]),
            0.261079,
        ),
        ("shifted disc", Ldr, disc(50.0, orange, NIGHT), disc(47.0, orange, NIGHT), 0.080247),
        ("black and white", Ldr, constant([0.0; 3]), constant([1.0; 3]), 0.967325),
        ("fine checker and its mean", Ldr, checker(1, [1.0; 3], [0.0; 3]), constant([0.5; 3]), 0.003398),
        ("green and blue", Ldr, constant([0.0, 1.0, 0.0]), constant([0.0, 0.0, 1.0]), 1.0),
        ("ramp", Hdr, ramp(1.1), ramp(1.0), 0.129984),
        ("shifted disc", Hdr, disc(50.0, fire, NIGHT), disc(47.0, fire, NIGHT), 0.081272),
        ("gradient", Hdr, soft_gradient(), gradient(), 0.641110),
        ("disc on black", Hdr, disc(50.0, [4.0, 3.0, 1.0], [0.0; 3]), disc(47.0, [4.0, 3.0, 1.0], [0.0; 3]), 0.080632),
    ];
    for (name, kind, image, reference, expected) in cases {
        let found = flip::flip(&image, &reference, kind).expect("equal sizes").mean();
        println!("FLIP {kind:?} {name}: {found:.6}, NVIDIA {expected:.6}, difference {:.1e}", found - expected);
        assert!((found - expected).abs() < 1e-3, "{kind:?} {name}: {found}, expected {expected}");
    }
}

fn flip_is_zero_for_equal_pictures_and_finds_differences() {
    let mut image = gradient();
    for kind in [PictureKind::Ldr, PictureKind::Hdr] {
        let map = flip::flip(&image, &image, kind).expect("equal sizes");
        assert!(map.errors.iter().all(|&error| error == 0.0));
    }
    image.pixels[(40 * WIDTH + 20) as usize] = [1.0; 3];
    let map = flip::flip(&image, &gradient(), PictureKind::Ldr).expect("equal sizes");
    let worst = map.errors.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("not empty").0 as u32;
    let (x, y) = (worst % WIDTH, worst / WIDTH);
    assert!(x.abs_diff(20) <= 3 && y.abs_diff(40) <= 3, "{x}, {y}");
    assert_eq!(map.errors[(10 * WIDTH + 80) as usize], 0.0, "far from the change");
}

fn hdr_flip_is_defined_for_black_constant_and_extreme_references() {
    let extreme = picture(|x, _| [f64::from(f32::MAX), x * 1e-38, -1.0]);
    for reference in [constant([0.0; 3]), constant([1.0; 3]), constant([-1.0; 3]), constant([1e30; 3]), extreme] {
        for image in [constant([0.0; 3]), constant([2.0; 3]), gradient()] {
            let map = flip::flip(&image, &reference, PictureKind::Hdr).expect("equal sizes");
            assert!(map.errors.iter().all(|error| (0.0..=1.0).contains(error)));
        }
    }
    let lit = flip::flip(&constant([0.2; 3]), &constant([0.0; 3]), PictureKind::Hdr).expect("equal sizes").mean();
    assert!((0.05..0.95).contains(&lit), "light where there should be none shows: {lit}");
}

fn a_comparison_contains_all_metrics() {
    let (image, reference) = (ramp(1.1), ramp(1.0));
    let found = metrics::compare(&image, &reference, PictureKind::Hdr).expect("equal sizes");
    assert_eq!(found.relmse, metrics::relmse(&image, &reference).expect("equal sizes"));
    assert_eq!(found.mse, metrics::mse(&image, &reference).expect("equal sizes"));
    assert_eq!(
        (found.image_mean, found.reference_mean),
        (metrics::mean_colour(&image), metrics::mean_colour(&reference))
    );
    assert!((found.flip - 0.129984).abs() < 1e-3);
    assert_eq!((found.width, found.height, found.image_non_finite, found.reference_non_finite), (WIDTH, HEIGHT, 0, 0));
    assert!((found.image_mean[1] / found.reference_mean[1] - 1.1).abs() < 1e-5);
}

tests! {
    plain: [
        exr_keeps_every_bit_and_the_provenance,
        exr_of_other_programs_is_read_in_every_number_type_and_layout,
        exr_stores_further_channels_unchanged,
        odd_text_in_the_provenance_is_stored_as_far_as_exr_can,
        png_and_jpeg_show_the_picture_through_tone_curve_and_exposure,
        png_declares_srgb,
        writing_chooses_the_format_by_extension_and_reading_by_content,
        a_saved_file_has_the_permissions_of_any_other,
        a_save_that_fails_leaves_the_old_file_and_nothing_else,
        a_read_only_directory_is_reported,
        files_other_than_images_are_refused_by_name,
        truncated_files_are_errors,
        absurd_sizes_are_refused_before_anything_is_allocated,
        damaged_files_are_errors_or_pictures_never_a_panic,
        flip_agrees_with_the_implementation_of_its_authors,
        flip_is_zero_for_equal_pictures_and_finds_differences,
        hdr_flip_is_defined_for_black_constant_and_extreme_references,
        a_comparison_contains_all_metrics,
    ],
}
