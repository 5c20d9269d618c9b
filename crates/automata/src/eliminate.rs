//! Conversion of an automaton to a short regular expression.
//!
//! States are eliminated one after the other (Brzozowski and `McCluskey`, "Signal flow graph
//! techniques for sequential circuit state diagrams", 1963). The order determines the length of the
//! expression. For few states all orders are tried; otherwise the state whose elimination copies
//! the least text is eliminated first (Delgado and Morais, "Approximation to the smallest regular
//! expression for a given regular language", 2004). The result is checked: it is converted back to
//! an automaton, which is compared with the original.

use crate::bound::{BoundExceeded, ExplorationBound, MAX_DFA_STATES};
use crate::dfa::{Dfa, REFUSED};
use crate::regex::{Regex, automaton};
use linewright_core::deadline::Deadline;

/// Maximum number of states for which all orders are tried.
const MAX_STATES_FOR_ALL_ORDERS: usize = 7;

/// Maximum number of states of the minimal automaton. With more states, the expression would be too
/// long or take too long to compute.
pub const MAX_ELIMINATED_STATES: usize = 512;

/// Maximum size of an expression, in letters and operators. Longer ones are not useful.
pub const MAX_REGEX_SIZE: usize = 1 << 16;

/// Graph whose edges are expressions. The last two states are additional: a start that precedes the
/// start of the automaton, and an end that follows all complete states.
#[derive(Clone)]
struct Graph {
    states: usize,
    between: Vec<Regex>,
}

impl Graph {
    fn new(dfa: &Dfa) -> Self {
        let inner = dfa.state_count();
        let states = inner + 2;
        let (start, end) = (inner, inner + 1);
        let mut classes: Vec<Vec<Regex>> = vec![Vec::new(); states * states];
        for from in 0..inner {
            for letter in 0..dfa.letter_count() {
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
        let letters = dfa.letter_count();
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

    /// Removes a state and adds expressions for the paths through it. `left` are the other states
    /// that have not been eliminated.
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

    /// Returns the size of the expressions that eliminating a state would copy.
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

/// Returns the union of `parts`, which are letters and the empty word. A union of letters is
/// written as a complement if that is shorter.
fn class(parts: Vec<Regex>, letters: usize) -> Regex {
    let is = |letter: &usize| parts.contains(&Regex::Letter(*letter));
    let missing: Vec<usize> = (0..letters).filter(|l| !is(l)).collect();
    if parts.len() > 2 && missing.len() + 1 < parts.len() && !parts.contains(&Regex::Empty) {
        return Regex::AnyBut(missing);
    }
    Regex::either(parts)
}

/// Returns a short expression that matches exactly the words that an automaton accepts.
///
/// # Errors
/// When the minimal automaton has more than [`MAX_ELIMINATED_STATES`] states, when the expression
/// would be larger than [`MAX_REGEX_SIZE`] or too large to be checked, or when the deadline has
/// passed.
///
/// # Panics
/// When the expression does not match the words of the automaton, which would be a bug in this
/// module.
pub fn regex(dfa: &Dfa, deadline: Deadline) -> Result<Regex, BoundExceeded> {
    let dfa = dfa.clone().trimmed().minimal();
    if dfa.state_count() > MAX_ELIMINATED_STATES {
        return Err(BoundExceeded::Count {
            what: "states to convert to a regular expression",
            limit: MAX_ELIMINATED_STATES,
        });
    }
    let graph = Graph::new(&dfa);
    let left: Vec<usize> = (0..dfa.state_count()).collect();
    let found = if left.len() <= MAX_STATES_FOR_ALL_ORDERS {
        let mut best = None;
        shortest(&graph, &left, &mut best);
        best.expect("no elimination order was tried; please report this")
    } else {
        lightest_first(graph, left, deadline)?
    };
    let again = automaton(
        &found,
        dfa.letter_count(),
        ExplorationBound::new(MAX_DFA_STATES, deadline),
    )?;
    assert!(
        again.difference(&dfa).is_none(),
        "the regular expression and the automaton have different words; please report this"
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
        // Elimination never shortens the expression, so an order whose expression is already longer
        // than the best one is abandoned.
        let size = graph.result().size();
        if best.as_ref().is_none_or(|b| size <= b.size()) {
            shortest(&graph, &rest, best);
        }
    }
}

fn lightest_first(
    mut graph: Graph,
    mut left: Vec<usize>,
    deadline: Deadline,
) -> Result<Regex, BoundExceeded> {
    while !left.is_empty() {
        deadline.check()?;
        let weights = left.iter().enumerate();
        let lightest = weights.min_by_key(|(_, state)| graph.weight(**state, &left));
        let (place, _) = lightest.expect("no state is left to eliminate; please report this");
        let state = left.remove(place);
        graph.eliminate(state, &left);
        if graph.between.iter().map(Regex::size).sum::<usize>()
            > MAX_REGEX_SIZE + graph.between.len()
        {
            return Err(BoundExceeded::Count {
                what: "skills and operators in the regular expression",
                limit: MAX_REGEX_SIZE,
            });
        }
    }
    Ok(graph.result().clone())
}
