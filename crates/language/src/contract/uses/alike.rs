//! LW113: two variables of a contract that look like two names for one thing (`desired` and
//! `desired_angle`).
//!
//! Names that share words are common and usually fine: `turn` and `turn_done`, `part` and
//! `part_ok`, `low` and `low_limit`. So three conditions have to be met for a finding:
//!
//! - Both variables are inputs, outputs or internal, and have the same type.
//! - The additional words of one name are generic (`_angle`, `_value`, `_cmd`), or one name
//!   abbreviates the other.
//! - They are not used together: no formula mentions one of them, or no formula mentions both.

use super::mentions::Mentions;
use linewright_core::diagnostics::{Diagnostic, codes, word_similarity, words};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{Contract, ContractItem, Domain, DomainKind, Name, Ownership};

/// Words for quantities; they add no information to the name of a number or label.
const QUANTITY_WORDS: &[&str] = &[
    "angle",
    "cell",
    "cmd",
    "command",
    "count",
    "distance",
    "height",
    "id",
    "index",
    "kind",
    "length",
    "level",
    "mode",
    "num",
    "number",
    "pos",
    "position",
    "pressure",
    "slot",
    "speed",
    "temperature",
    "type",
    "velocity",
    "weight",
    "width",
];
/// Words that add no information to the name of any variable.
const GENERIC_WORDS: &[&str] = &[
    "bit", "flag", "input", "output", "sig", "signal", "state", "status", "val", "value", "var",
    "variable",
];

/// Maximum number of variables whose names are compared. Contracts with more variables are not
/// checked, because they are probably generated, and the number of pairs grows quadratically.
const MAX_VARIABLES: usize = 1_000;

struct Variable<'a> {
    name: &'a Name,
    words: Vec<String>,
    ownership: Ownership,
    domain: &'a Domain,
}

/// Returns a finding for each pair of names in a contract that meets these conditions. Its position
/// is that of the unused name or, if both are used, of the later one. `is_unused` returns whether a
/// name is certainly unused.
pub(super) fn find(
    contract: &Contract,
    sources: &SourceMap,
    is_unused: impl Fn(&Name) -> bool,
) -> Vec<Diagnostic> {
    let mut variables: Vec<Variable<'_>> = Vec::new();
    let mut formulas: Vec<Mentions<'_>> = Vec::new();
    // Names in definitions and counters. They count as used together with every other name, because
    // the formulas that use these definitions and counters are not tracked.
    let mut indirect = Mentions::default();
    for item in &contract.items {
        match item {
            ContractItem::Variables {
                ownership,
                names,
                domain,
            } => variables.extend(names.iter().map(|name| Variable {
                name,
                words: words(&name.text),
                ownership: *ownership,
                domain,
            })),
            ContractItem::Formula { expr, .. } => {
                let mut mentions = Mentions::default();
                mentions.expr(expr);
                formulas.push(mentions);
            }
            ContractItem::Define(d) => indirect.expr(&d.value),
            ContractItem::Counter(c) => indirect.exprs(std::iter::once(&c.counts).chain(&c.resets)),
            _ => {}
        }
    }
    if variables.len() > MAX_VARIABLES {
        return Vec::new();
    }
    let same_type = |a: &Domain, b: &Domain| {
        let text = |d: &Domain| -> String { sources.text(d.span).split_whitespace().collect() };
        a.span == b.span || text(a) == text(b)
    };
    let mut findings = Vec::new();
    for (i, second) in variables.iter().enumerate() {
        for first in &variables[..i] {
            if first.ownership != second.ownership
                || !seem_equal(first, second)
                || !same_type(first.domain, second.domain)
            {
                continue;
            }
            let uses = |v: &Variable<'_>| formulas.iter().any(|f| f.has(&v.name.text));
            let together = || {
                let indirect = |v: &Variable<'_>| indirect.has(&v.name.text);
                let both = |f: &Mentions<'_>| f.has(&first.name.text) && f.has(&second.name.text);
                indirect(first) || indirect(second) || formulas.iter().any(both)
            };
            let (first_idle, second_idle) = (is_unused(first.name), is_unused(second.name));
            findings.extend(match (first_idle, second_idle) {
                (true, false) if uses(second) => Some(unused(first.name, second.name)),
                (false, true) if uses(first) => Some(unused(second.name, first.name)),
                (false, false) if uses(first) && uses(second) && !together() => {
                    Some(mixed(second.name, first.name))
                }
                _ => None,
            });
        }
    }
    // A name that is similar to several others is reported only once.
    let mut shown: Vec<Option<Span>> = Vec::new();
    findings.retain(|f| {
        let new = !shown.contains(&f.span);
        shown.push(f.span);
        new
    });
    findings
}

/// Returns whether two names differ only in generic words or an abbreviation.
fn seem_equal(a: &Variable<'_>, b: &Variable<'_>) -> bool {
    let truth = matches!(&a.domain.kind, DomainKind::Named(n) if n.text == "bool");
    let other = a.name.text != b.name.text;
    let similarity = other.then(|| word_similarity(&a.words, &b.words)).flatten();
    similarity.is_some_and(|similarity| {
        let is_generic = |w: &String| {
            let w = w.as_str();
            GENERIC_WORDS.contains(&w) || !truth && QUANTITY_WORDS.contains(&w)
        };
        similarity.words.iter().all(is_generic)
    })
}

fn unused(idle: &Name, used: &Name) -> Diagnostic {
    let (idle_text, used_text) = (&idle.text, &used.text);
    finding(
        idle,
        used,
        format!(
            "`{idle_text}` and `{used_text}` look like two names for one thing: no formula mentions `{idle_text}`"
        ),
    )
}

fn mixed(later: &Name, earlier: &Name) -> Diagnostic {
    let (a, b) = (&earlier.text, &later.text);
    finding(
        later,
        earlier,
        format!("`{a}` and `{b}` look like two names for one thing: no formula mentions both"),
    )
}

fn finding(at: &Name, other: &Name, message: String) -> Diagnostic {
    Diagnostic::warning(codes::NAMES_ALIKE, at.span, message)
        .with_label(other.span, "the other name")
        .with_help(format!(
            "if they mean the same, remove `{}` and write `{}` everywhere; otherwise, rename one so that the difference is clear",
            at.text, other.text
        ))
}
