//! Inspector: every control, and the effect of each kind of control on the text.

use super::*;
use pathmarch_render::pathmarch_field::registry;
use pathmarch_render::pathmarch_scene::document::{Control, ControlKind, ItemKind, key};
use pathmarch_render::pathmarch_scene::{materials, settings};

/// A scene with every shape, operator and kind of material, each with all of its parameters or none.
fn everything() -> String {
    let mut text = "pathmarch 1\ncamera { position 0 1 5; target 0 0 0 }\nrender { size 32 24; samples 1 }\n\
                    sky \"day\"\nsun { direction 0 1 0; irradiance 1 }\npoint { at 0 3 0; intensity 1 }\n"
        .to_owned();
    for kind in materials::kinds() {
        let numbers = |param: &materials::MaterialParam| format!("{} {}; ", param.name(), param.spec.default);
        let others: String = kind.params.iter().skip(1).map(numbers).collect();
        text += &format!("material \"of {0}\" {{ {0} {1}; {others}}}\n", kind.name, kind.params[0].spec.default);
    }
    for shape in registry::shapes() {
        let name = &*shape.info().name;
        let normal = if shape.info().facing { "; normal 0 1 0" } else { "" };
        let (open, close) = if shape.info().profile { ("extrude {", "}") } else { ("", "") };
        text +=
            &format!("object \"a {name}\" {{ {open} {name} {{ at 0 0 0; rotate 0 0 0; scale 1{normal} }} {close} }}\n");
    }
    for operator in registry::operators() {
        let name = &*operator.info().name;
        let blend = if operator.blends() { "smooth=0.1 profile=\"stairs\" steps=3" } else { "" };
        text += &format!("object \"an {name}\" {{ {name} {blend} {{ sphere; box }} }}\n");
    }
    for modifier in registry::modifiers() {
        let name = &*modifier.info().name;
        text += &format!("object \"an {name}\" {{ {name} {{ sphere }} }}\n");
    }
    text
}

#[test]
fn every_control_of_every_node_is_a_widget_with_its_label() {
    // Tall enough that every control is visible.
    let mut person = Start::with(&everything()).size(1000.0, 1600.0).go();
    let mut seen = 0;
    for item in person.items() {
        if item.kind == ItemKind::Version {
            continue;
        }
        person.app_mut().select(Some(item.path.clone()));
        person.wait(3);
        let controls = person.document().controls(&item.path);
        if item.kind == ItemKind::Shape || item.kind == ItemKind::Material {
            assert!(!controls.is_empty(), "{item:?}");
        }
        for control in controls {
            let label = &*control.label;
            let roles: &[Role] = match (&control.kind, &control.value) {
                // The scene is still.
                _ if settings::OF_MOTION.contains(&label) => &[Role::Button],
                (ControlKind::Material(_), _) => &[Role::ComboBox],
                (_, Value::None) => &[Role::Button],
                (ControlKind::Number(_), _) => &[Role::Slider, Role::SpinButton],
                (ControlKind::Triple { .. } | ControlKind::Size { .. }, _) => &[Role::SpinButton],
                (ControlKind::Colour { .. }, _) => &[Role::ColorWell, Role::Button],
                (ControlKind::Choice(_), _) => &[Role::ComboBox],
                (ControlKind::Flag, _) => &[Role::CheckBox],
                (ControlKind::Text | ControlKind::Picture, _) => &[Role::TextInput],
            };
            let is_there = |role: &Role| person.harness.query_all_by_role_and_label(*role, label).next().is_some();
            assert!(roles.iter().any(is_there), "{label} of {}: no {roles:?}", item.title());
            seen += 1;
        }
    }
    assert!(seen > 200, "{seen}");
    assert_eq!(person.undo_all(), 0, "looking changes nothing");
}

#[test]
fn a_number_is_typed_beside_its_slider() {
    let mut person = Person::at_scene();
    person.click_role(Role::TreeItem, "object “ball”");
    person.harness.query_all_by_role_and_label(Role::TreeItem, "sphere").next().expect("there").click();
    person.wait(PAUSE);
    assert_eq!(person.selected().as_deref(), Some("sphere"));
    person.type_number("radius", "0.85");
    assert_eq!(changed_lines(SCENE, person.text()).len(), 1);
    assert!(person.text().contains("object \"ball\" material=\"red\" { sphere 0.85 { at 0 0.7 0 } } // round"));
    assert_eq!(person.value("sphere", "radius"), Value::Number(0.85));
    let bounds = person.scene().field.leaf_bounds(0);
    assert!((bounds.max[0] - 0.85).abs() < 1e-3, "the scene has it, too: {bounds:?}");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_drag_of_a_slider_is_one_step() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let slider = person.harness.get_by_role_and_label(Role::Slider, "radius").rect();
    let from = slider.left_center() + Vec2::new(30.0, 0.0);
    person.drag(from, from + Vec2::new(45.0, 0.0), PointerButton::Primary, Modifiers::NONE);
    assert_eq!(changed_lines(SCENE, person.text()).len(), 1);
    person.drag(from, from + Vec2::new(10.0, 0.0), PointerButton::Primary, Modifiers::NONE);
    assert_eq!(person.undo_all(), 2);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn numbers_typed_into_two_controls_are_two_steps() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let undo_group = person.app().undo_group;
    person.harness.get_by_role_and_label(Role::Slider, "radius").focus();
    person.wait(2);
    person.key(Key::ArrowRight);
    person.key(Key::ArrowRight);
    person.harness.get_by_role_and_label(Role::Slider, "scale").focus();
    person.wait(2);
    person.key(Key::ArrowRight);
    assert_ne!(person.app().undo_group, undo_group);
    assert_eq!(person.undo_all(), 2, "{}", person.text());
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_position_is_typed() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let label = person.document().control(&person.path("sphere"), key::AT).expect("there").label.into_owned();
    let second = person.harness.query_all_by_role_and_label(Role::SpinButton, &label).nth(1).expect("y");
    second.click();
    person.wait(PAUSE);
    person.retype("1.25");
    assert!(person.text().contains("sphere 0.7 { at 0 1.25 0 }"), "{}", person.text());
}

#[test]
fn a_colour_is_chosen() {
    let mut person = Person::at_scene();
    person.select("red");
    let label = {
        let controls = person.document().controls(&person.path("red"));
        let is_colour = |control: &&Control| matches!(control.value, Value::Colour(_));
        controls.iter().find(is_colour).expect("a colour").label.clone().into_owned()
    };
    let button = person.harness.query_all_by_label(&label).next().expect("a button");
    button.click();
    person.wait(PAUSE);
    // The colour picker is open: click into its field.
    let before = person.text().to_owned();
    let at = person.harness.query_all_by_label(&label).next().expect("a button").rect().center();
    person.drag(at + Vec2::new(0.0, 120.0), at + Vec2::new(-20.0, 150.0), PointerButton::Primary, Modifiers::NONE);
    person.key(Key::Escape);
    assert_ne!(person.text(), before, "a colour was chosen");
    assert_eq!(changed_lines(SCENE, person.text()).len(), 1);
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

/// Opens a combo box and chooses an entry.
fn choose(person: &mut Person, label: &str, name: &str) {
    person.click_role(Role::ComboBox, label);
    let entry = person.harness.query_all_by_label(name).last();
    entry.unwrap_or_else(|| panic!("no {name} in {label}")).click();
    person.wait(PAUSE);
}

#[test]
fn choices_flags_sizes_and_texts_work() {
    let sky = SCENE.replace("sky 0.6", "sky \"day\"");
    let mut person = Start::with(&sky).size(1000.0, 1200.0).go();
    // A choice.
    person.select("render");
    person.key(Key::F3);
    person.key(Key::F3);
    let label = person.document().control(&person.path("render"), "tonemap").expect("there").label.into_owned();
    let combo = person.harness.query_all_by_role_and_label(Role::ComboBox, &label).next().expect("there");
    combo.click();
    person.wait(PAUSE);
    person.harness.query_all_by_label("neutral").last().expect("there").click();
    person.wait(PAUSE);
    assert_eq!(person.value("render", "tonemap"), Value::Text("neutral".to_owned()));
    // A size.
    let label = person.document().control(&person.path("render"), "size").expect("there").label.into_owned();
    let width = person.harness.query_all_by_role_and_label(Role::SpinButton, &label).next().expect("width");
    width.click();
    person.wait(PAUSE);
    person.retype("80");
    assert!(person.text().contains("size 80 48"), "{}", person.text());
    // A flag.
    person.select("sky");
    let flag = {
        let controls = person.document().controls(&person.path("sky"));
        let flag = controls.iter().find(|control| control.kind == ControlKind::Flag).expect("a flag");
        flag.label.clone().into_owned()
    };
    person.harness.query_all_by_role_and_label(Role::CheckBox, &flag).next().expect("there").click();
    person.wait(PAUSE);
    assert!(person.text().contains("#false"), "{}", person.text());
    // A text.
    person.select("ball");
    let label = person.document().control(&person.path("ball"), key::NAME).expect("there").label.into_owned();
    person.fill(Role::TextInput, &label, "globe");
    assert!(person.text().contains("object \"globe\""), "{}", person.text());
    // Escape discards a text.
    person.field(Role::TextInput, &label).focus();
    person.wait(2);
    person.ctrl(Key::A);
    person.harness.event(egui::Event::Text("not this".to_owned()));
    person.wait(2);
    person.key(Key::Escape);
    assert!(person.text().contains("object \"globe\"") && !person.text().contains("not this"));
    // A material.
    let label = person.document().control(&person.path("globe"), key::MATERIAL).expect("there").label.into_owned();
    choose(&mut person, &label, "grey");
    assert!(person.text().contains("object \"globe\" material=\"grey\""), "{}", person.text());
    // A material kind.
    person.select("grey");
    let label = person.document().control(&person.path("grey"), key::KIND).expect("there").label.into_owned();
    choose(&mut person, &label, "glass");
    assert!(person.text().contains("material \"grey\" { glass"), "{}", person.text());
    assert_eq!(person.undo_all(), 6);
    assert_eq!(person.text(), sky);
}

#[test]
fn given_values_can_be_reset_and_missing_ones_set() {
    let mut person = Person::at_scene();
    person.select("subtract");
    let crosses: Vec<_> = person.harness.query_all_by_role_and_label(Role::Button, "×").collect();
    assert!(!crosses.is_empty());
    let row = person.harness.query_all_by_label("smooth").next().expect("there").rect();
    let cross = crosses.iter().find(|cross| cross.rect().y_range().contains(row.center().y)).expect("its cross");
    cross.click();
    drop(crosses);
    person.wait(PAUSE);
    assert!(!person.text().contains("smooth"), "{}", person.text());
    person.ctrl(Key::Z);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn undo_and_redo_by_keys_and_menu_return_the_exact_text() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let mut texts = vec![SCENE.to_owned()];
    for value in ["0.8", "0.9", "1.1"] {
        person.type_number("radius", value);
        texts.push(person.text().to_owned());
    }
    for text in texts.iter().rev().skip(1) {
        person.ctrl(Key::Z);
        assert_eq!(person.text(), text);
    }
    assert!(!person.open().has_unsaved_work(), "back where it was saved");
    for (k, text) in texts.iter().enumerate().skip(1) {
        if k % 2 == 0 {
            person.ctrl(Key::Y);
        } else {
            person.ctrl_shift(Key::Z);
        }
        assert_eq!(person.text(), text);
    }
    person.menu("Edit", "Undo: ");
    assert_eq!(person.text(), texts[2]);
    person.assert_said("Undone: Change radius");
    person.menu("Edit", "Redo: ");
    assert_eq!(person.text(), texts[3]);
}

#[test]
fn the_text_is_edited_as_text() {
    let mut person = Person::at_scene();
    person.key(Key::F4);
    let field = Role::MultilineTextInput;
    person.harness.get_by_role_and_label(field, "Scene text").focus();
    person.wait(2);
    person.ctrl(Key::Home);
    person.harness.event(egui::Event::Text("// first\n".to_owned()));
    person.wait(2);
    assert_eq!(person.text(), format!("// first\n{SCENE}"));
    // Keys without Ctrl are letters here.
    person.harness.event(egui::Event::Text("// p".to_owned()));
    person.harness.key_press(Key::P);
    person.harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    person.wait(2);
    assert!(!person.text().contains("hidden"));
    assert_eq!(person.open().view.mode, pathmarch_render::Mode::Path);
    // Typing without a pause is one undo step.
    let first = person.text().to_owned();
    person.wait(20);
    for letter in ["a", "b", "c"] {
        person.harness.event(egui::Event::Text(letter.to_owned()));
        person.wait(1);
    }
    assert_eq!(person.text().len(), first.len() + 3);
    person.menu("Edit", "Undo: Typing");
    assert_eq!(person.text(), first);
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn an_error_keeps_the_last_good_picture_and_shows_its_line() {
    let mut person = Person::at_scene();
    person.rest();
    let good = person.document().last_good().expect("a scene").clone();
    person.key(Key::F4);
    person.harness.get_by_role_and_label(Role::MultilineTextInput, "Scene text").focus();
    person.wait(2);
    person.ctrl(Key::End);
    person.harness.event(egui::Event::Text("object \"x\" { sfere }\n".to_owned()));
    person.wait(3);
    assert!(person.document().scene().is_err());
    assert!(person.has("1 error"));
    let line = SCENE.lines().count() + 1;
    assert!(person.has(&format!("line {line}, column 14")), "{:?}", person.harness);
    assert!(person.has("object \"x\" { sfere }"));
    assert!(Arc::ptr_eq(person.document().last_good().expect("a scene"), &good));
    assert!(person.open().view.picture.is_some());
    person.undo_all();
    assert!(!person.has("1 error"));
}

#[test]
fn a_gizmo_drag_is_one_undo_step() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.wait(2);
    // The arrow along y starts at the sphere's centre.
    let camera = person.open().view.camera.clone();
    let middle = super::camera::place(&camera, person.picture(), [0.0, 0.7, 0.0]);
    let mut caught = false;
    // Below is the disc that moves in the view plane.
    for up in (25..120).step_by(3) {
        let from = middle - Vec2::new(0.0, up as f32);
        person.drag(from, from - Vec2::new(0.0, 25.0), PointerButton::Primary, Modifiers::NONE);
        caught = person.text() != SCENE;
        if caught {
            break;
        }
        // That was an orbit.
        person.key(Key::Home);
        person.select("sphere");
    }
    assert!(caught, "no handle was there");
    let Value::Triple([x, y, z]) = person.value("sphere", key::AT) else { panic!("a place") };
    assert!(x.abs() < 0.01 && z.abs() < 0.01 && y > 0.72, "{x} {y} {z}");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

/// Centre of the sphere's gizmo in the test scene.
fn middle_of_ball(person: &Person) -> Pos2 {
    super::camera::place(&person.open().view.camera, person.picture(), [0.0, 0.7, 0.0])
}

#[test]
fn the_disc_moves_in_the_view_plane() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let middle = middle_of_ball(&person);
    person.drag(middle, middle + Vec2::new(40.0, 0.0), PointerButton::Primary, Modifiers::NONE);
    let Value::Triple([x, y, z]) = person.value("sphere", key::AT) else { panic!("a place") };
    assert!(x > 0.1 && (y - 0.7).abs() < 1e-3 && z.abs() < 1e-3, "{x} {y} {z}");
    assert!(middle_of_ball(&person).distance(middle) < 1e-3, "the camera stays");
    assert_eq!(person.undo_all(), 1);
}

#[test]
fn rotating_and_scaling_is_one_undo_step_each() {
    let mut person = Person::at_scene();
    person.select("sphere");
    let middle = middle_of_ball(&person);
    let out = |x: f32, y: f32| middle + Vec2::new(x, y) * 84.0;
    person.hover(out(-2.0, 0.0));
    person.key(Key::Num2);
    // A quarter turn to the left about the view axis.
    person.drag(out(1.0, 0.0), out(0.0, -1.0), PointerButton::Primary, Modifiers::NONE);
    let Value::Triple(degrees) = person.value("sphere", key::ROTATE) else { panic!("angles") };
    let [x, y, z] = degrees.map(f32::to_radians);
    let turn = glam::Quat::from_euler(glam::EulerRot::ZYX, z, y, x);
    let axis = -pathmarch_render::pathmarch_scene::navigation::axes(&person.open().view.camera).forward;
    let expected = glam::Quat::from_axis_angle(axis, std::f32::consts::FRAC_PI_2);
    assert!(turn.angle_between(expected) < 0.02, "{degrees:?}");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
    person.hover(out(-2.0, 0.0));
    person.key(Key::Num3);
    person.drag(out(1.0, 0.0), out(1.5, 0.0), PointerButton::Primary, Modifiers::NONE);
    let Value::Number(scale) = person.value("sphere", key::SCALE) else { panic!("a scale") };
    assert!((scale - 1.5).abs() < 0.02, "{scale}");
    // A press without movement changes nothing, and a drag across handles does not grab them.
    assert_eq!(person.undo_all(), 1);
    person.click_at(out(1.0, 0.0), Modifiers::NONE);
    assert_eq!(person.text(), SCENE);
    let camera = person.open().view.camera.clone();
    person.drag(out(-1.5, 0.0), out(1.0, 0.0), PointerButton::Primary, Modifiers::NONE);
    assert_eq!(person.text(), SCENE);
    assert_ne!(person.open().view.camera, camera);
}

#[test]
fn a_shared_material_is_copied_and_becomes_a_preset() {
    let mut person = Person::at_scene();
    person.select("carved");
    person.click("Make a copy");
    assert!(person.text().contains("object \"carved\" material=\"grey 2\""), "{}", person.text());
    assert!(person.text().contains("object \"floor\" material=\"grey\""));
    assert_eq!(person.undo_all(), 1);
    person.select("red");
    person.click("Presets…");
    person.click("gold");
    assert!(person.text().contains("material \"red\" { metal 1 0.78 0.34; roughness 0.2 }"), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_sun_is_dragged_on_the_map_of_directions() {
    let text = format!("{SCENE}sun {{ direction 0 1 0; irradiance 2 }}\n");
    let mut person = Start::with(&text).go();
    person.select("sun");
    let (picture, camera) = (person.picture(), person.open().view.camera.clone());
    // Straight up is nearly a quarter of the sphere away from the camera, which looks a little down.
    let radius = 75.0_f32.min(0.22 * picture.width().min(picture.height()));
    let (y, z): (f32, f32) = (camera.position[1] - camera.target[1], camera.position[2]);
    let up = picture.center() - Vec2::new(0.0, radius * (z.atan2(y) / std::f32::consts::FRAC_PI_2));
    let right = picture.center() + Vec2::new(radius, 0.0);
    person.drag(up, right, PointerButton::Primary, Modifiers::NONE);
    let Value::Triple([x, y, z]) = person.value("sun", "direction") else { panic!("a direction") };
    assert!(x > 0.99 && y.abs() < 0.02 && z.abs() < 0.02, "{x} {y} {z}");
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), text);
    assert!(!person.open().view.is_camera_modified(), "the drag was no orbit");
}

#[test]
fn the_exposure_follows_the_picture_until_it_is_set() {
    let mut person = Person::at_scene();
    person.rest();
    person.click("Auto");
    person.rest();
    let stops = person.app().live.picture().expect("a picture").exposure_stops;
    assert!(person.open().view.camera.auto_exposure && stops != 0.0);
    person.menu("Camera", "Save view to camera");
    assert!(person.text().contains("fov 40; exposure \"auto\" }"), "{}", person.text());
    person.rest();
    person.click("Auto");
    let camera = &person.open().view.camera;
    assert_eq!((camera.auto_exposure, camera.exposure), (false, stops), "the picture stays as it is");
    person.type_number("exposure", "2");
    person.menu("Camera", "Save view to camera");
    assert!(person.text().contains("fov 40; exposure 2 }"), "{}", person.text());
    person.undo_all();
    assert_eq!(person.text(), SCENE);
}

#[test]
fn materials_are_dragged_from_the_palette_onto_shapes() {
    let mut person = Person::at_scene();
    person.rest();
    person.key(Key::F7);
    person.wait(4);
    let middle =
        |person: &Person, label: &str| person.harness.get_by_role_and_label(Role::Button, label).rect().center();
    let ball = middle_of_ball(&person);
    let from = middle(&person, "Preset gold");
    person.drag(from, ball, PointerButton::Primary, Modifiers::NONE);
    let gold = "material \"gold\" { metal 1 0.78 0.34; roughness 0.2 }";
    assert!(person.text().contains("object \"ball\" material=\"gold\""), "{}", person.text());
    assert_eq!(person.text().matches(gold).count(), 1);
    // Another use of the preset needs no second material.
    person.select("carved");
    person.click_role(Role::Button, "Preset gold");
    assert!(person.text().contains("object \"carved\" material=\"gold\""), "{}", person.text());
    assert_eq!(person.text().matches(gold).count(), 1);
    person.undo_all();
    assert_eq!(person.text(), SCENE);
    // Onto a row of the tree.
    let row = person.harness.get_by_role_and_label(Role::TreeItem, "object “floor”").rect().center();
    let from = middle(&person, "Material red");
    person.drag(from, row, PointerButton::Primary, Modifiers::NONE);
    assert!(person.text().contains("object \"floor\" material=\"red\""), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
    person.until("the visible balls are rendered", |person| {
        let [shown, all] = person.app().material_balls.counts();
        shown == all && all > 4
    });
}

/// The byte position on screen of a word of the source text.
fn place_of(person: &Person, word: &str) -> Pos2 {
    let text = person.text();
    let at = text.find(word).unwrap_or_else(|| panic!("no {word}"));
    let (line, column) = (text[..at].matches('\n').count(), text[..at].rsplit('\n').next().map_or(0, str::len));
    let field = person.harness.get_by_role_and_label(Role::MultilineTextInput, "Scene text").rect();
    let height = field.height() / text.split('\n').count() as f32;
    let context = &person.harness.ctx;
    let font = egui::TextStyle::Monospace.resolve(&context.style_of(egui::Theme::Dark));
    let width = context.fonts_mut(|fonts| fonts.glyph_width(&font, 'm'));
    field.min + Vec2::new((column as f32 + 0.5) * width, (line as f32 + 0.5) * height)
}

#[test]
fn names_are_listed_while_they_are_typed() {
    let mut person = Person::at_scene();
    person.key(Key::F4);
    person.harness.get_by_role_and_label(Role::MultilineTextInput, "Scene text").focus();
    person.wait(2);
    person.ctrl(Key::End);
    for letter in ["\nobject \"x\" { ", "sp", "h"] {
        person.harness.event(egui::Event::Text(letter.to_owned()));
        person.wait(2);
    }
    assert!(person.has("sphere"), "the list is shown");
    person.key(Key::Enter);
    assert!(person.text().ends_with("object \"x\" { sphere 1"), "{}", person.text());
    person.harness.event(egui::Event::Text(" }".to_owned()));
    person.wait(3);
    assert!(person.document().scene().is_ok());
    // Escape closes a list and puts nothing into the text.
    person.harness.event(egui::Event::Text("\nmat".to_owned()));
    person.wait(2);
    let text = person.text().to_owned();
    person.key(Key::Escape);
    person.key(Key::Enter);
    assert!(person.text().trim_end() == text.trim_end(), "{}", person.text());
}

#[test]
fn a_number_of_the_text_is_dragged() {
    let mut person =
        Start::with("pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nobject \"a\" { sphere 0.50 }\n").go();
    person.key(Key::F4);
    person.wait(3);
    let before = person.text().to_owned();
    let at = place_of(&person, "0.50");
    person.drag(at, at + Vec2::new(40.0, 0.0), PointerButton::Primary, Modifiers::ALT);
    assert!(person.text().contains("sphere 0.60"), "{}", person.text());
    assert_eq!(person.undo_all(), 1, "a drag is one step");
    assert_eq!(person.text(), before);
}

#[test]
fn mistakes_and_colours_are_marked_beside_the_text() {
    let mut person = Person::at_scene();
    person.key(Key::F4);
    person.wait(3);
    let swatch = person.harness.query_all_by_role_and_label(Role::ColorWell, "Colour in the text").count();
    assert!(swatch > 0, "the first lines with a colour have a swatch");
    person.harness.get_by_role_and_label(Role::MultilineTextInput, "Scene text").focus();
    person.wait(2);
    person.ctrl(Key::Home);
    person.harness.event(egui::Event::Text("spear\n".to_owned()));
    person.wait(3);
    let marks = person.harness.query_all(By::new().role(Role::Image).label_contains("spear"));
    assert_eq!(marks.count(), 1);
}
