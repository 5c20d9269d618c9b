//! Emits a machine as a CASE over its states with one condition per transition, as a person would
//! write it.

use super::assumptions::Assumptions;
use super::interface::{Interface, Port};
use super::text::{indented, wrap_condition};
use super::{Parts, Type, Variable, Width, literal};
use linewright_core::gr1::Specification;
use linewright_solver::mealy::{Guard, Machine, Transition};
use std::fmt::Write;

/// Maximum number of tests and assignments in a CASE; a machine with more becomes tables.
const MAX_TERMS: usize = 4_000;

/// Whether a machine is written as a CASE.
pub(super) fn is_short(machine: &Machine) -> bool {
    let transitions = machine.states.iter().chain([&machine.initial]).flatten();
    let terms = transitions.map(|t| {
        let tests: usize = t.guard.0.iter().map(|c| c.0.len()).sum();
        tests + t.output.len() + 1
    });
    terms.sum::<usize>() <= MAX_TERMS
}

/// Creates the variable that holds the state.
pub(super) fn state(interface: &mut Interface<'_>, machine: &Machine) -> Variable {
    let width = Width::of(0, machine.states.len() as i64);
    let name = interface.fresh("state");
    Variable::new(
        &name,
        Type::Integer(width),
        "-1 before step 0; same numbers as in JSON and diagrams",
    )
    .with_initial_value("-1")
}

/// Emits state and step.
pub(super) fn parts(
    interface: &mut Interface<'_>,
    machine: &Machine,
    specification: &Specification,
) -> Parts {
    let state = state(interface, machine);
    let assumptions = Assumptions::new(interface, specification, &state.name);
    let no_step = format!(
        "{} := {};\n",
        interface.own().refused,
        assumptions.no_step()
    );
    let mut step = format!("CASE {} OF\n", state.name);
    let places = std::iter::once(&machine.initial).chain(&machine.states);
    for (place, transitions) in places.enumerate() {
        let place = place as i64 - 1;
        let before = if place < 0 {
            " (* before step 0 *)"
        } else {
            ""
        };
        let _ = writeln!(step, "    {place}:{before}");
        let text = choice(interface, machine, transitions, &state.name, &no_step);
        step.push_str(&indented(&text, 2));
    }
    step.push_str("END_CASE;\n");
    let step = assumptions.around(interface.own(), &step);
    let reset = format!("{} := -1;\n{}", state.name, assumptions.reset());
    let mut locals = vec![state];
    locals.extend(assumptions.into_locals());
    Parts {
        locals,
        constants: Vec::new(),
        temporaries: Vec::new(),
        reset,
        step,
    }
}

/// The statements of one state; `no_step` is executed if no transition's guard holds.
fn choice(
    interface: &Interface<'_>,
    machine: &Machine,
    transitions: &[Transition],
    state: &str,
    no_step: &str,
) -> String {
    let mut out = String::new();
    for transition in transitions {
        let mut done = String::new();
        for (port, value) in interface.outputs.iter().zip(&transition.output) {
            let _ = writeln!(done, "{} := {};", port.name, port.value(*value));
        }
        let _ = writeln!(done, "{state} := {};", transition.to);
        let Some(guard) = condition(&interface.inputs, machine, &transition.guard) else {
            // The guards of a state are disjoint, so a guard that always holds is the only one.
            return done;
        };
        let word = if out.is_empty() { "IF" } else { "ELSIF" };
        let line = wrap_condition(&format!("{word} {guard} THEN"), "        ");
        let _ = write!(out, "{line}\n{}", indented(&done, 1));
    }
    if out.is_empty() {
        return no_step.to_owned();
    }
    let _ = write!(out, "ELSE\n{}END_IF;\n", indented(no_step, 1));
    out
}

/// A guard as a condition; `None` if it always holds.
fn condition(inputs: &[Port<'_>], machine: &Machine, guard: &Guard) -> Option<String> {
    let mut cubes = Vec::new();
    for cube in machine.guard_values(guard) {
        let mut tests = Vec::new();
        for (port, values) in inputs.iter().zip(&cube) {
            tests.extend(port_tests(port, values));
        }
        if tests.is_empty() {
            return None;
        }
        cubes.push(tests);
    }
    Some(match cubes.as_slice() {
        [] => "FALSE".to_owned(),
        [only] => only.join(" AND "),
        several => {
            let several: Vec<String> = several.iter().map(|c| grouped(c, " AND ")).collect();
            several.join(" OR ")
        }
    })
}

/// Joins operands with an operator; several operands are put in parentheses.
fn grouped(operands: &[String], operator: &str) -> String {
    match operands {
        [only] => only.clone(),
        _ => format!("({})", operands.join(operator)),
    }
}

/// Returns the tests that all hold exactly if a port has one of these values; empty if every value
/// is allowed.
fn port_tests(port: &Port<'_>, values: &[(i64, i64)]) -> Vec<String> {
    let name = &port.name;
    let (low, high) = (port.of.domain.low(), port.of.domain.high());
    if values == [(low, high)] {
        return Vec::new();
    }
    let is = |value: i64| format!("({name} = {})", port.value(value));
    let is_not = |value: i64| format!("({name} <> {})", port.value(value));
    let within = |value: i64| values.iter().any(|(a, b)| *a <= value && value <= *b);
    match &port.kind {
        Type::Bool if within(1) => vec![name.clone()],
        Type::Bool => vec![format!("NOT {name}")],
        Type::Enumeration(_) => {
            let (inside, outside): (Vec<i64>, Vec<i64>) = (low..=high).partition(|v| within(*v));
            if inside.len() <= outside.len() {
                let tests: Vec<String> = inside.into_iter().map(is).collect();
                vec![grouped(&tests, " OR ")]
            } else {
                outside.into_iter().map(is_not).collect()
            }
        }
        _ => {
            // Excluding a single value is easier to read than listing the allowed ones.
            let count: i64 = values.iter().map(|(a, b)| b - a + 1).sum();
            if count == high - low && high - low > 1 {
                let hole = values
                    .first()
                    .map_or(low, |(a, b)| if *a > low { low } else { b + 1 });
                return vec![is_not(hole)];
            }
            let bounds = |(a, b): &(i64, i64)| -> Vec<String> {
                if a == b {
                    return vec![is(*a)];
                }
                let mut tests = Vec::new();
                if *a > low {
                    tests.push(format!("({name} >= {})", literal(*a)));
                }
                if *b < high {
                    tests.push(format!("({name} <= {})", literal(*b)));
                }
                tests
            };
            match values {
                [only] => bounds(only),
                several => {
                    let several = several.iter().map(|p| grouped(&bounds(p), " AND "));
                    vec![grouped(&several.collect::<Vec<_>>(), " OR ")]
                }
            }
        }
    }
}
