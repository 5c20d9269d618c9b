//! Finds the rules that forbid a move, in the words of the contract.

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
    /// Each of these rules alone forbids it.
    Each(Vec<&'m Rule<'a>>),
    /// No single rule forbids it, but all of these together do, and no subset of them.
    Together(Vec<&'m Rule<'a>>),
}

/// Explains why a move with these values is not legal, if so.
pub(super) fn verdict<'a, 'm>(
    moves: &'m Moves<'a>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    among(moves, moves.rules.iter(), fixed)
}

/// Like `verdict`, with the rules that apply on leaving the step: why no step can follow.
pub(super) fn verdict_of_leaving<'a, 'm>(
    moves: &'m Moves<'a>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    among(moves, moves.rules.iter().chain(&moves.leaving), fixed)
}

fn among<'a, 'm>(
    moves: &'m Moves<'a>,
    rules: impl Iterator<Item = &'m Rule<'a>>,
    fixed: &[(VarId, i64)],
) -> Result<Verdict<'a, 'm>, EnumerationLimit> {
    let possible = |rules: &[&'m Rule<'a>]| -> Result<Option<Values>, EnumerationLimit> {
        moves.find_under(rules.iter().copied(), fixed)
    };
    let all: Vec<&Rule<'a>> = rules.filter(|r| r.left != Expr::TRUE).collect();
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

    /// Like `rules`, for rules that apply on leaving the upcoming step.
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

    /// `  assume held: always (a -> next a)`, followed by its place and the relevant values.
    fn rule(&self, formula: &Formula, before: Option<&[i64]>, known: &[Option<i64>]) -> String {
        let mut now = Values::new();
        let mut given = Values::new();
        let follows = formula.expr.mentions_next();
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

    fn lines(&self, formula: &Formula, looked_at: &[(&str, Values)]) -> String {
        let mut line = format!("  {}\n    {}", self.title(formula), self.place(formula));
        for (word, values) in looked_at {
            if !values.is_empty() {
                line = format!("{line}; {word} {}", listed(self.specification, values));
            }
        }
        line + "\n"
    }

    /// A rule as its author wrote it, `assume held: always (a -> next a)`; if the source is not
    /// available, its name and formula.
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
        // A rule without a name is identified by its position: `guarantee 3`.
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
        rules.filter(|r| r.left == Expr::FALSE).collect()
    }
}
