//! GPU of a live renderer: opening, compilation in the background, loss and recovery.

use super::background::lower_priority;
use super::shared::Shared;
use crate::backend::RenderInput;
use crate::backend::gpu::{self, GpuContext, GpuJob, KernelSource};
use crate::error::RenderError;
use crate::job::Backend;
use crate::job::tracer::Tracer;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Number of times that a lost device is opened again.
const MAX_REOPENINGS: u32 = 3;
/// Delay before a lost device is opened again.
const REOPEN_DELAY: Duration = Duration::from_secs(1);

/// State of the device.
enum DeviceState {
    /// Not asked for, or given up.
    None,
    /// Opened with the first kernel, not before `from`.
    Closed { from: Instant },
    /// Opened.
    Open(Arc<GpuContext>),
}

/// Result of a compilation.
struct Compiled {
    /// Device, if it could be opened.
    device: Option<Arc<GpuContext>>,
    /// Success if the device's kernel cache contains the kernel.
    result: Result<(), RenderError>,
}

/// Device, and the kernel of the present scene.
pub(super) struct LiveGpu {
    /// Part of the adapter's name.
    adapter: Option<String>,
    /// True if a software adapter may be used.
    accepts_software: bool,
    device: DeviceState,
    reopenings: u32,
    /// Source of the scene's kernel.
    source: Option<KernelSource>,
    compiling: Option<Receiver<Compiled>>,
    /// True if the device cannot render the present scene.
    refused: bool,
}

/// Runs `work`; turns a panic of a driver into an error.
fn catch_panic<T>(work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(RenderError::Device { adapter: "the GPU".to_owned(), reason: "its driver failed".to_owned() })
    })
}

impl LiveGpu {
    pub(super) fn new(backend: Backend, adapter: Option<String>) -> Self {
        Self {
            accepts_software: backend == Backend::Gpu || adapter.is_some(),
            adapter,
            device: match backend {
                Backend::Cpu => DeviceState::None,
                Backend::Auto | Backend::Gpu => DeviceState::Closed { from: Instant::now() },
            },
            reopenings: 0,
            source: None,
            compiling: None,
            refused: false,
        }
    }

    /// Opened device.
    pub(super) fn device(&self) -> Option<&Arc<GpuContext>> {
        match &self.device {
            DeviceState::Open(device) => Some(device),
            DeviceState::None | DeviceState::Closed { .. } => None,
        }
    }

    /// True while a kernel is being compiled.
    pub(super) fn is_compiling(&self) -> bool {
        self.compiling.is_some()
    }

    /// Time at which a lost device is to be opened again.
    pub(super) fn reopens_at(&self) -> Option<Instant> {
        match self.device {
            DeviceState::Closed { from } if self.compiling.is_none() && !self.refused => Some(from),
            _ => None,
        }
    }

    /// Forgets the kernel of the last scene.
    pub(super) fn start_scene(&mut self) {
        self.source = None;
        self.refused = false;
    }

    /// Starts to compile the kernel of `input`, unless it is compiled or being compiled.
    pub(super) fn compile(&mut self, input: &RenderInput, shared: &Arc<Shared>) {
        if self.compiling.is_some() || self.refused {
            return;
        }
        let device = match &self.device {
            DeviceState::None => return,
            DeviceState::Open(device) => Some(device.clone()),
            DeviceState::Closed { from } if *from > Instant::now() => return,
            DeviceState::Closed { .. } => None,
        };
        if let Some(device) = &device {
            let source = KernelSource::new(input, device);
            let ready = source.is_compiled(&device.kernels);
            self.source = Some(source);
            if ready {
                return;
            }
        }
        // A picture of one workgroup is enough: drivers compile for it.
        let mut sample = input.clone();
        (sample.frame.width, sample.frame.height) = (8, 8);
        let (adapter, accepts_software) = (self.adapter.clone(), self.accepts_software);
        let (sender, receiver) = channel();
        let waker = shared.clone();
        let work = move || {
            lower_priority();
            // The receiver is gone if the renderer has ended.
            let _ = sender.send(open_and_compile(device, adapter.as_deref(), accepts_software, &sample));
            waker.wake();
        };
        match std::thread::Builder::new().name("compile".to_owned()).spawn(work) {
            Ok(_) => self.compiling = Some(receiver),
            Err(error) => shared.set_notice(error.to_string()),
        }
    }

    /// Waits for the compilation, at most for `timeout`.
    pub(super) fn wait_for_kernel(&mut self, timeout: Duration, shared: &Shared) {
        if let Some(Ok(compiled)) = self.compiling.as_ref().map(|compiling| compiling.recv_timeout(timeout)) {
            self.finish(compiled, shared);
        }
    }

    /// Takes the result of a finished compilation; returns false if there is none.
    pub(super) fn poll_kernel(&mut self, shared: &Shared) -> bool {
        let compiled = self.compiling.as_ref().and_then(|compiling| compiling.try_recv().ok());
        compiled.map(|compiled| self.finish(compiled, shared)).is_some()
    }

    fn finish(&mut self, Compiled { device, result }: Compiled, shared: &Shared) {
        self.compiling = None;
        if let Some(device) = device {
            let wanted = self.accepts_software || !device.is_software();
            self.device = if wanted { DeviceState::Open(device) } else { DeviceState::None };
        }
        match result {
            Ok(()) => {}
            Err(error) if self.device().is_some_and(|device| device.check().is_ok()) => self.refuse(&error, shared),
            Err(error) => self.lose(&error, shared),
        }
    }

    /// Device and kernel of the present scene, if it is compiled.
    fn kernel(&self) -> Option<(&Arc<GpuContext>, &KernelSource)> {
        let (device, source) = (self.device()?, self.source.as_ref()?);
        (!self.refused && source.is_compiled(&device.kernels)).then_some((device, source))
    }

    /// True if the kernel of the present scene is compiled.
    pub(super) fn has_kernel(&self) -> bool {
        self.kernel().is_some()
    }

    /// Tracer on the GPU; `None` if the kernel is not compiled.
    pub(super) fn tracer(&self, input: &RenderInput, first_sample: u32) -> Option<Result<Tracer, RenderError>> {
        let (device, source) = self.kernel()?;
        let job = GpuJob::of_source(device.clone(), input, source, first_sample, gpu::LIVE);
        Some(job.map(|job| Tracer::Gpu(Box::new(job))))
    }

    /// Leaves the present scene to the CPU.
    pub(super) fn refuse(&mut self, error: &RenderError, shared: &Shared) {
        self.refused = true;
        shared.set_notice(format!("{error}: rendering on the CPU"));
    }

    /// Closes a device that has failed; opens it again later, unless that makes no sense.
    pub(super) fn lose(&mut self, error: &RenderError, shared: &Shared) {
        let may_reopen = self.reopenings < MAX_REOPENINGS;
        self.reopenings += 1;
        self.device = match error {
            RenderError::Device { .. } if may_reopen => DeviceState::Closed { from: Instant::now() + REOPEN_DELAY },
            _ => DeviceState::None,
        };
        self.compiling = None;
        self.source = None;
        shared.set_notice(format!("{error}: rendering on the CPU"));
    }
}

/// Opens the adapter if there is no device yet, and compiles the kernel of `input`.
fn open_and_compile(
    device: Option<Arc<GpuContext>>,
    adapter: Option<&str>,
    accepts_software: bool,
    input: &RenderInput,
) -> Compiled {
    let opened = match device {
        Some(device) => Ok(device),
        None => catch_panic(|| GpuContext::open(adapter).map(Arc::new)),
    };
    match opened {
        Err(error) => Compiled { device: None, result: Err(error) },
        Ok(device) if device.is_software() && !accepts_software => Compiled { device: Some(device), result: Ok(()) },
        Ok(device) => {
            let result = catch_panic(|| GpuJob::new(device.clone(), input, 0, gpu::LIVE).map(drop));
            Compiled { device: Some(device), result }
        }
    }
}
