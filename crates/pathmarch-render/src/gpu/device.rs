//! Adapters and the device opened on one of them.

use super::compiled::Kernels;
use super::display::DisplayPass;
use crate::error::RenderError;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

/// Work that takes this long has hung.
pub(super) const HUNG: Duration = Duration::from_secs(120);

/// The kind of an adapter that runs on the processor.
const SOFTWARE: &str = "software";

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
            wgpu::DeviceType::Cpu => SOFTWARE,
            wgpu::DeviceType::Other => "other",
        },
        driver: [info.driver.as_str(), info.driver_info.as_str()].join(" ").trim().to_owned(),
        unusable: match (compute, buffers) {
            (false, _) => Some("it has no compute shaders"),
            (true, false) => Some("it allows fewer than seven storage buffers in a shader"),
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
    /// What has been compiled for it.
    pub(super) kernels: Kernels,
    display: OnceLock<DisplayPass>,
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
            // For whoever measures.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
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
        Ok(Self { device, queue, description, kernels: Kernels::default(), display: OnceLock::new(), failure })
    }

    /// Whether it runs on the processor.
    pub(crate) fn is_software(&self) -> bool {
        self.description.kind == SOFTWARE
    }

    /// The pass that shows films.
    pub(super) fn display(&self) -> &DisplayPass {
        self.display.get_or_init(|| DisplayPass::new(&self.device))
    }

    /// A buffer, or why there is no room for it.
    pub(super) fn allocate(&self, descriptor: &wgpu::BufferDescriptor) -> Result<wgpu::Buffer, RenderError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(descriptor);
        match pollster::block_on(memory.pop()) {
            Some(error) => Err(self.error(error)),
            None => Ok(buffer),
        }
    }

    /// Waits for everything submitted, and hands the first `bytes` bytes of a buffer that can be mapped to `take`.
    pub(super) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if this function has already failed.
            let _ = sender.send(result);
        });
        self.device
            .poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(HUNG) })
            .map_err(|error| self.error(error))?;
        self.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.error(error)),
            Err(error) => return Err(self.error(error)),
        }
        let view = buffer.slice(..bytes).get_mapped_range().map_err(|error| self.error(error))?;
        let taken = take(&view);
        drop(view);
        buffer.unmap();
        Ok(taken)
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
