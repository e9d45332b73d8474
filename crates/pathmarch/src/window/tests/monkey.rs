//! Monkey test: random clicks, drags, keys and texts never cause a panic, and undoing everything restores the text byte
//! for byte.

use super::*;
use crate::window::app::actions::ACTIONS;
use crate::window::app::dialog::Dialog;
use crate::window::open_scene::view_state::Resolution;

const FRAMES: usize = 2000;
const SEED: u64 = 0x5eed;

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }
}

const TYPED: [&str; 16] =
    ["0", "1", "-3.5", "1e9", "nan", "}", "{", "\"", "//", "\n", "ü", "🦀", "sphere", "/-", "material=", "\u{202e}"];
/// Input without effect.
const IDLE: [Role; 3] = [Role::Label, Role::GenericContainer, Role::Image];
const MODIFIERS: [Modifiers; 5] =
    [Modifiers::NONE, Modifiers::NONE, Modifiers::SHIFT, Modifiers::ALT, Modifiers::COMMAND];
const KEYS: [Key; 23] = [
    Key::Tab,
    Key::Tab,
    Key::Enter,
    Key::Escape,
    Key::ArrowUp,
    Key::ArrowDown,
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::Home,
    Key::End,
    Key::Backspace,
    Key::Delete,
    Key::Space,
    Key::W,
    Key::A,
    Key::S,
    Key::D,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::T,
    Key::PageDown,
    Key::Minus,
];

/// Performs a random action, which takes some frames.
fn act(person: &mut Person, random: &mut Random, size: Vec2) {
    let at = Pos2::new(random.unit() * size.x, random.unit() * size.y);
    let to = Pos2::new(random.unit() * size.x, random.unit() * size.y);
    let modifiers = MODIFIERS[random.below(MODIFIERS.len())];
    let button = [PointerButton::Primary, PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle]
        [random.below(4)];
    match random.below(21) {
        0..4 => {
            person.harness.hover_at(at);
            person.button(at, button, true, modifiers);
            person.button(at, button, false, modifiers);
        }
        // Presses a random widget.
        4..10 => {
            let nodes: Vec<_> = person
                .harness
                .query_all_by(|node| node.bounding_box().is_some() && !IDLE.contains(&node.role()))
                .collect();
            // The picture alone has no widgets.
            if nodes.is_empty() {
                drop(nodes);
                return person.key(Key::Escape);
            }
            let node = &nodes[random.below(nodes.len())];
            match random.below(8) {
                0 => node.focus(),
                1 => node.click_secondary(),
                2 => node.click_accesskit(),
                3 => node.increment_accesskit(),
                4 => node.decrement_accesskit(),
                _ => node.click(),
            }
        }
        10..12 => {
            person.harness.hover_at(at);
            person.button(at, button, true, modifiers);
            for step in 1..4 {
                person.harness.event(egui::Event::PointerMoved(at.lerp(to, step as f32 / 3.0)));
            }
            // Sometimes the button is never released, or outside of the window.
            match random.below(8) {
                0 => person.harness.event(egui::Event::PointerGone),
                _ => person.button(to, button, false, modifiers),
            }
        }
        12..15 => person.harness.key_press_modifiers(modifiers, KEYS[random.below(KEYS.len())]),
        15 => {
            let shortcut = ACTIONS[random.below(ACTIONS.len())].shortcut;
            if let Some(shortcut) = shortcut {
                person.harness.key_press_modifiers(shortcut.modifiers, shortcut.logical_key);
            }
        }
        16 => {
            let items = person.items();
            // A file opened with a mistake has none.
            if !items.is_empty() {
                let item = items[random.below(items.len())].path.clone();
                person.app_mut().select(Some(item));
            }
        }
        17 => {
            let text = person.harness.query_all_by_role_and_label(Role::MultilineTextInput, "Scene text").next();
            if let (Some(text), 0) = (text, random.below(3)) {
                text.focus();
                person.harness.step();
            }
            person.harness.event(egui::Event::Text(TYPED[random.below(TYPED.len())].to_owned()));
        }
        18 => person.harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: Vec2::new(0.0, 8.0 * (random.unit() - 0.5)),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers,
        }),
        // Drags a handle: dots are small.
        19 => {
            let handles = person.app().gizmo.dot_places.clone();
            if handles.is_empty() {
                return;
            }
            let from = handles[random.below(handles.len())];
            let to = from.lerp(to, 0.3 * random.unit());
            person.drag(from, to, button, modifiers);
        }
        _ => {
            let side = |random: &mut Random| (1100.0 * random.unit() * random.unit()).floor();
            let sides = [side(random), side(random)];
            let size = if random.below(3) == 0 { Vec2::from(sides) } else { Vec2::new(1000.0, 700.0) };
            person.harness.set_size(size);
        }
    }
}

/// Keeps the monkey away from files outside of its directory and from pictures that would fill the memory.
fn hold(person: &mut Person, file: &Path) {
    let app = person.app_mut();
    app.file_dialog = None;
    if matches!(app.dialog, Some(Dialog::Render(_) | Dialog::Recovered(_))) {
        app.dialog = None;
    }
    if let Some(open) = &mut app.open
        && open.view.resolution == Resolution::Scene
    {
        open.view.resolution = Resolution::Fit;
    }
    assert!(app.renders.is_empty());
    if app.open.as_ref().is_none_or(|open| open.path.as_deref() != Some(file)) {
        app.open_file(file);
    }
}

/// Lights and profiles with handles, an animated camera, textures with ramps, and hidden objects.
const LIT_SCENE: &str = r#"pathmarch 1
camera "main" { position 0 1.2 4.5; target 0 0.6 0; exposure "auto" }
render { size 48 32; samples 2; bounces 2 }
sky "day" elevation=30 azimuth=120
sun { direction 1 2 1; irradiance 2 }
point { at 1 2 1; lumen 400; colour 1 0.8 0.6 }
spot { at -1 2 1; target 0 0.5 0; candela 300; cone 50 }
material "marble" { principled { marble scale=4 { colour 0.1; colour 0.9 0.8 0.7; colour 0.3 } }; roughness { noise from=0.1 to=0.6 } }
material "lamp" { emit 6 }
object "ball" material="marble" { sphere 0.6 { at 0 0.6 "0.2*sin(t)" } }
object "bulb" material="lamp" { sphere 0.1 { at 1 1.4 0 } }
object "cup" material="marble" { revolve { curve 0.05 { point 0.3 0; point 0.1 0.2; point 0.35 0.5; at 0 0.3 0 } } }
object "sign" { extrude 0.1 { polygon { point -0.4 0; point 0.4 0; point 0 0.5; at -1 0.2 0 } } }
object "gone" hidden=#true { box 0.3 }
object "floor" { plane }
"#;

#[test]
fn whatever_is_done_nothing_panics_and_undo_returns_the_text() {
    go_wild(SCENE, SEED);
}

#[test]
fn the_same_with_lights_textures_and_motion() {
    go_wild(LIT_SCENE, SEED + 1);
}

/// Does random things with a scene, and undoes them.
fn go_wild(text: &str, seed: u64) {
    let mut person = Start::with(text).go();
    let mut random = Random(seed);
    let file = person.open().path.clone().expect("a file");
    let mut opened = text.to_owned();
    let (mut edits, mut mistakes, mut wrong_for, mut revision) = (0, 0, 0, 0);
    for _ in 0..FRAMES {
        let size = person.harness.ctx.content_rect().size();
        act(&mut person, &mut random, size);
        // Each event is a frame of its own; the file dialog does not open in between.
        person.harness.step();
        let was_another = person.app().open.as_ref().is_none_or(|open| open.path.as_ref() != Some(&file));
        hold(&mut person, &file);
        if was_another {
            opened = person.text().to_owned();
            revision = person.document().revision();
        }
        edits += usize::from(person.document().revision() != revision);
        let is_wrong = person.document().scene().is_err();
        mistakes += usize::from(is_wrong);
        wrong_for = if is_wrong { wrong_for + 1 } else { 0 };
        if wrong_for > 10 {
            // Otherwise most actions would be refused from here on.
            person.ctrl(Key::Z);
        }
        revision = person.document().revision();
    }
    // The monkey was not idle. The count depends on when pictures and messages arrive.
    assert!(edits > 20 && mistakes > 5, "{edits} edits, {mistakes} frames with mistakes");
    let app = person.app_mut();
    app.dialog = None;
    while let Some(open) = &mut app.open
        && open.document.can_undo().is_some()
    {
        open.document.undo();
    }
    assert_eq!(person.text(), opened);
}
