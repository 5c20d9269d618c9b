//! The switch: which mutant is active, which places are passed, and the amount of work.

use std::cell::{Cell, RefCell};
use std::iter::{Skip, Take};

/// A mutant of a checker.
pub struct Mutant {
    pub file: &'static str,
    pub function: &'static str,
    pub operator: &'static str,
    pub right: &'static str,
    pub wrong: &'static str,
}

/// State of the switches in one run.
struct State {
    /// The active mutant.
    on: Cell<Option<u32>>,
    /// Remaining number of switch queries; after that the run counts as endless.
    fuel: Cell<u64>,
    asked: Cell<u64>,
    /// Whether places are recorded.
    recording: Cell<bool>,
    seen: RefCell<Vec<bool>>,
}

thread_local! {
    static STATE: State = const { State {
        on: Cell::new(None),
        fuel: Cell::new(u64::MAX),
        asked: Cell::new(0),
        recording: Cell::new(false),
        seen: RefCell::new(Vec::new()),
    } };
}

/// Query at a place with `count` mutants, the first of which has the number `first`: the active
/// one, counted from 1.
pub fn at(first: u32, count: u32) -> u32 {
    STATE.with(|state| {
        let asked = state.asked.get() + 1;
        state.asked.set(asked);
        assert!(asked <= state.fuel.get(), "without an end");
        if state.recording.get() {
            let mut seen = state.seen.borrow_mut();
            let end = (first + count) as usize;
            if seen.len() < end {
                seen.resize(end, false);
            }
            seen[first as usize..end].fill(true);
        }
        match state.on.get() {
            Some(on) if first <= on && on < first + count => on - first + 1,
            _ => 0,
        }
    })
}

/// A shortened loop: 1 over nothing, 2 over all but the first, 3 over the first only, 0 over all.
pub fn shortened<I: IntoIterator>(all: I, how: u32) -> Take<Skip<I::IntoIter>> {
    let most = match how {
        1 => 0,
        3 => 1,
        _ => usize::MAX,
    };
    all.into_iter().skip(usize::from(how == 2)).take(most)
}

/// Runs something with a mutant active; also returns the number of switch queries.
pub fn with<T>(mutant: Option<u32>, fuel: u64, run: impl FnOnce() -> T) -> (T, u64) {
    STATE.with(|state| {
        state.on.set(mutant);
        state.fuel.set(fuel);
        state.asked.set(0);
        state.recording.set(false);
    });
    let result = run();
    (result, STATE.with(|state| state.asked.get()))
}

/// Whether a mutant is active in this thread.
pub fn is_on() -> bool {
    STATE.with(|state| state.on.get().is_some())
}

/// Runs something without a mutant; also returns the mutants whose places it passes, and the number
/// of switch queries.
pub fn recorded<T>(run: impl FnOnce() -> T) -> (T, Vec<bool>, u64) {
    STATE.with(|state| {
        state.on.set(None);
        state.fuel.set(u64::MAX);
        state.asked.set(0);
        state.recording.set(true);
        state.seen.borrow_mut().clear();
    });
    let result = run();
    STATE.with(|state| {
        state.recording.set(false);
        (result, state.seen.take(), state.asked.get())
    })
}
