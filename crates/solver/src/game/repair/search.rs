//! The descent of the lattice of suggestions: see [`super`].

use super::advice::{NewAssumption, Weakening};
use super::trial::Trials;
use super::vocabulary::{Word, negation};
use crate::game::reference::{GuaranteeKind as Kind, GuaranteeRef, definitions};
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{BinaryOp, Expr, Specification, Time, VarId};

/// Maximum number of conditions of a suggestion.
const MOST_CONDITIONS: usize = 2;

/// Maximum number of suggestions of a kind.
const MOST_SUGGESTIONS: usize = 3;

/// Maximum number of suggestions for the core that are tried on the whole specification.
const MOST_WHOLE: usize = 40;

/// A family of assumptions: the demand, and the step in which its conditions are evaluated.
struct Family {
    kind: Kind,
    /// The demand when all conditions hold.
    wanted: Expr,
    /// Whether conditions may mention outputs: those of the previous step, not of the one in which
    /// the input is given.
    before: bool,
}

impl Family {
    fn with(&self, conditions: &[&Word]) -> Expr {
        let wanted = self.wanted_under(conditions);
        let conditions = conditions.iter().map(|w| w.expr.clone());
        match conditions.reduce(Expr::and) {
            None => wanted,
            Some(all) => all.implies(wanted),
        }
    }

    /// The demand, shortened if a condition determines the value that stays.
    fn wanted_under(&self, conditions: &[&Word]) -> Expr {
        if let Expr::Binary(BinaryOp::Eq, after, before) = &self.wanted
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
        self.wanted.clone()
    }
}

/// The families, each starting from its strongest formula.
fn families(specification: &Specification, words: &[Word]) -> Vec<Family> {
    let mut families = Vec::new();
    let mut inputs: Vec<VarId> = Vec::new();
    for word in words.iter().filter(|w| w.inputs) {
        word.expr.for_each_var(&mut |v, _| {
            if !inputs.contains(&v) {
                inputs.push(v);
            }
        });
        for (kind, wanted, before) in [
            (Kind::Justice, word.expr.clone(), true),
            (Kind::Invariant, word.expr.clone(), false),
            (Kind::Safety, word.next(), true),
            (Kind::Initial, word.expr.clone(), false),
        ] {
            families.push(Family {
                kind,
                wanted,
                before,
            });
        }
    }
    let mut stays = Vec::new();
    for input in inputs {
        if specification.variable(input).domain.size() > 1 {
            stays.push(Family {
                kind: Kind::Safety,
                wanted: Expr::next(input).equals(Expr::now(input)),
                before: true,
            });
        }
    }
    // "It stays" is easier to judge than "it becomes 3".
    stays.extend(families);
    stays
}

/// Assumptions that would help, the least restrictive first.
pub fn assumptions<K: Kernel>(
    trials: &mut Trials<'_, K>,
    specification: &Specification,
    words: &[Word],
) -> Result<Vec<NewAssumption>, Limit> {
    trials.begin();
    let mut found: Vec<(usize, NewAssumption)> = Vec::new();
    for (number, family) in families(specification, words).iter().enumerate() {
        if !trials.helps_core(family.kind, &family.wanted)? {
            continue;
        }
        let may = |word: &Word| family.before || word.inputs;
        let about = |word: &Word| {
            let mut same = false;
            if family.kind != Kind::Safety {
                let mut mine = Vec::new();
                family.wanted.for_each_var(&mut |v, _| mine.push(v));
                word.expr
                    .for_each_var(&mut |v, _| same |= mine.contains(&v));
            }
            same
        };
        let conditions: Vec<&Word> = words.iter().filter(|w| may(w) && !about(w)).collect();
        let weakest = weaken(&conditions, &mut |chosen| {
            trials.helps_core(family.kind, &family.with(chosen))
        })?;
        for chosen in weakest {
            let formula = family.with(&chosen);
            let forbids = trials.forbids(&formula)?;
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
    // A justice assumption forbids no step at all.
    let steps = |a: &NewAssumption| a.kind != Kind::Justice;
    found.sort_by(|(m, a), (n, b)| {
        let by_share = a.forbids.total_cmp(&b.forbids);
        steps(a).cmp(&steps(b)).then(by_share).then(m.cmp(n))
    });
    let mut chosen: Vec<(usize, NewAssumption)> = Vec::new();
    let mut meanings: Vec<(Kind, K::Function)> = Vec::new();
    for (tried, (number, candidate)) in found.into_iter().enumerate() {
        if chosen.len() >= MOST_SUGGESTIONS || tried >= MOST_WHOLE {
            break;
        }
        // One of a family is enough, and two may be equivalent.
        let meaning = (candidate.kind, trials.encode(&candidate.formula)?);
        let known = meanings.contains(&meaning) || chosen.iter().any(|(n, _)| *n == number);
        if !known && trials.mends(candidate.kind, &candidate.formula)? {
            chosen.push((number, candidate));
            meanings.push(meaning);
        }
    }
    Ok(chosen.into_iter().map(|(_, a)| a).collect())
}

/// Guarantees that could be weakened, the smallest loss first.
pub fn weakenings<K: Kernel>(
    trials: &mut Trials<'_, K>,
    core: &[GuaranteeRef],
    words: &[Word],
) -> Result<Vec<Weakening>, Limit> {
    let specification = trials.specification;
    trials.begin();
    let mut found: Vec<Weakening> = Vec::new();
    let formula = |guarantee: GuaranteeRef| guarantee.formula(&specification.guarantees);
    for guarantee in core {
        if formula(*guarantee).defines || !trials.mends_without(*guarantee, None)? {
            continue;
        }
        // A formula that reads a monitor is not written by the author: the guarantee can only be
        // left out as a whole.
        if trials.is_of_monitor(*guarantee) {
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
        // Conditions on inputs come first: an exception on its own outputs could always be made
        // true by the machine.
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
                let gives_up = trials.holds(&unless)?;
                let better = best.as_ref().is_none_or(|b| gives_up < b.gives_up);
                // The weakened guarantee must still demand something.
                let asks = better && gives_up > 0.0 && trials.asks(*guarantee, &unless)?;
                if asks && trials.mends_without(*guarantee, Some(&unless))? {
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
    found.truncate(MOST_SUGGESTIONS);
    Ok(found)
}

/// A minimal set of guarantees to leave out so that the rest can be kept: guarantees are added one
/// after the other as long as that works.
pub fn leave_out<K: Kernel>(trials: &Trials<'_, K>) -> Result<Vec<GuaranteeRef>, Limit> {
    let (mut kept, asked) = definitions(&trials.specification.guarantees);
    let mut left = Vec::new();
    for guarantee in asked {
        kept.push(guarantee);
        if !trials.keeps(&kept)? {
            kept.pop();
            left.push(guarantee);
        }
    }
    Ok(left)
}

/// The maximal sets of conditions for which something helps; it helps without any. Sets that only
/// repeat another's meaning are not distinguished.
fn weaken<'w>(
    conditions: &[&'w Word],
    helps: &mut impl FnMut(&[&Word]) -> Result<bool, Limit>,
) -> Result<Vec<Vec<&'w Word>>, Limit> {
    let mut level: Vec<Vec<usize>> = vec![Vec::new()];
    let mut maximal: Vec<Vec<usize>> = Vec::new();
    for _ in 0..MOST_CONDITIONS {
        let mut next: Vec<Vec<usize>> = Vec::new();
        for chosen in &level {
            let mut grew = false;
            let from = chosen.last().map_or(0, |last| last + 1);
            for at in from..conditions.len() {
                let contrary = |c: &&usize| {
                    let other = &conditions[**c].expr;
                    *other == conditions[at].expr || *other == negation(conditions[at].expr.clone())
                };
                if chosen.iter().find(contrary).is_some() {
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
            // A set of two may also be found starting from its other condition.
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
