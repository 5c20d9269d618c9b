//! The skills that lead to the initial situation count as called before the start, in some order.
//!
//! If a unit is left and up at the start, `Left` and `Up` have been called, in an unknown order. So
//! a window that one of them opens and the other closes can be open or closed. Several windows are
//! not independent of each other: one order has to explain the state of all of them. The possible
//! orders are explored from the last skill backwards.

use super::{Event, Skills};
use linewright_automata::bound::{BoundExceeded, MAX_DFA_STATES};
use std::collections::BTreeSet;

/// Returns the skills among these events that count as called at the start, as a mask: those that
/// lead to the initial situation of their component. Events of several skills are omitted, because
/// the situation does not show what was called at once.
pub fn initially_called(events: &[Event], skills: &Skills) -> u64 {
    let is_initial = |skill: &usize| {
        let skill = &skills.skills[*skill];
        skill.effect == Some(skills.components[skill.component].initial)
    };
    let single = events.iter().filter_map(|e| match e.0.as_slice() {
        [skill] => Some(skill),
        _ => None,
    });
    let initial = single.filter(|s| is_initial(s));
    initial.fold(0, |mask, skill| mask | 1 << skill)
}

/// Window of a rule at the start. Whether it is open depends on which of these skills was called
/// last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// Skills after which the window is open.
    opening: u64,
    /// Skills after which the window is closed.
    closing: u64,
}

impl Window {
    /// Creates the window that a `from` event opens and an `until` event closes.
    pub fn new(from: &[Event], until: &[Event], skills: &Skills) -> Self {
        let opening = initially_called(from, skills);
        Self {
            opening,
            closing: initially_called(until, skills) & !opening,
        }
    }

    /// Returns the possible states of the window at the start, in ascending order: `false` for
    /// closed, `true` for open.
    pub fn starts(self) -> Vec<bool> {
        match (self.opening, self.closing) {
            (0, _) => vec![false],
            (_, 0) => vec![true],
            _ => vec![false, true],
        }
    }

    /// Returns whether the window is open if this skill was called last; `None` if the skill
    /// neither opens nor closes it.
    fn after(self, skill: u32) -> Option<bool> {
        let has = |mask: u64| mask >> skill & 1 == 1;
        (has(self.opening) || has(self.closing)).then(|| has(self.opening))
    }
}

/// Returns all joint states of these windows at the start: for each, whether each window is open.
///
/// # Errors
/// When [`MAX_DFA_STATES`] combinations have been explored.
pub fn joint_starts(windows: &[Window]) -> Result<Vec<Vec<bool>>, BoundExceeded> {
    let begin: Vec<Option<bool>> = windows
        .iter()
        .map(|w| (w.opening == 0).then_some(false))
        .collect();
    let mut waiting = vec![begin.clone()];
    let mut seen = BTreeSet::from([begin]);
    let mut found = Vec::new();
    while let Some(decided) = waiting.pop() {
        let all: Option<Vec<bool>> = decided.iter().copied().collect();
        if let Some(all) = all {
            found.push(all);
            continue;
        }
        let open = windows.iter().zip(&decided).filter(|(_, d)| d.is_none());
        let matter = open.fold(0, |mask, (w, _)| mask | w.opening | w.closing);
        for last in (0..u64::BITS).filter(|s| matter >> s & 1 == 1) {
            let earlier: Vec<Option<bool>> = decided
                .iter()
                .zip(windows)
                .map(|(decided, w)| decided.or_else(|| w.after(last)))
                .collect();
            if seen.len() < MAX_DFA_STATES && seen.insert(earlier.clone()) {
                waiting.push(earlier);
            }
        }
        if seen.len() == MAX_DFA_STATES {
            return Err(BoundExceeded::Count {
                what: "states",
                limit: MAX_DFA_STATES,
            });
        }
    }
    found.sort_unstable();
    Ok(found)
}
