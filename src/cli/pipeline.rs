//! From a specification to a verified controller: solve → extract → verify, many at once.
//!
//! A controller that the verifier refuses is a fault of this program; it ends the command and is never written out. What was
//! solved before comes from the [cache]: results, from which the findings are made anew.

use super::cache::{self, Cache, Entry, Hints, Key, Version};
use super::controller::{Controller, Wish, controller};
use super::environment;
use super::interrupt::Watch;
use super::statistics::Statistics;
use super::worker::{self, Ended, Stop};
use crate::diagnostics::{Diagnostic, codes};
use crate::game::{
    self, EnvironmentFindings, GuaranteeRef, Heuristic, Heuristics, KernelChoice, Limit, Limits,
    Outcome, Phase, Progress, Ranking,
};
use crate::gr1::{Specification, overflow};
use crate::interchange::Inquiry;
use crate::mealy;
use crate::mealy::functions::Functions;
use crate::source::Span;
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Examining the plant's side of a small game ends at so many nodes.
const MOST_EXAMINED_NODES: u64 = 400_000;

/// What is known of a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// There is a controller.
    Realizable,
    /// There is none.
    Unrealizable,
    /// A limit was reached.
    GaveUp,
    /// It could not be understood.
    Invalid,
}

impl Verdict {
    /// The word in a JSON document.
    pub fn word(self) -> &'static str {
        match self {
            Self::Realizable => "realizable",
            Self::Unrealizable => "unrealizable",
            Self::GaveUp => "gave_up",
            Self::Invalid => "invalid",
        }
    }

    /// The verdict on two things together: the worse one.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let rank = |verdict: Self| match verdict {
            Self::Realizable => 0,
            Self::GaveUp => 1,
            Self::Unrealizable => 2,
            Self::Invalid => 3,
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
    /// The verified controller. A realizable contract has none when nobody asked for it, or when a limit was reached after the
    /// verdict; the findings say so.
    pub machine: Option<mealy::Machine>,
    /// The certified controller as functions, where that was asked for and a machine would be too large.
    pub functions: Option<Functions>,
    /// Why it is realizable, where that was asked for.
    pub ranking: Option<Ranking>,
    /// Seconds of the clock for all stages.
    pub seconds: f64,
    /// The largest number of BDD nodes, where the solver counts them.
    pub peak_nodes: Option<u64>,
    /// What it took, by phase.
    pub statistics: Statistics,
    /// Whether its controller and its plant were left unexamined because the game is too large for that.
    pub left_out: bool,
}

/// A fault of this program.
#[derive(Debug, thiserror::Error)]
#[error(
    "internal error: the controller synthesized for `{contract}` was refused by the verifier ({rule}). \
     Nothing was written. This is a fault of linewright: please report it together with the contract"
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

/// One specification to be solved, and where its findings point.
#[derive(Debug, Clone)]
pub struct Job {
    /// What to solve.
    pub specification: Arc<Specification>,
    /// The contract's name, or the component that gives it other arguments.
    pub span: Span,
    /// How far to go.
    pub goal: Goal,
    /// For a specification of another tool: what to find out beside, to say what that tool answers.
    pub inquiries: Vec<Inquiry>,
}

/// How far a job goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Goal {
    /// Only whether there is a controller.
    Answer,
    /// The same; and if there is none, which guarantees clash. Nothing is extracted, verified or examined: for specifications
    /// whose controller nobody asked for, and which may be far larger than a contract.
    Verdict,
    /// The same; and if the game is small, a verified controller. What is small is the solver's business; the clock has no
    /// part in it.
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
    wish: Wish,
}

impl Jobs {
    /// No jobs yet; those that come also look for what makes a realizable contract mean less than it seems to (LW205,
    /// LW206, LW208). `build` and `run` do without: it changes no controller.
    pub fn examining() -> Self {
        Self {
            examine: true,
            ..Self::default()
        }
    }

    /// The same, with controllers as they are wished for.
    #[must_use]
    pub fn wishing(self, wish: Wish) -> Self {
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
        self.add_foreign(specification, span, goal, Vec::new())
    }

    /// Adds a specification of another tool.
    pub fn add_foreign(
        &mut self,
        specification: &Arc<Specification>,
        span: Span,
        goal: Goal,
        inquiries: Vec<Inquiry>,
    ) -> usize {
        self.list.push(Job {
            specification: Arc::clone(specification),
            span,
            goal,
            inquiries,
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

    /// Does them all, in parallel; the results are in the order of the jobs. It ends shortly after the time limit, and after
    /// Ctrl-C, whatever is being done then.
    pub fn run(
        &self,
        settings: &Settings,
        progress: &ProgressBar,
    ) -> Result<Vec<CheckedContract>, InternalError> {
        let _watch = Watch::new();
        let results = self
            .list
            .par_iter()
            .map(|job| {
                let result = Task {
                    job: job.clone(),
                    examine: self.examine,
                    rank: self.rank,
                    wish: self.wish,
                    settings: settings.clone(),
                    solve: Arc::default(),
                }
                .in_time();
                progress.set_message(job.specification.name.clone());
                progress.inc(1);
                result
            })
            .collect::<Vec<_>>();
        progress.finish_and_clear();
        results.into_iter().collect()
    }
}

/// Why there is no verdict, or no controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// A limit was reached.
    Limit(Limit),
    /// Ctrl-C.
    Interrupt,
}

impl Reason {
    fn help(self) -> &'static str {
        match self {
            Self::Limit(Limit::Time) => {
                "give it more time with --timeout SECONDS, or make its domains smaller"
            }
            Self::Limit(Limit::Memory) => {
                "give it more memory with --memory MIB, or make its domains smaller"
            }
            Self::Limit(Limit::Size) => "make its domains smaller, or split it into two contracts",
            Self::Interrupt => "run it again for a verdict",
        }
    }
}

impl From<Stop> for Reason {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Time => Self::Limit(Limit::Time),
            Stop::Interrupt => Self::Interrupt,
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Limit(limit) => limit.fmt(f),
            Self::Interrupt => f.write_str("it was interrupted"),
        }
    }
}

/// What is known of a contract, before it is put into words.
#[derive(Debug, Clone)]
struct Known {
    realizable: bool,
    core: Option<Vec<GuaranteeRef>>,
    examined: bool,
    environment: Option<EnvironmentFindings>,
    controller: Controller,
    ranking: Option<Ranking>,
    /// For every inquiry the answers to its questions; `None` where a limit was reached first.
    answers: Vec<Option<Vec<bool>>>,
    peak_nodes: u64,
    statistics: Statistics,
}

/// A job, and all that it depends on.
struct Task {
    job: Job,
    examine: bool,
    rank: bool,
    wish: Wish,
    settings: Settings,
    solve: Arc<Progress>,
}

impl Task {
    /// Does the job on a thread of its own, and leaves it there when it does not end in time.
    fn in_time(self) -> Result<CheckedContract, InternalError> {
        let start = Instant::now();
        let deadline = self.settings.limits.deadline;
        let (job, examine) = (self.job.clone(), self.examine);
        let solve = Arc::clone(&self.solve);
        let checked = if let Some(stop) = worker::stop(deadline) {
            gave_up(&job, stop.into(), &solve)
        } else {
            match worker::run(deadline, move |report| self.check(report)) {
                Ended::Done(Err(error)) => return Err(error),
                Ended::Done(Ok(Ok(known))) => known.told(&job, examine),
                Ended::Done(Ok(Err(limit))) => gave_up(&job, Reason::Limit(limit), &solve),
                // What is looked for then are the guarantees that clash.
                Ended::Left(_, None) if solve.phase() == Phase::Core => {
                    Known::lost(&solve, &job.specification).told(&job, examine)
                }
                Ended::Left(stop, None) => gave_up(&job, stop.into(), &solve),
                Ended::Left(stop, Some(known)) => {
                    let known: Known = known;
                    known.stopped(stop.into(), &job).told(&job, examine)
                }
            }
        };
        Ok(CheckedContract {
            seconds: start.elapsed().as_secs_f64(),
            ..checked
        })
    }

    /// Solves the specification, extracts its controller, and verifies that; also looks for what makes a realizable
    /// contract mean less than it seems to. As soon as there is a verdict, it is given to `report`.
    fn check(&self, report: &dyn Fn(Known)) -> Result<Result<Known, Limit>, InternalError> {
        let specification = &*self.job.specification;
        let heuristics: Vec<Heuristic> = Heuristic::ALL
            .into_iter()
            .map(|(h, _)| h)
            .filter(|h| self.settings.heuristics.has(*h))
            .collect();
        let cache = self.settings.cache.as_ref().filter(|_| !self.rank);
        let key = Key::new(
            specification,
            &cache::Options {
                kernel: self.settings.kernel,
                heuristics: &heuristics,
                memory_mib: self.settings.limits.memory_mib,
                wish: self.wish(),
            },
        );
        let found = cache.and_then(|c| c.find(&key));
        let recalled = found.and_then(|entry| self.recall(entry));
        let mut known = if let Some(known) = recalled {
            Ok(known)
        } else {
            let known = self.solve(cache, report)?;
            if let (Some(cache), Ok(known)) = (cache, &known)
                && let Some(entry) = self.entry(known)
            {
                cache.keep(&key, &entry);
            }
            known
        };
        if let Ok(known) = &mut known
            && !self.job.inquiries.is_empty()
        {
            report(known.clone());
            known.answers = self.answers()?;
        }
        Ok(known)
    }

    /// The answers to the questions about another tool.
    fn answers(&self) -> Result<Vec<Option<Vec<bool>>>, InternalError> {
        let answer = |question: &Specification| -> Result<Option<bool>, InternalError> {
            let task = Self {
                job: Job {
                    specification: Arc::new(question.clone()),
                    span: self.job.span,
                    goal: Goal::Answer,
                    inquiries: Vec::new(),
                },
                examine: false,
                rank: false,
                wish: self.wish,
                settings: self.settings.clone(),
                solve: Arc::default(),
            };
            Ok(task.check(&|_| ())?.ok().map(|known| known.realizable))
        };
        let inquiries = self.job.inquiries.iter();
        inquiries
            .map(|inquiry| inquiry.questions.iter().map(answer).collect())
            .collect()
    }

    /// Whether a controller is asked for.
    fn extracts(&self, large: bool) -> bool {
        self.job.goal.extracts(large)
    }

    /// What it shall be like. Where only a small game has one at all, a machine may still be large; functions show as well that
    /// there is a right controller.
    fn wish(&self) -> Wish {
        Wish {
            functions: self.wish.functions || self.job.goal == Goal::Small,
            ..self.wish
        }
    }

    /// Whether the plant's side is examined.
    fn examines(&self, large: bool) -> bool {
        self.examine && self.job.goal >= Goal::Small && !large
    }

    fn solve(
        &self,
        cache: Option<&Cache>,
        report: &dyn Fn(Known),
    ) -> Result<Result<Known, Limit>, InternalError> {
        let specification = &*self.job.specification;
        let limits = &self.settings.limits;
        // What a written controller looks like may depend on the order. So only where none is written may the search begin
        // with what earlier runs have left.
        let version = cache.filter(|_| self.job.goal != Goal::Controller);
        let hints = version.and_then(|c| c.version(specification));
        let hints = hints.map(|v| v.hints(specification)).unwrap_or_default();
        let solved = self.play(&hints);
        let mut statistics = Statistics::of_solver(&solved.statistics, specification);
        let large = statistics.large;
        if large {
            statistics.known_order = hints.order.is_some();
            statistics.known_region = hints.region.is_some();
        }
        let last_order = solved.statistics.last_order;
        let mut known = Known {
            realizable: false,
            core: None,
            examined: false,
            environment: None,
            controller: Controller::Unasked,
            ranking: None,
            answers: Vec::new(),
            peak_nodes: 0,
            statistics,
        };
        let won = match solved.outcome {
            Outcome::GaveUp(limit) => return Ok(Err(limit)),
            Outcome::Unrealizable(lost) => {
                known.peak_nodes = lost.peak_nodes;
                known.core = lost.core;
                None
            }
            Outcome::Realizable(won) => {
                known.realizable = true;
                known.peak_nodes = won.peak_nodes;
                Some(won)
            }
        };
        report(known.clone());
        if let (Some(cache), Some(order), true) = (cache, &last_order, large) {
            let names = &known.statistics.order_after;
            let region = won.as_ref().map(game::Won::region);
            cache.keep_version(
                specification,
                &Version::new(specification, order, names, region),
            );
        }
        let Some(won) = won else {
            return Ok(Ok(known));
        };
        if self.rank {
            match won.ranking(specification, limits) {
                Ok(ranking) => known.ranking = Some(ranking),
                Err(limit) => return Ok(Err(limit)),
            }
        }
        if self.extracts(large) {
            let statistics = &mut known.statistics;
            known.controller = controller(
                specification,
                &won,
                statistics.pairs,
                self.wish(),
                limits,
                statistics.seconds.as_mut(),
            )?;
        }
        report(known.clone());
        if self.examines(large) {
            // A game that is small may still be large here: then this gives up by itself.
            let limits = Limits {
                most_nodes: Some(MOST_EXAMINED_NODES),
                ..*limits
            };
            let environment = won.examine_environment(specification, &limits);
            known.examined = !matches!(environment, Err(Limit::Time));
            known.environment = environment.ok();
        }
        Ok(Ok(known))
    }

    fn play(&self, hints: &Hints) -> game::Solved {
        let heuristics = self.settings.heuristics;
        let options = game::Options {
            limits: self.settings.limits,
            kernel: self.settings.kernel,
            heuristics: if hints.exact {
                heuristics.without(Heuristic::Sifting)
            } else {
                heuristics
            },
            without_core: self.job.goal == Goal::Answer,
            first_order: hints.order.clone(),
            first_region: hints.region.clone(),
            progress: Arc::clone(&self.solve),
        };
        game::solve_with(&self.job.specification, &options)
    }

    /// What an entry says, cut down to what would be known without it. `None` when it does not say enough.
    fn recall(&self, entry: Entry) -> Option<Known> {
        let large = entry.statistics.large;
        let extracts = entry.realizable && self.extracts(large);
        let examines = entry.realizable && self.examines(large);
        let explains = !entry.realizable && self.job.goal > Goal::Answer;
        if extracts && !entry.extracted
            || examines && !entry.examined
            || explains && entry.core.is_none()
        {
            return None;
        }
        let name = self.job.specification.name.clone();
        let mut statistics = entry.statistics;
        statistics.cached = true;
        if !extracts && let Some(seconds) = &mut statistics.seconds {
            (seconds.extract, seconds.verify) = (None, None);
        }
        Some(Known {
            realizable: entry.realizable,
            core: entry.core,
            examined: examines,
            environment: entry.environment.filter(|_| examines),
            controller: match (entry.machine, entry.functions) {
                _ if !extracts => Controller::Unasked,
                (None, None) => Controller::Stopped(Reason::Limit(Limit::Size)),
                (Some(machine), _) => Controller::Machine(mealy::Machine { name, ..machine }),
                (None, Some(functions)) => {
                    Controller::Functions(Box::new(Functions { name, ..*functions }))
                }
            },
            ranking: None,
            answers: Vec::new(),
            peak_nodes: entry.peak_nodes,
            statistics,
        })
    }

    /// What there is to remember. `None` when a limit of time or memory had a part in it.
    fn entry(&self, known: &Known) -> Option<Entry> {
        let (extracted, machine, functions) = match &known.controller {
            Controller::Unasked => (false, None, None),
            Controller::Stopped(Reason::Limit(Limit::Size)) => (true, None, None),
            Controller::Stopped(_) => return None,
            Controller::Machine(machine) => (true, Some(machine.clone()), None),
            Controller::Functions(functions) => (true, None, Some(functions.clone())),
        };
        let examines = known.realizable && self.examines(known.statistics.large);
        let explains = !known.realizable && self.job.goal > Goal::Answer;
        if examines && !known.examined || explains && known.core.is_none() {
            return None;
        }
        Some(Entry {
            realizable: known.realizable,
            core: known.core.clone(),
            examined: known.examined,
            environment: known.environment.clone(),
            extracted,
            machine,
            functions,
            peak_nodes: known.peak_nodes,
            statistics: known.statistics.clone(),
        })
    }
}

impl Known {
    /// An unrealizable contract without a core.
    fn lost(solve: &Progress, specification: &Specification) -> Self {
        let statistics = Statistics::of_solver(&solve.statistics(), specification);
        Self {
            realizable: false,
            core: None,
            examined: false,
            environment: None,
            controller: Controller::Unasked,
            ranking: None,
            answers: Vec::new(),
            peak_nodes: statistics.peak_nodes.unwrap_or(0),
            statistics,
        }
    }

    /// The same, when what was still to be done is not waited for.
    fn stopped(mut self, reason: Reason, job: &Job) -> Self {
        let asked = self.realizable && job.goal.extracts(self.statistics.large);
        if asked && matches!(self.controller, Controller::Unasked) {
            self.controller = Controller::Stopped(reason);
        }
        self
    }

    /// The same in words.
    fn told(self, job: &Job, examine: bool) -> CheckedContract {
        let specification = &*job.specification;
        let mut findings = Vec::new();
        let mut core = Vec::new();
        let (mut machine, mut functions) = (None, None);
        let mut left_out = false;
        if self.realizable {
            left_out = job.goal == Goal::Small && self.statistics.large;
            match self.controller {
                Controller::Unasked => {}
                Controller::Stopped(reason) => {
                    findings.push(no_machine(specification, job.span, reason));
                }
                Controller::Machine(verified) => machine = Some(verified),
                Controller::Functions(certified) => functions = Some(*certified),
            }
            if let Some(found) = &self.environment {
                findings.extend(environment::findings(specification, job.span, found));
            }
        } else {
            let formulas = self.core.iter().flatten();
            core.extend(formulas.map(|r| r.formula(&specification.guarantees).name.clone()));
            findings.push(unrealizable(specification, job.span, &core));
        }
        for (inquiry, answers) in job.inquiries.iter().zip(&self.answers) {
            findings.extend(
                answers
                    .as_ref()
                    .and_then(|a| inquiry.note(self.realizable, a)),
            );
        }
        if examine && job.goal >= Goal::Small {
            findings.extend(overflows(specification));
        }
        CheckedContract {
            verdict: if self.realizable {
                Verdict::Realizable
            } else {
                Verdict::Unrealizable
            },
            findings,
            core,
            machine,
            functions,
            ranking: self.ranking,
            seconds: 0.0,
            peak_nodes: Some(self.peak_nodes),
            statistics: self.statistics,
            left_out,
        }
    }
}

/// A contract without a verdict.
fn gave_up(job: &Job, reason: Reason, solve: &Progress) -> CheckedContract {
    let specification = &*job.specification;
    let name = &specification.name;
    let mut message = format!("there is no verdict on `{name}`: {reason}");
    if reason != Reason::Limit(Limit::Size) {
        message = format!("{message} {}", solve.reached());
    }
    let statistics = Statistics::of_solver(&solve.statistics(), specification);
    CheckedContract {
        verdict: Verdict::GaveUp,
        findings: vec![
            Diagnostic::error(codes::GAVE_UP, job.span, message).with_help(reason.help()),
        ],
        core: Vec::new(),
        machine: None,
        functions: None,
        ranking: None,
        seconds: 0.0,
        peak_nodes: statistics.peak_nodes.filter(|n| *n > 0),
        statistics,
        left_out: false,
    }
}

fn unrealizable(specification: &Specification, span: Span, core: &[String]) -> Diagnostic {
    let name = &specification.name;
    let mut finding = Diagnostic::error(
        codes::UNREALIZABLE,
        span,
        format!("no controller can keep the guarantees of `{name}`, whatever it does"),
    )
    .with_help("weaken a guarantee or add an assumption; `linewright explain LW203` shows how");
    let sides = [
        (&specification.guarantees, "cannot be kept"),
        (&specification.assumptions, "does not help enough"),
    ];
    for (side, text) in sides {
        for formula in side.all().filter(|f| core.contains(&f.name)) {
            finding = finding.with_label(formula.span, text);
        }
    }
    finding
}

/// LW208, for each guarantee that can ask for a next value outside its domain.
fn overflows(specification: &Specification) -> Vec<Diagnostic> {
    let found = overflow::overflows(specification).into_iter();
    found
        .map(|o| {
            let variable = specification.variable(o.variable);
            let example: Vec<String> = o
                .example
                .iter()
                .map(|(v, value)| {
                    let variable = specification.variable(*v);
                    format!("{} = {}", variable.name, variable.domain.show(*value))
                })
                .collect();
            let message = format!(
                "the next value of `{}` can be {}, but its domain is {}",
                variable.name,
                o.value,
                variable.domain.describe()
            );
            let finding = Diagnostic::warning(codes::DOMAIN_LEFT, o.formula.span, message);
            finding.with_help(format!(
                "it is for {}; keep it within with `min`, `max` or `mod`, or say when the formula holds",
                example.join(", ")
            ))
        })
        .collect()
}

/// A note, since the verdict stands; who needs the controller makes an error of it.
fn no_machine(specification: &Specification, span: Span, reason: Reason) -> Diagnostic {
    let name = &specification.name;
    let message =
        format!("`{name}` is realizable, but its controller was not written down: {reason}");
    let mut finding = Diagnostic::error(codes::GAVE_UP, span, message).with_help(reason.help());
    finding.severity = crate::diagnostics::Severity::Note;
    finding
}

impl CheckedContract {
    /// The findings for a command that needs the controller: that there is none is an error then.
    pub fn findings_where_needed(&self) -> Vec<Diagnostic> {
        let mut findings = self.findings.clone();
        if self.machine.is_none() && self.functions.is_none() {
            for finding in &mut findings {
                if finding.code == codes::GAVE_UP {
                    finding.severity = crate::diagnostics::Severity::Error;
                }
            }
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gr1::{Expr, Formula, Side, Timing};

    fn specification(name: &str) -> Arc<Specification> {
        let formula = |name: &str, start| Formula {
            name: name.to_owned(),
            requirement: None,
            expr: Expr::FALSE,
            span: Span::new(crate::source::FileId(0), start, start + 1),
            text: "false".to_owned(),
        };
        Arc::new(Specification {
            name: name.to_owned(),
            timing: Timing::Mealy,
            variables: Vec::new(),
            assumptions: Side::default(),
            guarantees: Side {
                initial: vec![formula("start", 5), formula("other", 9)],
                ..Side::default()
            },
        })
    }

    #[test]
    fn equal_contracts_are_one_job() {
        let mut jobs = Jobs::default();
        let span = Span::default();
        assert_eq!(jobs.add(&specification("A"), span), 0);
        assert_eq!(jobs.add(&specification("B"), span), 1);
        assert_eq!(jobs.add(&specification("A"), span), 0);
        assert_eq!(jobs.len(), 2);
    }

    #[test]
    fn the_core_is_pointed_at() {
        let spec = specification("A");
        let finding = unrealizable(&spec, Span::default(), &["start".to_owned()]);
        assert_eq!(finding.labels.len(), 1);
        assert_eq!(finding.labels[0].0.start, 5);
    }

    #[test]
    fn the_worse_verdict_wins() {
        let order = [
            Verdict::Realizable,
            Verdict::GaveUp,
            Verdict::Unrealizable,
            Verdict::Invalid,
        ];
        for (i, a) in order.into_iter().enumerate() {
            for (j, b) in order.into_iter().enumerate() {
                assert_eq!(a.and(b), order[i.max(j)]);
            }
        }
    }

    #[test]
    fn a_controller_that_is_needed_and_missing_is_an_error() {
        let checked = CheckedContract {
            verdict: Verdict::Realizable,
            findings: vec![no_machine(
                &specification("A"),
                Span::default(),
                Reason::Limit(Limit::Size),
            )],
            core: Vec::new(),
            machine: None,
            functions: None,
            ranking: None,
            seconds: 0.0,
            peak_nodes: None,
            statistics: Statistics::default(),
            left_out: false,
        };
        assert!(!crate::diagnostics::has_errors(&checked.findings));
        assert!(crate::diagnostics::has_errors(
            &checked.findings_where_needed()
        ));
    }
}
