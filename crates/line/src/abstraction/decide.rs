//! Decides whether a claim holds for all places together from a single exploration of the reachable
//! states: the quick answer for `check`.
//!
//! [`linewright_algebra::proof::prove`] additionally determines which formulas each proof needs: it
//! decides the same questions repeatedly, each time with some formulas left out.

use super::Abstraction;
use super::parts::formula;
use crate::undecided::UndecidedReason;
pub use linewright_algebra::proof::Open;
use linewright_algebra::proof::{self, Claim, Exports, Refutation};
use linewright_algebra::system::{FormulaRef, System, rule};
use linewright_core::gr1::{Expr, FormulaKind, Side};
use linewright_core::source::Span;
use linewright_language::contract::line::Line;
use linewright_solver::game::{Limit, Limits, Rule, Runs, SafetyViolationQuery};
use serde::{Deserialize, Serialize};

/// Result of the decision.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Goal formulas that do not hold, with counterexample runs. If safety is violated, justice is
    /// not examined.
    pub open: Vec<Open>,
    /// Undecided goals. Only justice can be undecided; without a decision on safety there is no
    /// verdict.
    pub undecided: Vec<FormulaRef>,
    /// The limit that ended the justice check. `None` if no limit was reached, or if justice was
    /// not checked because the line is too large.
    pub limit: Option<Limit>,
    /// Whether the open goals were found with parts that can move late, and it was not decided
    /// whether they are also open if parts move at once.
    pub late: bool,
    /// Whether the verdict is about [`Abstraction::at_once`] instead of [`Abstraction::of`].
    pub at_once: bool,
}

impl Verdict {
    /// Whether the whole claim holds.
    pub fn holds(&self) -> bool {
        self.open.is_empty() && self.undecided.is_empty()
    }
}

/// Maximum number of variables if parts move at once. In that case, everything that takes time
/// waits for everything that does not, so no goal involves only a few places.
const MAX_AT_ONCE_VARIABLES: usize = 24;

/// The rules of a line, in this order: the guarantees of all places, what is given, and the goal.
fn rules(abstraction: &Abstraction) -> Vec<Rule> {
    let sides = abstraction
        .system
        .components
        .iter()
        .map(|p| &p.guarantees)
        .chain([&abstraction.claim.given, &abstraction.claim.goal]);
    sides
        .flat_map(Side::formulas)
        .map(|(kind, _, f)| rule(kind, &f.expr))
        .collect()
}

/// Decides whether a line is sound. Returns the verdict, and the abstraction that shows it.
/// Justice, and the case in which parts move at once, are examined only for lines with at most
/// `most_variables` variables; for larger lines, justice stays undecided.
///
/// # Errors
/// Returns the reason if it was not decided.
pub fn examine(
    line: &Line,
    limits: &Limits,
    most_variables: usize,
) -> Result<(Abstraction, Verdict), UndecidedReason> {
    let is_small = |a: &Abstraction| a.system.variables.len() <= most_variables;
    let asked = |abstraction: &Abstraction| -> Result<Verdict, Limit> {
        let mut verdict = safety(abstraction, limits)?;
        if verdict.open.is_empty() && is_small(abstraction) {
            justice(abstraction, limits, &mut verdict);
        } else if verdict.open.is_empty() {
            verdict.undecided.extend(liveness(&abstraction.claim));
        }
        Ok(verdict)
    };
    let loose = Abstraction::of(line)?;
    let mut verdict = asked(&loose)?;
    if verdict.open.is_empty() {
        return Ok((loose, verdict));
    }
    if let Ok(strict) = Abstraction::at_once(line)
        && strict.system.variables.len() <= most_variables.min(MAX_AT_ONCE_VARIABLES)
        && let Ok(mut verdict) = asked(&strict)
        && (!verdict.holds() || has_a_run(&strict, limits).is_ok_and(|has| has))
    {
        verdict.at_once = true;
        return Ok((strict, verdict));
    }
    verdict.late = true;
    Ok((loose, verdict))
}

/// Decides the claim of one abstraction.
///
/// # Errors
/// Returns the limit that was reached.
pub fn decide(abstraction: &Abstraction, limits: &Limits) -> Result<Verdict, Limit> {
    let mut verdict = safety(abstraction, limits)?;
    if verdict.open.is_empty() {
        justice(abstraction, limits, &mut verdict);
    }
    Ok(verdict)
}

/// Whether some run satisfies what all places guarantee and what is given. If there is none, these
/// contradict each other, and any claim would follow from them. [`examine`] checks this for the
/// case in which parts move at once.
///
/// # Errors
/// Returns the limit that was reached.
pub fn has_a_run(abstraction: &Abstraction, limits: &Limits) -> Result<bool, Limit> {
    let never = formula(Span::default(), "never", "false", &Expr::FALSE);
    let claim = Claim {
        given: abstraction.claim.given.clone(),
        goal: Side {
            justice: vec![never],
            ..Side::default()
        },
        exports: Exports::Never,
        ..Claim::default()
    };
    let proof = proof::decide(&without_assumptions(&abstraction.system), &claim, limits)?;
    Ok(!proof.open.is_empty())
}

/// The system with places that keep their guarantees whatever the others do.
fn without_assumptions(system: &System) -> System {
    let mut alone = system.clone();
    for part in &mut alone.components {
        part.assumptions = Side::default();
    }
    alone
}

/// The justice goals that are not lemmas.
fn liveness(claim: &Claim) -> impl Iterator<Item = FormulaRef> {
    let goals = claim.goals().map(|(at, _)| at);
    goals.filter(|at| at.kind == FormulaKind::Justice && !claim.lemmas.contains_key(at))
}

fn safety(abstraction: &Abstraction, limits: &Limits) -> Result<Verdict, Limit> {
    let rules = rules(abstraction);
    let first_goal = rules.len() - abstraction.claim.goal.all().count();
    let keep: Vec<usize> = (0..first_goal)
        .filter(|r| rules[*r].kind != FormulaKind::Justice)
        .collect();
    let mut runs = Runs::new(&abstraction.system.variables, rules, limits)?;
    let mut verdict = Verdict::default();
    for (place, (what, _)) in abstraction.claim.goals().enumerate() {
        if what.kind == FormulaKind::Justice || abstraction.claim.lemmas.contains_key(&what) {
            continue;
        }
        let slip = SafetyViolationQuery {
            before: keep.clone(),
            last: keep.clone(),
            broken: first_goal + place,
        };
        verdict
            .open
            .extend(runs.find_violation(&slip)?.map(|trace| Open {
                what,
                why: Refutation::Trace(trace),
            }));
    }
    Ok(verdict)
}

/// Decides the justice goals one by one. The search for a proof goes from near places to far ones,
/// so most goals involve only a few places.
fn justice(abstraction: &Abstraction, limits: &Limits, verdict: &mut Verdict) {
    let claim = &abstraction.claim;
    // The safety goals hold, so they can be used.
    let alone = without_assumptions(&abstraction.system);
    let safety = claim
        .goals()
        .map(|(at, _)| at)
        .filter(|at| at.kind != FormulaKind::Justice);
    let asked = Claim {
        known: safety.filter(|at| !claim.lemmas.contains_key(at)).collect(),
        ..claim.clone()
    };
    match proof::decide(&alone, &asked, limits) {
        Ok(proof) => verdict.open.extend(proof.open),
        Err(limit) => {
            verdict.undecided.extend(liveness(claim));
            verdict.limit = Some(limit);
        }
    }
}

impl Abstraction {
    /// The goal formula to which `at` refers.
    pub fn goal(&self, at: FormulaRef) -> &linewright_core::gr1::Formula {
        &self.claim.goal.list(at.kind)[at.index]
    }
}
