//! Writes `.slugsin`, for slugs.
//!
//! The format has truth values only. A number becomes its bits, named as slugs' translator names them: `x@0.low.high` for the lowest,
//! `x@1`, ... for the others, which hold the distance from the smallest value; where some bits make no value, lines keep
//! them out. Sub-formulas that are used more than once become cells of a memory buffer, so that a formula stays as small as its
//! gates. What the format has not: answering first, and invariants; see [`lower`](super::lower).

use super::gates::{Gate, Gates, Shape, TooMany};
use super::lower;
use super::rename::renamed;
use super::write_spc::legend;
use crate::diagnostics::Diagnostic;
use crate::gr1::{Domain, Owner, Side, Specification, Time, VarId};
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let lowered = lower::answering_second(&lower::without_invariants(specification));
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

/// Names that slugs' own tools take too.
fn is_name(name: &str) -> bool {
    const WORDS: [&str; 9] = [
        "X",
        "F",
        "G",
        "U",
        "W",
        "FALSE",
        "TRUE",
        "next",
        "LEASTSIGNIFICANTBITOVERWRITES",
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
        let specification = self.specification;
        let mut text = format!("# {}\n", super::names::one_line(&specification.name));
        text.push_str(&legend(specification, self.names, false));
        for (head, owner) in [("INPUT", Owner::Environment), ("OUTPUT", Owner::System)] {
            let _ = writeln!(text, "\n[{head}]");
            for (index, variable) in specification.variables.iter().enumerate() {
                if variable.owner == owner {
                    for k in 0..bits(&variable.domain) {
                        let _ = writeln!(text, "{}", self.bit_name(VarId(index as u32), k));
                    }
                }
            }
        }
        for (head, owner, side) in [
            ("ENV", Owner::Environment, &specification.assumptions),
            ("SYS", Owner::System, &specification.guarantees),
        ] {
            self.side(head, owner, side, &mut text);
        }
        text
    }

    fn side(&mut self, head: &str, owner: Owner, side: &Side, text: &mut String) {
        for (kind, time, formulas) in [
            ("INIT", Some(Time::Now), &side.initial),
            ("TRANS", Some(Time::Next), &side.safety),
            ("LIVENESS", None, &side.justice),
        ] {
            let _ = writeln!(text, "\n[{head}_{kind}]");
            for formula in formulas {
                let _ = writeln!(text, "# {}", super::names::one_line(&formula.name));
                match self.gates.formula(self.specification, &formula.expr) {
                    Ok(gate) => {
                        let gate = self.in_bits(gate);
                        let _ = writeln!(text, "{}", self.line(gate));
                    }
                    Err(TooMany) => self.findings.push(TooMany::finding(formula)),
                }
            }
            if let Some(time) = time {
                self.domains(owner, time, text);
            }
        }
    }

    /// Lines that keep out what the bits of a number can hold beyond its domain.
    fn domains(&mut self, owner: Owner, time: Time, text: &mut String) {
        for index in 0..self.specification.variables.len() {
            let variable = &self.specification.variables[index];
            let size = variable.domain.size();
            if variable.owner == owner && size != 1 << bits(&variable.domain) {
                let _ = writeln!(text, "# {} has {size} values", self.names[index]);
                let gate = self.at_most(VarId(index as u32), time, size - 1);
                let _ = writeln!(text, "{}", self.line(gate));
            }
        }
    }

    fn bit_name(&self, v: VarId, k: u32) -> String {
        let name = &self.names[v.index()];
        match &self.specification.variable(v).domain {
            Domain::Bool => name.clone(),
            domain if k == 0 => format!("{name}@0.{}.{}", domain.low(), domain.high()),
            _ => format!("{name}@{k}"),
        }
    }

    /// That the bits hold at most this number: from the lowest bit up, "at most so far" is "this bit is below the bound's, or equal
    /// and the lower ones are at most".
    fn at_most(&mut self, v: VarId, time: Time, bound: u64) -> Gate {
        let mut gate = self.gates.bool(true);
        for k in 0..bits(&self.specification.variable(v).domain) {
            let bit = self.gates.bit(v, time, k);
            let unset = self.gates.not(bit);
            gate = if bound >> k & 1 == 1 {
                self.gates.or(unset, gate)
            } else {
                self.gates.and(unset, gate)
            };
        }
        gate
    }

    fn at_least(&mut self, v: VarId, time: Time, bound: u64) -> Gate {
        match bound.checked_sub(1) {
            None => self.gates.bool(true),
            Some(below) => {
                let gate = self.at_most(v, time, below);
                self.gates.not(gate)
            }
        }
    }

    /// The same gate over bits.
    fn in_bits(&mut self, root: Gate) -> Gate {
        let mut done: BTreeMap<Gate, Gate> = BTreeMap::new();
        // A gate stands behind what it uses.
        for gate in self.gates.uses(root).into_keys() {
            let new = |g: Gate| done.get(&g).copied().unwrap_or(g);
            let made = match self.gates.shape(gate) {
                Shape::Within(v, time, low, high) => {
                    let bottom = self.specification.variable(v).domain.low();
                    let low = self.at_least(v, time, (low - bottom) as u64);
                    let high = self.at_most(v, time, (high - bottom) as u64);
                    self.gates.and(low, high)
                }
                Shape::Not(a) => {
                    let a = new(a);
                    self.gates.not(a)
                }
                Shape::And(a, b) => {
                    let (a, b) = (new(a), new(b));
                    self.gates.and(a, b)
                }
                Shape::Or(a, b) => {
                    let (a, b) = (new(a), new(b));
                    self.gates.or(a, b)
                }
                Shape::Xor(a, b) => {
                    let (a, b) = (new(a), new(b));
                    self.gates.xor(a, b)
                }
                Shape::Const(_) | Shape::Bit(..) => gate,
            };
            done.insert(gate, made);
        }
        done.get(&root).copied().unwrap_or(root)
    }

    /// The line of a gate: its shared gates as cells, itself as the last one.
    fn line(&self, root: Gate) -> String {
        let uses = self.gates.uses(root);
        let shared = |gate: Gate| {
            uses.get(&gate).is_some_and(|n| *n > 1)
                && matches!(
                    self.gates.shape(gate),
                    Shape::And(..) | Shape::Or(..) | Shape::Xor(..)
                )
        };
        let cells: BTreeMap<Gate, usize> = uses
            .keys()
            .copied()
            .filter(|g| shared(*g))
            .zip(0..)
            .collect();
        let mut words: Vec<String> = Vec::new();
        if !cells.is_empty() {
            words.extend(["$".to_owned(), (cells.len() + 1).to_string()]);
            for gate in cells.keys() {
                self.words(*gate, &cells, &mut words);
            }
        }
        match cells.get(&root) {
            Some(cell) => words.extend(["?".to_owned(), cell.to_string()]),
            None => self.words(root, &cells, &mut words),
        }
        words.join(" ")
    }

    fn words(&self, root: Gate, cells: &BTreeMap<Gate, usize>, words: &mut Vec<String>) {
        let mut open = vec![root];
        while let Some(gate) = open.pop() {
            if let Some(cell) = cells.get(&gate).filter(|_| gate != root) {
                words.extend(["?".to_owned(), cell.to_string()]);
                continue;
            }
            let (word, operands) = match self.gates.shape(gate) {
                Shape::Const(value) => (u8::from(value).to_string(), vec![]),
                Shape::Bit(v, time, k) => {
                    let prime = if time == Time::Next { "'" } else { "" };
                    (self.bit_name(v, k) + prime, vec![])
                }
                Shape::Not(a) => ("!".to_owned(), vec![a]),
                Shape::And(a, b) => ("&".to_owned(), vec![b, a]),
                Shape::Or(a, b) => ("|".to_owned(), vec![b, a]),
                Shape::Xor(a, b) => ("^".to_owned(), vec![b, a]),
                // Replaced by bits before.
                Shape::Within(..) => ("1".to_owned(), vec![]),
            };
            words.push(word);
            open.extend(operands);
        }
    }
}

/// How many bits a variable has.
fn bits(domain: &Domain) -> u32 {
    u64::BITS - (domain.size() - 1).leading_zeros()
}
