//! The controllers of several machines, synthesized together and judged.

use crate::controlled::Controlled;
use crate::controller::Wish;
use crate::judgement;
use crate::machines::{self, Planned};
use crate::pipeline::{CheckedContract, Jobs, Settings};
use indicatif::ProgressBar;
use linewright_core::diagnostics::Diagnostic;
use linewright_language::contract::machine::Machine;

/// Machines whose controllers were asked for.
#[derive(Debug)]
pub struct Synthesis<'a> {
    planned: Vec<Planned<'a>>,
    jobs: Jobs,
    checked: Vec<CheckedContract>,
}

impl<'a> Synthesis<'a> {
    /// Synthesizes the controllers of these machines, each contract once, in parallel. `progress` gets the number of contracts.
    pub fn new(
        machines: impl IntoIterator<Item = &'a Machine>,
        settings: &Settings,
        progress: impl FnOnce(usize) -> ProgressBar,
    ) -> Self {
        let mut jobs = Jobs::default().wishing(Wish {
            functions: true,
            ..Wish::default()
        });
        let machines = machines.into_iter();
        let planned = machines.map(|m| Planned::new(m, &mut jobs)).collect();
        let checked = jobs.run(settings, &progress(jobs.len()));
        Self {
            planned,
            jobs,
            checked,
        }
    }

    /// What was found about the contracts; a controller that is missing is an error.
    pub fn findings(&self) -> Vec<Diagnostic> {
        machines::findings_where_needed(&self.planned, &self.jobs, &self.checked)
    }

    /// The machines that have all their controllers.
    pub fn controlled(&self) -> impl Iterator<Item = Controlled<'_>> {
        self.planned
            .iter()
            .filter_map(|p| p.controlled(&self.checked))
    }

    /// Whether every machine has all its controllers.
    pub fn is_complete(&self) -> bool {
        self.controlled().count() == self.planned.len()
    }

    /// A machine that differs from one of these in numbers at most, with its controllers.
    pub fn of(&self, machine: &Machine) -> Option<Controlled<'_>> {
        let mut planned = self.planned.iter();
        let alike = planned.find(|p| machines::is_alike(p.machine, machine))?;
        alike.controlled(&self.checked)
    }

    /// What is wrong with a machine as a whole.
    pub fn judge(&self, controlled: &Controlled<'_>, settings: &Settings) -> Vec<Diagnostic> {
        judgement::findings(controlled, &settings.limits, settings.cache.as_ref())
    }
}
