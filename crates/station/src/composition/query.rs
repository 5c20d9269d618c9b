//! Small questions about expressions over wires: does a goal follow from hypotheses?
//!
//! Questions are decided by enumerating all values of the wires that occur, or with decision
//! diagrams if there are many values. Hypotheses that share no wire with the goal, directly or
//! through other hypotheses, are left out first; omitting a hypothesis can only turn a "yes" into a
//! "no".

use super::walk::Node;
use super::{diagrams, support};
use linewright_core::gr1::{Domain, Expr, Time, VarId, Variable, eval, show_value};
use linewright_language::contract::machine::Machine;

/// Maximum number of valuations to enumerate; with more, diagrams are faster.
const MAX_VALUATIONS: u64 = 1 << 12;

/// Maximum number of valuations to enumerate if diagrams are too large.
const MAX_FALLBACK_VALUATIONS: u64 = 1 << 18;

/// The question whether a goal follows from hypotheses, over the wires of one step and the next.
#[derive(Debug, Clone)]
pub struct Question {
    /// The hypotheses.
    pub hypotheses: Vec<Expr>,
    /// The goal.
    pub goal: Expr,
    /// The coordinator's node in this step and in the next, if known.
    pub at: (Option<Node>, Option<Node>),
}

/// Answer to a question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The goal follows.
    Holds,
    /// It does not follow: with these values the hypotheses hold and the goal does not.
    Fails(Values),
    /// Too many values are involved.
    TooLarge,
}

/// Values of wires, each in this step or in the next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Values(pub Vec<((VarId, Time), i64)>);

impl Values {
    /// Formats the values for a message.
    pub fn show(&self, machine: &Machine) -> String {
        if self.0.is_empty() {
            return "the action is requested".to_owned();
        }
        let shown: Vec<String> = self
            .0
            .iter()
            .map(|((wire, time), value)| {
                let next = if *time == Time::Next { "next " } else { "" };
                let name = machine.wire_name(wire.index());
                let unit = unit(machine, *wire);
                format!(
                    "{next}{name} = {}",
                    show_value(&domain(machine, *wire), *value, &unit)
                )
            })
            .collect();
        shown.join(", ")
    }
}

/// Returns the domain of a wire.
pub fn domain(machine: &Machine, wire: VarId) -> Domain {
    match machine.plant.get(wire.index()) {
        Some(input) => input.domain.clone(),
        None => output(machine, wire).map_or(Domain::Bool, |v| v.domain.clone()),
    }
}

/// Unit of a wire's values; empty for numbers without a unit.
fn unit(machine: &Machine, wire: VarId) -> String {
    match machine.plant.get(wire.index()) {
        Some(input) => input.unit.clone(),
        None => output(machine, wire).map_or_else(String::new, |v| v.unit.clone()),
    }
}

/// Returns the component output that drives a wire.
fn output(machine: &Machine, wire: VarId) -> Option<&Variable> {
    let mut first = machine.plant.len();
    for component in &machine.components {
        let count = component.specification.outputs().count();
        if wire.index() < first + count {
            let id = component.specification.outputs().nth(wire.index() - first);
            return id.map(|id| component.specification.variable(id));
        }
        first += count;
    }
    None
}

impl Question {
    /// Creates a question without hypotheses and without a particular step.
    pub fn plain(goal: &Expr) -> Self {
        Self {
            hypotheses: Vec::new(),
            goal: goal.simplify(),
            at: (None, None),
        }
    }

    /// Whether the goal is trivially true.
    pub fn goal_is_true(&self) -> bool {
        self.goal == Expr::TRUE
    }

    /// Whether a hypothesis is trivially false, so that the goal follows.
    pub fn is_void(&self) -> bool {
        self.hypotheses.contains(&Expr::FALSE)
    }

    /// Answers the question.
    pub fn answer(&self, machine: &Machine) -> Answer {
        if self.goal_is_true() || self.is_void() {
            return Answer::Holds;
        }
        let (wires, relevant) = self.relevant(machine, u64::MAX);
        if valuations(machine, &wires) <= MAX_VALUATIONS {
            return self.enumerate(machine, &wires, &relevant);
        }
        match diagrams::decide(machine, &self.goal, &relevant) {
            Answer::TooLarge => {}
            decided => return decided,
        }
        let (wires, relevant) = self.relevant(machine, MAX_FALLBACK_VALUATIONS);
        if valuations(machine, &wires) > MAX_FALLBACK_VALUATIONS {
            return Answer::TooLarge;
        }
        self.enumerate(machine, &wires, &relevant)
    }

    /// Selects the hypotheses that share wires with the goal, directly or through other hypotheses,
    /// as long as all wires involved have at most `max_valuations` valuations. Also returns these
    /// wires.
    fn relevant(&self, machine: &Machine, max_valuations: u64) -> (Vec<(VarId, Time)>, Vec<&Expr>) {
        let mut wires = support(&self.goal);
        let mut relevant: Vec<&Expr> = Vec::new();
        let mut rest: Vec<&Expr> = self
            .hypotheses
            .iter()
            .filter(|h| **h != Expr::TRUE)
            .collect();
        loop {
            let (near, far): (Vec<&Expr>, Vec<&Expr>) = rest
                .into_iter()
                .partition(|h| support(h).iter().any(|w| wires.contains(w)));
            rest = far;
            if near.is_empty() {
                break;
            }
            for hypothesis in near {
                let more = support(hypothesis);
                let joined: Vec<_> = wires.iter().chain(&more).copied().collect();
                if valuations(machine, &joined) > max_valuations {
                    continue;
                }
                wires.extend(more);
                wires.sort_unstable();
                wires.dedup();
                relevant.push(hypothesis);
            }
        }
        (wires, relevant)
    }

    /// Answers the question by enumerating all values of these wires.
    pub(super) fn enumerate(
        &self,
        machine: &Machine,
        wires: &[(VarId, Time)],
        relevant: &[&Expr],
    ) -> Answer {
        let domains: Vec<Domain> = wires.iter().map(|(w, _)| domain(machine, *w)).collect();
        let mut now = vec![0; machine.wire_count()];
        let mut next = vec![0; machine.wire_count()];
        let mut values: Vec<i64> = domains.iter().map(Domain::low).collect();
        loop {
            for ((wire, time), value) in wires.iter().zip(&values) {
                match time {
                    Time::Now => now[wire.index()] = *value,
                    Time::Next => next[wire.index()] = *value,
                }
            }
            if !eval::holds(&self.goal, &now, &next)
                && relevant.iter().all(|h| eval::holds(h, &now, &next))
            {
                let pairs = wires.iter().copied().zip(values);
                return Answer::Fails(Values(pairs.collect()));
            }
            // Advance to the next valuation, like an odometer.
            let mut place = 0;
            loop {
                if place == values.len() {
                    return Answer::Holds;
                }
                if values[place] < domains[place].high() {
                    values[place] += 1;
                    break;
                }
                values[place] = domains[place].low();
                place += 1;
            }
        }
    }
}

/// Returns the number of valuations of the distinct wires in a list, at most `u64::MAX`.
fn valuations(machine: &Machine, wires: &[(VarId, Time)]) -> u64 {
    let mut distinct = wires.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    distinct.iter().fold(1u64, |product, (w, _)| {
        product.saturating_mul(domain(machine, *w).size())
    })
}
