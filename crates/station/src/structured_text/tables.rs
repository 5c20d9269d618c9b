//! A machine as tables: for those of many states and transitions.
//!
//! A state has transitions, a transition has cubes, a cube has tests, each from its own first row up to the first row of the next
//! one. What a transition sets stands in a table of answers, each once.

use super::assumptions::Assumptions;
use super::interface::Interface;
use super::text::indented;
use super::{Initial, Parts, Type, Variable, Width, codes, literal, machine};
use linewright_core::gr1::Specification;
use linewright_solver::mealy::Machine;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A table in the making.
#[derive(Default)]
struct Table(Vec<i64>);

impl Table {
    fn variable(&self, interface: &mut Interface<'_>, wish: &str, about: &str) -> Variable {
        table(interface, wish, self.0.clone(), 0, about)
    }
}

/// A constant array, in the narrowest type. It has at least one element: the standard has no empty arrays.
pub(super) fn table(
    interface: &mut Interface<'_>,
    wish: &str,
    values: Vec<i64>,
    first: i64,
    about: &str,
) -> Variable {
    named_table(&interface.fresh(wish), values, first, about)
}

/// The same, with a name.
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

/// The width of a table's elements.
pub(crate) fn element(table: &Variable) -> Width {
    match &table.kind {
        Type::Array(_, _, of) => match **of {
            Type::Integer(width) => width,
            _ => Width::Lint,
        },
        _ => Width::Lint,
    }
}

/// Tables, state and step.
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
            "the first transition before step 0, and of every state",
        ),
        firsts.variable(
            interface,
            "transition_first",
            "the first cube of every transition",
        ),
        answer.variable(interface, "transition_answer", "where its answer begins"),
        to.variable(interface, "transition_to", "the state it leads to"),
        cubes.variable(interface, "cube_first", "the first test of every cube"),
        inputs.variable(interface, "test_input", "which input is tested"),
        lows.variable(interface, "test_low", "its lowest value"),
        highs.variable(interface, "test_high", "its highest value"),
        table(interface, "answers", rows, 0, "the outputs, in order"),
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
        |wish: &str, width: Width| Variable::new(&interface.fresh(wish), Type::Integer(width), "");
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
        "the inputs as numbers",
    );

    let mut step = String::from("(* The inputs as numbers. *)\n");
    for (place, port) in interface.inputs.iter().enumerate() {
        let target = format!("{}[{place}]", values.name);
        step.push_str(&codes::read(port, &target, value));
    }
    let own = interface.own();
    // Everything is as wide as the widest of its kind, so that nothing is converted in the loops.
    let get = |table: &Variable, index_text: &str, width: Width| {
        element(table).convert(width, &format!("{}[{index_text}]", table.name))
    };
    let (at_name, cube_name, test_name) = (&at.name, &cube.name, &test.name);
    let place = format!("{} + 1", state.name);
    let next_place = format!("{} + 2", state.name);
    let _ = write!(
        step,
        "(* The transition that one of its cubes allows. *)\n\
         {taken} := -1;\n\
         {at_name} := {};\n\
         WHILE ({taken} < 0) AND ({at_name} < {}) DO\n\
         \x20   {cube_name} := {};\n\
         \x20   WHILE ({taken} < 0) AND ({cube_name} < {}) DO\n\
         \x20       {holds} := TRUE;\n\
         \x20       FOR {test_name} := {} TO {} - 1 DO\n\
         \x20           {number} := {values}[{}];\n\
         \x20           {holds} := {holds} AND ({number} >= {}) AND ({number} <= {});\n\
         \x20       END_FOR;\n\
         \x20       IF {holds} THEN\n\
         \x20           {taken} := {at_name};\n\
         \x20       END_IF;\n\
         \x20       {cube_name} := {cube_name} + 1;\n\
         \x20   END_WHILE;\n\
         \x20   {at_name} := {at_name} + 1;\n\
         END_WHILE;\n",
        get(s, &place, index),
        get(s, &next_place, index),
        get(t, at_name, index),
        get(t, &format!("{at_name} + 1"), index),
        get(c, cube_name, index),
        get(c, &format!("{cube_name} + 1"), index),
        get(i, test_name, index),
        get(l, test_name, value),
        get(h, test_name, value),
        taken = taken.name,
        holds = holds.name,
        number = number.name,
        values = values.name,
    );
    let _ = write!(
        step,
        "IF {0} < 0 THEN\n    {1} := {2};\nELSE\n",
        taken.name,
        own.refused,
        assumptions.no_step()
    );
    let mut done = format!("{at_name} := {};\n", get(a, &taken.name, index));
    for (place, port) in interface.outputs.iter().enumerate() {
        let source = match place {
            0 => format!("{}[{at_name}]", o.name),
            _ => format!("{}[{at_name} + {place}]", o.name),
        };
        done.push_str(&codes::write(port, &source, element(o)));
    }
    let Type::Integer(width) = state.kind else {
        unreachable!("a state is a number")
    };
    let _ = writeln!(
        done,
        "{} := {};",
        state.name,
        element(g).convert(width, &format!("{}[{}]", g.name, taken.name))
    );
    let _ = writeln!(step, "{}END_IF;", indented(&done, 1));
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
