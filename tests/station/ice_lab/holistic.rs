//! The assembly cell in one contract (`holistic.lw`) compared with the cell in parts (`cell.lw`).
//!
//! Three questions: whether every rule of every part is in the single contract, under its name, on
//! the correct side and with the same meaning; whether the single contract is realizable, and not
//! vacuously; and whether the cell in parts, on random walks, is an implementation of it that
//! reaches every job and every action.
//!
//! The rules are compared through the parts as combined in the cell: a part's variables are
//! replaced by the wires they are bound to, and both formulas are evaluated on random pairs of
//! steps.

use crate::differential::Random;
use crate::laboratory::{Controlled, machines};
use linewright::algebra::proof::completions;
use linewright::contract::machine::Machine;
use linewright::diagnostics::has_errors;
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::{Limits, Outcome, examine_environment, solve};
use linewright::gr1::{Domain, Expr, Formula, Owner, Side, Specification, VarId, eval};
use linewright::station::Controller;
use linewright::station::interpret::Interpreter;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Number of pairs of steps on which two formulas are compared.
const SAMPLES: usize = 30_000;

/// Number of steps of the walk.
const STEPS: usize = 20_000;

/// The holistic contract with the arguments that `machine` in the `holistic.lw` beside this file
/// gives it.
fn holistic(machine: &str) -> Arc<Specification> {
    let file = crate::support::root().join("tests/station/ice_lab/holistic.lw");
    let loaded = files::load(&[file.display().to_string()], &StandardLibrary::default());
    assert!(!has_errors(&loaded.findings), "{:?}", loaded.findings);
    let machines = &loaded.library.machines;
    let machine = machines.iter().find(|m| m.name == machine).expect(machine);
    Arc::clone(&machine.components[0].specification)
}

/// The cell in parts.
fn parts() -> &'static Controlled {
    let cell = machines().iter().find(|m| m.machine.name == "AssemblyCell");
    cell.expect("the line has it")
}

/// The name in the holistic contract of a component's variable: `pick_a_stage`, and
/// `pick_a_executed` for its `pick_executed`. The coordinator's variables keep their names.
fn holistic_name(machine: &Machine, component: usize, variable: &str) -> String {
    let component = &machine.components[component];
    if machine
        .coordinator()
        .is_some_and(|c| c.name == component.name)
    {
        return variable.to_owned();
    }
    let action = format!("{}_", component.contract.to_lowercase());
    let own = variable.strip_prefix(&action).unwrap_or(variable);
    format!("{}_{own}", component.name)
}

/// The variable of the holistic contract for each wire of the cell.
fn wires(machine: &Machine, whole: &Specification) -> Vec<VarId> {
    let plant = machine.plant.iter().map(|input| match input.name.as_str() {
        "operation" => "job".to_owned(),
        name => name.to_owned(),
    });
    let outputs = machine.components.iter().enumerate();
    let outputs = outputs.flat_map(|(i, component)| {
        let s = &component.specification;
        s.outputs()
            .map(move |id| holistic_name(machine, i, &s.variable(id).name))
    });
    let names: Vec<String> = plant.chain(outputs).collect();
    let mut found = Vec::new();
    for name in &names {
        let place = whole.variables.iter().position(|v| v.name == *name);
        let place = place.unwrap_or_else(|| panic!("`{name}` is a variable of the contract"));
        found.push(VarId(place as u32));
    }
    let distinct: BTreeSet<VarId> = found.iter().copied().collect();
    assert_eq!(distinct.len(), whole.variables.len(), "no other variable");
    for (wire, &id) in found.iter().enumerate() {
        let variable = whole.variable(id);
        let (owner, domain) = match machine.plant.get(wire) {
            Some(input) => (Owner::Environment, input.domain.clone()),
            None => (Owner::System, domain_of(machine, wire)),
        };
        // The plant's wire for jobs has the numbers of the operations; the labels are the
        // coordinator's.
        assert_eq!(variable.owner, owner, "{}", variable.name);
        let values = (variable.domain.low(), variable.domain.high());
        assert_eq!(values, (domain.low(), domain.high()), "{}", variable.name);
    }
    found
}

fn domain_of(machine: &Machine, wire: usize) -> Domain {
    let mut first = machine.plant.len();
    for component in &machine.components {
        let s = &component.specification;
        let outputs: Vec<VarId> = s.outputs().collect();
        if let Some(&id) = outputs.get(wire - first) {
            return s.variable(id).domain.clone();
        }
        first += outputs.len();
    }
    panic!("wire {wire} belongs to a component");
}

/// A component's formula over the holistic contract's variables.
fn in_place(machine: &Machine, component: usize, wires: &[VarId], expr: &Expr) -> Expr {
    let part = &machine.components[component];
    let inputs: Vec<VarId> = part.specification.inputs().collect();
    let outputs: Vec<VarId> = part.specification.outputs().collect();
    let first = machine.first_wire(component);
    expr.substitute(&mut |id, time| {
        let input = inputs.iter().position(|i| *i == id);
        if let Some(input) = input {
            return part.bindings[input].substitute(&mut |w, _| Expr::Var(wires[w.index()], time));
        }
        let output = outputs.iter().position(|o| *o == id);
        let output = output.expect("a variable is an input or an output");
        Expr::Var(wires[first + output], time)
    })
}

/// Kind of a formula, on one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Initial,
    Invariant,
    Safety,
    Justice,
}

/// The formulas of one side by rule and kind. A rule with several conjuncts of one kind is their
/// conjunction.
fn rules(side: &Side) -> BTreeMap<(String, Kind), Expr> {
    let mut rules: BTreeMap<(String, Kind), Expr> = BTreeMap::new();
    let mut add = |kind: Kind, formulas: &[Formula]| {
        for formula in formulas {
            let rule = rules.entry((formula.name.clone(), kind));
            let rule = rule.or_insert(Expr::TRUE);
            *rule = rule.clone().and(formula.expr.clone());
        }
    };
    add(Kind::Initial, &side.initial);
    add(Kind::Invariant, &side.invariants);
    add(Kind::Safety, &side.safety);
    add(Kind::Justice, &side.justice);
    rules
}

/// Values of all variables in two steps. Smallest values (none, false, 0) and unchanged outputs are
/// drawn more often than others, since rules mention them.
fn sample(whole: &Specification, random: &mut Random) -> (Vec<i64>, Vec<i64>) {
    let (mut now, mut next) = (Vec::new(), Vec::new());
    for variable in &whole.variables {
        let domain = &variable.domain;
        let value = match random.below(2) {
            0 => domain.low(),
            _ => random.within(domain),
        };
        now.push(value);
        next.push(match random.below(3) {
            0 => random.within(domain),
            _ => value,
        });
    }
    (now, next)
}

/// Rules that the plant's side of the holistic contract must express differently: a part's
/// assumption about the plant's next value may require a request in the next step, which the plant
/// of the whole cell does not see yet. They are compared on steps that keep the coordinator's
/// rules, by which a request continues exactly while it is not executed.
const SAID_DIFFERENTLY: [&str; 2] = ["move_a_target_held", "turn_a_target_held"];

/// The one rule that mentions only constants: arm b moves to where the arms meet and nowhere else.
const SAYS_NOTHING: [&str; 1] = ["move_b_target_held"];

/// Whether a pair of steps keeps the coordinator's own rules, and can occur: without a job, no
/// command.
fn coordinated(whole: &Specification, now: &[i64], next: &[i64]) -> bool {
    let value = |name: &str| {
        let place = whole.variables.iter().position(|v| v.name == name);
        now[place.expect("a variable")]
    };
    let own = |f: &&Formula| f.name.starts_with("cell_");
    let mut safety = whole.guarantees.safety.iter().filter(own);
    (value("phase") != 0 || value("command") == 0)
        && safety.all(|f| eval::holds(&f.expr, now, next))
}

#[test]
fn every_rule_of_the_seven_contracts_is_in_the_holistic_one() {
    let whole = holistic("Same");
    let machine = &parts().machine;
    let wires = wires(machine, &whole);
    let (mut assumed, mut guaranteed) = (rules(&whole.assumptions), rules(&whole.guarantees));
    let mut random = Random(3);
    let pairs: Vec<_> = (0..SAMPLES).map(|_| sample(&whole, &mut random)).collect();
    let mut steps: Vec<(Vec<i64>, Vec<i64>)> = Vec::new();
    while steps.len() < SAMPLES {
        let (now, next) = sample(&whole, &mut random);
        if coordinated(&whole, &now, &next) {
            steps.push((now, next));
        }
    }

    let (mut silent, mut different) = (Vec::new(), Vec::new());
    let contracts: BTreeSet<&str> = machine.components.iter().map(|c| &*c.contract).collect();
    assert_eq!(contracts.len(), 7, "{contracts:?}");
    for (index, component) in machine.components.iter().enumerate() {
        let s = &component.specification;
        // Where the other guarantees fix each step, `completes` follows from them.
        let named = |f| Formula {
            name: "completes".to_owned(),
            ..f
        };
        let follows = completions(s, &Limits::default()).expect("no limit");
        let follows = Side {
            justice: follows.into_iter().map(named).collect(),
            ..Side::default()
        };
        let sides = [
            (&s.assumptions, true),
            (&s.guarantees, false),
            (&follows, false),
        ];
        for (side, is_assumption) in sides {
            for ((rule, kind), expr) in rules(side) {
                let name = format!("{}_{rule}", component.name);
                let expr = in_place(machine, index, &wires, &expr).simplify();
                if expr == Expr::TRUE {
                    silent.push(name);
                    continue;
                }
                // What only the cell decides cannot be assumed of the plant.
                let mut of_plant = false;
                expr.for_each_var(&mut |v, _| {
                    of_plant |= whole.variable(v).owner == Owner::Environment;
                });
                let place = if is_assumption && of_plant {
                    &mut assumed
                } else {
                    &mut guaranteed
                };
                let key = (name, kind);
                let ours = place.remove(&key);
                let ours = ours.unwrap_or_else(|| panic!("{key:?} is missing"));
                let name = key.0;
                let compared = if SAID_DIFFERENTLY.contains(&name.as_str()) {
                    different.push(name.clone());
                    &steps
                } else {
                    &pairs
                };
                let mut seen = [0, 0];
                for (now, next) in compared {
                    let (theirs, ours) =
                        (eval::holds(&expr, now, next), eval::holds(&ours, now, next));
                    assert_eq!(theirs, ours, "{name} with {now:?} and then {next:?}");
                    seen[usize::from(ours)] += 1;
                }
                assert!(
                    seen[0] > 5 && seen[1] > 5,
                    "{name} is hardly compared: {seen:?}"
                );
            }
        }
    }
    assert_eq!(silent, SAYS_NOTHING);
    assert_eq!(different, SAID_DIFFERENTLY);
    let rest: Vec<_> = assumed.keys().chain(guaranteed.keys()).collect();
    assert!(rest.is_empty(), "rules that no part has: {rest:?}");
}

#[test]
fn the_holistic_contract_is_realizable_over_small_domains_and_not_for_want_of_a_plant() {
    let whole = holistic("Small");
    let limits = Limits::default();
    assert!(matches!(solve(&whole, &limits), Outcome::Realizable(_)));
    let found = examine_environment(&whole, &limits).expect("no limit");
    assert!(!found.cannot_start && !found.unsatisfiable);
    assert_eq!(
        found.stuck_at_start.or(found.dead_end).or(found.forced),
        None
    );
}

/// The steps of an implementation keep both sides, and reach everything.
#[test]
fn the_cell_in_parts_implements_the_holistic_contract() {
    let whole = holistic("Same");
    let Controlled {
        machine,
        controllers,
    } = parts();
    let wires = wires(machine, &whole);
    let mut cell = Interpreter::new(Arc::clone(machine), Arc::clone(controllers));
    let mut random = Random(5);
    let mut plant: Vec<i64> = machine.plant.iter().map(|p| p.domain.low()).collect();
    let mut outputs = vec![0; machine.wire_count() - plant.len()];
    let mut before: Option<Vec<i64>> = None;
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for step in 0..STEPS {
        // A plant that keeps the assumptions: the first of some random changes that violates no
        // part's assumption.
        let mut candidates = (0..2_000).map(|_| {
            let inputs = machine.plant.iter().zip(&plant);
            let mut change = |p: &Domain, old: i64| {
                if random.below(3) == 0 {
                    random.within(p)
                } else {
                    old
                }
            };
            inputs.map(|(p, &old)| change(&p.domain, old)).collect()
        });
        plant = candidates
            .find(|c: &Vec<i64>| cell.peek(c).is_ok())
            .expect("the plant always has a step");
        cell.step(&plant, &mut outputs).expect("as just looked at");
        let mut values = vec![0; whole.variables.len()];
        for (id, &value) in wires.iter().zip(plant.iter().chain(&outputs)) {
            values[id.index()] = value;
        }
        let sides = [&whole.assumptions, &whole.guarantees];
        for side in sides {
            let broken = match &before {
                None => side
                    .initial
                    .iter()
                    .find(|f| !eval::holds(&f.expr, &values, &[])),
                Some(last) => side
                    .safety
                    .iter()
                    .find(|f| !eval::holds(&f.expr, last, &values)),
            };
            let invariants = &side.invariants;
            let broken = broken.or_else(|| {
                invariants
                    .iter()
                    .find(|f| !eval::holds(&f.expr, &values, &[]))
            });
            assert!(broken.is_none(), "step {step}: {broken:?} with {values:?}");
            for goal in &side.justice {
                if eval::holds(&goal.expr, &values, &[]) {
                    *seen.entry(goal.name.clone()).or_default() += 1;
                }
            }
        }
        for (variable, &value) in whole.variables.iter().zip(&values) {
            if variable.owner == Owner::System {
                let shown = format!("{} = {}", variable.name, variable.domain.show(value));
                *seen.entry(shown).or_default() += 1;
            }
        }
        before = Some(values);
    }
    let goals = whole.assumptions.justice.iter();
    for goal in goals.chain(&whole.guarantees.justice) {
        let count = seen.get(&goal.name).copied().unwrap_or(0);
        assert!(count > STEPS / 10, "{}: {count}", goal.name);
    }
    for variable in whole.variables.iter().filter(|v| v.owner == Owner::System) {
        // Arm b moves to where the arms meet, and no farther.
        if ["move_b_x", "move_b_y"].contains(&variable.name.as_str()) {
            continue;
        }
        for value in variable.domain.low()..=variable.domain.high() {
            let shown = format!("{} = {}", variable.name, variable.domain.show(value));
            assert!(seen.contains_key(&shown), "{shown} never occurs");
        }
    }
}
