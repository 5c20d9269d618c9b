//! Intermediate results of a contract, and their conversion to findings.

use super::Explanation;
use super::{CheckedContract, Examination, Goal, Job, Verdict};
use crate::cache::ExaminationDepth;
use crate::controller::Controller;
use crate::findings::{environment, lost, shape};
use crate::statistics::Statistics;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Specification, overflow};
use linewright_core::source::Span;
use linewright_solver::game::{
    EnvironmentFindings, GuaranteeRef, Limit, Progress, Ranking, WeaknessFindings,
};
use linewright_solver::mealy;

/// Results about a contract before they are converted to findings.
#[derive(Debug, Clone)]
pub(super) struct Analysis {
    pub(super) realizable: bool,
    pub(super) core: Option<Vec<GuaranteeRef>>,
    pub(super) examined: ExaminationDepth,
    /// The limit of the command that ended the examination.
    pub(super) examination_limit: Option<Limit>,
    pub(super) environment: Option<EnvironmentFindings>,
    pub(super) shape: Option<WeaknessFindings>,
    pub(super) explanation: Option<Box<Explanation>>,
    pub(super) controller: Controller,
    pub(super) ranking: Option<Ranking>,
    /// For each inquiry, the answers to its questions; `None` if a limit was reached first.
    pub(super) answers: Vec<Option<Vec<bool>>>,
    pub(super) peak_nodes: u64,
    pub(super) statistics: Statistics,
}

impl Analysis {
    /// An unrealizable contract of which only the statistics are known so far.
    pub(super) fn new(statistics: Statistics) -> Self {
        Self {
            realizable: false,
            core: None,
            examined: ExaminationDepth::Nothing,
            examination_limit: None,
            environment: None,
            shape: None,
            explanation: None,
            controller: Controller::NotRequested,
            ranking: None,
            answers: Vec::new(),
            peak_nodes: statistics.peak_nodes.unwrap_or(0),
            statistics,
        }
    }

    /// What is known about an unrealizable contract while the search for its core is running.
    pub(super) fn without_core(solve: &Progress, specification: &Specification) -> Self {
        Self::new(Statistics::of_solver(&solve.statistics(), specification))
    }

    /// Records that the remaining work was abandoned.
    pub(super) fn stopped(mut self, limit: Limit, job: &Job) -> Self {
        let requested = self.realizable && job.goal.extracts(self.statistics.large);
        if requested && matches!(self.controller, Controller::NotRequested) {
            self.controller = Controller::Stopped(limit);
        }
        if !self.realizable && job.goal > Goal::Answer {
            let explanation = self.explanation.unwrap_or_default();
            self.explanation = Some(Box::new(explanation.stopped(limit)));
        }
        self
    }

    /// Whether to report formulas that demand less than they seem to. If no plant keeps the
    /// assumptions, they are not reported: every guarantee is then vacuous.
    pub(super) fn reports_shape(&self, job: &Job) -> bool {
        let empty = |e: &EnvironmentFindings| e.cannot_start || e.unsatisfiable;
        let is_vacuous = self.environment.as_ref().is_some_and(empty);
        job.goal >= Goal::Verdict && !is_vacuous
    }

    /// How much of the contract was examined. Where a limit of the command ended the examination,
    /// a finding says so.
    fn examination(&self, job: &Job) -> Examination {
        let is_missing =
            self.environment.is_none() || self.reports_shape(job) && self.shape.is_none();
        let is_examined = matches!(job.goal, Goal::Verdict | Goal::Small);
        if self.realizable && is_examined && self.statistics.large {
            Examination::VerdictOnly
        } else if self.examined == ExaminationDepth::Whole
            && self.examination_limit.is_none()
            && is_missing
        {
            Examination::Partial
        } else {
            Examination::Complete
        }
    }

    /// Names of the core's guarantees, except definitions, each once.
    pub(super) fn core_names(&self, specification: &Specification) -> Vec<String> {
        let mut names = Vec::new();
        let formulas = self.core.iter().flatten();
        let formulas = formulas.map(|r| r.formula(&specification.guarantees));
        for formula in formulas.filter(|f| !f.defines) {
            if !names.contains(&formula.name) {
                names.push(formula.name.clone());
            }
        }
        names
    }

    /// Converts the results to findings.
    pub(super) fn into_contract(self, job: &Job, examine: bool) -> CheckedContract {
        let specification = &*job.specification;
        let mut findings = Vec::new();
        let mut core = Vec::new();
        let mut controller = None;
        let examination = self.examination(job);
        let reports_shape = self.reports_shape(job);
        if self.realizable {
            match self.controller {
                Controller::NotRequested => {}
                Controller::Stopped(limit) => {
                    findings.push(no_machine(specification, job.span, limit));
                }
                Controller::Machine(verified) => controller = Some(verified.into()),
                Controller::Functions(certified) => {
                    controller = Some(mealy::Controller::Functions(certified));
                }
            }
            if let Some(limit) = self.examination_limit {
                findings.push(not_examined(specification, job.span, limit));
            }
            if let Some(found) = &self.environment {
                let examined = job.own.as_deref().unwrap_or(specification);
                findings.extend(environment::findings(examined, job.span, found));
            }
            if let Some(found) = self.shape.as_ref().filter(|_| reports_shape) {
                findings.extend(shape::findings(specification, job.format, found));
            }
        } else {
            core = self.core_names(specification);
            let explanation = self.explanation.as_deref();
            let shown = lost::finding(specification, job.format, job.span, &core, explanation);
            findings.push(shown);
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
            environment: self.environment,
            explanation: self.explanation,
            controller,
            ranking: self.ranking,
            seconds: 0.0,
            peak_nodes: Some(self.peak_nodes),
            statistics: self.statistics,
            examination,
        }
    }
}

/// Help text for a contract that reached a limit.
fn help(limit: Limit) -> String {
    match limit.remedy() {
        Some(remedy) => format!("{remedy}, or make its domains smaller"),
        None => "write it as functions (`synth --emit json`, c, st or plcopen), or make its domains smaller".to_owned(),
    }
}

/// Result for a contract whose verdict was prevented by a limit.
pub(super) fn gave_up(job: &Job, limit: Limit, solve: &Progress) -> CheckedContract {
    let specification = &*job.specification;
    let name = &specification.name;
    let mut message = format!("no verdict on `{name}`: {limit}");
    if limit != Limit::Size {
        message = format!("{message} {}", solve.describe());
    }
    let statistics = Statistics::of_solver(&solve.statistics(), specification);
    CheckedContract {
        findings: vec![
            Diagnostic::error(codes::GAVE_UP, job.span, message)
                .with_help(help(limit))
                .giving_up(limit.is_external()),
        ],
        ..CheckedContract::new(Verdict::GaveUp, statistics)
    }
}

/// Result for a contract whose check failed with an internal error.
pub(super) fn failed(job: &Job, finding: Diagnostic) -> CheckedContract {
    let statistics = Progress::default().statistics();
    let statistics = Statistics::of_solver(&statistics, &job.specification);
    CheckedContract {
        findings: vec![finding],
        ..CheckedContract::new(Verdict::InternalError, statistics)
    }
}

/// LW208 for each guarantee that can demand a next value outside the variable's domain.
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
                    format!("{} = {}", variable.name, variable.show(*value))
                })
                .collect();
            let message = format!(
                "the next value of `{}` can be {}, but its domain is {}",
                variable.name,
                o.value,
                variable.describe()
            );
            let finding = Diagnostic::warning(codes::DOMAIN_LEFT, o.formula.span, message);
            finding.with_help(format!(
                "this happens for {}; limit the value with `min`, `max` or `mod`, or add a condition to the formula",
                example.join(", ")
            ))
        })
        .collect()
}

/// Finding for a realizable contract whose examination a limit of the command ended.
fn not_examined(specification: &Specification, span: Span, limit: Limit) -> Diagnostic {
    let name = &specification.name;
    let message = format!("`{name}` was not examined completely: {limit}");
    Diagnostic::warning(codes::GAVE_UP, span, message)
        .with_help(help(limit))
        .giving_up(true)
}

/// Reports a missing controller as a note, since the verdict is known; commands that need the
/// controller turn the note into an error.
fn no_machine(specification: &Specification, span: Span, limit: Limit) -> Diagnostic {
    let name = &specification.name;
    let message = format!("`{name}` is realizable, but its controller was not extracted: {limit}");
    let mut finding = Diagnostic::error(codes::GAVE_UP, span, message)
        .with_help(help(limit))
        .giving_up(limit.is_external());
    finding.severity = linewright_core::diagnostics::Severity::Note;
    finding
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use linewright_core::gr1::{Expr, Formula, Side, Timing};

    pub fn specification(name: &str) -> Specification {
        let formula = |name: &str, start| Formula {
            defines: false,
            name: name.to_owned(),
            requirement: None,
            expr: Expr::FALSE,
            span: Span::new(linewright_core::source::FileId(0), start, start + 1),
            text: "false".to_owned(),
        };
        Specification {
            name: name.to_owned(),
            timing: Timing::Mealy,
            variables: Vec::new(),
            assumptions: Side::default(),
            guarantees: Side {
                initial: vec![formula("start", 5), formula("other", 9)],
                ..Side::default()
            },
        }
    }

    #[test]
    fn a_controller_that_is_needed_and_missing_is_an_error() {
        let checked = CheckedContract {
            findings: vec![no_machine(
                &specification("A"),
                Span::default(),
                Limit::Size,
            )],
            ..CheckedContract::new(Verdict::Realizable, Statistics::default())
        };
        assert!(!linewright_core::diagnostics::has_errors(&checked.findings));
        assert!(linewright_core::diagnostics::has_errors(
            &checked.findings_where_needed()
        ));
    }
}
