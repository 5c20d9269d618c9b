//! Whether a claim holds of all places together, with one look at what can be reached: the quick answer that `check` gives.
//!
//! The table of what rests on what is the business of [`crate::algebra::proof::prove`]; it asks these questions again and again
//! with formulas left away.

use super::{Abstraction, Unfit};
use super::claim::NO_CIRCULAR_WAIT;
use crate::algebra::proof::Broken;
use crate::algebra::system::{FormulaRef, Half, formulas, list, rule};
use crate::contract::line::Line;
use crate::gr1::Expr;
use crate::game::{Limit, Limits, Rule, RuleKind, Runs, Slip, Wanted};

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
}

impl Verdict {
    /// Whether the claim holds.
    pub fn holds(&self) -> bool {
        self.open.is_empty()
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

/// Decides whether a line is sound, and gives the abstraction that shows it.
///
/// # Errors
/// The reason why it was not decided.
pub fn examine(line: &Line, limits: &Limits) -> Result<(Abstraction, Verdict), Unfit> {
    let asked = |abstraction: &Abstraction| decide(abstraction, limits).map_err(|limit| Unfit(limit.to_string()));
    let loose = Abstraction::of(line)?;
    let verdict = asked(&loose)?;
    if verdict.holds() {
        return Ok((loose, verdict));
    }
    let strict = Abstraction::at_once(line)?;
    let verdict = asked(&strict)?;
    Ok((strict, verdict))
}

/// Decides the claim of one abstraction.
///
/// # Errors
/// When a limit was reached.
pub fn decide(abstraction: &Abstraction, limits: &Limits) -> Result<Verdict, Limit> {
    let goal = &abstraction.claim.goal;
    let rules = rules(abstraction);
    let first_goal = rules.len() - goal.all().count();
    let (again, keep): (Vec<usize>, Vec<usize>) =
        (0..first_goal).partition(|r| rules[*r].kind == RuleKind::Justice);
    let mut runs = Runs::new(&abstraction.system.variables, rules.clone(), limits)?;
    let mut verdict = Verdict::default();
    for (place, (kind, index, formula)) in formulas(goal).enumerate() {
        let asked = first_goal + place;
        let why = match kind {
            RuleKind::Justice if !verdict.holds() => None,
            RuleKind::Justice => {
                let wanted = Wanted {
                    keep: keep.clone(),
                    again: nearest_first(abstraction, &again, &rules, &formula.expr),
                    never_again: vec![asked],
                };
                runs.lasso(&wanted)?.map(Broken::Lasso)
            }
            _ => {
                let slip = Slip {
                    before: keep.clone(),
                    last: keep.clone(),
                    broken: asked,
                };
                runs.step(&slip)?.map(Broken::Trace)
            }
        };
        debug_assert!(formula.name != NO_CIRCULAR_WAIT || kind == RuleKind::Invariant);
        verdict.open.extend(why.map(|why| Open {
            what: FormulaRef {
                part: None,
                half: Half::Guarantees,
                kind,
                index,
            },
            why,
        }));
    }
    Ok(verdict)
}

/// Justice in the order in which it is likely to matter for a goal: that of its own place, of those that parts go to from there, of
/// those before them. A run that starves one place mostly does so by one nearby, and where no run is left the rest is not looked at.
fn nearest_first(abstraction: &Abstraction, again: &[usize], rules: &[Rule], goal: &Expr) -> Vec<usize> {
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
        let around = shape.after(place).into_iter().chain(shape.places[place].from.iter().copied());
        for other in around {
            if !order.contains(&other) {
                order.push(other);
            }
        }
    }
    let distance = |rule: &usize| {
        let place = owner(&rules[*rule].expr);
        place.and_then(|p| order.iter().position(|o| *o == p)).unwrap_or(usize::MAX)
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
