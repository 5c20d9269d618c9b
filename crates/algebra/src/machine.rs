//! Machines as systems: components over the machine's wires, and the facts about the plant that the
//! machine's file declares.

use super::proof::{Claim, Exports};
use super::system::{Component, System};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, PlantInput, PlantSource, RefinedContract};

/// Returns a machine's components as a system, and the claim that they discharge one another's
/// assumptions and keep the machine's guarantees.
///
/// The givens are the facts that the machine's file declares: some signals are constant, the
/// scripts of other signals restart with every call, and the operation and the values read from the
/// part stay until the operation is done. Assumptions about outside values can be exported to the
/// machine's caller, for the first step of a call. A machine without operations is only stepped;
/// its caller is responsible for everything from outside.
pub fn of_machine(machine: &Machine) -> (System, Claim) {
    let mut system = components(machine);
    let rules = &machine.guarantees;
    system.variables.extend(rules.monitors.iter().cloned());
    if !rules.monitors.is_empty() {
        let first = machine.wire_count() as u32;
        let monitors = (0..rules.monitors.len() as u32).map(|i| VarId(first + i));
        system.components.push(monitor_component(
            monitors.collect(),
            rules.definitions.clone(),
        ));
    }
    let mut goal = rules.side.clone();
    let claim = match &machine.done {
        Some(done) => Claim {
            given: facts(machine, done, &mut system),
            goal: {
                goal.justice.push(completes(machine, done));
                goal
            },
            exports: Exports::After(done.clone()),
            ..Claim::default()
        },
        None => Claim {
            given: Side::default(),
            goal,
            exports: Exports::Always,
            ..Claim::default()
        },
    };
    (system, claim)
}

/// Name of the goal of every machine with operations: each call is done eventually. For a component
/// of a proof, it is the name of what may follow from its contract.
pub const COMPLETES: &str = "every request completes";

fn completes(machine: &Machine, done: &Expr) -> Formula {
    Formula {
        defines: false,
        name: COMPLETES.to_owned(),
        requirement: None,
        expr: done.clone(),
        span: machine.span,
        text: "always eventually done".to_owned(),
    }
}

/// Returns a machine's components as a system, and the claim that together they refine a contract:
/// under the assumptions of that contract only, they discharge one another's assumptions and keep
/// its guarantees.
pub fn of_refined_contract(machine: &Machine, refined: &RefinedContract) -> (System, Claim) {
    let mut system = components(machine);
    let specification = &refined.specification;
    let mut monitors = Vec::new();
    let places: Vec<Expr> = refined
        .bindings
        .iter()
        .zip(&specification.variables)
        .map(|(binding, variable)| {
            if let Some(expr) = binding {
                return expr.clone();
            }
            let id = VarId(system.variables.len() as u32);
            let name = system.fresh_name(&variable.name);
            system.variables.push(Variable {
                name,
                ..variable.clone()
            });
            monitors.push(id);
            Expr::now(id)
        })
        .collect();
    let whole = Component::mapped(specification, &refined.contract, &mut |v, time| {
        places[v.index()].substitute(&mut |w, _| Expr::Var(w, time))
    });
    if !monitors.is_empty() {
        system
            .components
            .push(monitor_component(monitors, whole.definitions));
    }
    let claim = Claim {
        given: whole.assumptions,
        goal: whole.guarantees,
        exports: Exports::Never,
        ..Claim::default()
    };
    (system, claim)
}

/// Creates a component that only defines monitors.
fn monitor_component(drives: Vec<VarId>, definitions: Side) -> Component {
    Component {
        name: "monitors".to_owned(),
        timing: Timing::Moore,
        drives,
        assumptions: Side::default(),
        guarantees: Side::default(),
        definitions,
        completions: Side::default(),
    }
}

/// Returns a machine's components over its wires.
fn components(machine: &Machine) -> System {
    let mut system = System::default();
    for wire in 0..machine.wire_count() {
        system.variables.push(wire_variable(machine, wire));
    }
    for (index, component) in machine.components.iter().enumerate() {
        let first = machine.first_wire(index);
        let specification = &component.specification;
        system.components.push(Component::mapped(
            specification,
            &component.name,
            &mut |v, time| over_wires(specification, &component.bindings, first, v, time),
        ));
    }
    system
}

/// Returns the expression over wires for a component's variable: the binding of an input, or the
/// wire of an output. `first` is the component's first wire.
pub fn over_wires(
    specification: &Specification,
    bindings: &[Expr],
    first: usize,
    v: VarId,
    time: Time,
) -> Expr {
    let place = |mut all: Box<dyn Iterator<Item = VarId> + '_>| all.position(|o| o == v);
    if specification.variable(v).owner == Owner::System {
        let place = place(Box::new(specification.outputs())).unwrap_or(0);
        return Expr::Var(VarId((first + place) as u32), time);
    }
    let place = place(Box::new(specification.inputs())).unwrap_or(0);
    bindings[place].substitute(&mut |w, _| Expr::Var(w, time))
}

fn wire_variable(machine: &Machine, wire: usize) -> Variable {
    let name = machine.wire_name(wire);
    if let Some(input) = machine.plant.get(wire) {
        return Variable {
            name,
            ..input.variable()
        };
    }
    let mut outputs = machine.components.iter().flat_map(|c| {
        let specification = &c.specification;
        specification.outputs().map(|v| specification.variable(v))
    });
    let output = outputs.nth(wire - machine.plant.len());
    Variable {
        name,
        owner: Owner::System,
        ..output
            .expect("the wire is not one of this machine; please report this")
            .clone()
    }
}

/// Returns the facts that the machine's file declares about the plant while operations run.
fn facts(machine: &Machine, done: &Expr, system: &mut System) -> Side {
    let mut side = Side::default();
    let at = |name: String, text: String, expr: Expr, span: Span| Formula {
        defines: false,
        name,
        requirement: None,
        expr: expr.simplify(),
        span,
        text,
    };
    for (wire, input) in machine.plant.iter().enumerate() {
        let wire = VarId(wire as u32);
        match &input.source {
            PlantSource::Signal { script } => signal(input, wire, script, done, system, &mut side),
            PlantSource::Operation | PlantSource::Property(_) => {
                let stays = Expr::next(wire).equals(Expr::now(wire));
                side.safety.push(at(
                    format!("{} is held", input.name),
                    format!("{} stays until the operation is done", input.name),
                    done.clone().not().implies(stays),
                    input.span,
                ));
            }
        }
        if matches!(input.source, PlantSource::Operation) {
            let one = machine
                .operations
                .iter()
                .map(|o| Expr::now(wire).equals(Expr::Const(o.value)));
            let names: Vec<&str> = machine.operations.iter().map(|o| o.name.as_str()).collect();
            let known = match names.as_slice() {
                [only] => format!("{} is {only}", input.name),
                several => format!("{} is one of {}", input.name, several.join(", ")),
            };
            side.invariants.push(at(
                format!("{} is known", input.name),
                known,
                one.fold(Expr::FALSE, Expr::or),
                input.span,
            ));
        }
    }
    side
}

/// Adds the facts about a signal: a constant value, or a script that restarts with every call.
fn signal(
    input: &PlantInput,
    wire: VarId,
    script: &[i64],
    done: &Expr,
    system: &mut System,
    side: &mut Side,
) {
    let shown: Vec<String> = script.iter().map(|v| input.domain.show(*v)).collect();
    let formula = |expr: Expr, text: String| Formula {
        defines: false,
        name: format!("signal {}", input.name),
        requirement: None,
        expr: expr.simplify(),
        span: input.span,
        text,
    };
    let [first, rest @ ..] = script else {
        return;
    };
    if rest.iter().all(|v| v == first) {
        let text = format!("{} = {}", input.name, shown[0]);
        let expr = Expr::now(wire).equals(Expr::Const(*first));
        side.invariants.push(formula(expr, text));
        return;
    }
    let text = format!(
        "{} = {} in turn, from the first with every call",
        input.name,
        shown.join(", ")
    );
    let place = VarId(system.variables.len() as u32);
    let last = script.len() as i64 - 1;
    system.variables.push(Variable {
        name: system.fresh_name(&format!("{} (place)", input.name)),
        owner: Owner::Environment,
        internal: true,
        domain: Domain::Range { low: 0, high: last },
        unit: String::new(),
        span: input.span,
    });
    let start = Expr::now(place).equals(Expr::Const(0));
    let on = Expr::If(
        Box::new(done.clone().or(Expr::now(place).equals(Expr::Const(last)))),
        Box::new(Expr::Const(0)),
        Box::new(Expr::binary(
            linewright_core::gr1::BinaryOp::Add,
            Expr::now(place),
            Expr::Const(1),
        )),
    );
    let value = script
        .iter()
        .enumerate()
        .rev()
        .fold(Expr::Const(*first), |rest, (i, v)| {
            Expr::If(
                Box::new(Expr::now(place).equals(Expr::Const(i as i64))),
                Box::new(Expr::Const(*v)),
                Box::new(rest),
            )
        });
    side.initial.push(formula(start, text.clone()));
    side.safety
        .push(formula(Expr::next(place).equals(on), text.clone()));
    side.invariants
        .push(formula(Expr::now(wire).equals(value), text));
}
