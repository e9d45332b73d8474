//! Device opened on an adapter: memory, readback and failures.

use super::adapter::{AdapterDescription, SOFTWARE, describe, enumerate};
use crate::error::RenderError;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Time after which a submission to a GPU counts as hung.
const GPU_TIMEOUT: Duration = Duration::from_secs(120);
/// The same for software adapters, which other programs slow down without limit.
const SOFTWARE_TIMEOUT: Duration = Duration::from_secs(1800);

/// Keeps a failure unless there is an earlier one.
fn keep(failure: &Mutex<Option<String>>, message: String) {
    if let Ok(mut slot) = failure.lock() {
        slot.get_or_insert(message);
    }
}

/// Kind of adapter that a kernel is composed for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct KernelTarget {
    /// True for an adapter that runs on the CPU.
    pub(crate) is_software: bool,
    /// True for software whose kernels read and write textures of 32-bit numbers.
    pub(crate) has_textures: bool,
}

impl KernelTarget {
    /// A GPU, or Mesa's software Vulkan.
    pub(crate) const fn new(is_software: bool) -> Self {
        Self { is_software, has_textures: is_software }
    }
}

/// True if kernels can read and write textures of 32-bit numbers on an adapter.
fn has_textures(adapter: &wgpu::Adapter) -> bool {
    let flags = |format| adapter.get_texture_format_features(format).flags;
    let read = flags(wgpu::TextureFormat::R32Uint).contains(wgpu::TextureFormatFeatureFlags::STORAGE_READ_ONLY);
    let written = flags(wgpu::TextureFormat::Rgba32Float).contains(wgpu::TextureFormatFeatureFlags::STORAGE_READ_WRITE);
    adapter.features().contains(FORMAT_FEATURES) && read && written
}

/// Feature of adapters that read and write textures beyond what WebGPU guarantees.
const FORMAT_FEATURES: wgpu::Features = wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;

/// Opened adapter.
pub(crate) struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) description: AdapterDescription,
    /// True if kernels can read and write textures of 32-bit numbers.
    pub(crate) has_textures: bool,
    /// First error that the device reported outside of any call.
    failure: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens the adapter that the browser prefers.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn open_async() -> Result<Self, RenderError> {
        let adapter = super::adapter::preferred().await?;
        match describe(&adapter) {
            AdapterDescription { name, unusable: Some(reason), .. } => {
                Err(RenderError::NoAdapter { reason: format!("{name} cannot be used: {reason}") })
            }
            _ => Self::of_adapter(&adapter).await,
        }
    }

    /// Opens the preferred adapter, or the one whose name contains `name`, in any case.
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
                _ => RenderError::NoAdapter { reason: "no graphics driver reports one".to_owned() },
            })?,
        };
        pollster::block_on(Self::of_adapter(adapter))
    }

    async fn of_adapter(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let description = describe(adapter);
        // GPUs read buffers as fast.
        let has_textures = description.kind == SOFTWARE && has_textures(adapter);
        // Timestamps are for `GpuTimer`.
        let mut features = wgpu::Features::TIMESTAMP_QUERY;
        features.set(FORMAT_FEATURES, has_textures);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("pathmarch"),
            required_features: adapter.features() & features,
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = request
            .await
            .map_err(|error| RenderError::Device { adapter: description.name.clone(), reason: error.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        let slot = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
        let slot = failure.clone();
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep(&slot, format!("the device was lost: {message}"));
            }
        });
        Ok(Self { device, queue, description, has_textures, failure })
    }

    /// True if the adapter is software, which runs on the CPU.
    pub(crate) fn is_software(&self) -> bool {
        self.description.kind == SOFTWARE
    }

    /// What kernels are composed for.
    pub(super) fn kernel_target(&self) -> KernelTarget {
        let is_software = self.is_software();
        KernelTarget { is_software, has_textures: is_software && self.has_textures }
    }

    /// Time after which a submission counts as hung.
    pub(super) fn timeout(&self) -> Duration {
        if self.is_software() { SOFTWARE_TIMEOUT } else { GPU_TIMEOUT }
    }

    /// Allocates a buffer.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device is out of memory.
    pub(crate) fn allocate(&self, descriptor: &wgpu::BufferDescriptor) -> Result<wgpu::Buffer, RenderError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(descriptor);
        self.end_scope(memory)?;
        Ok(buffer)
    }

    /// Ends an error scope.
    ///
    /// # Errors
    /// [`RenderError::Device`] if it has caught an error. In a browser, which reports it later, [`check`](Self::check) does.
    pub(crate) fn end_scope(&self, scope: wgpu::ErrorScopeGuard) -> Result<(), RenderError> {
        let error = scope.pop();
        #[cfg(not(target_family = "wasm"))]
        return pollster::block_on(error).map_or(Ok(()), |error| Err(self.error(error)));
        #[cfg(target_family = "wasm")]
        {
            let slot = self.failure.clone();
            wasm_bindgen_futures::spawn_local(async move {
                if let Some(error) = error.await {
                    keep(&slot, error.to_string());
                }
            });
            self.check()
        }
    }

    /// Waits until all work that was submitted so far is done.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device has failed.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn finished(&self) -> Result<(), RenderError> {
        let (sender, receiver) = futures_channel::oneshot::channel();
        self.queue.on_submitted_work_done(move || sender.send(()).unwrap_or_default());
        // A lost device drops the sender.
        let _ = receiver.await;
        self.check()
    }

    /// Maps the first `bytes` bytes of a buffer once all submitted work is done, and passes them to `take`.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device fails.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn read_async<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        let (sender, receiver) = futures_channel::oneshot::channel();
        buffer.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
        match receiver.await {
            Ok(Ok(())) => self.check()?,
            Ok(Err(error)) => return Err(self.error(error)),
            Err(error) => return Err(self.error(error)),
        }
        self.taken(buffer, bytes, take)
    }

    /// Waits for all submissions, maps the first `bytes` bytes of a buffer and passes them to `take`.
    pub(crate) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        self.read_after(buffer, bytes, None, take)
    }

    /// Reads the first bytes of a buffer once a submission is complete; later ones may go on.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device fails.
    pub(crate) fn read_submitted<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        self.read_after(buffer, bytes, Some(submission), take)
    }

    fn read_after<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        submission_index: Option<wgpu::SubmissionIndex>,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if this function has already failed.
            let _ = sender.send(result);
        });
        self.device
            .poll(wgpu::PollType::Wait { submission_index, timeout: Some(self.timeout()) })
            .map_err(|error| self.error(error))?;
        self.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.error(error)),
            Err(error) => return Err(self.error(error)),
        }
        self.taken(buffer, bytes, take)
    }

    /// Passes the first bytes of a mapped buffer to `take`, and unmaps it.
    fn taken<T>(&self, buffer: &wgpu::Buffer, bytes: u64, take: impl FnOnce(&[u8]) -> T) -> Result<T, RenderError> {
        let view = buffer.slice(..bytes).get_mapped_range().map_err(|error| self.error(error))?;
        let taken = take(&view);
        drop(view);
        buffer.unmap();
        Ok(taken)
    }

    /// Fails if the device has reported an error or was lost.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let failure = self.failure.lock().ok().and_then(|slot| slot.clone());
        failure.map_or(Ok(()), |reason| Err(self.error(reason)))
    }

    /// Error of this adapter.
    pub(crate) fn error(&self, reason: impl ToString) -> RenderError {
        RenderError::Device { adapter: self.description.name.clone(), reason: reason.to_string() }
    }
}
