//! Uses helper variables to rewrite what a format cannot express. Each lowering preserves the
//! verdict.
//!
//! The lowerings have to run in this order: [`without_invariants`], [`to_mealy`], and then, for
//! gr1c only, [`goals_to_states`] and [`initial_to_transitions`].

use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;

/// Replaces each invariant with an initial condition and a transition formula about next values.
#[must_use]
pub fn without_invariants(specification: &Specification) -> Specification {
    let mut result = specification.clone();
    for side in [&mut result.assumptions, &mut result.guarantees] {
        for formula in std::mem::take(&mut side.invariants) {
            let next = Formula {
                expr: primed(&formula.expr),
                ..formula.clone()
            };
            side.initial.push(formula);
            side.safety.push(next);
        }
    }
    result
}

/// Turns a Moore game into a Mealy game; a Mealy game is returned unchanged.
///
/// The system chooses its outputs one step ahead, in helper variables, so that they cannot depend
/// on the inputs of the same step. It chooses the initial outputs in an additional first step, in
/// which no other formula applies.
#[must_use]
pub fn to_mealy(specification: &Specification) -> Specification {
    if specification.timing == Timing::Mealy {
        return specification.clone();
    }
    let mut result = specification.clone();
    result.timing = Timing::Mealy;
    let started = helper(&mut result, "started", Domain::Bool);
    let outputs: Vec<VarId> = specification.outputs().collect();
    let mut links = Vec::new();
    for v in outputs {
        let variable = specification.variable(v);
        let chosen = helper(
            &mut result,
            &format!("chosen_{}", variable.name),
            variable.domain.clone(),
        );
        links.push(Expr::next(v).equals(Expr::now(chosen)));
    }
    for side in [&mut result.assumptions, &mut result.guarantees] {
        let initial = std::mem::take(&mut side.initial);
        for formula in &mut side.safety {
            formula.expr = Expr::now(started).implies(formula.expr.clone());
        }
        side.safety.extend(initial.into_iter().map(|f| Formula {
            expr: Expr::now(started).or(primed(&f.expr)),
            ..f
        }));
    }
    let side = &mut result.guarantees;
    side.initial
        .push(made_up("not started", Expr::now(started).not()));
    side.safety.push(made_up("started", Expr::next(started)));
    side.safety.extend(
        links
            .into_iter()
            .map(|link| made_up("chosen a step ahead", link)),
    );
    result
}

/// Replaces each goal that refers to next values with a goal about a state.
///
/// A helper variable of the system is true after each transition that satisfies the goal.
#[must_use]
pub fn goals_to_states(specification: &Specification) -> Specification {
    let mut result = specification.clone();
    let mut seen = Vec::new();
    for owner in [Owner::Environment, Owner::System] {
        for index in 0..side(&mut result, owner).justice.len() {
            let expr = side(&mut result, owner).justice[index].expr.clone();
            if expr.mentions_next() {
                let met = helper(&mut result, "goal_met", Domain::Bool);
                side(&mut result, owner).justice[index].expr = Expr::now(met);
                seen.push((met, expr));
            }
        }
    }
    for (met, expr) in seen {
        let side = &mut result.guarantees;
        side.initial
            .push(made_up("no goal met yet", Expr::now(met).not()));
        side.safety
            .push(made_up("the goal was met", Expr::next(met).equals(expr)));
    }
    result
}

/// Turns the system's initial conditions that refer to inputs into conditions on its first step.
///
/// After a wrong first step of the system, the environment can make any move and the system can
/// make none, so the system loses. If the environment were still bound by its safety assumptions,
/// it might have no move after a wrong first step, and the system would win.
#[must_use]
pub fn initial_to_transitions(specification: &Specification) -> Specification {
    let refers_to_inputs = |f: &Formula| {
        let mut found = false;
        f.expr.for_each_var(&mut |v, _| {
            found |= specification.variable(v).owner == Owner::Environment;
        });
        found
    };
    let initial = &specification.guarantees.initial;
    let (moved, kept): (Vec<Formula>, Vec<Formula>) =
        initial.iter().cloned().partition(refers_to_inputs);
    if moved.is_empty() {
        return specification.clone();
    }
    let mut result = specification.clone();
    let first = helper(&mut result, "first_step", Domain::Bool);
    let sound = super::terms::balanced(
        BinaryOp::And,
        moved.iter().map(|f| f.expr.clone()).collect(),
    );
    for formula in &mut result.assumptions.safety {
        let wrong = Expr::now(first).and(sound.clone().not());
        formula.expr = wrong.or(formula.expr.clone());
    }
    let side = &mut result.guarantees;
    side.initial = kept;
    side.initial
        .push(made_up("the first step", Expr::now(first)));
    side.safety
        .push(made_up("the first step", Expr::next(first).not()));
    side.safety.extend(moved.into_iter().map(|f| Formula {
        expr: Expr::now(first).implies(f.expr.clone()),
        ..f
    }));
    result
}

/// The formula with next values in place of current ones.
fn primed(expr: &Expr) -> Expr {
    expr.substitute(&mut |v, _| Expr::Var(v, Time::Next))
}

fn side(specification: &mut Specification, owner: Owner) -> &mut Side {
    match owner {
        Owner::Environment => &mut specification.assumptions,
        Owner::System => &mut specification.guarantees,
    }
}

fn helper(specification: &mut Specification, wanted: &str, domain: Domain) -> VarId {
    let mut name = wanted.to_owned();
    while specification.variables.iter().any(|v| v.name == name) {
        name.push('_');
    }
    specification.variables.push(Variable {
        name,
        owner: Owner::System,
        internal: true,
        unit: String::new(),
        domain,
        span: Span::default(),
    });
    VarId(specification.variables.len() as u32 - 1)
}

fn made_up(name: &str, expr: Expr) -> Formula {
    Formula {
        defines: false,
        name: name.to_owned(),
        requirement: None,
        expr,
        span: Span::default(),
        text: String::new(),
    }
}
