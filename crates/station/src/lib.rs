//! Station libraries: the emitted C, the toolchain that compiles it, and the loader that calls it.
//!
//! [`Controller`] has two implementations: `load::Instance`, a compiled library called through its
//! exports, and `interpret::Interpreter`, the same machine in this process, against which the
//! library is tested.
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
pub use package::{Package, file_stem, is_device};
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

/// An error returned by a controller. The controller is as it was before the call, except after
/// `Limit`, where it has been reset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct CallError {
    /// Error code.
    pub code: ErrorCode,
    /// Name of the rule, component first, for `Assumption`, `Guarantee` and `Order`:
    /// `turn: gripped`.
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
}

/// One running instance of a machine.
pub trait Controller {
    /// Runs an operation (an index into the machine's operations) to its end at one simulated
    /// instant. `values` are those of the machine's properties, in order; the new ones are written
    /// back.
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError>;

    /// Makes one step. `plant` holds the plant's wires; `outputs` receives all components' wires.
    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError>;

    /// Resets the instance to before step 0.
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
        /// The command that was to be started.
        command: String,
        /// Reason of the failure.
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
        /// The command that was started.
        command: String,
        /// Name of the machine.
        machine: String,
        /// Output of the compiler.
        stderr: String,
    },
    /// The compiler was terminated, or not started any more.
    #[error("the library of `{machine}` was not built: {late}")]
    GivenUp {
        /// Name of the machine.
        machine: String,
        /// Time limit or interrupt.
        late: StopReason,
    },
    /// A library differs from what was built.
    #[error("the station library {} is damaged: {reason}", path.display())]
    LibraryDamaged {
        /// Path of the library.
        path: PathBuf,
        /// Kind of damage.
        reason: String,
    },
    /// A library uses another layout of `UF_Value` than the runner.
    #[error("the station library {} is built with {profile}, whose layout of UF_Value is not the one that the bundled runner passes", path.display())]
    ProfileForeign {
        /// Path of the library.
        path: PathBuf,
        /// Name of its profile.
        profile: String,
    },
    /// Something could not be written.
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
    /// Converts the error to a finding that includes the next step.
    pub fn to_diagnostic(&self) -> Diagnostic {
        let (code, help) = match self {
            Self::CompilerMissing { .. } => (
                codes::COMPILER_MISSING,
                "install a C compiler (Debian and Ubuntu: `apt install gcc`; macOS: `xcode-select --install`), or name one in the environment variable CC; `linewright doctor` tries it",
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
                "the emitted C is plain C99: look at what CC and CFLAGS hold; if they are in order, please report this",
            ),
            Self::GivenUp { late, .. } => (
                codes::GAVE_UP,
                match late {
                    StopReason::Time => {
                        "give it more time with --timeout SECONDS; what was built is kept"
                    }
                    StopReason::Interrupt => "run it again; what was built is kept",
                },
            ),
            Self::LibraryDamaged { .. } => {
                (codes::LIBRARY_DAMAGED, "delete it, or run with --rebuild")
            }
            Self::ProfileForeign { .. } => (
                codes::PROFILE_FOREIGN,
                "it is for Plant Simulation alone; `run` builds libraries of its own, and `build` without --profile makes one with the assumed layout",
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

/// Panics if the controllers are not those of the machine's components: an internal error.
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
        "machine `{}` needs one controller a component; please report this",
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

/// Whether everything that a machine's transitions refer to exists. For functions, this is checked
/// with their certificate.
fn is_closed(m: &mealy::Machine) -> bool {
    let mut transitions = m.initial.iter().chain(m.states.iter().flatten());
    transitions.all(|t| {
        let mut tests = t.guard.0.iter().flat_map(|c| &c.0);
        t.output.len() == m.outputs.len()
            && t.to < m.states.len()
            && tests.all(|t| t.input < m.inputs.len())
    })
}
