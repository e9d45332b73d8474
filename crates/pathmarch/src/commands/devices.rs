//! `pathmarch devices`: lists the devices that can render.

use pathmarch_cli::{DONE, Failure};
use pathmarch_render::adapters;

pub fn run() -> Result<u8, Failure> {
    let adapters = adapters();
    let preferred = adapters.iter().position(|adapter| adapter.unusable.is_none());
    let is_software = preferred.is_some_and(|at| adapters[at].kind == "software");
    for (k, adapter) in adapters.iter().enumerate() {
        let remark = match adapter.unusable {
            Some(reason) => format!("  not usable: {reason}"),
            None if Some(k) == preferred && is_software => {
                "  <- used where a trial is faster than the CPU; the window uses the CPU".to_owned()
            }
            None if Some(k) == preferred => "  <- default".to_owned(),
            None => String::new(),
        };
        println!("GPU  {}  [{}, {}; {}]{remark}", adapter.name, adapter.backend, adapter.kind, adapter.driver);
    }
    let threads = rayon::current_num_threads();
    let remark = if preferred.is_none() || is_software { "  <- default" } else { "" };
    println!("CPU  {threads} threads, eight rays per packet{remark}");
    if preferred.is_none() {
        println!("No usable GPU adapter: install a graphics driver, or Mesa's software Vulkan (mesa-vulkan-drivers).");
    }
    Ok(DONE)
}
