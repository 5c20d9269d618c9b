//! Writes `.slugsin`, for slugs.
//!
//! The format has Boolean variables only. A number becomes bits that hold the distance from its
//! smallest value. As in slugs' translator, `x@0.low.high` is the lowest bit, and `x@1`, ... are
//! the others; additional lines exclude bit patterns outside the domain. Subformulas that are used
//! more than once become cells of a memory buffer, so that the text grows with the number of
//! gates. The format has no Moore timing and no invariants; see [`lower`].

use super::super::lower;
use super::super::structured::WORDS;
use super::bits::{has_holes, width};
use super::gates::{Gate, Shape};
use super::one_line;
use super::{Writing, is_plain, legend, names_of};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{Domain, Owner, Side, Specification, Time, VarId};
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let lowered = lower::to_mealy(&lower::without_invariants(specification));
    let names = names_of(&lowered, is_name);
    let base = Writing::new(&lowered, &names);
    let mut writer = Writer { base };
    let text = writer.file();
    writer.base.finish(text)
}

/// Whether slugs' own tools accept the name.
fn is_name(name: &str) -> bool {
    is_plain(name, ".", &WORDS)
}

struct Writer<'s> {
    base: Writing<'s>,
}

impl Writer<'_> {
    fn file(&mut self) -> String {
        let specification = self.base.specification;
        let mut text = format!("# {}\n", one_line(&specification.name));
        text.push_str(&legend(specification, self.base.names, false));
        for (head, owner) in [("INPUT", Owner::Environment), ("OUTPUT", Owner::System)] {
            let _ = writeln!(text, "\n[{head}]");
            for (index, variable) in specification.variables.iter().enumerate() {
                if variable.owner == owner {
                    for k in 0..width(&variable.domain) {
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
                let _ = writeln!(text, "# {}", one_line(&formula.name));
                if let Some(gate) = self.base.gate(formula, &formula.expr) {
                    let gate = self.base.gates.in_bits(self.base.specification, gate);
                    let _ = writeln!(text, "{}", self.line(gate));
                }
            }
            if let Some(time) = time {
                self.domains(owner, time, text);
            }
        }
    }

    /// Writes lines that exclude bit patterns outside the domains.
    fn domains(&mut self, owner: Owner, time: Time, text: &mut String) {
        for (index, variable) in self.base.specification.variables.iter().enumerate() {
            let domain = &variable.domain;
            if variable.owner == owner && has_holes(domain) {
                let (name, size) = (&self.base.names[index], domain.size());
                let _ = writeln!(text, "# {name} has {size} values");
                let gate = self.base.gates.in_domain(domain, VarId(index as u32), time);
                let _ = writeln!(text, "{}", self.line(gate));
            }
        }
    }

    fn bit_name(&self, v: VarId, k: u32) -> String {
        let name = &self.base.names[v.index()];
        match &self.base.specification.variable(v).domain {
            Domain::Bool => name.clone(),
            domain if k == 0 => format!("{name}@0.{}.{}", domain.low(), domain.high()),
            _ => format!("{name}@{k}"),
        }
    }

    /// The line of a gate. Shared gates become cells of a buffer, and the gate itself is its last
    /// cell.
    fn line(&self, root: Gate) -> String {
        let uses = self.base.gates.uses(root);
        let shared = |gate: Gate| {
            uses.get(&gate).is_some_and(|n| *n > 1)
                && matches!(
                    self.base.gates.shape(gate),
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
            let (word, operands) = match self.base.gates.shape(gate) {
                Shape::Const(value) => (u8::from(value).to_string(), vec![]),
                Shape::Bit(v, time, k) => {
                    let prime = if time == Time::Next { "'" } else { "" };
                    (self.bit_name(v, k) + prime, vec![])
                }
                Shape::Not(a) => ("!".to_owned(), vec![a]),
                Shape::And(a, b) => ("&".to_owned(), vec![b, a]),
                Shape::Or(a, b) => ("|".to_owned(), vec![b, a]),
                Shape::Xor(a, b) => ("^".to_owned(), vec![b, a]),
                // Unreachable: `in_bits` has replaced these tests.
                Shape::Within(..) => ("1".to_owned(), vec![]),
            };
            words.push(word);
            open.extend(operands);
        }
    }
}
