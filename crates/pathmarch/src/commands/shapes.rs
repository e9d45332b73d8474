//! `pathmarch shapes`: reference of shapes and operators, from the registry.

use pathmarch_cli::{DONE, Failure, out, outln};
use pathmarch_render::pathmarch_field::Outline;
use pathmarch_render::pathmarch_field::blend::DEFAULT_STEPS;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes, solid, solids};
use pathmarch_render::pathmarch_field::{BlendProfile, Info, Param, Solid};
use pathmarch_render::pathmarch_scene::reference;
use serde_json::{Value, json};

#[derive(clap::Args)]
pub struct Arguments {
    /// Shape or operator to describe in full
    name: Option<String>,
    /// Print its generated WGSL
    #[arg(long, requires = "name")]
    wgsl: bool,
    /// Print it, or all shapes, operators and modifiers, with their parameters, as JSON
    #[arg(long, conflicts_with = "wgsl")]
    json: bool,
}

/// An entry of the registry.
fn entry(info: &Info, params: &[Param]) -> Value {
    let param = |param: &Param| {
        json!({"name": param.name, "doc": param.doc, "unit": param.unit.name(),
            "default": param.default_in_words(), "range": param.range_in_words()})
    };
    json!({"name": info.name, "doc": info.doc, "source": info.source, "exact": info.exact,
        "params": params.iter().map(param).collect::<Vec<_>>()})
}

/// Everything in the registry.
fn all_as_json() -> Value {
    json!({
        "shapes": shapes().iter().map(|shape| entry(shape.info(), shape.params())).collect::<Vec<_>>(),
        "operators": operators().iter().map(|operator| entry(operator.info(), operator.params())).collect::<Vec<_>>(),
        "modifiers": modifiers().iter().map(|modifier| entry(modifier.info(), modifier.params())).collect::<Vec<_>>(),
    })
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Some(name) = &arguments.name else {
        if arguments.json {
            outln!("{}", all_as_json());
            return Ok(DONE);
        }
        outln!("Shapes\n");
        for shape in shapes() {
            outln!("  {:<40} {}", usage(shape.info(), shape.params()), shape.info().doc);
        }
        outln!("\nOperators (children in braces; smooth= blends over metres)\n");
        for operator in operators() {
            let names = if operator.blends() { "smooth=0".to_owned() } else { param_names(operator.params()) };
            outln!("  {:<40} {}", format!("{} {names}", operator.info().name), operator.info().doc);
        }
        outln!("\nModifiers of the union of their children\n");
        for modifier in modifiers() {
            outln!("  {:<40} {}", usage(modifier.info(), modifier.params()), modifier.info().doc);
        }
        outln!("\nAny of them takes at, rotate and scale as children. `pathmarch shapes NAME` describes one.");
        return Ok(DONE);
    };
    match solid(name) {
        Some(found) if arguments.json => outln!("{}", entry(found.info(), found.params())),
        Some(Solid::Shape(shape)) if arguments.wgsl => {
            out!("{}\n{}", shape.wgsl_distance(), shape.wgsl_gradient());
        }
        Some(Solid::Shape(shape)) => {
            page(shape.info(), shape.params());
            match shape.info().outline {
                Some(Outline::Points) => {
                    outln!("\n  A child point x y is a corner; at least three, or none for an arrow.")
                }
                Some(Outline::Curve) => {
                    outln!(
                        "\n  A child point x y is on the curve; corner=#true makes a corner there. At least three, or two for a line, or none for a drop."
                    )
                }
                Some(Outline::Path) => {
                    outln!("\n  The argument is a path in the notation of SVG, in metres; `scale` changes its size.")
                }
                Some(Outline::Text) => {
                    outln!("\n  The argument is the text. font= names a .ttf or .otf file relative to the scene file.")
                }
                None => {}
            }
            if shape.info().profile {
                outln!("\n  Use it in extrude or revolve.");
            }
            if shape.info().facing {
                outln!("\n  A child normal x y z rotates +y to this direction.");
            }
            if shape.info().sheet {
                outln!("  No thickness; an emissive material emits only on the front side.");
            }
        }
        Some(Solid::Operator(operator)) if arguments.wgsl => {
            let profiles = BlendProfile::ALL.map(Some).into_iter().take(if operator.blends() { 4 } else { 1 });
            for profile in profiles.chain([None]) {
                outln!(
                    "{}\n{}\n{}",
                    operator.wgsl_distance(profile),
                    operator.wgsl_gradient(profile),
                    operator.wgsl_weight(profile)
                );
            }
        }
        Some(Solid::Operator(operator)) => {
            page(operator.info(), operator.params());
            if operator.blends() {
                outln!("\n  smooth=    Width of the blend, metres; sharp without it.");
                outln!("  profile=   Shape of the seam:");
                for profile in BlendProfile::ALL {
                    outln!("    {:<8} {}", profile.name(), profile.doc());
                }
                outln!("  steps=     Number of steps of the profile stairs. Default {DEFAULT_STEPS}.");
            }
        }
        Some(Solid::Modifier(modifier)) if arguments.wgsl => out!("{}", modifier.wgsl()),
        Some(Solid::Modifier(modifier)) => {
            page(modifier.info(), modifier.params());
            if modifier.needs_bounds() {
                outln!("\n  The child must have finite bounds.");
            }
        }
        None => {
            if !reference::entries(name).is_empty() {
                let why = format!("\"{name}\" is no shape or operator; `pathmarch help {name}` describes it");
                return Err(Failure::Usage(why));
            }
            let names = solids().map(|solid| &*solid.info().name);
            let nearest = names.min_by_key(|known| strsim::damerau_levenshtein(known, name)).unwrap_or_default();
            return Err(Failure::Usage(format!(
                "there is no shape or operator \"{name}\"; did you mean \"{nearest}\"? `pathmarch shapes` lists all"
            )));
        }
    }
    Ok(DONE)
}

fn usage(info: &Info, params: &[Param]) -> String {
    format!("{} {}", info.name, param_names(params)).trim().to_owned()
}

fn param_names(params: &[Param]) -> String {
    params.iter().map(|param| &*param.name).collect::<Vec<_>>().join(" ")
}

fn page(info: &Info, params: &[Param]) {
    outln!("{}\n\n  {}", usage(info, params), info.doc);
    outln!(
        "  {} Source: {}.",
        if info.exact { "Exact distance." } else { "Lower bound of the distance." },
        info.source
    );
    if info.size_params > 1 {
        outln!("  One number sets the first {} parameters.", info.size_params);
    }
    if !params.is_empty() {
        outln!("");
    }
    for param in params {
        let unit = if param.unit.name().is_empty() { String::new() } else { format!(", {}", param.unit.name()) };
        outln!(
            "  {:<10} {} Default {}{unit}; {}.",
            param.name,
            param.doc,
            param.default_in_words(),
            param.range_in_words()
        );
    }
}
