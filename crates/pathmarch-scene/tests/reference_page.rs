//! The reference page against the tables of settings.

use pathmarch_scene::RenderSettings;
use pathmarch_scene::settings::{RENDER, SettingValue};

/// Default of a setting as the page has it.
fn default(name: &str) -> String {
    match RenderSettings::DEFAULT.get(name).expect("a setting") {
        SettingValue::Absent => "none".to_owned(),
        SettingValue::Number(number) => number.to_string(),
        SettingValue::Whole(number) => number.to_string(),
        SettingValue::Size((width, height)) => format!("{width} {height}"),
        SettingValue::Choice(name) => name.to_owned(),
    }
}

/// Every render setting has a line with its range, default and help, in the order of the table. More text may follow.
#[test]
fn render_settings_are_those_of_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scene-language.md");
    let page = std::fs::read_to_string(path).expect("the page");
    let section = page.split("## Render settings").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("there");
    let rows: Vec<&str> = section.lines().filter(|line| line.starts_with("| `")).collect();
    assert_eq!(rows.len(), RENDER.len());
    for (row, setting) in rows.into_iter().zip(RENDER) {
        let range = setting.kind.range_in_words();
        let expected = format!("| `{}` | {range} | {} | {}", setting.name, default(setting.name), setting.doc);
        assert!(row.starts_with(&expected), "expected {expected}\nfound    {row}");
    }
}
