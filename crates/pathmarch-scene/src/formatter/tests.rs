//! The formatter against examples, every scene of the repository, and random texts.

use super::format;
use crate::language::nodes;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Formats a text without mistakes of syntax, and checks what holds for every text.
fn formatted(text: &str) -> String {
    let formatted = format("test.kdl", text).unwrap_or_else(|error| panic!("{error:?} in {text:?}"));
    let [before, after] = [text, &formatted].map(|text| nodes(text).expect("nodes"));
    assert!(before.has_same_nodes(&after), "{text:?}\n{formatted:?}");
    assert_eq!(format("test.kdl", &formatted).expect("still right"), formatted, "of {text:?}");
    formatted
}

/// Characters that the formatter never changes, in their order.
fn ink(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace() && !matches!(c, ';' | '\\')).collect()
}

/// Scenes of the repository.
fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut folders =
        ["scenes", "docs/tutorial", "crates/pathmarch-render/tests/data", "crates/pathmarch-measure/flights"]
            .map(|folder| root.join(folder))
            .to_vec();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("a file").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "kdl") {
                found.push(path);
            }
        }
    }
    found
}

#[test]
fn scenes_of_the_gallery_are_formatted() {
    let scenes = scenes();
    assert!(scenes.len() > 80, "{}", scenes.len());
    // Ten lines by name, of which one is wider than a line should be.
    let scenes = scenes.into_iter().filter(|path| !path.ends_with("ten-lines.kdl"));
    for path in scenes {
        let text = std::fs::read_to_string(&path).expect("a text");
        assert_eq!(formatted(&text), text, "run `pathmarch fmt {}`", path.display());
    }
}

/// Scenes of the gallery with other white space come back to what they are, apart from what depends on lines.
#[test]
fn indentation_and_spaces_do_not_matter() {
    for path in scenes() {
        let text = std::fs::read_to_string(&path).expect("a text");
        if text.contains("\"\"\"") || path.ends_with("ten-lines.kdl") {
            continue;
        }
        let ragged: Vec<String> = text.lines().map(|line| format!("\t{}  ", line.replace(" { ", "  {\t"))).collect();
        assert_eq!(formatted(&ragged.join("\n\n\n")).replace("\n\n", "\n"), text.replace("\n\n", "\n"), "{path:?}");
    }
}

#[test]
fn braces_stay_on_their_line_if_they_fit() {
    let wide = format!("object \"a\" {{ {} }}\n", ["sphere 1 { at 0 1 0 }"; 5].join("; "));
    let lines = format!("object \"a\" {{\n    {}\n}}\n", ["sphere 1 { at 0 1 0 }"; 5].join("\n    "));
    assert_eq!(formatted(&wide), lines);
    for (text, expected) in [
        ("a{b 1;c 2;}", "a { b 1; c 2 }\n"),
        ("a {\nb 1;c 2\nd 3 }", "a {\n    b 1; c 2\n    d 3\n}\n"),
        ("a { b; c {\nd } }", "a {\n    b\n    c {\n        d\n    }\n}\n"),
        ("a { }\nb {\n}", "a {}\nb {}\n"),
        ("\n\na 1;b 2\n\n\n\nc {\n\n d\n\n\n e\n\n}\n\n", "a 1; b 2\n\nc {\n    d\n\n    e\n}\n"),
        ("a  1   b = 2\tc=3", "a 1 b=2 c=3\n"),
        ("", ""),
        ("\n \n", ""),
    ] {
        assert_eq!(formatted(text), expected, "{text:?}");
    }
}

#[test]
fn comments_stay_where_they_are() {
    for (text, expected) in [
        ("a 1   // one\n  // two\nb", "a 1 // one\n// two\nb\n"),
        ("a {// main\nb\n// end\n}// after", "a { // main\n    b\n    // end\n} // after\n"),
        ("a /* x */ 1 ; /* y */b /* z */", "a /* x */ 1; /* y */ b /* z */\n"),
        ("/- a 1\nb /-2 /-  c=3 /- { d }{ e }", "/-a 1\nb /-2 /-c=3 /-{ d } { e }\n"),
        ("/- // why\na /- /* x */ 5 /- // y\n 6", "// why\n/-a /* x */ /-5 \\ // y\n    /-6\n"),
        ("a 1 \\ // more\n2 \\\n 3 \\\n\nb", "a 1 \\ // more\n    2 \\\n    3\n\nb\n"),
        ("a 1 \\ // end\n\nb", "a 1 // end\n\nb\n"),
        ("a b  /* x */ = /* y */  1", "a b  /* x */ = /* y */  1\n"),
        ("a {\n\t/* one\n\t   two */\n\tb\n}", "a {\n    /* one\n       two */\n    b\n}\n"),
        ("/-(type)a (t)1", "/-(type)a (t)1\n"),
    ] {
        assert_eq!(formatted(text), expected, "{text:?}");
    }
}

#[test]
fn comments_in_one_column_stay_in_one_column() {
    let text = "a 1      // one\nbc 2     // two\nd {      // three\n e 4 // four\n}\nf 1 // five\n";
    let expected = "a 1  // one\nbc 2 // two\nd {  // three\n    e 4 // four\n}\nf 1 // five\n";
    assert_eq!(formatted(text), expected);
}

#[test]
fn strings_of_several_lines_move_with_their_node() {
    let text = "a {\n  b \"\"\"\n      one;\n        two\n\n      \"\"\" c = #\"\"\"\n   x\n  \"\"\"#\n}\n";
    let expected =
        "a {\n    b \"\"\"\n        one;\n          two\n\n        \"\"\" c=#\"\"\"\n     x\n    \"\"\"#\n}\n";
    assert_eq!(formatted(text), expected);
    let less = "a {\n   b \"\"\"\n  one\n  \"\"\"\n}\n";
    assert_eq!(formatted(less), less.replace("   b", "    b"), "its lines have less than the indentation of the node");
}

#[test]
fn line_ends_and_marks_stay() {
    assert_eq!(formatted("\u{feff}a {\r\n\tb // c\r\n}"), "\u{feff}a {\r\n    b // c\r\n}\r\n");
}

#[test]
fn mistakes_of_syntax_are_refused_and_others_are_not() {
    for text in ["a {", "a }", "a \"b", "a 1.", "a(t)1", ";", "/*"] {
        let error = format("bad.kdl", text).expect_err(text);
        assert!(!error.mistakes().is_empty() && error.to_string().starts_with("bad.kdl has"), "{error}");
    }
    assert_eq!(formatted("misspelt   nonsense"), "misspelt nonsense\n");
    assert!(format("large.kdl", &" ".repeat((16 << 20) + 1)).is_err());
}

/// Random texts without mistakes of syntax.
struct Dice<'a>(std::slice::Iter<'a, u8>);

impl Dice<'_> {
    fn pick<'x>(&mut self, all: &[&'x str]) -> &'x str {
        all[self.0.next().map_or(0, |number| usize::from(*number)) % all.len()]
    }
    fn chance(&mut self, in_ten: u8) -> bool {
        self.0.next().is_some_and(|number| number % 10 < in_ten)
    }
    fn space(&mut self) -> &'static str {
        self.pick(&[" ", "  ", "\t", " /* c */ ", " /* c\n  d */ ", " \\\n", " \\ // j\n  ", " \\ /* k */ // l\n\t"])
    }
    fn line_space(&mut self) -> &'static str {
        self.pick(&["", "\n", " ", "\n\n\n", "// c\n", "/* d */", "\n  // e\n", "\t/* f\n\tg */\n", "\\\n", "\r\n"])
    }
    fn value(&mut self) -> &'static str {
        self.pick(&[
            "1",
            "-0.50",
            "1e3",
            "\"s; {\"",
            "#\"r\"#",
            "bare",
            "#true",
            "\"\"\"\n    m\n      n\n    \"\"\"",
            "\"j \\\n k\"",
        ])
    }
    fn entry(&mut self) -> String {
        let hidden = if self.chance(2) { format!("/-{}", self.line_space()) } else { String::new() };
        let name = if self.chance(4) { self.pick(&["a=", "b =", "c= ", "\"d\" /* e */ = "]) } else { "" };
        format!("{hidden}{name}{}", self.value())
    }
    fn braces(&mut self, depth: usize) -> String {
        format!("{{{}{}}}", self.line_space(), self.nodes(depth + 1))
    }
    fn node(&mut self, depth: usize) -> String {
        let hidden = if self.chance(1) { format!("/-{}", self.line_space()) } else { String::new() };
        let mut text = format!("{hidden}{}", self.pick(&["sphere", "n", "\"quoted name\"", "long-name-of-a-node"]));
        while self.chance(5) {
            text = format!("{text}{}{}", self.space(), self.entry());
        }
        if self.chance(2) {
            text = format!("{text}{}/-{}{}", self.space(), self.line_space(), self.braces(depth));
        }
        if depth < 5 && self.chance(4) {
            text = format!("{text}{}{}", self.space(), self.braces(depth));
        }
        text
    }
    fn nodes(&mut self, depth: usize) -> String {
        let mut text = String::new();
        while self.chance(7) {
            let end =
                self.pick(&["\n", ";", " // c\n", "  // c\n", "; ", " ;", " \\\n;", " \\ // c\n\n", "; /* e */ "]);
            text = format!("{text}{}{end}{}", self.node(depth), self.line_space());
        }
        if self.chance(3) { format!("{text}{}", self.node(depth)) } else { text }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn slow_random_texts_keep_nodes_and_comments(numbers in prop::collection::vec(any::<u8>(), 0..400)) {
        let text = Dice(numbers.iter()).nodes(0);
        let sorted = |text: &str| { let mut ink: Vec<char> = ink(text).chars().collect(); ink.sort_unstable(); ink };
        // What is between `/-` and its node moves before it.
        prop_assert_eq!(sorted(&formatted(&text)), sorted(&text));
        if !text.contains("/-") {
            prop_assert_eq!(ink(&formatted(&text)), ink(&text));
        }
    }

    /// Text of any kind is refused or formatted.
    #[test]
    fn slow_any_text(text in "[a1{};=/*\\-\"#\\\\ \n\r\t().é]{0,40}") {
        if format("any.kdl", &text).is_ok() {
            formatted(&text);
        }
    }
}
