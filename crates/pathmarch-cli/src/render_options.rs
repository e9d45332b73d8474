//! Options of the command line for the render settings of a scene.
//!
//! Names, help, ranges and types follow from the table [`settings::RENDER`], so that a setting added there is an option, too.

use crate::value_parsers;
use clap::builder::ValueParser;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use pathmarch_render::pathmarch_scene::RenderSettings;
use pathmarch_render::pathmarch_scene::settings::{self, Setting, SettingKind, SettingValue};
use std::ops::Range;

/// Name of the setting that may be given as a range.
const SAMPLES: &str = "samples";

/// Render settings that override those of a scene.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    values: Vec<(&'static str, SettingValue)>,
    sample_range: Option<Range<u32>>,
}

/// Value of an option: of the setting, or a range of samples.
#[derive(Clone, Debug)]
struct OptionValue {
    setting: Option<SettingValue>,
    samples: Option<Range<u32>>,
}

impl From<SettingValue> for OptionValue {
    fn from(value: SettingValue) -> Self {
        Self { setting: Some(value), samples: None }
    }
}

/// Parses a number of samples, a range `A..B` of them, or `A..B/N`: the range of a picture of N samples.
fn parse_samples(text: &str, limits: (u32, u32)) -> Result<OptionValue, String> {
    let whole = value_parsers::whole(limits);
    let Some((start, rest)) = text.split_once("..") else {
        return whole(text).map(|samples| SettingValue::Whole(samples).into());
    };
    let (end, of) = match rest.split_once('/') {
        Some((end, of)) => (end, Some(whole(of)?)),
        None => (rest, None),
    };
    let (start, end) = (value_parsers::whole((0, limits.1))(start)?, whole(end)?);
    if start >= end || of.is_some_and(|of| end > of) {
        return Err("a range is A..B with A below B, or A..B/N with B at most N".to_owned());
    }
    Ok(OptionValue { setting: of.map(SettingValue::Whole), samples: Some(start..end) })
}

impl RenderOptions {
    /// Overrides settings of a scene.
    pub fn apply(&self, render: &mut RenderSettings) {
        for (name, value) in &self.values {
            // The parser has checked the value.
            render.set(name, *value);
        }
    }

    /// Range of the samples to render, if only a part of them.
    pub fn sample_range(&self) -> Option<Range<u32>> {
        self.sample_range.clone()
    }

    /// Whether the setting of this name is overridden.
    pub fn overrides(&self, name: &str) -> bool {
        self.values.iter().any(|(other, _)| *other == name)
    }
}

/// Parser of a setting's value; `None` for kinds that are no options.
fn parser(setting: &Setting) -> Option<ValueParser> {
    Some(match setting.kind {
        SettingKind::Whole { range, .. } if setting.name == SAMPLES => {
            ValueParser::new(move |text: &str| parse_samples(text, range))
        }
        SettingKind::Number { range, .. } => {
            let parse = value_parsers::number(range);
            ValueParser::new(move |text: &str| parse(text).map(|value| OptionValue::from(SettingValue::Number(value))))
        }
        SettingKind::Whole { range, .. } => {
            let parse = value_parsers::whole(range);
            ValueParser::new(move |text: &str| parse(text).map(|value| OptionValue::from(SettingValue::Whole(value))))
        }
        SettingKind::Size { .. } => ValueParser::new(|text: &str| {
            value_parsers::size(text).map(|[width, height]| OptionValue::from(SettingValue::Size((width, height))))
        }),
        SettingKind::Choice { names, .. } => ValueParser::new(move |text: &str| {
            let name = names().into_iter().find(|name| *name == text);
            name.map(|name| OptionValue::from(SettingValue::Choice(name)))
                .ok_or_else(|| format!("expected one of {}", names().join(", ")))
        }),
        _ => return None,
    })
}

/// Help of a setting: its documentation, range and default.
fn help(setting: &Setting) -> String {
    let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
    let doc = setting.doc.trim_end_matches('.');
    let part = if setting.name == SAMPLES { "; or a part of them, A..B or A..B/N" } else { "" };
    format!("{doc} ({}{unit}){part} [default: the scene's]", setting.kind.range_in_words())
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
        let value = |setting: &Setting| {
            let given = matches.get_one::<OptionValue>(setting.name)?;
            Some((setting.name, given.setting?))
        };
        let sample_range = matches.get_one::<OptionValue>(SAMPLES).and_then(|given| given.samples.clone());
        Ok(Self { values: settings::RENDER.iter().filter_map(value).collect(), sample_range })
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
    fn samples_may_be_a_range() {
        let command = RenderOptions::augment_args(Command::new("test"));
        let parse = |text: &str| {
            let matches = command.clone().try_get_matches_from(["test", "--samples", text]).ok()?;
            let options = RenderOptions::from_arg_matches(&matches).ok()?;
            let mut render = RenderSettings::DEFAULT;
            options.apply(&mut render);
            Some((options.sample_range(), options.overrides(SAMPLES).then_some(render.samples)))
        };
        assert_eq!(parse("12"), Some((None, Some(12))));
        assert_eq!(parse("3..12"), Some((Some(3..12), None)));
        assert_eq!(parse("0..12/64"), Some((Some(0..12), Some(64))));
        for wrong in ["12..3", "3..3", "3..12/11", "..3", "3..", "a..b", "3..12/"] {
            assert_eq!(parse(wrong), None, "{wrong}");
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
