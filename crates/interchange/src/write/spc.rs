//! Writes `.spc`, for gr1c.
//!
//! A number `low..high` becomes `[0,high-low]`, with its comparisons shifted; enumerations are
//! numbered. gr1c only compares a variable with a number and has no arithmetic, so formulas are
//! expanded by [`gates`](super::gates). The format has no Moore timing, no invariants, no primed
//! goals, and no initial conditions of the system that refer to inputs; see [`lower`].

use super::super::lower;
use super::gates::Shape;
use super::one_line;
use super::text::{Piece, Rank, Words};
use super::{Writing, is_plain, legend, names_of};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{Domain, Formula, Owner, Side, Specification, Time};
use std::fmt::Write as _;

const WORDS: Words = Words {
    truth: ["False", "True"],
    not: "!",
    and: "&",
    or: "|",
    iff: "<->",
};

/// Maximum number of gates of an expanded formula.
const MAX_SIZE: u64 = 1 << 18;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    let lowered = lower::to_mealy(&lower::without_invariants(specification));
    let lowered = lower::initial_to_transitions(&lower::goals_to_states(&lowered));
    let names = names_of(&lowered, is_name);
    let base = Writing::new(&lowered, &names);
    let mut writer = Writer { base };
    let text = writer.file();
    writer.base.finish(text)
}

fn is_name(name: &str) -> bool {
    const WORDS: [&str; 10] = [
        "True", "False", "ENV", "SYS", "ENVINIT", "ENVTRANS", "ENVGOAL", "SYSINIT", "SYSTRANS",
        "SYSGOAL",
    ];
    is_plain(name, ".", &WORDS)
}

struct Writer<'s> {
    base: Writing<'s>,
}

impl Writer<'_> {
    fn file(&mut self) -> String {
        let mut text = format!("# {}\n", one_line(&self.base.specification.name));
        text.push_str(&legend(self.base.specification, self.base.names, true));
        text.push('\n');
        for (head, owner) in [("ENV", Owner::Environment), ("SYS", Owner::System)] {
            let _ = write!(text, "{head}:");
            for (variable, name) in self
                .base
                .specification
                .variables
                .iter()
                .zip(self.base.names)
            {
                if variable.owner == owner {
                    let _ = write!(text, " {name}");
                    if variable.domain != Domain::Bool {
                        let _ = write!(text, " [0,{}]", variable.domain.size() - 1);
                    }
                }
            }
            // gr1c requires at least one variable.
            if owner == Owner::System && self.base.specification.variables.is_empty() {
                text.push_str(" unused");
            }
            text.push_str(";\n");
        }
        let specification = self.base.specification;
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
                let name = one_line(&formula.name);
                let _ = write!(text, "\n  {sign} {operator}({body})  # {name}");
            }
            text.push_str(if formulas.is_empty() { ";\n" } else { "\n;\n" });
        }
    }

    fn formula(&mut self, formula: &Formula) -> String {
        let gate = self
            .base
            .gate(formula, &formula.expr)
            .and_then(|g| self.base.check_size(formula, g, MAX_SIZE));
        let text = gate.map(|g| WORDS.gate(&self.base.gates, g, &|shape| self.test(shape)).1);
        text.unwrap_or_default()
    }

    fn test(&self, shape: Shape) -> Piece {
        let Shape::Within(v, time, low, high) = shape else {
            return WORDS.truth(true);
        };
        let domain = &self.base.specification.variable(v).domain;
        let name = match time {
            Time::Now => self.base.names[v.index()].clone(),
            Time::Next => format!("{}'", self.base.names[v.index()]),
        };
        if *domain == Domain::Bool {
            let name = (Rank::Tight, name);
            return if high == 1 { name } else { WORDS.not(name) };
        }
        let (bottom, top) = (domain.low(), domain.high());
        let relation = |sign: &str, value: i64| {
            let text = format!("({name} {sign} {})", value - bottom);
            (Rank::Tight, text)
        };
        if low == high {
            return relation("=", low);
        }
        let above = (low > bottom).then(|| relation(">=", low));
        let below = (high < top).then(|| relation("<=", high));
        WORDS.all(above.into_iter().chain(below).collect())
    }
}
