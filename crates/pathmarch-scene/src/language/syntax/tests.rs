//! The reader against the `kdl` crate: the same trees of whatever both accept, and what neither accepts.

use super::read;
use crate::language::diagnostics::report::Report;
use crate::language::tree::{Block, Value};
use kdl::{KdlDocument, KdlValue};
use proptest::prelude::*;
use std::fmt::Write;

/// A tree as text, the same for both readers.
fn ours(block: &Block, out: &mut String) {
    for node in &block.nodes {
        let _ = write!(out, "{:?}", node.name.value);
        // The order of properties among themselves is kept; a repeated one is the scene's business.
        for entry in &node.entries {
            let name = entry.name.as_ref().map(|name| name.value.as_ref());
            let value = match &entry.value {
                Value::Text(text) => format!("{text:?}"),
                Value::Number(number) => format!("{number:?}"),
                Value::Bool(value) => format!("#{value}"),
                Value::Null => "#null".to_owned(),
                Value::Bad => "bad".to_owned(),
            };
            let _ = write!(out, " {name:?}={value}");
        }
        out.push('{');
        if let Some(children) = &node.children {
            ours(children, out);
        }
        out.push('}');
    }
}

fn theirs(document: &KdlDocument, out: &mut String) {
    for node in document.nodes() {
        let _ = write!(out, "{:?}", node.name().value());
        for entry in node.entries() {
            let name = entry.name().map(|name| name.value());
            let value = match entry.value() {
                KdlValue::String(text) => format!("{text:?}"),
                KdlValue::Integer(number) => format!("{:?}", *number as f64),
                KdlValue::Float(number) => format!("{number:?}"),
                KdlValue::Bool(value) => format!("#{value}"),
                KdlValue::Null => "#null".to_owned(),
            };
            let _ = write!(out, " {name:?}={value}");
        }
        out.push('{');
        if let Some(children) = node.children() {
            theirs(children, out);
        }
        out.push('}');
    }
}

/// Our tree; `None` after a mistake other than a type annotation.
fn read_ours(text: &str) -> Option<String> {
    let mut report = Report::new("test", text);
    let block = read(text, &mut report);
    let error = report.into_error();
    let bad = error.mistakes().iter().any(|mistake| mistake.code != "pathmarch::annotation");
    let mut out = String::new();
    ours(&block?, &mut out);
    (!bad).then_some(out)
}

fn read_theirs(text: &str) -> Option<String> {
    let mut out = String::new();
    theirs(&KdlDocument::parse_v2(text).ok()?, &mut out);
    Some(out)
}

#[test]
fn both_read_the_same() {
    for text in [
        "a",
        "a;b;c",
        "a 1 2.5 -3 +4 1e3 1.5E-3 1_000.5_0 0xfF 0o17 0b1010_1 -0x10",
        "a #true #false #null #inf #-inf",
        "a b=1 c=\"d\" e = 2 \"f g\"=3",
        "a { b { c }; d }\ne",
        "a {\n  b\n\n  c\n}",
        "\"a b\" \"c\\n\\t\\\"\\\\\\s\\u{1F600}\\b\\f\\r\"",
        "a #\"b\\n\"# ##\"c\"#d\"##",
        "a \"\"\"\n    one\n      two\n\n    three\n    \"\"\"",
        "a \"\"\"\n  one \\\n     joined\n  \"quoted\" \\\"\"\" end\n  \"\"\"",
        "a #\"\"\"\n\tx\\n\n\ty\n\t\"\"\"#",
        "a \"joined \\\n     here\"",
        "// comment\na // another\n/* b /* c */ d */ e /* f */ 1 /* g */ 2",
        "a \\\n 1 \\ // comment\n 2\nb",
        "/- a 1 { b }\nc",
        "a /- 1 2 /- b=3 c=4",
        "a /- { b } { c } /- { d }",
        "a {} \nb { } ; c",
        "/-a\n/-b\nc",
        "- -a --b .c -.d + ~x a,b <> ?",
        "a 1;\n;".trim_end_matches(";"),
        "\u{feff}a 1",
        "(t)a (u)1 b=(v)2",
        "a\u{a0}1\u{3000}2\u{2028}b\r\nc\rd\u{85}e",
        "é ünï=\"ö\" 日本",
        "",
        "\n\n  // nothing\n",
    ] {
        let (ours, theirs) = (read_ours(text), read_theirs(text));
        assert!(theirs.is_some(), "the crate refuses {text:?}");
        assert_eq!(ours, theirs, "{text:?}");
    }
}

#[test]
fn neither_reads() {
    for text in [
        "a {",
        "a }",
        "{ }",
        "a \"b",
        "a \"\"\"b\"\"\"",
        "a #\"b\"",
        "/* a",
        "a 1x",
        "a 1.",
        "a .5",
        "a 1..2",
        "a 0xg",
        "a true",
        "a #yes",
        "a b=",
        "a =1",
        "a 1=2",
        "a [1]",
        "a \"\\q\"",
        "a \"\\u{110000}\"",
        "a \"b\"c",
        "1 2",
        "#true",
        "a \\ b",
        "(a",
        "(1)b",
        "/-",
        "a { } b",
        "a {} {}",
        "a \"\"\"\n  b\n c\n  \"\"\"",
    ] {
        assert_eq!(read_ours(text), None, "{text:?}");
        assert_eq!(read_theirs(text), None, "the crate reads {text:?}");
    }
}

/// Pieces that texts are made of; few enough nested `/-` that the crate does not take minutes.
fn piece() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "a",
        "b",
        " ",
        " ",
        " ",
        "\n",
        ";",
        "{",
        "}",
        "{ c }",
        "1",
        "-2.5",
        "0x1f",
        "1e-3",
        "\"s\"",
        "\"t\\n\"",
        "#\"r\"#",
        "=",
        "k=1",
        " v=\"w\"",
        "/-",
        "// x\n",
        "/* y */",
        "\\\n",
        "#true",
        "#null",
        "(t)",
        "\"",
        "#",
        ".",
        "-",
        "\r\n",
        "é",
        "\"\"\"\n  m\n  \"\"\"",
    ])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Texts that both accept have the same trees.
    #[test]
    fn agrees_with_the_crate(pieces in prop::collection::vec(piece(), 0..14)) {
        let text = pieces.concat();
        // The crate loses braces that follow a comment behind what `/-` takes out, and what follows `#true/-value`.
        let lost = text.contains("/-") && text.contains("*/{") || text.contains("#true/-") || text.contains("#null/-");
        if let (Some(ours), Some(theirs)) = (read_ours(&text), read_theirs(&text))
            && !lost
        {
            prop_assert_eq!(ours, theirs, "{:?}", text);
        }
    }
}
