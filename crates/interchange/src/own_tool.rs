//! What a file's own tool would have answered, where that is not what its format means.
//!
//! A reader notes on the spot what the tool refuses (a primed goal in gr1c). What depends on a
//! verdict is an [`Inquiry`]: small specifications that somebody with a solver decides, and what to
//! say for the answers. Nothing is said that was not computed.
//!
//! - gr1c compares the initial states with the winning ones among them; where `SYSINIT` contradicts
//!   itself there are neither, and it answers "realizable".
//! - Where the environment's initial condition contradicts itself, both tools answer "realizable",
//!   as the definition does: nothing is asked of the machine. Hardly anybody means that, so it is
//!   said.
//! - gr1c's `rg`, for reachability games, lets the environment choose the machine's initial values
//!   too, and answers "unrealizable" where there are none.

use super::{Format, Reading};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    /// Whether the machine can start.
    Machine,
    /// Whether the environment can.
    Environment,
    /// Whether the machine wins from every start.
    EveryStart,
}

/// A question whose answer tells what the file's own tool says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inquiry {
    topic: Topic,
    format: Format,
    span: Span,
    /// What to solve: whether each is realizable is the answer.
    pub questions: Vec<Specification>,
}

/// The questions about a file that was read.
pub fn inquiries(reading: &Reading) -> Vec<Inquiry> {
    let Some(specification) = &reading.specification else {
        return Vec::new();
    };
    // What the tool refuses, it answers nothing about.
    if reading.findings.iter().any(|f| f.code == codes::OWN_TOOL) {
        return Vec::new();
    }
    let place = |side: &Side| side.initial.first().map_or(reading.span, |f| f.span);
    let (environment, machine) = (&specification.assumptions, &specification.guarantees);
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
            environment.initial.iter().chain(&machine.initial),
        );
        add(
            Topic::EveryStart,
            place(machine),
            vec![both, every_start(specification)],
        );
        return found;
    }
    if reading.format == Format::Spc && !machine.initial.is_empty() {
        let question = satisfiable(specification, &machine.initial);
        add(Topic::Machine, place(machine), vec![question]);
    }
    if !environment.initial.is_empty() {
        let question = satisfiable(specification, &environment.initial);
        add(Topic::Environment, place(environment), vec![question]);
    }
    found
}

impl Inquiry {
    /// What to say, given whether the file is realizable, and whether each question is.
    pub fn note(&self, realizable: bool, answers: &[bool]) -> Option<Diagnostic> {
        let (message, help) = match (self.topic, answers) {
            (Topic::Machine, [false]) if !realizable => (
                "gr1c answers \"realizable\": SYSINIT contradicts itself, and it asks nothing of a machine that cannot start".to_owned(),
                "by the definition the machine needs an initial state: weaken SYSINIT",
            ),
            (Topic::Environment, [false]) if realizable => (
                format!(
                    "{} answers \"realizable\" too: the environment's initial condition contradicts itself, so nothing is asked of the machine",
                    self.format.tool()
                ),
                "no environment can begin like this; weaken its initial condition",
            ),
            (Topic::EveryStart, [possible, every]) if (*possible && *every) != realizable => (
                if realizable {
                    "rg answers \"unrealizable\": it lets the environment choose the initial values of the system's variables too"
                } else {
                    "rg answers \"realizable\": it lets the environment choose the initial values of the system's variables too"
                }
                .to_owned(),
                "here the machine chooses them, among those that SYSINIT allows",
            ),
            _ => return None,
        };
        Some(Diagnostic::note(codes::OWN_TOOL, self.span, message).with_help(help))
    }
}

/// Realizable exactly if these formulas have a common valuation: the machine chooses all variables.
fn satisfiable<'f>(
    specification: &Specification,
    formulas: impl IntoIterator<Item = &'f Formula>,
) -> Specification {
    let mut variables = specification.variables.clone();
    for variable in &mut variables {
        variable.owner = Owner::System;
    }
    Specification {
        name: specification.name.clone(),
        timing: Timing::Mealy,
        variables,
        assumptions: Side::default(),
        guarantees: Side {
            initial: formulas.into_iter().cloned().collect(),
            ..Side::default()
        },
    }
}

/// The same game with the machine's first values chosen by the environment: it names them in inputs
/// of its own, within what both initial conditions allow, and the machine takes them over.
fn every_start(specification: &Specification) -> Specification {
    let mut result = specification.clone();
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
        // After the start they say nothing more: one value is enough.
        let still = match specification.variable(*v).domain {
            Domain::Bool => Expr::Var(*name, Time::Next).not(),
            ref domain => Expr::next(*name).equals(Expr::Const(domain.low())),
        };
        result.assumptions.safety.push(formula(still));
    }
    result
}
