//! What a format cannot say, said with helper variables. Each lowering gives a specification with
//! the same verdict.
//!
//! They build on one another, so their order is fixed: [`without_invariants`],
//! [`answering_second`], then what only gr1c needs: [`goals_of_states`] and [`starting_alone`].

use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;

/// Invariants as initial conditions and transitions: they hold at the start, and in whatever comes
/// next.
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

/// A machine that answers before it sees the inputs, as one that answers after: it names its next
/// outputs a step ahead, so that they cannot depend on what comes in with them. A step is put in
/// front, in which it names the first ones and nothing else is asked.
#[must_use]
pub fn answering_second(specification: &Specification) -> Specification {
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

/// Goals over next values as goals over states: a helper of the machine is true after each
/// transition that satisfies the goal.
#[must_use]
pub fn goals_of_states(specification: &Specification) -> Specification {
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

/// Initial conditions of the machine that refer to inputs, as a condition on its first step.
///
/// Where the machine has started wrongly, the environment may do anything next, so that it surely
/// has a move, and the machine has none. Without this freedom a machine could start wrongly
/// wherever the environment is stuck at once.
#[must_use]
pub fn starting_alone(specification: &Specification) -> Specification {
    let about_inputs = |f: &Formula| {
        let mut found = false;
        f.expr.for_each_var(&mut |v, _| {
            found |= specification.variable(v).owner == Owner::Environment;
        });
        found
    };
    let initial = &specification.guarantees.initial;
    let (moved, kept): (Vec<Formula>, Vec<Formula>) =
        initial.iter().cloned().partition(about_inputs);
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

/// A formula about the next values.
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
