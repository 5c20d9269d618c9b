//! The controllers of machines: every component's contract with the arguments that the machine gives it.

use super::files::Loaded;
use super::findings;
use super::libraries::Controlled;
use super::pipeline::{CheckedContract, Jobs, Verdict};
use super::select::Selection;
use crate::contract::line::{Line, NodeKind};
use crate::contract::machine::{Machine, Role};
use crate::diagnostics::{Diagnostic, codes};
use crate::station::file_stem;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A machine, and the job of each of its components.
#[derive(Debug, Clone)]
pub struct Planned<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One index into the jobs a component.
    pub jobs: Vec<usize>,
}

impl<'a> Planned<'a> {
    /// Adds a machine's components to the jobs. The coordinator's controller has to be a machine: its states are walked when the
    /// composition is checked.
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

    /// The verdict on all its components together.
    pub fn verdict(&self, checked: &[CheckedContract]) -> Verdict {
        self.jobs
            .iter()
            .map(|j| checked[*j].verdict)
            .fold(Verdict::Realizable, Verdict::and)
    }

    /// What is wrong with its components. What was found at a contract itself is told there, and only pointed at here.
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
                    "see at the contract what would give it one",
                ),
                Verdict::InternalError => (
                    codes::INTERNAL,
                    "could not be looked at",
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
    pub fn controlled(&self, checked: &'a [CheckedContract]) -> Option<Controlled<'a>> {
        let controllers = self.jobs.iter().map(|j| checked[*j].controller.as_ref());
        Some(Controlled {
            machine: self.machine,
            controllers: controllers.collect::<Option<_>>()?,
        })
    }
}

/// What is to be built.
#[derive(Debug, Default)]
pub struct Picked<'a> {
    /// The machines.
    pub machines: Vec<&'a Machine>,
    /// What is to be said of the choice.
    pub notes: Vec<Diagnostic>,
}

/// The machines that a selection names, or those of the line that it names. Without a name those of the file's lines, with the sizes that they
/// have there, as `run` would build them; and those that the file declares and no line of it uses, with their default sizes.
pub fn picked<'a>(selection: &Selection, loaded: &'a Loaded) -> anyhow::Result<Picked<'a>> {
    let library = &loaded.library;
    let declared = selection.find(loaded, &library.machines, |m| (&m.name, m.span));
    if selection.name.is_some() && !declared.is_empty() {
        return Ok(Picked {
            machines: declared,
            notes: Vec::new(),
        });
    }
    let lines = selection.find(loaded, &library.lines, |l| (&l.name, l.span));
    let mut picked = Picked::default();
    for machine in lines.iter().flat_map(|l| of_line(l)) {
        let known = |m: &&Machine| is_same(m, machine);
        if !picked.machines.iter().any(known) {
            picked.machines.push(machine);
        }
    }
    for machine in declared {
        let mut used = picked.machines.iter().filter(|m| m.span == machine.span);
        if used.clone().count() == 0 {
            picked.machines.push(machine);
        } else if !used.any(|m| is_same(m, machine)) {
            picked
                .notes
                .push(sized(selection, machine, lines.as_slice()));
        }
    }
    if picked.machines.is_empty() {
        picked.machines =
            selection.pick(loaded, "machine", &library.machines, |m| (&m.name, m.span))?;
    }
    Ok(picked)
}

/// That a machine is built with other sizes than its own.
fn sized(selection: &Selection, machine: &Machine, lines: &[&Line]) -> Diagnostic {
    let name = &machine.name;
    let users = lines
        .iter()
        .filter(|l| of_line(l).iter().any(|m| m.span == machine.span))
        .map(|l| format!("`{}`", l.name));
    let users: Vec<String> = users.collect();
    Diagnostic::note(
        codes::SIZES_OF_LINE,
        machine.span,
        format!(
            "`{name}` is built with the sizes that it has in {}",
            findings::list(&users)
        ),
    )
    .with_help(format!(
        "`linewright build {}::{name}` builds it with its default sizes",
        selection.path
    ))
}

/// The same machines under names whose files differ: of two that would be written to the same file, such as one machine in two sizes, the
/// second is called `Printer_2`.
pub fn told_apart<'a>(machines: &[&'a Machine]) -> Vec<Cow<'a, Machine>> {
    // SimTalk does not tell capitals from small letters either.
    let keys = |name: &str| [file_stem(name), name.to_lowercase()];
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let mut told = Vec::new();
    for machine in machines {
        let mut name = machine.name.clone();
        let mut number = 2;
        while keys(&name).iter().any(|key| taken.contains(key)) {
            name = format!("{}_{number}", machine.name);
            number += 1;
        }
        taken.extend(keys(&name));
        told.push(if name == machine.name {
            Cow::Borrowed(*machine)
        } else {
            Cow::Owned(Machine {
                name,
                ..(*machine).clone()
            })
        });
    }
    told
}

/// Whether two machines are one declaration with the same arguments throughout: their libraries are the same. What a machine consists of is
/// compared as it is written out, so that nothing in it is left out of the comparison.
fn is_same(one: &Machine, other: &Machine) -> bool {
    std::ptr::eq(one, other)
        || (one.span == other.span && format!("{one:?}") == format!("{other:?}"))
}

/// Whether two machines are one declaration with the same arguments: their controllers are the same.
pub fn is_alike(one: &Machine, other: &Machine) -> bool {
    let mut components = one.components.iter().zip(&other.components);
    one.span == other.span
        && one.components.len() == other.components.len()
        && components.all(|(a, b)| a.specification == b.specification && a.bindings == b.bindings)
}

/// Whether what is judged of one machine holds of the other: they differ in times, powers, limits and defaults at most.
pub fn is_judged_alike(one: &Machine, other: &Machine) -> bool {
    let judged = |m: &Machine| {
        let text = format!(
            "{:?}",
            (&m.plant, &m.done, &m.guarantees, &m.refines, &m.orders)
        );
        (text, m.layers.inner.len())
    };
    is_alike(one, other) && judged(one) == judged(other)
}

/// The machines of a line, each once, in the order of their first place in it.
pub fn of_line(line: &Line) -> Vec<&Arc<Machine>> {
    let mut machines: Vec<&Arc<Machine>> = Vec::new();
    for node in &line.nodes {
        let machine = match &node.kind {
            NodeKind::Station { machine, .. } => machine,
            NodeKind::Conveyor {
                belt: Some(belt), ..
            } => &belt.machine,
            _ => continue,
        };
        if !machines.iter().any(|m| Arc::ptr_eq(m, machine)) {
            machines.push(machine);
        }
    }
    machines
}

/// The findings of machines whose controllers are needed: what is missing is an error, each contract is told once.
pub fn findings_where_needed(
    planned: &[Planned<'_>],
    jobs: &Jobs,
    checked: &[CheckedContract],
) -> Vec<Diagnostic> {
    let mut findings: Vec<Diagnostic> = Vec::new();
    for result in checked {
        findings.extend(result.findings_where_needed());
    }
    for plan in planned {
        for finding in plan.findings(jobs, checked) {
            // A component's own job was told above.
            let told = findings
                .iter()
                .any(|f| f.code == finding.code && f.span == finding.span);
            if !told {
                findings.push(finding);
            }
        }
    }
    findings
}
