//! Writes specifications in the formats of other tools.
//!
//! Formulas that a format cannot express are decomposed: into [`gates`] over tests of single
//! variables for formats without arithmetic, and into [`bits`] for formats without numbers. Where
//! the game differs, [`lower`](super::lower) introduces helper variables.

mod bits;
mod gates;
mod slugsin;
mod spc;
mod spectra;
mod text;
mod tlsf;

pub(super) use gates::is_truth;

use super::Format;
use super::names::one_line;
use gates::{Gate, Gates, TooManyCases};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{Domain, Expr, Formula, FormulaKind, Owner, Specification, Variable};
use linewright_core::rename::renamed;

/// Output formats of [`write`](fn@write).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    /// gr1c's `.spc`.
    Spc,
    /// slugs' `.slugsin`.
    Slugsin,
    /// The Spectra language.
    Spectra,
    /// TLSF, the format of LTL synthesis, with strict semantics.
    Tlsf,
}

/// An assumption or guarantee as a statement of a file in this format, such as
/// `asm G (a -> !next(b));`.
///
/// `name` is the label of the statement. Returns `None` for formats other than Spectra's, if the
/// format cannot express the formula, or if the formula mentions a variable that the file does not
/// declare.
pub fn statement(
    format: Format,
    specification: &Specification,
    side: Owner,
    name: Option<&str>,
    kind: FormulaKind,
    expr: &Expr,
) -> Option<String> {
    match format {
        Format::Spectra => spectra::statement(specification, side, name, kind, expr),
        _ => None,
    }
}

/// Writes a specification in another tool's format. That tool comes to the same verdict.
///
/// Features that the format lacks are expressed with helper variables.
///
/// # Errors
/// One finding for each formula that has too many cases for the format.
pub fn write(specification: &Specification, target: Target) -> Result<String, Vec<Diagnostic>> {
    match target {
        Target::Spc => spc::write(specification),
        Target::Slugsin => slugsin::write(specification),
        Target::Spectra => spectra::write(specification),
        Target::Tlsf => tlsf::write(specification),
    }
}

/// State that all writers share.
struct Writing<'s> {
    /// The specification to write, lowered to the features of the format.
    specification: &'s Specification,
    /// Names of the variables in the format.
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

    /// The gate of `expr`, the lowered form of `formula`. If there are too many cases, reports this
    /// and returns `None`.
    fn gate(&mut self, formula: &Formula, expr: &Expr) -> Option<Gate> {
        let gate = self.gates.formula(self.specification, expr);
        self.unless_too_many(formula, gate)
    }

    /// The gate, if its tree has at most `size` gates, for formats that cannot share gates.
    /// Otherwise reports too many cases and returns `None`.
    fn check_size(&mut self, formula: &Formula, gate: Gate, size: u64) -> Option<Gate> {
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

    /// Returns the text, or the findings if there are any.
    fn finish(self, text: String) -> Result<String, Vec<Diagnostic>> {
        if self.findings.is_empty() {
            Ok(text)
        } else {
            Err(self.findings)
        }
    }
}

/// For each variable, a unique name that the format allows.
fn names_of(specification: &Specification, is_allowed: impl Fn(&str) -> bool) -> Vec<String> {
    let wanted = specification.variables.iter().map(|v| v.name.as_str());
    renamed(wanted, "v_", is_allowed)
}

/// Whether a name has only ASCII letters, digits, `_` and `others`, begins with a letter or `_`,
/// and is not among `words`.
fn is_plain(name: &str, others: &str, words: &[&str]) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || others.contains(c);
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(fits)
        && !words.contains(&name)
}

/// A comment about a variable: its original name, its labels, and the value that 0 represents.
///
/// `from_zero` is whether the format counts the values of numbers from 0. `None` if no comment is
/// needed.
fn variable_comment(variable: &Variable, name: &str, from_zero: bool) -> Option<String> {
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
    // Helper variables have no source location.
    if variable.internal && variable.span == linewright_core::source::Span::default() {
        parts.push("a helper".to_owned());
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// The comments of all variables, one per line.
fn legend(specification: &Specification, names: &[String], from_zero: bool) -> String {
    let variables = specification.variables.iter().zip(names);
    let lines = variables
        .filter_map(|(v, n)| Some(format!("# {n}: {}\n", variable_comment(v, n, from_zero)?)));
    lines.collect()
}
