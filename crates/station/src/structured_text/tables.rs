//! Emits a machine as tables, for machines with many states and transitions.
//!
//! A state has transitions, a transition has cubes, and a cube has tests. The cubes of a
//! transition, for example, are the rows from the first cube of this transition up to the first
//! cube of the following transition. A table of distinct answers holds the output values of
//! transitions.

use super::assumptions::Assumptions;
use super::interface::Interface;
use super::text::indented;
use super::{Initial, Parts, Type, Variable, Width, codes, literal, machine};
use crate::template::render;
use linewright_core::gr1::Specification;
use linewright_solver::mealy::Machine;
use serde::Serialize;
use std::collections::BTreeMap;

/// The fields of `tables.st`.
#[derive(Serialize)]
struct TableStep<'a> {
    /// Statements that store the inputs in the table of values.
    inputs: Vec<String>,
    taken: &'a str,
    row: &'a str,
    cube: &'a str,
    test: &'a str,
    holds: &'a str,
    number: &'a str,
    values: &'a str,
    first_transition: String,
    end_of_transitions: String,
    first_cube: String,
    end_of_cubes: String,
    first_test: String,
    end_of_tests: String,
    test_input: String,
    test_low: String,
    test_high: String,
    refused: &'a str,
    no_step: &'a str,
    /// Index of the transition's first output value.
    answer: String,
    /// Statements that set the outputs from the output values of the transition.
    outputs: Vec<String>,
    state: &'a str,
    next_state: String,
}

/// A table under construction.
#[derive(Default)]
struct Table(Vec<i64>);

impl Table {
    fn variable(&self, interface: &mut Interface<'_>, name: &str, about: &str) -> Variable {
        table(interface, name, self.0.clone(), 0, about)
    }
}

/// Declares a constant array of the narrowest type. It has at least one element, because the
/// standard has no empty arrays.
pub(super) fn table(
    interface: &mut Interface<'_>,
    name: &str,
    values: Vec<i64>,
    first: i64,
    about: &str,
) -> Variable {
    named_table(&interface.fresh(name), values, first, about)
}

/// Like `table`, with a name that is already unique.
pub(crate) fn named_table(name: &str, mut values: Vec<i64>, first: i64, about: &str) -> Variable {
    if values.is_empty() {
        values.push(0);
    }
    let bounds = values.iter().fold((0, 0), |(low, high): (i64, i64), v| {
        (low.min(*v), high.max(*v))
    });
    let of = Type::Integer(Width::of(bounds.0, bounds.1));
    let last = first + values.len() as i64 - 1;
    Variable {
        initial: Initial::Values(values.into_iter().map(literal).collect()),
        ..Variable::new(name, Type::Array(first, last, Box::new(of)), about)
    }
}

/// Width of a table's elements.
pub(crate) fn element(table: &Variable) -> Width {
    match &table.kind {
        Type::Array(_, _, of) => match **of {
            Type::Integer(width) => width,
            _ => Width::Lint,
        },
        _ => Width::Lint,
    }
}

/// Emits tables, state and step.
pub(super) fn parts(
    interface: &mut Interface<'_>,
    machine: &Machine,
    specification: &Specification,
) -> Parts {
    let state = machine::state(interface, machine);
    let assumptions = Assumptions::new(interface, specification, &state.name);
    let mut answers: BTreeMap<&[i64], usize> = BTreeMap::new();
    let mut rows: Vec<i64> = Vec::new();
    let [mut inputs, mut lows, mut highs] = [(); 3].map(|()| Table::default());
    let [mut cubes, mut firsts, mut answer, mut to, mut states] =
        [(); 5].map(|()| Table::default());
    for list in std::iter::once(&machine.initial).chain(&machine.states) {
        states.0.push(to.0.len() as i64);
        for transition in list {
            firsts.0.push(cubes.0.len() as i64);
            for cube in &transition.guard.0 {
                cubes.0.push(inputs.0.len() as i64);
                for test in &cube.0 {
                    inputs.0.push(test.input as i64);
                    lows.0.push(test.low);
                    highs.0.push(test.high);
                }
            }
            let fresh = answers.len();
            let known = *answers.entry(&transition.output).or_insert(fresh);
            if known == fresh {
                rows.extend(&transition.output);
            }
            answer.0.push((known * transition.output.len()) as i64);
            to.0.push(transition.to as i64);
        }
    }
    cubes.0.push(inputs.0.len() as i64);
    firsts.0.push(cubes.0.len() as i64 - 1);
    states.0.push(to.0.len() as i64);

    let constants = [
        states.variable(
            interface,
            "state_first",
            "first transition of step 0, then of every state",
        ),
        firsts.variable(
            interface,
            "transition_first",
            "first cube of every transition",
        ),
        answer.variable(
            interface,
            "transition_answer",
            "index of the transition's first output value",
        ),
        to.variable(interface, "transition_to", "next state"),
        cubes.variable(interface, "cube_first", "first test of every cube"),
        inputs.variable(interface, "test_input", "index of the tested input"),
        lows.variable(interface, "test_low", "lowest value of the input"),
        highs.variable(interface, "test_high", "highest value of the input"),
        table(
            interface,
            "answers",
            rows,
            0,
            "values of the outputs, in order",
        ),
    ];
    let [s, t, a, g, c, i, l, h, o] = &constants;
    let index = constants[..6]
        .iter()
        .map(element)
        .max()
        .unwrap_or(Width::Int);
    let (from, value) = (element(l).max(element(h)), codes::width(&interface.inputs));
    let value = value.max(from);
    let mut variable =
        |name: &str, width: Width| Variable::new(&interface.fresh(name), Type::Integer(width), "");
    let (at, cube, test) = (
        variable("row", index),
        variable("cube", index),
        variable("test", index),
    );
    let taken = variable("taken", index);
    let number = variable("number", value);
    let holds = Variable::new(&interface.fresh("holds"), Type::Bool, "");
    let last = (interface.inputs.len() as i64 - 1).max(0);
    let values = Variable::new(
        &interface.fresh("values"),
        Type::Array(0, last, Box::new(Type::Integer(value))),
        "inputs as numbers",
    );

    let input_values = interface.inputs.iter().enumerate().map(|(place, port)| {
        let target = format!("{}[{place}]", values.name);
        codes::read(port, &target, value).trim_end().to_owned()
    });
    let outputs = interface.outputs.iter().enumerate().map(|(place, port)| {
        let source = match place {
            0 => format!("{}[{}]", o.name, at.name),
            _ => format!("{}[{} + {place}]", o.name, at.name),
        };
        let statements = codes::write(port, &source, element(o));
        indented(&statements, 1).trim_end().to_owned()
    });
    let Type::Integer(width) = state.kind else {
        unreachable!("a state is a number")
    };
    let own = interface.own();
    // All indices have the same width, and so do all values, so the loops need few conversions.
    let get = |table: &Variable, place: &str, width: Width| {
        element(table).convert(width, &format!("{}[{place}]", table.name))
    };
    let offset = |variable: &Variable, places: u8| format!("{} + {places}", variable.name);
    let step = render(
        "structured_text/tables.st",
        TableStep {
            inputs: input_values.collect(),
            taken: &taken.name,
            row: &at.name,
            cube: &cube.name,
            test: &test.name,
            holds: &holds.name,
            number: &number.name,
            values: &values.name,
            first_transition: get(s, &offset(&state, 1), index),
            end_of_transitions: get(s, &offset(&state, 2), index),
            first_cube: get(t, &at.name, index),
            end_of_cubes: get(t, &offset(&at, 1), index),
            first_test: get(c, &cube.name, index),
            end_of_tests: get(c, &offset(&cube, 1), index),
            test_input: get(i, &test.name, index),
            test_low: get(l, &test.name, value),
            test_high: get(h, &test.name, value),
            refused: &own.refused,
            no_step: assumptions.no_step(),
            answer: get(a, &taken.name, index),
            outputs: outputs.collect(),
            state: &state.name,
            next_state: get(g, &taken.name, width),
        },
    );
    let step = assumptions.around(own, &step);
    let reset = format!("{} := -1;\n{}", state.name, assumptions.reset());
    let mut locals = vec![state];
    locals.extend(assumptions.into_locals());
    Parts {
        locals,
        constants: constants.into(),
        temporaries: vec![values, at, cube, test, taken, number, holds],
        reset,
        step,
    }
}
