//! A single controller as C99, for use outside any station: a header and a source file without dependencies, allocation or
//! recursion.
//!
//! A machine becomes tables of guards, functions become a table of decisions that a short loop walks. Tables rather than
//! code: they compile in a moment whatever their size, and what is shared is there once.

use super::assumed::Assumptions;
use super::decisions::{self, Naming};
use super::expression::literal;
use super::text::comment;
use super::words::{is_header, word};
use super::{Names, table};
use crate::is_device;
use linewright_core::gr1::{Domain, Specification, Timing};
use linewright_solver::mealy::functions::Functions;
use linewright_solver::mealy::{Machine, Port};
use std::collections::HashMap;
use std::fmt::Write;

/// The two files of a controller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Files {
    /// The file's name without its ending, which is also the prefix of all it declares.
    pub name: String,
    /// The header.
    pub header: String,
    /// The source.
    pub source: String,
}

/// A controller of this specification with explicit states.
pub fn of_machine(machine: &Machine, specification: &Specification) -> Files {
    let text = Text::new(
        &machine.name,
        machine.timing,
        &machine.inputs,
        &machine.outputs,
    );
    let assumptions = Assumptions::new(specification);
    let header = text.header(&format!(
        "    /* -1 before step 0. */\n    int32_t state;\n{}",
        assumptions.fields()
    ));
    Files {
        source: text.machine(machine, &assumptions),
        name: text.name,
        header,
    }
}

/// A controller as functions.
pub fn of_functions(functions: &Functions) -> Files {
    let text = Text::new(
        &functions.name,
        functions.timing,
        &functions.inputs,
        &functions.outputs,
    );
    let state = format!(
        "    /* The goal that is pursued; -1 before step 0. */\n    int32_t goal;\n    /* The bits of the last step's values. */\n    uint8_t current[{}];\n",
        functions.pairs().max(1)
    );
    let header = text.header(&state);
    Files {
        source: text.functions(functions),
        name: text.name,
        header,
    }
}

struct Text<'a> {
    contract: &'a str,
    timing: Timing,
    name: String,
    inputs: Vec<(String, &'a Port)>,
    outputs: Vec<(String, &'a Port)>,
}

/// The type of a field.
fn integer(domain: &Domain) -> &'static str {
    let fits = |v: i64| i32::try_from(v).is_ok();
    if fits(domain.low()) && fits(domain.high()) {
        "int32_t"
    } else {
        "int64_t"
    }
}

impl<'a> Text<'a> {
    fn new(contract: &'a str, timing: Timing, inputs: &'a [Port], outputs: &'a [Port]) -> Self {
        let fields = |ports: &'a [Port]| {
            let mut names = Names::default();
            let named = ports.iter().map(|p| (names.unique(&word(&p.name)), p));
            named.collect::<Vec<_>>()
        };
        let mut name = word(contract);
        if is_header(&name) || is_device(&name) {
            name.push('_');
        }
        Self {
            contract,
            timing,
            name,
            inputs: fields(inputs),
            outputs: fields(outputs),
        }
    }

    /// The header, with what is kept between two steps.
    fn header(&self, state: &str) -> String {
        let name = &self.name;
        let guard = format!("LINEWRIGHT_{name}_H");
        let structure = |what: &str, ports: &[(String, &Port)]| {
            let mut fields = String::new();
            for (field, port) in ports {
                let values = match &port.domain {
                    Domain::Enum { labels, .. } => {
                        let labels = labels.iter().enumerate();
                        let labels: Vec<String> =
                            labels.map(|(i, label)| format!("{i} {label}")).collect();
                        labels.join(", ")
                    }
                    Domain::Bool => "0 or 1".to_owned(),
                    domain @ Domain::Range { .. } => domain.describe(),
                };
                let internal = if port.internal { "internal, " } else { "" };
                let _ = writeln!(
                    fields,
                    "    {} {field}; /* {}: {internal}{} */",
                    integer(&port.domain),
                    comment(&port.name),
                    comment(&values)
                );
            }
            if ports.is_empty() {
                fields.push_str("    uint8_t none; /* C has no empty structures. */\n");
            }
            format!("typedef struct {name}_{what} {{\n{fields}}} {name}_{what};\n")
        };
        let kind = match self.timing {
            Timing::Mealy => "The outputs of a step may depend on its inputs.",
            Timing::Moore => "The outputs of a step do not depend on its inputs.",
        };
        format!(
            "/* The controller of the contract {}, synthesized and verified by linewright.\n * {kind}\n */\n\
             #ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n\
             #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
             {}\n{}\n/* Where the controller is between two steps. */\ntypedef struct {name}_state {{\n{state}}} {name}_state;\n\n\
             /* What {name}_step returns. Exactly the inputs that break an assumption are refused as such. */\nenum {{\n    {name}_OK = 0,\n    {name}_ASSUMPTION_BROKEN = -1,\n    {name}_OUTSIDE_DOMAIN = -2\n}};\n\n\
             /* Before step 0. */\nvoid {name}_reset({name}_state *state);\n\n\
             /* One step. A negative result says why it was refused; then state and outputs are as before. */\n\
             int {name}_step({name}_state *state, const {name}_inputs *inputs, {name}_outputs *outputs);\n\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
            comment(self.contract),
            structure("inputs", &self.inputs),
            structure("outputs", &self.outputs),
        )
    }

    fn begin(&self) -> String {
        format!(
            "/* The controller of the contract {}, synthesized and verified by linewright.\n *\n *     cc -std=c99 -O2 -c {}.c\n */\n#include \"{}.h\"\n\n#include <stddef.h>\n\n",
            comment(self.contract),
            self.name,
            self.name
        )
    }

    /// Names of what is local to the source file begin like this.
    fn signature(&self) -> String {
        let name = &self.name;
        format!(
            "int {name}_step({name}_state *state, const {name}_inputs *inputs, {name}_outputs *outputs)\n{{\n"
        )
    }

    /// Refuses inputs outside their domains.
    fn domain_checks(&self) -> String {
        let mut out = String::new();
        for (field, port) in &self.inputs {
            let (low, high) = (literal(port.domain.low()), literal(port.domain.high()));
            let _ = writeln!(
                out,
                "    if (inputs->{field} < {low} || inputs->{field} > {high}) {{\n        return {}_OUTSIDE_DOMAIN;\n    }}",
                self.name
            );
        }
        if self.inputs.is_empty() {
            out.push_str("    (void)inputs;\n");
        }
        out
    }

    fn machine(&self, machine: &Machine, assumptions: &Assumptions<'_>) -> String {
        let name = &self.name;
        let mut out = self.begin();
        let (mut tests, mut cubes, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        let (mut states, mut answers) = (Vec::new(), Vec::new());
        let mut known: HashMap<&[i64], usize> = HashMap::new();
        for list in std::iter::once(&machine.initial).chain(&machine.states) {
            states.push(format!(
                "    {{ {}, {} }},\n",
                rows.len(),
                rows.len() + list.len()
            ));
            for transition in list {
                let first = cubes.len();
                for cube in &transition.guard.0 {
                    let begin = tests.len();
                    for test in &cube.0 {
                        tests.push(format!(
                            "    {{ {}, {}, {} }}, /* {} */\n",
                            test.input,
                            literal(test.low),
                            literal(test.high),
                            comment(&machine.inputs[test.input].name)
                        ));
                    }
                    cubes.push(format!("    {{ {begin}, {} }},\n", tests.len()));
                }
                let fresh = known.len();
                let answer = *known.entry(&transition.output).or_insert(fresh);
                if answer == fresh {
                    let values = transition.output.iter().map(|v| literal(*v) + ", ");
                    answers.push(format!("    {}\n", values.collect::<String>().trim_end()));
                }
                rows.push(format!(
                    "    {{ {first}, {}, {answer}, {} }},\n",
                    cubes.len(),
                    transition.to
                ));
            }
        }
        if machine.outputs.is_empty() {
            answers.clear();
        }
        out.push_str("/* An input that lies between two values. */\ntypedef struct {\n    uint32_t input;\n    int64_t low, high;\n} test;\n\n");
        out.push_str("/* Rows of the next table, from the first up to the last, which is not included. */\ntypedef struct {\n    uint32_t first, last;\n} range;\n\n");
        out.push_str("/* What is done when one of the cubes holds. */\ntypedef struct {\n    uint32_t first, last, answer;\n    int32_t to;\n} transition;\n\n");
        table(&mut out, "test", "tests", &tests, "{ 0, 0, 0 }");
        out.push_str("/* Conjunctions of tests. */\n");
        table(&mut out, "range", "cubes", &cubes, "{ 0, 0 }");
        table(
            &mut out,
            "transition",
            "transitions",
            &rows,
            "{ 0, 0, 0, 0 }",
        );
        out.push_str("/* The transitions of step 0, and of every state. */\n");
        table(&mut out, "range", "states", &states, "{ 0, 0 }");
        if !self.outputs.is_empty() {
            table(&mut out, "int64_t", "answers", &answers, "0");
        }
        out.push_str(&assumptions.definitions());
        let _ = write!(
            out,
            "void {name}_reset({name}_state *state)\n{{\n    state->state = -1;\n{}}}\n\n{}",
            assumptions.reset(),
            self.signature()
        );
        let _ = writeln!(
            out,
            "    int64_t values[{}];\n    const range *here = &states[state->state + 1];\n    uint32_t t, c, k;",
            self.inputs.len().max(1)
        );
        out.push_str(&self.domain_checks());
        for (i, (field, _)) in self.inputs.iter().enumerate() {
            let _ = writeln!(out, "    values[{i}] = inputs->{field};");
        }
        if self.inputs.is_empty() {
            out.push_str("    values[0] = 0;\n");
        }
        out.push_str(&assumptions.refuse(&format!("{name}_ASSUMPTION_BROKEN")));
        out.push_str("    for (t = here->first; t < here->last; t++) {\n        const transition *taken = &transitions[t];\n");
        out.push_str("        for (c = taken->first; c < taken->last; c++) {\n            int holds = 1;\n            for (k = cubes[c].first; k < cubes[c].last; k++) {\n");
        out.push_str("                int64_t value = values[tests[k].input];\n                holds = holds && tests[k].low <= value && value <= tests[k].high;\n            }\n");
        out.push_str("            if (holds) {\n");
        let count = self.outputs.len();
        for (i, (field, port)) in self.outputs.iter().enumerate() {
            let _ = writeln!(
                out,
                "                outputs->{field} = ({})answers[{count} * taken->answer + {i}];",
                integer(&port.domain)
            );
        }
        out.push_str(&assumptions.keep("                ", |i| {
            format!("answers[{count} * taken->answer + {i}]")
        }));
        if self.outputs.is_empty() {
            out.push_str("                (void)outputs;\n");
        }
        let _ = write!(
            out,
            "                state->state = taken->to;\n                return {name}_OK;\n            }}\n        }}\n    }}\n    return {name}_ASSUMPTION_BROKEN;\n}}\n"
        );
        out
    }

    fn functions(&self, functions: &Functions) -> String {
        let name = &self.name;
        let controls = &functions.controls;
        let pairs = functions.pairs();
        let mut out = self.begin();
        out.push_str("/* The signals: signal 2k is a bit of the last step's values, 2k + 1 the same bit in this step. */\n");
        let ports = self.inputs.iter().zip(&functions.input_bits);
        let ports = ports.chain(self.outputs.iter().zip(&functions.output_bits));
        for ((_, port), bits) in ports {
            if let (Some(first), Some(last)) = (bits.first(), bits.last()) {
                let _ = writeln!(
                    out,
                    "/* {}..{}: {} */",
                    first.0,
                    last.0 + 1,
                    comment(&port.name)
                );
            }
        }
        out.push_str("\n/* A decision. Edge 2n leads to node n - 1, edge 2n + 1 to its negation; 0 is false and 1 is true. */\ntypedef struct {\n    uint32_t high, low; /* where it goes on when the signal is 1, and when it is 0 */\n    uint16_t signal;\n} node;\n\n");
        out.push_str("typedef struct {\n    uint32_t edge;\n    uint16_t signal;\n} output;\n\n");
        out.push_str("/* A way of pursuing a goal: when it is taken, and the first of its outputs. */\ntypedef struct {\n    uint32_t when, first;\n} mode;\n\n");
        out.push_str("/* A goal: its first mode, and when it is reached. */\ntypedef struct {\n    uint32_t mode, reached;\n} goal;\n\n");
        let naming = Naming {
            types: "",
            tables: "",
            signal: &|bit| bit.0.to_string(),
        };
        decisions::tables(&mut out, controls, naming);
        let count = controls.first.len();
        let assumed = |out: &mut String, what: &str, edges: Vec<u32>, names: &[String]| {
            let rows = edges.iter().zip(names);
            let rows: Vec<String> = rows
                .map(|(edge, name)| format!("    {edge}, /* {} */\n", comment(name)))
                .collect();
            table(out, "uint32_t", what, &rows, "1");
        };
        out.push_str(
            "/* What the environment has promised for step 0, and for every later step. */\n",
        );
        let edges = controls.assumed_first.iter().map(|(_, e)| e.0).collect();
        assumed(&mut out, "assumed_first", edges, &functions.names_first);
        let edges = controls.assumed.iter().map(|(_, e)| e.0).collect();
        assumed(&mut out, "assumed", edges, &functions.names);

        out.push_str("static int holds(uint32_t edge, const uint8_t *signals)\n{\n    uint32_t value = edge & 1u;\n    while (edge > 1u) {\n        const node *at = &nodes[edge / 2u - 1u];\n        edge = signals[at->signal] ? at->high : at->low;\n        value ^= edge & 1u;\n    }\n    return (int)value;\n}\n\n");
        if functions.input_bits.iter().any(|b| !b.is_empty()) {
            out.push_str("/* Writes a number to every other signal, the most significant bit first. */\nstatic void put(uint8_t *signals, size_t bits, uint64_t code)\n{\n    while (bits-- > 0) {\n        signals[2 * bits] = (uint8_t)(code & 1u);\n        code >>= 1;\n    }\n}\n\n");
        }
        if functions.output_bits.iter().any(|b| !b.is_empty()) {
            out.push_str("/* Reads it back. */\nstatic int64_t get(const uint8_t *signals, size_t bits)\n{\n    uint64_t code = 0;\n    size_t i;\n    for (i = 0; i < bits; i++) {\n        code = 2 * code + signals[2 * i];\n    }\n    return (int64_t)code;\n}\n\n");
        }
        let _ = write!(
            out,
            "void {name}_reset({name}_state *state)\n{{\n    size_t i;\n    state->goal = -1;\n    for (i = 0; i < sizeof state->current; i++) {{\n        state->current[i] = 0;\n    }}\n}}\n\n{}",
            self.signature()
        );
        let _ = writeln!(
            out,
            "    uint8_t signals[{}];\n    const uint32_t *promised = state->goal < 0 ? assumed_first : assumed;\n    size_t promises = state->goal < 0 ? sizeof assumed_first / sizeof *assumed_first : sizeof assumed / sizeof *assumed;\n    const output *answer = computed;\n    size_t i;",
            2 * pairs.max(1)
        );
        out.push_str(&self.domain_checks());
        out.push_str("    for (i = 0; i < sizeof state->current; i++) {\n        signals[2 * i] = state->current[i];\n        signals[2 * i + 1] = 0;\n    }\n");
        for ((field, port), bits) in self.inputs.iter().zip(&functions.input_bits) {
            if let Some(first) = bits.first() {
                let _ = writeln!(
                    out,
                    "    put(signals + {}, {}, (uint64_t)((int64_t)inputs->{field} - {}));",
                    first.primed().0,
                    bits.len(),
                    literal(port.domain.low())
                );
            }
        }
        let _ = write!(
            out,
            "    for (i = 0; i < promises; i++) {{\n        if (!holds(promised[i], signals)) {{\n            return {name}_ASSUMPTION_BROKEN;\n        }}\n    }}\n    if (state->goal >= 0) {{\n        const mode *taken = &modes[goals[state->goal].mode];\n        while (!holds(taken->when, signals)) {{\n            taken++; /* the last mode of a goal always holds */\n        }}\n        answer = &computed[taken->first];\n    }}\n"
        );
        if count > 0 {
            let _ = writeln!(
                out,
                "    for (i = 0; i < {count}; i++) {{\n        signals[answer[i].signal] = (uint8_t)holds(answer[i].edge, signals);\n    }}"
            );
        } else {
            out.push_str("    (void)answer;\n");
        }
        let _ = writeln!(
            out,
            "    if (state->goal < 0) {{\n        state->goal = 0;\n    }} else if (holds(goals[state->goal].reached, signals)) {{\n        state->goal = (state->goal + 1) % {};\n    }}",
            controls.goals.len()
        );
        out.push_str("    for (i = 0; i < sizeof state->current; i++) {\n        state->current[i] = signals[2 * i + 1];\n    }\n");
        for ((field, port), bits) in self.outputs.iter().zip(&functions.output_bits) {
            let low = literal(port.domain.low());
            let value = bits.first().map_or(low.clone(), |first| {
                format!(
                    "get(signals + {}, {}) + {low}",
                    first.primed().0,
                    bits.len()
                )
            });
            let _ = writeln!(
                out,
                "    outputs->{field} = ({})({value});",
                integer(&port.domain)
            );
        }
        if self.outputs.is_empty() {
            out.push_str("    (void)outputs;\n");
        }
        let _ = writeln!(out, "    return {name}_OK;\n}}");
        out
    }
}
