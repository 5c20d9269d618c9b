//! Finds monitors, counters and patterns whose formulas only define the values of their variables.
//!
//! Spectra calls these formulas guarantees, but does not check that they leave the system free. If
//! they do, none of them can be the reason why a specification is unrealizable.

use super::reader::Reader;
use linewright_core::gr1::eval::eval;
use linewright_core::gr1::{Expr, Formula, Side, Specification, Time, VarId};
use std::collections::BTreeSet;
use std::ops::Range;

/// Maximum number of combinations of values that are tried for one group of variables.
const MAX_COMBINATIONS: u64 = 1 << 16;

/// Variables declared together, and the guarantees that were added with them.
#[derive(Debug)]
pub(super) struct Group {
    variables: Vec<VarId>,
    initial: Range<usize>,
    invariants: Range<usize>,
    safety: Range<usize>,
}

/// Numbers of initial conditions, invariants and safety formulas.
pub(super) type Counts = [usize; 3];

impl Reader {
    /// Returns the current numbers of guarantees.
    pub fn counts(&self) -> Counts {
        let side = &self.specification.guarantees;
        [side.initial.len(), side.invariants.len(), side.safety.len()]
    }

    /// Records the guarantees added since `before` as formulas of these variables.
    pub fn record_group(&mut self, variables: Vec<VarId>, before: Counts) {
        let now = self.counts();
        let [initial, invariants, safety] = [0, 1, 2].map(|list| before[list]..now[list]);
        self.groups.push(Group {
            variables,
            initial,
            invariants,
            safety,
        });
    }
}

/// Marks the formulas of a group as definitions if they never restrict anything but the group's
/// variables: whatever values all other variables have, the group's variables have values that
/// satisfy them. Groups with too many combinations of values are left as they are.
pub(super) fn mark(specification: &mut Specification, group: &Group) {
    if is_total(specification, group) == Some(true) {
        for formula in formulas(&mut specification.guarantees, group) {
            formula.defines = true;
        }
    }
}

fn formulas<'a>(side: &'a mut Side, group: &Group) -> impl Iterator<Item = &'a mut Formula> {
    let initial = side.initial[group.initial.clone()].iter_mut();
    let invariants = side.invariants[group.invariants.clone()].iter_mut();
    initial
        .chain(invariants)
        .chain(side.safety[group.safety.clone()].iter_mut())
}

/// Values of all variables in two consecutive steps.
struct Steps {
    now: Vec<i64>,
    next: Vec<i64>,
}

/// A variable in one of the two steps.
type Place = (VarId, Time);

fn is_total(specification: &Specification, group: &Group) -> Option<bool> {
    let side = &specification.guarantees;
    let list =
        |formulas: &[Formula]| -> Vec<Expr> { formulas.iter().map(|f| f.expr.clone()).collect() };
    let initial = list(&side.initial[group.initial.clone()]);
    let mut invariants = list(&side.invariants[group.invariants.clone()]);
    let safety = list(&side.safety[group.safety.clone()]).into_iter();
    // A safety formula without next values holds in every step that is left. It is enough to
    // satisfy it in every step.
    let (safety, always): (Vec<Expr>, Vec<Expr>) = safety.partition(Expr::mentions_next);
    invariants.extend(always);
    let primed: Vec<Expr> = invariants
        .iter()
        .map(|e| e.substitute(&mut |v, _| Expr::next(v)))
        .collect();
    let own = |place: &Place| group.variables.contains(&place.0);
    let holds = |formulas: &[&[Expr]], steps: &Steps| {
        let mut all = formulas.iter().flat_map(|list| list.iter());
        all.all(|e| eval(e, &steps.now, &steps.next) != 0)
    };
    let lows: Vec<i64> = specification
        .variables
        .iter()
        .map(|v| v.domain.low())
        .collect();
    let mut steps = Steps {
        now: lows.clone(),
        next: lows,
    };

    // The first step, and then every other one.
    let start: &[&[Expr]] = &[&initial, &invariants];
    let (inner, outer): (Vec<Place>, Vec<Place>) =
        places(specification, start)?.into_iter().partition(own);
    let starts = every(specification, &outer, &mut steps, &mut |steps| {
        some(specification, &inner, steps, &mut |steps| {
            holds(start, steps)
        })
    });
    let step: &[&[Expr]] = &[&safety, &primed];
    let all = places(specification, &[&invariants, &safety, &primed])?;
    let chosen = |place: &Place| own(place) && place.1 == Time::Next;
    let (inner, outer): (Vec<Place>, Vec<Place>) = all.into_iter().partition(chosen);
    let goes_on = every(specification, &outer, &mut steps, &mut |steps| {
        !holds(&[&invariants], steps)
            || some(specification, &inner, steps, &mut |steps| {
                holds(step, steps)
            })
    });
    Some(starts && goes_on)
}

/// Returns the places that formulas mention; `None` if they have too many combinations of values.
fn places(specification: &Specification, formulas: &[&[Expr]]) -> Option<BTreeSet<Place>> {
    let mut found = BTreeSet::new();
    for expr in formulas.iter().flat_map(|list| list.iter()) {
        expr.for_each_var(&mut |v, time| {
            found.insert((v, time));
        });
    }
    let combinations = found.iter().try_fold(1_u64, |n, (v, _)| {
        n.checked_mul(specification.variable(*v).domain.size())
    })?;
    (combinations <= MAX_COMBINATIONS).then_some(found)
}

/// Whether some values at these places pass a test.
fn some(
    specification: &Specification,
    places: &[Place],
    steps: &mut Steps,
    test: &mut dyn FnMut(&mut Steps) -> bool,
) -> bool {
    let Some(((v, time), rest)) = places.split_first() else {
        return test(steps);
    };
    let domain = &specification.variable(*v).domain;
    (domain.low()..=domain.high()).any(|value| {
        let values = match time {
            Time::Now => &mut steps.now,
            Time::Next => &mut steps.next,
        };
        values[v.index()] = value;
        some(specification, rest, steps, test)
    })
}

/// Whether all values at these places pass a test.
fn every(
    specification: &Specification,
    places: &[Place],
    steps: &mut Steps,
    test: &mut dyn FnMut(&mut Steps) -> bool,
) -> bool {
    !some(specification, places, steps, &mut |steps| !test(steps))
}
