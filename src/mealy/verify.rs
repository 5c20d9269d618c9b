//! Checks a machine against its specification without the solver: every transition against safety, every fair cycle
//! against justice.

use super::Machine;
use crate::game::{Limit, Limits};
use crate::gr1::Specification;

/// What a machine does wrong, with the play that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The formula's name, or what else is wrong (no transition for a legal input).
    pub rule: String,
    /// The valuations of all variables, step by step, up to the violation.
    pub trace: Vec<Vec<i64>>,
    /// For a justice formula: the step to which the play returns for ever.
    pub repeats_from: Option<usize>,
}

/// Checks a machine. `Ok(Ok(()))` is: it keeps its contract.
pub fn verify(
    specification: &Specification,
    machine: &Machine,
    limits: &Limits,
) -> Result<Result<(), Violation>, Limit> {
    let _ = (specification, machine, limits);
    todo!("verification")
}
