//! A program of calls, checked before it is loaded: the first call that is refused, why, and how it
//! could go on.

use super::fsm::{MOST_ENTRIES, calls};
use super::supervisor::{Call, Refusal, State, Supervisor};
use linewright_automata::bound::TooLarge;
use linewright_automata::search::{Found, way};
use rustc_hash::FxHashSet;

/// For one way on so many calls are looked at.
pub const MOST_SOUGHT: usize = 1 << 20;

/// What came of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// How many of its calls are allowed, one after the other; all of them where there is no
    /// violation.
    pub allowed: usize,
    /// The first call that is not.
    pub violation: Option<Violation>,
    /// The state after the last allowed call.
    pub state: State,
    /// Rules that are in the middle of a sequence there, by their places.
    pub unfinished: Vec<usize>,
    /// The shortest calls with which it would be complete; `None` where it is, or never can be. An
    /// error where that would be too much to be found out.
    pub completion: Sought,
}

/// The shortest calls after which something is so, if there are any.
pub type Sought = Result<Option<Vec<Call>>, TooLarge>;

/// A call that is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// Its place in the program, from 0.
    pub step: usize,
    /// The call.
    pub call: Call,
    /// Why.
    pub refusal: Refusal,
    /// The shortest calls after which it is allowed; `None` where there are none. An error where
    /// that would be too much to be found out.
    pub detour: Sought,
    /// What may be called in its place, single skills and as many at once as the call has.
    pub instead: Vec<Call>,
}

/// Reads a program call by call, up to the first violation.
///
/// # Errors
/// When one rule speaks of too many of the skills of one call.
pub fn check(supervisor: &mut Supervisor<'_>, program: &[Call]) -> Result<Checked, TooLarge> {
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
                return Ok(Checked {
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
    Ok(Checked {
        allowed: program.len(),
        violation: None,
        unfinished: supervisor.unfinished(&state),
        completion,
        state,
    })
}

/// What may be called in a state: single skills, and up to `most` at once.
///
/// # Errors
/// When one rule speaks of too many of the skills of one call.
pub fn allowed(
    supervisor: &mut Supervisor<'_>,
    state: &State,
    most: usize,
) -> Result<Vec<Call>, TooLarge> {
    let mut allowed = Vec::new();
    for call in calls(supervisor.skills(), most) {
        if supervisor.call(state, call)?.is_ok() {
            allowed.push(call);
        }
    }
    Ok(allowed)
}

/// The shortest calls, of single skills, after which a call is allowed. `None` where there are
/// none.
///
/// # Errors
/// When more than so many calls would be looked at, or the time is over.
pub fn detour(supervisor: &mut Supervisor<'_>, from: &State, call: Call, entries: usize) -> Sought {
    search(supervisor, from, entries, |supervisor, state| {
        matches!(supervisor.call(state, call), Ok(Ok(_)))
    })
}

/// The shortest calls, of single skills, after which a program may end. `None` where there are
/// none.
///
/// # Errors
/// When too many states would be looked at, or the time is over.
pub fn completion(supervisor: &mut Supervisor<'_>, from: &State) -> Sought {
    search(supervisor, from, MOST_SOUGHT, |supervisor, state| {
        supervisor.is_complete(state)
    })
}

fn search(
    supervisor: &mut Supervisor<'_>,
    from: &State,
    entries: usize,
    mut wanted: impl FnMut(&mut Supervisor<'_>, &State) -> bool,
) -> Sought {
    let singles = calls(supervisor.skills(), 1);
    let limit = entries / singles.len().max(1) + 1;
    let until = supervisor.options().until;
    let mut seen = FxHashSet::from_iter([supervisor.essence(from)]);
    let mut found: Vec<Found<State, Call>> = vec![(from.clone(), None)];
    let mut at = 0;
    while at < found.len() {
        if found.len() >= limit {
            return Err(TooLarge::Count {
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

/// The shortest sequence of calls that one of two sets of rules allows and the other refuses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The calls; the last one tells them apart.
    pub calls: Vec<Call>,
    /// Whether the first of the two allows it.
    pub first_allows: bool,
    /// Why the other refuses the last call; `None` where it is only no whole program.
    pub refusal: Option<Refusal>,
}

/// What counts as a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Apart {
    /// Also programs that the one lets end and the other does not.
    pub whole: bool,
    /// Only what the first allows and the second refuses.
    pub one_way: bool,
    /// So many calls of pairs of states are looked at.
    pub entries: usize,
}

impl Default for Apart {
    fn default() -> Self {
        Self {
            whole: false,
            one_way: false,
            entries: MOST_ENTRIES,
        }
    }
}

/// Tells two sets of rules over the same skills apart.
///
/// # Errors
/// When there are too many pairs of states, or one rule speaks of too many skills of one call.
pub fn difference(
    first: &Supervisor<'_>,
    second: &Supervisor<'_>,
    calls: &[Call],
    apart: Apart,
) -> Result<Option<Difference>, TooLarge> {
    let (first, second) = (&mut first.clone().lean(), &mut second.clone().lean());
    let limit = apart.entries / calls.len().max(1);
    let start = (first.start(), second.start());
    // Whether the first lets a program end, where they do not agree on it.
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
    let mut found: Vec<Found<(State, State), Call>> = vec![(start, None)];
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
                return Err(TooLarge::Count {
                    what: "pairs of states",
                    limit,
                });
            }
            // Asked as soon as it is found: behind a state found later, but as early, there may be
            // a longer difference only.
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
