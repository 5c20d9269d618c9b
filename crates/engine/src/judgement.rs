//! Checks a machine with its controllers, and the skills that it calls, for `check`, `build` and
//! `run`.
//!
//! `check` shows how each obligation is met; `build` and `run` only need the findings. The
//! [`Prover`] caches its results, so that a run after a check does not repeat the proofs.

use super::internal;
use super::machine::{self, MachineContext, StateCount};
use super::prover::Prover;
use crate::controlled::ControlledMachine;
use linewright_core::deadline::Deadline;
use linewright_core::diagnostics::Diagnostic;
use linewright_language::order::{self, Skills};

/// Findings about skills and their orders.
pub fn skills(skills: &Skills, deadline: Deadline) -> Vec<Diagnostic> {
    let doing = || format!("checking the skills `{}`", skills.name);
    internal::caught(doing, || order::findings::examine(skills, deadline))
        .unwrap_or_else(|fault| vec![fault.finding(Some(skills.span))])
}

/// Findings about a machine as a whole, as `check` reports them.
pub fn findings(controlled: &ControlledMachine<'_>, prover: Prover<'_>) -> Vec<Diagnostic> {
    let machine = controlled.machine;
    let doing = || format!("checking the machine `{}`", machine.name);
    internal::caught(doing, || {
        machine::prove_machine(
            controlled,
            MachineContext::Alone,
            prover,
            StateCount::Omitted,
        )
        .findings
    })
    .unwrap_or_else(|fault| vec![fault.finding(Some(machine.span))])
}
