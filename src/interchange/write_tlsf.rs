//! Writes `.tlsf`, for tools of LTL synthesis.
//!
//! The strict semantics of the format is that of a strict GR(1) game, section by section, if everything that is asked of a next step
//! stands behind `X`: an invariant is asked of step 0 under INITIALLY or PRESET, and of every next step under REQUIRE or ASSERT. A number
//! is a bus that holds the distance from its smallest value; what its bits can hold beyond its domain is kept out like an invariant.

use super::gates::{Gate, Gates, Shape, TooMany};
use super::rename::renamed;
use crate::diagnostics::Diagnostic;
use crate::gr1::{Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId};
use std::fmt::Write as _;

/// A formula may have so many gates, written out.
const MAX_SIZE: u64 = 1 << 14;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let names = { specification.variables.iter() }.map(|v| v.name.as_str());
    let names = renamed(names, "v_", is_name);
    let mut writer = Writer {
        specification,
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
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && { name.chars() }.all(|c| c.is_ascii_alphanumeric() || "_'@".contains(c))
        && !super::tlsf::is_reserved(name)
}

struct Writer<'s> {
    specification: &'s Specification,
    names: &'s [String],
    gates: Gates,
    findings: Vec<Diagnostic>,
}

impl Writer<'_> {
    fn file(&mut self) -> String {
        let specification = self.specification;
        let kind = match specification.timing {
            Timing::Mealy => "Mealy",
            Timing::Moore => "Moore",
        };
        let title = super::names::one_line(&specification.name).replace(['"', '\\'], "'");
        let mut text = format!(
            "INFO {{\n  TITLE:       \"{title}\"\n  DESCRIPTION: \"Written by Linewright\"\n  SEMANTICS:   {kind},Strict\n  TARGET:      {kind}\n}}\n\nMAIN {{\n"
        );
        for (head, owner) in [("INPUTS", Owner::Environment), ("OUTPUTS", Owner::System)] {
            let _ = writeln!(text, "  {head} {{");
            for (variable, name) in specification.variables.iter().zip(self.names) {
                if variable.owner == owner {
                    let about = about(&variable.name, name, &variable.domain);
                    let _ = match bits(&variable.domain) {
                        _ if variable.domain == Domain::Bool => {
                            writeln!(text, "    {name};{about}")
                        }
                        0 => writeln!(text, "    // {name} has one value"),
                        n => writeln!(text, "    {name}[{n}];{about}"),
                    };
                }
            }
            // The format wants one signal at least.
            let constant = |v: &crate::gr1::Variable| v.domain.size() == 1;
            if owner == Owner::System && specification.variables.iter().all(constant) {
                text.push_str("    unused;\n");
            }
            text.push_str("  }\n");
        }
        let sides = [
            (
                ["INITIALLY", "REQUIRE", "ASSUME"],
                Owner::Environment,
                &specification.assumptions,
            ),
            (
                ["PRESET", "ASSERT", "GUARANTEE"],
                Owner::System,
                &specification.guarantees,
            ),
        ];
        for (heads, owner, side) in sides {
            self.side(heads, owner, side, &mut text);
        }
        text.push_str("}\n");
        text
    }

    fn side(
        &mut self,
        [initial, steps, justice]: [&str; 3],
        owner: Owner,
        side: &Side,
        text: &mut String,
    ) {
        let list = { side.initial.iter().chain(&side.invariants) }
            .map(|f| self.formula(f, Time::Now))
            .collect::<Vec<_>>();
        let domains = self.domains(owner, Time::Now);
        section(initial, list.into_iter().chain(domains), text);
        let mut list: Vec<String> = side
            .invariants
            .iter()
            .map(|f| self.formula(f, Time::Next))
            .collect();
        list.extend(side.safety.iter().map(|f| self.formula(f, Time::Now)));
        let domains = self.domains(owner, Time::Next);
        section(steps, list.into_iter().chain(domains), text);
        let list: Vec<String> = { side.justice.iter() }
            .map(|f| format!("G F ({})", self.formula(f, Time::Now)))
            .collect();
        section(justice, list, text);
    }

    /// A formula from this step or from the next one on.
    fn formula(&mut self, formula: &Formula, from: Time) -> String {
        let mut text = String::new();
        match self
            .gates
            .formula(self.specification, &moved(&formula.expr, from))
        {
            Ok(gate) if self.gates.tree_size(gate) <= MAX_SIZE => self.gate(gate, &mut text),
            _ => self.findings.push(TooMany::finding(formula)),
        }
        text
    }

    /// What the bits of numbers can hold beyond their domains, kept out.
    fn domains(&self, owner: Owner, time: Time) -> Vec<String> {
        let mut found = Vec::new();
        for (index, variable) in self.specification.variables.iter().enumerate() {
            let size = variable.domain.size();
            if variable.owner == owner && size != 1 << bits(&variable.domain) {
                found.push(self.at_most(VarId(index as u32), time, size - 1));
            }
        }
        found
    }

    /// A bit, or the whole of a Boolean.
    fn bit(&self, v: VarId, time: Time, k: u32) -> String {
        let name = &self.names[v.index()];
        let next = if time == Time::Next { "X " } else { "" };
        match self.specification.variable(v).domain {
            Domain::Bool => format!("{next}{name}"),
            _ => format!("{next}{name}[{k}]"),
        }
    }

    /// That the bits hold at most this number: from the lowest bit up, "at most so far" is "this bit is below the bound's, or equal
    /// and the lower ones are at most".
    fn at_most(&self, v: VarId, time: Time, bound: u64) -> String {
        let mut text = "true".to_owned();
        for k in 0..bits(&self.specification.variable(v).domain) {
            let bit = self.bit(v, time, k);
            let op = if bound >> k & 1 == 1 { "||" } else { "&&" };
            text = match (text.as_str(), op) {
                ("true", "||") => continue,
                ("true", _) => format!("! {bit}"),
                _ => format!("(! {bit} {op} {text})"),
            };
        }
        text
    }

    /// The recursion is as deep as the formula.
    fn gate(&self, gate: Gate, text: &mut String) {
        let pair = |text: &mut String, a: Gate, op: &str, b: Gate| {
            text.push('(');
            self.gate(a, text);
            text.push_str(op);
            self.gate(b, text);
            text.push(')');
        };
        match self.gates.shape(gate) {
            Shape::Const(value) => text.push_str(if value { "true" } else { "false" }),
            Shape::Not(a) => {
                text.push_str("! ");
                self.gate(a, text);
            }
            Shape::And(..) => self.chain(gate, true, text),
            Shape::Or(..) => self.chain(gate, false, text),
            Shape::Xor(a, b) => {
                text.push_str("! ");
                pair(text, a, " <-> ", b);
            }
            Shape::Bit(v, time, k) => text.push_str(&self.bit(v, time, k)),
            Shape::Within(v, time, low, high) => {
                let domain = &self.specification.variable(v).domain;
                let (bottom, top) = (domain.low(), domain.high());
                let above = (low > bottom)
                    .then(|| format!("! {}", self.at_most(v, time, (low - bottom - 1) as u64)));
                let below = (high < top).then(|| self.at_most(v, time, (high - bottom) as u64));
                match (above, below) {
                    (None, None) => text.push_str("true"),
                    (Some(one), None) | (None, Some(one)) => text.push_str(&one),
                    (Some(above), Some(below)) => {
                        let _ = write!(text, "({above} && {below})");
                    }
                }
            }
        }
    }

    /// The operands of a chain side by side, so that they do not nest.
    fn chain(&self, root: Gate, and: bool, text: &mut String) {
        let (mut open, mut first) = (vec![root], true);
        text.push('(');
        while let Some(gate) = open.pop() {
            match (self.gates.shape(gate), and) {
                (Shape::And(a, b), true) | (Shape::Or(a, b), false) => open.extend([b, a]),
                _ => {
                    if !first {
                        text.push_str(if and { " && " } else { " || " });
                    }
                    first = false;
                    self.gate(gate, text);
                }
            }
        }
        text.push(')');
    }
}

fn section(head: &str, formulas: impl IntoIterator<Item = String>, text: &mut String) {
    let _ = writeln!(text, "  {head} {{");
    for formula in formulas {
        let _ = writeln!(text, "    {formula};");
    }
    text.push_str("  }\n");
}

/// What became of a name, labels and offsets.
fn about(old: &str, new: &str, domain: &Domain) -> String {
    let mut parts = Vec::new();
    if old != new {
        parts.push(format!("was {}", super::names::one_line(old)));
    }
    match domain {
        Domain::Enum { labels, .. } => {
            let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
            parts.push(labels.collect::<Vec<_>>().join(", "));
        }
        Domain::Range { low, .. } if *low != 0 => parts.push(format!("0 stands for {low}")),
        _ => {}
    }
    if parts.is_empty() {
        String::new()
    } else {
        format!(" // {}", parts.join("; "))
    }
}

fn moved(expr: &Expr, from: Time) -> Expr {
    match from {
        Time::Now => expr.clone(),
        Time::Next => expr.substitute(&mut |v, _| Expr::next(v)),
    }
}

/// How many bits a variable has.
fn bits(domain: &Domain) -> u32 {
    u64::BITS - (domain.size() - 1).leading_zeros()
}
