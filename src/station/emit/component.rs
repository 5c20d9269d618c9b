//! One component: its guard rows or its functions as tables, its formulas, bindings, time and power as functions.

use super::decisions::{self, Naming};
use super::expression;
use super::text::{comment, identifier, string, wrap};
use super::{Names, table};
use crate::contract::machine::{ActionTime, Component, Machine, RealExpr};
use crate::gr1::{Expr, Formula, Side, Time, Timing, VarId};
use crate::mealy;
use crate::mealy::functions::Functions;
use crate::station::messages::{self, Party};
use std::fmt::Write;

/// What the emitter knows of one component.
pub(super) struct Emitter<'a> {
    pub machine: &'a Machine,
    pub component: &'a Component,
    pub controller: &'a mealy::Controller,
    /// Begins the names of its functions and tables: `c1_turn`.
    pub prefix: String,
    /// The names of its variables.
    pub variables: Vec<String>,
    /// The names of the machine's wires.
    pub wires: &'a [String],
    /// Its first variable among those of all components.
    pub first_value: usize,
    /// Its first wire.
    pub first_wire: usize,
    /// Its first justice assumption among those of all components.
    pub first_justice: usize,
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

impl Emitter<'_> {
    /// All definitions of the component.
    pub fn definitions(&self) -> String {
        let mut out = String::new();
        let k = self.component;
        let title = format!("{}: {} ", comment(&k.name), comment(&k.contract));
        let _ = writeln!(
            out,
            "/* ---- {title}{} */\n",
            "-".repeat(100_usize.saturating_sub(title.chars().count()))
        );
        let _ = writeln!(out, "/* Its variables, in the order of the contract. */");
        let names: Vec<String> = self
            .variables
            .iter()
            .zip(&k.specification.variables)
            .map(|(name, v)| format!("    {name}, /* {} */\n", comment(&v.describe())))
            .collect();
        if !names.is_empty() {
            let _ = writeln!(out, "enum {{\n{}}};\n", names.concat());
        }
        self.ports(&mut out);
        match self.controller {
            mealy::Controller::Machine(machine) => self.rows(&mut out, machine),
            mealy::Controller::Functions(functions) => self.functions(&mut out, functions),
        }
        self.bindings(&mut out);
        self.side(&mut out, &k.specification.assumptions, Party::Plant);
        self.side(&mut out, &k.specification.guarantees, Party::Machine);
        self.justice(&mut out);
        self.action(&mut out);
        out
    }

    /// Its entry in the table of components.
    pub fn descriptor(&self) -> String {
        let k = self.component;
        let specification = &k.specification;
        let p = &self.prefix;
        let side = |side: &Side, word: &str| {
            let promise = |formulas: &[Formula], kind: &str| {
                if formulas.is_empty() {
                    "{ NULL, NULL }".to_owned()
                } else {
                    format!("{{ {p}_{word}_{kind}, {p}_{word}_{kind}_rules }}")
                }
            };
            format!(
                "{{\n            {},\n            {},\n            {} }}",
                promise(&side.initial, "initial"),
                promise(&side.invariants, "invariants"),
                promise(&side.safety, "safety")
            )
        };
        let some = |is: bool, name: &str| {
            if is {
                format!("{p}_{name}")
            } else {
                "NULL".to_owned()
            }
        };
        let time = match k.time {
            Some(ActionTime::PerExecution(_)) => "LW_TIME_EXECUTION",
            _ => "LW_TIME_STEP",
        };
        let action = k.active.is_some();
        let controller = match self.controller {
            mealy::Controller::Machine(_) => {
                format!("{p}_row_of, {p}_rows, {p}_tests, {p}_answers, NULL")
            }
            mealy::Controller::Functions(_) => {
                format!("NULL, NULL, NULL, NULL, &{p}_functions")
            }
        };
        format!(
            "    {{ {}, {}, {}, {}, {}, {},\n        {p}_input, {p}_output, {controller}, {p}_bind,\n        {},\n        {},\n        {}, {}, {}, {time}, {}, {} }},\n",
            string(&k.name),
            u8::from(specification.timing == Timing::Moore),
            self.first_value,
            self.first_wire,
            specification.inputs().count(),
            specification.outputs().count(),
            side(&specification.assumptions, "assumes"),
            side(&specification.guarantees, "guarantees"),
            some(!specification.assumptions.justice.is_empty(), "justice"),
            self.first_justice,
            some(action, "active"),
            some(action, "seconds"),
            some(action, "watts"),
        )
    }

    /// Its justice assumptions' entries in the table that the step limit reads.
    pub fn justice_rules(&self) -> Vec<String> {
        let justice = &self.component.specification.assumptions.justice;
        justice
            .iter()
            .map(|f| self.rule(f, &messages::silent(self.component, f)))
            .collect()
    }

    fn rule(&self, formula: &Formula, message: &str) -> String {
        format!(
            "    {{ {},\n      {} }},\n",
            string(&messages::rule(self.component, formula)),
            string(message)
        )
    }

    fn ports(&self, out: &mut String) {
        let specification = &self.component.specification;
        let p = &self.prefix;
        let inputs: Vec<String> = specification
            .inputs()
            .map(|id| {
                let v = specification.variable(id);
                format!(
                    "    {{ {}, {}, {}, {}, {} }},\n",
                    string(&v.name),
                    string(&v.describe()),
                    self.variables[id.index()],
                    expression::literal(v.domain.low()),
                    expression::literal(v.domain.high())
                )
            })
            .collect();
        table(out, "lw_input", &format!("{p}_input"), &inputs, "{ 0 }");
        let outputs: Vec<String> = specification
            .outputs()
            .map(|id| format!("    {},\n", self.variables[id.index()]))
            .collect();
        table(out, "int", &format!("{p}_output"), &outputs, "0");
    }

    /// The guard rows: every cube of every transition is one, with its tests, its answer and its target.
    fn rows(&self, out: &mut String, controller: &mealy::Machine) {
        let p = &self.prefix;
        let mut answers: Vec<&[i64]> = Vec::new();
        let mut numbers = std::collections::BTreeMap::new();
        let mut tests = Vec::new();
        let mut rows = Vec::new();
        let mut row_of = Vec::new();
        let mut test_count = 0;
        let mut row_count = 0;
        let places = std::iter::once(&controller.initial).chain(&controller.states);
        for (place, transitions) in places.enumerate() {
            let place_name = if place == 0 {
                "before step 0".to_owned()
            } else {
                format!("state {}", place - 1)
            };
            row_of.push(format!("    {row_count}, /* {place_name} */\n"));
            let mut heading = format!("    /* {place_name} */\n");
            for transition in transitions {
                let answer = *numbers
                    .entry(transition.output.as_slice())
                    .or_insert_with(|| {
                        answers.push(&transition.output);
                        answers.len() - 1
                    });
                for cube in &transition.guard.0 {
                    let guard = comment(&controller.show_cube(cube));
                    let heading = std::mem::take(&mut heading);
                    rows.push(format!(
                        "{heading}    {{ {test_count}, {}, {answer}, {} }}, /* {guard} */\n",
                        cube.0.len(),
                        transition.to + 1
                    ));
                    if !cube.0.is_empty() {
                        let line: Vec<String> = cube
                            .0
                            .iter()
                            .map(|t| {
                                format!(
                                    "{{ {}, {}, {} }},",
                                    t.input,
                                    expression::literal(t.low),
                                    expression::literal(t.high)
                                )
                            })
                            .collect();
                        tests.push(format!("    {}\n", line.join(" ")));
                    }
                    test_count += cube.0.len();
                    row_count += 1;
                }
            }
        }
        row_of.push(format!("    {row_count},\n"));
        let ports = &controller.outputs;
        let answers: Vec<String> = answers
            .iter()
            .map(|values| {
                let numbers: String = values
                    .iter()
                    .fold(String::new(), |s, v| s + &expression::literal(*v) + ", ");
                let words: Vec<String> = ports
                    .iter()
                    .zip(values.iter())
                    .map(|(port, v)| format!("{} = {}", port.name, port.domain.show(*v)))
                    .collect();
                format!("    {numbers}/* {} */\n", comment(&words.join(", ")))
            })
            .collect();
        out.push_str(
            "/* The controller. A row is { first test, tests, answer, place it leads to }; place 0 is before step 0,\n * place s + 1 is state s. A test is { input, low, high }. */\n",
        );
        let has_answers = answers.iter().any(|a| !a.starts_with("    /*"));
        let answers = if has_answers { answers } else { Vec::new() };
        table(out, "lw_test", &format!("{p}_tests"), &tests, "{ 0 }");
        table(out, "int64_t", &format!("{p}_answers"), &answers, "0");
        table(out, "lw_row", &format!("{p}_rows"), &rows, "{ 0 }");
        table(out, "int", &format!("{p}_row_of"), &row_of, "0");
    }

    /// The functions: their decisions, and which signals stand for which variable.
    fn functions(&self, out: &mut String, functions: &Functions) {
        let p = &self.prefix;
        let specification = &self.component.specification;
        let _ = writeln!(
            out,
            "/* The controller as functions: of {} signals, in {} decisions. Signal 2k is a bit of the step before, 2k + 1 the same\n * bit of this step. Of a goal's modes the first that holds says what the outputs are. */",
            2 * functions.pairs(),
            functions.controls.diagram.nodes.len()
        );
        let naming = Naming {
            types: "lw_",
            tables: &format!("{p}_"),
        };
        decisions::tables(out, &functions.controls, naming);
        let mut rows = vec![String::new(); specification.variables.len()];
        let inputs = specification.inputs().zip(&functions.input_bits);
        let outputs = specification.outputs().zip(&functions.output_bits);
        for (id, bits) in inputs.chain(outputs) {
            let variable = specification.variable(id);
            rows[id.index()] = format!(
                "    {{ {}, {}, {} }}, /* {} */\n",
                bits.first().map_or(0, |b| b.0),
                bits.len(),
                expression::literal(variable.domain.low()),
                comment(&variable.name)
            );
        }
        out.push_str("/* The bits of its variables, the most significant first: { first signal, bits, lowest value }. */\n");
        table(out, "lw_bits", &format!("{p}_bits"), &rows, "{ 0, 0, 0 }");
        let _ = writeln!(
            out,
            "static const lw_functions {p}_functions = {{\n    {p}_nodes, {p}_bits, {}, {p}_computed, {}, {p}_modes, {p}_goals, {}\n}};\n",
            specification.variables.len(),
            functions.controls.first.len(),
            functions.controls.goals.len()
        );
    }

    fn bindings(&self, out: &mut String) {
        let wires = |v: VarId, _| format!("wires[{}]", self.wires[v.index()]);
        let lines: Vec<String> = self
            .component
            .specification
            .inputs()
            .zip(&self.component.bindings)
            .map(|(id, binding)| {
                let value = expression::integer(binding, &wires);
                wrap(
                    &format!("current[{}] = {value};", self.variables[id.index()]),
                    "        ",
                )
            })
            .collect();
        let _ = writeln!(
            out,
            "static void {}_bind(const int64_t *wires, int64_t *current)\n{{",
            self.prefix
        );
        if !lines.iter().any(|l| l.contains("wires[")) {
            out.push_str("    (void)wires;\n");
        }
        if lines.is_empty() {
            out.push_str("    (void)current;\n");
        }
        for line in lines {
            let _ = writeln!(out, "    {line}");
        }
        out.push_str("}\n\n");
    }

    fn side(&self, out: &mut String, side: &Side, party: Party) {
        let (word, title) = match party {
            Party::Plant => ("assumes", "What it assumes"),
            Party::Machine => ("guarantees", "What it guarantees"),
        };
        let lists = [
            (&side.initial, "initial", "in step 0"),
            (&side.invariants, "invariants", "in every step"),
            (&side.safety, "safety", "from every step to the next"),
        ];
        for (formulas, kind, when) in lists {
            if formulas.is_empty() {
                continue;
            }
            let name = format!("{}_{word}_{kind}", self.prefix);
            let rules: Vec<String> = formulas
                .iter()
                .map(|f| self.rule(f, &messages::broken(self.component, f, party)))
                .collect();
            let mut body = String::new();
            for (i, formula) in formulas.iter().enumerate() {
                let _ = writeln!(
                    body,
                    "    /* {} */\n    if (!({})) {{\n        return {i};\n    }}",
                    cite(formula),
                    self.formula(formula)
                );
            }
            let _ = writeln!(out, "/* {title} {when}. */");
            table(out, "lw_rule", &format!("{name}_rules"), &rules, "{ 0 }");
            let _ = writeln!(
                out,
                "static int {name}(const int64_t *previous, const int64_t *current)\n{{\n{}{body}    return -1;\n}}\n",
                unused(&body)
            );
        }
    }

    fn formula(&self, formula: &Formula) -> String {
        let text = if formula.expr.mentions_next() {
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

    fn justice(&self, out: &mut String) {
        let justice = &self.component.specification.assumptions.justice;
        if justice.is_empty() {
            return;
        }
        let mut body = String::new();
        for (i, formula) in justice.iter().enumerate() {
            let holds = self.formula(formula);
            let holds = if formula.expr.mentions_next() {
                format!("earlier && ({holds})")
            } else {
                holds
            };
            let _ = writeln!(
                body,
                "    /* {} */\n    if ({holds}) {{\n        held[{i}] = step;\n    }}",
                cite(formula)
            );
        }
        let unused_earlier = if body.contains("earlier &&") {
            ""
        } else {
            "    (void)earlier;\n"
        };
        let _ = writeln!(
            out,
            "/* What it assumes to happen again and again. */\nstatic void {}_justice(const int64_t *previous, const int64_t *current, int earlier, int64_t step, int64_t *held)\n{{\n{}{unused_earlier}{body}}}\n",
            self.prefix,
            unused(&body)
        );
    }

    fn action(&self, out: &mut String) {
        let Some(active) = &self.component.active else {
            return;
        };
        let p = &self.prefix;
        let wires = |v: VarId, _| format!("wires[{}]", self.wires[v.index()]);
        let condition = expression::truth(active, &wires);
        let unused = if condition.contains("wires[") {
            ""
        } else {
            "    (void)wires;\n"
        };
        let _ = writeln!(
            out,
            "/* Whether it is being executed in this step. */\nstatic int {p}_active(const int64_t *wires)\n{{\n{unused}    return {};\n}}\n",
            wrap(&condition, "        ")
        );
        let step_seconds = RealExpr::Number(self.machine.step_seconds);
        let (seconds, what) = match &self.component.time {
            None => (&step_seconds, "a step, in seconds"),
            Some(ActionTime::PerStep(expr)) => (expr, "a step, in seconds"),
            Some(ActionTime::PerExecution(expr)) => (expr, "an execution, in seconds"),
        };
        let _ = writeln!(out, "/* The time of {what}. */");
        super::real_function(out, &format!("{p}_seconds"), seconds);
        let _ = writeln!(out, "/* The power it draws, in watts. */");
        super::real_function(out, &format!("{p}_watts"), &self.component.watts);
    }
}

/// `gripped: command = turn -> grip`
fn cite(formula: &Formula) -> String {
    let requirement = formula
        .requirement
        .as_ref()
        .map(|r| format!(" ({r})"))
        .unwrap_or_default();
    comment(&format!("{}{requirement}: {}", formula.name, formula.text))
}

/// The statements that keep a compiler from warning about a parameter.
fn unused(body: &str) -> String {
    ["previous", "current"]
        .into_iter()
        .filter(|name| !body.contains(&format!("{name}[")))
        .fold(String::new(), |s, name| s + &format!("    (void){name};\n"))
}
