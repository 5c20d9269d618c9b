//! A monitor: receives the calls one by one, and decides whether each is allowed.
//!
//! It is an interlock: a refused call changes nothing, as if it had not been made. Calls do not
//! allocate memory.

use super::layout::Layout;
use super::supervisor::{Call, Refusal as Refused, State, Supervisor};
use super::table::{RuleCitation, Table};
use linewright_automata::bound::BoundExceeded;

/// Reason why a call is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RefusalReason {
    /// A rule forbids the call. The number is its index in [`Table::rules`], or the index of the
    /// first rule if several forbid the call.
    Rule(usize),
    /// The skill's component is already in its target situation, and recalls are forbidden.
    Recall,
    /// Two of the skills belong to one component, or more skills are called at once than the
    /// monitor supports.
    Together,
    /// The skill does not exist.
    Unknown,
}

/// A monitor's verdict on a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[must_use]
pub enum Verdict {
    /// The call is allowed.
    Allowed,
    /// The call is refused, and must not be made.
    Refused(RefusalReason),
}

/// First refused call of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Refusal {
    /// Number of calls before the refused one.
    pub at: usize,
    /// Reason for the refusal.
    pub why: RefusalReason,
}

/// A monitor that looks up each call in a table.
#[derive(Debug, Clone)]
pub struct Monitor<'a> {
    table: &'a Table,
    layout: Layout,
    /// Offset of the state's row.
    state: u32,
}

impl Verdict {
    /// Returns whether the call is allowed.
    pub fn is_allowed(self) -> bool {
        self == Self::Allowed
    }
}

impl RefusalReason {
    /// Formats the reason: the citation of the rule, or what is wrong with the call.
    pub fn text(self, rules: &[RuleCitation]) -> String {
        match self {
            Self::Rule(rule) => rules[rule].to_string(),
            Self::Recall => "a recall: the component is already in the target situation".to_owned(),
            Self::Together => {
                "two skills of one component, or more skills at once than this monitor supports"
                    .to_owned()
            }
            Self::Unknown => "this skill does not exist".to_owned(),
        }
    }
}

impl<'a> Monitor<'a> {
    /// Creates a monitor in the state before the first call.
    pub fn new(table: &'a Table) -> Self {
        let layout = Layout::new(table);
        Self {
            table,
            state: layout.start,
            layout,
        }
    }

    /// Returns the table in which the monitor looks up calls.
    pub fn table(&self) -> &'a Table {
        self.table
    }

    /// Returns the state, as numbered in the table.
    pub fn state(&self) -> u32 {
        self.state / self.layout.stride as u32
    }

    /// Resets the monitor to the state before the first call.
    pub fn reset(&mut self) {
        self.state = self.layout.start;
    }

    /// Calls a skill, by its index in the table. A refused call changes nothing.
    pub fn call(&mut self, skill: u8) -> Verdict {
        self.take(self.single(skill))
    }

    /// Calls all skills of a mask at once. A refused call changes nothing; an empty mask is
    /// allowed.
    pub fn call_at_once(&mut self, skills: u64) -> Verdict {
        self.take(self.at_once(skills))
    }

    /// Returns the verdict on calling all skills of a mask at once, without changing the state.
    pub fn allows(&self, skills: u64) -> Verdict {
        self.verdict(self.at_once(skills))
    }

    /// Returns a mask of the skills that are allowed as the next call, each by itself.
    pub fn allowed(&self) -> u64 {
        let row = &self.layout.single[self.state as usize..][..self.table.skills.len()];
        let allowed = row.iter().enumerate();
        allowed
            .filter(|(_, entry)| **entry < self.layout.refused)
            .fold(0, |mask, (skill, _)| mask | 1 << skill)
    }

    /// Calls single skills one after the other, and stops at the first refused call. Returns this
    /// refusal; `None` if all calls are allowed.
    pub fn run(&mut self, calls: &[u8]) -> Option<Refusal> {
        let Layout {
            stride,
            single,
            refused,
            ..
        } = &self.layout;
        let mut state = self.state;
        for (at, &skill) in calls.iter().enumerate() {
            let skill = usize::from(skill);
            let entry = if skill < *stride {
                single[state as usize + skill]
            } else {
                u32::MAX
            };
            if entry >= *refused {
                self.state = state;
                let why = self.layout.refusal_reason(entry);
                return Some(Refusal { at, why });
            }
            state = entry;
        }
        self.state = state;
        None
    }

    fn verdict(&self, entry: u32) -> Verdict {
        if entry < self.layout.refused {
            Verdict::Allowed
        } else {
            Verdict::Refused(self.layout.refusal_reason(entry))
        }
    }

    fn take(&mut self, entry: u32) -> Verdict {
        let verdict = self.verdict(entry);
        if verdict.is_allowed() {
            self.state = entry;
        }
        verdict
    }

    /// Returns the entry for a single skill.
    fn single(&self, skill: u8) -> u32 {
        let skill = usize::from(skill);
        if skill < self.layout.stride {
            self.layout.single[self.state as usize + skill]
        } else {
            self.layout.refusal_code(RefusalReason::Unknown)
        }
    }

    /// Returns the entry for all skills of a mask.
    fn at_once(&self, skills: u64) -> u32 {
        let known = self.table.skills.len() as u32;
        match skills.count_ones() {
            0 => self.state,
            1 => self.single(skills.trailing_zeros() as u8),
            _ if known < 64 && skills >> known != 0 => {
                self.layout.refusal_code(RefusalReason::Unknown)
            }
            _ => match self.layout.sets.binary_search(&skills) {
                Ok(set) => {
                    let row = self.state as usize / self.layout.stride;
                    self.layout.at_once[row * self.layout.sets.len() + set]
                }
                Err(_) => self.layout.refusal_code(RefusalReason::Together),
            },
        }
    }
}

/// A monitor for rules whose table would be too large: it computes the result of a call on demand
/// and caches it. So the first call of its kind in a state takes longer, and allocates memory.
#[derive(Debug, Clone)]
pub struct LazyMonitor<'a> {
    supervisor: Supervisor<'a>,
    /// Maximum number of skills called at once.
    at_once: u32,
    state: State,
}

impl<'a> LazyMonitor<'a> {
    /// Creates a monitor in the state before the first call, for calls of up to `at_once` skills.
    pub fn new(supervisor: &Supervisor<'a>, at_once: u32) -> Self {
        let supervisor = supervisor.clone().track_relevant_only();
        Self {
            state: supervisor.start(),
            supervisor,
            at_once,
        }
    }

    /// Calls all skills of a mask at once. A refused call changes nothing; an empty mask is
    /// allowed. A call whose result exceeds a bound is refused.
    pub fn call_at_once(&mut self, skills: u64) -> Verdict {
        let known = self.supervisor.skills().skills.len() as u32;
        if skills == 0 {
            return Verdict::Allowed;
        }
        if known < 64 && skills >> known != 0 {
            return Verdict::Refused(RefusalReason::Unknown);
        }
        if skills.count_ones() > self.at_once {
            return Verdict::Refused(RefusalReason::Together);
        }
        match self.supervisor.call(&self.state, Call(skills)) {
            Ok(Ok(after)) => {
                self.state = after;
                Verdict::Allowed
            }
            Ok(Err(refusal)) => Verdict::Refused(match refusal {
                Refused::SameComponent { .. } => RefusalReason::Together,
                Refused::Recall { .. } => RefusalReason::Recall,
                Refused::Rule { rule, .. } | Refused::Deleted { rule } => RefusalReason::Rule(rule),
            }),
            Err(BoundExceeded::Count { .. } | BoundExceeded::Stopped(_)) => {
                Verdict::Refused(RefusalReason::Together)
            }
        }
    }
}
