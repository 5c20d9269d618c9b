//! Finds requests that need not be completed.
//!
//! A contract declares a request in one of two ways. Either it assumes that the request is held
//! until it is done, `always (R and not D -> next R)`, where D is an output. Or it has an output
//! `turn_executed` or `turn_done` for an input that has a value `turn`. The property that should
//! hold is `always eventually (not R or D)`. The check determines whether all controllers ensure
//! it, only some, or none. If none can, the contract may name what comes in place of a completion,
//! as in `always eventually (not R or D or fault)`; then nothing is reported.

use crate::game::arena::Arena;
use crate::game::fixpoint::winning_states;
use crate::game::lasting::lasting;
use crate::game::reference::{AssumptionRef, all};
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, FormulaKind as Kind, Owner, Specification, Time, UnaryOp, VarId,
};
use serde::{Deserialize, Serialize};

/// A request that need not be completed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// Condition under which the request is present; over current values.
    pub request: Expr,
    /// Condition under which the request is done; over current values.
    pub done: Expr,
    /// The output that signals completion.
    pub output: VarId,
    /// The assumption that the request is held; `None` if the output's name declares the request.
    pub held_by: Option<AssumptionRef>,
    /// Whether some controller can ensure completion.
    pub enforceable: bool,
}

/// Returns the declared requests that some controller leaves uncompleted. `reached` and `moves` are
/// the states and steps that can occur.
pub fn uncompleted<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    reached: &K::Function,
    moves: &K::Function,
) -> Result<Vec<Request>, Limit> {
    let m = &arena.kernel;
    let mut found = Vec::new();
    let plain = |r: &Request| r.done == Expr::now(r.output);
    for mut request in declared_requests(specification).into_iter().filter(plain) {
        let up = arena.encoding.formula(m, &request.request)?;
        let done = arena.encoding.formula(m, &request.done)?;
        let waiting = m.and_not(&up, &done)?;
        if m.is_false(&m.and(reached, &waiting)?) {
            continue;
        }
        // If no play waits for ever and satisfies all justice, every controller completes the
        // request.
        if m.is_false(&m.and(reached, &lasting(arena, moves, &waiting)?)?) {
            continue;
        }
        let mut goals = arena.goals.clone();
        goals.push(m.not(&waiting)?);
        let demanding = Arena {
            goals,
            ..arena.clone()
        };
        request.enforceable = demanding.wins_initially(&winning_states(&demanding)?)?;
        if request.enforceable || !names_exception(arena, reached, &waiting)? {
            found.push(request);
        }
    }
    Ok(found)
}

/// Whether the contract names what may come in place of a completion, like a fault: some goal, open
/// at times, is met by every completion and by a part of the waiting.
fn names_exception<K: Kernel>(
    arena: &Arena<K>,
    reached: &K::Function,
    waiting: &K::Function,
) -> Result<bool, Limit> {
    let m = &arena.kernel;
    let waiting = m.and(reached, waiting)?;
    for goal in &arena.goals {
        let unmet = m.and_not(reached, goal)?;
        if !m.is_false(&unmet)
            && m.is_false(&m.and_not(&unmet, &waiting)?)
            && !m.is_false(&m.and(&waiting, goal)?)
        {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns the requests that a specification declares, without a verdict on them. In place of D,
/// an assumption that a request is held may have any condition about outputs, as in
/// `always (R and verdict = none -> next R)`.
#[must_use]
pub fn declared_requests(specification: &Specification) -> Vec<Request> {
    let mut found: Vec<Request> = Vec::new();
    for (assumption, formula) in all(&specification.assumptions) {
        if assumption.kind != Kind::Safety {
            continue;
        }
        for part in formula.expr.conjuncts() {
            if let Some((request, done, output)) = held(specification, part) {
                found.push(Request {
                    request,
                    done,
                    output,
                    held_by: Some(assumption),
                    enforceable: false,
                });
            }
        }
    }
    let named = specification.outputs().filter_map(|v| {
        let name = &specification.variable(v).name;
        let stem = ["_executed", "_done"]
            .iter()
            .find_map(|end| name.strip_suffix(end))?;
        let bool_output = specification.variable(v).domain == Domain::Bool;
        Some((v, stem)).filter(|_| bool_output)
    });
    for (output, stem) in named {
        if found.iter().any(|r| r.output == output) {
            continue;
        }
        let request =
            specification
                .inputs()
                .find_map(|input| match &specification.variable(input).domain {
                    Domain::Enum { labels, .. } => {
                        let label = labels.iter().position(|l| l == stem)?;
                        Some(Expr::now(input).equals(Expr::Const(label as i64)))
                    }
                    _ => None,
                });
        if let Some(request) = request {
            found.push(Request {
                request,
                done: Expr::now(output),
                output,
                held_by: None,
                enforceable: false,
            });
        }
    }
    found
}

/// Returns R, D and the output of a formula `R and not D -> next R`; `None` for any other formula.
fn held(specification: &Specification, expr: &Expr) -> Option<(Expr, Expr, VarId)> {
    let Expr::Binary(BinaryOp::Implies, before, after) = expr else {
        return None;
    };
    let mut done = None;
    let mut request: Vec<Expr> = Vec::new();
    for part in before.conjuncts() {
        match output_of(specification, part) {
            Some(output) if done.is_none() => {
                let is_done = match part {
                    Expr::Unary(UnaryOp::Not, inner) => (**inner).clone(),
                    other => other.clone().not(),
                };
                done = Some((is_done, output));
            }
            _ => request.push(part.clone()),
        }
    }
    let held_parts = after.conjuncts();
    // All of R must be held. If only a part of R is held, the request can change.
    let kept = |r: &Expr| {
        let mut of_inputs = true;
        r.for_each_var(&mut |v, t| {
            of_inputs &= t == Time::Now && specification.variable(v).owner == Owner::Environment;
        });
        let next = r.substitute(&mut |v, _| Expr::next(v));
        of_inputs && held_parts.contains(&&next)
    };
    if !request.iter().all(kept) {
        return None;
    }
    let request = request.into_iter().reduce(Expr::and)?;
    let (done, output) = done?;
    Some((request, done, output))
}

/// Returns an output that a condition mentions, if it mentions current values of outputs only.
fn output_of(specification: &Specification, condition: &Expr) -> Option<VarId> {
    let (mut output, mut is_about_outputs) = (None, true);
    condition.for_each_var(&mut |v, t| {
        output = output.or(Some(v));
        is_about_outputs &= t == Time::Now && specification.variable(v).owner == Owner::System;
    });
    output.filter(|_| is_about_outputs)
}
