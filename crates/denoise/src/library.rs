//! The library itself: found at run time, called through its C interface (`OpenImageDenoise/oidn.h`,
//! version 2).

use crate::DenoiseError;
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};

/// Names under which systems know the library, where it is not named.
const NAMES: &[&str] = if cfg!(target_os = "windows") {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// `OIDN_DEVICE_TYPE_CPU`: its memory is ours, whatever other devices there are.
const DEVICE_CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FORMAT_FLOAT3: c_int = 3;

type Object = *mut c_void;

/// Declares the functions of the library that are called, and how they are found.
macro_rules! functions {
    ($($field:ident = $name:literal : fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library.
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            fn of(library: &Library) -> Result<Self, libloading::Error> {
                #[expect(unsafe_code, reason = "functions of a foreign library have no types to check")]
                // SAFETY: the types are those that the header declares for these names.
                unsafe {
                    Ok(Self { $($field: *library.get($name)?,)* })
                }
            }
        }
    };
}

functions! {
    new_device = b"oidnNewDevice\0": fn(c_int) -> Object;
    set_device_bool = b"oidnSetDeviceBool\0": fn(Object, *const c_char, bool);
    set_device_int = b"oidnSetDeviceInt\0": fn(Object, *const c_char, c_int);
    commit_device = b"oidnCommitDevice\0": fn(Object);
    device_error = b"oidnGetDeviceError\0": fn(Object, *mut *const c_char) -> c_int;
    release_device = b"oidnReleaseDevice\0": fn(Object);
    new_filter = b"oidnNewFilter\0": fn(Object, *const c_char) -> Object;
    set_image = b"oidnSetSharedFilterImage\0":
        fn(Object, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool = b"oidnSetFilterBool\0": fn(Object, *const c_char, bool);
    commit_filter = b"oidnCommitFilter\0": fn(Object);
    execute_filter = b"oidnExecuteFilter\0": fn(Object);
    release_filter = b"oidnReleaseFilter\0": fn(Object);
}

/// Intel Open Image Denoise, ready to work on this machine's processors.
pub struct Denoiser {
    functions: Functions,
    device: Object,
    path: PathBuf,
    /// Where the functions lie; dropped last.
    _library: Library,
}

impl Denoiser {
    /// Finds and starts the library: at `named`, a library or the folder that holds it, if given, else
    /// where the system finds libraries. It works on `threads` threads, on as many as it likes where that
    /// is 0.
    ///
    /// # Errors
    /// No library, or not version 2 of this one; a machine that it does not work on.
    pub fn open(named: Option<&Path>, threads: usize) -> Result<Self, DenoiseError> {
        let candidates: Vec<PathBuf> = match named {
            Some(folder) if folder.is_dir() => NAMES.iter().map(|name| folder.join(name)).collect(),
            Some(library) => vec![library.to_path_buf()],
            None => NAMES.iter().map(PathBuf::from).collect(),
        };
        let mut tried = Vec::new();
        for path in candidates {
            #[expect(unsafe_code, reason = "a library is loaded while the program runs")]
            // SAFETY: loading runs the initialisers of a library that the user or the system names as
            // this one; they ask nothing of the program.
            let loaded = unsafe { Library::new(&path) };
            match loaded {
                Ok(library) => return Self::start(library, path, threads),
                Err(error) => tried.push(format!("{}: {}", path.display(), said(&error))),
            }
        }
        Err(DenoiseError::NotFound { tried: tried.join("; ") })
    }

    fn start(library: Library, path: PathBuf, threads: usize) -> Result<Self, DenoiseError> {
        let functions = match Functions::of(&library) {
            Ok(functions) => functions,
            Err(error) => return Err(DenoiseError::Unsuitable { path, what: said(&error) }),
        };
        #[expect(unsafe_code, reason = "calls into a foreign library")]
        // SAFETY: the function was found in the library, which is still loaded, and takes any type.
        let device = unsafe { (functions.new_device)(DEVICE_CPU) };
        if device.is_null() {
            return Err(DenoiseError::Failed("it has no device for this machine".into()));
        }
        let denoiser = Self { functions, device, path, _library: library };
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        let functions = &denoiser.functions;
        #[expect(unsafe_code, reason = "calls into a foreign library")]
        // SAFETY: the device is not null and lives until `denoiser` is dropped; names end with a zero.
        unsafe {
            // Threads that are tied to processors slow down whatever else runs there.
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.set_device_int)(device, c"numThreads".as_ptr(), threads);
            (functions.commit_device)(device);
        }
        denoiser.check()?;
        Ok(denoiser)
    }

    /// The library as it was found.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes noise from `width` x `height` scene-linear colours, row-major, by the guides of their
    /// pixels: diffuse albedo in [0, 1], and normal.
    ///
    /// # Errors
    /// Not one value per pixel; what the library refuses.
    pub fn denoise(
        &self,
        [width, height]: [usize; 2],
        colour: &[[f32; 3]],
        albedo: &[[f32; 3]],
        normal: &[[f32; 3]],
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let pixels = width.saturating_mul(height);
        let images = [(c"color", colour), (c"albedo", albedo), (c"normal", normal)];
        if let Some((_, image)) = images.iter().find(|(_, image)| image.len() != pixels) {
            return Err(DenoiseError::Size { values: image.len(), pixels });
        }
        let mut clean = vec![[0.0f32; 3]; pixels];
        let functions = &self.functions;
        #[expect(unsafe_code, reason = "calls into a foreign library")]
        // SAFETY: the device lives as long as `self`. Every image has `width * height` pixels of three
        // floats without gaps, as was checked, and outlives the filter, which is released below. The
        // library writes to the output alone, which is not borrowed elsewhere; the others it reads, though
        // its interface takes them all as writable.
        let filtered = unsafe {
            let filter = (functions.new_filter)(self.device, c"RT".as_ptr());
            if !filter.is_null() {
                let set = |name: &CStr, data: *mut c_void| {
                    (functions.set_image)(
                        filter,
                        name.as_ptr(),
                        data,
                        FORMAT_FLOAT3,
                        width,
                        height,
                        0,
                        0,
                        0,
                    );
                };
                images.iter().for_each(|(name, image)| set(name, image.as_ptr() as *mut c_void));
                set(c"output", clean.as_mut_ptr().cast());
                (functions.set_filter_bool)(filter, c"hdr".as_ptr(), true);
                (functions.commit_filter)(filter);
                (functions.execute_filter)(filter);
                (functions.release_filter)(filter);
            }
            !filter.is_null()
        };
        self.check()?;
        if filtered { Ok(clean) } else { Err(DenoiseError::Failed("it has no filter RT".into())) }
    }

    /// # Errors
    /// The first error of the device that was not told yet.
    fn check(&self) -> Result<(), DenoiseError> {
        let mut message: *const c_char = std::ptr::null();
        #[expect(unsafe_code, reason = "calls into a foreign library")]
        // SAFETY: the device lives as long as `self`; a message that is given ends with a zero and lives
        // until the device is asked again, after it was copied.
        unsafe {
            if (self.functions.device_error)(self.device, &raw mut message) == 0 {
                return Ok(());
            }
            let text =
                if message.is_null() { c"no reason is given" } else { CStr::from_ptr(message) };
            Err(DenoiseError::Failed(text.to_string_lossy().into_owned()))
        }
    }
}

impl Drop for Denoiser {
    fn drop(&mut self) {
        #[expect(unsafe_code, reason = "calls into a foreign library")]
        // SAFETY: the device is released once, and the library that holds the function is still loaded.
        unsafe {
            (self.functions.release_device)(self.device);
        }
    }
}

/// What the system said, which `libloading` keeps as the cause of its own words.
fn said(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}
