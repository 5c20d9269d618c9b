//! The joint automaton of some rules as a plain table: what monitors are made of, in this process,
//! in C and in Structured Text.

use super::Rule;
use super::fsm::Fsm;
use super::supervisor::{Call, Refusal, Supervisor};
use linewright_automata::bound::TooLarge;
use linewright_automata::dfa;

/// An entry of [`Table::next`]: the call is refused.
pub const REFUSED: u32 = u32::MAX;

/// An entry of [`Table::why`]: the call is a recall, and recalls are forbidden.
pub const RECALL: u16 = u16::MAX;

/// An entry of [`Table::why`]: these skills are never called at once.
pub const TOGETHER: u16 = u16::MAX - 1;

/// What every call leads to, from every state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// The name of the skill set: `PickAndPlaceUnit`.
    pub name: String,
    /// How its rules are kept, in words: `at the level valid`.
    pub kept: String,
    /// The skills' names.
    pub skills: Vec<String>,
    /// The rules, as messages cite them.
    pub rules: Vec<Cited>,
    /// What may be called at once, a column each: masks over the skills. First the single skills in
    /// their order, then sets of two, of three and so on, each size in ascending order.
    pub calls: Vec<u64>,
    /// Row by row, `next[state * calls.len() + column]`: the state after the call, or [`REFUSED`].
    pub next: Vec<u32>,
    /// For every refused entry of [`Table::next`], at the same place, the first rule that refuses:
    /// an index into [`Table::rules`], [`RECALL`] or [`TOGETHER`].
    pub why: Vec<u16>,
    /// How many states there are.
    pub states: usize,
    /// The state before the first call.
    pub start: u32,
}

/// A rule in a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cited {
    /// Its name.
    pub name: String,
    /// The requirement it comes from, `R-12`.
    pub requirement: Option<String>,
    /// What it says, in one line.
    pub text: String,
}

impl Cited {
    /// A rule as it is cited.
    pub fn of(rule: &Rule) -> Self {
        Self {
            name: rule.name.clone(),
            requirement: rule.requirement.clone(),
            text: rule.text.clone(),
        }
    }
}

impl Table {
    /// The table of all that these calls lead to. Components whose situation decides nothing are
    /// left out of it.
    ///
    /// # Errors
    /// When it would be too large, or one rule speaks of too many of the skills of one call, or the
    /// time is over.
    pub fn explore(supervisor: &Supervisor<'_>, calls: Vec<Call>) -> Result<Self, TooLarge> {
        let supervisor = &mut supervisor.clone().lean();
        let fsm = Fsm::explore(supervisor, calls)?;
        let skills = supervisor.skills();
        let mut table = Self {
            name: skills.name.clone(),
            kept: supervisor.options().text(),
            skills: skills.skills.iter().map(|s| s.name.clone()).collect(),
            rules: skills.rules.iter().map(Cited::of).collect(),
            calls: fsm.calls.iter().map(|c| c.0).collect(),
            next: Vec::new(),
            why: Vec::new(),
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
                table.why.push(match why {
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

impl std::fmt::Display for Cited {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)?;
        if let Some(requirement) = &self.requirement {
            write!(f, " ({requirement})")?;
        }
        write!(f, ": {}", self.text)
    }
}
