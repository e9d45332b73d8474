//! Adapters and the device opened on one of them.

use crate::error::RenderError;
use std::sync::{Arc, Mutex};

/// One adapter that this machine offers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// The adapter's own name.
    pub name: String,
    /// Graphics interface it is reached through: "Vulkan", "Metal", "Dx12", "Gl".
    pub backend: String,
    /// "discrete GPU", "integrated GPU", "virtual GPU", "software" or "other".
    pub kind: &'static str,
    /// Driver and its version, as far as it says.
    pub driver: String,
    /// Why it cannot be used, where it cannot.
    pub unusable: Option<&'static str>,
}

fn instance(backends: wgpu::Backends) -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

fn describe(adapter: &wgpu::Adapter) -> AdapterDescription {
    let info = adapter.get_info();
    let compute = adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS);
    let buffers = adapter.limits().max_storage_buffers_per_shader_stage >= super::job::STORAGE_BUFFERS;
    AdapterDescription {
        name: info.name.clone(),
        backend: format!("{:?}", info.backend),
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        },
        driver: [info.driver.as_str(), info.driver_info.as_str()].join(" ").trim().to_owned(),
        unusable: match (compute, buffers) {
            (false, _) => Some("it has no compute shaders"),
            (true, false) => Some("it allows fewer than four storage buffers in a shader"),
            (true, true) => None,
        },
    }
}

/// Best first: real GPUs before software.
fn rank(adapter: &wgpu::Adapter) -> u8 {
    match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let of = |backends| pollster::block_on(instance(backends).enumerate_adapters(backends));
    let mut adapters = of(wgpu::Backends::PRIMARY);
    // OpenGL shows the same hardware once more, and its libraries are noisy where there is no display: only when needed.
    if !adapters.iter().any(|adapter| describe(adapter).unusable.is_none()) {
        adapters.extend(of(wgpu::Backends::GL));
    }
    adapters.sort_by_key(rank);
    adapters
}

/// Every adapter of this machine, the preferred one first.
pub fn adapters() -> Vec<AdapterDescription> {
    enumerate().iter().map(describe).collect()
}

/// An opened adapter.
pub(crate) struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) description: AdapterDescription,
    /// The first failure that the device reported on its own.
    failure: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens the preferred adapter, or the one whose name contains `name` (whatever the case).
    pub(crate) fn open(name: Option<&str>) -> Result<Self, RenderError> {
        let adapters = enumerate();
        let usable: Vec<_> = adapters.iter().filter(|adapter| describe(adapter).unusable.is_none()).collect();
        let adapter = match name {
            Some(name) => {
                let wanted = name.to_lowercase();
                let found = |adapter: &&&wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&wanted);
                usable.iter().find(found).ok_or_else(|| RenderError::NoSuchAdapter {
                    name: name.to_owned(),
                    available: usable.iter().map(|adapter| adapter.get_info().name).collect(),
                })?
            }
            None => usable.first().ok_or_else(|| match adapters.first().map(describe) {
                Some(AdapterDescription { name, unusable: Some(reason), .. }) => {
                    RenderError::NoAdapter { reason: format!("{name} cannot be used: {reason}") }
                }
                _ => RenderError::NoAdapter { reason: "no graphics driver offers one".to_owned() },
            })?,
        };
        let description = describe(adapter);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("pathmarch"),
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request)
            .map_err(|error| RenderError::Device { adapter: description.name.clone(), reason: error.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        let keep = |failure: &Arc<Mutex<Option<String>>>, message: String| {
            if let Ok(mut slot) = failure.lock() {
                slot.get_or_insert(message);
            }
        };
        let slot = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
        let slot = failure.clone();
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep(&slot, format!("the device was lost: {message}"));
            }
        });
        Ok(Self { device, queue, description, failure })
    }

    /// What the device reported on its own since it was opened, as an error.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let failure = self.failure.lock().ok().and_then(|slot| slot.clone());
        failure.map_or(Ok(()), |reason| Err(self.error(reason)))
    }

    pub(crate) fn error(&self, reason: impl ToString) -> RenderError {
        RenderError::Device { adapter: self.description.name.clone(), reason: reason.to_string() }
    }
}
