//! Station libraries: the C that is emitted, the toolchain that compiles it, and the loader that calls it.
//!
//! Two things implement [`Controller`]: `load::Instance`, a compiled library called through its exports, and
//! `interpret::Interpreter`, the same machine in this process, against which the library is tested.

/// The codes that a station library answers with; the same numbers as in `ffi/station.h`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(i32)]
pub enum ErrorCode {
    /// A handle that was never given, or is no longer valid.
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
}

/// An error that a controller answered with. The controller is as it was before the call, except after `Limit`, where it
/// has been reset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct CallError {
    /// The code.
    pub code: ErrorCode,
    /// The rule's name, component first, for `Assumption` and `Guarantee`: `turn: gripped`.
    pub rule: Option<String>,
    /// The whole text of `last_error`.
    pub message: String,
}

/// What an operation took.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Service {
    /// Duration in seconds.
    pub seconds: f64,
    /// Energy in joules.
    pub joules: f64,
    /// How many steps the controller made.
    pub steps: u64,
}

/// One running instance of a machine.
pub trait Controller {
    /// Runs an operation (an index into the machine's operations) to its end, at one instant. `values` are those of the
    /// machine's properties, in order; the new ones are written back.
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError>;

    /// Makes one step. `plant` are the plant's wires; `outputs` gets all components' wires.
    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError>;

    /// Back to before step 0.
    fn reset(&mut self);
}
