//! Device with its compiled kernels and passes.

use super::device::Device;
use super::display::DisplayPass;
use super::kernel_cache::KernelCache;
use crate::error::RenderError;
use std::ops::Deref;
use std::sync::OnceLock;

/// Opened device, its kernels and passes.
pub(crate) struct GpuContext {
    pub(crate) opened: Device,
    pub(crate) kernels: KernelCache,
    display: OnceLock<DisplayPass>,
}

impl GpuContext {
    /// Opens the preferred adapter, or the one whose name contains `adapter`, in any case.
    ///
    /// # Errors
    /// [`RenderError`] if there is no such adapter, or the driver refuses.
    pub(crate) fn open(adapter: Option<&str>) -> Result<Self, RenderError> {
        Ok(Self { opened: Device::open(adapter)?, kernels: KernelCache::default(), display: OnceLock::new() })
    }

    /// Opens the adapter that the browser prefers.
    ///
    /// # Errors
    /// [`RenderError`] if it has none, or refuses.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn open_async() -> Result<Self, RenderError> {
        let opened = Device::open_async().await?;
        Ok(Self { opened, kernels: KernelCache::default(), display: OnceLock::new() })
    }

    /// Pass that tone-maps films.
    pub(super) fn display(&self) -> &DisplayPass {
        self.display.get_or_init(|| DisplayPass::new(&self.opened.device))
    }
}

impl Deref for GpuContext {
    type Target = Device;

    fn deref(&self) -> &Device {
        &self.opened
    }
}
