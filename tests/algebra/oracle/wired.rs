//! Random systems of parts that read one another's outputs.

use super::contracts::{Scope, expression, formula, named};
use crate::random::Random;
use linewright::algebra::proof::latest;
use linewright::algebra::system::{Component, System};
use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, FormulaKind, Side, Timing, VarId, Variable,
};

/// Parameters of random systems.
pub struct Plan {
    pub parts: u64,
    /// Number of variables set from outside.
    pub outside: u64,
    /// Percentage of parts that answer first.
    pub moore: u64,
    /// Percentage of assumptions that are guarantees of another part, or weaker.
    pub derived: u64,
    /// Whether to assume more and guarantee less.
    pub demanding: bool,
    /// Percentage of guarantees of a part that answers second that mention the inputs of the step.
    pub sees: u64,
}

fn domain(r: &mut Random, wide: bool) -> Domain {
    if wide && r.chance(50) {
        Domain::Range { low: 0, high: 2 }
    } else {
        Domain::Bool
    }
}

/// A formula of this kind mentions values of the last step only from `latest`, all others from
/// everywhere.
fn written(r: &mut Random, variables: &[Variable], kind: FormulaKind, latest: &[VarId]) -> Expr {
    let everything = Scope::all(variables, false).now;
    let scope = match kind {
        FormulaKind::Initial | FormulaKind::Invariant => Scope {
            variables,
            now: latest.to_vec(),
            next: Vec::new(),
        },
        FormulaKind::Safety => Scope {
            variables,
            now: everything,
            next: latest.to_vec(),
        },
        FormulaKind::Justice => Scope {
            variables,
            now: everything,
            next: Vec::new(),
        },
    };
    expression(r, &scope)
}

/// Guarantees of a part: often the value of its output under a condition.
fn guarantees(
    r: &mut Random,
    variables: &[Variable],
    own: VarId,
    timing: Timing,
    name: &str,
    plan: &Plan,
) -> Side {
    let others: Vec<VarId> = (0..variables.len() as u32)
        .map(VarId)
        .filter(|v| *v != own)
        .collect();
    let mut side = Side::default();
    for (kind, percent) in [
        (FormulaKind::Initial, 60),
        (FormulaKind::Invariant, 25),
        (FormulaKind::Safety, 60),
        (FormulaKind::Safety, 30),
        (FormulaKind::Justice, 50),
        (FormulaKind::Justice, 15),
    ] {
        if !r.chance(if plan.demanding { percent / 2 } else { percent }) {
            continue;
        }
        // Usually only a part that sees the step's inputs mentions them.
        let sees = match timing {
            Timing::Mealy => r.chance(plan.sees),
            Timing::Moore => r.chance(4),
        };
        let mut latest = vec![own];
        if sees {
            latest.push(others[r.below(others.len() as u64) as usize]);
        }
        let is_bool = variables[own.index()].domain == Domain::Bool;
        let expr = if kind == FormulaKind::Safety && is_bool && r.chance(50) {
            let from = if sees { others.clone() } else { vec![own] };
            let rest = written(
                r,
                variables,
                if sees { kind } else { FormulaKind::Justice },
                &from,
            );
            Expr::binary(BinaryOp::Eq, Expr::next(own), rest)
        } else {
            written(r, variables, kind, &latest)
        };
        let place = side.list(kind).len();
        side.list_mut(kind)
            .push(formula(format!("{name} guarantees {kind:?} {place}"), expr));
    }
    side
}

/// Assumptions of a part about the others: their guarantees, weaker formulas, or random ones.
fn assumptions(r: &mut Random, system: &System, part: usize, plan: &Plan) -> Side {
    let own = system.components[part].drives[0];
    let variables = &system.variables;
    let others: Vec<VarId> = (0..variables.len() as u32)
        .map(VarId)
        .filter(|v| *v != own)
        .collect();
    let promised: Vec<(FormulaKind, &Formula)> = system
        .components
        .iter()
        .enumerate()
        .filter(|(j, _)| *j != part)
        .flat_map(|(_, p)| {
            FormulaKind::ALL
                .into_iter()
                .flat_map(|kind| p.guarantees.list(kind).iter().map(move |f| (kind, f)))
        })
        .filter(|(kind, f)| *kind == FormulaKind::Justice || !latest(&f.expr, *kind).contains(&own))
        .collect();
    let mut side = Side::default();
    let percents: &[u64] = if plan.demanding {
        &[95, 80, 60, 40]
    } else {
        &[80, 50, 20]
    };
    for percent in percents.iter().copied() {
        if !r.chance(percent) {
            continue;
        }
        let (kind, expr) = if !promised.is_empty() && r.chance(plan.derived) {
            let (kind, formula) = promised[r.below(promised.len() as u64) as usize];
            let expr = formula.expr.clone();
            if r.chance(40) {
                (kind, expr.or(written(r, variables, kind, &others)))
            } else {
                (kind, expr)
            }
        } else {
            let kind = FormulaKind::ALL[r.below(4) as usize];
            let expr = written(r, variables, kind, &others);
            if plan.demanding {
                (kind, expr)
            } else {
                // Weakened, since it would rarely hold otherwise.
                (kind, expr.or(written(r, variables, kind, &others)))
            }
        };
        let place = side.list(kind).len();
        let name = format!("{} assumes {kind:?} {place}", system.components[part].name);
        side.list_mut(kind).push(formula(name, expr));
    }
    side
}

/// A system whose parts drive one variable each; the last variables come from outside. `mend` may
/// change it after the guarantees are set, and after the assumptions are.
pub fn system(r: &mut Random, plan: &Plan, mend: &dyn Fn(&mut Random, &mut System)) -> System {
    let count = plan.parts + plan.outside;
    let wide = r.below(2 * count);
    let domains: Vec<Domain> = (0..count).map(|i| domain(r, i == wide)).collect();
    let variables = named(&domains);
    let mut parts = Vec::new();
    for i in 0..plan.parts {
        let timing = if r.chance(plan.moore) {
            Timing::Moore
        } else {
            Timing::Mealy
        };
        let own = VarId(i as u32);
        let name = ["A", "B", "C"][i as usize];
        parts.push(Component {
            name: name.to_owned(),
            timing,
            drives: vec![own],
            assumptions: Side::default(),
            guarantees: guarantees(r, &variables, own, timing, name, plan),
            definitions: Side::default(),
            completions: Side::default(),
        });
    }
    let mut system = System {
        variables,
        components: parts,
    };
    mend(r, &mut system);
    for i in 0..plan.parts as usize {
        system.components[i].assumptions = assumptions(r, &system, i, plan);
    }
    mend(r, &mut system);
    system
}
