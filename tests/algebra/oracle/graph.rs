//! Explicit states: all valuations of a few variables, sets of them as bits of a word, and
//! reachability.

use super::lassos::valuations;
use crate::game::value;
use linewright::gr1::{Formula, Side, Variable};

/// A set of valuations, by their numbers.
pub type Set = u128;

/// Successors of each valuation.
pub type Relation = Vec<Set>;

/// The numbers in a set.
pub fn members(set: Set) -> impl Iterator<Item = usize> {
    (0..128).filter(move |i| set >> i & 1 == 1)
}

/// All valuations, and formulas over them.
pub struct Board {
    pub valuations: Vec<Vec<i64>>,
}

/// Runs without a side's justice: their initial states and steps.
#[derive(Clone)]
pub struct Steps {
    pub start: Set,
    pub step: Relation,
}

impl Board {
    pub fn new(variables: &[Variable]) -> Self {
        let valuations = valuations(variables);
        assert!(valuations.len() <= 128);
        Self { valuations }
    }

    pub fn everything(&self) -> Set {
        members(Set::MAX)
            .take(self.valuations.len())
            .fold(0, |set, i| set | 1 << i)
    }

    pub fn number(&self, valuation: &[i64]) -> usize {
        let mut all = self.valuations.iter();
        all.position(|v| v == valuation).expect("within domains")
    }

    /// The valuations for which a formula without next values holds.
    pub fn states(&self, formula: &Formula) -> Set {
        let all = self.valuations.iter().enumerate();
        all.filter(|(_, now)| value(&formula.expr, now, &[]) == 1)
            .fold(0, |set, (i, _)| set | 1 << i)
    }

    /// The steps for which a formula holds.
    pub fn relation(&self, formula: &Formula) -> Relation {
        let row = |now: &Vec<i64>| {
            let next = self.valuations.iter().enumerate();
            next.filter(|(_, next)| value(&formula.expr, now, next) == 1)
                .fold(0, |set, (i, _)| set | 1 << i)
        };
        self.valuations.iter().map(row).collect()
    }

    pub fn relations(&self, formulas: &[Formula]) -> Vec<Relation> {
        formulas.iter().map(|f| self.relation(f)).collect()
    }

    /// The runs that keep the initial conditions, invariants and safety of all these sides.
    pub fn steps<'a>(&self, sides: impl IntoIterator<Item = &'a Side>) -> Steps {
        let mut start = self.everything();
        let mut always = self.everything();
        let mut step = vec![self.everything(); self.valuations.len()];
        for side in sides {
            for f in &side.initial {
                start &= self.states(f);
            }
            for f in &side.invariants {
                always &= self.states(f);
            }
            for f in &side.safety {
                for (row, more) in step.iter_mut().zip(self.relation(f)) {
                    *row &= more;
                }
            }
        }
        for row in &mut step {
            *row &= always;
        }
        Steps {
            start: start & always,
            step,
        }
    }
}

impl Steps {
    pub fn after(&self, set: Set) -> Set {
        members(set).fold(0, |all, s| all | self.step[s])
    }

    /// The states reachable from a set, including the set.
    pub fn reach(&self, from: Set) -> Set {
        let mut all = from;
        loop {
            let more = all | self.after(all);
            if more == all {
                return all;
            }
            all = more;
        }
    }

    /// The valuations from which some infinite run meets all of `justice` again and again.
    pub fn lasting(&self, justice: &[Relation]) -> Set {
        let count = self.step.len();
        let mut good = (0..count).fold(0, |set: Set, i| set | 1 << i);
        loop {
            // A step remains, and every justice can be met within `good`.
            let mut smaller = members(good)
                .filter(|s| self.step[*s] & good != 0)
                .fold(0, |set: Set, s| set | 1 << s);
            for goal in justice {
                let mut way: Set = 0;
                loop {
                    let more = members(smaller)
                        .filter(|s| self.step[*s] & (way | (goal[*s] & smaller)) != 0)
                        .fold(way, |set, s| set | 1 << s);
                    if more == way {
                        break;
                    }
                    way = more;
                }
                smaller = way;
            }
            if smaller == good {
                return good;
            }
            good = smaller;
        }
    }

    /// Whether a cycle among these valuations meets all of `justice`.
    pub fn has_cycle(&self, among: Set, justice: &[Relation]) -> bool {
        let inside = Self {
            start: 0,
            step: self
                .step
                .iter()
                .enumerate()
                .map(|(s, row)| if among >> s & 1 == 1 { row & among } else { 0 })
                .collect(),
        };
        inside.lasting(justice) != 0
    }
}
