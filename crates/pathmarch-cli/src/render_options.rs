//! Options of the command line for the render settings of a scene.
//!
//! Names, help, ranges and types follow from the table [`settings::RENDER`], so that a setting added there is an option, too.

use crate::value_parsers;
use clap::builder::ValueParser;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use pathmarch_render::pathmarch_scene::RenderSettings;
use pathmarch_render::pathmarch_scene::settings::{self, Setting, SettingKind, SettingValue};

/// Render settings that override those of a scene.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    values: Vec<(&'static str, SettingValue)>,
}

impl RenderOptions {
    /// Overrides settings of a scene.
    pub fn apply(&self, render: &mut RenderSettings) {
        for (name, value) in &self.values {
            // The parser has checked the value.
            render.set(name, *value);
        }
    }

    /// Whether the setting of this name is overridden.
    pub fn overrides(&self, name: &str) -> bool {
        self.values.iter().any(|(other, _)| *other == name)
    }
}

/// Parser of a setting's value; `None` for kinds that are no options.
fn parser(setting: &Setting) -> Option<ValueParser> {
    Some(match setting.kind {
        SettingKind::Number { range, .. } => {
            let parse = value_parsers::number(range);
            ValueParser::new(move |text: &str| parse(text).map(SettingValue::Number))
        }
        SettingKind::Whole { range, .. } => {
            let parse = value_parsers::whole(range);
            ValueParser::new(move |text: &str| parse(text).map(SettingValue::Whole))
        }
        SettingKind::Size { .. } => ValueParser::new(|text: &str| {
            value_parsers::size(text).map(|[width, height]| SettingValue::Size((width, height)))
        }),
        SettingKind::Choice { names, .. } => ValueParser::new(move |text: &str| {
            let name = names().into_iter().find(|name| *name == text);
            name.map(SettingValue::Choice).ok_or_else(|| format!("expected one of {}", names().join(", ")))
        }),
        _ => return None,
    })
}

/// Help of a setting: its documentation, range and default.
fn help(setting: &Setting) -> String {
    let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
    let doc = setting.doc.trim_end_matches('.');
    format!("{doc} ({}{unit}) [default: the scene's]", setting.kind.range_in_words())
}

/// Name of a value in the usage of an option.
fn value_name(setting: &Setting) -> &'static str {
    match setting.kind {
        SettingKind::Size { .. } => "WxH",
        SettingKind::Choice { .. } => "NAME",
        _ => "N",
    }
}

impl Args for RenderOptions {
    fn augment_args(command: Command) -> Command {
        settings::RENDER.iter().fold(command, |command, setting| {
            let Some(parser) = parser(setting) else { return command };
            let argument = Arg::new(setting.name).long(setting.name).value_name(value_name(setting));
            command.arg(argument.help(help(setting)).value_parser(parser).allow_hyphen_values(true))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for RenderOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let value = |setting: &Setting| Some((setting.name, *matches.get_one::<SettingValue>(setting.name)?));
        Ok(Self { values: settings::RENDER.iter().filter_map(value).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_render_setting_is_an_option() {
        let command = RenderOptions::augment_args(Command::new("test"));
        for setting in settings::RENDER {
            let value = match setting.kind {
                SettingKind::Number { .. } => "0.5".to_owned(),
                SettingKind::Whole { range, .. } => range.1.to_string(),
                SettingKind::Size { .. } => "640x360".to_owned(),
                SettingKind::Choice { names, .. } => names().last().expect("a name").to_string(),
                _ => panic!("{} is no option", setting.name),
            };
            let arguments = ["test".to_owned(), format!("--{}", setting.name), value];
            let matches = command.clone().try_get_matches_from(arguments).expect(setting.name);
            let options = RenderOptions::from_arg_matches(&matches).expect("no option is required");
            let mut render = RenderSettings::DEFAULT;
            options.apply(&mut render);
            assert!(options.overrides(setting.name));
            assert_ne!(render.get(setting.name), RenderSettings::DEFAULT.get(setting.name), "{}", setting.name);
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        let command = RenderOptions::augment_args(Command::new("test"));
        for [name, value] in [["--samples", "0"], ["--size", "0x10"], ["--detail", "nan"], ["--tonemap", "film"]] {
            let error = command.clone().try_get_matches_from(["test", name, value]).expect_err(name);
            assert!(error.to_string().contains(value), "{error}");
        }
    }
}
