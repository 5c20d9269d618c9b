//! Regular expressions over steps, with complement and intersection, and their conversion to
//! deterministic automata.
//!
//! The conversion uses derivatives (Brzozowski, "Derivatives of regular expressions", 1964), which
//! support complement and intersection directly: the derivative of an expression after a step
//! matches the words that can follow that step. A state of the automaton is an expression. Equal
//! states are recognized because unions and intersections are sets.

use crate::bound::BoundExceeded;
use crate::symbolic::{Automaton, Values};
use std::collections::BTreeSet;
use std::rc::Rc;

/// A regular expression over steps, with complement and intersection. Conditions on a step are
/// numbered.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExtendedRegex {
    /// No word at all.
    Never,
    /// The empty word.
    Empty,
    /// One step, with any values.
    Any,
    /// One step in which a condition holds.
    Step(usize),
    /// Every word that the expression does not match.
    Not(Rc<ExtendedRegex>),
    /// Concatenation.
    Sequence(Rc<ExtendedRegex>, Rc<ExtendedRegex>),
    /// Any number of repetitions, including none.
    Star(Rc<ExtendedRegex>),
    /// Intersection.
    And(BTreeSet<ExtendedRegex>),
    /// Union.
    Or(BTreeSet<ExtendedRegex>),
}

impl ExtendedRegex {
    /// Returns the complement.
    #[must_use]
    #[expect(
        clippy::should_implement_trait,
        reason = "a method like the other operators"
    )]
    pub fn not(self) -> Self {
        match self {
            Self::Not(inner) => (*inner).clone(),
            other => Self::Not(Rc::new(other)),
        }
    }

    /// Returns the concatenation.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Never, _) | (_, Self::Never) => Self::Never,
            (Self::Empty, r) | (r, Self::Empty) => r,
            // Nested to the right, so that equal sequences have equal representations.
            (Self::Sequence(a, b), next) => Self::Sequence(a, Rc::new((*b).clone().then(next))),
            (a, b) => Self::Sequence(Rc::new(a), Rc::new(b)),
        }
    }

    /// Returns an expression for any number of repetitions, including none.
    #[must_use]
    pub fn star(self) -> Self {
        match self {
            Self::Never | Self::Empty => Self::Empty,
            star @ Self::Star(_) => star,
            other => Self::Star(Rc::new(other)),
        }
    }

    /// Returns whether the expression is one of the two forms that match every word.
    fn is_all(&self) -> bool {
        matches!(self, Self::Not(inner) if **inner == Self::Never)
            || matches!(self, Self::Star(inner) if **inner == Self::Any)
    }

    /// Returns the union.
    pub fn or(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut set = BTreeSet::new();
        for part in parts {
            match part {
                Self::Never => {}
                Self::Or(inner) => set.extend(inner),
                part if part.is_all() => return part,
                part => {
                    set.insert(part);
                }
            }
        }
        match set.len() {
            0 => Self::Never,
            1 => set.pop_first().unwrap_or(Self::Never),
            _ => Self::Or(set),
        }
    }

    /// Returns the intersection.
    pub fn and(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut set = BTreeSet::new();
        for part in parts {
            match part {
                Self::Never => return Self::Never,
                Self::And(inner) => set.extend(inner),
                part if part.is_all() => {}
                part => {
                    set.insert(part);
                }
            }
        }
        match set.len() {
            0 => Self::Never.not(),
            1 => set.pop_first().unwrap_or(Self::Never),
            _ => Self::And(set),
        }
    }

    /// Returns whether the expression matches the empty word.
    pub fn matches_empty(&self) -> bool {
        match self {
            Self::Never | Self::Any | Self::Step(_) => false,
            Self::Empty | Self::Star(_) => true,
            Self::Not(r) => !r.matches_empty(),
            Self::Sequence(a, b) => a.matches_empty() && b.matches_empty(),
            Self::And(set) => set.iter().all(Self::matches_empty),
            Self::Or(set) => set.iter().any(Self::matches_empty),
        }
    }

    /// Collects the conditions on which the derivative depends.
    fn next_conditions(&self, found: &mut BTreeSet<usize>) {
        match self {
            Self::Never | Self::Empty | Self::Any => {}
            Self::Step(atom) => {
                found.insert(*atom);
            }
            Self::Not(r) | Self::Star(r) => r.next_conditions(found),
            Self::Sequence(a, b) => {
                a.next_conditions(found);
                if a.matches_empty() {
                    b.next_conditions(found);
                }
            }
            Self::And(set) | Self::Or(set) => set.iter().for_each(|r| r.next_conditions(found)),
        }
    }

    /// Returns the derivative: an expression for the words that can follow a step in which the
    /// conditions have these values.
    fn derivative(&self, values: &Values) -> Self {
        match self {
            Self::Any => Self::Empty,
            Self::Step(atom) if values.get(atom) == Some(&true) => Self::Empty,
            Self::Never | Self::Empty | Self::Step(_) => Self::Never,
            Self::Not(r) => r.derivative(values).not(),
            Self::Star(r) => r.derivative(values).then(self.clone()),
            Self::Sequence(a, b) => {
                let first = a.derivative(values).then((**b).clone());
                if a.matches_empty() {
                    Self::or([first, b.derivative(values)])
                } else {
                    first
                }
            }
            Self::And(set) => Self::and(set.iter().map(|r| r.derivative(values))),
            Self::Or(set) => Self::or(set.iter().map(|r| r.derivative(values))),
        }
    }

    /// Returns the minimal automaton that is in an accepting state exactly after the words that the
    /// expression matches.
    ///
    /// # Errors
    /// When the automaton exceeds the limits of [`Automaton::explore`].
    pub fn automaton(&self) -> Result<Automaton, BoundExceeded> {
        let conditions = |state: &Self| {
            let mut conditions = BTreeSet::new();
            state.next_conditions(&mut conditions);
            conditions.into_iter().collect()
        };
        let step = |state: &Self, values: &Values| Ok(state.derivative(values));
        let found = Automaton::explore(self.clone(), conditions, step, Self::matches_empty)?;
        Ok(found.minimal())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::Decision;

    /// Returns whether an automaton over condition 0 accepts these steps.
    fn accepts(automaton: &Automaton, word: &[bool]) -> bool {
        let mut state = 0;
        for holds in word {
            let mut decision = &automaton.steps[state];
            while let Decision::If(_, yes, no) = decision {
                decision = if *holds { yes } else { no };
            }
            if let Decision::To(next) = decision {
                state = *next;
            }
        }
        automaton.accepting[state]
    }

    #[test]
    fn complement_and_intersection_are_converted() {
        use ExtendedRegex as R;
        let all = || R::Any.star();
        let some = all().then(R::Step(0)).then(all());
        let even = R::Any.then(R::Any).star();
        let both = R::and([even.clone(), some.clone().not()]);
        let automaton = both.automaton().expect("it is small");
        for length in 0..6 {
            for bits in 0..1_u32 << length {
                let word: Vec<bool> = (0..length).map(|i| bits >> i & 1 == 1).collect();
                let wanted = length % 2 == 0 && bits == 0;
                assert_eq!(accepts(&automaton, &word), wanted, "{word:?}");
            }
        }
        // De Morgan's law, by the minimal automata.
        let other = R::or([even.not(), some]).not();
        assert_eq!(other.automaton(), Ok(automaton));
    }
}
