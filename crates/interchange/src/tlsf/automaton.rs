//! What breaks after finitely many steps, watched by a deterministic automaton over subformulas.
//!
//! A state is what is still to be kept: obligations on the steps from now on, as a disjunction of conjunctions of subformulas.
//! A step replaces each by what it asks of the rest (progression: Bacchus and Kabanza, Planning for temporally extended goals,
//! 1998). States that cannot be told apart are joined, and the one in which nothing can help is the end.

use super::ltl::{F, Formulas, Op};
use super::states::{State, and, joined, or};
use linewright_core::gr1::Expr;
use linewright_core::gr1::eval::holds;
use std::collections::{BTreeMap, BTreeSet};

/// So many states are worth having in a monitor.
const MAX_STATES: usize = 48;
/// So many different conditions on a step may occur.
const MAX_LETTERS: usize = 8;
/// Conditions are tried on all values of so many variables at most.
const MAX_VARIABLES: usize = 12;
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    True,
    False,
    /// A condition on the step, or its negation.
    Letter(usize, bool),
    And(Vec<u32>),
    Or(Vec<u32>),
    Next(u32),
    Globally(u32),
    Weak(u32, u32),
    Release(u32, u32),
}

/// A deterministic automaton; state 0 is the first.
#[derive(Debug, Clone)]
pub(super) struct Automaton {
    /// The conditions on a step.
    pub letters: Vec<Expr>,
    /// For each state and each possible choice of conditions (as bits) the next state, `None` if the formula is broken.
    pub steps: Vec<BTreeMap<u32, Option<usize>>>,
}

struct Builder {
    nodes: Vec<Node>,
    known: BTreeMap<Node, u32>,
    letters: Vec<Expr>,
    progress: BTreeMap<(u32, u32), State>,
    /// Formulas and their negations as nodes: `a <-> b` asks for both of both.
    made: BTreeMap<(F, bool), u32>,
}

/// The automaton of a safety formula; `None` where it would become too large. `state` gives the expression of a formula about one
/// step.
pub(super) fn of(
    formulas: &Formulas,
    f: F,
    state: &dyn Fn(F) -> Option<Expr>,
) -> Option<Automaton> {
    let mut builder = Builder {
        nodes: Vec::new(),
        known: BTreeMap::new(),
        letters: Vec::new(),
        progress: BTreeMap::new(),
        made: BTreeMap::new(),
    };
    let root = builder.node(formulas, f, false, state)?;
    let possible = builder.possible();
    let first = builder.lifted(root)?;
    let mut states = vec![first.clone()];
    let mut index = BTreeMap::from([(first, 0)]);
    let mut steps: Vec<BTreeMap<u32, Option<usize>>> = Vec::new();
    while let Some(state) = states.get(steps.len()).cloned() {
        let mut row = BTreeMap::new();
        for letter in &possible {
            let next = builder.step(&state, *letter)?;
            let target = if next.is_empty() {
                None
            } else if let Some(known) = index.get(&next) {
                Some(*known)
            } else {
                if states.len() >= 4 * MAX_STATES {
                    return None;
                }
                index.insert(next.clone(), states.len());
                states.push(next);
                Some(states.len() - 1)
            };
            row.insert(*letter, target);
        }
        steps.push(row);
    }
    let steps = joined(&steps);
    (steps.len() <= MAX_STATES).then_some(Automaton {
        letters: builder.letters,
        steps,
    })
}

impl Builder {
    fn push(&mut self, node: Node) -> u32 {
        let next = self.nodes.len() as u32;
        *self.known.entry(node.clone()).or_insert_with(|| {
            self.nodes.push(node);
            next
        })
    }

    /// The recursion is as deep as the formula.
    fn node(
        &mut self,
        formulas: &Formulas,
        f: F,
        negated: bool,
        state: &dyn Fn(F) -> Option<Expr>,
    ) -> Option<u32> {
        if let Some(known) = self.made.get(&(f, negated)) {
            return Some(*known);
        }
        let found = self.node_of(formulas, f, negated, state)?;
        self.made.insert((f, negated), found);
        Some(found)
    }

    fn node_of(
        &mut self,
        formulas: &Formulas,
        f: F,
        negated: bool,
        state: &dyn Fn(F) -> Option<Expr>,
    ) -> Option<u32> {
        if formulas.is_state(f) {
            let expr = state(f)?.simplify();
            let (expr, negated) = match expr {
                Expr::Unary(linewright_core::gr1::UnaryOp::Not, inner) => (*inner, !negated),
                expr => (expr, negated),
            };
            if let Expr::Const(value) = expr {
                return Some(self.push(if (value != 0) == negated {
                    Node::False
                } else {
                    Node::True
                }));
            }
            let found = self.letters.iter().position(|l| *l == expr);
            let letter = found.unwrap_or(self.letters.len());
            if found.is_none() {
                if letter >= MAX_LETTERS {
                    return None;
                }
                self.letters.push(expr);
            }
            return Some(self.push(Node::Letter(letter, !negated)));
        }
        let op = formulas.op(f).clone();
        let mut inner = |g: F, negated: bool| self.node(formulas, g, negated, state);
        let node = match op {
            Op::Not(a) => return inner(a, !negated),
            Op::And(list) | Op::Or(list) => {
                let and = matches!(formulas.op(f), Op::And(_)) != negated;
                let list: Option<Vec<u32>> = list.into_iter().map(|g| inner(g, negated)).collect();
                if and {
                    Node::And(list?)
                } else {
                    Node::Or(list?)
                }
            }
            Op::Implies(a, b) => {
                let list = vec![inner(a, !negated)?, inner(b, negated)?];
                if negated {
                    Node::And(list)
                } else {
                    Node::Or(list)
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
                let (one, two) = (
                    self.push(Node::Or(one.into())),
                    self.push(Node::Or(two.into())),
                );
                Node::And(vec![one, two])
            }
            Op::Next(a) => Node::Next(inner(a, negated)?),
            Op::Globally(a) if !negated => Node::Globally(inner(a, false)?),
            Op::Weak(a, b) if !negated => Node::Weak(inner(a, false)?, inner(b, false)?),
            Op::Release(a, b) if !negated => Node::Release(inner(a, false)?, inner(b, false)?),
            _ => return None,
        };
        Some(self.push(node))
    }

    /// The choices of conditions that some values of the variables make.
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

    /// A formula as a state: what is to be kept from here on.
    fn lifted(&self, node: u32) -> Option<State> {
        match &self.nodes[node as usize] {
            Node::True => Some(State::from([BTreeSet::new()])),
            Node::False => Some(State::new()),
            Node::And(list) => {
                let mut all = State::from([BTreeSet::new()]);
                for part in list {
                    all = and(&all, &self.lifted(*part)?)?;
                }
                Some(all)
            }
            Node::Or(list) => {
                let mut all = State::new();
                for part in list {
                    all = or(all, self.lifted(*part)?)?;
                }
                Some(all)
            }
            _ => Some(State::from([BTreeSet::from([node])])),
        }
    }

    fn step(&mut self, state: &State, letter: u32) -> Option<State> {
        let mut result = State::new();
        for term in state {
            let mut all = State::from([BTreeSet::new()]);
            for obligation in term {
                all = and(&all, &self.after(*obligation, letter)?)?;
                if all.is_empty() {
                    break;
                }
            }
            result = or(result, all)?;
        }
        Some(result)
    }

    /// What a formula asks of the steps after one with these conditions.
    fn after(&mut self, node: u32, letter: u32) -> Option<State> {
        if let Some(known) = self.progress.get(&(node, letter)) {
            return Some(known.clone());
        }
        let truth = |t: bool| {
            if t {
                State::from([BTreeSet::new()])
            } else {
                State::new()
            }
        };
        let itself = State::from([BTreeSet::from([node])]);
        let found = match self.nodes[node as usize].clone() {
            Node::True => truth(true),
            Node::False => truth(false),
            Node::Letter(k, wanted) => truth((letter >> k & 1 == 1) == wanted),
            Node::And(list) => {
                let mut all = truth(true);
                for part in list {
                    all = and(&all, &self.after(part, letter)?)?;
                }
                all
            }
            Node::Or(list) => {
                let mut all = truth(false);
                for part in list {
                    all = or(all, self.after(part, letter)?)?;
                }
                all
            }
            Node::Next(a) => self.lifted(a)?,
            Node::Globally(a) => and(&self.after(a, letter)?, &itself)?,
            Node::Weak(a, b) => {
                let on = and(&self.after(a, letter)?, &itself)?;
                or(self.after(b, letter)?, on)?
            }
            Node::Release(a, b) => {
                let on = or(self.after(a, letter)?, itself)?;
                and(&self.after(b, letter)?, &on)?
            }
        };
        self.progress.insert((node, letter), found.clone());
        Some(found)
    }
}

impl Automaton {
    /// An expression over a state and conditions: in each state what `of` gives for the next one.
    pub fn by_state(&self, now: &dyn Fn(usize) -> Expr, of: &dyn Fn(Option<usize>) -> i64) -> Expr {
        let rows: Vec<Expr> = (0..self.steps.len())
            .map(|s| {
                let row: Vec<(u32, i64)> =
                    self.steps[s].iter().map(|(l, t)| (*l, of(*t))).collect();
                self.decided(&row, 0)
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

    /// Conditions are asked from the first on; what cannot be does not matter.
    fn decided(&self, row: &[(u32, i64)], from: usize) -> Expr {
        let value = row.first().map_or(0, |r| r.1);
        if row.iter().all(|r| r.1 == value) || from >= self.letters.len() {
            return Expr::Const(value);
        }
        let (yes, no): (Vec<_>, Vec<_>) = row.iter().partition(|r| r.0 >> from & 1 == 1);
        if yes.is_empty() || no.is_empty() {
            return self.decided(row, from + 1);
        }
        let (a, b) = (self.decided(&yes, from + 1), self.decided(&no, from + 1));
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
