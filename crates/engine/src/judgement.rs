//! Judges a machine with its controllers and the skills that it calls, for `check`, `build` and
//! `run` alike.
//!
//! `check` shows how the result is reached; `build` and `run` only need the findings. That a
//! machine has none is cached beside the results of contracts, so that a run after a check does not
//! judge again.

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

/// Findings about a machine, as `check` reports them.
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
    let doing = || format!("judging the machine `{}`", machine.name);
    let findings = internal::caught(doing, || {
        machine::proved(controlled, MachineContext::Alone, limits).findings
    })
    .unwrap_or_else(|fault| vec![fault.finding(Some(machine.span))]);
    remember(&findings, controlled, cache);
    findings
}

/// Records in the cache that a machine has no findings, if that is so.
pub fn remember(
    findings: &[Diagnostic],
    controlled: &ControlledMachine<'_>,
    cache: Option<&Cache>,
) {
    if let (Some(cache), true) = (cache, findings.is_empty()) {
        let key = Key::of_machine(controlled.machine, &controlled.controllers);
        cache.keep_sound(&key);
    }
}
