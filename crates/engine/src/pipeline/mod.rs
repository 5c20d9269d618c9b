//! From a specification to a verified controller: solve → extract → verify, with many contracts in
//! parallel.
//!
//! A controller that the verifier rejects is a fault of this program and is never written. Results
//! of earlier solves come from the [cache](super::cache); findings are generated from them again. A
//! task collects the results for a contract, which are then converted to findings.

mod announce;
mod explain;
mod known;
mod memory;
mod task;

pub use announce::Announcer;
pub use explain::Explanation;
pub use memory::Memory;

use super::cache::Cache;
use super::controller::ExtractionOptions;
use super::internal::{self, Fault};
use super::prover::Prover;
use super::statistics::Statistics;
use indicatif::ProgressBar;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Specification;
use linewright_core::source::Span;
use linewright_interchange::{Format, Inquiry, Reading, inquiries};
use linewright_solver::game::{EnvironmentFindings, Heuristics, KernelChoice, Limits, Ranking};
use linewright_solver::mealy;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;
use task::Task;

/// Verdict on a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// There is a controller.
    Realizable,
    /// There is no controller.
    Unrealizable,
    /// A limit was reached.
    GaveUp,
    /// The contract is invalid.
    Invalid,
    /// An internal error occurred: nothing is known.
    InternalError,
}

/// The name used in JSON documents.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Verdict {
    /// Combined verdict on two contracts: the worse one.
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

/// Result of the pipeline for a contract.
#[derive(Debug, Clone)]
pub struct CheckedContract {
    /// The verdict.
    pub verdict: Verdict,
    /// Findings of all stages.
    pub findings: Vec<Diagnostic>,
    /// For an unrealizable contract, names of the guarantees that clash.
    pub core: Vec<String>,
    /// Findings about the environment of a realizable contract.
    pub environment: Option<EnvironmentFindings>,
    /// Why the contract is unrealizable; `None` if it is realizable, or if this was not examined.
    pub explanation: Option<Box<Explanation>>,
    /// The verified controller. A realizable contract has none if it was not requested, or if a
    /// limit was reached after the verdict, which is a finding.
    pub controller: Option<mealy::Controller>,
    /// Why the contract is realizable, if requested.
    pub ranking: Option<Ranking>,
    /// Wall-clock seconds for all stages.
    pub seconds: f64,
    /// Peak number of BDD nodes, if the solver counts them.
    pub peak_nodes: Option<u64>,
    /// Statistics of the solver.
    pub statistics: Statistics,
    /// How much of it was examined.
    pub examination: Examination,
}

/// How much of a realizable contract was examined beyond its verdict, compared with what was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Examination {
    /// As much as was asked.
    Complete,
    /// Findings about its assumptions or its formulas can be missing: the search for them used up
    /// its work budget.
    Partial,
    /// Nothing, because the game is too large for the goal.
    VerdictOnly,
}

/// An internal error: the verifier rejected a controller.
#[derive(Debug, thiserror::Error)]
#[error(
    "the verifier rejected the controller synthesized for `{contract}` ({rule}); nothing was written"
)]
pub struct InternalError {
    contract: String,
    rule: String,
}

impl InternalError {
    /// Creates the error for a contract whose controller breaks `rule`.
    pub fn new(specification: &Specification, rule: String) -> Self {
        Self {
            contract: specification.name.clone(),
            rule,
        }
    }
}

/// Settings of the solver.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Time and memory limits.
    pub limits: Limits,
    /// BDD package.
    pub kernel: KernelChoice,
    /// Enabled heuristics.
    pub heuristics: Heuristics,
    /// Cache of solved contracts, if one is used.
    pub cache: Option<Cache>,
    /// Where to announce what is known of an unrealizable contract whose explanation takes long.
    pub announcer: Option<Announcer>,
}

impl Settings {
    /// Returns a prover with these limits and this cache.
    pub fn prover(&self) -> Prover<'_> {
        Prover::new(&self.limits, self.cache.as_ref())
    }
}

impl Default for Settings {
    /// No limits and no cache.
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            kernel: KernelChoice::Automatic,
            heuristics: Heuristics::default(),
            cache: None,
            announcer: None,
        }
    }
}

/// A specification to solve, and the place to which its findings point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// The specification to solve.
    pub specification: Arc<Specification>,
    /// Place of the contract's name, or of the component that gives the contract other arguments.
    pub span: Span,
    /// How far to go.
    pub goal: Goal,
    /// Whether the controller must be a machine of any size, even if functions are acceptable for
    /// the other jobs.
    pub explicit: bool,
    /// For a specification from another tool's file: the file's format.
    format: Option<Format>,
    /// If assumptions were added to those in the file, the specification without them; findings
    /// about assumptions refer to it.
    own: Option<Arc<Specification>>,
    /// For another tool's specification: further specifications whose verdicts show what that tool
    /// would answer.
    pub inquiries: Vec<Inquiry>,
}

/// How far to go in a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Goal {
    /// Only decide whether there is a controller.
    Answer,
    /// Also find the guarantees that clash if there is no controller, and examine the environment
    /// of small games. No controller is extracted or verified. This is the goal for specifications
    /// whose controller was not requested, since they can be far larger than a contract.
    Verdict,
    /// Also extract and verify a controller if the game is small. The solver defines what is small,
    /// independently of time.
    Small,
    /// Extract and verify a controller at any cost.
    Controller,
}

impl Goal {
    /// Whether a controller is requested.
    fn extracts(self, large: bool) -> bool {
        match self {
            Self::Answer | Self::Verdict => false,
            Self::Small => !large,
            Self::Controller => true,
        }
    }
}

/// Jobs without duplicates: a contract that several machines use is synthesized once.
#[derive(Debug, Default)]
pub struct Jobs {
    list: Vec<Job>,
    examine: bool,
    rank: bool,
    extraction: ExtractionOptions,
}

impl Jobs {
    /// Creates an empty job list. Jobs added to it also examine the environments of realizable
    /// contracts, and search for formulas that demand less than they seem to (LW205, LW206, LW208).
    /// `build` and `run` skip these checks, since they change no controller.
    pub fn examining() -> Self {
        Self {
            examine: true,
            ..Self::default()
        }
    }

    /// Sets the requested properties of controllers.
    #[must_use]
    pub fn with_extraction(self, extraction: ExtractionOptions) -> Self {
        Self { extraction, ..self }
    }

    /// Sets whether to compute, for each realizable contract, the ranking that shows why it is
    /// realizable.
    #[must_use]
    pub fn with_ranking(self, rank: bool) -> Self {
        Self { rank, ..self }
    }

    /// Adds a job whose controller is needed; returns its index, or that of an equal job.
    pub fn add(&mut self, specification: &Arc<Specification>, span: Span) -> usize {
        self.add_for(Goal::Controller, specification, span)
    }

    /// Like [`Jobs::add`], for a controller that must be a machine (a table of states).
    pub fn add_explicit(&mut self, specification: &Arc<Specification>, span: Span) -> usize {
        let index = self.add(specification, span);
        self.list[index].explicit = true;
        index
    }

    /// Adds a job; returns its index. An equal job whose goal is at least [`Goal::Small`] is
    /// reused, with the more demanding of the two goals.
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

    /// Adds a specification of another tool; returns the index of its job.
    pub fn add_foreign(
        &mut self,
        specification: &Arc<Specification>,
        span: Span,
        goal: Goal,
        reading: &Reading,
    ) -> usize {
        let index = self.push(specification, span, goal);
        self.list[index].format = Some(reading.format);
        self.list[index]
            .own
            .clone_from(&reading.with_own_assumptions);
        self.list[index].inquiries = inquiries(reading);
        index
    }

    fn push(&mut self, specification: &Arc<Specification>, span: Span, goal: Goal) -> usize {
        self.list.push(Job {
            specification: Arc::clone(specification),
            span,
            goal,
            explicit: false,
            format: None,
            own: None,
            inquiries: Vec::new(),
        });
        self.list.len() - 1
    }

    /// Returns the job at an index.
    pub fn get(&self, index: usize) -> &Job {
        &self.list[index]
    }

    /// Number of jobs.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no jobs.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Runs all jobs in parallel; results are in job order. Returns shortly after the deadline even
    /// if jobs are still running.
    pub fn run(&self, settings: &Settings, progress: &ProgressBar) -> Vec<CheckedContract> {
        self.run_with(None, settings, progress)
    }

    /// Like [`Jobs::run`], but reuses the results of the previous run for equal jobs, and then
    /// remembers this run instead.
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
            memory.store(&self.list, &results);
        }
        results
    }

    /// Runs one job. An internal error is reported at the contract and does not affect other jobs.
    fn done(&self, job: &Job, settings: &Settings) -> CheckedContract {
        let name = &job.specification.name;
        let doing = || format!("checking the contract `{name}`");
        let task = Task {
            job: job.clone(),
            examine: self.examine,
            rank: self.rank,
            extraction: self.extraction,
            settings: settings.clone(),
            solve: Arc::default(),
        };
        let fault = match internal::caught(doing, || task.in_time()) {
            Ok(Ok(known)) => return known,
            Ok(Err(refused)) => Fault::detected(doing(), refused.to_string()),
            Err(fault) => fault,
        };
        known::failed(job, fault.finding(Some(job.span)))
    }
}

impl CheckedContract {
    /// Creates a result with only a verdict and statistics.
    pub(super) fn new(verdict: Verdict, statistics: Statistics) -> Self {
        Self {
            verdict,
            findings: Vec::new(),
            core: Vec::new(),
            environment: None,
            explanation: None,
            controller: None,
            ranking: None,
            seconds: 0.0,
            peak_nodes: statistics.peak_nodes.filter(|n| *n > 0),
            statistics,
            examination: Examination::Complete,
        }
    }

    /// Findings for a command that needs the controller: a missing controller is an error.
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
