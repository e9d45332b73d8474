//! `pathmarch reference`: every word of the scene language, as Markdown.

use pathmarch_cli::{DONE, Failure, out};
use pathmarch_render::pathmarch_scene::reference;

#[derive(clap::Args)]
pub struct Arguments {}

pub fn run(_: &Arguments) -> Result<u8, Failure> {
    out!("{}", reference::page());
    Ok(DONE)
}
