//! `pathmarch help`: help on commands, and on every word of the scene language.

use clap::Command;
use pathmarch_cli::{DONE, Failure, outln};
use pathmarch_render::pathmarch_scene::reference::{self, Entry};

#[derive(clap::Args)]
pub struct Arguments {
    /// Command, or word of the scene language: `pathmarch help roughness`
    word: Option<String>,
}

pub fn run(arguments: &Arguments, mut command: Command) -> Result<u8, Failure> {
    let Some(word) = &arguments.word else { return printed(&mut command) };
    let entries = reference::entries(word);
    if let Some(command) = command.find_subcommand_mut(word) {
        printed(command)?;
        if !entries.is_empty() {
            outln!("\nIn scenes:\n");
        }
    } else if entries.is_empty() {
        let nearest = reference::nearest(word).map_or(String::new(), |word| format!("; did you mean \"{word}\"?"));
        return Err(Failure::Usage(format!("there is no command and no word \"{word}\"{nearest}")));
    }
    entries.iter().for_each(print);
    Ok(DONE)
}

fn printed(command: &mut Command) -> Result<u8, Failure> {
    command.print_long_help().map_err(Failure::other)?;
    Ok(DONE)
}

fn print(entry: &Entry) {
    outln!("{}\n  {}", entry.title, entry.doc);
    for line in &entry.details {
        outln!("    {line}");
    }
    outln!("");
}
