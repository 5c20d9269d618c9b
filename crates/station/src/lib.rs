//! Station libraries: the emitted C, the toolchain that compiles it, and the loader that calls it.
//!
//! [`Controller`] has two implementations: `load::Instance` calls a compiled library through its
//! exports; `interpret::Interpreter` runs the same machine in this process. The library is tested
//! against the interpreter.
//!
//! ```text
//! contract::machine::Machine, mealy::Controller... ─Package::emit→ Package ─Toolchain::build→ Built ─Library::open→ Library
//!      ─Library::instance→ Instance
//! ```

pub mod composition;
pub mod disk;
pub mod emit;
pub mod fmi;
pub mod interpret;
pub mod load;
pub mod messages;
pub mod monitor;
pub mod package;
pub mod probe;
pub mod profile;
pub mod simtalk;
pub mod structured_text;
mod template;
pub mod toolchain;

use linewright_core::deadline::StopReason;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::machine::Machine;
use linewright_solver::mealy;
pub use package::{Package, file_stem, is_windows_device};
use std::path::PathBuf;
pub use toolchain::Toolchain;

/// Error codes of a station library; the same numbers as in `ffi/station.h`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(i32)]
pub enum ErrorCode {
    /// A handle that was never issued, or is no longer valid.
    Handle = -1,
    /// A null pointer, a wrong tag, or a wrong count.
    Argument = -2,
    /// A value outside its domain.
    Domain = -3,
    /// An operation that the machine does not have.
    Operation = -4,
    /// The plant broke an assumption.
    Assumption = -5,
    /// The machine broke a guarantee: a fault of this program or of the compiler.
    Guarantee = -6,
    /// The operation did not end within the step limit.
    Limit = -7,
    /// No memory, or no free slot for an instance.
    Memory = -8,
    /// A fault of this program.
    Internal = -9,
    /// A skill was called against an order, by the machine or by its caller.
    Order = -10,
}

/// An error returned by a controller. The call leaves the controller's state unchanged, except for
/// `Limit`, which resets the controller.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct CallError {
    /// Error code.
    pub code: ErrorCode,
    /// Name of the violated rule, component first: `turn: gripped`. Set for `Assumption`,
    /// `Guarantee` and `Order`, and for `Limit` if a justice assumption did not hold.
    pub rule: Option<String>,
    /// Complete text of `last_error`.
    pub message: String,
}

/// Cost of an operation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Service {
    /// Duration in seconds.
    pub seconds: f64,
    /// Energy in joules.
    pub joules: f64,
    /// Number of controller steps.
    pub steps: u64,
    /// The part of `seconds` in which no action was active: the time of control.
    pub control_seconds: f64,
}

/// One running instance of a machine.
pub trait Controller {
    /// Runs an operation (an index into the machine's operations) to its end at one simulated
    /// instant. `values` holds the values of the machine's properties, in order, and receives the
    /// new ones.
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError>;

    /// Performs one controller step. `plant` holds the plant's wires; `outputs` receives all
    /// components' wires.
    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError>;

    /// Resets the instance to its state before step 0.
    fn reset(&mut self);
}

impl ErrorCode {
    /// Converts a number returned by a library to an error code.
    pub fn from_number(number: i32) -> Option<Self> {
        [
            Self::Handle,
            Self::Argument,
            Self::Domain,
            Self::Operation,
            Self::Assumption,
            Self::Guarantee,
            Self::Limit,
            Self::Memory,
            Self::Internal,
            Self::Order,
        ]
        .into_iter()
        .find(|code| *code as i32 == number)
    }
}

/// Errors concerning station libraries.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No C compiler of that name exists, or it cannot compile anything.
    #[error("the C compiler `{command}` cannot be used: {cause}")]
    CompilerMissing {
        /// Command of the compiler.
        command: String,
        /// Reason for the failure.
        cause: String,
    },
    /// No C compiler for 64-bit Windows was found.
    #[error("no C compiler for 64-bit Windows was found on this computer")]
    CrossCompilerMissing,
    /// No Microsoft compiler was found.
    #[error("Microsoft's C compiler was not found on this computer")]
    MsvcMissing,
    /// The C compiler reported an error.
    #[error("the C compiler `{command}` failed on the library of `{machine}`:\n{stderr}")]
    CompilerFailed {
        /// Command of the compiler.
        command: String,
        /// Name of the machine.
        machine: String,
        /// Output of the compiler.
        stderr: String,
    },
    /// The time limit or an interrupt stopped the build.
    #[error("the library of `{machine}` was not built: {reason}")]
    GivenUp {
        /// Name of the machine.
        machine: String,
        /// Time limit or interrupt.
        reason: StopReason,
    },
    /// A library differs from its manifest, or cannot be loaded.
    #[error("the station library {} is damaged: {reason}", path.display())]
    LibraryDamaged {
        /// Path of the library.
        path: PathBuf,
        /// Kind of damage.
        reason: String,
    },
    /// A library uses another layout of `UF_Value` than the runner.
    #[error("the station library {} was built with {profile}, whose UF_Value layout differs from the layout that the bundled runner uses", path.display())]
    ProfileForeign {
        /// Path of the library.
        path: PathBuf,
        /// Name of its profile.
        profile: String,
    },
    /// A file or folder could not be written.
    #[error("{} cannot be written: {cause}", path.display())]
    Unwritable {
        /// Path of the file or folder.
        path: PathBuf,
        /// Cause reported by the system.
        cause: std::io::Error,
    },
    /// A call returned an error.
    #[error(transparent)]
    Call(#[from] CallError),
}

impl Error {
    /// Converts the error to a diagnostic with a help text.
    pub fn to_diagnostic(&self) -> Diagnostic {
        let (code, help) = match self {
            Self::CompilerMissing { .. } => (
                codes::COMPILER_MISSING,
                "install a C compiler (Debian and Ubuntu: `apt install gcc`; macOS: `xcode-select --install`), or name one in the environment variable CC; `linewright doctor` tests it",
            ),
            Self::CrossCompilerMissing => (
                codes::CROSS_COMPILER_MISSING,
                "install MinGW (Debian and Ubuntu: `apt install gcc-mingw-w64-x86-64`) or Zig (`pip install ziglang`, or zig on the PATH); `linewright doctor` shows what is found",
            ),
            Self::MsvcMissing => (
                codes::MSVC_MISSING,
                "build on a Windows computer with the Visual Studio Build Tools, or use `--target windows`, whose libraries Windows programs load as well",
            ),
            Self::CompilerFailed { .. } => (
                codes::COMPILER_FAILED,
                "the emitted C is plain C99: check the environment variables CC and CFLAGS; if they are correct, please report this",
            ),
            Self::GivenUp { reason, .. } => (
                codes::GAVE_UP,
                match reason {
                    StopReason::Time => {
                        "allow more time with --timeout SECONDS; finished libraries are kept"
                    }
                    StopReason::Memory => {
                        "allow more memory with --memory MIB; finished libraries are kept"
                    }
                    StopReason::Interrupt => "run it again; finished libraries are kept",
                },
            ),
            Self::LibraryDamaged { .. } => (
                codes::LIBRARY_DAMAGED,
                "delete the library, or run with --rebuild",
            ),
            Self::ProfileForeign { .. } => (
                codes::PROFILE_FOREIGN,
                "use this library only in Plant Simulation; `run` builds its own libraries, and `build` without --profile builds one with the assumed layout",
            ),
            Self::Unwritable { .. } => (
                codes::OUTPUT_UNWRITABLE,
                "choose another folder with --out, or make this one writable",
            ),
            Self::Call(_) => (
                codes::LIBRARY_CALL,
                "the message names what was expected; `linewright explain LW505` lists the codes",
            ),
        };
        Diagnostic::error(code, None, self.to_string()).with_help(help)
    }
}

/// Checks that each controller fits the contract of its component, and that their counts agree.
///
/// # Panics
/// Panics if a controller does not fit, which is an internal error.
fn assert_fit(machine: &Machine, controllers: &[mealy::Controller]) {
    let fit = |c: &linewright_language::contract::machine::Component, k: &mealy::Controller| {
        let specification = &c.specification;
        specification.inputs().count() == k.inputs().len()
            && c.bindings.len() == k.inputs().len()
            && specification.outputs().count() == k.outputs().len()
            && specification.timing == k.timing()
            && k.machine().is_none_or(is_closed)
    };
    assert_eq!(
        machine.components.len(),
        controllers.len(),
        "machine `{}` needs one controller per component; please report this",
        machine.name
    );
    for (component, controller) in machine.components.iter().zip(controllers) {
        assert!(
            fit(component, controller),
            "the controller of `{}.{}` does not fit its contract; please report this",
            machine.name,
            component.name
        );
    }
}

/// Whether all inputs, outputs and states that a Mealy machine's transitions refer to exist. For a
/// controller as functions, the check of its certificate covers this.
fn is_closed(m: &mealy::Machine) -> bool {
    let mut transitions = m.initial.iter().chain(m.states.iter().flatten());
    transitions.all(|t| {
        let mut tests = t.guard.0.iter().flat_map(|c| &c.0);
        t.output.len() == m.outputs.len()
            && t.to < m.states.len()
            && tests.all(|t| t.input < m.inputs.len())
    })
}
