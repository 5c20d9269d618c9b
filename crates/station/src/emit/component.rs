//! Emits one component: the decisions or functions of its controller as tables; its formulas,
//! bindings, time and power as C functions.

use super::assumed::Check;
use super::decisions::{self, WalkTables};
use super::expression;
use super::machine::Function;
use super::splits::{Decisions, Target};
use super::text::{comment, identifier, string, wrap};
use super::walks::{Place, Walks};
use super::{Names, rows};
use crate::messages::{self, Party};
use crate::template::render;
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Domain, Expr, Formula, Side, Time, Timing, VarId, show_value};
use linewright_language::contract::machine::{ActionTime, Component, Machine, RealExpr, Role};
use linewright_solver::mealy;
use linewright_solver::mealy::functions::Functions;
use linewright_solver::symbolic::Bit;
use serde::Serialize;
use std::collections::BTreeMap;

/// Data for emitting one component.
pub(super) struct Emitter<'a> {
    pub machine: &'a Machine,
    pub component: &'a Component,
    pub controller: &'a mealy::Controller,
    /// Prefix of the component's functions and tables: `c1_turn`.
    pub prefix: String,
    /// Names of the component's variables.
    pub variables: Vec<String>,
    /// Names of the machine's wires.
    pub wires: &'a [String],
    /// Index of the component's first variable among the variables of all components.
    pub first_value: usize,
    /// Index of the component's first justice assumption among those of all components.
    pub first_justice: usize,
}

/// Location of a signal in the runtime's values: a signal is one bit of a value.
struct Signal {
    value: usize,
    /// Array that contains the value: `LW_PREVIOUS`, `LW_CURRENT` or `LW_SHIFTED` of
    /// `ffi/machine.h`.
    from: usize,
    shift: usize,
}

/// `LW_PUT` of `ffi/machine.h`.
const PUT: usize = 3;

impl Signal {
    fn fields(&self) -> String {
        format!("{}, {}, {}", self.value, self.from, self.shift)
    }
}

/// Returns the rows of the table of walks and, for each list of walks, the rows at which its walks
/// begin. A place that writes bits of several variables takes several rows.
fn walk_rows(walks: &Walks, signal: impl Fn(Bit) -> Signal) -> (Vec<String>, Vec<Vec<usize>>) {
    let put = |bits: &[Bit]| {
        let mut values: BTreeMap<(usize, usize), u32> = BTreeMap::new();
        for bit in bits {
            let at = signal(*bit);
            *values.entry((at.from, at.value)).or_default() |= 1 << at.shift;
        }
        values
    };
    let mut places = vec![0];
    let mut count = 0;
    for place in &walks.places {
        places.push(count + 1);
        count += match place {
            Place::Test { .. } => 1,
            Place::Write { bits, .. } => put(bits).len(),
        };
    }
    let mut rows = Vec::new();
    for place in &walks.places {
        match place {
            Place::Test { bit, high, low } => {
                let (high, low) = (places[*high], places[*low]);
                let signal = signal(*bit).fields();
                rows.push(format!("    {{ {high}, {low}, {signal} }},"));
            }
            Place::Write { bits, next: after } => {
                let values = put(bits);
                let last = rows.len() + values.len();
                for ((from, value), mask) in values {
                    let next = rows.len() + 2;
                    let next = if next > last { places[*after] } else { next };
                    let from = PUT + from;
                    rows.push(format!("    {{ {next}, {mask}, {value}, {from}, 0 }},"));
                }
            }
        }
    }
    let starts = walks
        .starts
        .iter()
        .map(|list| list.iter().map(|place| places[*place]).collect());
    (rows, starts.collect())
}

/// The names of a component's variables as enumeration constants.
pub(super) fn variable_names(component: &Component, index: usize) -> Vec<String> {
    let mut names = Names::default();
    let begin = format!("v{index}_{}", identifier(&component.name));
    component
        .specification
        .variables
        .iter()
        .map(|v| names.unique(&format!("{begin}_{}", identifier(&v.name))))
        .collect()
}

/// The fields of `component.c`.
#[derive(Serialize)]
struct Definitions<'a> {
    title: String,
    dashes: String,
    prefix: &'a str,
    variables: Vec<Variable<'a>>,
    inputs: Vec<Input<'a>>,
    outputs: Vec<&'a str>,
    decisions: Option<DecisionTables<'a>>,
    functions: Option<FunctionTables<'a>>,
    unused_by_bindings: Vec<&'static str>,
    bindings: Vec<String>,
    sides: Vec<FormulaChecks>,
    justice: Option<Justice>,
    action: Option<Action>,
}

#[derive(Serialize)]
struct Variable<'a> {
    name: &'a str,
    about: String,
}

/// An input whose binding could have a value outside the input's domain.
#[derive(Serialize)]
struct Input<'a> {
    name: String,
    domain: String,
    variable: &'a str,
    low: String,
    high: String,
}

/// The tables of a controller with explicit states.
#[derive(Serialize)]
struct DecisionTables<'a> {
    splits: Vec<Split<'a>>,
    leaves: Vec<Leaf>,
    answers: Vec<Answer>,
    roots: Vec<String>,
    moore: bool,
    first_answers: Vec<i64>,
}

/// A comparison of a variable with a bound, and the targets of both outcomes.
#[derive(Serialize)]
struct Split<'a> {
    variable: &'a str,
    at_most: String,
    above: String,
    bound: String,
    /// The condition as a comment.
    about: String,
}

/// Index of an answer, and the next place; place -1 if there is no transition.
#[derive(Serialize)]
struct Leaf {
    answer: usize,
    place: i64,
}

/// Values of all outputs, as C literals and as a comment.
#[derive(Serialize)]
struct Answer {
    values: String,
    about: String,
}

/// The tables of a controller as functions.
#[derive(Serialize)]
struct FunctionTables<'a> {
    signals: usize,
    walk: String,
    #[serde(flatten)]
    tables: WalkTables,
    shifted: Vec<Shifted<'a>>,
    shifted_count: usize,
    goal_count: usize,
}

/// A variable whose domain does not begin at 0.
#[derive(Serialize)]
struct Shifted<'a> {
    variable: &'a str,
    output: u8,
    lowest: String,
}

/// Formulas of one kind, with the messages for violations.
#[derive(Serialize)]
struct FormulaChecks {
    title: String,
    name: String,
    rules: Vec<Rule>,
    unused: Vec<&'static str>,
    checks: Vec<Check>,
}

/// A rule's name and a message, as C strings.
#[derive(Serialize)]
pub(super) struct Rule {
    name: String,
    message: String,
}

#[derive(Serialize)]
struct Justice {
    unused: Vec<&'static str>,
    checks: Vec<Check>,
}

/// Functions for an action: whether it is active, its time, and its power.
#[derive(Serialize)]
struct Action {
    active: Function,
    time_of: &'static str,
    seconds: Function,
    watts: Function,
}

/// A component's entry in the table of components.
#[derive(Serialize)]
pub(super) struct Entry {
    name: String,
    prefix: String,
    moore: u8,
    watches: u8,
    first_value: usize,
    inputs: usize,
    outputs: usize,
    controller: String,
    assumes: SideEntry,
    guarantees: SideEntry,
    justice: String,
    first_justice: usize,
    active: String,
    time: &'static str,
    seconds: String,
    watts: String,
}

/// Initializers for one side of a contract: the check function and the rules of each kind of
/// formula.
#[derive(Serialize)]
struct SideEntry {
    initial: String,
    invariants: String,
    safety: String,
}

impl Emitter<'_> {
    /// Returns all definitions of the component.
    pub fn definitions(&self) -> String {
        let k = self.component;
        let specification = &k.specification;
        let title = format!("{}: {}", comment(&k.name), comment(&k.contract));
        let variables = self
            .variables
            .iter()
            .zip(&specification.variables)
            .map(|(name, v)| Variable {
                name,
                about: comment(&v.describe()),
            });
        let outputs = specification.outputs();
        let (decisions, functions) = match self.controller {
            mealy::Controller::Machine(machine) => (Some(self.decisions(machine)), None),
            mealy::Controller::Functions(functions) => (None, Some(self.functions(functions))),
        };
        let bindings = self.bindings();
        let party = Party::of_assumptions(k);
        let mut sides = self.side(&specification.assumptions, party);
        sides.extend(self.side(&specification.guarantees, Party::Machine));
        render(
            "station/component.c",
            Definitions {
                dashes: "-".repeat(99_usize.saturating_sub(title.chars().count())),
                title,
                prefix: &self.prefix,
                variables: variables.collect(),
                inputs: self.inputs(),
                outputs: outputs.map(|id| self.variable(id)).collect(),
                decisions,
                functions,
                unused_by_bindings: unused(
                    bindings.iter().map(String::as_str),
                    &["values", "current"],
                ),
                bindings,
                sides,
                justice: self.justice(),
                action: self.action(),
            },
        )
    }

    /// Returns the component's entry in the table of components.
    pub fn entry(&self) -> Entry {
        let k = self.component;
        let specification = &k.specification;
        let p = &self.prefix;
        let side_entry = |side: &Side, word: &str| {
            let list = |formulas: &[Formula], kind: &str| {
                if formulas.is_empty() {
                    "{ NULL, NULL }".to_owned()
                } else {
                    format!("{{ {p}_{word}_{kind}, {p}_{word}_{kind}_rules }}")
                }
            };
            SideEntry {
                initial: list(&side.initial, "initial"),
                invariants: list(&side.invariants, "invariants"),
                safety: list(&side.safety, "safety"),
            }
        };
        let some = |exists: bool, name: &str| {
            if exists {
                format!("{p}_{name}")
            } else {
                "NULL".to_owned()
            }
        };
        let action = k.active.is_some();
        let moore = specification.timing == Timing::Moore;
        let controller = match self.controller {
            mealy::Controller::Machine(_) => {
                let first = some(moore, "first_answer");
                format!("{p}_root, {p}_splits, {p}_leaves, {p}_answers, {first}, NULL")
            }
            mealy::Controller::Functions(_) => {
                format!("NULL, NULL, NULL, NULL, NULL, &{p}_functions")
            }
        };
        Entry {
            name: string(&k.name),
            prefix: p.clone(),
            moore: u8::from(moore),
            watches: u8::from(k.role == Role::Watch),
            first_value: self.first_value,
            inputs: self.open_inputs().len(),
            outputs: specification.outputs().count(),
            controller,
            assumes: side_entry(&specification.assumptions, "assumes"),
            guarantees: side_entry(&specification.guarantees, "guarantees"),
            justice: some(!specification.assumptions.justice.is_empty(), "justice"),
            first_justice: self.first_justice,
            active: some(action, "active"),
            time: match k.time {
                Some(ActionTime::PerExecution(_)) => "LW_TIME_EXECUTION",
                _ => "LW_TIME_STEP",
            },
            seconds: some(action, "seconds"),
            watts: some(action, "watts"),
        }
    }

    /// Returns the rules of the component's justice assumptions for the table of messages about the
    /// step limit.
    pub fn justice_rules(&self) -> Vec<Rule> {
        let justice = &self.component.specification.assumptions.justice;
        justice
            .iter()
            .map(|f| self.rule(f, &messages::describe_unmet_justice(self.component, f)))
            .collect()
    }

    fn rule(&self, formula: &Formula, message: &str) -> Rule {
        Rule {
            name: string(&messages::rule_name(self.component, formula)),
            message: string(message),
        }
    }

    /// Name of a variable.
    fn variable(&self, id: VarId) -> &str {
        &self.variables[id.index()]
    }

    /// Inputs whose bindings could have a value outside the input's domain. The other inputs need
    /// no check in a step.
    fn open_inputs(&self) -> Vec<VarId> {
        let domain = |v: VarId| Interval::of(self.machine.wire_domain(v.index()));
        let specification = &self.component.specification;
        let inputs = specification.inputs().zip(&self.component.bindings);
        inputs
            .filter(|(id, binding)| {
                let allowed = Interval::of(&specification.variable(*id).domain);
                !interval(binding, &domain)
                    .is_ok_and(|i| allowed.contains(i.low) && allowed.contains(i.high))
            })
            .map(|(id, _)| id)
            .collect()
    }

    fn inputs(&self) -> Vec<Input<'_>> {
        let inputs = self.open_inputs().into_iter().map(|id| {
            let v = self.component.specification.variable(id);
            Input {
                name: string(&v.name),
                domain: string(&v.describe()),
                variable: self.variable(id),
                low: expression::literal(v.domain.low()),
                high: expression::literal(v.domain.high()),
            }
        });
        inputs.collect()
    }

    /// Converts the transitions of a machine to tables of decisions.
    fn decisions(&self, controller: &mealy::Machine) -> DecisionTables<'_> {
        let decisions = Decisions::of(controller);
        let inputs: Vec<VarId> = self.component.specification.inputs().collect();
        let number = |target: &Target| match target {
            Target::Split(n) => n.to_string(),
            Target::Leaf(n) => format!("-{}", n + 1),
        };
        let splits = decisions.splits.iter().map(|split| {
            let port = &controller.inputs[split.input];
            let condition = if port.domain == Domain::Bool {
                format!("!{}", port.name)
            } else {
                let bound = show_value(&port.domain, split.bound, &port.unit);
                format!("{} <= {bound}", port.name)
            };
            Split {
                variable: self.variable(inputs[split.input]),
                at_most: number(&split.at_most),
                above: number(&split.above),
                bound: expression::literal(split.bound),
                about: comment(&condition),
            }
        });
        let leaves = decisions.leaves.iter().map(|leaf| {
            let (answer, place) = leaf.map_or((0, -1), |(answer, to)| (answer, to as i64));
            Leaf { answer, place }
        });
        let ports = &controller.outputs;
        let answers = decisions
            .answers
            .iter()
            .filter(|a| !a.is_empty())
            .map(|values| {
                let numbers = values.iter().map(|v| expression::literal(*v) + ",");
                let words: Vec<String> = ports
                    .iter()
                    .zip(values)
                    .map(|(port, v)| {
                        format!(
                            "{} = {}",
                            port.name,
                            show_value(&port.domain, *v, &port.unit)
                        )
                    })
                    .collect();
                let numbers: Vec<String> = numbers.collect();
                Answer {
                    values: numbers.join(" "),
                    about: comment(&words.join(", ")),
                }
            });
        let firsts = decisions
            .first_answers
            .iter()
            .map(|answer| answer.map_or(-1, |a| a as i64));
        DecisionTables {
            splits: splits.collect(),
            leaves: leaves.collect(),
            answers: answers.collect(),
            roots: decisions.places.iter().map(number).collect(),
            moore: controller.timing == Timing::Moore,
            first_answers: firsts.collect(),
        }
    }

    /// Converts functions to tables: decisions, and the locations of the bits that the decisions
    /// read.
    fn functions(&self, functions: &Functions) -> FunctionTables<'_> {
        let specification = &self.component.specification;
        let mut shifted = Vec::new();
        // For each pair of bits: the index of the variable, the variable's index among the shifted
        // variables, and the position of the bit in the value.
        let mut places = vec![(0, None, 0); functions.pairs()];
        let inputs = specification.inputs().zip(&functions.input_bits);
        let outputs = specification.outputs().zip(&functions.output_bits);
        for (is_output, (id, bits)) in inputs.map(|i| (false, i)).chain(outputs.map(|o| (true, o)))
        {
            let variable = specification.variable(id);
            let low = variable.domain.low();
            let moved = (low != 0).then(|| {
                shifted.push(Shifted {
                    variable: self.variable(id),
                    output: u8::from(is_output),
                    lowest: expression::literal(low),
                });
                shifted.len() - 1
            });
            for (shift, bit) in bits.iter().rev().enumerate() {
                places[usize::from(bit.pair())] = (id.index(), moved, shift);
            }
        }
        let signal = |bit: Bit| {
            let (value, moved, shift) = places[usize::from(bit.pair())];
            let time = usize::from(bit != Bit(2 * bit.pair()));
            match moved {
                Some(number) => Signal {
                    value: 2 * number + time,
                    from: 2,
                    shift,
                },
                None => Signal {
                    value,
                    from: time,
                    shift,
                },
            }
        };
        let controls = &functions.controls;
        let (walk, starts) = walk_rows(&Walks::of(controls), signal);
        FunctionTables {
            signals: 2 * functions.pairs(),
            walk: rows(&walk, "{ 0 }"),
            tables: decisions::walk_tables(controls, &|bit| signal(bit).fields(), &starts),
            shifted_count: shifted.len(),
            shifted,
            goal_count: controls.goals.len(),
        }
    }

    /// Statements that compute the component's inputs.
    fn bindings(&self) -> Vec<String> {
        let wires = |v: VarId, _| format!("values[{}]", self.wires[v.index()]);
        let specification = &self.component.specification;
        let inputs = specification.inputs().zip(&self.component.bindings);
        let statements = inputs.map(|(id, binding)| {
            let value = expression::integer(binding, &wires);
            let statement = format!("current[{}] = {value};", self.variable(id));
            wrap(&statement, "        ")
        });
        statements.collect()
    }

    fn side(&self, side: &Side, party: Party) -> Vec<FormulaChecks> {
        let (word, title) = match party {
            Party::Plant => ("assumes", "Assumptions"),
            Party::Caller => ("assumes", "Orders"),
            Party::Machine => ("guarantees", "Guarantees"),
        };
        let lists = [
            (&side.initial, "initial", "about step 0"),
            (&side.invariants, "invariants", "about every step"),
            (&side.safety, "safety", "about every step and the next"),
        ];
        let lists = lists.into_iter().filter(|(list, ..)| !list.is_empty());
        let rules = lists.map(|(formulas, kind, when)| {
            let rules = formulas
                .iter()
                .map(|f| self.rule(f, &messages::describe_violation(self.component, f, party)));
            let checks = formulas.iter().map(|f| Check {
                about: cite(f),
                holds: self.formula(f, kind == "safety"),
            });
            let checks: Vec<Check> = checks.collect();
            FormulaChecks {
                title: format!("{title} {when}"),
                name: format!("{word}_{kind}"),
                rules: rules.collect(),
                unused: unused(
                    checks.iter().map(|c| c.holds.as_str()),
                    &["previous", "current"],
                ),
                checks,
            }
        });
        rules.collect()
    }

    /// C condition of a formula about the previous and the current step, or about the current step
    /// only.
    fn formula(&self, formula: &Formula, two_steps: bool) -> String {
        let text = if two_steps {
            expression::truth(&formula.expr, &|v: VarId, t| match t {
                Time::Now => format!("previous[{}]", self.variables[v.index()]),
                Time::Next => format!("current[{}]", self.variables[v.index()]),
            })
        } else {
            self.current(&formula.expr)
        };
        wrap(&text, "          ")
    }

    fn current(&self, expr: &Expr) -> String {
        expression::truth(expr, &|v: VarId, _| {
            format!("current[{}]", self.variables[v.index()])
        })
    }

    fn justice(&self) -> Option<Justice> {
        let justice = &self.component.specification.assumptions.justice;
        let checks = justice.iter().map(|formula| {
            let two_steps = formula.expr.mentions_next();
            let holds = self.formula(formula, two_steps);
            Check {
                about: cite(formula),
                holds: if two_steps {
                    format!("earlier && ({holds})")
                } else {
                    holds
                },
            }
        });
        let checks: Vec<Check> = checks.collect();
        let conditions = checks.iter().map(|c| c.holds.as_str());
        let mut unused = unused(conditions, &["previous", "current"]);
        if !justice.iter().any(|f| f.expr.mentions_next()) {
            unused.push("earlier");
        }
        (!checks.is_empty()).then_some(Justice { unused, checks })
    }

    fn action(&self) -> Option<Action> {
        let active = self.component.active.as_ref()?;
        let wires = |v: VarId, _| format!("values[{}]", self.wires[v.index()]);
        let step_seconds = RealExpr::Number(self.machine.step_seconds);
        let (seconds, time_of) = match &self.component.time {
            None => (&step_seconds, "a step"),
            Some(ActionTime::PerStep(expr)) => (expr, "a step"),
            Some(ActionTime::PerExecution(expr)) => (expr, "an execution"),
        };
        Some(Action {
            active: Function::condition(&expression::truth(active, &wires)),
            time_of,
            seconds: Function::real(seconds, self.wires),
            watts: Function::real(&self.component.watts, self.wires),
        })
    }
}

/// Cites a formula in a comment: `gripped: command = turn -> grip`.
pub(super) fn cite(formula: &Formula) -> String {
    let requirement = formula
        .requirement
        .as_ref()
        .map(|r| format!(" ({r})"))
        .unwrap_or_default();
    comment(&format!("{}{requirement}: {}", formula.name, formula.text))
}

/// Returns the array parameters that no piece of a function's body reads. A compiler would warn
/// about them.
pub(super) fn unused<'a>(
    code: impl IntoIterator<Item = &'a str>,
    parameters: &[&'static str],
) -> Vec<&'static str> {
    let mut unused = parameters.to_vec();
    for piece in code {
        unused.retain(|name| !piece.contains(&format!("{name}[")));
    }
    unused
}
