//! LW113: two variables of a contract that look like two names for one thing (`desired` and
//! `desired_angle`).
//!
//! Names that share words are common and usually fine: `turn` and `turn_done`, `part` and
//! `part_ok`, `low` and `low_limit`. So three conditions have to be met for a finding. The two have
//! the same side and type. The additional words of one only give the kind of thing (`_angle`,
//! `_value`, `_cmd`), or one abbreviates the other. And they are not used together: no formula
//! mentions one of them, or each formula mentions only one of the two, although someone who knew
//! both would add the distinguishing word.

use super::mentions::Mentions;
use linewright_core::diagnostics::{Diagnostic, codes, related, words};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{Contract, ContractItem, Domain, DomainKind, Name, Ownership};

/// Words that only give the kind of thing a name is for.
const KINDS: &[&str] = &[
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
/// Such words for any type, including truth values.
const MERE: &[&str] = &[
    "bit", "flag", "input", "output", "sig", "signal", "state", "status", "val", "value", "var",
    "variable",
];

/// Maximum number of variables whose names are compared: more are probably generated, and the
/// number of pairs grows with the square.
const MOST_VARIABLES: usize = 1_000;

struct Variable<'a> {
    name: &'a Name,
    words: Vec<String>,
    ownership: Ownership,
    domain: &'a Domain,
}

/// Finds the pairs of a contract, each reported at the unused name, or at the later one. `idle`
/// tells which names are certainly unused.
pub(super) fn find(
    contract: &Contract,
    sources: &SourceMap,
    idle: impl Fn(&Name) -> bool,
) -> Vec<Diagnostic> {
    let mut variables: Vec<Variable<'_>> = Vec::new();
    let mut formulas: Vec<Mentions<'_>> = Vec::new();
    // Which formulas use a definition is not tracked.
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
    if variables.len() > MOST_VARIABLES {
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
                || !one_thing(first, second)
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
            let (first_idle, second_idle) = (idle(first.name), idle(second.name));
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
    // A third name for the same thing adds nothing.
    let mut told: Vec<Option<Span>> = Vec::new();
    findings.retain(|f| {
        let new = !told.contains(&f.span);
        told.push(f.span);
        new
    });
    findings
}

fn one_thing(a: &Variable<'_>, b: &Variable<'_>) -> bool {
    let truth = matches!(&a.domain.kind, DomainKind::Named(n) if n.text == "bool");
    let other = a.name.text != b.name.text;
    let kin = other.then(|| related(&a.words, &b.words)).flatten();
    kin.is_some_and(|kin| {
        let mere = |w: &String| {
            let w = w.as_str();
            MERE.contains(&w) || !truth && KINDS.contains(&w)
        };
        kin.words.iter().all(mere)
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
        .with_label(other.span, "the other one")
        .with_help(format!(
            "if they are one, drop `{}` and write `{}` everywhere; if not, give one a name that says what sets it apart",
            at.text, other.text
        ))
}
