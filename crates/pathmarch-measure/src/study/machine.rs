//! The machine of the study: Table 5.1 of the thesis.

use super::Study;
use super::table::Table;
use pathmarch_cli::Failure;
use pathmarch_render::adapters;

/// Processor, cores, memory and system, as the operating system reports them.
pub fn describe() -> [String; 3] {
    use sysinfo::System;
    let mut system = System::new();
    system.refresh_memory();
    system.refresh_cpu_all();
    let processor = system.cpus().first().map_or_else(String::new, |cpu| cpu.brand().trim().to_owned());
    let processor = format!("{processor}, {} logical cores", system.cpus().len());
    let memory = format!("{:.0} GiB", system.total_memory() as f64 / f64::from(1 << 30));
    let name = System::long_os_version().unwrap_or_default();
    let kernel = System::kernel_version().unwrap_or_default();
    [processor, memory, format!("{name}, kernel {kernel}")]
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let mut table = Table::new(["", "thesis", "this study"]);
    let [processor, memory, system] = describe();
    table.push(["operating system", "Windows 10.1 Version 1809 (build 17763.1098)", &system]);
    table.push(["processor", "Intel i5-6600k", &processor]);
    table.push(["memory", "not stated", &memory]);
    for (index, adapter) in adapters().iter().enumerate() {
        let (name, thesis) = if index == 0 { ("GPU", "MSI Radeon R9 390 8GB GDDR5") } else { ("GPU", "") };
        table.push([name, thesis, &format!("{} ({}, {})", adapter.name, adapter.backend, adapter.kind)]);
        let thesis = if index == 0 { "Radeon Software Adrenalin 2020 Edition 20.1.3" } else { "" };
        table.push(["GPU driver", thesis, &adapter.driver]);
    }
    table.save(study.directory, "machine")?;
    Ok(format!("## Machine\n\nTable 5.1.\n\n{}", table.markdown()))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_machine_has_a_processor_and_memory() {
        let [processor, memory, _] = super::describe();
        assert!(processor.contains("logical cores") && !processor.contains(" 0 "), "{processor}");
        assert!(memory != "0 GiB", "{memory}");
    }
}
