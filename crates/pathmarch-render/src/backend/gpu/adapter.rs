//! Graphics adapters of this machine.

/// Largest number of storage buffers of a kernel: leaves, materials, lights, film, scene data, vectors, guides, and the
/// parameters of a large field.
const STORAGE_BUFFERS: u32 = 8;

/// Kind of an adapter that runs on the CPU.
pub(super) const SOFTWARE: &str = "software";

/// Graphics adapter of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// Name that the driver reports.
    pub name: String,
    /// Graphics API: "Vulkan", "Metal", "Dx12", "Gl".
    pub backend: String,
    /// "discrete GPU", "integrated GPU", "virtual GPU", "software" or "other".
    pub kind: &'static str,
    /// Name and version of the driver; empty if not reported.
    pub driver: String,
    /// Reason why it cannot be used; `None` if it can.
    pub unusable: Option<&'static str>,
}

fn instance(backends: wgpu::Backends) -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

pub(super) fn describe(adapter: &wgpu::Adapter) -> AdapterDescription {
    let info = adapter.get_info();
    let compute = adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS);
    let buffers = adapter.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS;
    AdapterDescription {
        name: info.name.clone(),
        backend: format!("{:?}", info.backend),
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Cpu => SOFTWARE,
            wgpu::DeviceType::Other => "other",
        },
        driver: [info.driver.as_str(), info.driver_info.as_str()].join(" ").trim().to_owned(),
        unusable: match (compute, buffers) {
            (false, _) => Some("it does not support compute shaders"),
            (true, false) => Some("it supports fewer than seven storage buffers in a shader"),
            (true, true) => None,
        },
    }
}

/// Rank in the order of preference: GPUs before software.
fn rank(adapter: &wgpu::Adapter) -> u8 {
    match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Adapter that the browser prefers, the fastest one of the machine.
#[cfg(target_family = "wasm")]
pub(super) async fn preferred() -> Result<wgpu::Adapter, crate::error::RenderError> {
    let request =
        wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    let adapter = instance(wgpu::Backends::BROWSER_WEBGPU).request_adapter(&request).await;
    adapter.map_err(|error| crate::error::RenderError::NoAdapter { reason: error.to_string() })
}

pub(super) fn enumerate() -> Vec<wgpu::Adapter> {
    let of = |backends| pollster::block_on(instance(backends).enumerate_adapters(backends));
    let mut adapters = of(wgpu::Backends::PRIMARY);
    // OpenGL lists the same hardware again, and its libraries print warnings without a display: used only if needed.
    if !adapters.iter().any(|adapter| describe(adapter).unusable.is_none()) {
        adapters.extend(of(wgpu::Backends::GL));
    }
    adapters.sort_by_key(rank);
    adapters
}

/// All adapters of this machine, the preferred one first.
pub fn adapters() -> Vec<AdapterDescription> {
    enumerate().iter().map(describe).collect()
}
