//! Reads `.tlsf` files: the Temporal Logic Synthesis Format, basic and full.
//!
//! Sources: Jacobs, Klein and Schirmer, "A High-Level LTL Synthesis Format: TLSF v1.1", SYNT 2016;
//! for runs that end, which are refused, Jacobs, Pérez and Schlehuber-Caissier, "The Temporal Logic
//! Synthesis Format TLSF v1.2", 2023.
//!
//! ```text
//! text ─lexer→ words ─parser→ ast::File ─expand→ ltl::Formulas ─normal→ parts ─classify→ pieces of GR(1) ─meaning→ Specification
//! ```
//!
//! The format is that of LTL synthesis, so not every file is one of GR(1): what is left over after
//! the equivalences of [`normal`], [`long_run`] and [`classify`] is refused, at the smallest part
//! that has none. A bus becomes a Boolean variable an element, `HBURST[0]`.
//!
//! The parser bounds the nesting of expressions, the expansion its depth, its steps and the size of
//! what it makes. Definitions may call themselves thousands of times, so all of it runs on a stack
//! of its own.

mod assemble;
mod ast;
mod automaton;
mod beginning;
mod classify;
mod declare;
mod definition;
mod expand;
mod expression;
mod found;
mod info;
mod lexer;
mod long_run;
mod ltl;
mod meaning;
mod normal;
mod operators;
mod pairs;
mod parser;
mod parts;
mod past;
mod refusal;
mod report;
mod target;
mod value;

use ast::File;
use classify::Classifier;
use expand::Expander;
use found::Conjunct;
use linewright_core::diagnostics::{Diagnostic, codes, has_errors};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::monitors::Monitors;
use linewright_core::gr1::{Side, Specification, Timing, VarId};
use linewright_core::source::FileId;
use meaning::Meaning;
pub(super) use operators::is_reserved;
use report::Report;
use std::collections::BTreeMap;

/// What was read: the specification, and where some of its assumptions are not the file's own, what
/// it is with only those.
type Read = (Specification, Option<Specification>);

fn empty(name: &str) -> Specification {
    Specification {
        name: name.to_owned(),
        timing: Timing::Mealy,
        variables: Vec::new(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

/// Reads a text. What could not be understood is in the findings.
pub(super) fn read(name: &str, file: FileId, text: &str) -> (Read, Vec<Diagnostic>) {
    let mut report = Report::new(file);
    let tokens = lexer::words(text, &mut report);
    let tree = parser::Parser::new(text, &tokens, &mut report).file();
    if tree.finite {
        // Its operators are others, `X[!]` among them.
        report.findings.retain(|f| f.code == codes::NOT_GR1);
    }
    if has_errors(&report.findings) {
        return ((empty(name), None), report.findings);
    }
    let specification = lower_file(name, &tree, text, &mut report);
    (
        specification.unwrap_or_else(|| (empty(name), None)),
        report.findings,
    )
}

/// What the file says; `None` where that was reported.
fn lower_file(name: &str, file: &File, text: &str, report: &mut Report) -> Option<Read> {
    let Some(semantics) = file.semantics else {
        report.syntax(
            0..0,
            "INFO does not say which semantics is meant",
            "write `SEMANTICS: Mealy`, or Moore, or one of them with `,Strict` behind it",
        );
        return None;
    };
    let globals = declare::declared(file, report);
    let mut expander = Expander::new(globals, report);
    let variables = declare::signals(file, &mut expander)?;
    let mut wishes = declare::domains(file, &mut expander);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in &file.entries {
        let count = counts.entry(&entry.heading).or_default();
        *count += 1;
        if let Ok(formula) = expander.formula(&entry.tree) {
            wishes.push(Conjunct {
                section: entry.section,
                name: format!("{} {count}", entry.heading),
                heading: entry.place.clone(),
                formula,
            });
        }
        if expander.formulas.too_large {
            let range = entry.tree.range.clone();
            expander.report.error(
                codes::TOO_LARGE,
                range,
                "this formula becomes too large once its definitions are written out",
                "give the parameters smaller values, or split it",
            );
            return None;
        }
    }
    let Expander {
        mut formulas,
        sites,
        report,
        ..
    } = expander;
    if has_errors(&report.findings) {
        return None;
    }
    let moore = file.target.unwrap_or(semantics.moore);
    let wishes = target::moved(wishes, &mut formulas, semantics, moore, &variables);
    // The variable for broken promises appears between signals and monitors.
    let broken = VarId(variables.len() as u32);
    let first = VarId(broken.0 + 1);
    let names = variables.iter().map(|v| v.name.clone());
    let monitors = Monitors::new(first, names);
    let mut classifier = Classifier::new(&mut formulas, monitors, first.0, broken);
    let timing = if moore { Timing::Moore } else { Timing::Mealy };
    let sides = Meaning {
        classifier: &mut classifier,
        report,
        sites: &sites,
        text,
        variables: &variables,
        timing,
        strict: semantics.strict,
        kept_anyway: false,
    }
    .sides(wishes);
    if has_errors(&report.findings) {
        return None;
    }
    let span = report.span(&(0..0));
    let (specification, own) =
        assemble::specifications(name, timing, variables, sides, &classifier, span);
    bounded(&specification, report).then_some((specification, own))
}

/// Later stages walk formulas by recursion and bound their numbers.
fn bounded(specification: &Specification, report: &mut Report) -> bool {
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut fine = true;
    for formula in sides.into_iter().flat_map(Side::all) {
        let domain = |v: VarId| Interval::of(&specification.variable(v).domain);
        if depth(&formula.expr) > super::terms::MAX_DEPTH
            || interval(&formula.expr, &domain).is_err()
        {
            let finding = Diagnostic::error(
                codes::TOO_LARGE,
                formula.span,
                "this formula nests too deep",
            )
            .with_help("give parts of it outputs of their own");
            report.push(finding);
            fine = false;
        }
    }
    fine
}

/// The recursion is as deep as the expression, on this reader's stack.
fn depth(e: &linewright_core::gr1::Expr) -> u32 {
    use linewright_core::gr1::Expr;
    1 + match e {
        Expr::Const(_) | Expr::Var(..) => 0,
        Expr::Unary(_, a) => depth(a),
        Expr::Binary(_, a, b) => depth(a).max(depth(b)),
        Expr::If(c, a, b) => depth(c).max(depth(a)).max(depth(b)),
    }
}
