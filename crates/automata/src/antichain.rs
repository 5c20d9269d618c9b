//! Conditions built from "and" and "or" alone, in minimal form.
//!
//! Such a condition is a set of sets. Read as *terms*, all elements of at least one set have to
//! hold; read as *clauses*, at least one element of every set. In both readings a set that contains
//! another one is redundant, and without these the condition has only one form (Quine, "The problem
//! of simplifying truth functions", 1952): equal conditions are equal values. "And" in one reading
//! is "or" in the other.

use std::collections::BTreeSet;

/// Sets none of which contains another one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Antichain<T>(BTreeSet<BTreeSet<T>>);

impl<T: Clone + Ord> Antichain<T> {
    /// Returns the empty set of sets: false as terms, true as clauses.
    pub fn none() -> Self {
        Self(BTreeSet::new())
    }

    /// Returns the empty set alone: true as terms, false as clauses.
    pub fn unit() -> Self {
        Self(BTreeSet::from([BTreeSet::new()]))
    }

    /// Returns one element alone.
    pub fn of(element: T) -> Self {
        Self(BTreeSet::from([BTreeSet::from([element])]))
    }

    /// Returns the sets of both: "or" of terms, "and" of clauses.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self(least(&self.0.union(&other.0).cloned().collect()))
    }

    /// Returns each set of one joined with each set of the other: "and" of terms, "or" of clauses.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let pairs = self
            .0
            .iter()
            .flat_map(|a| other.0.iter().map(move |b| a | b));
        Self(least(&pairs.collect()))
    }

    /// Returns only the chosen sets.
    #[must_use]
    pub fn filter(&self, chosen: impl Fn(&BTreeSet<T>) -> bool) -> Self {
        Self(self.0.iter().filter(|set| chosen(set)).cloned().collect())
    }

    /// Returns the sets in ascending order.
    pub fn sets(&self) -> impl Iterator<Item = &BTreeSet<T>> {
        self.0.iter()
    }

    /// Returns the number of sets.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether there is no set.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Removes the sets that contain another one.
fn least<T: Clone + Ord>(sets: &BTreeSet<BTreeSet<T>>) -> BTreeSet<BTreeSet<T>> {
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
    fn constants_are_neutral_or_win() {
        let (none, unit) = (Antichain::none(), Antichain::unit());
        let a = Antichain::of('a');
        assert_eq!(a.union(&none), a);
        assert_eq!(a.product(&unit), a);
        assert_eq!(a.product(&none), none);
        assert_eq!(a.union(&unit), unit);
    }
}
