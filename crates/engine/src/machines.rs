//! Plans the synthesis of machines: one job for each component's contract, with the arguments that
//! the machine gives it.

use super::pipeline::{CheckedContract, Jobs, Verdict};
use crate::controlled::ControlledMachine;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_language::contract::Library;
use linewright_language::contract::line::Line;
use linewright_language::contract::machine::{Machine, Role};
use std::sync::Arc;

/// A machine and the jobs of its components.
#[derive(Debug, Clone)]
pub struct MachinePlan<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One job index per component.
    pub jobs: Vec<usize>,
}

impl<'a> MachinePlan<'a> {
    /// Adds a machine's components to the jobs. The coordinator's controller must be a table of
    /// states, which are explored when the composition is checked.
    pub fn new(machine: &'a Machine, jobs: &mut Jobs) -> Self {
        let components = machine.components.iter();
        Self {
            machine,
            jobs: components
                .map(|c| match c.role {
                    Role::Coordinator => jobs.add_explicit(&c.specification, c.span),
                    Role::Action | Role::Watch => jobs.add(&c.specification, c.span),
                })
                .collect(),
        }
    }

    /// The worst verdict of the machine's components.
    pub fn verdict(&self, checked: &[CheckedContract]) -> Verdict {
        self.jobs
            .iter()
            .map(|j| checked[*j].verdict)
            .fold(Verdict::Realizable, Verdict::and)
    }

    /// Findings about the machine's components. If a contract has no controller even without the
    /// machine's arguments, the finding here only refers to the one at the contract.
    pub fn findings(&self, jobs: &Jobs, checked: &[CheckedContract]) -> Vec<Diagnostic> {
        let mut findings = Vec::new();
        for (component, index) in self.machine.components.iter().zip(&self.jobs) {
            let (job, result) = (jobs.get(*index), &checked[*index]);
            if job.span == component.span {
                findings.extend(result.findings.clone());
                continue;
            }
            let (code, why, help) = match result.verdict {
                Verdict::Unrealizable => (
                    codes::UNREALIZABLE,
                    "is unrealizable",
                    "repair the contract first",
                ),
                Verdict::GaveUp => (
                    codes::GAVE_UP,
                    "has no verdict",
                    "see the finding at the contract for how to get a verdict",
                ),
                Verdict::InternalError => (
                    codes::INTERNAL,
                    "could not be checked",
                    "this is a fault of linewright: see the finding at the contract",
                ),
                Verdict::Realizable | Verdict::Invalid => continue,
            };
            findings.push(
                Diagnostic::error(
                    code,
                    component.span,
                    format!(
                        "`{}` of `{}` has no controller: its contract `{}` {why}",
                        component.name, self.machine.name, component.contract
                    ),
                )
                .with_label(job.span, "see the finding here")
                .with_help(help),
            );
        }
        findings
    }

    /// The machine with its controllers, if every component has one.
    pub fn controlled(&self, checked: &'a [CheckedContract]) -> Option<ControlledMachine<'a>> {
        let controllers = self.jobs.iter().map(|j| checked[*j].controller.as_ref());
        Some(ControlledMachine {
            machine: self.machine,
            controllers: controllers.collect::<Option<_>>()?,
        })
    }
}

/// Whether two machines are the same declaration with the same arguments, so that their libraries
/// are the same. Compares their complete debug output, so that no field is missed.
pub fn is_same(one: &Machine, other: &Machine) -> bool {
    std::ptr::eq(one, other)
        || (one.span == other.span && format!("{one:?}") == format!("{other:?}"))
}

/// Whether two machines are the same declaration with the same components, so that their
/// controllers are the same. They can differ in other numbers, such as times.
pub fn is_alike(one: &Machine, other: &Machine) -> bool {
    let mut components = one.components.iter().zip(&other.components);
    one.span == other.span
        && one.components.len() == other.components.len()
        && components.all(|(a, b)| a.specification == b.specification && a.bindings == b.bindings)
}

/// Whether the findings about one machine hold for the other: they differ at most in times, powers,
/// limits and defaults.
pub fn has_same_proofs(one: &Machine, other: &Machine) -> bool {
    let proved = |m: &Machine| {
        let text = format!(
            "{:?}",
            (&m.plant, &m.done, &m.guarantees, &m.refines, &m.orders)
        );
        (text, m.layers.inner.len())
    };
    is_alike(one, other) && proved(one) == proved(other)
}

/// The machines of a line, each once, in the order of their first occurrence.
pub fn of_line(line: &Line) -> Vec<&Arc<Machine>> {
    let mut machines: Vec<&Arc<Machine>> = Vec::new();
    for node in &line.nodes {
        let Some(machine) = node.machine() else {
            continue;
        };
        if !machines.iter().any(|m| Arc::ptr_eq(m, machine)) {
            machines.push(machine);
        }
    }
    machines
}

/// Whether `machine` has an inner machine, at any depth, that is declared at `declared`.
pub fn contains(machine: &Machine, declared: Span) -> bool {
    let mut inner = machine.layers.inner.iter().map(|inner| &inner.machine);
    inner.any(|inner| inner.span == declared || contains(inner, declared))
}

/// Whether a machine occurs within other machines of the library, but not directly in a line.
pub fn is_only_inner(machine: &Machine, library: &Library) -> bool {
    let stations = library.lines.iter().flat_map(of_line);
    !stations.into_iter().any(|m| m.span == machine.span)
        && library.machines.iter().any(|m| contains(m, machine.span))
}

/// Findings about the controllers of machines that need them: a missing controller is an error, and
/// each contract is reported once.
pub fn findings_where_needed(
    planned: &[MachinePlan<'_>],
    jobs: &Jobs,
    checked: &[CheckedContract],
) -> Vec<Diagnostic> {
    let mut findings: Vec<Diagnostic> = Vec::new();
    for result in checked {
        findings.extend(result.findings_where_needed());
    }
    for plan in planned {
        for finding in plan.findings(jobs, checked) {
            // A component's own job was already reported.
            let shown = findings
                .iter()
                .any(|f| f.code == finding.code && f.span == finding.span);
            if !shown {
                findings.push(finding);
            }
        }
    }
    findings
}
