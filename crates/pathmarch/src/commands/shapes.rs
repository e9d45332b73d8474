//! `pathmarch shapes`: reference of shapes and operators, from the registry.

use pathmarch_cli::{DONE, Failure};
use pathmarch_render::pathmarch_field::Outline;
use pathmarch_render::pathmarch_field::blend::DEFAULT_STEPS;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes, solid, solids};
use pathmarch_render::pathmarch_field::{BlendProfile, Info, Param, Solid};
use pathmarch_render::pathmarch_scene::reference;

#[derive(clap::Args)]
pub struct Arguments {
    /// Shape or operator to describe in full
    name: Option<String>,
    /// Print its generated WGSL
    #[arg(long, requires = "name")]
    wgsl: bool,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Some(name) = &arguments.name else {
        println!("Shapes\n");
        for shape in shapes() {
            println!("  {:<40} {}", usage(shape.info(), shape.params()), shape.info().doc);
        }
        println!("\nOperators (children in braces; smooth= blends over metres)\n");
        for operator in operators() {
            let names = if operator.blends() { "smooth=0".to_owned() } else { param_names(operator.params()) };
            println!("  {:<40} {}", format!("{} {names}", operator.info().name), operator.info().doc);
        }
        println!("\nModifiers of the union of their children\n");
        for modifier in modifiers() {
            println!("  {:<40} {}", usage(modifier.info(), modifier.params()), modifier.info().doc);
        }
        println!("\nAny of them takes at, rotate and scale as children. `pathmarch shapes NAME` describes one.");
        return Ok(DONE);
    };
    match solid(name) {
        Some(Solid::Shape(shape)) if arguments.wgsl => {
            print!("{}\n{}", shape.wgsl_distance(), shape.wgsl_gradient());
        }
        Some(Solid::Shape(shape)) => {
            page(shape.info(), shape.params());
            match shape.info().outline {
                Some(Outline::Points) => {
                    println!("\n  A child point x y is a corner; at least three, or none for an arrow.")
                }
                Some(Outline::Text) => println!(
                    "\n  The argument is the text. font= names a .ttf or .otf file relative to the scene file."
                ),
                None => {}
            }
            if shape.info().profile {
                println!("\n  Use it in extrude or revolve.");
            }
            if shape.info().facing {
                println!("\n  A child normal x y z rotates +y to this direction.");
            }
            if shape.info().sheet {
                println!("  No thickness; an emissive material emits only on the front side.");
            }
        }
        Some(Solid::Operator(operator)) if arguments.wgsl => {
            let profiles = BlendProfile::ALL.map(Some).into_iter().take(if operator.blends() { 4 } else { 1 });
            for profile in profiles.chain([None]) {
                println!(
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
                println!("\n  smooth=    Width of the blend, metres; sharp without it.");
                println!("  profile=   Shape of the seam:");
                for profile in BlendProfile::ALL {
                    println!("    {:<8} {}", profile.name(), profile.doc());
                }
                println!("  steps=     Number of steps of the profile stairs. Default {DEFAULT_STEPS}.");
            }
        }
        Some(Solid::Modifier(modifier)) if arguments.wgsl => print!("{}", modifier.wgsl()),
        Some(Solid::Modifier(modifier)) => {
            page(modifier.info(), modifier.params());
            if modifier.needs_bounds() {
                println!("\n  The child must have finite bounds.");
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
    println!("{}\n\n  {}", usage(info, params), info.doc);
    println!(
        "  {} Source: {}.",
        if info.exact { "Exact distance." } else { "Lower bound of the distance." },
        info.source
    );
    if info.size_params > 1 {
        println!("  One number sets the first {} parameters.", info.size_params);
    }
    if !params.is_empty() {
        println!();
    }
    for param in params {
        let unit = if param.unit.name().is_empty() { String::new() } else { format!(", {}", param.unit.name()) };
        println!(
            "  {:<10} {} Default {}{unit}; {}.",
            param.name,
            param.doc,
            param.default_in_words(),
            param.range_in_words()
        );
    }
}
