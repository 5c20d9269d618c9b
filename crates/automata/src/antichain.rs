//! Conditions built with "and" and "or" only, in minimal form.
//!
//! A condition is a set of sets of elements. Read as *terms*, all elements of at least one set have
//! to hold; read as *clauses*, at least one element of every set has to hold. In both readings, a
//! set that contains another one is redundant. Without redundant sets, each condition has only one
//! form (Quine, "The problem of simplifying truth functions", 1952), so equivalent conditions are
//! equal values. The operation that is "and" in one reading is "or" in the other.

use std::collections::BTreeSet;

/// A set of sets, none of which contains another one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Antichain<T>(BTreeSet<BTreeSet<T>>);

impl<T: Clone + Ord> Antichain<T> {
    /// Creates the condition without sets: false as terms, true as clauses.
    pub fn none() -> Self {
        Self(BTreeSet::new())
    }

    /// Creates the condition with only the empty set: true as terms, false as clauses.
    pub fn unit() -> Self {
        Self(BTreeSet::from([BTreeSet::new()]))
    }

    /// Creates the condition that one element holds.
    pub fn of(element: T) -> Self {
        Self(BTreeSet::from([BTreeSet::from([element])]))
    }

    /// Returns the sets of both conditions: "or" of terms, "and" of clauses.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self(minimal_sets(&self.0.union(&other.0).cloned().collect()))
    }

    /// Returns the unions of each set of one condition with each set of the other: "and" of terms,
    /// "or" of clauses.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let pairs = self
            .0
            .iter()
            .flat_map(|a| other.0.iter().map(move |b| a | b));
        Self(minimal_sets(&pairs.collect()))
    }

    /// Returns the condition with only the sets for which `keep` is true.
    #[must_use]
    pub fn filter(&self, keep: impl Fn(&BTreeSet<T>) -> bool) -> Self {
        Self(self.0.iter().filter(|set| keep(set)).cloned().collect())
    }

    /// Returns the sets in ascending order.
    pub fn sets(&self) -> impl Iterator<Item = &BTreeSet<T>> {
        self.0.iter()
    }

    /// Returns the number of sets.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether the condition has no sets.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Removes the sets that contain another set.
fn minimal_sets<T: Clone + Ord>(sets: &BTreeSet<BTreeSet<T>>) -> BTreeSet<BTreeSet<T>> {
    let contains_another = |set: &BTreeSet<T>| sets.iter().any(|s| s != set && s.is_subset(set));
    let kept = sets.iter().filter(|set| !contains_another(set));
    kept.cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_conditions_are_equal_values() {
        let [a, b, c] = ['a', 'b', 'c'].map(Antichain::of);
        // Distribution holds in both directions, so it holds in both readings.
        assert_eq!(a.product(&b.union(&c)), a.product(&b).union(&a.product(&c)));
        assert_eq!(a.union(&b.product(&c)), a.union(&b).product(&a.union(&c)));
        assert_eq!(a.union(&a.product(&b)), a);
        assert_eq!(a.product(&a.union(&b)), a);
    }

    #[test]
    fn constants_are_neutral_or_absorbing() {
        let (none, unit) = (Antichain::none(), Antichain::unit());
        let a = Antichain::of('a');
        assert_eq!(a.union(&none), a);
        assert_eq!(a.product(&unit), a);
        assert_eq!(a.product(&none), none);
        assert_eq!(a.union(&unit), unit);
    }
}
