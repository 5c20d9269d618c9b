//! A program of calls, checked before it is loaded: the first refused call, the reason, and
//! possible continuations.

use super::fsm::{MOST_ENTRIES, calls};
use super::supervisor::{Call, Refusal, State, Supervisor};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::search::{SearchNode, way};
use rustc_hash::FxHashSet;

/// Maximum number of calls explored in one search.
pub const MOST_SOUGHT: usize = 1 << 20;

/// Result of checking a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramCheck {
    /// Number of allowed calls from the start; all of them if there is no violation.
    pub allowed: usize,
    /// First call that is not allowed.
    pub violation: Option<Violation>,
    /// State after the last allowed call.
    pub state: State,
    /// Rules that are in the middle of a sequence there, by index.
    pub unfinished: Vec<usize>,
    /// Shortest calls that would complete it; `None` if it is complete, or never can be. An error
    /// if the search is too large.
    pub completion: SearchResult,
}

/// The shortest calls that reach a goal, if there are any.
pub type SearchResult = Result<Option<Vec<Call>>, BoundExceeded>;

/// A refused call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// Index in the program, from 0.
    pub step: usize,
    /// The call.
    pub call: Call,
    /// Reason for the refusal.
    pub refusal: Refusal,
    /// Shortest calls after which it is allowed; `None` if there are none. An error if the search
    /// is too large.
    pub detour: SearchResult,
    /// Calls allowed in its place: single skills, and up to as many at once as in the call.
    pub instead: Vec<Call>,
}

/// Checks a program call by call, up to the first violation.
///
/// # Errors
/// When one rule mentions too many of the skills of one call.
pub fn check(
    supervisor: &mut Supervisor<'_>,
    program: &[Call],
) -> Result<ProgramCheck, BoundExceeded> {
    let mut state = supervisor.start();
    for (step, call) in program.iter().enumerate() {
        match supervisor.call(&state, *call)? {
            Ok(after) => state = after,
            Err(refusal) => {
                let violation = Violation {
                    step,
                    call: *call,
                    refusal,
                    detour: detour(supervisor, &state, *call, MOST_SOUGHT),
                    instead: allowed(supervisor, &state, call.skills().count())?,
                };
                return Ok(ProgramCheck {
                    allowed: step,
                    violation: Some(violation),
                    unfinished: Vec::new(),
                    completion: Ok(None),
                    state,
                });
            }
        }
    }
    let completion = if supervisor.is_complete(&state) {
        Ok(None)
    } else {
        completion(supervisor, &state)
    };
    Ok(ProgramCheck {
        allowed: program.len(),
        violation: None,
        unfinished: supervisor.unfinished(&state),
        completion,
        state,
    })
}

/// Returns the allowed calls in a state: single skills, and up to `most` at once.
///
/// # Errors
/// When one rule mentions too many of the skills of one call.
pub fn allowed(
    supervisor: &mut Supervisor<'_>,
    state: &State,
    most: usize,
) -> Result<Vec<Call>, BoundExceeded> {
    let mut allowed = Vec::new();
    for call in calls(supervisor.skills(), most) {
        if supervisor.call(state, call)?.is_ok() {
            allowed.push(call);
        }
    }
    Ok(allowed)
}

/// Returns the shortest sequence of single skills after which a call is allowed. `None` if there is
/// none.
///
/// # Errors
/// When more than `entries` calls would be explored, or the deadline has passed.
pub fn detour(
    supervisor: &mut Supervisor<'_>,
    from: &State,
    call: Call,
    entries: usize,
) -> SearchResult {
    search(supervisor, from, entries, |supervisor, state| {
        matches!(supervisor.call(state, call), Ok(Ok(_)))
    })
}

/// Returns the shortest sequence of single skills after which a program may end. `None` if there is
/// none.
///
/// # Errors
/// When too many states would be explored, or the deadline has passed.
pub fn completion(supervisor: &mut Supervisor<'_>, from: &State) -> SearchResult {
    search(supervisor, from, MOST_SOUGHT, |supervisor, state| {
        supervisor.is_complete(state)
    })
}

fn search(
    supervisor: &mut Supervisor<'_>,
    from: &State,
    entries: usize,
    mut wanted: impl FnMut(&mut Supervisor<'_>, &State) -> bool,
) -> SearchResult {
    let singles = calls(supervisor.skills(), 1);
    let limit = entries / singles.len().max(1) + 1;
    let until = supervisor.options().until;
    let mut seen = FxHashSet::from_iter([supervisor.essence(from)]);
    let mut found: Vec<SearchNode<State, Call>> = vec![(from.clone(), None)];
    let mut at = 0;
    while at < found.len() {
        if found.len() >= limit {
            return Err(BoundExceeded::Count {
                what: "states",
                limit,
            });
        }
        until.check()?;
        let state = found[at].0.clone();
        if wanted(supervisor, &state) {
            return Ok(Some(way(&found, at)));
        }
        for call in &singles {
            if let Ok(Ok(after)) = supervisor.call(&state, *call)
                && seen.insert(supervisor.essence(&after))
            {
                found.push((after, Some((at, *call))));
            }
        }
        at += 1;
    }
    Ok(None)
}

/// The shortest sequence of calls that only one of two sets of rules allows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Calls; the last one distinguishes the sets.
    pub calls: Vec<Call>,
    /// Whether the first set allows it.
    pub first_allows: bool,
    /// Why the other set refuses the last call; `None` if it only does not let the program end.
    pub refusal: Option<Refusal>,
}

/// Criteria for a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DifferenceOptions {
    /// Whether programs that only one set lets end count as well.
    pub whole: bool,
    /// Whether only calls that the first allows and the second refuses count.
    pub one_way: bool,
    /// Maximum number of calls of pairs of states that are explored.
    pub entries: usize,
}

impl Default for DifferenceOptions {
    fn default() -> Self {
        Self {
            whole: false,
            one_way: false,
            entries: MOST_ENTRIES,
        }
    }
}

/// Finds the difference of two sets of rules over the same skills.
///
/// # Errors
/// When there are too many pairs of states, or one rule mentions too many skills of one call.
pub fn difference(
    first: &Supervisor<'_>,
    second: &Supervisor<'_>,
    calls: &[Call],
    apart: DifferenceOptions,
) -> Result<Option<Difference>, BoundExceeded> {
    let (first, second) = (&mut first.clone().lean(), &mut second.clone().lean());
    let limit = apart.entries / calls.len().max(1);
    let start = (first.start(), second.start());
    // Whether the first lets a program end, if they do not agree on it.
    let ends = |first: &Supervisor<'_>, second: &Supervisor<'_>, (a, b): &(State, State)| {
        let ends = first.is_complete(a);
        let differ = ends != second.is_complete(b) && (ends || !apart.one_way);
        (apart.whole && differ).then_some(ends)
    };
    if let Some(first_allows) = ends(first, second, &start) {
        return Ok(Some(Difference {
            calls: Vec::new(),
            first_allows,
            refusal: None,
        }));
    }
    let mut seen = FxHashSet::from_iter([start.clone()]);
    let mut found: Vec<SearchNode<(State, State), Call>> = vec![(start, None)];
    let mut at = 0;
    let until = first.options().until;
    while at < found.len() {
        until.check()?;
        let (a, b) = found[at].0.clone();
        for call in calls {
            let pair = match (first.call(&a, *call)?, second.call(&b, *call)?) {
                (Ok(a), Ok(b)) => (a, b),
                (Err(_), Err(_)) => continue,
                (Err(_), Ok(_)) if apart.one_way => continue,
                (allowed, refused) => {
                    let mut calls = way(&found, at);
                    calls.push(*call);
                    return Ok(Some(Difference {
                        calls,
                        first_allows: allowed.is_ok(),
                        refusal: allowed.err().or(refused.err()),
                    }));
                }
            };
            if seen.contains(&pair) {
                continue;
            }
            if found.len() == limit {
                return Err(BoundExceeded::Count {
                    what: "pairs of states",
                    limit,
                });
            }
            // Checked as soon as the pair is found: a state found later at the same depth may only
            // have a longer difference.
            let end = ends(first, second, &pair);
            seen.insert(pair.clone());
            found.push((pair, Some((at, *call))));
            if let Some(first_allows) = end {
                return Ok(Some(Difference {
                    calls: way(&found, found.len() - 1),
                    first_allows,
                    refusal: None,
                }));
            }
        }
        at += 1;
    }
    Ok(None)
}
