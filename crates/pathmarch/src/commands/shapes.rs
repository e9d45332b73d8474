//! `pathmarch shapes`: the reference page, from the registry.

use pathmarch_cli::{DONE, Failure};
use pathmarch_render::pathmarch_field::Outline;
use pathmarch_render::pathmarch_field::blend::DEFAULT_STEPS;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes, solid, solids};
use pathmarch_render::pathmarch_field::{BlendProfile, Info, Param, Solid};

#[derive(clap::Args)]
pub struct Arguments {
    /// One shape or operator, in full
    name: Option<String>,
    /// Print the WGSL made of it
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
            let words = if operator.blends() { "smooth=0".to_owned() } else { words(operator.params()) };
            println!("  {:<40} {}", format!("{} {words}", operator.info().name), operator.info().doc);
        }
        println!("\nOperators that change what they hold, the union of their children\n");
        for modifier in modifiers() {
            println!("  {:<40} {}", usage(modifier.info(), modifier.params()), modifier.info().doc);
        }
        println!("\nAny of them takes at, rotate and scale as children. `pathmarch shapes NAME` tells more.");
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
                    println!("\n  point x y as a child is a corner; three at least, or none for an arrow.")
                }
                Some(Outline::Text) => println!(
                    "\n  Its argument is what it says. font= names a .ttf or .otf file relative to the scene file."
                ),
                None => {}
            }
            if shape.info().profile {
                println!("\n  Stands in extrude or revolve.");
            }
            if shape.info().facing {
                println!("\n  normal x y z as a child turns +y to this direction.");
            }
            if shape.info().sheet {
                println!("  Without thickness; a material that emits does so on the side it faces only.");
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
                println!("\n  smooth=    Width of the blend, metres; sharp when absent.");
                println!("  profile=   What its seam looks like:");
                for profile in BlendProfile::ALL {
                    println!("    {:<8} {}", profile.name(), profile.doc());
                }
                println!("  steps=     How many steps the profile stairs has. Default {DEFAULT_STEPS}.");
            }
        }
        Some(Solid::Modifier(modifier)) if arguments.wgsl => print!("{}", modifier.wgsl()),
        Some(Solid::Modifier(modifier)) => {
            page(modifier.info(), modifier.params());
            if modifier.needs_bounds() {
                println!("\n  What it holds must have an end.");
            }
        }
        None => {
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
    format!("{} {}", info.name, words(params)).trim().to_owned()
}

fn words(params: &[Param]) -> String {
    params.iter().map(|param| &*param.name).collect::<Vec<_>>().join(" ")
}

fn page(info: &Info, params: &[Param]) {
    println!("{}\n\n  {}", usage(info, params), info.doc);
    println!(
        "  {} Source: {}.",
        if info.exact { "Exact distance." } else { "A lower bound of the distance." },
        info.source
    );
    if info.size_params > 1 {
        println!("  One number may stand for the first {}.", info.size_params);
    }
    if !params.is_empty() {
        println!();
    }
    for param in params {
        let unit = if param.unit.name().is_empty() { String::new() } else { format!(", {}", param.unit.name()) };
        println!("  {:<10} {} Default {}{unit}; {}.", param.name, param.doc, param.default, param.range_in_words());
    }
}
