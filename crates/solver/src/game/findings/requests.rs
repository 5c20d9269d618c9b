//! Checks whether an accepted request is always completed.
//!
//! A contract declares a request in one of two ways. It assumes that the request is held until it
//! is done, `always (R and not D -> next R)`, where D is an output; or it has an output
//! `turn_executed` or `turn_done` for an input that has the value `turn`. The property is
//! `always eventually (not R or D)`: does every controller ensure it, can one, or none?

use crate::game::arena::Arena;
use crate::game::fixpoint::winning_states;
use crate::game::lasting::lasting;
use crate::game::reference::{AssumptionRef, GuaranteeKind as Kind, all};
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Owner, Specification, Time, UnaryOp, VarId};
use serde::{Deserialize, Serialize};

/// A request that need not be completed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// Condition under which it is pending; over current values.
    pub request: Expr,
    /// Condition under which it is done; over current values.
    pub done: Expr,
    /// The output that signals completion.
    pub output: VarId,
    /// The assumption that it is held, if that declares it.
    pub held_by: Option<AssumptionRef>,
    /// Whether some controller can ensure completion. If none can, it is completed only by chance.
    pub enforceable: bool,
}

/// Declared requests that need not be completed.
pub fn open<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    reached: &K::Function,
    moves: &K::Function,
) -> Result<Vec<Request>, Limit> {
    let m = &arena.kernel;
    let mut open = Vec::new();
    for mut request in declared(specification) {
        let up = arena.encoding.formula(m, &request.request)?;
        let done = arena.encoding.formula(m, &request.done)?;
        let waiting = m.and_not(&up, &done)?;
        if m.is_false(&m.and(reached, &waiting)?) {
            continue;
        }
        // A play of some controller that waits for ever and yet keeps all justice.
        if m.is_false(&m.and(reached, &lasting(arena, moves, &waiting)?)?) {
            continue;
        }
        let mut goals = arena.goals.clone();
        goals.push(m.not(&waiting)?);
        let asked = Arena {
            goals,
            ..arena.clone()
        };
        request.enforceable = asked.wins_initially(&winning_states(&asked)?)?;
        open.push(request);
    }
    Ok(open)
}

/// The requests that a specification declares.
fn declared(specification: &Specification) -> Vec<Request> {
    let mut found: Vec<Request> = Vec::new();
    for (assumption, formula) in all(&specification.assumptions) {
        if assumption.kind != Kind::Safety {
            continue;
        }
        for part in formula.expr.conjuncts() {
            if let Some((request, output)) = held(specification, part) {
                found.push(Request {
                    request,
                    done: Expr::now(output),
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

/// The request and the output of `R and not D -> next R`.
fn held(specification: &Specification, expr: &Expr) -> Option<(Expr, VarId)> {
    let Expr::Binary(BinaryOp::Implies, before, after) = expr else {
        return None;
    };
    let mut done = None;
    let mut request: Vec<Expr> = Vec::new();
    for part in before.conjuncts() {
        match part {
            Expr::Unary(UnaryOp::Not, inner) => {
                if let Expr::Var(v, Time::Now) = **inner
                    && specification.variable(v).owner == Owner::System
                    && done.is_none()
                {
                    done = Some(v);
                    continue;
                }
                request.push(part.clone());
            }
            other => request.push(other.clone()),
        }
    }
    let asked = after.conjuncts();
    // All of it is held. If only a part were, that part could stay while the request changes.
    let kept = |r: &Expr| {
        let mut of_inputs = true;
        r.for_each_var(&mut |v, t| {
            of_inputs &= t == Time::Now && specification.variable(v).owner == Owner::Environment;
        });
        let next = r.substitute(&mut |v, _| Expr::next(v));
        of_inputs && asked.contains(&&next)
    };
    if !request.iter().all(kept) {
        return None;
    }
    let request = request.into_iter().reduce(Expr::and)?;
    Some((request, done?))
}
