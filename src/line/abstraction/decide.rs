//! Whether a claim holds of all places together, with one look at what can be reached: the quick answer that `check` gives.
//!
//! The table of what rests on what is the business of [`crate::algebra::proof::prove`]; it asks these questions again and again
//! with formulas left away.

use super::{Abstraction, Unfit};
use crate::algebra::proof::Broken;
use crate::algebra::system::{FormulaRef, Half, formulas, list, rule};
use crate::contract::line::Line;
use crate::game::{Limit, Limits, Rule, RuleKind, Runs, Slip, Wanted};
use crate::gr1::Expr;

/// A formula of the goal that does not hold, and a run that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Open {
    /// The formula of the claim's goal.
    pub what: FormulaRef,
    /// The run.
    pub why: Broken,
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Verdict {
    /// What does not hold. Where something is wrong with safety, nothing is asked of what comes in the end.
    pub open: Vec<Open>,
    /// What was not decided: only justice, for safety is decided or else there is no verdict.
    pub undecided: Vec<FormulaRef>,
    /// What is open was found where parts may move late, and whether it is so when they move at once was not decided.
    pub late: bool,
}

impl Verdict {
    /// Whether the whole claim holds.
    pub fn holds(&self) -> bool {
        self.open.is_empty() && self.undecided.is_empty()
    }
}

/// The rules of a line: what all places guarantee, and what is given. Rules of the goal come after them.
fn rules(abstraction: &Abstraction) -> Vec<Rule> {
    let sides = abstraction.system.parts.iter().map(|p| &p.guarantees);
    let sides = sides.chain([&abstraction.claim.given, &abstraction.claim.goal]);
    sides
        .flat_map(formulas)
        .map(|(kind, _, f)| rule(kind, &f.expr))
        .collect()
}

/// Decides whether a line is sound, and gives the abstraction that shows it. What comes in the end, and what holds where parts move at once,
/// is only asked of lines with at most so many variables; of larger ones it stays undecided.
///
/// # Errors
/// The reason why it was not decided.
pub fn examine(
    line: &Line,
    limits: &Limits,
    most_variables: usize,
) -> Result<(Abstraction, Verdict), Unfit> {
    let is_small = |a: &Abstraction| a.system.variables.len() <= most_variables;
    let asked = |abstraction: &Abstraction| {
        let mut verdict = safety(abstraction, limits)?;
        if verdict.open.is_empty() && is_small(abstraction) {
            justice(abstraction, limits, &mut verdict);
        } else if verdict.open.is_empty() {
            let goals = formulas(&abstraction.claim.goal);
            let justice = goals.filter(|(kind, ..)| *kind == RuleKind::Justice);
            verdict
                .undecided
                .extend(justice.map(|(kind, index, _)| at(kind, index)));
        }
        Ok(verdict)
    };
    let loose = Abstraction::of(line)?;
    let mut verdict = asked(&loose).map_err(|limit: Limit| Unfit(limit.to_string()))?;
    if verdict.open.is_empty() {
        return Ok((loose, verdict));
    }
    let strict = Abstraction::at_once(line)?;
    if is_small(&strict)
        && let Ok(verdict) = asked(&strict)
    {
        return Ok((strict, verdict));
    }
    verdict.late = true;
    Ok((loose, verdict))
}

/// Decides the claim of one abstraction.
///
/// # Errors
/// When a limit was reached.
pub fn decide(abstraction: &Abstraction, limits: &Limits) -> Result<Verdict, Limit> {
    let mut verdict = safety(abstraction, limits)?;
    if verdict.open.is_empty() {
        justice(abstraction, limits, &mut verdict);
    }
    Ok(verdict)
}

/// A formula of the goal.
fn at(kind: RuleKind, index: usize) -> FormulaRef {
    FormulaRef {
        part: None,
        half: Half::Guarantees,
        kind,
        index,
    }
}

/// The rules, those of them that hold throughout, those that are met again and again, and where the goal's begin.
fn asked(abstraction: &Abstraction) -> (Vec<Rule>, Vec<usize>, Vec<usize>, usize) {
    let rules = rules(abstraction);
    let first_goal = rules.len() - abstraction.claim.goal.all().count();
    let (again, keep) = (0..first_goal).partition(|r: &usize| rules[*r].kind == RuleKind::Justice);
    (rules, keep, again, first_goal)
}

fn safety(abstraction: &Abstraction, limits: &Limits) -> Result<Verdict, Limit> {
    let (rules, keep, _, first_goal) = asked(abstraction);
    let mut runs = Runs::new(&abstraction.system.variables, rules, limits)?;
    let mut verdict = Verdict::default();
    for (place, (kind, index, _)) in formulas(&abstraction.claim.goal).enumerate() {
        if kind == RuleKind::Justice {
            continue;
        }
        let slip = Slip {
            before: keep.clone(),
            last: keep.clone(),
            broken: first_goal + place,
        };
        verdict.open.extend(runs.step(&slip)?.map(|trace| Open {
            what: at(kind, index),
            why: Broken::Trace(trace),
        }));
    }
    Ok(verdict)
}

fn justice(abstraction: &Abstraction, limits: &Limits, verdict: &mut Verdict) {
    let (rules, keep, again, first_goal) = asked(abstraction);
    let mut runs = Runs::new(&abstraction.system.variables, rules.clone(), limits);
    for (place, (kind, index, formula)) in formulas(&abstraction.claim.goal).enumerate() {
        if kind != RuleKind::Justice {
            continue;
        }
        let wanted = Wanted {
            keep: keep.clone(),
            again: nearest_first(abstraction, &again, &rules, &formula.expr),
            never_again: vec![first_goal + place],
        };
        match runs.as_mut().map(|runs| runs.lasso(&wanted)) {
            Ok(Ok(None)) => {}
            Ok(Ok(Some(lasso))) => verdict.open.push(Open {
                what: at(kind, index),
                why: Broken::Lasso(lasso),
            }),
            Ok(Err(_)) | Err(_) => verdict.undecided.push(at(kind, index)),
        }
    }
}

/// Justice in the order in which it is likely to matter for a goal: that of its own place, of those that parts go to from there, of
/// those before them. A run that starves one place mostly does so by one nearby, and where no run is left the rest is not looked at.
fn nearest_first(
    abstraction: &Abstraction,
    again: &[usize],
    rules: &[Rule],
    goal: &Expr,
) -> Vec<usize> {
    let shape = &abstraction.shape;
    let owner = |expr: &Expr| {
        let mut found = None;
        expr.for_each_var(&mut |v, _| found = found.or_else(|| abstraction.system.driver(v)));
        found
    };
    let mut order: Vec<usize> = owner(goal).into_iter().collect();
    let mut next = 0;
    while let Some(&place) = order.get(next) {
        next += 1;
        let around = shape
            .after(place)
            .into_iter()
            .chain(shape.places[place].from.iter().copied());
        for other in around {
            if !order.contains(&other) {
                order.push(other);
            }
        }
    }
    let distance = |rule: &usize| {
        let place = owner(&rules[*rule].expr);
        place
            .and_then(|p| order.iter().position(|o| *o == p))
            .unwrap_or(usize::MAX)
    };
    let mut sorted = again.to_vec();
    sorted.sort_by_key(distance);
    sorted
}

impl Abstraction {
    /// The formula of the goal that is pointed at.
    pub fn goal(&self, at: FormulaRef) -> &crate::gr1::Formula {
        &list(&self.claim.goal, at.kind)[at.index]
    }
}
