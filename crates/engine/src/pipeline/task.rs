//! Runs the pipeline for one contract: takes the result from the cache, or solves the contract.

use super::announce::Announcements;
use super::explain::explain;
use super::known::{Analysis, gave_up};
use super::{CheckedContract, Goal, InternalError, Job, Settings};
use crate::cache::{self, Cache, Entry, ExaminationDepth, Hints, Key, Version};
use crate::controller::{Controller, ExtractionOptions, controller};
use crate::internal::within;
use crate::statistics::Statistics;
use crate::worker::{self, Completion};
use linewright_core::gr1::Specification;
use linewright_solver::game::{self, Budget, Heuristic, Limit, Outcome, Phase, Progress};
use linewright_solver::mealy;
use linewright_solver::mealy::functions::Functions;
use std::sync::Arc;
use std::time::Instant;

/// A job with the settings for running it.
pub(super) struct Task {
    pub(super) job: Job,
    pub(super) examine: bool,
    pub(super) rank: bool,
    pub(super) extraction: ExtractionOptions,
    pub(super) settings: Settings,
    pub(super) solve: Arc<Progress>,
}

impl Task {
    /// Runs the job on its own thread, and abandons the thread if it does not end in time.
    pub(super) fn in_time(self) -> Result<CheckedContract, InternalError> {
        let start = Instant::now();
        let deadline = self.settings.limits.deadline;
        let (job, examine) = (self.job.clone(), self.examine);
        let solve = Arc::clone(&self.solve);
        let checked = if let Some(late) = deadline.check().err() {
            gave_up(&job, late.into(), &solve)
        } else {
            let announcer = self.settings.announcer.clone();
            let mut announcements = Announcements::new(announcer.as_ref(), &job.specification);
            let waiting = |reported: Option<&Analysis>| announcements.update(&solve, reported);
            match worker::run(deadline, move |report| self.check(report), waiting) {
                Completion::Done(Err(error)) => return Err(error),
                Completion::Done(Ok(Ok(known))) => known.into_contract(&job, examine),
                Completion::Done(Ok(Err(limit))) => gave_up(&job, limit, &solve),
                // In this phase, the contract is known to be unrealizable; only the search for its
                // core was still running.
                Completion::Abandoned(late, None) if solve.phase() == Phase::Core => {
                    Analysis::without_core(&solve, &job.specification)
                        .stopped(late.into(), &job)
                        .into_contract(&job, examine)
                }
                Completion::Abandoned(late, None) => gave_up(&job, late.into(), &solve),
                Completion::Abandoned(late, Some(known)) => {
                    let known: Analysis = known;
                    known
                        .stopped(late.into(), &job)
                        .into_contract(&job, examine)
                }
            }
        };
        Ok(CheckedContract {
            seconds: start.elapsed().as_secs_f64(),
            ..checked
        })
    }

    /// Solves the specification, extracts its controller, and verifies it; also searches for
    /// formulas that demand less than they seem to. Intermediate results are passed to `report`,
    /// beginning with the verdict.
    fn check(&self, report: &dyn Fn(Analysis)) -> Result<Result<Analysis, Limit>, InternalError> {
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
                budget_factor: self.settings.limits.budget_factor,
                extraction: self.extraction_options(),
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
                cache.store(&key, &entry);
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

    /// Solves the specifications of the inquiries, to show what another tool would answer. For each
    /// inquiry, `None` if a limit was reached first.
    fn answers(&self) -> Result<Vec<Option<Vec<bool>>>, InternalError> {
        let answer = |question: &Specification| -> Result<Option<bool>, InternalError> {
            let task = Self {
                job: Job {
                    specification: Arc::new(question.clone()),
                    span: self.job.span,
                    goal: Goal::Answer,
                    explicit: false,
                    format: None,
                    own: None,
                    inquiries: Vec::new(),
                },
                examine: false,
                rank: false,
                extraction: self.extraction,
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

    /// Whether a controller is requested.
    fn extracts(&self, large: bool) -> bool {
        self.job.goal.extracts(large)
    }

    /// Requested properties of the controller. Even a small game can have a large machine. If the
    /// controller itself is not needed, functions are acceptable, since they show equally well that
    /// a controller exists.
    fn extraction_options(&self) -> ExtractionOptions {
        ExtractionOptions {
            functions: !self.job.explicit
                && (self.extraction.functions || self.job.goal == Goal::Small),
            ..self.extraction
        }
    }

    /// Whether the environment is examined.
    fn examines(&self, large: bool) -> bool {
        self.examine && self.job.goal >= Goal::Verdict && !large
    }

    fn solve(
        &self,
        cache: Option<&Cache>,
        report: &dyn Fn(Analysis),
    ) -> Result<Result<Analysis, Limit>, InternalError> {
        let specification = &*self.job.specification;
        let limits = &self.settings.limits;
        // The form of a controller can depend on the variable order. So the search starts from
        // earlier results only if no controller is written.
        let version = cache.filter(|_| self.job.goal != Goal::Controller);
        let hints = version
            .and_then(|c| c.version(specification))
            .map(|v| v.hints(specification))
            .unwrap_or_default();
        let solved = within("solving the game", || self.play(&hints));
        let mut statistics = Statistics::of_solver(&solved.statistics, specification);
        let large = statistics.large;
        if large {
            statistics.known_order = hints.order.is_some();
            statistics.known_region = hints.region.is_some();
        }
        let last_order = solved.statistics.last_order;
        let mut known = Analysis::new(statistics);
        let mut stopped_by = None;
        let won = match solved.outcome {
            Outcome::GaveUp(limit) => return Ok(Err(limit)),
            Outcome::Unrealizable(lost) => {
                known.peak_nodes = lost.peak_nodes;
                known.core = lost.core;
                stopped_by = lost.stopped_by;
                None
            }
            Outcome::Realizable(won) => {
                known.realizable = true;
                known.peak_nodes = won.peak_nodes;
                Some(won)
            }
        };
        let solved_work = won.as_ref().map_or(0, game::WonGame::work);
        report(known.clone());
        if let (Some(cache), Some(order), true) = (cache, &last_order, large) {
            let names = &known.statistics.order_after;
            let region = won.as_ref().map(game::WonGame::region);
            cache.store_version(
                specification,
                &Version::new(specification, order, names, region),
            );
        }
        let Some(won) = won else {
            if self.job.goal > Goal::Answer
                && let Some(core) = known.core.clone()
            {
                let explanation = within("explaining why it is unrealizable", || {
                    explain(specification, &core, limits, &mut |so_far| {
                        let explanation = Some(Box::new(so_far.clone()));
                        report(Analysis {
                            explanation,
                            ..known.clone()
                        });
                    })
                })?;
                known.explanation = Some(Box::new(explanation));
            }
            if let Some(limit) = stopped_by {
                known = known.stopped(limit, &self.job);
            }
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
            known.controller = within("extracting its controller", || {
                controller(
                    specification,
                    &won,
                    statistics.pairs,
                    self.extraction_options(),
                    limits,
                    statistics.seconds.as_mut(),
                )
            })?;
        }
        report(known.clone());
        if self.examines(large) {
            let budget = Budget {
                work: Budget::EXAMINATION.work + solved_work / 4,
                ..Budget::EXAMINATION
            };
            let environment = within("examining its plant", || match &self.job.own {
                Some(own) => game::examine_environment(own, &limits.with_budget(budget)),
                None => won.examine_environment(
                    specification,
                    &limits.with_budget_after(won.work(), budget),
                ),
            });
            // Budgets end an examination silently: a second one would end in the same way.
            let external = |limit: Limit| {
                let limit = limits.with_budget(budget).attribute(limit);
                Some(limit).filter(|limit| limit.is_external())
            };
            let is_late = matches!(environment, Err(Limit::Stopped(_)));
            known.examination_limit = environment.as_ref().err().copied().and_then(external);
            known.environment = environment.ok();
            if !is_late {
                known.examined = ExaminationDepth::Plant;
            }
            if known.reports_shape(&self.job) {
                report(known.clone());
                let shape = within("examining its formulas", || {
                    won.find_weaknesses(
                        specification,
                        &limits.with_budget_after(won.work(), budget),
                    )
                });
                if !is_late && !matches!(shape, Err(Limit::Stopped(_))) {
                    known.examined = ExaminationDepth::Whole;
                }
                let stopped_by = shape.as_ref().err().copied().and_then(external);
                known.examination_limit = known.examination_limit.or(stopped_by);
                known.shape = shape.ok();
            }
        }
        Ok(Ok(known))
    }

    fn play(&self, hints: &Hints) -> game::Solution {
        let options = game::Options {
            limits: self.settings.limits,
            kernel: self.settings.kernel,
            heuristics: self.settings.heuristics,
            without_core: self.job.goal == Goal::Answer,
            initial_order: hints.order.clone(),
            is_final_order: hints.is_final,
            initial_region: hints.region.clone(),
            progress: Arc::clone(&self.solve),
        };
        game::solve_with(&self.job.specification, &options)
    }

    /// Restores the results in a cache entry, reduced to those that this job would compute without
    /// the cache. `None` if the entry lacks one of them.
    fn recall(&self, entry: Entry) -> Option<Analysis> {
        let large = entry.statistics.large;
        let extracts = entry.realizable && self.extracts(large);
        let examines = entry.realizable && self.examines(large);
        let explains = !entry.realizable && self.job.goal > Goal::Answer;
        let explained = entry.lost.as_ref().is_some_and(|l| l.complete);
        // If assumptions were added to those of the source file (`own`), the findings of this job
        // are about the latter alone. Those of an entry are about all assumptions.
        let differs = examines && self.job.own.is_some();
        if differs
            || extracts && !entry.extracted
            || examines && entry.examined == ExaminationDepth::Nothing
            || explains && (entry.core.is_none() || !explained)
        {
            return None;
        }
        let name = self.job.specification.name.clone();
        let mut statistics = entry.statistics;
        statistics.cached = true;
        if !extracts && let Some(seconds) = &mut statistics.seconds {
            (seconds.extract, seconds.verify) = (None, None);
        }
        let known = Analysis {
            realizable: entry.realizable,
            core: entry.core,
            examination_limit: None,
            examined: if examines {
                entry.examined
            } else {
                ExaminationDepth::Nothing
            },
            environment: entry.environment.filter(|_| examines),
            shape: entry.shape.filter(|_| examines),
            explanation: entry.lost.filter(|_| explains),
            controller: match (entry.machine, entry.functions) {
                _ if !extracts => Controller::NotRequested,
                (None, None) => Controller::Stopped(Limit::Size),
                (Some(machine), _) => Controller::Machine(mealy::Machine { name, ..machine }),
                (None, Some(functions)) => {
                    Controller::Functions(Box::new(Functions { name, ..*functions }))
                }
            },
            ranking: None,
            answers: Vec::new(),
            peak_nodes: entry.peak_nodes,
            statistics,
        };
        // A limit of time can have ended the examination of the entry.
        let is_sufficient =
            known.examined == ExaminationDepth::Whole || !known.reports_shape(&self.job);
        (is_sufficient || !examines).then_some(known)
    }

    /// The entry to store. `None` if a time or memory limit affected the result, or if its findings
    /// are only about the assumptions in the file.
    fn entry(&self, known: &Analysis) -> Option<Entry> {
        if self.settings.limits.deadline.has_exceeded_memory() || known.examination_limit.is_some()
        {
            return None;
        }
        let (extracted, machine, functions) = match &known.controller {
            Controller::NotRequested => (false, None, None),
            Controller::Stopped(Limit::Size) => (true, None, None),
            Controller::Stopped(_) => return None,
            Controller::Machine(machine) => (true, Some(machine.clone()), None),
            Controller::Functions(functions) => (true, None, Some(functions.clone())),
        };
        let examines = known.realizable && self.examines(known.statistics.large);
        let explains = !known.realizable && self.job.goal > Goal::Answer;
        let explained = known.explanation.as_ref().is_some_and(|l| l.complete);
        if examines && (known.examined == ExaminationDepth::Nothing || self.job.own.is_some())
            || explains && (known.core.is_none() || !explained)
        {
            return None;
        }
        Some(Entry {
            realizable: known.realizable,
            core: known.core.clone(),
            examined: known.examined,
            environment: known.environment.clone(),
            shape: known.shape.clone(),
            lost: known.explanation.clone(),
            extracted,
            machine,
            functions,
            peak_nodes: known.peak_nodes,
            statistics: known.statistics.clone(),
        })
    }
}
