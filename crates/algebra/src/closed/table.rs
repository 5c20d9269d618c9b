//! A controller's table as rules over wires and a state.
//!
//! A row of the table gives, for a state and the inputs that satisfy a guard, the outputs and the
//! next state. The rows of a state are disjoint, so the table is their disjunction. Inputs are
//! replaced by their bindings.
//!
//! The outputs of a step almost determine the state of the table after the step. So only one small
//! variable is added ([`TableStates`]): it selects one of the states to which rows with these
//! outputs lead.

use linewright_core::gr1::{BinaryOp, Expr, FormulaKind, Time, Timing, VarId};
use linewright_solver::game::Rule;
use linewright_solver::mealy::{Guard, Machine, Test, Transition};
use std::collections::BTreeMap;

/// Encoding of a table's states: the outputs of the last step, and a number that selects one of the
/// states to which rows with these outputs lead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableStates {
    /// For the outputs of each row, the states that such rows lead to, in ascending order.
    after: BTreeMap<Vec<i64>, Vec<usize>>,
}

impl TableStates {
    /// Collects the states of a table.
    pub(super) fn new(machine: &Machine) -> Self {
        let mut after: BTreeMap<Vec<i64>, Vec<usize>> = BTreeMap::new();
        let rows = machine
            .initial
            .iter()
            .chain(machine.states.iter().flatten());
        for row in rows {
            let known = after.entry(row.output.clone()).or_default();
            if let Err(place) = known.binary_search(&row.to) {
                known.insert(place, row.to);
            }
        }
        Self { after }
    }

    /// Returns the maximum number of states that rows with the same outputs lead to; at least 1.
    pub(super) fn max_per_output(&self) -> usize {
        self.after.values().map(Vec::len).max().unwrap_or(1)
    }

    /// Returns the number that, with these outputs, encodes a state; `None` if no row with these
    /// outputs leads to the state.
    pub fn number(&self, outputs: &[i64], state: usize) -> Option<usize> {
        self.after.get(outputs)?.binary_search(&state).ok()
    }

    /// Returns all encodings of a state: pairs of outputs and a number.
    fn encodings(&self, state: usize) -> impl Iterator<Item = (&[i64], usize)> {
        let all = self.after.iter();
        all.filter_map(move |(outputs, states)| {
            Some((outputs.as_slice(), states.binary_search(&state).ok()?))
        })
    }
}

/// A table with its connections in a machine.
pub(super) struct Table<'a> {
    /// The table itself.
    pub machine: &'a Machine,
    /// Expression over wires for each input.
    pub bindings: &'a [Expr],
    /// Index of the component's first wire.
    pub first: usize,
    /// Variable for the number in the encoding of the state.
    pub state: VarId,
    /// Encoding of the states.
    pub states: &'a TableStates,
}

/// A condition on step 0, and a condition on every later step.
#[derive(Debug, Clone)]
pub(super) struct StepCondition {
    /// Condition on step 0, over current values.
    pub first: Expr,
    /// Condition on two consecutive steps; next values are those of the later one.
    pub later: Expr,
}

impl StepCondition {
    /// Converts the condition to an initial rule and a safety rule.
    pub fn rules(self) -> [Rule; 2] {
        [
            Rule {
                kind: FormulaKind::Initial,
                expr: self.first,
            },
            Rule {
                kind: FormulaKind::Safety,
                expr: self.later,
            },
        ]
    }

    /// Returns the disjunction.
    pub fn or(self, other: Self) -> Self {
        Self {
            first: self.first.or(other.first).simplify(),
            later: self.later.or(other.later).simplify(),
        }
    }

    /// Returns the negation.
    pub fn not(self) -> Self {
        Self {
            first: self.first.not().simplify(),
            later: self.later.not().simplify(),
        }
    }

    /// Returns whether the condition is syntactically true.
    pub fn is_true(&self) -> bool {
        self.first == Expr::TRUE && self.later == Expr::TRUE
    }
}

impl Table<'_> {
    /// Returns the condition that a row is taken: the inputs satisfy its guard, and the outputs and
    /// the next state are those of the row. For a table that answers first, the outputs are left to
    /// [`fixed_outputs`](Self::fixed_outputs).
    pub fn transitions_taken(&self) -> StepCondition {
        let outputs = self.machine.timing == Timing::Mealy;
        self.over_states(|table, state, time| {
            let rows = table.machine.transitions(state).iter();
            any(rows.map(|row| table.row(row, time, outputs)).collect())
        })
    }

    /// Returns the condition that a table that answers first gives the outputs of its state; `None`
    /// for a Mealy machine.
    pub fn fixed_outputs(&self) -> Option<StepCondition> {
        (self.machine.timing == Timing::Moore).then(|| {
            self.over_states(
                |table, state, time| match table.machine.transitions(state) {
                    [] => Expr::TRUE,
                    [row, ..] => table.outputs(&row.output, time),
                },
            )
        })
    }

    /// Returns the condition that the table has outputs in its state if it answers first.
    pub fn has_outputs(&self) -> StepCondition {
        if self.machine.timing == Timing::Mealy {
            return StepCondition {
                first: Expr::TRUE,
                later: Expr::TRUE,
            };
        }
        let silent = (0..self.machine.states.len())
            .filter(|s| self.machine.states[*s].is_empty())
            .map(|s| self.is_in(s, Time::Now))
            .collect();
        StepCondition {
            first: Expr::Const(i64::from(!self.machine.initial.is_empty())),
            later: any(silent).not().simplify(),
        }
    }

    /// Returns the condition that the table has a row for the inputs.
    pub fn has_row(&self) -> StepCondition {
        self.over_states(|table, state, time| {
            let rows = table.machine.transitions(state).iter();
            any(rows.map(|row| table.guard(&row.guard, time)).collect())
        })
    }

    /// Combines the conditions for all states in which the table can be before a step; the state is
    /// `None` before step 0.
    fn over_states(&self, condition: impl Fn(&Self, Option<usize>, Time) -> Expr) -> StepCondition {
        let states = 0..self.machine.states.len();
        let cases = states.map(|s| {
            self.is_in(s, Time::Now)
                .and(condition(self, Some(s), Time::Next))
        });
        StepCondition {
            first: condition(self, None, Time::Now).simplify(),
            later: any(cases.collect()).simplify(),
        }
    }

    fn is_in(&self, state: usize, time: Time) -> Expr {
        let encodings = self.states.encodings(state).map(|(outputs, number)| {
            let number = Expr::Var(self.state, time).equals(Expr::Const(number as i64));
            self.outputs(outputs, time).and(number)
        });
        any(encodings.collect())
    }

    /// Returns the condition that the state variable, with the outputs of a row, encodes the next
    /// state of the row.
    fn leads_to(&self, row: &Transition, time: Time) -> Expr {
        let number = self
            .states
            .number(&row.output, row.to)
            .map_or(-1, |n| n as i64);
        Expr::Var(self.state, time).equals(Expr::Const(number))
    }

    fn row(&self, row: &Transition, time: Time, outputs: bool) -> Expr {
        let mut all = vec![self.guard(&row.guard, time)];
        if outputs {
            all.push(self.outputs(&row.output, time));
        }
        all.push(self.leads_to(row, time));
        conjunction(all)
    }

    fn outputs(&self, values: &[i64], time: Time) -> Expr {
        let wires = values.iter().enumerate().map(|(place, value)| {
            let wire = VarId((self.first + place) as u32);
            Expr::Var(wire, time).equals(Expr::Const(*value))
        });
        conjunction(wires.collect())
    }

    fn guard(&self, guard: &Guard, time: Time) -> Expr {
        let cube = |tests: &[Test]| {
            let tests = tests.iter().map(|t| self.test(t, time));
            conjunction(tests.collect())
        };
        any(guard.0.iter().map(|c| cube(&c.0)).collect())
    }

    fn test(&self, test: &Test, time: Time) -> Expr {
        let value = self.bindings[test.input].substitute(&mut |w, _| Expr::Var(w, time));
        if test.low == test.high {
            return value.equals(Expr::Const(test.low));
        }
        let low = Expr::binary(BinaryOp::Ge, value.clone(), Expr::Const(test.low));
        low.and(Expr::binary(BinaryOp::Le, value, Expr::Const(test.high)))
    }
}

/// Builds a disjunction as a balanced tree, since a table can have thousands of rows.
pub(super) fn any(parts: Vec<Expr>) -> Expr {
    tree(parts, &Expr::FALSE, Expr::or)
}

/// Builds a conjunction as a balanced tree.
pub(super) fn conjunction(parts: Vec<Expr>) -> Expr {
    tree(parts, &Expr::TRUE, Expr::and)
}

fn tree(mut parts: Vec<Expr>, empty: &Expr, join: fn(Expr, Expr) -> Expr) -> Expr {
    if parts.is_empty() {
        return empty.clone();
    }
    while parts.len() > 1 {
        let mut joined = Vec::with_capacity(parts.len().div_ceil(2));
        let mut rest = parts.into_iter();
        while let Some(first) = rest.next() {
            joined.push(match rest.next() {
                Some(second) => join(first, second),
                None => first,
            });
        }
        parts = joined;
    }
    parts.swap_remove(0)
}
