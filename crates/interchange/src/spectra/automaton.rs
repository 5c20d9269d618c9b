//! Encodes automata over the steps of a run in variables, for triggers and published patterns.
//!
//! An [`Automaton`] reads truth values in each step. Its state is an internal variable of the
//! system. The steps before step t determine the state in step t, so the system has no choice. The
//! automaton becomes a justice assumption or guarantee: an accepting state is visited infinitely
//! often.

use super::reader::Reader;
use super::value::{Kind, Value};
use linewright_automata::symbolic::{Automaton, Decision, MAX_CONDITIONS, MAX_STATES};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Domain, Expr, Formula, Owner};
use linewright_core::source::Span;
use std::ops::Range;

/// The next state as an expression; `atoms` are the values of the conditions.
fn value(decision: &Decision, atoms: &[Value]) -> Value {
    match decision {
        Decision::To(state) => Value::int(*state as i64),
        Decision::If(atom, yes, no) => {
            Value::choose(atoms[*atom].clone(), value(yes, atoms), value(no, atoms))
        }
    }
}

/// The next state if the current state is in `among`, by binary search: a chain of as many choices
/// as there are states would nest too deeply.
fn next_state(
    current: &Value,
    automaton: &Automaton,
    among: Range<usize>,
    atoms: &[Value],
) -> Value {
    if among.len() == 1 {
        return value(&automaton.steps[among.start], atoms);
    }
    let middle = among.start.midpoint(among.end);
    let is_lower = Value::binary(BinaryOp::Lt, current.clone(), Value::int(middle as i64));
    Value::choose(
        is_lower,
        next_state(current, automaton, among.start..middle, atoms),
        next_state(current, automaton, middle..among.end, atoms),
    )
}

impl Reader {
    /// Adds an automaton's state variable, its transitions, and the justice of its accepting
    /// states.
    pub fn add_automaton(
        &mut self,
        automaton: &Automaton,
        stem: &str,
        atoms: &[Value],
        side: Owner,
        span: Span,
    ) -> Option<()> {
        let count = automaton.steps.len();
        if automaton.accepting.iter().all(|a| *a) {
            return Some(());
        }
        let domain = Domain::Range {
            low: 0,
            high: count as i64 - 1,
        };
        let name = self.fresh(stem);
        let state = self.variables(&name, Owner::System, true, (domain, Vec::new()), span)?;
        let current = Value::leaf(Expr::now(state.first), Kind::Int);
        let is = |s: usize| Value::binary(BinaryOp::Eq, current.clone(), Value::int(s as i64));
        let update = next_state(&current, automaton, 0..count, atoms);
        let update = self.check_size(update, span)?;
        self.check_finished(&update.expr, update.size, span)?;
        let accepted: Vec<Value> = (0..count)
            .filter(|s| automaton.accepting[*s])
            .map(is)
            .collect();
        let accepted = Value::chain(BinaryOp::Or, accepted);
        let definition = |expr| Formula {
            defines: true,
            ..self.formula(expr)
        };
        let start = definition(Expr::now(state.first).equals(Expr::Const(0)));
        let step = definition(Expr::next(state.first).equals(update.expr));
        let goal = self.formula(accepted.expr);
        let guarantees = &mut self.specification.guarantees;
        guarantees.initial.push(start);
        guarantees.safety.push(step);
        match side {
            Owner::System => guarantees.justice.push(goal),
            Owner::Environment => self.specification.assumptions.justice.push(goal),
        }
        Some(())
    }

    /// A formula with the origin of the current statement.
    pub fn formula(&self, expr: Expr) -> Formula {
        Formula {
            defines: false,
            name: self.origin.name.clone(),
            requirement: None,
            expr,
            span: self.origin.span,
            text: self.origin.text.clone(),
        }
    }

    /// Reports an automaton with too many states or conditions.
    pub fn too_many_states(&mut self, span: Span) {
        self.error(
            codes::TOO_LARGE,
            span,
            format!("this needs an automaton with more than {MAX_STATES} states, or with more than {MAX_CONDITIONS} conditions in one step"),
            "use fewer repetitions and complements, and fewer different conditions",
        );
    }
}
