use super::*;
use egui::epaint::{Mesh, TextureId};
use egui::{Color32, ColorImage, Context, RawInput, Rect, TextureOptions, Vec2, pos2, vec2};
use egui_kittest::TestRenderer;
use egui_kittest::wgpu::WgpuTestRenderer;
use proptest::prelude::*;

const SIZE: [usize; 2] = [400, 300];

fn ui(ui: &mut egui::Ui, picture: &egui::TextureHandle) {
    ui.heading("A heading");
    ui.horizontal(|ui| {
        let _ = ui.button("Press");
        ui.add(egui::Slider::new(&mut 0.3, 0.0..=1.0).text("slid"));
        ui.checkbox(&mut true, "checked");
    });
    ui.colored_label(Color32::from_rgba_unmultiplied(250, 90, 40, 130), "Half of a colour");
    egui::Frame::popup(ui.style()).corner_radius(9.0).show(ui, |ui| ui.label("A shadow lies under this."));
    let origin = ui.cursor().min;
    let painter = ui.painter();
    // Images larger, equal and smaller than their textures, rotated, tinted and cropped.
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    for (at, size, tint) in [
        (vec2(0.3, 5.6), vec2(150.0, 90.0), Color32::WHITE),
        (vec2(160.0, 5.0), vec2(48.0, 32.0), Color32::WHITE),
        (vec2(215.0, 5.0), vec2(30.0, 20.0), Color32::from_rgba_premultiplied(90, 120, 60, 120)),
    ] {
        painter.image(picture.id(), Rect::from_min_size(origin + at, size), whole, tint);
    }
    let mut turned = Mesh::with_texture(picture.id());
    turned.add_rect_with_uv(Rect::from_min_size(origin + vec2(270.0, 20.0), vec2(70.0, 50.0)), whole, Color32::WHITE);
    turned.rotate(egui::emath::Rot2::from_angle(0.5), origin + vec2(300.0, 45.0));
    painter.add(turned);
    let mut shaded = Mesh::default();
    for (x, y, colour) in
        [(160.0, 50.0, Color32::RED), (250.0, 60.0, Color32::GREEN), (180.0, 120.0, Color32::TRANSPARENT)]
    {
        shaded.colored_vertex(origin + vec2(x, y), colour);
    }
    shaded.add_triangle(0, 1, 2);
    painter.add(shaded);
    painter.circle(origin + vec2(300.0, 110.0), 20.0, Color32::from_rgb_additive(60, 60, 160), (3.0, Color32::YELLOW));
}

/// The same frame drawn here and by a GPU: text, feathered edges, shadows, images of all sizes.
#[test]
#[ignore = "draws with a GPU adapter: run it with --include-ignored"]
fn a_frame_is_what_a_gpu_draws() {
    for pixels_per_point in [1.0, 1.5] {
        let ctx = Context::default();
        let mut image = ColorImage::filled([48, 32], Color32::BLACK);
        for (at, pixel) in image.pixels.iter_mut().enumerate() {
            let (x, y) = (at % 48, at / 48);
            *pixel = Color32::from_rgb((x * 5) as u8, (y * 8) as u8, if (x / 6 + y / 6) % 2 == 0 { 200 } else { 30 });
        }
        let picture = ctx.load_texture("picture", image, TextureOptions::LINEAR);
        let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32) / pixels_per_point;
        let mut input = RawInput { screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), size)), ..Default::default() };
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(pixels_per_point);
        let mut gpu = WgpuTestRenderer::new();
        let mut textures = Textures::default();
        let mut output = None;
        for _ in 0..3 {
            let mut frame = ctx.run_ui(input.clone(), |root| {
                egui::CentralPanel::default().show(root, |panel| ui(panel, &picture));
            });
            let mut copy = frame.textures_delta.clone();
            gpu.handle_delta(&mut frame.textures_delta);
            textures.apply_all(&mut copy);
            output = Some(frame);
        }
        let output = output.expect("a frame");
        let theirs = gpu.render(&ctx, &output).expect("a GPU to compare with");
        assert_eq!([theirs.width() as usize, theirs.height() as usize], SIZE);
        let mut pixels = vec![0; SIZE[0] * SIZE[1]];
        let primitives = ctx.tessellate(output.shapes, output.pixels_per_point);
        Canvas { pixels: &mut pixels, width: SIZE[0] }.paint(&primitives, pixels_per_point, &textures);
        let mut differences: Vec<u8> = (pixels.iter().zip(theirs.pixels()))
            .map(|(ours, theirs)| {
                let [_, ours @ ..] = ours.to_be_bytes();
                (0..3).map(|k| ours[k].abs_diff(theirs.0[k])).max().unwrap_or(0)
            })
            .collect();
        if let Some(path) = std::env::var_os("PATHMARCH_SHOW") {
            let bytes: Vec<u8> =
                pixels.iter().flat_map(|pixel| [(pixel >> 16) as u8, (pixel >> 8) as u8, *pixel as u8]).collect();
            let path = std::path::PathBuf::from(path);
            image::save_buffer(path.join("ours.png"), &bytes, SIZE[0] as u32, SIZE[1] as u32, image::ColorType::Rgb8)
                .expect("saved");
            theirs.save(path.join("theirs.png")).expect("saved");
        }
        differences.sort_unstable();
        let count = differences.len();
        let (most, worst) = (differences[count - count / 1000 - 1], differences[count - 1]);
        assert!(most <= 3 && worst <= 40, "at {pixels_per_point}: {most} {worst}");
        assert!(pixels.iter().collect::<std::collections::HashSet<_>>().len() > 1000, "there is something to see");
    }
}

fn white() -> Textures {
    let mut textures = Textures::default();
    let image = ColorImage::filled([1, 1], Color32::WHITE);
    textures.apply(TextureId::default(), &ImageDelta::full(image, TextureOptions::LINEAR));
    textures
}

fn painted(mesh: Mesh, size: [usize; 2]) -> Vec<u32> {
    let mut pixels = vec![0x20_30_40; size[0] * size[1]];
    let clip_rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(size[0] as f32, size[1] as f32));
    let primitive = ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) };
    Canvas { pixels: &mut pixels, width: size[0] }.paint(&[primitive], 1.0, &white());
    pixels
}

proptest! {
    /// Triangles that share edges draw each pixel once, however they lie.
    #[test]
    fn no_gaps_and_nothing_twice(
        middle in (0.0f32..40.0, 0.0f32..30.0),
        rim in prop::collection::btree_set(0u32..6283, 3..12),
        flips in prop::collection::vec(any::<bool>(), 12),
    ) {
        let angles: Vec<f32> = rim.iter().map(|angle| *angle as f32 / 1000.0).collect();
        let gap = |k: usize| {
            let next = angles.get(k + 1).copied().unwrap_or(angles[0] + std::f32::consts::TAU);
            next - angles[k]
        };
        // A fan around a point inside, far larger than the canvas.
        prop_assume!((0..angles.len()).all(|k| gap(k) < 3.0));
        let mut mesh = Mesh::default();
        let colour = Color32::from_rgba_premultiplied(100, 50, 20, 128);
        mesh.colored_vertex(pos2(middle.0, middle.1), colour);
        for angle in &angles {
            mesh.colored_vertex(pos2(middle.0 + 2000.0 * angle.cos(), middle.1 + 2000.0 * angle.sin()), colour);
        }
        let count = angles.len() as u32;
        for k in 0..count {
            let (a, b) = (1 + k, 1 + (k + 1) % count);
            let (a, b) = if flips[k as usize] { (b, a) } else { (a, b) };
            mesh.add_triangle(0, a, b);
        }
        let pixels = painted(mesh, [40, 30]);
        let once = over(code(colour), 0x20_30_40);
        prop_assert!(pixels.iter().all(|pixel| *pixel == once));
    }

    /// No input panics, and no pixel outside of the clip rectangle changes.
    #[test]
    fn any_triangle_is_drawn(corners in prop::collection::vec((any::<f32>(), any::<f32>(), any::<[f32; 2]>(), any::<[u8; 4]>()), 3)) {
        let mut mesh = Mesh::default();
        for (x, y, uv, [r, g, b, a]) in corners {
            let color = Color32::from_rgba_premultiplied(r, g, b, a);
            mesh.vertices.push(Vertex { pos: pos2(x, y), uv: uv.into(), color });
        }
        mesh.add_triangle(0, 1, 2);
        let mut pixels = vec![1; 30 * 20];
        let clip_rect = Rect::from_min_max(pos2(5.0, 5.0), pos2(20.0, 10.0));
        let primitive = ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) };
        Canvas { pixels: &mut pixels, width: 30 }.paint(&[primitive], 1.0, &white());
        let outside = |at: usize| !(5..20).contains(&(at % 30)) || !(5..10).contains(&(at / 30));
        prop_assert!(pixels.iter().enumerate().all(|(at, pixel)| !outside(at) || *pixel == 1));
    }

    #[test]
    fn blending_is_that_of_each_channel(colour in any::<[u8; 4]>(), pixel in any::<[u8; 3]>()) {
        let [r, g, b, a] = colour;
        let result = over(u32::from_be_bytes([a, r, g, b]), u32::from_be_bytes([0, pixel[0], pixel[1], pixel[2]]));
        let [zero, result @ ..] = result.to_be_bytes();
        prop_assert_eq!(zero, 0);
        for (k, light) in [r, g, b].into_iter().enumerate() {
            let expected = f32::from(light) + f32::from(pixel[k]) * (1.0 - f32::from(a) / 255.0);
            prop_assert!((f32::from(result[k]) - expected.min(255.0)).abs() <= 0.51);
        }
    }
}
