//! Specifications written in the formats that other tools read.
//!
//! What a format has no words for is taken apart on the way: into [`gates`] over tests of single
//! variables where it has no arithmetic, into [`bits`] where it has no numbers, and into helper
//! variables by [`lower`](super::lower) where its game is another one.

mod bits;
mod gates;
mod slugsin;
mod spc;
mod spectra;
mod text;
mod tlsf;

pub(super) use gates::is_truth;

use super::names::one_line;
use super::rename::renamed;
use gates::{Gate, Gates, TooManyCases};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{Domain, Expr, Formula, Specification, Variable};

/// The formats that [`write`](fn@write) knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    /// gr1c's.
    Spc,
    /// slugs'.
    Slugsin,
    /// Spectra's.
    Spectra,
    /// That of LTL synthesis, with strict semantics.
    Tlsf,
}

/// Writes a specification in another tool's format, so that this tool gives the same verdict. What
/// the format cannot say is lowered with helper variables, or refused in the findings.
pub fn write(specification: &Specification, target: Target) -> Result<String, Vec<Diagnostic>> {
    match target {
        Target::Spc => spc::write(specification),
        Target::Slugsin => slugsin::write(specification),
        Target::Spectra => spectra::write(specification),
        Target::Tlsf => tlsf::write(specification),
    }
}

/// What every writer has at hand.
struct Writing<'s> {
    /// What is written, lowered to what the format can say.
    specification: &'s Specification,
    /// The names of its variables in the format.
    names: &'s [String],
    gates: Gates,
    findings: Vec<Diagnostic>,
}

impl<'s> Writing<'s> {
    fn new(specification: &'s Specification, names: &'s [String]) -> Self {
        Self {
            specification,
            names,
            gates: Gates::default(),
            findings: Vec::new(),
        }
    }

    /// The gate of a formula that the format says in the words of `expr`; a finding if that takes
    /// too many cases.
    fn gate(&mut self, formula: &Formula, expr: &Expr) -> Option<Gate> {
        let gate = self.gates.formula(self.specification, expr);
        self.unless_too_many(formula, gate)
    }

    /// The same, for a format that writes each use of a gate out; at most `size` gates.
    fn written_out(&mut self, formula: &Formula, gate: Gate, size: u64) -> Option<Gate> {
        let fits = self.gates.tree_size(gate) <= size;
        self.unless_too_many(formula, fits.then_some(gate).ok_or(TooManyCases))
    }

    fn unless_too_many<T>(
        &mut self,
        formula: &Formula,
        result: Result<T, TooManyCases>,
    ) -> Option<T> {
        if result.is_err() {
            self.findings.push(TooManyCases::finding(formula));
        }
        result.ok()
    }

    /// The text, unless something could not be said.
    fn finish(self, text: String) -> Result<String, Vec<Diagnostic>> {
        if self.findings.is_empty() {
            Ok(text)
        } else {
            Err(self.findings)
        }
    }
}

/// Names of all variables that the format takes.
fn names_of(specification: &Specification, takes: impl Fn(&str) -> bool) -> Vec<String> {
    let wanted = specification.variables.iter().map(|v| v.name.as_str());
    renamed(wanted, "v_", takes)
}

/// Whether a name has only letters, digits and `others`, begins with none but a letter or `_`, and
/// is none of the format's words.
fn is_plain(name: &str, others: &str, words: &[&str]) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || others.contains(c);
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(fits)
        && !words.contains(&name)
}

/// What became of a variable's name, its labels and its smallest value, for a comment. `from_zero`
/// tells that numbers are counted from 0.
fn about(variable: &Variable, name: &str, from_zero: bool) -> Option<String> {
    let mut parts = Vec::new();
    if *name != variable.name {
        parts.push(format!("was {}", one_line(&variable.name)));
    }
    match &variable.domain {
        Domain::Enum { labels, .. } => {
            let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
            parts.push(labels.collect::<Vec<_>>().join(", "));
        }
        Domain::Range { low, .. } if *low != 0 && from_zero => {
            parts.push(format!("0 stands for {low}"));
        }
        _ => {}
    }
    // Helpers are in no file.
    if variable.internal && variable.span == linewright_core::source::Span::default() {
        parts.push("a helper".to_owned());
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// The same as lines of comments.
fn legend(specification: &Specification, names: &[String], from_zero: bool) -> String {
    let variables = specification.variables.iter().zip(names);
    let lines =
        variables.filter_map(|(v, n)| Some(format!("# {n}: {}\n", about(v, n, from_zero)?)));
    lines.collect()
}
