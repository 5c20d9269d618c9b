//! Checks a program of calls before it is loaded: finds the first refused call, the reason, and
//! possible continuations.

use super::fsm::{MAX_ENTRIES, calls};
use super::supervisor::{Call, Refusal, State, Supervisor};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::search::{SearchNode, path_labels};
use rustc_hash::FxHashSet;

/// Maximum number of calls explored in one search.
pub const MAX_SEARCHED_CALLS: usize = 1 << 20;

/// Result of checking a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramCheck {
    /// Number of allowed calls from the start; all of them if there is no violation.
    pub allowed: usize,
    /// First call that is not allowed.
    pub violation: Option<Violation>,
    /// State after the last allowed call.
    pub state: State,
    /// Indices of the rules whose sequence is unfinished in that state.
    pub unfinished: Vec<usize>,
    /// Shortest sequence of calls that completes the program; `None` if it is already complete or
    /// cannot be completed. An error if the search is too large.
    pub completion: SearchResult,
}

/// Shortest sequence of calls that reaches a goal; `None` if the goal is unreachable.
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
    /// Shortest sequence of calls after which the refused call is allowed; `None` if there is none.
    /// An error if the search is too large.
    pub detour: SearchResult,
    /// Calls that are allowed instead. They have at most as many skills at once as the refused
    /// call.
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
                    detour: detour(supervisor, &state, *call, MAX_SEARCHED_CALLS),
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

/// Returns the allowed calls in a state, of at most `most` skills at once.
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

/// Returns the shortest sequence of single skills after which a call is allowed; `None` if there is
/// no such sequence.
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

/// Returns the shortest sequence of single skills after which a program can end; `None` if there is
/// no such sequence.
///
/// # Errors
/// When too many states would be explored, or the deadline has passed.
pub fn completion(supervisor: &mut Supervisor<'_>, from: &State) -> SearchResult {
    search(supervisor, from, MAX_SEARCHED_CALLS, |supervisor, state| {
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
    let mut seen = FxHashSet::from_iter([supervisor.relevant_part(from)]);
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
            return Ok(Some(path_labels(&found, at)));
        }
        for call in &singles {
            if let Ok(Ok(after)) = supervisor.call(&state, *call)
                && seen.insert(supervisor.relevant_part(&after))
            {
                found.push((after, Some((at, *call))));
            }
        }
        at += 1;
    }
    Ok(None)
}

/// Shortest sequence of calls that distinguishes two sets of rules.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The sequence. Only one of the sets allows its last call, or allows the program to end after
    /// it.
    pub calls: Vec<Call>,
    /// Whether this is the first set.
    pub first_allows: bool,
    /// Why the other set refuses the last call; `None` if the sets differ only in whether the
    /// program may end.
    pub refusal: Option<Refusal>,
}

/// Options for comparing two sets of rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DifferenceOptions {
    /// Whether a program that can end under only one of the sets counts as a difference.
    pub whole: bool,
    /// Whether to report only what the first set allows and the second refuses.
    pub one_way: bool,
    /// Maximum number of explored pairs of states, times the number of calls.
    pub entries: usize,
}

impl Default for DifferenceOptions {
    fn default() -> Self {
        Self {
            whole: false,
            one_way: false,
            entries: MAX_ENTRIES,
        }
    }
}

/// Finds a shortest difference of two sets of rules over the same skills; `None` if they agree on
/// all sequences of these calls.
///
/// # Errors
/// When there are too many pairs of states, or one rule mentions too many skills of one call.
pub fn difference(
    first: &Supervisor<'_>,
    second: &Supervisor<'_>,
    calls: &[Call],
    options: DifferenceOptions,
) -> Result<Option<Difference>, BoundExceeded> {
    let (first, second) = (
        &mut first.clone().track_relevant_only(),
        &mut second.clone().track_relevant_only(),
    );
    let limit = options.entries / calls.len().max(1);
    let start = (first.start(), second.start());
    // Whether the first set lets a program end, if the two sets disagree on it.
    let ends = |first: &Supervisor<'_>, second: &Supervisor<'_>, (a, b): &(State, State)| {
        let ends = first.is_complete(a);
        let differ = ends != second.is_complete(b) && (ends || !options.one_way);
        (options.whole && differ).then_some(ends)
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
                (Err(_), Ok(_)) if options.one_way => continue,
                (allowed, refused) => {
                    let mut calls = path_labels(&found, at);
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
            // The end is checked as soon as the pair is found, because otherwise another pair at
            // the same depth could return a longer difference before.
            let end = ends(first, second, &pair);
            seen.insert(pair.clone());
            found.push((pair, Some((at, *call))));
            if let Some(first_allows) = end {
                return Ok(Some(Difference {
                    calls: path_labels(&found, found.len() - 1),
                    first_allows,
                    refusal: None,
                }));
            }
        }
        at += 1;
    }
    Ok(None)
}
