//! Writes `.spc`, for gr1c.
//!
//! A number `low..high` becomes `[0,high-low]`, comparisons move with it; enumerations are numbered. gr1c compares a variable with a
//! number and has no arithmetic, so formulas are written out by [`gates`](super::gates). What the format has not: answering first,
//! invariants, primed goals, initial conditions of the machine that speak of inputs; see [`lower`](super::lower).

use super::gates::{Gate, Gates, Shape, TooMany};
use super::lower;
use super::rename::renamed;
use crate::diagnostics::Diagnostic;
use crate::gr1::{Domain, Formula, Owner, Side, Specification, Time, Variable};
use std::fmt::Write as _;

/// A formula may have so many gates, written out.
const MAX_SIZE: u64 = 1 << 18;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let lowered = lower::answering_second(&lower::without_invariants(specification));
    let lowered = lower::starting_alone(&lower::goals_of_states(&lowered));
    let names = renamed(
        lowered.variables.iter().map(|v| v.name.as_str()),
        "v_",
        is_name,
    );
    let mut writer = Writer {
        specification: &lowered,
        names: &names,
        gates: Gates::default(),
        findings: Vec::new(),
    };
    let text = writer.file();
    if writer.findings.is_empty() {
        Ok(text)
    } else {
        Err(writer.findings)
    }
}

fn is_name(name: &str) -> bool {
    const WORDS: [&str; 10] = [
        "True", "False", "ENV", "SYS", "ENVINIT", "ENVTRANS", "ENVGOAL", "SYSINIT", "SYSTRANS",
        "SYSGOAL",
    ];
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "_.".contains(c))
        && !WORDS.contains(&name)
}

struct Writer<'s> {
    specification: &'s Specification,
    names: &'s [String],
    gates: Gates,
    findings: Vec<Diagnostic>,
}

impl Writer<'_> {
    fn file(&mut self) -> String {
        let mut text = format!("# {}\n", super::names::one_line(&self.specification.name));
        text.push_str(&legend(self.specification, self.names, true));
        text.push('\n');
        for (head, owner) in [("ENV", Owner::Environment), ("SYS", Owner::System)] {
            let _ = write!(text, "{head}:");
            for (variable, name) in self.specification.variables.iter().zip(self.names) {
                if variable.owner == owner {
                    let _ = write!(text, " {name}");
                    if variable.domain != Domain::Bool {
                        let _ = write!(text, " [0,{}]", variable.domain.size() - 1);
                    }
                }
            }
            // gr1c wants one variable at least.
            if owner == Owner::System && self.specification.variables.is_empty() {
                text.push_str(" unused");
            }
            text.push_str(";\n");
        }
        let specification = self.specification;
        for (head, side) in [
            ("ENV", &specification.assumptions),
            ("SYS", &specification.guarantees),
        ] {
            text.push('\n');
            self.side(head, side, &mut text);
        }
        text
    }

    fn side(&mut self, head: &str, side: &Side, text: &mut String) {
        for (kind, operator, formulas) in [
            ("INIT", "", &side.initial),
            ("TRANS", "[]", &side.safety),
            ("GOAL", "[]<>", &side.justice),
        ] {
            let _ = write!(text, "{head}{kind}:");
            for (index, formula) in formulas.iter().enumerate() {
                let sign = if index == 0 { ' ' } else { '&' };
                let body = self.formula(formula);
                let name = super::names::one_line(&formula.name);
                let _ = write!(text, "\n  {sign} {operator}({body})  # {name}");
            }
            text.push_str(if formulas.is_empty() { ";\n" } else { "\n;\n" });
        }
    }

    fn formula(&mut self, formula: &Formula) -> String {
        let mut text = String::new();
        match self.gates.formula(self.specification, &formula.expr) {
            Ok(gate) if self.gates.tree_size(gate) <= MAX_SIZE => self.gate(gate, &mut text),
            _ => self.findings.push(TooMany::finding(formula)),
        }
        text
    }

    /// The recursion is as deep as the formula and the trees of its cases.
    fn gate(&self, gate: Gate, text: &mut String) {
        let binary = |text: &mut String, a: Gate, op: &str, b: Gate| {
            text.push('(');
            self.gate(a, text);
            text.push_str(op);
            self.gate(b, text);
            text.push(')');
        };
        match self.gates.shape(gate) {
            Shape::Const(value) => text.push_str(if value { "True" } else { "False" }),
            Shape::Not(a) => {
                if let Shape::Xor(a, b) = self.gates.shape(a) {
                    binary(text, a, " <-> ", b);
                } else {
                    text.push('!');
                    self.gate(a, text);
                }
            }
            Shape::And(a, b) => binary(text, a, " & ", b),
            Shape::Or(a, b) => binary(text, a, " | ", b),
            Shape::Xor(a, b) => {
                text.push('!');
                binary(text, a, " <-> ", b);
            }
            Shape::Within(v, time, low, high) => {
                let domain = &self.specification.variable(v).domain;
                let name = &self.names[v.index()];
                let prime = if time == Time::Next { "'" } else { "" };
                let (bottom, top) = (domain.low(), domain.high());
                let _ = match (domain, low == bottom, high == top) {
                    (Domain::Bool, _, true) => write!(text, "{name}{prime}"),
                    (Domain::Bool, ..) => write!(text, "!{name}{prime}"),
                    _ if low == high => write!(text, "({name}{prime} = {})", low - bottom),
                    (_, true, _) => write!(text, "({name}{prime} <= {})", high - bottom),
                    (_, _, true) => write!(text, "({name}{prime} >= {})", low - bottom),
                    _ => write!(
                        text,
                        "(({name}{prime} >= {}) & ({name}{prime} <= {}))",
                        low - bottom,
                        high - bottom
                    ),
                };
            }
            // Bits are made by the other writer only.
            Shape::Bit(..) => {}
        }
    }
}

/// What became of names, labels and offsets, in comments. `offset` tells whether numbers are counted from 0.
pub(super) fn legend(specification: &Specification, names: &[String], offset: bool) -> String {
    let mut text = String::new();
    for (variable, name) in specification.variables.iter().zip(names) {
        let mut parts = Vec::new();
        if *name != variable.name {
            parts.push(format!("was {}", variable.name));
        }
        match &variable.domain {
            Domain::Enum { labels, .. } => {
                let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
                parts.push(labels.collect::<Vec<_>>().join(", "));
            }
            Domain::Range { low, .. } if *low != 0 && offset => {
                parts.push(format!("0 stands for {low}"));
            }
            _ => {}
        }
        if is_helper(variable) {
            parts.push("a helper".to_owned());
        }
        if !parts.is_empty() {
            let _ = writeln!(text, "# {name}: {}", parts.join("; "));
        }
    }
    text
}

/// Helpers stand in no file.
fn is_helper(variable: &Variable) -> bool {
    variable.internal && variable.span == crate::source::Span::default()
}
