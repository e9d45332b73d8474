//! The reference as a page of Markdown, for manuals.

use super::{NODES, OTHER_NODES, PROPERTIES, TABLES};
use crate::language::formulas::expression::functions;
use crate::materials::{self, MaterialParam};
use crate::settings::{self, Setting, SettingKind};
use crate::textures;
use pathmarch_field::{Info, Param, Solid, registry};

/// Every word of the scene language with its parameters, ranges, defaults and units.
pub fn page() -> String {
    let mut page = String::from(
        "# Words of the scene language\n\nPrinted by `pathmarch reference` from the tables that read scenes. \
         [The scene language](scene-language.md) explains how they work together.\n",
    );
    nodes(&mut page);
    solids(&mut page);
    section(&mut page, "Placement", "In the braces of every shape, operator and texture.");
    setting_rows(&mut page, settings::PLACEMENT);
    setting_rows(&mut page, std::slice::from_ref(&settings::NORMAL));
    materials(&mut page);
    textures(&mut page);
    section(&mut page, "Functions of formulas", "");
    let names: Vec<String> = functions().map(|name| format!("`{name}`")).collect();
    paragraph(&mut page, &names.join(" "));
    page
}

fn paragraph(page: &mut String, text: &str) {
    if !text.is_empty() {
        page.extend(["\n", text, "\n"]);
    }
}

fn heading(page: &mut String, level: usize, title: &str, doc: &str) {
    page.extend(["\n", &"#".repeat(level), " ", title, "\n"]);
    paragraph(page, doc);
}

fn section(page: &mut String, title: &str, doc: &str) {
    heading(page, 2, title, doc);
}

/// Starts a table.
fn table(page: &mut String, columns: &[&str]) {
    let rule = vec!["---"; columns.len()].join("|");
    page.extend(["\n| ", &columns.join(" | "), " |\n|", &rule, "|\n"]);
}

fn row(page: &mut String, cells: &[&str]) {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    page.extend(["| ", &cells.join(" | "), " |\n"]);
}

/// Nodes at the top of a file, with their settings.
fn nodes(page: &mut String) {
    section(page, "Nodes of a file", "");
    table(page, &["Node", "Description"]);
    NODES.iter().for_each(|(name, doc)| row(page, &[&format!("`{name}`"), doc]));
    let in_braces = TABLES.iter().filter(|(owner, _)| *owner != super::PLACEMENTS);
    let of_others = |(owner, _): &&(&str, &[Setting])| TABLES.iter().all(|(other, _)| other != owner);
    let mut last = "";
    for (owner, settings) in in_braces.chain(PROPERTIES.iter().filter(of_others)) {
        if *owner != last {
            heading(page, 3, &format!("Settings of {owner}"), "");
        }
        setting_rows(page, settings);
        last = owner;
    }
    heading(page, 3, "Other nodes", "");
    table(page, &["Node", "In", "Description"]);
    OTHER_NODES.iter().for_each(|(owner, name, doc)| row(page, &[&format!("`{name}`"), owner, doc]));
}

fn setting_rows(page: &mut String, settings: &[Setting]) {
    table(page, &["Setting", "Example", "Range", "Unit", "Description"]);
    for setting in settings {
        let example = format!("`{}`", setting.example);
        let range = match setting.kind {
            SettingKind::Properties(of) => {
                of.iter().map(|one| format!("`{}`", one.name)).collect::<Vec<_>>().join(", ")
            }
            _ => setting.kind.range_in_words(),
        };
        row(page, &[&format!("`{}`", setting.name), &example, &range, setting.unit, setting.doc]);
    }
}

/// Shapes, profiles, operators and modifiers.
fn solids(page: &mut String) {
    let is_profile = |solid: &Solid| solid.info().profile;
    let all = || registry::solids();
    let shapes = || all().filter(|solid| !solid.is_operator());
    solid_section(page, "Shapes", "", shapes().filter(|solid| !is_profile(solid)));
    solid_section(page, "Profiles", "Planar shapes, for `extrude` and `revolve`.", shapes().filter(is_profile));
    let blending = "Their children are in braces. Those that blend have these properties:";
    section(page, "Operators", blending);
    setting_rows(page, settings::BLEND);
    all().filter(|solid| matches!(solid, Solid::Operator(_))).for_each(|solid| describe(page, solid));
    let modifiers = all().filter(|solid| matches!(solid, Solid::Modifier(_)));
    solid_section(page, "Modifiers", "They change the union of their children, which are in braces.", modifiers);
}

fn solid_section<'s>(page: &mut String, title: &str, doc: &str, solids: impl Iterator<Item = Solid<'s>>) {
    section(page, title, doc);
    solids.for_each(|solid| describe(page, solid));
}

fn describe(page: &mut String, solid: Solid) {
    let Info { name, doc, source, exact, .. } = solid.info();
    heading(page, 3, name, doc);
    let distance = if *exact { "Exact distance." } else { "Lower bound of the distance." };
    paragraph(page, &format!("{distance} Source: {source}."));
    parameters(page, solid.params());
}

fn parameters(page: &mut String, params: &[Param]) {
    if params.is_empty() {
        return;
    }
    table(page, &["Parameter", "Default", "Range", "Unit", "Description"]);
    for param in params {
        let name = format!("`{}`", param.name);
        row(page, &[&name, &param.default_in_words(), &param.range_in_words(), param.unit.name(), &param.doc]);
    }
}

fn materials(page: &mut String) {
    section(page, "Materials", "The first parameter follows the name of the kind, the others are nodes beside it.");
    for kind in materials::kinds() {
        heading(page, 3, kind.name, kind.doc);
        paragraph(page, &format!("Source: {}.", kind.source.trim_end_matches('.')));
        table(page, &["Parameter", "Kind", "Default", "Range", "Description"]);
        kind.params.iter().for_each(|param| material_row(page, param));
    }
}

fn material_row(page: &mut String, param: &MaterialParam) {
    let kind = param.kind.name();
    let (default, range) = (param.default_in_words(), param.range_in_words());
    row(page, &[&format!("`{}`", param.name()), kind, &default, &range, &param.spec.doc]);
}

fn textures(page: &mut String) {
    section(page, "Textures", "In the braces of a parameter of a material, or of `bump`.");
    for kind in textures::kinds() {
        heading(page, 3, kind.name, kind.doc);
        parameters(page, kind.params);
    }
    heading(page, 3, textures::PICTURE, "Picture of a .png or .jpg file.");
    parameters(page, std::slice::from_ref(&textures::PICTURE_SIZE));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::words;

    #[test]
    fn the_page_has_every_word() {
        let page = page();
        for word in words() {
            let is_there = page.contains(&format!("`{word}`")) || page.contains(&format!("### {word}\n"));
            assert!(is_there, "{word}");
        }
        let columns = |line: &str| line.replace("\\|", "").matches('|').count();
        let rows: Vec<&str> = page.lines().filter(|line| line.starts_with('|')).collect();
        assert!(rows.len() > 200 && rows.iter().all(|row| columns(row) >= 3), "{}", rows.len());
    }
}
