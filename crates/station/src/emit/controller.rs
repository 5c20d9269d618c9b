//! Emits a single controller as C99 for use outside stations: a header and a source file without
//! dependencies, allocation or recursion.
//!
//! A machine becomes tables of guards; functions become a table of decisions that a short loop
//! evaluates. Even large tables compile quickly, and parts that are shared are stored only once.

use super::Names;
use super::assumed::{Assumptions, Checks, StoredStep};
use super::decisions::{self, Tables};
use super::expression::literal;
use super::text::{comment, wrap};
use super::words::{is_header, word};
use crate::is_windows_device;
use crate::template::render;
use linewright_core::gr1::{Domain, Specification, Timing};
use linewright_solver::mealy::functions::Functions;
use linewright_solver::mealy::{Machine, Port};
use linewright_solver::symbolic::Bit;
use serde::Serialize;
use std::collections::HashMap;

/// The header and the source file of a controller or a monitor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Files {
    /// File name without extension; also the prefix of all declarations.
    pub name: String,
    /// The header.
    pub header: String,
    /// The source.
    pub source: String,
}

/// What a controller was made from, for the comments of its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// What it controls: `the contract Turn`.
    pub title: String,
    /// How to use it, beside what holds for all controllers; one paragraph per entry.
    pub usage: Vec<String>,
}

impl Origin {
    /// Returns the origin of the controller of a contract.
    pub fn contract(name: &str) -> Self {
        Self {
            title: format!("the contract {name}"),
            usage: Vec::new(),
        }
    }
}

/// Emits a controller of this specification with explicit states.
pub fn of_machine(machine: &Machine, specification: &Specification) -> Files {
    of_machine_from(machine, specification, &Origin::contract(&machine.name))
}

/// Like [`of_machine`], for a controller of any origin.
pub fn of_machine_from(machine: &Machine, specification: &Specification, origin: &Origin) -> Files {
    let text = Text::new(
        &machine.name,
        origin.clone(),
        machine.timing,
        &machine.inputs,
        &machine.outputs,
    );
    let assumptions = Assumptions::new(specification);
    let header = text.header(None, assumptions.kept());
    Files {
        source: text.machine(machine, &assumptions),
        name: text.name,
        header,
    }
}

/// Emits a controller as functions.
pub fn of_functions(functions: &Functions) -> Files {
    let text = Text::new(
        &functions.name,
        Origin::contract(&functions.name),
        functions.timing,
        &functions.inputs,
        &functions.outputs,
    );
    let header = text.header(Some(functions.pairs().max(1)), None);
    Files {
        source: text.functions(functions),
        name: text.name,
        header,
    }
}

struct Text<'a> {
    origin: Origin,
    timing: Timing,
    name: String,
    inputs: Vec<(String, &'a Port)>,
    outputs: Vec<(String, &'a Port)>,
}

/// The fields of `controller.h`.
#[derive(Serialize)]
struct Header<'a> {
    title: String,
    name: &'a str,
    moore: bool,
    usage: Vec<String>,
    inputs: Vec<Field<'a>>,
    outputs: Vec<Field<'a>>,
    /// For a controller as functions: the number of bits that store the values of the last step.
    bits: Option<usize>,
    kept: Option<StoredStep>,
}

/// A field of a structure.
#[derive(Serialize)]
struct Field<'a> {
    kind: &'static str,
    name: &'a str,
    about: String,
}

/// The fields of `machine.c`.
#[derive(Serialize)]
struct MachineSource<'a> {
    title: String,
    name: &'a str,
    tests: Vec<Test<'a>>,
    /// For each cube, its range of tests.
    cubes: Vec<Range>,
    transitions: Vec<TransitionRow>,
    /// The range of transitions of step 0, then of each state.
    states: Vec<Range>,
    answers: Vec<String>,
    operators: Vec<String>,
    assumed_first: Option<Checks<'a>>,
    assumed: Option<Checks<'a>>,
    /// Length of the array of input values; at least 1.
    values: usize,
    inputs: Vec<Input<'a>>,
    outputs: Vec<Output<'a>>,
    /// C condition that is true if a step breaks an assumption.
    broken: Option<String>,
    /// C expressions of the values that the assumptions read in the next step.
    kept: Vec<String>,
}

/// A test whether an input lies between two values.
#[derive(Serialize)]
struct Test<'a> {
    input: usize,
    low: String,
    high: String,
    name: &'a str,
}

/// A range of rows in another table: the tests of a cube, or the transitions of a state.
#[derive(Serialize)]
struct Range {
    first: usize,
    last: usize,
}

/// A transition: its cubes, its answer, and the next state.
#[derive(Serialize)]
struct TransitionRow {
    first: usize,
    last: usize,
    answer: usize,
    to: usize,
}

/// The fields of `functions.c`.
#[derive(Serialize)]
struct FunctionsSource<'a> {
    title: String,
    name: &'a str,
    signals: Vec<SignalRange>,
    #[serde(flatten)]
    tables: Tables,
    assumed_first: Vec<Assumption>,
    assumed: Vec<Assumption>,
    reads: bool,
    writes: bool,
    /// Number of signals.
    bits: usize,
    inputs: Vec<Input<'a>>,
    outputs: Vec<Output<'a>>,
    /// Number of outputs computed in a step.
    count: usize,
    goal_count: usize,
}

/// The signals of a port.
#[derive(Serialize)]
struct SignalRange {
    first: u16,
    end: u16,
    about: String,
}

/// An assumption: an edge of the decisions that must be true.
#[derive(Serialize)]
struct Assumption {
    edge: u32,
    about: String,
}

/// An input of a step.
#[derive(Serialize)]
struct Input<'a> {
    field: &'a str,
    low: String,
    high: String,
    /// First signal of the input in this step, and the number of its bits; both 0 for a controller
    /// with explicit states.
    signal: u16,
    bits: usize,
}

/// An output of a step.
#[derive(Serialize)]
struct Output<'a> {
    field: &'a str,
    kind: &'static str,
    /// C expression of its value.
    value: String,
}

/// C type of a field.
fn integer(domain: &Domain) -> &'static str {
    let fits = |v: i64| i32::try_from(v).is_ok();
    if fits(domain.low()) && fits(domain.high()) {
        "int32_t"
    } else {
        "int64_t"
    }
}

impl<'a> Text<'a> {
    fn new(
        controller: &str,
        origin: Origin,
        timing: Timing,
        inputs: &'a [Port],
        outputs: &'a [Port],
    ) -> Self {
        let fields = |ports: &'a [Port]| {
            let mut names = Names::default();
            let named = ports.iter().map(|p| (names.unique(&word(&p.name)), p));
            named.collect::<Vec<_>>()
        };
        let mut name = word(controller);
        if is_header(&name) || is_windows_device(&name) {
            name.push('_');
        }
        Self {
            origin,
            timing,
            name,
            inputs: fields(inputs),
            outputs: fields(outputs),
        }
    }

    /// Renders the header, with the bits or values that the state stores between two steps.
    fn header(&self, bits: Option<usize>, kept: Option<StoredStep>) -> String {
        render(
            "controller/controller.h",
            Header {
                title: comment(&self.origin.title),
                name: &self.name,
                moore: self.timing == Timing::Moore,
                usage: (self.origin.usage.iter())
                    .map(|text| wrap(&comment(text), " * "))
                    .collect(),
                inputs: structure(&self.inputs),
                outputs: structure(&self.outputs),
                bits,
                kept,
            },
        )
    }

    /// The inputs, with their bits if the controller consists of functions.
    fn step_inputs(&self, bits: &[Vec<Bit>]) -> Vec<Input<'_>> {
        let inputs = self.inputs.iter().enumerate().map(|(i, (field, port))| {
            let bits = bits.get(i).map_or(&[][..], Vec::as_slice);
            Input {
                field,
                low: literal(port.domain.low()),
                high: literal(port.domain.high()),
                signal: bits.first().map_or(0, |first| first.primed().0),
                bits: bits.len(),
            }
        });
        inputs.collect()
    }

    /// The outputs with the C expressions of their values.
    fn step_outputs(&self, value: impl Fn(usize, &Port) -> String) -> Vec<Output<'_>> {
        let outputs = self
            .outputs
            .iter()
            .enumerate()
            .map(|(i, (field, port))| Output {
                field,
                kind: integer(&port.domain),
                value: value(i, port),
            });
        outputs.collect()
    }

    fn machine(&self, machine: &Machine, assumptions: &Assumptions<'_>) -> String {
        let (mut tests, mut cubes, mut transitions) = (Vec::new(), Vec::new(), Vec::new());
        let (mut states, mut answers) = (Vec::new(), Vec::new());
        let mut known: HashMap<&[i64], usize> = HashMap::new();
        let names: Vec<String> = machine.inputs.iter().map(|p| comment(&p.name)).collect();
        for list in std::iter::once(&machine.initial).chain(&machine.states) {
            states.push(Range {
                first: transitions.len(),
                last: transitions.len() + list.len(),
            });
            for transition in list {
                let first = cubes.len();
                for cube in &transition.guard.0 {
                    let begin = tests.len();
                    tests.extend(cube.0.iter().map(|test| Test {
                        input: test.input,
                        low: literal(test.low),
                        high: literal(test.high),
                        name: &names[test.input],
                    }));
                    cubes.push(Range {
                        first: begin,
                        last: tests.len(),
                    });
                }
                let fresh = known.len();
                let answer = *known.entry(&transition.output).or_insert(fresh);
                if answer == fresh {
                    let values = transition.output.iter().map(|v| literal(*v) + ", ");
                    answers.push(values.collect::<String>().trim_end().to_owned());
                }
                transitions.push(TransitionRow {
                    first,
                    last: cubes.len(),
                    answer,
                    to: transition.to,
                });
            }
        }
        let count = self.outputs.len();
        let value = |i: usize| format!("answers[{count} * taken->answer + {i}]");
        render(
            "controller/machine.c",
            MachineSource {
                title: comment(&self.origin.title),
                name: &self.name,
                tests,
                cubes,
                transitions,
                states,
                answers,
                operators: assumptions.operators(),
                assumed_first: assumptions.first(),
                assumed: assumptions.later(),
                values: self.inputs.len().max(1),
                inputs: self.step_inputs(&[]),
                outputs: self.step_outputs(|i, _| value(i)),
                broken: assumptions.broken(),
                kept: assumptions.kept_values(value),
            },
        )
    }

    fn functions(&self, functions: &Functions) -> String {
        let controls = &functions.controls;
        let ports = self
            .inputs
            .iter()
            .zip(&functions.input_bits)
            .chain(self.outputs.iter().zip(&functions.output_bits));
        let signals = ports.filter_map(|((_, port), bits)| {
            Some(SignalRange {
                first: bits.first()?.0,
                end: bits.last()?.0 + 1,
                about: comment(&port.name),
            })
        });
        let assumptions = |edges: &mut dyn Iterator<Item = u32>, names: &[String]| {
            let assumptions = edges.zip(names).map(|(edge, name)| Assumption {
                edge,
                about: comment(name),
            });
            assumptions.collect::<Vec<_>>()
        };
        let mut first = controls.assumed_first.iter().map(|(_, e)| e.0);
        let mut later = controls.assumed.iter().map(|(_, e)| e.0);
        let outputs = self.step_outputs(|i, port| {
            let (low, bits) = (literal(port.domain.low()), &functions.output_bits[i]);
            bits.first().map_or(low.clone(), |first| {
                let (first, count) = (first.primed().0, bits.len());
                format!("get(signals + {first}, {count}) + {low}")
            })
        });
        let any = |bits: &[Vec<Bit>]| bits.iter().any(|b| !b.is_empty());
        render(
            "controller/functions.c",
            FunctionsSource {
                title: comment(&self.origin.title),
                name: &self.name,
                signals: signals.collect(),
                tables: decisions::tables(controls, &|bit| bit.0.to_string()),
                assumed_first: assumptions(&mut first, &functions.names_first),
                assumed: assumptions(&mut later, &functions.names),
                reads: any(&functions.input_bits),
                writes: any(&functions.output_bits),
                bits: 2 * functions.pairs().max(1),
                inputs: self.step_inputs(&functions.input_bits),
                outputs,
                count: controls.first.len(),
                goal_count: controls.goals.len(),
            },
        )
    }
}

fn structure<'a>(ports: &'a [(String, &Port)]) -> Vec<Field<'a>> {
    let fields = ports.iter().map(|(name, port)| {
        let values = match &port.domain {
            Domain::Enum { labels, .. } => {
                let labels: Vec<String> = labels
                    .iter()
                    .enumerate()
                    .map(|(i, label)| format!("{i} {label}"))
                    .collect();
                labels.join(", ")
            }
            Domain::Bool => "0 or 1".to_owned(),
            domain @ Domain::Range { .. } => domain.describe(),
        };
        let internal = if port.internal { "internal, " } else { "" };
        Field {
            kind: integer(&port.domain),
            name,
            about: format!("{}: {internal}{}", comment(&port.name), comment(&values)),
        }
    });
    fields.collect()
}
