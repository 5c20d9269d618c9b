//! Deterministic automata over the steps of a run, with Büchi acceptance: what triggers and published patterns come to.
//!
//! An automaton reads truth values, its *atoms*, in each step. Its state is an internal variable of the machine: the value in step t
//! comes from the steps before t, so the machine has no choice in it. That an accepting state is visited again and again is assumed or
//! guaranteed.

use super::reader::Reader;
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Domain, Expr, Formula, Owner};
use linewright_core::source::Span;
use std::collections::BTreeMap;

/// An automaton may have so many states before it is made minimal.
pub(super) const MAX_STATES: usize = 2000;
/// So many atoms may decide one transition.
pub(super) const MAX_ATOMS: usize = 12;

/// A decision between successors, atoms in rising order.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Tree {
    To(usize),
    If(usize, Box<Tree>, Box<Tree>),
}

impl Tree {
    /// The tree over some atoms, in rising order, whose leaves are `to`.
    pub fn over(atoms: &[usize], to: &mut dyn FnMut(&BTreeMap<usize, bool>) -> usize) -> Self {
        fn grow(
            atoms: &[usize],
            values: &mut BTreeMap<usize, bool>,
            to: &mut dyn FnMut(&BTreeMap<usize, bool>) -> usize,
        ) -> Tree {
            let [atom, rest @ ..] = atoms else {
                return Tree::To(to(values));
            };
            values.insert(*atom, true);
            let yes = grow(rest, values, to);
            values.insert(*atom, false);
            let no = grow(rest, values, to);
            values.remove(atom);
            Tree::decide(*atom, yes, no)
        }
        grow(atoms, &mut BTreeMap::new(), to)
    }

    fn decide(atom: usize, yes: Self, no: Self) -> Self {
        if yes == no {
            yes
        } else {
            Self::If(atom, Box::new(yes), Box::new(no))
        }
    }

    /// The same with other successors.
    pub fn renamed(&self, to: &dyn Fn(usize) -> usize) -> Self {
        match self {
            Self::To(state) => Self::To(to(*state)),
            Self::If(atom, yes, no) => Self::decide(*atom, yes.renamed(to), no.renamed(to)),
        }
    }

    fn value(&self, atoms: &[Value]) -> Value {
        match self {
            Self::To(state) => Value::int(*state as i64),
            Self::If(atom, yes, no) => {
                Value::choose(atoms[*atom].clone(), yes.value(atoms), no.value(atoms))
            }
        }
    }
}

/// An automaton; it begins in state 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Automaton {
    pub steps: Vec<Tree>,
    pub accepting: Vec<bool>,
}

impl Automaton {
    /// The same without states that no run reaches.
    pub fn reached(&self) -> Self {
        let (mut order, mut at) = (vec![0], 0);
        while at < order.len() {
            let mut open = vec![&self.steps[order[at]]];
            while let Some(tree) = open.pop() {
                match tree {
                    Tree::To(state) if !order.contains(state) => order.push(*state),
                    Tree::To(_) => {}
                    Tree::If(_, yes, no) => open.extend([&**no, &**yes]),
                }
            }
            at += 1;
        }
        let place = |s: usize| order.iter().position(|o| *o == s).unwrap_or(0);
        Self {
            steps: order
                .iter()
                .map(|s| self.steps[*s].renamed(&place))
                .collect(),
            accepting: order.iter().map(|s| self.accepting[*s]).collect(),
        }
    }

    /// The same without states that nothing tells apart.
    pub fn minimal(&self) -> Self {
        let mut class: Vec<usize> = self.accepting.iter().map(|a| usize::from(*a)).collect();
        let mut count = 0;
        loop {
            let mut known = BTreeMap::new();
            let next: Vec<usize> = (0..class.len())
                .map(|s| {
                    let key = (class[s], self.steps[s].renamed(&|t| class[t]));
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
        // Classes are numbered by their first states, so the first one stays state 0.
        let first: Vec<usize> = (0..count)
            .filter_map(|c| class.iter().position(|d| *d == c))
            .collect();
        Self {
            steps: first
                .iter()
                .map(|s| self.steps[*s].renamed(&|t| class[t]))
                .collect(),
            accepting: first.iter().map(|s| self.accepting[*s]).collect(),
        }
    }
}

impl Reader {
    /// Adds an automaton's state, and that it is accepted.
    pub fn follow(
        &mut self,
        automaton: &Automaton,
        stem: &str,
        atoms: &[Value],
        side: Owner,
        span: Span,
    ) -> Option<()> {
        let count = automaton.steps.len();
        if automaton.accepting.iter().all(|a| *a) {
            return Some(());
        }
        let domain = Domain::Range {
            low: 0,
            high: count as i64 - 1,
        };
        let name = self.fresh(stem);
        let state = self.variables(&name, Owner::System, true, (domain, Vec::new()), span)?;
        let is = |s: usize| {
            let state = Value::leaf(Expr::now(state.first), Kind::Int);
            Value::binary(BinaryOp::Eq, state, Value::int(s as i64))
        };
        let mut update = automaton.steps[count - 1].value(atoms);
        for s in (0..count - 1).rev() {
            update = Value::choose(is(s), automaton.steps[s].value(atoms), update);
        }
        let update = self.sized(update, span)?;
        self.finished(&update.expr, update.size, span)?;
        let accepted: Vec<Value> = (0..count)
            .filter(|s| automaton.accepting[*s])
            .map(is)
            .collect();
        let accepted = Value::chain(BinaryOp::Or, accepted);
        let start = self.formula(Expr::now(state.first).equals(Expr::Const(0)));
        let step = self.formula(Expr::next(state.first).equals(update.expr));
        let goal = self.formula(accepted.expr);
        let guarantees = &mut self.specification.guarantees;
        guarantees.initial.push(start);
        guarantees.safety.push(step);
        match side {
            Owner::System => guarantees.justice.push(goal),
            Owner::Environment => self.specification.assumptions.justice.push(goal),
        }
        Some(())
    }

    /// A formula of the statement at hand.
    pub fn formula(&self, expr: Expr) -> Formula {
        Formula {
            name: self.origin.name.clone(),
            requirement: None,
            expr,
            span: self.origin.span,
            text: self.origin.text.clone(),
        }
    }

    /// An automaton would have too many states or inputs.
    pub fn too_many_states(&mut self, span: Span) {
        self.error(
            codes::TOO_LARGE,
            span,
            format!("this comes to an automaton of more than {MAX_STATES} states, or of more than {MAX_ATOMS} conditions in one step"),
            "use fewer repetitions and complements, and fewer different conditions",
        );
    }
}
