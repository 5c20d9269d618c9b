//! Searches the lattice of suggestions; see [`super`].

use super::advice::{NewAssumption, Weakening};
use super::trial::Trials;
use super::vocabulary::{Word, negation};
use crate::game::reference::{GuaranteeRef, split_definitions};
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{BinaryOp, Expr, FormulaKind as Kind, Specification, Time, VarId};

/// Maximum number of conditions in a suggestion.
const MAX_CONDITIONS: usize = 2;

/// Maximum number of suggestions of a kind.
const MAX_SUGGESTIONS: usize = 3;

/// Maximum number of suggestions for the core that are tried on the whole specification.
const MAX_TRIED: usize = 40;

/// A family of assumptions `conditions -> demand` with the same demand.
struct Family {
    kind: Kind,
    /// What the environment must do if all conditions hold.
    demand: Expr,
    /// Whether conditions can mention outputs, because they are evaluated in an earlier step than
    /// the demanded input.
    allows_outputs: bool,
}

impl Family {
    /// Returns the assumption with these conditions.
    fn with(&self, conditions: &[&Word]) -> Expr {
        let demand = self.demand_under(conditions);
        let conditions = conditions.iter().map(|w| w.expr.clone());
        match conditions.reduce(Expr::and) {
            None => demand,
            Some(all) => all.implies(demand),
        }
    }

    /// Returns the demand. "The input stays" is simplified if a condition determines the input's
    /// value.
    fn demand_under(&self, conditions: &[&Word]) -> Expr {
        if let Expr::Binary(BinaryOp::Eq, after, before) = &self.demand
            && matches!(**after, Expr::Var(_, Time::Next))
            && matches!(**before, Expr::Var(_, Time::Now))
        {
            if conditions.iter().any(|w| w.expr == **before) {
                return (**after).clone();
            }
            let not = (**before).clone().not();
            if conditions.iter().any(|w| w.expr == not) {
                return (**after).clone().not();
            }
        }
        self.demand.clone()
    }
}

/// Returns the families of assumptions to search.
fn families(specification: &Specification, words: &[Word]) -> Vec<Family> {
    let mut families = Vec::new();
    let mut inputs: Vec<VarId> = Vec::new();
    for word in words.iter().filter(|w| w.inputs) {
        word.expr.for_each_var(&mut |v, _| {
            if !inputs.contains(&v) {
                inputs.push(v);
            }
        });
        for (kind, demand, allows_outputs) in [
            (Kind::Justice, word.expr.clone(), true),
            (Kind::Invariant, word.expr.clone(), false),
            (Kind::Safety, word.next(), true),
            (Kind::Initial, word.expr.clone(), false),
        ] {
            families.push(Family {
                kind,
                demand,
                allows_outputs,
            });
        }
    }
    let mut stays = Vec::new();
    for input in inputs {
        if specification.variable(input).domain.size() > 1 {
            stays.push(Family {
                kind: Kind::Safety,
                demand: Expr::next(input).equals(Expr::now(input)),
                allows_outputs: true,
            });
        }
    }
    // "The input stays" is easier to judge than "the input becomes 3", so it comes first.
    stays.extend(families);
    stays
}

/// Returns assumptions that make the specification realizable, the least restrictive first.
pub fn assumptions<K: Kernel>(
    trials: &mut Trials<'_, K>,
    specification: &Specification,
    words: &[Word],
) -> Result<Vec<NewAssumption>, Limit> {
    trials.reset_games();
    let mut found: Vec<(usize, NewAssumption)> = Vec::new();
    for (number, family) in families(specification, words).iter().enumerate() {
        if !trials.helps_core(family.kind, &family.demand)? {
            continue;
        }
        let is_allowed = |word: &Word| family.allows_outputs || word.inputs;
        let shares_variable = |word: &Word| {
            let mut same = false;
            if family.kind != Kind::Safety {
                let mut demanded = Vec::new();
                family.demand.for_each_var(&mut |v, _| demanded.push(v));
                word.expr
                    .for_each_var(&mut |v, _| same |= demanded.contains(&v));
            }
            same
        };
        let conditions: Vec<&Word> = words
            .iter()
            .filter(|w| is_allowed(w) && !shares_variable(w))
            .collect();
        let weakest = weaken(&conditions, &mut |chosen| {
            trials.helps_core(family.kind, &family.with(chosen))
        })?;
        for chosen in weakest {
            let formula = family.with(&chosen);
            let forbids = trials.forbidden_share(&formula)?;
            found.push((
                number,
                NewAssumption {
                    kind: family.kind,
                    formula,
                    forbids,
                },
            ));
        }
    }
    // Justice assumptions come first, since they forbid no single step.
    let restricts_steps = |a: &NewAssumption| a.kind != Kind::Justice;
    found.sort_by(|(m, a), (n, b)| {
        let by_share = a.forbids.total_cmp(&b.forbids);
        restricts_steps(a)
            .cmp(&restricts_steps(b))
            .then(by_share)
            .then(m.cmp(n))
    });
    let mut chosen: Vec<(usize, NewAssumption)> = Vec::new();
    let mut meanings: Vec<(Kind, K::Function)> = Vec::new();
    for (tried, (number, candidate)) in found.into_iter().enumerate() {
        if chosen.len() >= MAX_SUGGESTIONS || tried >= MAX_TRIED {
            break;
        }
        // Suggests at most one assumption of each family, and no two equivalent ones.
        let meaning = (candidate.kind, trials.encode(&candidate.formula)?);
        let known = meanings.contains(&meaning) || chosen.iter().any(|(n, _)| *n == number);
        if !known && trials.helps_whole(candidate.kind, &candidate.formula)? {
            chosen.push((number, candidate));
            meanings.push(meaning);
        }
    }
    Ok(chosen.into_iter().map(|(_, a)| a).collect())
}

/// Returns guarantees of the core that can be weakened or left out to make the specification
/// realizable, the smallest loss first.
pub fn weakenings<K: Kernel>(
    trials: &mut Trials<'_, K>,
    core: &[GuaranteeRef],
    words: &[Word],
) -> Result<Vec<Weakening>, Limit> {
    let specification = trials.specification;
    trials.reset_games();
    let mut found: Vec<Weakening> = Vec::new();
    let formula = |guarantee: GuaranteeRef| guarantee.formula(&specification.guarantees);
    for guarantee in core {
        if formula(*guarantee).defines || !trials.helps_whole_without(*guarantee, None)? {
            continue;
        }
        // A formula that mentions a monitor was generated from a guarantee that can only be left
        // out as a whole.
        // The same holds of the formulas of a counter or monitor, which are named after its
        // variable.
        if trials.mentions_monitor(*guarantee) || trials.declares(*guarantee) {
            let name = &formula(*guarantee).name;
            if found.iter().all(|w| formula(w.guarantee).name != *name) {
                found.push(Weakening {
                    guarantee: *guarantee,
                    unless: None,
                    gives_up: 1.0,
                });
            }
            continue;
        }
        let mut best: Option<Weakening> = None;
        // Conditions on inputs are preferred, because the machine could satisfy a condition on its
        // own outputs at will and so evade the guarantee.
        for inputs_only in [true, false] {
            let mut conditions: Vec<Word> = Vec::new();
            for word in words.iter().filter(|w| w.inputs || !inputs_only) {
                let next = Word {
                    expr: word.next(),
                    inputs: word.inputs,
                };
                conditions.push(word.clone());
                if guarantee.kind == Kind::Safety && word.inputs {
                    conditions.push(next);
                }
            }
            let conditions: Vec<&Word> = conditions.iter().collect();
            let join = |chosen: &[&Word]| chosen.iter().map(|w| w.expr.clone()).reduce(Expr::and);
            let weakest = weaken(&conditions, &mut |chosen| {
                trials.helps_core_without(*guarantee, join(chosen).as_ref())
            })?;
            for chosen in weakest {
                let Some(unless) = join(&chosen) else {
                    continue;
                };
                let gives_up = trials.holding_share(&unless)?;
                let better = best.as_ref().is_none_or(|b| gives_up < b.gives_up);
                let demands =
                    better && gives_up > 0.0 && trials.still_demands(*guarantee, &unless)?;
                if demands && trials.helps_whole_without(*guarantee, Some(&unless))? {
                    best = Some(Weakening {
                        guarantee: *guarantee,
                        unless: Some(unless),
                        gives_up,
                    });
                }
            }
            if best.is_some() {
                break;
            }
        }
        found.push(best.unwrap_or(Weakening {
            guarantee: *guarantee,
            unless: None,
            gives_up: 1.0,
        }));
    }
    found.sort_by(|a, b| {
        let by_share = a.gives_up.total_cmp(&b.gives_up);
        by_share.then(a.guarantee.cmp(&b.guarantee))
    });
    found.truncate(MAX_SUGGESTIONS);
    Ok(found)
}

/// Returns a minimal set of guarantees whose omission makes the specification realizable. Adds the
/// guarantees one after the other, and leaves out each one that would make the specification
/// unrealizable.
pub fn leave_out<K: Kernel>(trials: &Trials<'_, K>) -> Result<Vec<GuaranteeRef>, Limit> {
    let (mut kept, demands) = split_definitions(&trials.specification.guarantees);
    let mut left = Vec::new();
    for guarantee in demands {
        kept.push(guarantee);
        if !trials.is_realizable(&kept)? {
            kept.pop();
            left.push(guarantee);
        }
    }
    Ok(left)
}

/// Returns the maximal sets of up to [`MAX_CONDITIONS`] conditions for which `helps` returns true.
/// It must return true for the empty set. The result can contain equivalent sets.
fn weaken<'w>(
    conditions: &[&'w Word],
    helps: &mut impl FnMut(&[&Word]) -> Result<bool, Limit>,
) -> Result<Vec<Vec<&'w Word>>, Limit> {
    let mut level: Vec<Vec<usize>> = vec![Vec::new()];
    let mut maximal: Vec<Vec<usize>> = Vec::new();
    for _ in 0..MAX_CONDITIONS {
        let mut next: Vec<Vec<usize>> = Vec::new();
        for chosen in &level {
            let mut grew = false;
            let from = chosen.last().map_or(0, |last| last + 1);
            for at in from..conditions.len() {
                let is_redundant = |c: &&usize| {
                    let other = &conditions[**c].expr;
                    *other == conditions[at].expr || *other == negation(conditions[at].expr.clone())
                };
                if chosen.iter().find(is_redundant).is_some() {
                    continue;
                }
                let mut longer = chosen.clone();
                longer.push(at);
                let words: Vec<&Word> = longer.iter().map(|c| conditions[*c]).collect();
                if helps(&words)? {
                    grew = true;
                    next.push(longer);
                }
            }
            // A larger set that contains this one might have been found from another set.
            let covered = next
                .iter()
                .any(|longer| chosen.iter().all(|c| longer.contains(c)));
            if !grew && !covered {
                maximal.push(chosen.clone());
            }
        }
        level = next;
        if level.is_empty() {
            break;
        }
    }
    maximal.extend(level);
    let words = |chosen: Vec<usize>| chosen.into_iter().map(|c| conditions[c]).collect();
    Ok(maximal.into_iter().map(words).collect())
}
