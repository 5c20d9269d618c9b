//! The initial situation counts as called before the start, in some order.
//!
//! A unit that starts left and up has been called `Left` and `Up`, in an unknown order. So a window
//! that one of them opens and the other closes may be open or not. Several windows depend on one
//! another there: the result of one order for all of them is found from its end, skill by skill.

use super::{Event, Skills};
use linewright_automata::bound::{BoundExceeded, MOST_STATES};
use std::collections::BTreeSet;

/// Returns those of these skills that the initial situation implies, as a mask. Events of several
/// skills are omitted: the situation does not show what was called at once.
pub fn standing(events: &[Event], skills: &Skills) -> u64 {
    let stands = |skill: &usize| {
        let skill = &skills.skills[*skill];
        skill.effect == Some(skills.components[skill.component].initial)
    };
    let single = events.iter().filter_map(|e| match e.0.as_slice() {
        [skill] => Some(skill),
        _ => None,
    });
    let standing = single.filter(|s| stands(s));
    standing.fold(0, |mask, skill| mask | 1 << skill)
}

/// A window of a rule at the start: determined by the skill of these that was called last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// Skills that leave it open.
    opening: u64,
    /// Skills that leave it closed.
    closing: u64,
}

impl Window {
    /// Creates the window from one of these events until one of those.
    pub fn new(from: &[Event], until: &[Event], skills: &Skills) -> Self {
        let opening = standing(from, skills);
        Self {
            opening,
            closing: standing(until, skills) & !opening,
        }
    }

    /// Returns whether it is open; both values if that is unknown.
    pub fn starts(self) -> Vec<bool> {
        match (self.opening, self.closing) {
            (0, _) => vec![false],
            (_, 0) => vec![true],
            _ => vec![false, true],
        }
    }

    /// Returns whether it is open if this skill was the last one; `None` if the skill is not one of
    /// its own.
    fn after(self, skill: u32) -> Option<bool> {
        let has = |mask: u64| mask >> skill & 1 == 1;
        (has(self.opening) || has(self.closing)).then(|| has(self.opening))
    }
}

/// Returns which of these windows may be open together.
///
/// # Errors
/// When there are too many such sets.
pub fn together(windows: &[Window]) -> Result<Vec<Vec<bool>>, BoundExceeded> {
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
            if seen.len() < MOST_STATES && seen.insert(earlier.clone()) {
                waiting.push(earlier);
            }
        }
        if seen.len() == MOST_STATES {
            return Err(BoundExceeded::Count {
                what: "states",
                limit: MOST_STATES,
            });
        }
    }
    found.sort_unstable();
    Ok(found)
}
