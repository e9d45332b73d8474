//! Answers for text editors: completion, help, colours, symbols, declarations.

use pathmarch_scene::language_service::{CompletionKind, Completions, OpenText, SymbolKind};

const SCENE: &str = "pathmarch 1
param spin 30 min=0 doc=\"Turn of the mill.\"
camera { position 0 1.5 6; target 0 1 0 }
sky \"day\" haze=2 { ground 0.3 0.25 0.2 }
material \"gold\" { metal 1 0.78 0.34; roughness 0.2 }
material \"red paint\" { principled \"#c8691e\" }
material \"lamp\" { emit 15 13.6 7.5 }
shape \"bolt\" {
    param head 0.2 doc=\"Radius of the head.\"
    cylinder head 1
}
object \"mill\" material=\"gold\" {
    union smooth=0.1 {
        box 2 0.2 0.4 { rotate 0 \"spin + 90*t\" 0 }
        bolt head=0.3
    }
}
";

/// Opens a text whose `|` is the place that is asked for.
fn open(text: &str) -> (OpenText, usize) {
    let at = text.find('|').expect("a place");
    (OpenText::new("scene.kdl", text.replacen('|', "", 1), false), at)
}

fn completions(text: &str) -> Completions {
    let (mut open, at) = open(text);
    open.completions(at)
}

fn labels(text: &str) -> Vec<String> {
    completions(text).list.into_iter().map(|completion| completion.label).collect()
}

/// The scene with a text in place of another; `|` in it is the place that is asked for.
fn with(old: &str, new: &str) -> String {
    assert!(SCENE.contains(old), "{old}");
    SCENE.replacen(old, new, 1)
}

fn hover(text: &str) -> String {
    let (open, at) = open(text);
    let hover = open.hover(at).unwrap_or_else(|| panic!("no help in {text}"));
    hover.meanings.iter().map(|meaning| meaning.markdown()).collect::<Vec<_>>().join("\n\n")
}

#[test]
fn names_fit_their_place() {
    for (old, new, fitting, foreign) in [
        ("camera {", "| camera {", &["camera", "material", "object", "include"][..], &["sphere", "fov"][..]),
        ("target 0 1 0 }", "target 0 1 0; f| }", &["fov", "lens", "up"], &["sphere", "irradiance"]),
        ("roughness 0.2", "rou|", &["roughness", "edge", "bump"], &["transmission", "fov"]),
        ("bolt head=0.3", "sph|", &["sphere", "union", "bolt", "at"], &["fov", "emit"]),
        ("bolt head=0.3", "sphere 1 { | }", &["at", "rotate", "scale"], &["sphere", "fov"]),
        ("metal 1 0.78 0.34", "metal { | }", &["fbm", "wood", "picture"], &["metal"]),
        ("ground 0.3 0.25 0.2", "|", &["ground"], &["zenith"]),
        ("haze=2", "ha|", &["haze", "elevation", "sun"], &["ground"]),
        ("smooth=0.1", "|", &["smooth", "profile", "material"], &["radius"]),
        ("smooth=0.1", "profile=|", &["soft", "round", "chamfer", "stairs"], &["smooth"]),
        ("head=0.3", "| ", &["head", "material", "spin", "t", "pi"], &["smooth"]),
        ("material=\"gold\"", "material=\"|\"", &["gold", "red paint", "lamp"], &["t"]),
        ("material=\"gold\"", "material=|", &["gold", "red paint", "lamp"], &[]),
        ("90*t", "90*s|", &["spin", "sin", "frame"], &["gold", "head"]),
        ("cylinder head 1", "cylinder h| 1", &["head", "spin"], &["gold"]),
        ("haze=2", "sun=|", &["#true", "#false"], &["haze"]),
    ] {
        let found = labels(&with(old, new));
        let has = |name: &&&str| found.iter().any(|label| label == **name);
        assert!(fitting.iter().all(|name| has(&name)), "{new}: {fitting:?} in {found:?}");
        assert!(!foreign.iter().any(|name| has(&name)), "{new}: {foreign:?} not in {found:?}");
    }
    for nowhere in [with("param spin", "// pa|\nparam spin"), with("\"gold\" {", "\"go|ld\" {"), with("0.78", "0.7|8")]
    {
        assert_eq!(labels(&nowhere).into_iter().filter(|label| label == "sphere").count(), 0, "{nowhere}");
    }
}

#[test]
fn a_completion_replaces_the_word_and_has_help() {
    let text = with("bolt head=0.3", "sphe|re 1");
    let found = completions(&text);
    assert_eq!(&text.replacen('|', "", 1)[found.range.clone()], "sphere");
    let sphere = found.list.iter().find(|completion| completion.label == "sphere").expect("there");
    assert_eq!((sphere.kind, sphere.insert.as_str()), (CompletionKind::Node, "sphere ${1:1}"));
    assert!(sphere.help.as_ref().is_some_and(|help| help.title == "shape `sphere`"), "{sphere:?}");
    let bolt = found.list.iter().find(|completion| completion.label == "bolt").expect("there");
    assert!(bolt.help.as_ref().is_some_and(|help| help.details[0].contains("Radius of the head.")), "{bolt:?}");

    let text = with("material=\"gold\"", "material=\"red pa|\"");
    let found = completions(&text);
    assert_eq!(&text.replacen('|', "", 1)[found.range], "red pa");
    let text = with("material=\"gold\"", "material=|");
    let paint = completions(&text).list.into_iter().find(|completion| completion.label == "red paint").expect("there");
    assert_eq!(paint.insert, "\"red paint\"");
    let text = with("90*t", "90*sp|");
    assert_eq!(&text.replacen('|', "", 1)[completions(&text).range], "sp");
}

/// A hundred mistakes before the place do not matter.
#[test]
fn completion_works_in_a_text_full_of_mistakes() {
    let text = with("bolt head=0.3", &format!("{}\nsph|", "wrong\n".repeat(200)));
    assert!(labels(&text).contains(&"sphere".to_owned()));
}

#[test]
fn every_word_is_explained_where_it_stands() {
    for (old, new, expected) in [
        ("camera {", "cam|era {", "**node `camera`**"),
        ("position", "po|sition", "**`position` of camera**"),
        ("roughness", "rough|ness", "**`roughness` of material `metal`**"),
        ("metal 1", "met|al 1", "**material `metal`**"),
        ("haze=2", "ha|ze=2", "**`haze` of sky \"day\"**"),
        ("smooth", "smo|oth", "Width over which"),
        ("box 2 0.2", "box 2 0|.2", "**`y` of `box`**"),
        ("rotate 0", "rot|ate 0", "**`rotate` of shapes and operators**"),
        ("bolt head", "bo|lt head", "Radius of the head."),
        ("head=0.3", "he|ad=0.3", "Radius of the head."),
        ("\"spin + 90", "\"sp|in + 90", "Turn of the mill."),
        ("=\"gold\"", "=\"go|ld\"", "**material `gold`**"),
        ("cylinder head 1", "cylinder he|ad 1", "Radius of the head."),
    ] {
        let help = hover(&with(old, new));
        assert!(help.contains(expected), "{new}: {help}");
        assert_eq!(help.matches("**").count(), 2, "{new} means one thing: {help}");
    }
}

#[test]
fn colours_are_those_that_are_read_as_colours() {
    let open = OpenText::new("scene.kdl", SCENE, false);
    let texts: Vec<&str> = open.colours().into_iter().map(|colour| &SCENE[colour.range]).collect();
    assert_eq!(texts, ["0.3 0.25 0.2", "1 0.78 0.34", "\"#c8691e\"", "15 13.6 7.5"]);
}

#[test]
fn symbols_are_what_the_text_declares() {
    let open = OpenText::new("scene.kdl", SCENE, false);
    let symbols = open.symbols();
    let found: Vec<(&str, SymbolKind)> = symbols.iter().map(|symbol| (symbol.name.as_str(), symbol.kind)).collect();
    assert!(
        found.contains(&("gold", SymbolKind::Material)) && found.contains(&("bolt", SymbolKind::Shape)),
        "{found:?}"
    );
    assert!(
        found.contains(&("mill", SymbolKind::Object)) && found.contains(&("camera", SymbolKind::Camera)),
        "{found:?}"
    );
    let mill = symbols.iter().find(|symbol| symbol.name == "mill").expect("there");
    assert_eq!(&SCENE[mill.name_range.clone()], "\"mill\"");
    assert!(SCENE[mill.range.clone()].starts_with("object") && SCENE[mill.range.clone()].ends_with('}'));
}

#[test]
fn names_lead_to_their_declaration() {
    for (old, new, declared) in [
        ("=\"gold\"", "=\"go|ld\"", "\"gold\""),
        ("bolt head", "b|olt head", "\"bolt\""),
        ("\"spin + 90", "\"spi|n + 90", "spin"),
        ("cylinder head", "cylinder h|ead", "head"),
    ] {
        let (open, at) = open(&with(old, new));
        let definition = open.definition(at).unwrap_or_else(|| panic!("{new}"));
        assert_eq!((&definition.file, &SCENE[definition.range]), (&None, declared), "{new}");
    }
    let (open, at) = open(&with("box 2", "b|ox 2"));
    assert_eq!(open.definition(at), None, "shapes of the language are declared nowhere");
}

#[test]
fn declarations_are_found_in_included_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("parts.kdl"), "pathmarch 1\ninclude \"deep/metals.kdl\"\n").expect("written");
    std::fs::create_dir(path("deep")).expect("made");
    std::fs::write(path("deep/metals.kdl"), "pathmarch 1\nmaterial \"steel\" { metal 0.6 }\n").expect("written");
    let text = "pathmarch 1\ninclude \"parts.kdl\"\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\n\
                object \"a\" material=\"steel\" { sphere 1 }\n";
    let open = OpenText::new(path("main.kdl").display().to_string(), text, false);
    assert_eq!(open.mistakes().len(), 0, "{:?}", open.mistakes());
    let definition = open.definition(text.find("steel").expect("there")).expect("found");
    let (file, other) = definition.file.expect("another file");
    assert!(file.ends_with("deep/metals.kdl"), "{file:?}");
    assert_eq!(&other[definition.range], "\"steel\"");
    assert!(
        open.hover(text.find("steel").expect("there")).is_some_and(|hover| hover.meanings[0].doc.contains("`metal`"))
    );
    let included = open.definition(text.find("parts").expect("there")).expect("found");
    assert!(included.file.is_some_and(|(file, _)| file.ends_with("parts.kdl")));
}

/// No place of a text makes anything panic, whether the text is right or broken off there.
#[test]
fn every_place_has_answers() {
    for at in (0..=SCENE.len()).step_by(3) {
        for text in [SCENE, &SCENE[..at]] {
            let mut open = OpenText::new("scene.kdl", text.replace("sky \"day\" haze=2", "sky \"gradient\""), false);
            let at = at.min(open.text().len());
            let completions = open.completions(at);
            assert!(completions.range.contains(&at) || completions.range.end == at, "{at}");
            if let Some(hover) = open.hover(at) {
                assert!(hover.range.start <= at && at <= hover.range.end, "{at}");
            }
            open.definition(at);
            open.symbols();
            open.colours();
        }
    }
}

#[test]
fn misspelt_names_have_a_suggestion() {
    let open = OpenText::new("scene.kdl", with("roughness", "roughnes").replace("=\"gold\"", "=\"glod\""), false);
    let suggestions: Vec<Option<&str>> = open.mistakes().iter().map(|mistake| mistake.suggestion.as_deref()).collect();
    assert_eq!(suggestions, [Some("roughness"), Some("gold")]);
}

/// Editors of documents get the same answers, and the document keeps what it has read.
#[test]
fn documents_answer_as_texts_do() {
    use pathmarch_scene::document::Document;
    use pathmarch_scene::language_service::in_document;
    let (mut open, at) = open(&with("bolt head=0.3", "sph|"));
    let mut document = Document::new("scene.kdl", open.text());
    let before = document.revision();
    assert_eq!(in_document::completions(&mut document, at), open.completions(at));
    assert!(in_document::completions(&mut document, at).list.iter().any(|name| name.label == "sphere"));
    assert_eq!(in_document::hover(&mut document, at - 1), open.hover(at - 1));
    assert_eq!(in_document::colours(&mut document), open.colours());
    assert_eq!((document.revision(), document.text()), (before, open.text()));
}
