//! Finds the rules that forbid a move, and formats them as written in the contract.

use super::legal::{EnumerationLimit, Moves, Rule, Values};
use super::values::listed;
use linewright_core::gr1::{Expr, Formula, Owner, Specification, Time, VarId};
use linewright_core::source::SourceMap;

/// Formats rules.
#[derive(Debug, Clone, Copy)]
pub(super) struct RulePrinter<'a> {
    pub specification: &'a Specification,
    pub sources: &'a SourceMap,
}

/// Whether and why a move is not legal.
#[derive(Debug)]
pub(super) enum Verdict<'a, 'm> {
    /// Legal, for instance with these values.
    Legal(Values),
    /// Each of these rules alone forbids the move.
    Each(Vec<&'m Rule<'a>>),
    /// Only all of these rules together forbid the move; no proper subset does.
    Together(Vec<&'m Rule<'a>>),
}

/// Decides whether a move with these values is legal, and if not, which rules forbid it.
pub(super) fn verdict<'a, 'm>(
    moves: &'m Moves<'a>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    verdict_under(moves, moves.rules.iter(), fixed)
}

/// Like [`verdict`], but also applies the rules for leaving the step: decides whether another step
/// can follow the move.
pub(super) fn verdict_of_leaving<'a, 'm>(
    moves: &'m Moves<'a>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    verdict_under(moves, moves.rules.iter().chain(&moves.leaving), fixed)
}

fn verdict_under<'a, 'm>(
    moves: &'m Moves<'a>,
    rules: impl Iterator<Item = &'m Rule<'a>>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    let possible = |rules: &[&'m Rule<'a>]| -> Result<Option<Values>, EnumerationLimit> {
        moves.find_under(rules.iter().copied(), fixed)
    };
    let all: Vec<&Rule<'a>> = rules.filter(|r| r.residual != Expr::TRUE).collect();
    if let Some(values) = possible(&all)? {
        return Ok(Verdict::Legal(values));
    }
    let mut each = Vec::new();
    for rule in &all {
        if possible(&[*rule])?.is_none() {
            each.push(*rule);
        }
    }
    if !each.is_empty() {
        return Ok(Verdict::Each(each));
    }
    let mut together = all;
    let mut at = 0;
    while at < together.len() {
        let mut fewer = together.clone();
        fewer.remove(at);
        if possible(&fewer)?.is_none() {
            together = fewer;
        } else {
            at += 1;
        }
    }
    Ok(Verdict::Together(together))
}

impl<'a> RulePrinter<'a> {
    /// Lists rules, one per line, with the place and relevant values of each.
    pub fn rules(
        &self,
        rules: &[&Rule<'_>],
        before: Option<&[i64]>,
        known: &[Option<i64>],
    ) -> String {
        let mut texts: Vec<String> = Vec::new();
        for rule in rules {
            let text = self.rule(rule.formula, before, known);
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
        texts.concat()
    }

    /// Like [`RulePrinter::rules`], for rules that apply on leaving the upcoming step.
    pub fn leaving(&self, rules: &[&Rule<'_>], known: &[Option<i64>]) -> String {
        let mut texts: Vec<String> = Vec::new();
        for rule in rules {
            let mut values = Values::new();
            rule.formula.expr.for_each_var(&mut |v, time| {
                let value = known[v.index()].filter(|_| time == Time::Now);
                let pair = value.map(|value| (v, value));
                values.extend(pair.filter(|p| !values.contains(p)));
            });
            let text = self.lines(rule.formula, &[("now", values)]);
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
        texts.concat()
    }

    /// Formats a rule, `  assume held: always (a -> next a)`, with its place and relevant values.
    fn rule(&self, formula: &Formula, before: Option<&[i64]>, known: &[Option<i64>]) -> String {
        let mut now = Values::new();
        let mut given = Values::new();
        // A safety formula without next values restricts the step that is left.
        let follows = formula.expr.mentions_next() || self.is_safety(formula);
        formula.expr.for_each_var(&mut |v, time| {
            let now_is_before = follows && time == Time::Now;
            let (list, value) = match before {
                Some(before) if now_is_before => (&mut now, Some(before[v.index()])),
                _ => (&mut given, known[v.index()]),
            };
            let pair = value.map(|value| (v, value));
            list.extend(pair.filter(|p| !list.contains(p)));
        });
        self.lines(formula, &[("before", now), ("now", given)])
    }

    fn is_safety(&self, formula: &Formula) -> bool {
        let s = self.specification;
        let mut safety = s.assumptions.safety.iter().chain(&s.guarantees.safety);
        safety.any(|f| std::ptr::eq(f, formula))
    }

    fn lines(&self, formula: &Formula, relevant: &[(&str, Values)]) -> String {
        let mut line = format!("  {}\n    {}", self.title(formula), self.place(formula));
        for (word, values) in relevant {
            if !values.is_empty() {
                line = format!("{line}; {word} {}", listed(self.specification, values));
            }
        }
        line + "\n"
    }

    /// A rule as written in the source, `assume held: always (a -> next a)`; if the source does not
    /// begin like this, the rule's name and formula.
    pub fn title(&self, formula: &Formula) -> String {
        let file = self.sources.file(formula.span.file);
        let (start, end) = (
            self.sources.start(formula.span),
            self.sources.end(formula.span),
        );
        let lines = file.text.lines().skip(start.line - 1);
        let lines = lines.take(end.line - start.line + 1).map(|line| {
            let code = line.split_once("//").map_or(line, |(code, _)| code);
            code.trim()
        });
        let written = lines.collect::<Vec<_>>().join(" ");
        let name = &formula.name;
        let begins = |word: &str| written.starts_with(&format!("{word} {name}:"));
        if begins("assume") || begins("guarantee") {
            return written;
        }
        let same = |f: &Formula| std::ptr::eq(f, formula);
        let side = if self.specification.assumptions.all().any(same) {
            "assume"
        } else {
            "guarantee"
        };
        // The generated name of an unnamed rule contains its side: `guarantee 3`.
        if name.contains(' ') {
            format!("{name}: {}", formula.text)
        } else {
            format!("{side} {name}: {}", formula.text)
        }
    }

    fn place(&self, formula: &Formula) -> String {
        let file = &self.sources.file(formula.span.file).name;
        format!("{file}:{}", self.sources.start(formula.span).line)
    }

    /// Rules of a side that a complete step violates.
    pub fn broken(&self, side: Owner, before: Option<&[i64]>, step: &[i64]) -> Vec<Rule<'a>> {
        let known: Vec<Option<i64>> = step.iter().copied().map(Some).collect();
        let moves = Moves::new(self.specification, side, before, &known);
        let rules = moves.rules.into_iter();
        rules.filter(|r| r.residual == Expr::FALSE).collect()
    }
}
