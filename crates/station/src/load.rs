//! Loads station libraries and calls them.
//!
//! An operation is called through the exports that Plant Simulation calls (`instantiate`,
//! `simulate`, `get_real`, `deinstantiate`), so that the bundled runner runs the shipped code. A
//! single step, which Plant Simulation does not use, calls `lw_step`. Arguments use the assumed
//! layout of `UF_Value`, which can differ from Plant Simulation's; a library built with another
//! layout is rejected. Before a library is loaded, it is compared with its manifest, because
//! loading a truncated file would kill this process.

use super::profile::Profile;
use super::toolchain::Manifest;
use super::{CallError, Controller, Error, ErrorCode, Service};
use serde_json::Value;
use std::ffi::{CStr, CString, c_char, c_int};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `UF_Value` of the default profile, as declared in `ffi/uf_value.h`.
#[repr(C)]
#[derive(Clone, Copy)]
struct UfValue {
    tag: c_int,
    value: UfUnion,
}

#[repr(C)]
#[derive(Clone, Copy)]
union UfUnion {
    integer: i32,
    real: f64,
    string: *const c_char,
}

const TAG_INTEGER: c_int = 1;
const TAG_REAL: c_int = 2;
const TAG_STRING: c_int = 3;

/// Number of results of an operation before the properties.
const OWN_RESULTS: usize = 3;

/// Value returned by an export.
enum Answer {
    Integer(i32),
    Real(f64),
    Other,
}

impl UfValue {
    const NOTHING: Self = Self {
        tag: 0,
        value: UfUnion { real: 0.0 },
    };

    fn integer(integer: i32) -> Self {
        Self {
            tag: TAG_INTEGER,
            value: UfUnion { integer },
        }
    }

    fn real(real: f64) -> Self {
        Self {
            tag: TAG_REAL,
            value: UfUnion { real },
        }
    }

    fn string(text: &CStr) -> Self {
        Self {
            tag: TAG_STRING,
            value: UfUnion {
                string: text.as_ptr(),
            },
        }
    }

    fn answer(&self) -> Answer {
        match self.tag {
            #[expect(unsafe_code, reason = "the tag determines which field was written")]
            // SAFETY: every field is valid for any bits.
            TAG_INTEGER => Answer::Integer(unsafe { self.value.integer }),
            #[expect(unsafe_code, reason = "the tag determines which field was written")]
            // SAFETY: every field is valid for any bits.
            TAG_REAL => Answer::Real(unsafe { self.value.real }),
            _ => Answer::Other,
        }
    }
}

type Export = unsafe extern "C" fn(*mut UfValue, *mut UfValue);
type StepExport = unsafe extern "C" fn(i32, *const i64, usize, *mut i64, usize) -> i32;
type TextExport = unsafe extern "C" fn(i32, *mut c_char, usize) -> i32;

/// A loaded station library.
pub struct Library {
    path: PathBuf,
    description: Value,
    /// Results that an instance reads after an operation: energy, steps, time of control, then each
    /// property.
    results: Vec<CString>,
    /// Whether a step without an active action takes time.
    control_takes_time: bool,
    plant_count: usize,
    output_count: usize,
    instantiate: Export,
    simulate: Export,
    get_real: Export,
    reset: Export,
    deinstantiate: Export,
    step: StepExport,
    last_error: TextExport,
    last_rule: TextExport,
    // Keeps the library loaded, so that the functions above stay valid.
    _keep: libloading::Library,
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Library")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Library {
    /// Loads a library that [`Toolchain::build`](super::Toolchain::build) made, after comparing it
    /// with its manifest.
    pub fn open(path: &Path) -> Result<Arc<Self>, Error> {
        Manifest::verify(path)?;
        let damaged = |reason: String| Error::LibraryDamaged {
            path: path.to_owned(),
            reason,
        };
        // The path must contain a folder, because the system would otherwise search its own library
        // folders.
        let absolute = std::path::absolute(path).map_err(|e| damaged(e.to_string()))?;
        #[expect(unsafe_code, reason = "the loader of station libraries")]
        // SAFETY: the file is byte for byte the output of our compiler run on our own C source,
        // which has no constructors.
        let library =
            unsafe { libloading::Library::new(absolute) }.map_err(|e| damaged(e.to_string()))?;
        let library = Self::bind(path, library).map_err(damaged)?;
        // Up to here, only exports without `UF_Value` arguments have been called.
        let profile = &library.description["profile"];
        let expected = serde_json::json!(Profile::assumed().layout);
        if profile["layout"] != expected {
            return Err(Error::ProfileForeign {
                path: path.to_owned(),
                profile: format!("profile {}", profile["name"]),
            });
        }
        Ok(library)
    }

    fn bind(path: &Path, library: libloading::Library) -> Result<Arc<Self>, String> {
        #[expect(unsafe_code, reason = "the loader of station libraries")]
        // SAFETY: every type below is the one that `ffi/station.h` and `ffi/plant_simulation.c`
        // declare for that name. The description is a static text that ends with a zero byte.
        unsafe {
            fn find<T: Copy>(library: &libloading::Library, name: &str) -> Result<T, String> {
                #[expect(unsafe_code, reason = "the loader of station libraries")]
                // SAFETY: the caller names the declared type, as justified above.
                unsafe { library.get::<T>(name) }
                    .map(|symbol| *symbol)
                    .map_err(|e| e.to_string())
            }
            let version: unsafe extern "C" fn() -> i32 = find(&library, "lw_abi_version")?;
            if version() != super::toolchain::ABI_VERSION {
                return Err(format!(
                    "its interface has version {}, not {}",
                    version(),
                    super::toolchain::ABI_VERSION
                ));
            }
            let describe: unsafe extern "C" fn() -> *const c_char = find(&library, "lw_describe")?;
            let description = CStr::from_ptr(describe()).to_bytes();
            let description: Value =
                serde_json::from_slice(description).map_err(|e| e.to_string())?;
            let count = |name: &str| -> Result<usize, String> {
                let count: unsafe extern "C" fn() -> i32 = find(&library, name)?;
                usize::try_from(count()).map_err(|e| e.to_string())
            };
            Ok(Arc::new(Self {
                path: path.to_owned(),
                results: result_names(&description)?,
                control_takes_time: description["step_seconds"].as_f64() != Some(0.0),
                description,
                plant_count: count("lw_plant_count")?,
                output_count: count("lw_output_count")?,
                instantiate: find(&library, "instantiate")?,
                simulate: find(&library, "simulate")?,
                get_real: find(&library, "get_real")?,
                reset: find(&library, "reset")?,
                deinstantiate: find(&library, "deinstantiate")?,
                step: find(&library, "lw_step")?,
                last_error: find(&library, "lw_last_error")?,
                last_rule: find(&library, "lw_last_rule")?,
                _keep: library,
            }))
        }
    }

    /// Path of the library file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Description of the machine: the JSON that `lw_describe` returns.
    pub fn description(&self) -> &Value {
        &self.description
    }

    /// Creates an instance in its state before step 0.
    pub fn instance(self: &Arc<Self>) -> Result<Instance, CallError> {
        let handle = match call(self.instantiate, &mut []) {
            Answer::Integer(handle) if handle > 0 => handle,
            Answer::Integer(code) => return Err(self.error(0, code)),
            _ => return Err(unexpected("instantiate")),
        };
        Ok(Instance {
            library: Arc::clone(self),
            handle,
            arguments: Vec::with_capacity(self.results.len() + 2),
        })
    }

    /// Builds the error for a negative code from the texts that the library recorded.
    fn error(&self, handle: i32, number: i32) -> CallError {
        let Some(code) = ErrorCode::from_number(number) else {
            return unexpected("a call");
        };
        let rule = text(self.last_rule, handle);
        CallError {
            code,
            rule: Some(rule).filter(|r| !r.is_empty()),
            message: text(self.last_error, handle),
        }
    }
}

/// Calls an export. The length of `arguments` must be the number of arguments that it takes.
fn call(export: Export, arguments: &mut [UfValue]) -> Answer {
    let mut answer = UfValue::NOTHING;
    #[expect(unsafe_code, reason = "the loader of station libraries")]
    // SAFETY: the export reads exactly the arguments in its documentation, which the callers below
    // pass, and writes one answer; texts among the arguments live until the export returns.
    unsafe {
        export(&raw mut answer, arguments.as_mut_ptr());
    }
    answer.answer()
}

/// Reads a text about an instance from the library.
fn text(export: TextExport, handle: i32) -> String {
    let mut buffer = vec![0_u8; 1024];
    #[expect(unsafe_code, reason = "the loader of station libraries")]
    // SAFETY: the export writes at most the given number of bytes, the last one a zero.
    unsafe {
        export(handle, buffer.as_mut_ptr().cast(), buffer.len());
    }
    let length = buffer.iter().position(|&b| b == 0).unwrap_or(0);
    String::from_utf8_lossy(&buffer[..length]).into_owned()
}

/// Names of the results that an instance reads after an operation, from the description.
fn result_names(description: &Value) -> Result<Vec<CString>, String> {
    let properties = description["properties"]
        .as_array()
        .ok_or("its description lists no properties")?;
    let mut names = vec![
        c"joules".to_owned(),
        c"steps".to_owned(),
        c"control_time".to_owned(),
    ];
    for property in properties {
        let name = property["name"].as_str().unwrap_or_default();
        names.push(CString::new(format!("property.{name}")).map_err(|e| e.to_string())?);
    }
    Ok(names)
}

fn unexpected(what: &str) -> CallError {
    CallError {
        code: ErrorCode::Internal,
        rule: None,
        message: format!("{what} of the station library returned an unexpected value"),
    }
}

/// A running instance of a loaded library; dropping it ends the instance.
pub struct Instance {
    library: Arc<Library>,
    handle: i32,
    arguments: Vec<UfValue>,
}

#[expect(unsafe_code, reason = "the loader of station libraries")]
// SAFETY: the library can be called from any thread; the pointers in `arguments` are not used
// between calls.
unsafe impl Send for Instance {}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance")
            .field("library", &self.library)
            .field("handle", &self.handle)
            .finish_non_exhaustive()
    }
}

impl Instance {
    /// Handle of the instance in the library.
    pub fn handle(&self) -> i32 {
        self.handle
    }

    /// Library of the instance.
    pub fn library(&self) -> &Arc<Library> {
        &self.library
    }

    /// Calls `simulate` with an operation and the values of all properties, and returns the
    /// duration in seconds. The other results stay in the library.
    pub fn serve(&mut self, operation: usize, values: &[f64]) -> Result<f64, CallError> {
        let Ok(index) = i32::try_from(operation) else {
            return Err(CallError::operation(operation));
        };
        // The export does not receive the number of values, so the number is checked here.
        if values.len() + OWN_RESULTS != self.library.results.len() {
            return Err(CallError::value_count());
        }
        self.arguments.clear();
        self.arguments.push(UfValue::integer(self.handle));
        self.arguments.push(UfValue::integer(index));
        self.arguments
            .extend(values.iter().map(|v| UfValue::real(*v)));
        match call(self.library.simulate, &mut self.arguments) {
            Answer::Real(seconds) if seconds >= 0.0 => Ok(seconds),
            Answer::Real(code) => Err(self.library.error(self.handle, code as i32)),
            _ => Err(unexpected("simulate")),
        }
    }

    fn result(&mut self, index: usize) -> Result<f64, CallError> {
        let library = &self.library;
        let name = UfValue::string(&library.results[index]);
        let mut arguments = [UfValue::integer(self.handle), name];
        match call(library.get_real, &mut arguments) {
            Answer::Real(value) => Ok(value),
            Answer::Integer(code) => Err(library.error(self.handle, code)),
            Answer::Other => Err(unexpected("get_real")),
        }
    }
}

impl Controller for Instance {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        let seconds = self.serve(operation, values)?;
        let service = Service {
            seconds,
            joules: self.result(0)?,
            steps: self.result(1)? as u64,
            control_seconds: if self.library.control_takes_time {
                self.result(2)?
            } else {
                0.0
            },
        };
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.result(i + OWN_RESULTS)?;
        }
        Ok(service)
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        let library = &self.library;
        if plant.len() != library.plant_count {
            return Err(CallError::plant_count());
        }
        if outputs.len() != library.output_count {
            return Err(CallError::output_count());
        }
        #[expect(unsafe_code, reason = "the loader of station libraries")]
        // SAFETY: both slices have the given lengths, which the library checks against its own
        // counts. The pointer is null only if the machine has no outputs.
        let code = unsafe {
            let room = if outputs.is_empty() {
                std::ptr::null_mut()
            } else {
                outputs.as_mut_ptr()
            };
            (library.step)(
                self.handle,
                plant.as_ptr(),
                plant.len(),
                room,
                outputs.len(),
            )
        };
        if code == 0 {
            Ok(())
        } else {
            Err(library.error(self.handle, code))
        }
    }

    fn reset(&mut self) {
        let mut arguments = [UfValue::integer(self.handle)];
        call(self.library.reset, &mut arguments);
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let mut arguments = [UfValue::integer(self.handle)];
        call(self.library.deinstantiate, &mut arguments);
    }
}
