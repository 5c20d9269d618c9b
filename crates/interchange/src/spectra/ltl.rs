//! Formulas of linear temporal logic as deterministic Büchi automata, for the published patterns.
//!
//! A state is what is left to be kept after the steps so far: a conjunction of disjunctions of temporal formulas (progression:
//! Bacchus, Kabanza: Using Temporal Logics to Express Search Control Knowledge, Artificial Intelligence 2000). A disjunction with a
//! `release` in it is kept by going on; one without, a *debt*, has to be paid some day. Debts are paid in rounds: those that are there
//! when a round begins are watched until none is left, which is accepting (the break-point construction of Miyano and Hayashi,
//! Theoretical Computer Science 1984).
//!
//! That is right for formulas in which no `until` holds a `release`, as those of the patterns.

use super::automaton::{Automaton, MAX_STATES, Tree};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A formula; negations stand before atoms only.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Ltl {
    Constant(bool),
    /// An atom, or its negation.
    Atom(usize, bool),
    And(Rc<Ltl>, Rc<Ltl>),
    Or(Rc<Ltl>, Rc<Ltl>),
    Next(Rc<Ltl>),
    Until(Rc<Ltl>, Rc<Ltl>),
    Release(Rc<Ltl>, Rc<Ltl>),
}

use Ltl as L;

impl Ltl {
    pub fn and(self, other: Self) -> Self {
        L::And(Rc::new(self), Rc::new(other))
    }

    pub fn or(self, other: Self) -> Self {
        L::Or(Rc::new(self), Rc::new(other))
    }

    pub fn next(self) -> Self {
        L::Next(Rc::new(self))
    }

    pub fn until(self, other: Self) -> Self {
        L::Until(Rc::new(self), Rc::new(other))
    }

    /// `self` until `other`, or for ever.
    pub fn unless(self, other: Self) -> Self {
        L::Release(Rc::new(other.clone()), Rc::new(self.or(other)))
    }

    pub fn eventually(self) -> Self {
        L::Constant(true).until(self)
    }

    pub fn always(self) -> Self {
        L::Release(Rc::new(L::Constant(false)), Rc::new(self))
    }

    pub fn not(&self) -> Self {
        let both = |a: &Rc<Self>, b: &Rc<Self>| (Rc::new(a.not()), Rc::new(b.not()));
        match self {
            L::Constant(value) => L::Constant(!value),
            L::Atom(atom, value) => L::Atom(*atom, !value),
            L::And(a, b) => {
                let (a, b) = both(a, b);
                L::Or(a, b)
            }
            L::Or(a, b) => {
                let (a, b) = both(a, b);
                L::And(a, b)
            }
            L::Next(a) => L::Next(Rc::new(a.not())),
            L::Until(a, b) => {
                let (a, b) = both(a, b);
                L::Release(a, b)
            }
            L::Release(a, b) => {
                let (a, b) = both(a, b);
                L::Until(a, b)
            }
        }
    }

    pub fn implies(self, other: Self) -> Self {
        self.not().or(other)
    }

    fn has_release(&self) -> bool {
        match self {
            L::Constant(_) | L::Atom(..) => false,
            L::Release(..) => true,
            L::Next(a) => a.has_release(),
            L::And(a, b) | L::Or(a, b) | L::Until(a, b) => a.has_release() || b.has_release(),
        }
    }
}

/// One of its formulas has to hold.
type Clause = BTreeSet<Ltl>;
/// All of its clauses have to hold, from the next step on.
type State = BTreeSet<Clause>;

fn constant(value: bool) -> State {
    if value {
        State::new()
    } else {
        State::from([Clause::new()])
    }
}

/// Without clauses that others imply.
fn least(clauses: &State) -> State {
    let implied = |c: &Clause| clauses.iter().any(|d| d != c && d.is_subset(c));
    clauses.iter().filter(|c| !implied(c)).cloned().collect()
}

fn and(a: State, b: State) -> State {
    least(&a.into_iter().chain(b).collect())
}

fn or(a: &State, b: &State) -> State {
    let pairs = a.iter().flat_map(|x| b.iter().map(move |y| x | y));
    least(&pairs.collect())
}

/// A formula about the steps to come.
fn state(formula: &Ltl) -> State {
    match formula {
        L::Constant(value) => constant(*value),
        L::And(a, b) => and(state(a), state(b)),
        L::Or(a, b) => or(&state(a), &state(b)),
        other => State::from([Clause::from([other.clone()])]),
    }
}

/// What is left of a formula after a step.
fn after(formula: &Ltl, letter: &BTreeMap<usize, bool>) -> State {
    match formula {
        L::Constant(value) => constant(*value),
        L::Atom(atom, value) => constant(letter.get(atom) == Some(value)),
        L::And(a, b) => and(after(a, letter), after(b, letter)),
        L::Or(a, b) => or(&after(a, letter), &after(b, letter)),
        L::Next(a) => state(a),
        L::Until(a, b) => or(&after(b, letter), &and(after(a, letter), state(formula))),
        L::Release(a, b) => and(after(b, letter), or(&after(a, letter), &state(formula))),
    }
}

fn all_after(clauses: &State, letter: &BTreeMap<usize, bool>) -> State {
    let mut found = constant(true);
    for clause in clauses {
        let mut left = constant(false);
        for formula in clause {
            left = or(&left, &after(formula, letter));
        }
        found = and(found, left);
    }
    found
}

/// What is left, the debts that are watched, and whether a round has just ended.
type Round = (State, State, bool);

/// The automaton of a formula over the atoms 0 to `atoms - 1`; `None` if it becomes too large.
pub(super) fn automaton(formula: &Ltl, atoms: usize) -> Option<Automaton> {
    let atoms: Vec<usize> = (0..atoms).collect();
    let first: Round = (state(formula), State::new(), false);
    let mut states = vec![first.clone()];
    let mut known = BTreeMap::from([(first, 0)]);
    let mut steps = Vec::new();
    while steps.len() < states.len() {
        if states.len() > MAX_STATES {
            return None;
        }
        let (left, watched, _) = states[steps.len()].clone();
        steps.push(Tree::over(&atoms, &mut |letter| {
            let left = all_after(&left, letter);
            let mut watched = all_after(&watched, letter);
            let paid = watched.is_empty() && left != constant(false);
            if paid {
                let debts = left.iter().filter(|c| !c.iter().any(L::has_release));
                watched = debts.cloned().collect();
            }
            let next = (left, watched, paid);
            *known.entry(next.clone()).or_insert_with(|| {
                states.push(next);
                states.len() - 1
            })
        }));
    }
    let accepting = states.iter().map(|(_, _, paid)| *paid).collect();
    Some(Automaton { steps, accepting }.minimal())
}
