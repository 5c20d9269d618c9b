//! Synthesizes the controllers of several machines together, and checks the machines.

use crate::controlled::ControlledMachine;
use crate::controller::ExtractionOptions;
use crate::judgement;
use crate::machines::{self, MachinePlan};
use crate::pipeline::{CheckedContract, Jobs, Settings};
use indicatif::ProgressBar;
use linewright_core::diagnostics::{Diagnostic, Severity};
use linewright_language::contract::machine::Machine;
use linewright_language::order::Skills;

/// Machines with the results of synthesizing their controllers.
#[derive(Debug)]
pub struct Synthesis<'a> {
    planned: Vec<MachinePlan<'a>>,
    jobs: Jobs,
    checked: Vec<CheckedContract>,
    /// Errors, and limits that were reached, in the check of the machines' skills.
    skills: Vec<Diagnostic>,
}

impl<'a> Synthesis<'a> {
    /// Synthesizes the controllers of these machines in parallel, each contract once, and checks
    /// the skills that the machines call. `progress` receives the number of contracts.
    pub fn new(
        machines: impl IntoIterator<Item = &'a Machine>,
        settings: &Settings,
        progress: impl FnOnce(usize) -> ProgressBar,
    ) -> Self {
        let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
            functions: true,
            ..ExtractionOptions::default()
        });
        let machines = machines.into_iter();
        let planned: Vec<_> = machines.map(|m| MachinePlan::new(m, &mut jobs)).collect();
        let checked = jobs.run(settings, &progress(jobs.len()));
        let orders = planned.iter().flat_map(|p| &p.machine.orders);
        let mut skills: Vec<&Skills> = Vec::new();
        for orders in orders {
            if !skills.iter().any(|s| s.span == orders.skills.span) {
                skills.push(&orders.skills);
            }
        }
        let deadline = settings.limits.deadline;
        let found = skills.iter().flat_map(|s| judgement::skills(s, deadline));
        let is_wrong = |f: &Diagnostic| f.severity == Severity::Error || f.gave_up;
        Self {
            skills: found.filter(is_wrong).collect(),
            planned,
            jobs,
            checked,
        }
    }

    /// Findings about the contracts, where a missing controller is an error, and about the skills.
    pub fn findings(&self) -> Vec<Diagnostic> {
        let mut findings =
            machines::findings_where_needed(&self.planned, &self.jobs, &self.checked);
        findings.extend(self.skills.iter().cloned());
        findings
    }

    /// The machines of which every component has a controller.
    pub fn controlled(&self) -> impl Iterator<Item = ControlledMachine<'_>> {
        self.planned
            .iter()
            .filter_map(|p| p.controlled(&self.checked))
    }

    /// Whether every machine has all its controllers.
    pub fn is_complete(&self) -> bool {
        self.controlled().count() == self.planned.len()
    }

    /// Returns the synthesized machine that has the same controllers as `machine` (see
    /// [`machines::is_alike`]). `None` if there is none, or if one of its components has no
    /// controller.
    pub fn of(&self, machine: &Machine) -> Option<ControlledMachine<'_>> {
        let mut planned = self.planned.iter();
        let alike = planned.find(|p| machines::is_alike(p.machine, machine))?;
        alike.controlled(&self.checked)
    }

    /// Findings about a machine as a whole; see [`judgement::findings`].
    pub fn judge(
        &self,
        controlled: &ControlledMachine<'_>,
        settings: &Settings,
    ) -> Vec<Diagnostic> {
        judgement::findings(controlled, settings.prover())
    }
}
