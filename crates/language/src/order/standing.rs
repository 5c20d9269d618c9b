//! What stands at the start counts as called before it, in some order.
//!
//! A unit that stands left and up has been called `Left` and `Up`, and which of them last is not
//! known. So a window that the one opens and the other closes may stand open or not. Several
//! windows are not independent of one another there: what one order leads to for each of them is
//! found from its end, skill by skill.

use super::{Event, Skills};
use linewright_automata::bound::{MOST_STATES, TooLarge};
use std::collections::BTreeSet;

/// The skills among these that stand at the start, as a mask. Events of several skills are left
/// out: where components stand does not say what was called at once.
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

/// A window of a rule at the start: by the skill that was called last of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// Those that leave it open.
    opening: u64,
    /// Those that leave it closed.
    closing: u64,
}

impl Window {
    /// The window from one of these events until one of those.
    pub fn new(from: &[Event], until: &[Event], skills: &Skills) -> Self {
        let opening = standing(from, skills);
        Self {
            opening,
            closing: standing(until, skills) & !opening,
        }
    }

    /// Whether it stands open: both where that is not known.
    pub fn starts(self) -> Vec<bool> {
        match (self.opening, self.closing) {
            (0, _) => vec![false],
            (_, 0) => vec![true],
            _ => vec![false, true],
        }
    }

    /// Whether it stands open when this skill was the last of its skills; `None` where it is not
    /// one of them.
    fn after(self, skill: u32) -> Option<bool> {
        let has = |mask: u64| mask >> skill & 1 == 1;
        (has(self.opening) || has(self.closing)).then(|| has(self.opening))
    }
}

/// Which of these windows may stand open together.
///
/// # Errors
/// When there are too many such sets.
pub fn together(windows: &[Window]) -> Result<Vec<Vec<bool>>, TooLarge> {
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
            return Err(TooLarge::Count {
                what: "states",
                limit: MOST_STATES,
            });
        }
    }
    found.sort_unstable();
    Ok(found)
}
