//! Writes the JavaScript that loads the module, as `wasm-bindgen --target web` does, but of the version that the module was built with.
//!
//! `cargo run --release -p pathmarch-web --features bindgen --example bindgen MODULE.wasm FOLDER`

use std::error::Error;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(module), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("name a module and a folder: bindgen MODULE.wasm FOLDER".into());
    };
    let mut bindgen = Bindgen::new();
    bindgen.remove_name_section(true).remove_producers_section(true);
    Ok(bindgen.input_path(module).web(true)?.typescript(false).generate(folder)?)
}
