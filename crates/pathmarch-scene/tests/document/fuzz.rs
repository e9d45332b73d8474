//! Random edits with random steps back and forth: a scene stays a scene, comments stay through changes of parameters,
//! and taking everything back gives the file byte for byte.

use super::all_items;
use super::controls::meaning;
use pathmarch_field::registry;
use pathmarch_scene::document::{Control, ControlKind, Document, EditError, Item, ItemKind, Path, Value};
use pathmarch_scene::{Scene, materials};
use proptest::prelude::*;
use std::collections::HashMap;

/// Real scenes, and texts of which every line is nasty in its own way. Days and pictures would make it slow.
const TEXTS: &[&str] = &[
    include_str!("../../../../scenes/cornell.kdl"),
    include_str!("../../../../scenes/glass-still-life.kdl"),
    include_str!("../../../../scenes/ten-lines.kdl"),
    include_str!("../../../../scenes/thesis/combinations.kdl"),
    include_str!("../../../../scenes/thesis/solids.kdl"),
    include_str!("../../../../scenes/material-grid.kdl"),
    // CR LF, tabs, a byte order mark, no new line at the end.
    "\u{feff}pathmarch 1\r\n// first\r\ncamera \"a\" {\r\n\tposition 0 1 5 // where\r\n\ttarget 0 1 0\r\n}\r\n\r\n\r\nmaterial m { diffuse \"#FFF\" }\r\n\
     object \"o\" material=m {\r\n\tunion smooth=0.1 {\r\n\t\t// ball\r\n\t\tsphere 1 // round\r\n\r\n\t\tbox 2 { at 1 0 0 }\r\n\t}\r\n}",
    // One line after the other in one line; comments everywhere; what is commented out; lines that go on.
    "/* top */ pathmarch 1; camera { position 0 1 5; target 0 1 0 }; sky \"#abc\" // blue\n\
     material \"g\" { diffuse /* c */ \"#fff\" /* d */; } /* b */\n\
     object \"c\" /-\"x\" material=\"g\" /* e */ { subtract /-smooth=1 smooth=0.05 { at 0 0 1; box 2 1 \\ // join\n 2\n\
     /-torus { a \"}\" }\nsphere radius=0.7 { at 0.4 1 0.4; } // d\n /- (type)cone (t)1 /-{ b }\n}/* f */\n /* g\n h */ }\n\
     /* i */ object #\"e\"# { plane /-{ x } { normal 0 1 1 } /-{ y } } // last\n\
     render { samples 4\n\n\n  size 64 48; bounces 2 }\nsun{direction 0.3 0.8 0.5;irradiance 3 2.9 2.7;angle 0.53}\n\
     point \\\n { \\\n at 1 1 1 \\\n\n intensity 1 ; }\n\n\n// end",
    // Strings of several lines, braces that are empty or close where a node ends, properties first.
    "pathmarch 1\ncamera \"\"\"\n  two\n  lines\n  \"\"\" { position 0 1 5; target 0 1 0}\n\
     material \"\"\"\n    deep\n      er\n    \"\"\" {metal 1 0.5 0.25;roughness 0.5}\nmaterial #\"raw \"quoted\"\"# { emit 1 }\n\
     object \"a\" material=#\"raw \"quoted\"\"# {union{sphere material=\"\"\"\n    deep\n      er\n    \"\"\" radius=1{}\nbox{}}}\n\
     object \"b\"{torus minor=0.1 1{at 0 1 0}}\nobject c { rounded-box 2 0.1 {\n} }\n\
     sky \"gradient\" {\n  zenith 1 // up\n\n  horizon 0.5 }\nrender {}\n",
];

/// One random number after the other.
struct Dice<'a> {
    numbers: std::slice::Iter<'a, u32>,
}

impl Dice<'_> {
    fn below(&mut self, end: usize) -> usize {
        self.numbers.next().map_or(0, |number| *number as usize) % end.max(1)
    }
    fn pick<'x, T>(&mut self, all: &'x [T]) -> Option<&'x T> {
        let index = self.below(all.len());
        all.get(index)
    }
    fn number(&mut self) -> f32 {
        const NUMBERS: [f32; 12] = [0.0, 1.0, 0.5, 2.0, -1.0, 0.1, 3.25, 1e-7, 1e12, 100.0, 0.3, -0.75];
        NUMBERS[self.below(NUMBERS.len())]
    }
    fn name(&mut self) -> &'static str {
        const NAMES: [&str; 8] = ["a", "new", "two words", "\"quoted\"", "", "1", "back\\slash\n", "{é}"];
        NAMES[self.below(NAMES.len())]
    }
    fn value(&mut self, control: &Control) -> Value {
        match &control.kind {
            ControlKind::Number(range) if range.whole => Value::Number(range.allowed.min + self.below(5) as f32),
            ControlKind::Number(_) => Value::Number(self.number()),
            ControlKind::Triple { .. } => Value::Triple([self.number(), self.number(), self.number()]),
            ControlKind::Colour { .. } => match self.below(3) {
                0 => Value::Colour([self.number(); 3]),
                1 => Value::Colour([1.0, 0.0, 1.0]),
                _ => Value::Colour([self.number(), self.number(), self.number()]),
            },
            // A day takes long to compute.
            ControlKind::Choice(words) => {
                let words: Vec<_> = words.iter().filter(|word| *word != "day").collect();
                Value::Text(self.pick(&words).map_or_else(String::new, |word| word.to_string()))
            }
            ControlKind::Text | ControlKind::Picture => Value::Text(self.name().to_owned()),
            ControlKind::Flag => Value::Flag(self.below(2) == 0),
            ControlKind::Material(names) => match self.below(4) {
                0 => Value::None,
                _ => Value::Text(self.pick(names).cloned().unwrap_or_default()),
            },
            ControlKind::Size { .. } => Value::Size([self.below(2000) as u32, 64]),
        }
    }
}

/// All comments of a text, wherever they stand; also what looks like one in a string.
fn comments(text: &str) -> Vec<String> {
    let line = |rest: &str| rest.split(['\r', '\n']).next().unwrap_or("").trim_end().to_owned();
    let mut comments: Vec<String> = text.split("//").skip(1).map(line).collect();
    comments.extend(text.split("/*").skip(1).map(|rest| rest.split("*/").next().unwrap_or("").to_owned()));
    comments
}

/// Every node with all its values, in no order.
fn inventory(document: &Document) -> Vec<String> {
    let values = |item: &Item| {
        let controls = document.controls(&item.path).into_iter();
        let values: Vec<_> = controls.map(|control| format!("{}={:?}", control.key, control.value)).collect();
        format!("{} {}", item.word, values.join(" "))
    };
    let mut all: Vec<String> = all_items(document).iter().map(values).collect();
    all.sort();
    all
}

/// What is in `all` and not in `some`, each as often as it is.
fn without(all: &[String], some: &[String]) -> Vec<String> {
    let mut left = some.to_vec();
    let gone = |one: &&String| left.iter().position(|other| other == *one).map(|at| left.swap_remove(at)).is_none();
    all.iter().filter(gone).cloned().collect()
}

/// How many nodes came and went in an edit, of those that are as they were in all their values.
fn came_and_went(before: &[String], after: &[String]) -> (usize, usize) {
    (without(after, before).len(), without(before, after).len())
}

/// That so many nodes came and went, if the text is a scene: a mistake can make one node of several.
fn assert_came_and_went(before: &[String], document: &Document, expected: (usize, usize)) {
    if document.scene().is_ok() {
        assert_eq!(came_and_went(before, &inventory(document)), expected, "{}", document.text());
    }
}

/// Number of shapes, in objects and operators of any depth.
fn shapes(document: &Document) -> usize {
    all_items(document).iter().filter(|item| matches!(item.kind, ItemKind::Shape | ItemKind::Instance)).count()
}

/// That the shapes are still there, if the text is a scene.
fn assert_shapes(document: &Document, count: usize) {
    if document.scene().is_ok() {
        assert_eq!(shapes(document), count, "{}", document.text());
    }
}

fn size(item: &Item) -> usize {
    1 + item.children.iter().map(size).sum::<usize>()
}

/// One random edit; whether it only changed parameters.
fn edit(document: &mut Document, dice: &mut Dice) -> Result<bool, EditError> {
    let items: Vec<Item> = all_items(document);
    let Some(item) = dice.pick(&items).cloned() else { return Ok(true) };
    let path = &item.path;
    let before = inventory(document);
    let another = dice.pick(&items).map(|item| item.path.clone()).unwrap_or_default();
    match dice.below(16) {
        0..=4 => {
            let controls = document.controls(path);
            let Some(control) = dice.pick(&controls) else { return Ok(true) };
            let value = dice.value(control);
            let gesture = [None, Some(1), Some(2)][dice.below(3)];
            document.set(path, &control.key, value, gesture)?;
            // Another kind of thing has other parameters.
            return Ok(control.key != "kind");
        }
        5..=6 => {
            let controls = document.controls(path);
            let Some(control) = dice.pick(&controls) else { return Ok(true) };
            // A setting goes with the comment behind it.
            document.reset(path, &control.key)?;
        }
        7 => {
            let parent = [Some(path), None][dice.below(2)];
            let additions: Vec<_> =
                document.additions(parent).into_iter().filter(|addition| addition.name != "day").collect();
            let Some(addition) = dice.pick(&additions) else { return Ok(true) };
            let added = document.add(parent, addition)?;
            let added = document.item(&added).expect("added");
            assert_came_and_went(&before, document, (size(added), 0));
            return Ok(true);
        }
        8 => {
            document.remove(path)?;
            assert_came_and_went(&before, document, (0, size(&item)));
        }
        9 => {
            document.rename(path, dice.name())?;
            return Ok(true);
        }
        10..=11 => {
            let parent =
                [Some(&another), None, path.parent().as_ref(), another.parent().as_ref()][dice.below(4)].cloned();
            let count = shapes(document);
            let moved = document.move_to(path, parent.as_ref(), dice.below(8))?;
            let now = document.item(&moved).expect("moved");
            if parent == path.parent() {
                assert_eq!((&now.word, &now.name, now.children.len()), (&item.word, &item.name, item.children.len()));
                assert_came_and_went(&before, document, (0, 0));
            }
            assert_shapes(document, count);
            // What is empty after the move goes, with its comments.
            let holder = items.iter().find(|holder| Some(&holder.path) == path.parent().as_ref());
            let was_alone = holder.is_some_and(|holder| holder.children.len() == 1);
            return Ok(parent == path.parent() || now.word == item.word && !was_alone);
        }
        12 if dice.below(2) == 0 => {
            let chosen: Vec<Path> = (0..dice.below(4)).filter_map(|_| Some(dice.pick(&items)?.path.clone())).collect();
            let count = shapes(document);
            document.combine(&chosen, ["union", "subtract", "intersect"][dice.below(3)])?;
            assert_shapes(document, count);
        }
        12 => {
            let siblings: Vec<Path> =
                items.iter().map(|item| item.path.clone()).filter(|other| other.is_sibling_of(path)).collect();
            let mut chosen: Vec<Path> = siblings.into_iter().filter(|_| dice.below(2) == 0).collect();
            chosen.push(path.clone());
            let operators: Vec<_> = registry::solids().filter(|solid| solid.is_operator()).collect();
            let operator = &*operators[dice.below(operators.len())].info().name;
            let group = document.group(&chosen, operator)?;
            chosen.sort();
            chosen.dedup();
            assert_eq!(document.item(&group).map(|item| item.children.len()), Some(chosen.len()));
            assert_came_and_went(&before, document, (1, 0));
            return Ok(true);
        }
        13 => {
            let freed = document.ungroup(path)?;
            if item.material.is_none() {
                assert_came_and_went(&before, document, (0, 1));
            }
            assert_eq!(freed.len(), item.children.len());
            for (path, child) in freed.iter().zip(&item.children) {
                assert_eq!(document.item(path).map(|item| &item.word), Some(&child.word));
            }
        }
        14 => {
            let copy = document.duplicate(path)?;
            assert_eq!(document.item(&copy).map(|item| &item.word), Some(&item.word));
            assert_came_and_went(&before, document, (size(&item), 0));
        }
        _ => {
            let kinds: Vec<&str> =
                materials::kinds().iter().map(|kind| kind.name).chain(["subtract", "gradient", "colour"]).collect();
            match dice.below(2) {
                0 => document.set_kind(path, dice.pick(&kinds).expect("kinds"))?,
                _ => {
                    let Some(mut camera) = document.last_good().map(|scene| scene.cameras[0].clone()) else {
                        return Ok(true);
                    };
                    camera.position[dice.below(3)] = dice.number();
                    camera.lens_radius = dice.number().abs();
                    camera.focus = [None, Some(2.5)][dice.below(2)];
                    let into = [None, Some(path)][dice.below(2)];
                    let at = document.write_camera(&camera, into)?;
                    let name = document.item(&at).and_then(|item| item.name.clone()).expect("a camera");
                    let written = document.scene().unwrap().cameras.iter().find(|other| other.name == name).cloned();
                    camera.name = name;
                    assert_eq!(written, Some(camera));
                }
            }
        }
    }
    Ok(false)
}

/// That everything can be taken back and done again.
fn check_history(document: &mut Document, text: &str) {
    while document.redo().is_some() {}
    let last = document.text().to_owned();
    let mut texts = vec![last.clone()];
    while document.undo().is_some() {
        texts.push(document.text().to_owned());
    }
    assert_eq!(document.text(), text);
    assert!(document.is_saved());
    for expected in texts.iter().rev().skip(1) {
        assert!(document.redo().is_some());
        assert_eq!(document.text(), expected);
    }
    assert_eq!(document.text(), last);
    assert!(document.redo().is_none());
}

/// Text of every node, and controls with their values.
fn places(document: &Document) -> Vec<String> {
    let place = |item: &Item| format!("{:?} {:?}", document.text_of(&item.path), document.controls(&item.path));
    all_items(document).iter().map(place).collect()
}

/// Counts the edits that were made, by the first word of their label.
fn run(text: &str, numbers: &[u32]) -> HashMap<String, usize> {
    let mut made = HashMap::new();
    let mut document = Document::new("../../scenes/test.kdl", text);
    let was_scene = document.scene().is_ok();
    let mut dice = Dice { numbers: numbers.iter() };
    while dice.numbers.len() > 0 {
        let before = document.text().to_owned();
        match dice.below(8) {
            0 => drop(document.undo()),
            1 => drop(document.redo()),
            _ => match edit(&mut document, &mut dice) {
                Ok(keeps_comments) => {
                    if let Some(label) = document.can_undo().filter(|_| document.text() != before) {
                        let word = label.split(' ').next().unwrap_or_default();
                        *made.entry(word.to_owned()).or_default() += 1;
                    }
                    // In a text with mistakes, a string without end can hold comments.
                    if keeps_comments && was_scene {
                        let now = comments(document.text());
                        let lost: Vec<_> = comments(&before).into_iter().filter(|old| !now.contains(old)).collect();
                        assert!(lost.is_empty(), "{lost:?} lost from\n{before}\nin\n{}", document.text());
                    }
                }
                Err(_) => assert_eq!(document.text(), before),
            },
        }
        if was_scene {
            document
                .scene()
                .unwrap_or_else(|error| panic!("{:?}\n{before}\n=>\n{}", error.mistakes()[0].message, document.text()));
        }
        // What it holds is what the text says.
        let fresh = Document::new(document.name(), document.text());
        assert_eq!(fresh.outline(), document.outline());
        assert_eq!(places(&fresh), places(&document));
        assert_eq!(fresh.scene().ok().map(|scene| meaning(scene)), document.scene().ok().map(|scene| meaning(scene)));
    }
    // Another reader of KDL 2 agrees that the text is in form.
    if was_scene && kdl::KdlDocument::parse_v2(text).is_ok() {
        let theirs = kdl::KdlDocument::parse_v2(document.text());
        assert!(theirs.is_ok(), "{theirs:?} of\n{}", document.text());
    }
    check_history(&mut document, text);
    made
}

/// That the random edits are edits: enough of each kind come to pass.
#[test]
fn slow_random_edits_are_made() {
    let mut made: HashMap<String, usize> = HashMap::new();
    let mut state = 1_u32;
    for round in 0..4 * TEXTS.len() {
        let numbers: Vec<u32> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            state >> 8
        })
        .take(600)
        .collect();
        run(TEXTS[round % TEXTS.len()], &numbers)
            .into_iter()
            .for_each(|(word, count)| *made.entry(word).or_default() += count);
    }
    let words = [
        "Change",
        "Reset",
        "Add",
        "Remove",
        "Rename",
        "Move",
        "Group",
        "Combine",
        "Ungroup",
        "Duplicate",
        "Make",
        "Write",
    ];
    for word in words {
        assert!(made.get(word).is_some_and(|count| *count >= 4), "{word} in {made:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn slow_random_edits_can_all_be_taken_back(which in 0..TEXTS.len(), numbers in prop::collection::vec(any::<u32>(), 0..300)) {
        run(TEXTS[which], &numbers);
    }

    /// Texts with mistakes of every kind: a piece of a scene cut out.
    #[test]
    fn slow_broken_texts_are_edited_safely(
        which in 0..TEXTS.len(),
        (start, length) in (0..1000_usize, 1..12_usize),
        numbers in prop::collection::vec(any::<u32>(), 0..100),
    ) {
        let mut text: Vec<char> = TEXTS[which].chars().collect();
        let start = start % text.len();
        text.drain(start..(start + length).min(text.len()));
        run(&text.into_iter().collect::<String>(), &numbers);
    }
}

#[test]
fn the_texts_are_scenes() {
    for text in TEXTS {
        let problem =
            Scene::parse("../../scenes/test.kdl", text).err().map(|error| error.mistakes()[0].message.clone());
        assert_eq!(problem, None, "{text}");
    }
}
