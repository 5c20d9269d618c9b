//! Reports the answer of a file's own tool where it differs from the meaning of the format.
//!
//! Some notes do not depend on a verdict: the reader itself notes a construct that the tool
//! refuses, such as a primed goal in gr1c. A note that depends on a verdict is an [`Inquiry`]. It
//! holds small specifications for the caller's solver, and chooses the note from the answers.
//!
//! - gr1c checks whether every initial state is winning. If `SYSINIT` contradicts itself, there is
//!   no initial state, and gr1c answers "realizable".
//! - If the environment's initial condition contradicts itself, both tools answer "realizable", in
//!   line with the definition, because no guarantee ever applies. This is rarely intended, so a
//!   note is given.
//! - gr1c's `rg`, for reachability games, lets the environment choose the system's initial values
//!   too, and answers "unrealizable" if there is no initial state.

use super::{Format, Reading};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    /// Asks whether the system has an initial state.
    System,
    /// Asks whether the environment has an initial state.
    Environment,
    /// Asks whether the system wins from every initial state.
    EveryStart,
}

/// Questions whose answers determine what the file's own tool answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inquiry {
    topic: Topic,
    format: Format,
    span: Span,
    /// Specifications to solve. The answer to each is whether it is realizable. Their names are
    /// not that of the file's specification, under which the cache keeps what the next check of the
    /// file begins with.
    pub questions: Vec<Specification>,
}

/// The inquiries about a file; none if a finding says that the file's own tool refuses it.
pub fn inquiries(reading: &Reading) -> Vec<Inquiry> {
    let Some(specification) = &reading.specification else {
        return Vec::new();
    };
    // The file's own tool does not solve a file that it refuses.
    if reading.findings.iter().any(|f| f.code == codes::OWN_TOOL) {
        return Vec::new();
    }
    let place = |side: &Side| side.initial.first().map_or(reading.span, |f| f.span);
    let (environment, system) = (&specification.assumptions, &specification.guarantees);
    let mut found = Vec::new();
    let mut add = |topic, span, questions| {
        found.push(Inquiry {
            topic,
            format: reading.format,
            span,
            questions,
        });
    };
    if reading.reachability {
        let both = satisfiable(
            specification,
            environment.initial.iter().chain(&system.initial),
        );
        add(
            Topic::EveryStart,
            place(system),
            vec![both, every_start(specification)],
        );
        return found;
    }
    if reading.format == Format::Spc && !system.initial.is_empty() {
        let question = satisfiable(specification, &system.initial);
        add(Topic::System, place(system), vec![question]);
    }
    if !environment.initial.is_empty() {
        let question = satisfiable(specification, &environment.initial);
        add(Topic::Environment, place(environment), vec![question]);
    }
    found
}

impl Inquiry {
    /// The note about the answer of the file's own tool; `None` if none is needed.
    ///
    /// `realizable` is the verdict about the file, `answers` the verdicts about
    /// [`Self::questions`], in their order.
    pub fn note(&self, realizable: bool, answers: &[bool]) -> Option<Diagnostic> {
        let (message, help) = match (self.topic, answers) {
            (Topic::System, [false]) if !realizable => (
                "gr1c answers \"realizable\": SYSINIT contradicts itself, and gr1c requires nothing of a system that cannot start".to_owned(),
                "by definition, the system needs an initial state: weaken SYSINIT",
            ),
            (Topic::Environment, [false]) if realizable => (
                format!(
                    "{} answers \"realizable\" too: the environment's initial condition contradicts itself, so no guarantee ever applies",
                    self.format.tool()
                ),
                "weaken the environment's initial condition",
            ),
            (Topic::EveryStart, [possible, every]) if (*possible && *every) != realizable => (
                if realizable {
                    "rg answers \"unrealizable\": it lets the environment choose the initial values of the system's variables too"
                } else {
                    "rg answers \"realizable\": it lets the environment choose the initial values of the system's variables too"
                }
                .to_owned(),
                "here the system chooses them, among those that SYSINIT allows",
            ),
            _ => return None,
        };
        Some(Diagnostic::note(codes::OWN_TOOL, self.span, message).with_help(help))
    }
}

/// A specification that is realizable if and only if some valuation satisfies all `formulas`. The
/// system chooses all variables.
fn satisfiable<'f>(
    specification: &Specification,
    formulas: impl IntoIterator<Item = &'f Formula>,
) -> Specification {
    let mut variables = specification.variables.clone();
    for variable in &mut variables {
        variable.owner = Owner::System;
    }
    Specification {
        name: format!("the start of {}", specification.name),
        timing: Timing::Mealy,
        variables,
        assumptions: Side::default(),
        guarantees: Side {
            initial: formulas.into_iter().cloned().collect(),
            ..Side::default()
        },
    }
}

/// The same game, but the environment chooses the system's initial values.
///
/// The environment chooses them in additional inputs, as both initial conditions allow, and the
/// system has to copy them.
fn every_start(specification: &Specification) -> Specification {
    let mut result = specification.clone();
    result.name = format!("every start of {}", specification.name);
    let mut given: Vec<(VarId, VarId)> = Vec::new();
    for v in specification.outputs() {
        let variable = specification.variable(v);
        let name = VarId(result.variables.len() as u32);
        result.variables.push(Variable {
            name: format!("{} at the start", variable.name),
            owner: Owner::Environment,
            internal: false,
            unit: String::new(),
            domain: variable.domain.clone(),
            span: variable.span,
        });
        given.push((v, name));
    }
    let formula = |expr| Formula {
        defines: false,
        name: "start".to_owned(),
        requirement: None,
        expr,
        span: Span::default(),
        text: String::new(),
    };
    let named = |v: VarId| {
        given
            .iter()
            .find(|(w, _)| *w == v)
            .map_or(v, |(_, name)| *name)
    };
    let chosen = std::mem::take(&mut result.guarantees.initial);
    result.assumptions.initial.extend(
        chosen
            .iter()
            .map(|f| formula(f.expr.substitute(&mut |v, _| Expr::now(named(v))))),
    );
    for (v, name) in &given {
        result
            .guarantees
            .initial
            .push(formula(Expr::now(*v).equals(Expr::now(*name))));
        // After the start, the additional inputs are constant.
        let still = match specification.variable(*v).domain {
            Domain::Bool => Expr::Var(*name, Time::Next).not(),
            ref domain => Expr::next(*name).equals(Expr::Const(domain.low())),
        };
        result.assumptions.safety.push(formula(still));
    }
    result
}
