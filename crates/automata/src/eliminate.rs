//! From an automaton to a short regular expression.
//!
//! States are eliminated one after the other (Brzozowski and `McCluskey`, "Signal flow graph
//! techniques for sequential circuit state diagrams", 1963). The order determines the length of the
//! expression. For few states all orders are tried; otherwise the state through which the least
//! text would be copied goes first (Delgado and Morais, "Approximation to the smallest regular
//! expression for a given regular language", 2004). The result is converted back to an automaton
//! and compared.

use crate::bound::{BoundExceeded, ExplorationBound, MOST_STATES};
use crate::dfa::{Dfa, REFUSED};
use crate::regex::{Regex, automaton};
use linewright_core::deadline::Deadline;

/// Maximum number of states for which all orders are tried.
const ALL_ORDERS: usize = 7;

/// Maximum number of states of the minimal automaton. With more, an expression would be too long or
/// take too long to make.
pub const MOST_ELIMINATED: usize = 512;

/// Maximum size of a useful expression.
pub const MOST_SIZE: usize = 1 << 16;

/// Expressions between any two states. The last two states are a start before the start and an end
/// behind all complete states.
#[derive(Clone)]
struct Graph {
    states: usize,
    between: Vec<Regex>,
}

impl Graph {
    fn new(dfa: &Dfa) -> Self {
        let inner = dfa.states();
        let states = inner + 2;
        let (start, end) = (inner, inner + 1);
        let mut classes: Vec<Vec<Regex>> = vec![Vec::new(); states * states];
        for from in 0..inner {
            for letter in 0..dfa.letters() {
                let to = dfa.next(from as u32, letter);
                if to != REFUSED {
                    classes[from * states + to as usize].push(Regex::Letter(letter));
                }
            }
            if dfa.is_complete(from as u32) {
                classes[from * states + end].push(Regex::Empty);
            }
        }
        classes[start * states].push(Regex::Empty);
        let letters = dfa.letters();
        Self {
            states,
            between: classes.into_iter().map(|c| class(c, letters)).collect(),
        }
    }

    fn at(&self, from: usize, to: usize) -> &Regex {
        &self.between[from * self.states + to]
    }

    fn neighbours(&self, state: usize, left: &[usize]) -> (Vec<usize>, Vec<usize>) {
        let is = |from: usize, to: usize| from != to && *self.at(from, to) != Regex::Nothing;
        let ends = [self.states - 2, self.states - 1];
        let others = || left.iter().chain(&ends).copied();
        let before = others().filter(|s| is(*s, state)).collect();
        let after = others().filter(|s| is(state, *s)).collect();
        (before, after)
    }

    /// Removes a state and replaces the paths through it.
    fn eliminate(&mut self, state: usize, left: &[usize]) {
        let (before, after) = self.neighbours(state, left);
        let around = self.at(state, state).clone().star();
        for from in before {
            for to in &after {
                let through = Regex::concat([
                    self.at(from, state).clone(),
                    around.clone(),
                    self.at(state, *to).clone(),
                ]);
                let direct = self.at(from, *to).clone();
                self.between[from * self.states + to] = Regex::either([direct, through]);
            }
        }
        for other in 0..self.states {
            self.between[other * self.states + state] = Regex::Nothing;
            self.between[state * self.states + other] = Regex::Nothing;
        }
    }

    /// Returns how much text eliminating a state copies.
    fn weight(&self, state: usize, left: &[usize]) -> usize {
        let (before, after) = self.neighbours(state, left);
        let size = |from, to| self.at(from, to).size();
        let incoming: usize = before.iter().map(|s| size(*s, state)).sum();
        let outgoing: usize = after.iter().map(|s| size(state, *s)).sum();
        let around = match self.at(state, state) {
            Regex::Nothing => 0,
            other => other.size(),
        };
        incoming * after.len() + outgoing * before.len() + around * before.len() * after.len()
    }

    fn result(&self) -> &Regex {
        self.at(self.states - 2, self.states - 1)
    }
}

/// Returns one of several letters, written as a complement if that is shorter.
fn class(parts: Vec<Regex>, letters: usize) -> Regex {
    let is = |letter: &usize| parts.contains(&Regex::Letter(*letter));
    let missing: Vec<usize> = (0..letters).filter(|l| !is(l)).collect();
    if parts.len() > 2 && missing.len() + 1 < parts.len() && !parts.contains(&Regex::Empty) {
        return Regex::AnyBut(missing);
    }
    Regex::either(parts)
}

/// Returns a short expression with the words of an automaton.
///
/// # Errors
/// When there are more than [`MOST_ELIMINATED`] states, when the expression would be longer than
/// [`MOST_SIZE`] or is too large to be compared, or when the deadline has passed.
///
/// # Panics
/// When the expression does not have the words of the automaton, which would be a bug in this
/// module.
pub fn regex(dfa: &Dfa, until: Deadline) -> Result<Regex, BoundExceeded> {
    let dfa = dfa.clone().trimmed().minimal();
    if dfa.states() > MOST_ELIMINATED {
        return Err(BoundExceeded::Count {
            what: "states to make a regular expression of",
            limit: MOST_ELIMINATED,
        });
    }
    let graph = Graph::new(&dfa);
    let left: Vec<usize> = (0..dfa.states()).collect();
    let found = if left.len() <= ALL_ORDERS {
        let mut best = None;
        shortest(&graph, &left, &mut best);
        best.expect("some order; please report this")
    } else {
        lightest_first(graph, left, until)?
    };
    let again = automaton(
        &found,
        dfa.letters(),
        ExplorationBound::new(MOST_STATES, until),
    )?;
    assert!(
        again.difference(&dfa).is_none(),
        "the regular expression has other words than the automaton; please report this"
    );
    Ok(found)
}

fn shortest(graph: &Graph, left: &[usize], best: &mut Option<Regex>) {
    if left.is_empty() {
        let found = graph.result();
        if best.as_ref().is_none_or(|b| found.size() < b.size()) {
            *best = Some(found.clone());
        }
        return;
    }
    for (i, state) in left.iter().enumerate() {
        let mut rest = left.to_vec();
        rest.remove(i);
        let mut graph = graph.clone();
        graph.eliminate(*state, &rest);
        // If the expression between the ends is already longer, it can only grow.
        let size = graph.result().size();
        if best.as_ref().is_none_or(|b| size <= b.size()) {
            shortest(&graph, &rest, best);
        }
    }
}

fn lightest_first(
    mut graph: Graph,
    mut left: Vec<usize>,
    until: Deadline,
) -> Result<Regex, BoundExceeded> {
    while !left.is_empty() {
        until.check()?;
        let weights = left.iter().enumerate();
        let lightest = weights.min_by_key(|(_, state)| graph.weight(**state, &left));
        let (place, _) = lightest.expect("some are left; please report this");
        let state = left.remove(place);
        graph.eliminate(state, &left);
        if graph.between.iter().map(Regex::size).sum::<usize>() > MOST_SIZE + graph.between.len() {
            return Err(BoundExceeded::Count {
                what: "skills and operators in the regular expression",
                limit: MOST_SIZE,
            });
        }
    }
    Ok(graph.result().clone())
}
