//! Deterministic automata over the conditions that hold in a step: each state branches on the
//! conditions relevant to it.
//!
//! Conditions are numbered and tested in ascending order, as in binary decision diagrams without
//! sharing (Akers, "Binary decision diagrams", 1978). Every step has a successor. The user of the
//! automaton defines the meaning of *accepting*: either that a word can end in the state, or that
//! such states have to recur for ever (Büchi).

use crate::bound::BoundExceeded;
use std::collections::BTreeMap;

/// Maximum number of states before minimization.
pub const MAX_STATES: usize = 2000;
/// Maximum number of conditions that one transition depends on.
pub const MAX_CONDITIONS: usize = 12;

/// Truth value of each condition in a step.
pub type Values = BTreeMap<usize, bool>;

/// Computes the next state, given the values of the conditions.
type Successor<'a> = dyn FnMut(&Values) -> Result<usize, BoundExceeded> + 'a;

/// A decision tree whose leaves are successors; conditions ascend from the root to each leaf.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decision {
    /// Next state.
    To(usize),
    /// Branch on a condition: the decision if it holds, and the decision if it does not.
    If(usize, Box<Decision>, Box<Decision>),
}

impl Decision {
    /// Builds the decision over these conditions, which must be in ascending order. `to` computes
    /// the successor for each choice of values.
    fn over(conditions: &[usize], to: &mut Successor<'_>) -> Result<Self, BoundExceeded> {
        fn grow(
            conditions: &[usize],
            values: &mut Values,
            to: &mut Successor<'_>,
        ) -> Result<Decision, BoundExceeded> {
            let [condition, rest @ ..] = conditions else {
                return to(values).map(Decision::To);
            };
            values.insert(*condition, true);
            let yes = grow(rest, values, to)?;
            values.insert(*condition, false);
            let no = grow(rest, values, to)?;
            values.remove(condition);
            Ok(Decision::branch(*condition, yes, no))
        }
        grow(conditions, &mut Values::new(), to)
    }

    fn branch(condition: usize, yes: Self, no: Self) -> Self {
        if yes == no {
            yes
        } else {
            Self::If(condition, Box::new(yes), Box::new(no))
        }
    }

    /// Replaces each successor `s` by `to(s)`, and merges branches that become equal.
    #[must_use]
    pub fn map_successors(&self, to: &dyn Fn(usize) -> usize) -> Self {
        match self {
            Self::To(state) => Self::To(to(*state)),
            Self::If(condition, yes, no) => {
                Self::branch(*condition, yes.map_successors(to), no.map_successors(to))
            }
        }
    }
}

/// A deterministic automaton; state 0 is the initial state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Automaton {
    /// Decision of every state.
    pub steps: Vec<Decision>,
    /// Whether each state is accepting.
    pub accepting: Vec<bool>,
}

impl Automaton {
    /// Explores all states that are reachable from `start`, which becomes state 0. `conditions`
    /// returns the conditions relevant to a state, in ascending order; `step` returns the next
    /// state for their values.
    ///
    /// # Errors
    /// When there are more than [`MAX_STATES`] states, when more than [`MAX_CONDITIONS`] conditions
    /// are relevant to a state, or when `step` fails.
    pub fn explore<S: Clone + Ord>(
        start: S,
        conditions: impl Fn(&S) -> Vec<usize>,
        mut step: impl FnMut(&S, &Values) -> Result<S, BoundExceeded>,
        accepting: impl Fn(&S) -> bool,
    ) -> Result<Self, BoundExceeded> {
        let mut states = vec![start.clone()];
        let mut numbers = BTreeMap::from([(start, 0)]);
        let mut steps = Vec::new();
        while let Some(state) = states.get(steps.len()).cloned() {
            let deciding = conditions(&state);
            at_most(MAX_CONDITIONS, deciding.len(), "conditions in one step")?;
            let decision = Decision::over(&deciding, &mut |values| {
                let next = step(&state, values)?;
                if let Some(known) = numbers.get(&next) {
                    return Ok(*known);
                }
                at_most(MAX_STATES, states.len() + 1, "states")?;
                numbers.insert(next.clone(), states.len());
                states.push(next);
                Ok(states.len() - 1)
            })?;
            steps.push(decision);
        }
        Ok(Self {
            steps,
            accepting: states.iter().map(accepting).collect(),
        })
    }

    /// Removes unreachable states and numbers the others in breadth-first order.
    #[must_use]
    pub fn reachable(&self) -> Self {
        let (mut order, mut at) = (vec![0], 0);
        while at < order.len() {
            let mut open = vec![&self.steps[order[at]]];
            while let Some(decision) = open.pop() {
                match decision {
                    Decision::To(state) if !order.contains(state) => order.push(*state),
                    Decision::To(_) => {}
                    Decision::If(_, yes, no) => open.extend([&**no, &**yes]),
                }
            }
            at += 1;
        }
        let place = |s: usize| order.iter().position(|o| *o == s).unwrap_or(0);
        Self {
            steps: order
                .iter()
                .map(|s| self.steps[*s].map_successors(&place))
                .collect(),
            accepting: order.iter().map(|s| self.accepting[*s]).collect(),
        }
    }

    /// Merges indistinguishable states (Moore, "Gedanken-experiments on sequential machines",
    /// 1956). Whole decisions are compared, so letters are not enumerated.
    #[must_use]
    pub fn minimal(&self) -> Self {
        let mut class: Vec<usize> = self.accepting.iter().map(|a| usize::from(*a)).collect();
        let mut count = 0;
        loop {
            let mut known = BTreeMap::new();
            let next: Vec<usize> = (0..class.len())
                .map(|s| {
                    let key = (class[s], self.steps[s].map_successors(&|t| class[t]));
                    let new = known.len();
                    *known.entry(key).or_insert(new)
                })
                .collect();
            class = next;
            if known.len() == count {
                break;
            }
            count = known.len();
        }
        // Classes are numbered by their first states, so the initial state stays state 0.
        let first: Vec<usize> = (0..count)
            .filter_map(|c| class.iter().position(|d| *d == c))
            .collect();
        Self {
            steps: first
                .iter()
                .map(|s| self.steps[*s].map_successors(&|t| class[t]))
                .collect(),
            accepting: first.iter().map(|s| self.accepting[*s]).collect(),
        }
    }
}

fn at_most(limit: usize, count: usize, what: &'static str) -> Result<(), BoundExceeded> {
    if count > limit {
        return Err(BoundExceeded::Count { what, limit });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts the steps in which condition 7 holds up to `most`; accepting if the count is a
    /// multiple of `n`.
    fn counting(n: usize, most: usize) -> Result<Automaton, BoundExceeded> {
        let step = |count: &usize, values: &Values| Ok((count + usize::from(values[&7])) % most);
        Automaton::explore(0, |_| vec![7], step, |count| count.is_multiple_of(n))
    }

    #[test]
    fn indistinguishable_states_are_merged() {
        let minimal = counting(3, 12).expect("it is small").minimal();
        assert_eq!(minimal, counting(3, 3).expect("it is small"));
    }

    #[test]
    fn unreachable_states_are_removed() {
        let mut automaton = counting(2, 2).expect("it is small");
        let reachable = automaton.clone();
        automaton.steps.insert(1, Decision::To(0));
        automaton.accepting.insert(1, true);
        let moved = |s: usize| if s == 1 { 2 } else { s };
        automaton.steps[0] = automaton.steps[0].map_successors(&moved);
        automaton.steps[2] = automaton.steps[2].map_successors(&moved);
        assert_eq!(automaton.reachable(), reachable);
    }

    #[test]
    fn the_limit_is_respected() {
        assert!(counting(1, MAX_STATES).is_ok());
        let limit = MAX_STATES;
        let too_large = Err(BoundExceeded::Count {
            what: "states",
            limit,
        });
        assert_eq!(counting(1, MAX_STATES + 1), too_large);
    }
}
