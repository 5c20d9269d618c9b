//! Checks a machine with its controllers, and the skills that it calls, for `check`, `build` and
//! `run`.
//!
//! `check` shows how each obligation is met; `build` and `run` only need the findings. If a machine
//! has none, this is cached next to the results of contracts, so that a run after a check does not
//! repeat the proofs.

use super::cache::{Cache, Key};
use super::internal;
use super::machine::{self, MachineContext};
use crate::controlled::ControlledMachine;
use linewright_core::deadline::Deadline;
use linewright_core::diagnostics::Diagnostic;
use linewright_language::order::{self, Skills};
use linewright_solver::game::Limits;

/// Findings about skills and their orders.
pub fn skills(skills: &Skills, deadline: Deadline) -> Vec<Diagnostic> {
    let doing = || format!("checking the skills `{}`", skills.name);
    internal::caught(doing, || order::findings::examine(skills, deadline))
        .unwrap_or_else(|fault| vec![fault.finding(Some(skills.span))])
}

/// Findings about a machine as a whole, as `check` reports them.
pub fn findings(
    controlled: &ControlledMachine<'_>,
    limits: &Limits,
    cache: Option<&Cache>,
) -> Vec<Diagnostic> {
    let key = cache.map(|_| Key::of_machine(controlled.machine, &controlled.controllers));
    if let (Some(cache), Some(key)) = (cache, &key)
        && cache.is_sound(key)
    {
        return Vec::new();
    }
    let machine = controlled.machine;
    let doing = || format!("checking the machine `{}`", machine.name);
    let findings = internal::caught(doing, || {
        machine::prove_machine(controlled, MachineContext::Alone, limits).findings
    })
    .unwrap_or_else(|fault| vec![fault.finding(Some(machine.span))]);
    remember(&findings, controlled, cache);
    findings
}

/// Records in the cache that a machine has no findings; does nothing if there are any.
pub fn remember(
    findings: &[Diagnostic],
    controlled: &ControlledMachine<'_>,
    cache: Option<&Cache>,
) {
    if let (Some(cache), true) = (cache, findings.is_empty()) {
        let key = Key::of_machine(controlled.machine, &controlled.controllers);
        cache.store_sound(&key);
    }
}
