//! The settings of cameras, rendering, lights, skies and placement: their words, ranges, defaults and documentation.
//!
//! Written once: the parser reads by these tables and [`crate::document`] makes controls of them. Shapes, operators and
//! materials bring their own, in their registries.

use super::arguments::{
    Range, Settings, choice, colour, direction, flag, in_range, named, numbers, properties, string, whole,
    whole_numbers,
};
use super::report::Report;
use super::tree::{Entry, Node};
use crate::atmosphere::SUN_ANGLE;
use crate::limits;
use crate::render_settings::{Caustics, DETAIL, Sampler, Tonemap};
use pathmarch_field::BlendProfile;
use pathmarch_field::blend::{DEFAULT_STEPS, MAX_STEPS};

/// What stands behind a setting's word.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    /// A number; without default, its absence means something of its own.
    Number { range: Range, default: Option<f32> },
    /// A whole number.
    Whole { range: (u32, u32), default: u32 },
    /// Width and height.
    Size { range: (u32, u32), default: [u32; 2] },
    /// Three numbers.
    Triple { default: [f32; 3] },
    /// Three numbers that are not all zero.
    Direction { default: [f32; 3] },
    /// A colour of channels from 0 to `max`; without default, its absence means something of its own.
    Colour { max: f32, default: Option<[f32; 3]> },
    /// One of these words, the first when absent.
    Choice { words: fn() -> Vec<&'static str> },
    /// A truth value.
    Flag { default: bool },
    /// Properties of its own.
    Properties(&'static [Setting]),
}

/// One setting.
#[derive(Clone, Copy)]
pub(crate) struct Setting {
    /// Its word.
    pub(crate) name: &'static str,
    pub(crate) form: Form,
    /// Whether it must be given; its default then is what a new node says.
    pub(crate) required: bool,
    /// As printed after a number.
    pub(crate) unit: &'static str,
    /// As it is written; what to begin with where there is no default.
    pub(crate) example: &'static str,
    /// One sentence for people.
    pub(crate) doc: &'static str,
}

const fn setting(
    name: &'static str,
    form: Form,
    unit: &'static str,
    example: &'static str,
    doc: &'static str,
) -> Setting {
    Setting { name, form, required: false, unit, example, doc }
}

impl Setting {
    const fn required(self) -> Self {
        Self { required: true, ..self }
    }
    /// How it is used, as in "`at x y z`".
    fn usage(&self) -> String {
        match self.form {
            Form::Triple { .. } | Form::Direction { .. } => format!("`{} x y z`", self.name),
            _ => format!("`{}`", self.example),
        }
    }
}

const fn number(range: Range, default: f32) -> Form {
    Form::Number { range, default: Some(default) }
}
const OPTIONAL: Form = Form::Number { range: Range::POSITIVE, default: None };
const fn radiance(default: [f32; 3]) -> Form {
    Form::Colour { max: f32::MAX, default: Some(default) }
}

/// In the braces of a camera.
pub(crate) const CAMERA: &[Setting] = &[
    setting("position", Form::Triple { default: [0.0, 1.5, 6.0] }, "m", "position 0 1.5 6", "Where the camera stands.")
        .required(),
    setting(
        "target",
        Form::Triple { default: [0.0, 1.0, 0.0] },
        "m",
        "target 0 1 0",
        "What is in the middle of the picture.",
    )
    .required(),
    setting(
        "up",
        Form::Direction { default: [0.0, 1.0, 0.0] },
        "",
        "up 0 1 0",
        "Direction that is up in the picture; not along the view.",
    ),
    setting("fov", number(Range::between(0.0, 180.0), 40.0), "°", "fov 40", "Vertical field of view."),
    setting("lens", Form::Properties(LENS), "", "lens radius=0.05 focus=6", "A thin lens."),
    setting(
        "exposure",
        number(limits::EXPOSURE, 0.0),
        "EV",
        "exposure 0",
        "Stops for the screen, PNG and JPEG; never for EXR.",
    ),
];

/// Properties of `lens`.
pub(crate) const LENS: &[Setting] = &[
    setting("radius", number(Range::NOT_NEGATIVE, 0.0), "m", "radius=0.05", "Radius of the thin lens; 0 is a pinhole."),
    setting(
        "focus",
        OPTIONAL,
        "m",
        "focus=6",
        "Distance of what is sharp, along the view; that of the target when absent.",
    ),
];

/// In the braces of `render`.
pub(crate) const RENDER: &[Setting] = &[
    setting(
        "size",
        Form::Size { range: limits::SIDE, default: [1280, 720] },
        "px",
        "size 1280 720",
        "Width and height of the picture.",
    ),
    setting(
        "samples",
        Form::Whole { range: limits::SAMPLES, default: 256 },
        "",
        "samples 256",
        "Paths for each pixel.",
    ),
    setting(
        "bounces",
        Form::Whole { range: limits::BOUNCES, default: 4 },
        "",
        "bounces 4",
        "Scattering events after the first hit; 0 is emitted and direct light only.",
    ),
    setting(
        "tonemap",
        Form::Choice { words: || Tonemap::ALL.map(Tonemap::name).to_vec() },
        "",
        "tonemap \"agx\"",
        "How the screen, PNG and JPEG show radiance; never applied to EXR.",
    ),
    setting(
        "sampler",
        Form::Choice { words: || Sampler::ALL.map(Sampler::name).to_vec() },
        "",
        "sampler \"sobol\"",
        "Random numbers: evenly spread, or each by itself.",
    ),
    setting(
        "caustics",
        Form::Choice { words: || Caustics::ALL.map(Caustics::name).to_vec() },
        "",
        "caustics \"traced\"",
        "Light through clear glass: followed, or let through straight by shadow rays, which is biased.",
    ),
    setting(
        "clamp",
        Form::Number { range: limits::CLAMP, default: None },
        "W/(m² sr)",
        "clamp 10",
        "Largest channel of a contribution of light that bounced, against fireflies; darkens.",
    ),
    setting(
        "detail",
        number(limits::DETAIL, DETAIL),
        "px",
        "detail 0.1",
        "How near to a surface a ray ends, as it is seen: smaller shows finer detail of fractals, and costs steps.",
    ),
    setting("fps", number(limits::FPS, 24.0), "/s", "fps 24", "Pictures of an animation in a second."),
    setting(
        "shutter",
        number(limits::SHUTTER, 0.0),
        "",
        "shutter 0.5",
        "Part of a frame's time that the shutter is open: motion blur; 0 is none.",
    ),
];

const PENUMBRA: Setting = setting(
    "penumbra",
    OPTIONAL,
    "",
    "penumbra 16",
    "Softens shadows by near misses, an approximation; larger is sharper.",
);

/// In the braces of a sun.
pub(crate) const SUN: &[Setting] = &[
    setting(
        "direction",
        Form::Direction { default: [0.3, 0.8, 0.5] },
        "",
        "direction 0.3 0.8 0.5",
        "Points towards the sun.",
    )
    .required(),
    setting("irradiance", radiance([3.0, 2.9, 2.7]), "W/m²", "irradiance 3 2.9 2.7", "On a surface that faces it.")
        .required(),
    setting(
        "angle",
        number(Range::from_to(0.0, 180.0), SUN_ANGLE),
        "°",
        "angle 0.53",
        "Apparent diameter; 0 is parallel light with hard shadows.",
    ),
    PENUMBRA,
];

/// In the braces of a point light.
pub(crate) const POINT: &[Setting] = &[
    setting("at", Form::Triple { default: [4.0, 6.0, 4.0] }, "m", "at 4 6 4", "Where it stands.").required(),
    setting("intensity", radiance([60.0; 3]), "W/sr", "intensity 60", "In every direction.").required(),
    PENUMBRA,
];

/// In the braces of a sky that is a gradient.
pub(crate) const GRADIENT: &[Setting] = &[
    setting("zenith", radiance([0.2, 0.4, 0.8]), "W/(m² sr)", "zenith 0.2 0.4 0.8", "Radiance from straight up.")
        .required(),
    setting(
        "horizon",
        radiance([0.8, 0.85, 0.9]),
        "W/(m² sr)",
        "horizon 0.8 0.85 0.9",
        "Radiance at the height of the eye.",
    )
    .required(),
    setting(
        "ground",
        Form::Colour { max: f32::MAX, default: None },
        "W/(m² sr)",
        "ground 0.3 0.25 0.2",
        "Radiance from below; that of the horizon when absent.",
    ),
];

const STRENGTH: Setting =
    setting("strength", number(Range::NOT_NEGATIVE, 1.0), "", "strength=1", "Factor of all radiance.");

/// Properties of a sky that is a picture.
pub(crate) const PICTURE: &[Setting] =
    &[STRENGTH, setting("rotate", number(Range::ANY, 0.0), "°", "rotate=90", "Turn about the vertical, right-handed.")];

/// Properties of a sky that is a day. The defaults are those of `Day`.
pub(crate) const DAY: &[Setting] = &[
    setting(
        "elevation",
        number(Range::from_to(-20.0, 90.0), 40.0),
        "°",
        "elevation=40",
        "Height of the sun above the horizon.",
    ),
    setting(
        "azimuth",
        number(Range::ANY, 135.0),
        "°",
        "azimuth=135",
        "Direction of the sun, clockwise from north (-z): 90 is +x.",
    ),
    setting(
        "haze",
        number(Range::from_to(0.0, 20.0), 1.0),
        "",
        "haze=1",
        "0 is air alone, 1 a clear day, 4 a usual one, 20 thick haze.",
    ),
    STRENGTH,
    setting("sun", Form::Flag { default: true }, "", "sun=#true", "Whether the sun itself shines."),
];

/// In the braces of a sky that is a day.
pub(crate) const DAY_GROUND: &[Setting] = &[setting(
    "ground",
    Form::Colour { max: 1.0, default: Some([0.2; 3]) },
    "",
    "ground 0.2",
    "Fraction of the light that the ground reflects.",
)];

/// Where every shape and operator stands.
pub(crate) const PLACEMENT: &[Setting] = &[
    setting("at", Form::Triple { default: [0.0; 3] }, "m", "at 0 1 0", "Position."),
    setting(
        "rotate",
        Form::Triple { default: [0.0; 3] },
        "°",
        "rotate 0 45 0",
        "Turns about the fixed x, then y, then z axis, right-handed.",
    ),
    setting("scale", number(Range::POSITIVE, 1.0), "", "scale s", "Size, a factor."),
];

/// Where a shape that faces +y is turned to.
pub(crate) const NORMAL: Setting = setting(
    "normal",
    Form::Direction { default: [0.0, 1.0, 0.0] },
    "",
    "normal 0 1 0",
    "Direction that it faces, before it is turned.",
);

/// The node of a material that gives its surfaces a relief.
pub(crate) const BUMP: &str = "bump";
/// A node of a row of colours.
pub(crate) const COLOUR: &str = "colour";

/// The node of a material that colours fractals by their orbits.
pub(crate) const ORBIT_TRAP: &str = "orbit-trap";

/// The property of texts that names a font.
pub(crate) const FONT: &str = "font";

/// The words of [`Unit::Axis`](pathmarch_field::Unit::Axis), in the order of its numbers.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Over how much an operator of several solids blends.
const SMOOTH: Setting = setting(
    "smooth",
    number(Range::NOT_NEGATIVE, 0.0),
    "m",
    "smooth=0.1",
    "Width over which edges and materials blend; 0 is sharp.",
);

/// Properties of every operator that blends.
pub(crate) const BLEND: &[Setting] = &[
    SMOOTH,
    setting(
        "profile",
        Form::Choice { words: || BlendProfile::ALL.map(BlendProfile::name).to_vec() },
        "",
        "profile=\"round\"",
        "What the seam of a blend looks like.",
    ),
    setting(
        "steps",
        Form::Whole { range: (1, MAX_STEPS), default: DEFAULT_STEPS as u32 },
        "",
        "steps=4",
        "How many steps the profile \"stairs\" has.",
    ),
];

/// The words of a table.
pub(crate) fn names(table: &'static [Setting]) -> Vec<&'static str> {
    table.iter().map(|setting| setting.name).collect()
}

/// The setting of this word.
pub(crate) fn find(table: &'static [Setting], name: &str) -> &'static Setting {
    table.iter().find(|setting| setting.name == name).expect("a word of this table")
}

/// The three numbers of a node that says where or whereto; `None` after a mistake.
pub(crate) fn triple(node: &Node, setting: &Setting, report: &mut Report) -> Option<[f32; 3]> {
    match setting.form {
        Form::Direction { .. } => direction(node, report),
        _ => numbers(node, &setting.usage(), Range::ANY, report),
    }
}

/// The number of a node; `None` after a mistake.
pub(crate) fn single(node: &Node, setting: &Setting, report: &mut Report) -> Option<f32> {
    let range = setting.form.range();
    numbers(node, &setting.usage(), range, report).map(|[number]| number)
}

/// The number of a property; `None` after a mistake.
pub(crate) fn property(entry: &Entry, setting: &Setting, report: &mut Report) -> Option<f32> {
    in_range(entry, &format!("`{}`", setting.name), setting.form.range(), report)
}

impl Form {
    fn range(&self) -> Range {
        match self {
            Self::Number { range, .. } => *range,
            _ => Range::ANY,
        }
    }
    fn default_number(&self) -> Option<f32> {
        match self {
            Self::Number { default, .. } => *default,
            _ => None,
        }
    }
}

/// Nodes in braces, read by their table. Each value is the default where its node is absent, and `None` after a mistake,
/// which is then reported.
pub(crate) struct Braces<'n> {
    node: &'n Node<'n>,
    table: &'static [Setting],
    settings: Settings<'n>,
}

impl<'n> Braces<'n> {
    /// Reports unknown nodes and repeated ones. `place` as in "in a camera".
    pub(crate) fn new(node: &'n Node<'n>, table: &'static [Setting], place: &str, report: &mut Report) -> Self {
        Self { node, table, settings: Settings::new(node, &names(table), place, report) }
    }
    /// The node of this word.
    pub(crate) fn get(&self, name: &str) -> Option<&'n Node<'n>> {
        self.settings.get(name)
    }
    /// The setting of this word, and its node. A required one that is missing is reported.
    fn find(&self, name: &str, report: &mut Report) -> (&'static Setting, Option<&'n Node<'n>>) {
        let setting = find(self.table, name);
        let found = match setting.required {
            true => self.settings.require(name, setting.example, self.node, report),
            false => self.settings.get(name),
        };
        (setting, found)
    }
    pub(crate) fn triple(&self, name: &str, report: &mut Report) -> Option<[f32; 3]> {
        let (setting, found) = self.find(name, report);
        match (found, setting.form) {
            (Some(node), _) => triple(node, setting, report),
            (None, Form::Triple { default } | Form::Direction { default }) if !setting.required => Some(default),
            _ => None,
        }
    }
    pub(crate) fn number(&self, name: &str, report: &mut Report) -> Option<f32> {
        let (setting, found) = self.find(name, report);
        match found {
            Some(node) => single(node, setting, report),
            None => setting.form.default_number(),
        }
    }
    pub(crate) fn whole(&self, name: &str, report: &mut Report) -> Option<u32> {
        let (setting, found) = self.find(name, report);
        let Form::Whole { range, default } = setting.form else { return None };
        match found {
            Some(node) => whole_numbers(node, &setting.usage(), range, report).map(|[number]| number),
            None => Some(default),
        }
    }
    pub(crate) fn size(&self, name: &str, report: &mut Report) -> Option<[u32; 2]> {
        let (setting, found) = self.find(name, report);
        let Form::Size { range, default } = setting.form else { return None };
        match found {
            Some(node) => whole_numbers(node, &setting.usage(), range, report),
            None => Some(default),
        }
    }
    pub(crate) fn colour(&self, name: &str, report: &mut Report) -> Option<[f32; 3]> {
        let (setting, found) = self.find(name, report);
        let Form::Colour { max, default } = setting.form else { return None };
        match found {
            Some(node) => colour(node, Range::from_to(0.0, max), report),
            None => default.filter(|_| !setting.required),
        }
    }
    /// One of the things in `all`, the first when absent; `what` as in "There is no …".
    pub(crate) fn choice<T: Copy>(
        &self,
        name: &str,
        what: &str,
        all: &[T],
        name_of: fn(T) -> &'static str,
        report: &mut Report,
    ) -> Option<T> {
        match self.get(name) {
            Some(node) => choice(node, what, all, name_of, report),
            None => all.first().copied(),
        }
    }
}

/// Properties of a node, read by their table; defaults for what is absent or wrong.
pub(crate) struct Properties<'n> {
    table: &'static [Setting],
    found: Vec<(&'static str, &'n Entry<'n>)>,
}

impl<'n> Properties<'n> {
    /// Of those found by [`properties`], which may be of other tables, too.
    pub(crate) fn of(table: &'static [Setting], found: &[(&str, &'n Entry<'n>)]) -> Self {
        let ours = |(word, entry): &(&str, &'n Entry<'n>)| {
            let setting = table.iter().find(|setting| setting.name == *word)?;
            Some((setting.name, *entry))
        };
        Self { table, found: found.iter().filter_map(ours).collect() }
    }
    /// Reports unknown properties and repeated ones.
    pub(crate) fn new(node: &'n Node<'n>, table: &'static [Setting], report: &mut Report) -> Self {
        Self { table, found: properties(node, &names(table), report) }
    }
    fn get(&self, name: &str) -> Option<&'n Entry<'n>> {
        self.found.iter().find(|(word, _)| *word == name).map(|(_, entry)| *entry)
    }
    /// `None` where it is absent and has no default.
    pub(crate) fn number(&self, name: &str, report: &mut Report) -> Option<f32> {
        let setting = find(self.table, name);
        self.get(name).and_then(|entry| property(entry, setting, report)).or(setting.form.default_number())
    }
    /// `None` after a mistake.
    pub(crate) fn whole(&self, name: &str, report: &mut Report) -> Option<u32> {
        let Form::Whole { range, default } = find(self.table, name).form else { return None };
        self.get(name).map_or(Some(default), |entry| whole(entry, &format!("`{name}`"), range, report))
    }
    /// One of the things in `all`, the first when absent; `what` as in "There is no …".
    pub(crate) fn choice<T: Copy>(
        &self,
        name: &str,
        what: &str,
        all: &[T],
        name_of: fn(T) -> &'static str,
        report: &mut Report,
    ) -> Option<T> {
        let Some(entry) = self.get(name) else { return all.first().copied() };
        let text = string(entry, &format!("`{name}`"), report)?;
        named(entry, text, what, all, name_of, report)
    }
    pub(crate) fn flag(&self, name: &str, report: &mut Report) -> bool {
        let given = self.get(name).and_then(|entry| flag(entry, &format!("`{name}`"), report));
        given.unwrap_or(matches!(find(self.table, name).form, Form::Flag { default: true }))
    }
}

#[cfg(test)]
mod tests {
    use super::{DAY, DAY_GROUND, Form, RENDER, find};
    use crate::atmosphere::Day;
    use crate::render_settings::RenderSettings;

    /// Two structures have defaults of their own, for those who make them without a text.
    #[test]
    fn defaults_are_those_of_the_structures() {
        let number = |name: &str| find(DAY, name).form.default_number().unwrap();
        let Form::Colour { default: Some(ground), .. } = DAY_GROUND[0].form else { panic!("a colour") };
        let day = Day {
            elevation: number("elevation"),
            azimuth: number("azimuth"),
            haze: number("haze"),
            strength: number("strength"),
            ground,
        };
        assert_eq!(day, Day::default());
        let whole = |name: &str| match find(RENDER, name).form {
            Form::Whole { default, .. } => default,
            _ => panic!("{name} is a whole number"),
        };
        let Form::Size { default: size, .. } = find(RENDER, "size").form else { panic!("a size") };
        let default = RenderSettings::default();
        assert_eq!((size.into(), whole("samples"), whole("bounces")), (default.size, default.samples, default.bounces));
    }
}
