//! The joint automaton of some rules as a plain table, from which monitors are built: in this
//! process, in C and in Structured Text.

use super::Rule;
use super::fsm::Fsm;
use super::supervisor::{Call, Refusal, Supervisor};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa;

/// Entry of [`Table::next`] for a refused call.
pub const REFUSED: u32 = u32::MAX;

/// Entry of [`Table::reasons`]: the call is a recall, and recalls are forbidden.
pub const RECALL: u16 = u16::MAX;

/// Entry of [`Table::reasons`]: two of the skills belong to one component.
pub const TOGETHER: u16 = u16::MAX - 1;

/// The result of every call in every state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Name of the skill set: `PickAndPlaceUnit`.
    pub name: String,
    /// Options under which the rules apply, as text: `at the level valid`.
    pub options_text: String,
    /// Names of the skills.
    pub skills: Vec<String>,
    /// Rules, as messages cite them.
    pub rules: Vec<RuleCitation>,
    /// Calls, one per column: masks over the skills. First the single skills in their order, then
    /// sets of two, of three and so on, each size in ascending order.
    pub calls: Vec<u64>,
    /// Row by row, `next[state * calls.len() + column]`: the state after the call, or [`REFUSED`].
    pub next: Vec<u32>,
    /// For every refused entry of [`Table::next`], at the same index, the reason: the index of the
    /// first refusing rule in [`Table::rules`], [`RECALL`] or [`TOGETHER`]. 0 for allowed calls.
    pub reasons: Vec<u16>,
    /// Number of states.
    pub states: usize,
    /// State before the first call.
    pub start: u32,
}

/// A rule as cited in a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuleCitation {
    /// Name of the rule.
    pub name: String,
    /// Requirement from which the rule comes, such as `R-12`.
    pub requirement: Option<String>,
    /// Text of the rule, on one line.
    pub text: String,
}

impl RuleCitation {
    /// Creates the citation of a rule.
    pub fn of(rule: &Rule) -> Self {
        Self {
            name: rule.name.clone(),
            requirement: rule.requirement.clone(),
            text: rule.text.clone(),
        }
    }
}

impl Table {
    /// Computes the result of each of these calls in every reachable state. Components whose
    /// situation has no influence on later calls are not tracked.
    ///
    /// # Errors
    /// When the table would be too large, when one rule mentions too many of the skills of one
    /// call, or when the deadline has passed.
    pub fn explore(supervisor: &Supervisor<'_>, calls: Vec<Call>) -> Result<Self, BoundExceeded> {
        let supervisor = &mut supervisor.clone().track_relevant_only();
        let fsm = Fsm::explore(supervisor, calls)?;
        let skills = supervisor.skills();
        let mut table = Self {
            name: skills.name.clone(),
            options_text: supervisor.options().text(),
            skills: skills.skills.iter().map(|s| s.name.clone()).collect(),
            rules: skills.rules.iter().map(RuleCitation::of).collect(),
            calls: fsm.calls.iter().map(|c| c.0).collect(),
            next: Vec::new(),
            reasons: Vec::new(),
            states: fsm.states.len(),
            start: 0,
        };
        for (number, state) in fsm.states.iter().enumerate() {
            for (column, call) in fsm.calls.iter().enumerate() {
                let to = fsm.dfa.next(number as u32, column);
                table
                    .next
                    .push(if to == dfa::REFUSED { REFUSED } else { to });
                let why = if to == dfa::REFUSED {
                    supervisor.call(state, *call)?.err()
                } else {
                    None
                };
                table.reasons.push(match why {
                    Some(Refusal::Rule { rule, .. } | Refusal::Deleted { rule }) => rule as u16,
                    Some(Refusal::Recall { .. }) => RECALL,
                    Some(Refusal::SameComponent { .. }) => TOGETHER,
                    None => 0,
                });
            }
        }
        Ok(table)
    }
}

impl std::fmt::Display for RuleCitation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)?;
        if let Some(requirement) = &self.requirement {
            write!(f, " ({requirement})")?;
        }
        write!(f, ": {}", self.text)
    }
}
