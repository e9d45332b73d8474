//! No text makes the parser panic, overflow the stack, or take long.

use pathmarch_scene::Scene;
use proptest::prelude::*;
use std::time::{Duration, Instant};

const FILES: &[&str] = &[
    include_str!("data/cornell.kdl"),
    include_str!("data/diffuse_sphere_plane.kdl"),
    "pathmarch 1\ncamera \"a\" { position 0 1 5; target 0 1 0; lens radius=0.1 focus=2 }\nsky \"#abc\"\n\
     material \"g\" { diffuse \"#fff\" } /* b */\nobject \"c\" material=\"g\" { subtract smooth=0.05 { at 0 0 1; box 2 1 \\\n 2\n\
     /-torus { a }\nsphere radius=0.7 { at 0.4 1 0.4 } } // d\n }\nobject #\"e\"# { plane { normal 0 1 1 } }\n\
     sun { direction 0.3 0.8 0.5; irradiance 3 2.9 2.7; angle 0.53 }",
    "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky \"gradient\" { zenith 0.2 0.4 0.8; horizon 1; ground 0.3 }\n\
     render { sampler \"sobol\"; caustics \"fast\"; clamp 10 }\npoint { at 0 1 0; intensity 1; penumbra 16 }\n\
     object \"a\" { sphere }",
    "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky \"tests/data/small.hdr\" strength=2 rotate=90\nmisspelt",
    // One mistake, so that no day is computed.
    "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nmisspelt\n\
     sky \"day\" elevation=35 azimuth=120 haze=1 strength=1 sun=#true { ground 0.2 }",
];

/// Pieces worth inserting.
const PIECES: &[&str] = &[
    "{",
    "}",
    "\"",
    "#",
    "\"\"\"",
    "/*",
    "*/",
    "/-",
    "//",
    "\\",
    "(",
    ")",
    "=",
    ";",
    "\n",
    "-",
    ".",
    "1e999",
    "#nan",
    "é",
    "\u{0}",
    "union {",
    "material=",
    "0x",
    "\r",
    "[",
    "-0",
    "1e-300",
    "3e38",
    "#\"",
    "\u{feff}",
    " at 1 1 1;",
];

/// (what, where, how much): deletes, doubles, or inserts.
fn mutate(text: &str, changes: &[(usize, usize, usize)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for &(what, place, amount) in changes {
        let place = place % (bytes.len() + 1);
        let end = (place + amount % 24).min(bytes.len());
        match what % 4 {
            0 => drop(bytes.drain(place..end)),
            1 => {
                let piece = bytes[place..end].to_vec();
                bytes.splice(place..place, piece);
            }
            2 => drop(bytes.splice(place..place, PIECES[amount % PIECES.len()].bytes())),
            _ => bytes.insert(place, amount as u8),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A scene or mistakes inside the text, never a panic.
    #[test]
    fn slow_mutated_files(file in 0..FILES.len(), changes in prop::collection::vec(any::<(usize, usize, usize)>(), 1..8)) {
        let text = mutate(FILES[file], &changes);
        match Scene::parse("mutated.kdl", &text) {
            Ok(scene) => prop_assert!(!scene.cameras.is_empty()),
            Err(error) => {
                prop_assert!(!error.mistakes().is_empty());
                for mistake in error.mistakes() {
                    let span = mistake.span.offset()..mistake.span.offset() + mistake.span.len();
                    prop_assert!(text.get(span.clone()).is_some(), "{:?} is not inside {:?}: {}", span, text, mistake);
                }
                let report = format!("{:?}", miette::Report::new(error));
                prop_assert!(!report.is_empty());
            }
        }
    }

    #[test]
    fn slow_any_text(text in "\\PC*") {
        let _ = Scene::parse("any.kdl", &text);
    }
}

/// Time for a text, whatever comes of it; far below `limit` except on a very busy machine.
fn timed(what: &str, text: &str, limit: Duration) {
    let start = Instant::now();
    let result = Scene::parse("large.kdl", text);
    let elapsed = start.elapsed();
    let outcome =
        result.map_or_else(|error| error.to_string(), |scene| format!("{} shapes", scene.field.leaves().len()));
    println!("{what}: {} bytes, {:.1} ms, {outcome}", text.len(), elapsed.as_secs_f64() * 1e3);
    assert!(elapsed < limit, "{what} took {elapsed:?}");
}

#[test]
fn slow_large_scenes_in_linear_time() {
    for count in [1_000, 10_000, 90_000] {
        let mut text =
            "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nmaterial \"white\" { diffuse 0.8 }\n".to_owned();
        for index in 0..count {
            text += &format!("object \"o{index}\" material=\"white\" {{ sphere 1 {{ at {index}.5 0.25 -3.125 }} }}\n");
        }
        timed(&format!("{count} objects"), &text, Duration::from_secs(20));
    }
}

/// Texts as large as allowed and as bad as we could think of. The stack of a test thread is 2 MiB.
#[test]
fn slow_hostile_texts() {
    let limit = Duration::from_secs(40);
    let head = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n";
    timed("100,000 open braces", &format!("{head}{}", "a { ".repeat(100_000)), limit);
    timed("100,000 bare braces", &format!("{head}{}", "{".repeat(100_000)), limit);
    for (what, piece) in [
        ("closing braces", "}"),
        ("nodes", "a;"),
        ("arguments", "1 "),
        ("commented-out nodes", "/-a{"),
        ("commented-out blocks", "a /-{ "),
        ("/-", "/-"),
        ("comments in comments", "/*"),
        ("quotes", "\""),
        ("open strings", "a \"\n"),
        ("joined lines", "\\\n"),
        ("hashes", "#"),
        ("raw strings", "#\" "),
        ("parentheses", "(a"),
        ("spaces before =", "a "),
        ("zero bytes", "\0"),
        ("misspelt nodes", "objct\n"),
        ("cameras", "camera\n"),
        ("materials", "material a{difuse 1}\n"),
        ("lights", "point{at 0 0 0;intensity 1}\n"),
        ("skies", "sky \"day\"\n"),
        ("objects", "object a{sphere}\n"),
        ("one long name", "a"),
        ("one long number", "9"),
    ] {
        let largest = if cfg!(debug_assertions) { 1 << 20 } else { 16 << 20 };
        let room = largest - head.len();
        timed(what, &format!("{head}{}", piece.repeat(room / piece.len())), limit);
    }
    let points = "point { at 0 0 0; intensity 1 }\n".repeat(200_000);
    let shapes = format!("object a {{\n{}}}", "sphere\n".repeat(100_000));
    timed("points in solids", &format!("{head}{points}{shapes}"), limit);
    let string = "\\ \n".repeat(1 << 20);
    timed("one long string", &format!("{head}object \"{string}\" {{ sphere }}"), limit);
    timed("long lines", &format!("{head}object \"\"\"\n{}\n\"\"\" {{ sphere }}", "a\n".repeat(1 << 22)), limit);
}

/// A few lines that would be a billion shapes are refused at once.
#[test]
fn shapes_of_shapes_are_bounded() {
    let head = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nsky 1\n";
    let refused = |text: &str| {
        let start = Instant::now();
        let error = Scene::parse("laughs.kdl", text).expect_err("too much");
        assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
        error.mistakes().iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>()
    };
    let ten = |name: &str| format!("{name}; ").repeat(10);
    let laughs = |first: &str, levels: usize| {
        let mut text = format!("{head}shape \"s0\" {{ {first} }}\n");
        (1..levels).for_each(|k| text += &format!("shape \"s{k}\" {{ {} }}\n", ten(&format!("s{}", k - 1))));
        format!("{text}object \"o\" {{ s{} }}\n", levels - 1)
    };
    assert_eq!(refused(&laughs("box; sphere", 10)), ["The scene has more than 100000 shapes."]);
    assert_eq!(refused(&laughs("s1", 10)).len(), 10);
    assert_eq!(refused(&laughs("spher", 30)).len(), 1);
    assert_eq!(refused(&laughs("sphere \"t - 1\"", 30)).len(), 1);
    let mut chain = format!("{head}shape \"s0\" {{ sphere }}\n");
    (1..20_000).for_each(|k| chain += &format!("shape \"s{k}\" {{ s{} }}\n", k - 1));
    assert!(Scene::parse("chain.kdl", &format!("{chain}object \"o\" {{ s60 }}\n")).is_ok());
    assert_eq!(
        refused(&format!("{chain}object \"o\" {{ s19999 }}\n")),
        ["Shapes are nested more than 64 levels deep."]
    );
    let _ = pathmarch_scene::Document::new("chain.kdl", chain);
}
