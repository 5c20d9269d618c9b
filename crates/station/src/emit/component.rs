//! One component: its decisions or its functions as tables, its formulas, bindings, time and power as functions.

use super::decisions::{self, Naming};
use super::expression;
use super::splits::{Decisions, Way};
use super::text::{comment, identifier, string, wrap};
use super::walks::{Place, Walks};
use super::{Names, table};
use crate::messages::{self, Party};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Domain, Expr, Formula, Side, Time, Timing, VarId, shown};
use linewright_language::contract::machine::{ActionTime, Component, Machine, RealExpr, Role};
use linewright_solver::mealy;
use linewright_solver::mealy::functions::Functions;
use linewright_solver::symbolic::Bit;
use std::collections::BTreeMap;
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
    /// Its first justice assumption among those of all components.
    pub first_justice: usize,
}

/// Where a signal is: which bit of which value.
struct Signal {
    value: usize,
    /// `LW_PREVIOUS`, `LW_CURRENT` or `LW_SHIFTED` of `ffi/machine.h`.
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

/// The rows of walks, and lists of those at which the walks of a step begin. What writes bits of several variables takes several rows.
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
            Place::Ask { .. } => 1,
            Place::Put { bits, .. } => put(bits).len(),
        };
    }
    let mut rows = Vec::new();
    for place in &walks.places {
        match place {
            Place::Ask { bit, high, low } => {
                let (high, low) = (places[*high], places[*low]);
                rows.push(format!(
                    "    {{ {high}, {low}, {} }},\n",
                    signal(*bit).fields()
                ));
            }
            Place::Put { bits, next: after } => {
                let values = put(bits);
                let last = rows.len() + values.len();
                for ((from, value), mask) in values {
                    let next = rows.len() + 2;
                    let next = if next > last { places[*after] } else { next };
                    rows.push(format!(
                        "    {{ {next}, {mask}, {value}, {}, 0 }},\n",
                        PUT + from
                    ));
                }
            }
        }
    }
    let starts = walks.starts.iter();
    let starts = starts.map(|list| list.iter().map(|place| places[*place]).collect());
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
            mealy::Controller::Machine(machine) => self.decisions(&mut out, machine),
            mealy::Controller::Functions(functions) => self.functions(&mut out, functions),
        }
        self.bindings(&mut out);
        let party = Party::of_assumptions(k);
        self.side(&mut out, &k.specification.assumptions, party);
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
                let first = if specification.timing == Timing::Moore {
                    format!("{p}_first_answer")
                } else {
                    "NULL".to_owned()
                };
                format!("{p}_way, {p}_splits, {p}_leaves, {p}_answers, {first}, NULL")
            }
            mealy::Controller::Functions(_) => {
                format!("NULL, NULL, NULL, NULL, NULL, &{p}_functions")
            }
        };
        format!(
            "    {{ {}, {}, {}, {}, {}, {},\n        {p}_input, {p}_output, {controller}, {p}_bind,\n        {},\n        {},\n        {}, {}, {}, {time}, {}, {} }},\n",
            string(&k.name),
            u8::from(specification.timing == Timing::Moore),
            u8::from(k.role == Role::Watch),
            self.first_value,
            self.open_inputs().len(),
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

    /// The inputs whose bindings could leave their domains; the others need no check in a step.
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

    fn ports(&self, out: &mut String) {
        let specification = &self.component.specification;
        let p = &self.prefix;
        let inputs: Vec<String> = self
            .open_inputs()
            .into_iter()
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

    /// The transitions, as decisions.
    fn decisions(&self, out: &mut String, controller: &mealy::Machine) {
        let p = &self.prefix;
        let decisions = Decisions::of(controller);
        let inputs: Vec<VarId> = self.component.specification.inputs().collect();
        let number = |way: &Way| match way {
            Way::Split(n) => n.to_string(),
            Way::Leaf(n) => format!("-{}", n + 1),
        };
        let splits = decisions.splits.iter().map(|split| {
            let port = &controller.inputs[split.input];
            let condition = if port.domain == Domain::Bool {
                format!("!{}", port.name)
            } else {
                let bound = shown(&port.domain, split.bound, &port.unit);
                format!("{} <= {bound}", port.name)
            };
            format!(
                "    {{ {}, {}, {}, {} }}, /* {} */\n",
                self.variables[inputs[split.input].index()],
                number(&split.at_most),
                number(&split.above),
                expression::literal(split.bound),
                comment(&condition)
            )
        });
        let leaves = decisions.leaves.iter().map(|leaf| match leaf {
            Some((answer, to)) => format!("    {{ {answer}, {to} }},\n"),
            None => "    { 0, -1 },\n".to_owned(),
        });
        let ports = &controller.outputs;
        let answers = decisions
            .answers
            .iter()
            .filter(|a| !a.is_empty())
            .map(|values| {
                let numbers: String = values
                    .iter()
                    .fold(String::new(), |s, v| s + &expression::literal(*v) + ", ");
                let words: Vec<String> = ports
                    .iter()
                    .zip(values)
                    .map(|(port, v)| {
                        format!("{} = {}", port.name, shown(&port.domain, *v, &port.unit))
                    })
                    .collect();
                format!("    {numbers}/* {} */\n", comment(&words.join(", ")))
            });
        let named = |place: usize| match place {
            0 => "before step 0".to_owned(),
            _ => format!("state {}", place - 1),
        };
        let ways = decisions.places.iter().enumerate();
        let ways =
            ways.map(|(place, way)| format!("    {}, /* {} */\n", number(way), named(place)));
        out.push_str(
            "/* The controller. A split is { variable, way if it is at most the bound, way if it is more, bound }; a way is a split's number, or\n * -1 - n for leaf n. A leaf is { answer, place it leads to }; place 0 is before step 0, place s + 1 is state s. */\n",
        );
        let table_of = |out: &mut String, of: &str, name: &str, rows: Vec<String>, empty: &str| {
            table(out, of, &format!("{p}_{name}"), &rows, empty);
        };
        table_of(out, "lw_split", "splits", splits.collect(), "{ 0 }");
        table_of(out, "lw_leaf", "leaves", leaves.collect(), "{ 0, -1 }");
        table_of(out, "lw_number", "answers", answers.collect(), "0");
        table_of(out, "int", "way", ways.collect(), "0");
        if controller.timing == Timing::Moore {
            let firsts = decisions.first_answers.iter().map(|answer| match answer {
                Some(answer) => format!("    {answer},\n"),
                None => "    -1,\n".to_owned(),
            });
            table_of(out, "int", "first_answer", firsts.collect(), "-1");
        }
    }

    /// The functions: their decisions, and where the bits are that they look at.
    fn functions(&self, out: &mut String, functions: &Functions) {
        let p = &self.prefix;
        let specification = &self.component.specification;
        let mut shifted = Vec::new();
        // Where the bits of each pair are: the variable's number, that among the shifted ones, and the place in the value.
        let mut places = vec![(0, None, 0); functions.pairs()];
        let inputs = specification.inputs().zip(&functions.input_bits);
        let outputs = specification.outputs().zip(&functions.output_bits);
        for (is_output, (id, bits)) in inputs.map(|i| (false, i)).chain(outputs.map(|o| (true, o)))
        {
            let variable = specification.variable(id);
            let low = variable.domain.low();
            let moved = (low != 0).then(|| {
                shifted.push(format!(
                    "    {{ {}, {}, {} }},\n",
                    self.variables[id.index()],
                    u8::from(is_output),
                    expression::literal(low),
                ));
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
        let naming = Naming {
            types: "lw_",
            tables: &format!("{p}_"),
            signal: &|bit| signal(bit).fields(),
        };
        let controls = &functions.controls;
        let signals = 2 * functions.pairs();
        let (rows, starts) = walk_rows(&Walks::of(controls), signal);
        let _ = writeln!(
            out,
            "/* The controller as functions of {signals} signals: walks decide all outputs. Of a goal's modes the first that holds says\n * which. */",
        );
        table(out, "lw_node", &format!("{p}_walk"), &rows, "{ 0 }");
        decisions::around_walks(out, controls, naming, &starts);
        out.push_str("/* Its variables whose domains do not begin at 0: { variable, whether it is an output, lowest value }. */\n");
        table(
            out,
            "lw_shifted",
            &format!("{p}_shifted"),
            &shifted,
            "{ 0 }",
        );
        let _ = writeln!(
            out,
            "static const lw_functions {p}_functions = {{\n    {p}_nodes, {p}_shifted, {}, {p}_walk, {p}_walks, {p}_modes, {p}_goals, {}\n}};\n",
            shifted.len(),
            controls.goals.len()
        );
    }

    fn bindings(&self, out: &mut String) {
        let wires = |v: VarId, _| format!("values[{}]", self.wires[v.index()]);
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
            "static void {}_bind(const int64_t *values, int64_t *current)\n{{",
            self.prefix
        );
        if !lines.iter().any(|l| l.contains("values[")) {
            out.push_str("    (void)values;\n");
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
            Party::Caller => ("assumes", "The orders that it watches over"),
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
                    self.formula(formula, kind == "safety")
                );
            }
            let _ = writeln!(out, "/* {title} {when}. */");
            table(out, "lw_rule", &format!("{name}_rules"), &rules, "{ 0 }");
            let _ = writeln!(
                out,
                "static int {name}(const int64_t *previous, const int64_t *current)\n{{\n{}{body}    return -1;\n}}\n",
                unused(&body, &["previous", "current"])
            );
        }
    }

    /// A formula, which speaks of two steps or of the current one.
    fn formula(&self, formula: &Formula, of_two: bool) -> String {
        let text = if of_two {
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
            let holds = self.formula(formula, formula.expr.mentions_next());
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
            unused(&body, &["previous", "current"])
        );
    }

    fn action(&self, out: &mut String) {
        let Some(active) = &self.component.active else {
            return;
        };
        let p = &self.prefix;
        let wires = |v: VarId, _| format!("values[{}]", self.wires[v.index()]);
        let condition = expression::truth(active, &wires);
        let unused = if condition.contains("values[") {
            ""
        } else {
            "    (void)values;\n"
        };
        let _ = writeln!(
            out,
            "/* Whether it is being executed in this step. */\nstatic int {p}_active(const int64_t *values)\n{{\n{unused}    return {};\n}}\n",
            wrap(&condition, "        ")
        );
        let step_seconds = RealExpr::Number(self.machine.step_seconds);
        let (seconds, what) = match &self.component.time {
            None => (&step_seconds, "a step, in seconds"),
            Some(ActionTime::PerStep(expr)) => (expr, "a step, in seconds"),
            Some(ActionTime::PerExecution(expr)) => (expr, "an execution, in seconds"),
        };
        let _ = writeln!(out, "/* The time of {what}. */");
        super::real_function(out, &format!("{p}_seconds"), seconds, self.wires);
        let _ = writeln!(out, "/* The power it draws, in watts. */");
        super::real_function(
            out,
            &format!("{p}_watts"),
            &self.component.watts,
            self.wires,
        );
    }
}

/// `gripped: command = turn -> grip`
pub(super) fn cite(formula: &Formula) -> String {
    let requirement = formula
        .requirement
        .as_ref()
        .map(|r| format!(" ({r})"))
        .unwrap_or_default();
    comment(&format!("{}{requirement}: {}", formula.name, formula.text))
}

/// The statements that keep a compiler from warning about parameters, which are arrays.
pub(super) fn unused(body: &str, parameters: &[&str]) -> String {
    let code = without_comments(body);
    parameters
        .iter()
        .filter(|name| !code.contains(&format!("{name}[")))
        .fold(String::new(), |s, name| s + &format!("    (void){name};\n"))
}

/// The lines of a text that are no comments, in which a contract's words stand.
pub(super) fn without_comments(text: &str) -> String {
    let lines = text.lines().filter(|l| !l.trim_start().starts_with("/*"));
    lines.fold(String::new(), |s, line| s + line + "\n")
}
