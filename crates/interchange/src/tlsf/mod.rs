//! Reads `.tlsf` files: the Temporal Logic Synthesis Format, basic and full.
//!
//! Sources: Jacobs, Klein and Schirmer, "A High-Level LTL Synthesis Format: TLSF v1.1", SYNT 2016;
//! for runs that end, which are refused, Jacobs, Pérez and Schlehuber-Caissier, "The Temporal Logic
//! Synthesis Format TLSF v1.2", 2023.
//!
//! ```text
//! text ─lexer→ tokens ─parser→ ast::File ─expand→ ltl::Formulas ─normal→ parts
//!      ─classify→ pieces of GR(1) ─meaning→ Specification
//! ```
//!
//! The format covers all of LTL, so not every file is in GR(1). A formula that the equivalences of
//! [`normal`], [`long_run`] and [`classify`] do not turn into GR(1) is refused, and the finding
//! points to the smallest part without an equivalent. Each element of a bus becomes a Boolean
//! variable, such as `HBURST[0]`.
//!
//! The parser limits the nesting of expressions. The expansion limits its depth, its steps and the
//! size of the formulas. Definitions can recurse thousands of times, so the reader runs on a large
//! stack of its own.

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

/// The specification, and a copy with only the file's own assumptions; `None` if there are no
/// others.
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

/// Reads a text. After an error, which is in the findings, the specification is empty.
pub(super) fn read(name: &str, file: FileId, text: &str) -> (Read, Vec<Diagnostic>) {
    let mut report = Report::new(file);
    let tokens = lexer::words(text, &mut report);
    let tree = parser::Parser::new(text, &tokens, &mut report).file();
    if tree.finite {
        // Drop syntax errors, because operators of finite runs, such as `X[!]`, can cause them.
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

/// Lowers a parsed file; `None` after an error, which is reported.
fn lower_file(name: &str, file: &File, text: &str, report: &mut Report) -> Option<Read> {
    let Some(semantics) = file.semantics else {
        report.syntax(
            0..0,
            "INFO does not state the semantics",
            "write `SEMANTICS: Mealy` or `SEMANTICS: Moore`, optionally followed by `,Strict`",
        );
        return None;
    };
    let globals = declare::globals(file, report);
    let mut expander = Expander::new(globals, report);
    let variables = declare::signals(file, &mut expander)?;
    let mut conjuncts = declare::enumeration_formulas(file, &mut expander);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in &file.entries {
        let count = counts.entry(&entry.heading).or_default();
        *count += 1;
        if let Ok(formula) = expander.formula(&entry.tree) {
            conjuncts.push(Conjunct {
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
                "this formula becomes too large after its definitions are expanded",
                "give the parameters smaller values, or split the formula",
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
    let conjuncts = target::adapted(conjuncts, &mut formulas, semantics, moore, &variables);
    // The variable for broken guarantees is between signals and monitors.
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
        moved_to_preset: false,
    }
    .sides(conjuncts);
    if has_errors(&report.findings) {
        return None;
    }
    let span = report.span(&(0..0));
    let (specification, own) =
        assemble::specifications(name, timing, variables, sides, &classifier, span);
    is_within_limits(&specification, report).then_some((specification, own))
}

/// Whether all formulas are small enough for later stages, which traverse them recursively. Reports
/// each formula that is not.
fn is_within_limits(specification: &Specification, report: &mut Report) -> bool {
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut within = true;
    for formula in sides.into_iter().flat_map(Side::all) {
        let domain = |v: VarId| Interval::of(&specification.variable(v).domain);
        if depth(&formula.expr) > super::terms::MAX_DEPTH
            || interval(&formula.expr, &domain).is_err()
        {
            let finding = Diagnostic::error(
                codes::TOO_LARGE,
                formula.span,
                "this formula nests too deeply",
            )
            .with_help("introduce outputs for parts of it");
            report.push(finding);
            within = false;
        }
    }
    within
}

/// Depth of an expression. The recursion is as deep as the expression, on this reader's large
/// stack.
fn depth(e: &linewright_core::gr1::Expr) -> u32 {
    use linewright_core::gr1::Expr;
    1 + match e {
        Expr::Const(_) | Expr::Var(..) => 0,
        Expr::Unary(_, a) => depth(a),
        Expr::Binary(_, a, b) => depth(a).max(depth(b)),
        Expr::If(c, a, b) => depth(c).max(depth(a)).max(depth(b)),
    }
}
