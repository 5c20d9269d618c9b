//! From a specification to a verified controller: solve → extract → verify, many at once.
//!
//! A controller that the verifier refuses is a fault of this program, and is never written out.
//! What was solved before comes from the [cache](super::cache): results, from which the findings
//! are made anew. A task finds out what is to be known of a contract, and that is then put into
//! words.

mod explain;
mod known;
mod memory;
mod task;

pub use explain::Explained;
pub use memory::Memory;

use super::cache::Cache;
use super::controller::ExtractionOptions;
use super::internal::{self, Fault};
use super::statistics::Statistics;
use indicatif::ProgressBar;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Specification;
use linewright_core::source::Span;
use linewright_interchange::{Inquiry, Reading, inquiries};
use linewright_solver::game::{EnvironmentFindings, Heuristics, KernelChoice, Limits, Ranking};
use linewright_solver::mealy;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;
use task::Task;

/// What is known of a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// There is a controller.
    Realizable,
    /// There is none.
    Unrealizable,
    /// A limit was reached.
    GaveUp,
    /// It could not be understood.
    Invalid,
    /// This program failed while it looked at it: nothing is known.
    InternalError,
}

/// The word of the JSON documents.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Verdict {
    /// The verdict on two things together: the worse one.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let rank = |verdict: Self| match verdict {
            Self::Realizable => 0,
            Self::GaveUp => 1,
            Self::Unrealizable => 2,
            Self::Invalid => 3,
            Self::InternalError => 4,
        };
        if rank(other) > rank(self) {
            other
        } else {
            self
        }
    }
}

/// A contract after the pipeline.
#[derive(Debug, Clone)]
pub struct CheckedContract {
    /// The verdict.
    pub verdict: Verdict,
    /// What was found on the way.
    pub findings: Vec<Diagnostic>,
    /// Names of guarantees and assumptions that clash, for an unrealizable one.
    pub core: Vec<String>,
    /// What was found about the plant's side of a realizable one.
    pub environment: Option<EnvironmentFindings>,
    /// Why there is none.
    pub lost: Option<Box<Explained>>,
    /// The verified controller. A realizable contract has none when nobody asked for it, or when a
    /// limit was reached after the verdict; the findings say so.
    pub controller: Option<mealy::Controller>,
    /// Why it is realizable, where that was asked for.
    pub ranking: Option<Ranking>,
    /// Seconds of the clock for all stages.
    pub seconds: f64,
    /// The largest number of BDD nodes, where the solver counts them.
    pub peak_nodes: Option<u64>,
    /// What it took, by phase.
    pub statistics: Statistics,
    /// Whether its controller and its plant were left unexamined because the game is too large for
    /// that.
    pub left_out: bool,
}

/// A fault of this program.
#[derive(Debug, thiserror::Error)]
#[error(
    "the controller synthesized for `{contract}` was refused by the verifier ({rule}); nothing was written"
)]
pub struct InternalError {
    contract: String,
    rule: String,
}

impl InternalError {
    /// The controller of a contract breaks a rule.
    pub fn new(specification: &Specification, rule: String) -> Self {
        Self {
            contract: specification.name.clone(),
            rule,
        }
    }
}

/// How to solve.
#[derive(Debug, Clone)]
pub struct Settings {
    /// When to give up.
    pub limits: Limits,
    /// Which BDD package.
    pub kernel: KernelChoice,
    /// Which heuristics are on.
    pub heuristics: Heuristics,
    /// What is known of contracts that were solved before.
    pub cache: Option<Cache>,
}

impl Default for Settings {
    /// Without limits, and remembering nothing.
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            kernel: KernelChoice::Automatic,
            heuristics: Heuristics::default(),
            cache: None,
        }
    }
}

/// One specification to be solved, and where its findings point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// What to solve.
    pub specification: Arc<Specification>,
    /// The contract's name, or the component that gives it other arguments.
    pub span: Span,
    /// How far to go.
    pub goal: Goal,
    /// Whether the controller has to be a machine, whatever its size, although functions were
    /// wished for.
    pub explicit: bool,
    /// Whether another tool's file says it: then nothing is said about formulas that could be left
    /// out.
    foreign: bool,
    /// The specification with the assumptions that stand in the file only, where others were added;
    /// findings about assumptions are about it.
    own: Option<Arc<Specification>>,
    /// For a specification of another tool: what to find out beside, to say what that tool answers.
    pub inquiries: Vec<Inquiry>,
}

/// How far a job goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Goal {
    /// Only whether there is a controller.
    Answer,
    /// The same; and if there is none, which guarantees clash. Nothing is extracted or verified,
    /// and only small games are examined: for specifications whose controller nobody asked for, and
    /// which may be far larger than a contract.
    Verdict,
    /// The same; and if the game is small, a verified controller. What is small is the solver's
    /// business; the clock has no part in it.
    Small,
    /// A verified controller, whatever it costs.
    Controller,
}

impl Goal {
    /// Whether a controller is asked for.
    fn extracts(self, large: bool) -> bool {
        match self {
            Self::Answer | Self::Verdict => false,
            Self::Small => !large,
            Self::Controller => true,
        }
    }
}

/// Jobs without repetition: equal contracts are synthesized once, however many machines use them.
#[derive(Debug, Default)]
pub struct Jobs {
    list: Vec<Job>,
    examine: bool,
    rank: bool,
    wish: ExtractionOptions,
}

impl Jobs {
    /// No jobs yet; those that come also look for what makes a realizable contract mean less than
    /// it seems to (LW205, LW206, LW208). `build` and `run` do without: it changes no controller.
    pub fn examining() -> Self {
        Self {
            examine: true,
            ..Self::default()
        }
    }

    /// The same, with controllers as they are wished for.
    #[must_use]
    pub fn wishing(self, wish: ExtractionOptions) -> Self {
        Self { wish, ..self }
    }

    /// The same, and asks why each realizable contract is realizable.
    #[must_use]
    pub fn ranking(self, rank: bool) -> Self {
        Self { rank, ..self }
    }

    /// Adds a job whose controller is needed, or finds an equal one, and gives its index.
    pub fn add(&mut self, specification: &Arc<Specification>, span: Span) -> usize {
        self.add_for(Goal::Controller, specification, span)
    }

    /// The same for a controller that has to be a machine, state by state.
    pub fn add_explicit(&mut self, specification: &Arc<Specification>, span: Span) -> usize {
        let index = self.add(specification, span);
        self.list[index].explicit = true;
        index
    }

    /// Adds a job, or finds an equal one, and gives its index.
    pub fn add_for(&mut self, goal: Goal, specification: &Arc<Specification>, span: Span) -> usize {
        let equal = |job: &Job| {
            job.goal >= Goal::Small
                && job.inquiries.is_empty()
                && (Arc::ptr_eq(&job.specification, specification)
                    || job.specification == *specification)
        };
        let found = self.list.iter().position(equal);
        if let Some(index) = found {
            let job = &mut self.list[index];
            job.goal = job.goal.max(goal);
            return index;
        }
        self.push(specification, span, goal)
    }

    /// Adds a specification of another tool.
    pub fn add_foreign(
        &mut self,
        specification: &Arc<Specification>,
        span: Span,
        goal: Goal,
        reading: &Reading,
    ) -> usize {
        let index = self.push(specification, span, goal);
        self.list[index].foreign = true;
        self.list[index].own.clone_from(&reading.own);
        self.list[index].inquiries = inquiries(reading);
        index
    }

    fn push(&mut self, specification: &Arc<Specification>, span: Span, goal: Goal) -> usize {
        self.list.push(Job {
            specification: Arc::clone(specification),
            span,
            goal,
            explicit: false,
            foreign: false,
            own: None,
            inquiries: Vec::new(),
        });
        self.list.len() - 1
    }

    /// The job of an index.
    pub fn get(&self, index: usize) -> &Job {
        &self.list[index]
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Does them all, in parallel; the results are in the order of the jobs. It ends shortly
    /// after the deadline, whatever is being done then.
    pub fn run(&self, settings: &Settings, progress: &ProgressBar) -> Vec<CheckedContract> {
        self.run_with(None, settings, progress)
    }

    /// The same without the jobs that a run before has done, if it asked for the same of them; this
    /// run is remembered instead.
    pub fn run_with(
        &self,
        memory: Option<&mut Memory>,
        settings: &Settings,
        progress: &ProgressBar,
    ) -> Vec<CheckedContract> {
        let results = self
            .list
            .par_iter()
            .map(|job| {
                let result = match memory.as_ref().and_then(|m| m.find(job)) {
                    Some(known) => known,
                    None => self.done(job, settings),
                };
                progress.set_message(job.specification.name.clone());
                progress.inc(1);
                result
            })
            .collect::<Vec<_>>();
        progress.finish_and_clear();
        if let Some(memory) = memory {
            memory.keep(&self.list, &results);
        }
        results
    }

    /// Does one of them. A fault of this program is told where the contract stands, and leaves the
    /// others alone.
    fn done(&self, job: &Job, settings: &Settings) -> CheckedContract {
        let name = &job.specification.name;
        let doing = || format!("checking the contract `{name}`");
        let task = Task {
            job: job.clone(),
            examine: self.examine,
            rank: self.rank,
            wish: self.wish,
            settings: settings.clone(),
            solve: Arc::default(),
        };
        let fault = match internal::caught(doing, || task.in_time()) {
            Ok(Ok(known)) => return known,
            Ok(Err(refused)) => Fault::noticed(doing(), refused.to_string()),
            Err(fault) => fault,
        };
        known::failed(job, fault.finding(Some(job.span)))
    }
}

impl CheckedContract {
    /// One with that verdict, and nothing else of it known yet.
    pub(super) fn new(verdict: Verdict, statistics: Statistics) -> Self {
        Self {
            verdict,
            findings: Vec::new(),
            core: Vec::new(),
            environment: None,
            lost: None,
            controller: None,
            ranking: None,
            seconds: 0.0,
            peak_nodes: statistics.peak_nodes.filter(|n| *n > 0),
            statistics,
            left_out: false,
        }
    }

    /// The findings for a command that needs the controller: that there is none is an error then.
    pub fn findings_where_needed(&self) -> Vec<Diagnostic> {
        let mut findings = self.findings.clone();
        if self.controller.is_none() {
            for finding in &mut findings {
                if finding.code == codes::GAVE_UP {
                    finding.severity = linewright_core::diagnostics::Severity::Error;
                }
            }
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::known::tests::specification;
    use super::*;

    #[test]
    fn equal_contracts_are_one_job() {
        let mut jobs = Jobs::default();
        let mut add = |name| jobs.add(&Arc::new(specification(name)), Span::default());
        assert_eq!([add("A"), add("B"), add("A")], [0, 1, 0]);
        assert_eq!(jobs.len(), 2);
    }

    #[test]
    fn the_worse_verdict_wins() {
        let order = [
            Verdict::Realizable,
            Verdict::GaveUp,
            Verdict::Unrealizable,
            Verdict::Invalid,
            Verdict::InternalError,
        ];
        for (i, a) in order.into_iter().enumerate() {
            for (j, b) in order.into_iter().enumerate() {
                assert_eq!(a.and(b), order[i.max(j)]);
            }
        }
    }
}
