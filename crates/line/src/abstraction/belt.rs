//! Derives from a belt's contract how many parts the belt certainly has room for.
//!
//! A belt need not close gaps. For example, a belt that moves as a whole stands still while its
//! last part waits to be taken. A part on its first place then prevents others from coming on, even
//! if there is room in the middle. The abstraction needs one number: with fewer parts than this on
//! it, the belt accepts another one even while the first part waits. The number is derived from the
//! contract, and so is the guarantee that parts reach the end at all.

use super::words::{all, count, is};
use linewright_core::gr1::{BinaryOp, Domain, Expr, FormulaKind, Owner, VarId, Variable};
use linewright_language::contract::line::Belt;
use linewright_language::contract::machine::Machine;
use linewright_solver::game::{Budget, Limit, Limits, Rule, RunQuery, Runs};

/// Room on a belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Room {
    /// With fewer parts than this on the belt, another one comes on even while the first one waits.
    /// The number is at least 1.
    Sure(u32),
    /// The contract does not guarantee that an empty belt takes a part.
    TakesNone,
    /// The contract does not guarantee that parts reach the end.
    BringsNone,
}

/// Derives the room from the contract.
pub(super) fn room(belt: &Belt) -> Result<Room, Limit> {
    let limits = Limits::default().with_budget(Budget::CONVEYOR);
    let (variables, mut rules, mut again) = contract(&belt.machine);
    let kept: Vec<usize> = (0..rules.len()).collect();
    let wire = |wire: usize| VarId(wire as u32);
    let on = |at: usize| is(wire(at), 1);
    let held = count(belt.places.iter().map(|place| on(*place)));
    let loaded = on(belt.load).and(on(belt.ready).not());
    let blocked = loaded.clone().and(on(belt.unload_ready).not());
    let with = |n: usize| held.clone().equals(Expr::Const(n as i64));
    // Each guarantee would be violated by a run in which one of these conditions holds for ever
    // from some step on.
    let last = belt.places.last().map_or(Expr::FALSE, |last| on(*last));
    let some = Expr::binary(BinaryOp::Gt, held.clone(), Expr::Const(0));
    let mut bad = vec![
        some.and(last.not()),
        all([with(0), loaded, on(belt.unload_ready)]),
    ];
    bad.extend((1..belt.places.len()).map(|n| with(n).and(blocked.clone())));
    let first = rules.len();
    rules.extend(bad.into_iter().map(|expr| justice(expr.not())));
    let justices = rules.len();
    rules.append(&mut again);
    let again: Vec<usize> = (justices..rules.len()).collect();
    let mut runs = Runs::new(&variables, rules, &limits)?;
    let mut may_stay = |question: usize, again: &[usize]| {
        let wanted = RunQuery {
            keep: kept.clone(),
            infinitely_often: again.to_vec(),
            finitely_often: vec![first + question],
        };
        runs.find_lasso(&wanted).map(|lasso| lasso.is_some())
    };
    if may_stay(0, &[])? {
        return Ok(Room::BringsNone);
    }
    // In this question, the next place is ready to take parts. Only in this case, the contract's
    // justice is used.
    if may_stay(1, &again)? {
        return Ok(Room::TakesNone);
    }
    for number in 1..belt.places.len() {
        if may_stay(number + 1, &[])? {
            return Ok(Room::Sure(number as u32));
        }
    }
    Ok(Room::Sure(belt.places.len() as u32))
}

fn justice(expr: Expr) -> Rule {
    Rule {
        kind: FormulaKind::Justice,
        expr,
    }
}

/// Returns the variables of a machine (its wires and its components' inputs), the rules of all its
/// contracts except justice, and their justice.
fn contract(machine: &Machine) -> (Vec<Variable>, Vec<Rule>, Vec<Rule>) {
    let new = |name: String, domain: &Domain| Variable {
        name,
        owner: Owner::System,
        internal: false,
        domain: domain.clone(),
        unit: String::new(),
        span: machine.span,
    };
    let plant = machine
        .plant
        .iter()
        .map(|input| new(input.name.clone(), &input.domain));
    let mut variables: Vec<Variable> = plant.collect();
    for component in &machine.components {
        let specification = &component.specification;
        let outputs = specification.outputs().map(|v| specification.variable(v));
        variables.extend(outputs.map(|v| new(v.name.clone(), &v.domain)));
    }
    let (mut rules, mut again) = (Vec::new(), Vec::new());
    for (index, component) in machine.components.iter().enumerate() {
        let specification = &component.specification;
        let mut place = vec![VarId(0); specification.variables.len()];
        for (wire, output) in specification.outputs().enumerate() {
            place[output.index()] = VarId((machine.first_wire(index) + wire) as u32);
        }
        for (input, binding) in specification.inputs().zip(&component.bindings) {
            let own = VarId(variables.len() as u32);
            let declared = specification.variable(input);
            variables.push(new(
                format!("{}.{}", component.name, declared.name),
                &declared.domain,
            ));
            place[input.index()] = own;
            rules.push(Rule {
                kind: FormulaKind::Invariant,
                expr: Expr::now(own).equals(binding.clone()),
            });
        }
        let put = |expr: &Expr| expr.substitute(&mut |v, time| Expr::Var(place[v.index()], time));
        let side = &specification.guarantees;
        let lists = [
            (FormulaKind::Initial, &side.initial),
            (FormulaKind::Invariant, &side.invariants),
            (FormulaKind::Safety, &side.safety),
        ];
        for (kind, list) in lists {
            rules.extend(list.iter().map(|f| Rule {
                kind,
                expr: put(&f.expr),
            }));
        }
        let own = side
            .justice
            .iter()
            .chain(&specification.assumptions.justice);
        again.extend(own.map(|f| justice(put(&f.expr))));
    }
    (variables, rules, again)
}
