//! Intel Open Image Denoise, for comparison: a neural network, in a shared library that is found at run time.
//!
//! **Idea.** Nothing of the library is needed to build or run this crate. [`Library::open`] loads it if it is installed;
//! otherwise the error lists the names that it was looked for. The albedo and the normals of the first surfaces guide
//! it.
//!
//! **Source.** The C interface of Open Image Denoise, versions 1.4 to 2.x, openimagedenoise.org/documentation.html.
//!
//! **Safety.** All unsafe code of the crate is here. The signatures of the functions are those of `oidn.h`. The images
//! that a filter reads and writes outlive its execution, and each has three floats for every pixel.

use super::DenoiseError;
use glam::Vec3;
use libloading::Symbol;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::{from_ref, null, null_mut};

/// Environment variable with the path of the library.
pub const LIBRARY_VARIABLE: &str = "OIDN_LIBRARY";

/// File names of the library, the latest version first.
#[cfg(target_os = "macos")]
const NAMES: [&str; 3] = ["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.1.dylib", "libOpenImageDenoise.dylib"];
#[cfg(windows)]
const NAMES: [&str; 1] = ["OpenImageDenoise.dll"];
#[cfg(not(any(target_os = "macos", windows)))]
const NAMES: [&str; 3] = ["libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so"];

/// Type of a device that runs on the CPU (`OIDN_DEVICE_TYPE_CPU`).
const CPU_DEVICE: c_int = 1;
/// Format of three floats a pixel (`OIDN_FORMAT_FLOAT3`).
const FLOAT3: c_int = 3;

/// Device or filter of the library.
type Handle = *mut c_void;
type NewDevice = unsafe extern "C" fn(c_int) -> Handle;
type NewFilter = unsafe extern "C" fn(Handle, *const c_char) -> Handle;
type SetImage = unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
type SetBool = unsafe extern "C" fn(Handle, *const c_char, bool);
type Act = unsafe extern "C" fn(Handle);
type GetError = unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int;

/// Images of a picture of one size, the top row first.
pub(super) struct Images<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Noisy radiance.
    pub(super) colour: &'a [Vec3],
    /// Albedo, 0 to 1.
    pub(super) albedo: &'a [Vec3],
    /// Normals, of length up to 1.
    pub(super) normal: &'a [Vec3],
}

/// Loaded library.
pub(super) struct Library(libloading::Library);

impl Library {
    /// Loads the library from the path in [`LIBRARY_VARIABLE`], or from where the system looks for libraries.
    pub(super) fn open() -> Result<Self, DenoiseError> {
        let chosen = std::env::var(LIBRARY_VARIABLE).ok().filter(|path| !path.is_empty());
        let names: Vec<String> = chosen.map_or_else(|| NAMES.map(str::to_owned).to_vec(), |path| vec![path]);
        let mut reasons = Vec::new();
        for name in &names {
            // SAFETY: the initialisation of the library has no preconditions.
            match unsafe { libloading::Library::new(name) } {
                Ok(library) => return Ok(Self(library)),
                Err(error) => reasons.push(error.to_string()),
            }
        }
        Err(DenoiseError::NoLibrary { names, reason: reasons.join("; ") })
    }

    /// Function of this name.
    ///
    /// # Safety
    /// The type must be the signature of the function.
    unsafe fn function<T>(&self, name: &str) -> Result<Symbol<'_, T>, DenoiseError> {
        // SAFETY: that of the caller.
        unsafe { self.0.get(name.as_bytes()) }.map_err(|error| DenoiseError::Library(error.to_string()))
    }

    /// Denoised radiance.
    pub(super) fn filter(&self, images: &Images) -> Result<Vec<Vec3>, DenoiseError> {
        let mut output = vec![Vec3::ZERO; images.colour.len()];
        // SAFETY: the signatures are those of `oidn.h`. Handles are used between their creation and their release. All
        // images have `width * height` pixels, are borrowed until the filter is released, and the filter writes to
        // `output` only.
        unsafe {
            let new_device: Symbol<NewDevice> = self.function("oidnNewDevice")?;
            let commit_device: Symbol<Act> = self.function("oidnCommitDevice")?;
            let new_filter: Symbol<NewFilter> = self.function("oidnNewFilter")?;
            let commit_filter: Symbol<Act> = self.function("oidnCommitFilter")?;
            let execute_filter: Symbol<Act> = self.function("oidnExecuteFilter")?;
            let release_filter: Symbol<Act> = self.function("oidnReleaseFilter")?;
            let release_device: Symbol<Act> = self.function("oidnReleaseDevice")?;
            let set_image: Symbol<SetImage> = self.function("oidnSetSharedFilterImage")?;
            // Version 2 has renamed it.
            let set_bool: Symbol<SetBool> =
                self.function("oidnSetFilterBool").or_else(|_| self.function("oidnSetFilter1b"))?;

            let device = new_device(CPU_DEVICE);
            self.check(null_mut(), device)?;
            commit_device(device);
            let filter = new_filter(device, c"RT".as_ptr());
            let (width, height) = (images.width, images.height);
            let image = |name: &CStr, pixels: *mut c_void| {
                set_image(filter, name.as_ptr(), pixels, FLOAT3, width, height, 0, size_of::<Vec3>(), 0);
            };
            let inputs = [(c"color", images.colour), (c"albedo", images.albedo), (c"normal", images.normal)];
            for (name, pixels) in inputs {
                assert_eq!(pixels.len(), width * height, "an image of another size");
                image(name, from_ref(pixels).cast::<c_void>().cast_mut());
            }
            image(c"output", output.as_mut_ptr().cast());
            set_bool(filter, c"hdr".as_ptr(), true);
            commit_filter(filter);
            execute_filter(filter);
            let result = self.check(device, filter);
            release_filter(filter);
            release_device(device);
            result?;
        }
        Ok(output)
    }

    /// Reports the latest error of a device, or of the thread if it is null, and a null `handle`.
    ///
    /// # Safety
    /// The device must be null or valid.
    unsafe fn check(&self, device: Handle, handle: Handle) -> Result<(), DenoiseError> {
        let mut message: *const c_char = null();
        // SAFETY: the signature is that of `oidn.h`; the message is valid until the next call.
        let (code, text) = unsafe {
            let get_error: Symbol<GetError> = self.function("oidnGetDeviceError")?;
            let code = get_error(device, &raw mut message);
            let text =
                if message.is_null() { None } else { Some(CStr::from_ptr(message).to_string_lossy().into_owned()) };
            (code, text)
        };
        if code == 0 && !handle.is_null() {
            return Ok(());
        }
        Err(DenoiseError::Library(text.unwrap_or_else(|| format!("error {code}"))))
    }
}
