//! From a specification to a verified controller: solve → extract → verify, many at once.
//!
//! A controller that the verifier refuses is a fault of this program; it ends the command and is never written out.

use super::environment;
use crate::diagnostics::{Diagnostic, codes};
use crate::game::{self, Limit, Limits, Outcome};
use crate::gr1::{Specification, overflow};
use crate::mealy;
use crate::mealy::functions::Functions;
use crate::symbolic::Encoding;
use crate::source::Span;
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

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
#[derive(Debug)]
pub struct CheckedContract {
    /// The verdict.
    pub verdict: Verdict,
    /// What was found on the way.
    pub findings: Vec<Diagnostic>,
    /// Names of guarantees and assumptions that clash, for an unrealizable one.
    pub core: Vec<String>,
    /// The verified controller. A realizable contract has none when a limit was reached after the verdict; the findings say so.
    pub machine: Option<mealy::Machine>,
    /// The certified controller as functions, where that was asked for and a machine would be too large.
    pub functions: Option<Functions>,
    /// Seconds of the clock for all stages.
    pub seconds: f64,
    /// The largest number of BDD nodes, where the solver counts them.
    pub peak_nodes: Option<u64>,
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

/// One specification to be solved, and where its findings point.
#[derive(Debug, Clone)]
pub struct Job {
    /// What to solve.
    pub specification: Arc<Specification>,
    /// The contract's name, or the component that gives it other arguments.
    pub span: Span,
}

/// Jobs without repetition: equal contracts are synthesized once, however many machines use them.
#[derive(Debug, Default)]
pub struct Jobs {
    jobs: Vec<Job>,
    examine: bool,
    functions: bool,
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

    /// The same jobs, for which functions are as good as a machine where that would be large.
    #[must_use]
    pub fn with_functions(self) -> Self {
        Self {
            functions: true,
            ..self
        }
    }

    /// Adds a job, or finds an equal one, and gives its index.
    pub fn add(&mut self, specification: &Arc<Specification>, span: Span) -> usize {
        let equal = |job: &Job| {
            Arc::ptr_eq(&job.specification, specification) || job.specification == *specification
        };
        self.jobs.iter().position(equal).unwrap_or_else(|| {
            self.jobs.push(Job {
                specification: Arc::clone(specification),
                span,
            });
            self.jobs.len() - 1
        })
    }

    /// The job of an index.
    pub fn get(&self, index: usize) -> &Job {
        &self.jobs[index]
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.jobs.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Does them all, in parallel; the results are in the order of the jobs.
    pub fn run(
        &self,
        limits: &Limits,
        progress: &ProgressBar,
    ) -> Result<Vec<CheckedContract>, InternalError> {
        let results = self
            .jobs
            .par_iter()
            .map(|job| {
                let result = check(
                    &job.specification,
                    job.span,
                    (self.examine, self.functions),
                    limits,
                );
                progress.set_message(job.specification.name.clone());
                progress.inc(1);
                result
            })
            .collect::<Vec<_>>();
        progress.finish_and_clear();
        results.into_iter().collect()
    }
}

/// Solves one specification, extracts its controller, and verifies that. With `examine`, also looks for what makes a
/// realizable contract mean less than it seems to. With `functions`, they take the place of a machine that would be large.
pub fn check(
    specification: &Specification,
    span: Span,
    (examine, functions): (bool, bool),
    limits: &Limits,
) -> Result<CheckedContract, InternalError> {
    let start = Instant::now();
    let mut checked = CheckedContract {
        verdict: Verdict::GaveUp,
        findings: Vec::new(),
        core: Vec::new(),
        machine: None,
        functions: None,
        seconds: 0.0,
        peak_nodes: None,
    };
    match game::solve(specification, limits) {
        Outcome::GaveUp(limit) => {
            let name = &specification.name;
            checked.findings.push(gave_up(
                span,
                &format!("there is no verdict on `{name}`: {limit}"),
                limit,
            ));
        }
        Outcome::Unrealizable(lost) => {
            checked.verdict = Verdict::Unrealizable;
            checked.core = lost.core_names(specification);
            checked.peak_nodes = Some(lost.peak_nodes);
            let finding = unrealizable(specification, span, &checked.core);
            checked.findings.push(finding);
        }
        Outcome::Realizable(won) => {
            checked.verdict = Verdict::Realizable;
            checked.peak_nodes = Some(won.peak_nodes);
            match controller(specification, &won, functions, limits) {
                Ok(Ok(Controller::Machine(machine))) => checked.machine = Some(machine),
                Ok(Ok(Controller::Functions(functions))) => checked.functions = Some(functions),
                Ok(Err(rule)) => {
                    return Err(InternalError {
                        contract: specification.name.clone(),
                        rule,
                    });
                }
                Err(limit) => checked
                    .findings
                    .push(no_machine(specification, span, limit)),
            }
        }
    }
    if examine && checked.verdict == Verdict::Realizable {
        let findings = environment::examine(specification, span, limits);
        checked.findings.extend(findings);
    }
    if examine {
        checked.findings.extend(overflows(specification));
    }
    checked.seconds = start.elapsed().as_secs_f64();
    Ok(checked)
}

/// A controller in either form.
enum Controller {
    Machine(mealy::Machine),
    Functions(Functions),
}

/// A machine is only tried for games that needed fewer nodes than this.
const MACHINE_PEAK_NODES: u64 = 50_000;

/// A machine is only tried for games of so many pairs of bits.
const MACHINE_PAIRS: usize = 48;

/// Where functions will do, a machine is given up that needs more nodes than this at once. A bound on time would make the form
/// depend on the computer.
const MACHINE_NODES: u64 = 200_000;

/// A verified controller, or the rule that it breaks.
fn controller(
    specification: &Specification,
    won: &game::Won,
    functions: bool,
    limits: &Limits,
) -> Result<Result<Controller, String>, Limit> {
    let machine = |limits: &Limits| {
        let machine = mealy::extract::extract(specification, won, limits)?;
        let verdict = mealy::verify::verify(specification, &machine, limits)?;
        Ok(match verdict {
            Ok(()) => Ok(Controller::Machine(machine)),
            Err(violation) => Err(violation.rule),
        })
    };
    if !functions {
        return machine(limits);
    }
    let pairs = Encoding::new(specification).pairs();
    if won.peak_nodes <= MACHINE_PEAK_NODES && pairs <= MACHINE_PAIRS {
        let bounded = Limits {
            most_nodes: Some(MACHINE_NODES),
            ..*limits
        };
        match machine(&bounded) {
            Err(Limit::Memory | Limit::Size) => {}
            done => return done,
        }
    }
    let functions = Functions::extract(specification, won, limits)?;
    let verdict = mealy::certify::certify(specification, &functions, limits)?;
    Ok(match verdict {
        Ok(()) => Ok(Controller::Functions(functions)),
        Err(fault) => Err(fault.rule),
    })
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

fn gave_up(span: Span, message: &str, limit: Limit) -> Diagnostic {
    Diagnostic::error(codes::GAVE_UP, span, message).with_help(match limit {
        Limit::Time => "give it more time with --timeout SECONDS, or make its domains smaller",
        Limit::Memory => "give it more memory with --memory MIB, or make its domains smaller",
        Limit::Size => "make its domains smaller, or split it into two contracts",
    })
}

/// A note, since the verdict stands; who needs the controller makes an error of it.
fn no_machine(specification: &Specification, span: Span, limit: Limit) -> Diagnostic {
    let name = &specification.name;
    let message =
        format!("`{name}` is realizable, but its controller was not written down: {limit}");
    let mut finding = gave_up(span, &message, limit);
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
                Limit::Size,
            )],
            core: Vec::new(),
            machine: None,
            functions: None,
            seconds: 0.0,
            peak_nodes: None,
        };
        assert!(!crate::diagnostics::has_errors(&checked.findings));
        assert!(crate::diagnostics::has_errors(
            &checked.findings_where_needed()
        ));
    }
}
