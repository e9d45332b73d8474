//! `pathmarch devices`: lists the devices that can render.

use pathmarch_cli::{DONE, Failure, InstructionSet, outln};
use pathmarch_render::adapters;
use serde_json::json;

#[derive(clap::Args)]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let adapters = adapters();
    let preferred = adapters.iter().position(|adapter| adapter.unusable.is_none());
    let is_software = preferred.is_some_and(|at| adapters[at].kind == "software");
    let default_gpu = preferred.filter(|_| !is_software);
    if arguments.json {
        let gpus: Vec<_> = adapters
            .iter()
            .enumerate()
            .map(|(k, adapter)| {
                json!({
                    "name": adapter.name,
                    "backend": adapter.backend,
                    "kind": adapter.kind,
                    "driver": adapter.driver,
                    "unusable": adapter.unusable.map(|reason| reason.to_string()),
                    "default": Some(k) == default_gpu,
                })
            })
            .collect();
        let cpu = json!({
            "threads": rayon::current_num_threads(),
            "instructions": InstructionSet::of_build().name(),
            "default": default_gpu.is_none(),
        });
        outln!("{}", json!({"gpus": gpus, "cpu": cpu}));
        return Ok(DONE);
    }
    for (k, adapter) in adapters.iter().enumerate() {
        let remark = match adapter.unusable {
            Some(reason) => format!("  not usable: {reason}"),
            None if Some(k) == preferred && is_software => {
                "  <- used where a trial is faster than the CPU; the window uses the CPU".to_owned()
            }
            None if Some(k) == preferred => "  <- default".to_owned(),
            None => String::new(),
        };
        outln!("GPU  {}  [{}, {}; {}]{remark}", adapter.name, adapter.backend, adapter.kind, adapter.driver);
    }
    let threads = rayon::current_num_threads();
    let remark = if default_gpu.is_none() { "  <- default" } else { "" };
    let instructions = InstructionSet::of_build().label();
    outln!("CPU  {threads} threads, eight rays per packet, {instructions}{remark}");
    if preferred.is_none() {
        outln!("No usable GPU adapter: install a graphics driver, or Mesa's software Vulkan (mesa-vulkan-drivers).");
    }
    Ok(DONE)
}
