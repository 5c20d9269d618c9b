//! Writes `.tlsf`, for LTL synthesis tools.
//!
//! Section by section, the format's strict semantics equals that of a strict GR(1) game, if
//! conditions on the next step are written with `X`. Therefore an invariant is written twice: for
//! step 0 under INITIALLY or PRESET, and for every next step under REQUIRE or ASSERT. A number
//! becomes a bus that holds the distance from its smallest value; another invariant excludes bit
//! patterns outside the domain.

use super::super::tlsf::is_reserved;
use super::bits::{has_holes, width};
use super::gates::{Gate, Shape};
use super::one_line;
use super::text::{Piece, Rank, Words, at_least};
use super::{Writing, is_plain, names_of, variable_comment};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use std::fmt::Write as _;

const WORDS: Words = Words {
    truth: ["false", "true"],
    not: "! ",
    and: "&&",
    or: "||",
    iff: "<->",
};

/// Maximum number of gates of an expanded formula.
const MAX_SIZE: u64 = 1 << 14;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let names = names_of(specification, is_name);
    let base = Writing::new(specification, &names);
    let mut writer = Writer { base };
    let text = writer.file();
    writer.base.finish(text)
}

fn is_name(name: &str) -> bool {
    is_plain(name, "'@", &[]) && !is_reserved(name)
}

struct Writer<'s> {
    base: Writing<'s>,
}

impl Writer<'_> {
    fn file(&mut self) -> String {
        let specification = self.base.specification;
        let kind = match specification.timing {
            Timing::Mealy => "Mealy",
            Timing::Moore => "Moore",
        };
        let title = one_line(&specification.name).replace(['"', '\\'], "'");
        let mut text = format!(
            "INFO {{\n  TITLE:       \"{title}\"\n  DESCRIPTION: \"Written by Linewright\"\n  SEMANTICS:   {kind},Strict\n  TARGET:      {kind}\n}}\n\nMAIN {{\n"
        );
        for (head, owner) in [("INPUTS", Owner::Environment), ("OUTPUTS", Owner::System)] {
            let _ = writeln!(text, "  {head} {{");
            for (variable, name) in specification.variables.iter().zip(self.base.names) {
                if variable.owner == owner {
                    let comment = variable_comment(variable, name, true)
                        .map_or_else(String::new, |a| format!(" // {a}"));
                    let _ = match width(&variable.domain) {
                        _ if variable.domain == Domain::Bool => {
                            writeln!(text, "    {name};{comment}")
                        }
                        0 => writeln!(text, "    // {name} has one value"),
                        n => writeln!(text, "    {name}[{n}];{comment}"),
                    };
                }
            }
            // The format requires at least one signal.
            let constant = |v: &Variable| v.domain.size() == 1;
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
        let formulas = side.initial.iter().chain(&side.invariants);
        let mut lines: Vec<String> = formulas.map(|f| self.line(f, Time::Now)).collect();
        lines.extend(self.domains(owner, Time::Now));
        section(initial, &lines, text);
        let formulas = side
            .invariants
            .iter()
            .map(|f| (f, Time::Next))
            .chain(side.safety.iter().map(|f| (f, Time::Now)));
        let mut lines: Vec<String> = formulas.map(|(f, from)| self.line(f, from)).collect();
        lines.extend(self.domains(owner, Time::Next));
        section(steps, &lines, text);
        let lines = side.justice.iter().map(|f| {
            let again = at_least(self.formula(f, Time::Now), Rank::Tight);
            commented(&format!("G F {again}"), &f.name)
        });
        section(justice, &lines.collect::<Vec<_>>(), text);
    }

    fn line(&mut self, formula: &Formula, from: Time) -> String {
        commented(&self.formula(formula, from).1, &formula.name)
    }

    /// The text of a formula; with `Time::Next`, next values replace current ones.
    fn formula(&mut self, formula: &Formula, from: Time) -> Piece {
        let expr = match from {
            Time::Now => formula.expr.clone(),
            Time::Next => formula.expr.substitute(&mut |v, _| Expr::next(v)),
        };
        let gate = self
            .base
            .gate(formula, &expr)
            .map(|g| self.base.gates.in_bits(self.base.specification, g))
            .and_then(|g| self.base.check_size(formula, g, MAX_SIZE));
        gate.map_or_else(|| WORDS.truth(true), |g| self.text(g))
    }

    /// Formulas that exclude bit patterns outside the domains.
    fn domains(&mut self, owner: Owner, time: Time) -> Vec<String> {
        let mut found = Vec::new();
        for (index, variable) in self.base.specification.variables.iter().enumerate() {
            if variable.owner == owner && has_holes(&variable.domain) {
                let v = VarId(index as u32);
                let gate = self.base.gates.in_domain(&variable.domain, v, time);
                let what = format!(
                    "{} has {} values",
                    self.base.names[index],
                    variable.domain.size()
                );
                found.push(commented(&self.text(gate).1, &what));
            }
        }
        found
    }

    fn text(&self, gate: Gate) -> Piece {
        WORDS.gate(&self.base.gates, gate, &|shape| match shape {
            Shape::Bit(v, time, k) => (Rank::Tight, self.bit(v, time, k)),
            // Unreachable: `in_bits` has replaced all other tests.
            _ => WORDS.truth(true),
        })
    }

    /// A bit of a number, or a Boolean variable.
    fn bit(&self, v: VarId, time: Time, k: u32) -> String {
        let name = &self.base.names[v.index()];
        let next = if time == Time::Next { "X " } else { "" };
        match self.base.specification.variable(v).domain {
            Domain::Bool => format!("{next}{name}"),
            _ => format!("{next}{name}[{k}]"),
        }
    }
}

fn commented(formula: &str, what: &str) -> String {
    format!("{formula}; // {}", one_line(what))
}

fn section(head: &str, lines: &[String], text: &mut String) {
    let _ = writeln!(text, "  {head} {{");
    for line in lines {
        let _ = writeln!(text, "    {line}");
    }
    text.push_str("  }\n");
}
