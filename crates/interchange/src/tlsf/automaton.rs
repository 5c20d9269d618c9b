//! Deterministic automata that monitor safety formulas.
//!
//! The atoms of the formula are conditions on a single step. Only the truth assignments to the
//! atoms that some values of the variables produce are considered; the others are don't-cares.

use super::ltl::{FormulaId, Formulas, Op};
use linewright_automata::dfa::Dfa;
use linewright_automata::ltl::{self, Formula, Limits, Node};
use linewright_core::gr1::eval::holds;
use linewright_core::gr1::{Expr, UnaryOp};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of states of a monitor.
const MAX_STATES: usize = 48;
/// Limits of the automaton before minimization.
const LIMITS: Limits = Limits {
    states: 4 * MAX_STATES,
    alternatives: 48,
};
/// Maximum number of different conditions on a step.
const MAX_LETTERS: usize = 8;
/// Maximum number of variables whose values are enumerated for a condition.
const MAX_VARIABLES: usize = 12;

/// A deterministic automaton that rejects the prefixes that violate its formula.
#[derive(Debug, Clone)]
pub(super) struct Automaton {
    /// The conditions on a step.
    letters: Vec<Expr>,
    /// The combinations of letters that can occur, each as a set of bits. They form the alphabet of
    /// `dfa`.
    possible: Vec<u32>,
    dfa: Dfa,
}

struct Builder {
    made: ltl::Formulas,
    letters: Vec<Expr>,
    /// Nodes of formulas and of their negations; `a <-> b` needs both for each operand.
    known: BTreeMap<(FormulaId, bool), Node>,
}

/// The automaton of a safety formula; `None` if it is too large. `state` returns the expression of
/// a formula about a single step.
pub(super) fn of(
    formulas: &Formulas,
    f: FormulaId,
    state: &dyn Fn(FormulaId) -> Option<Expr>,
) -> Option<Automaton> {
    let mut builder = Builder {
        made: ltl::Formulas::default(),
        letters: Vec::new(),
        known: BTreeMap::new(),
    };
    let root = builder.node(formulas, f, false, state)?;
    let possible = builder.possible();
    let dfa = ltl::safety(&builder.made, root, &possible, LIMITS).ok()?;
    (dfa.state_count() <= MAX_STATES).then_some(Automaton {
        letters: builder.letters,
        possible,
        dfa,
    })
}

impl Builder {
    /// The node of a formula or of its negation. The recursion is as deep as the formula.
    fn node(
        &mut self,
        formulas: &Formulas,
        f: FormulaId,
        negated: bool,
        state: &dyn Fn(FormulaId) -> Option<Expr>,
    ) -> Option<Node> {
        if let Some(known) = self.known.get(&(f, negated)) {
            return Some(*known);
        }
        let found = self.node_of(formulas, f, negated, state)?;
        self.known.insert((f, negated), found);
        Some(found)
    }

    fn node_of(
        &mut self,
        formulas: &Formulas,
        f: FormulaId,
        negated: bool,
        state: &dyn Fn(FormulaId) -> Option<Expr>,
    ) -> Option<Node> {
        if formulas.is_state(f) {
            let expr = state(f)?.simplify();
            let (expr, negated) = match expr {
                Expr::Unary(UnaryOp::Not, inner) => (*inner, !negated),
                expr => (expr, negated),
            };
            if let Expr::Const(value) = expr {
                return Some(self.made.constant((value != 0) != negated));
            }
            let found = self.letters.iter().position(|l| *l == expr);
            let letter = found.unwrap_or(self.letters.len());
            if found.is_none() {
                if letter >= MAX_LETTERS {
                    return None;
                }
                self.letters.push(expr);
            }
            return Some(self.made.node(Formula::Atom(letter, !negated)));
        }
        let op = formulas.op(f).clone();
        let mut inner = |g: FormulaId, negated: bool| self.node(formulas, g, negated, state);
        let found = match op {
            Op::Not(a) => return inner(a, !negated),
            Op::And(list) | Op::Or(list) => {
                let and = matches!(formulas.op(f), Op::And(_)) != negated;
                let list: Option<Vec<Node>> = list.into_iter().map(|g| inner(g, negated)).collect();
                if and {
                    Formula::And(list?)
                } else {
                    Formula::Or(list?)
                }
            }
            Op::Implies(a, b) => {
                let list = vec![inner(a, !negated)?, inner(b, negated)?];
                if negated {
                    Formula::And(list)
                } else {
                    Formula::Or(list)
                }
            }
            Op::Iff(a, b) => {
                let (p, q) = (inner(a, false)?, inner(b, false)?);
                let (r, s) = (inner(a, true)?, inner(b, true)?);
                let (one, two) = if negated {
                    ([p, q], [r, s])
                } else {
                    ([r, q], [p, s])
                };
                let both = [one, two].map(|list| self.made.node(Formula::Or(list.into())));
                Formula::And(both.into())
            }
            Op::Next(a) => Formula::Next(inner(a, negated)?),
            Op::Globally(a) if !negated => {
                let a = inner(a, false)?;
                return Some(self.made.always(a));
            }
            Op::Weak(a, b) if !negated => Formula::Weak(inner(a, false)?, inner(b, false)?),
            Op::Release(a, b) if !negated => Formula::Release(inner(a, false)?, inner(b, false)?),
            _ => return None,
        };
        Some(self.made.node(found))
    }

    /// The combinations of letters that some values of the variables produce; all of them if there
    /// are too many variables to enumerate.
    fn possible(&self) -> Vec<u32> {
        let mut variables = BTreeSet::new();
        for letter in &self.letters {
            letter.for_each_var(&mut |v, _| {
                variables.insert(v);
            });
        }
        let all = 1_u32 << self.letters.len();
        if variables.len() > MAX_VARIABLES {
            return (0..all).collect();
        }
        let size = variables.iter().map(|v| v.index() + 1).max().unwrap_or(0);
        let mut found = BTreeSet::new();
        for choice in 0..1_u32 << variables.len() {
            let mut values = vec![0; size];
            for (k, v) in variables.iter().enumerate() {
                values[v.index()] = i64::from(choice >> k & 1);
            }
            let letters = self.letters.iter().enumerate();
            found.insert(letters.fold(0, |bits, (k, l)| {
                bits | u32::from(holds(l, &values, &[])) << k
            }));
        }
        found.into_iter().collect()
    }
}

impl Automaton {
    /// Number of states.
    pub fn state_count(&self) -> usize {
        self.dfa.state_count()
    }

    /// An expression over the current state and the letters. Its value is `of` applied to the next
    /// state, or to `None` after a violation.
    ///
    /// `now` returns the expression that is true in a given state.
    pub fn by_state(&self, now: &dyn Fn(usize) -> Expr, of: &dyn Fn(Option<u32>) -> i64) -> Expr {
        let rows: Vec<Expr> = (0..self.state_count() as u32)
            .map(|s| {
                let row = self
                    .possible
                    .iter()
                    .enumerate()
                    .map(|(l, bits)| (*bits, of(self.dfa.step(s, l))));
                self.decision_tree(&row.collect::<Vec<_>>(), 0)
            })
            .collect();
        let mut result = rows[rows.len() - 1].clone();
        for s in (0..rows.len() - 1).rev() {
            if rows[s] != result || s + 2 < rows.len() {
                let (c, a) = (Box::new(now(s)), Box::new(rows[s].clone()));
                result = Expr::If(c, a, Box::new(result));
            }
        }
        result.simplify()
    }

    /// A decision tree over the letters with index `from` and higher. Impossible combinations are
    /// don't-cares.
    fn decision_tree(&self, row: &[(u32, i64)], from: usize) -> Expr {
        let value = row.first().map_or(0, |r| r.1);
        if row.iter().all(|r| r.1 == value) || from >= self.letters.len() {
            return Expr::Const(value);
        }
        let (yes, no): (Vec<_>, Vec<_>) = row.iter().partition(|r| r.0 >> from & 1 == 1);
        if yes.is_empty() || no.is_empty() {
            return self.decision_tree(row, from + 1);
        }
        let (a, b) = (
            self.decision_tree(&yes, from + 1),
            self.decision_tree(&no, from + 1),
        );
        if a == b {
            return a;
        }
        Expr::If(
            Box::new(self.letters[from].clone()),
            Box::new(a),
            Box::new(b),
        )
    }
}
