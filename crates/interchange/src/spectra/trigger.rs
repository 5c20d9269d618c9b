//! Lowers triggers `trig r |=> e`, and `G regexp(r)`, `GF regexp(r)`.
//!
//! Whenever r matches, e has to match the following steps (Amram, Ma'ayan, Maoz, Pistiner,
//! Ringert: Triggers for Reactive Synthesis Specifications, ICSE 2023). Matches do not overlap, and
//! each is the shortest possible:
//!
//! 1. Read steps until they match r. If they never do, the trigger holds.
//! 2. Read the following steps until they match e, which has to happen eventually. Then continue
//!    with 1 in the step after.
//!
//! If r matches the empty word, part 1 reads no step. If e matches it, the trigger always holds.
//! `GF regexp(r)` is `trig true* |=> true* r`: infinitely often some steps match r. `G regexp(r)`
//! is `trig true* |=> r`: the run is a sequence of matches of r.

use super::reader::Reader;
use super::syntax::{Regexp, TemporalForm};
use super::value::Value;
use linewright_automata::derivative::ExtendedRegex as Re;
use linewright_automata::symbolic::{Automaton, Decision};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Owner;
use linewright_core::source::Span;

impl Reader {
    /// Adds `trig from |=> to`.
    pub fn trigger(&mut self, side: Owner, from: &Regexp, to: &Regexp, span: Span) -> Option<()> {
        let mut atoms = Vec::new();
        let (r, e) = (self.regexp(from, &mut atoms), self.regexp(to, &mut atoms));
        self.add_trigger(side, &r?, &e?, &atoms, span)
    }

    /// Adds `G regexp(r)` or `GF regexp(r)`.
    pub fn regexp_clause(
        &mut self,
        side: Owner,
        when: TemporalForm,
        regexp: &Regexp,
        span: Span,
    ) -> Option<()> {
        let mut atoms = Vec::new();
        let r = self.regexp(regexp, &mut atoms)?;
        let any = Re::Any.star();
        let effect = match when {
            TemporalForm::Transition => r,
            TemporalForm::Repeatedly => any.clone().then(r),
            _ => {
                self.error(
                    codes::NOT_GR1,
                    span,
                    "this regular expression has neither `G` nor `GF`",
                    "write `G regexp(r)` or `GF regexp(r)`; for a match at the start, use the similar `trig true |=> r`",
                );
                return None;
            }
        };
        self.add_trigger(side, &any, &effect, &atoms, span)
    }

    fn add_trigger(
        &mut self,
        side: Owner,
        from: &Re,
        to: &Re,
        atoms: &[Value],
        span: Span,
    ) -> Option<()> {
        let (Ok(from), Ok(to)) = (from.automaton(), to.automaton()) else {
            self.too_many_states(span);
            return None;
        };
        match trigger_automaton(&from, &to) {
            Some(automaton) => self.add_automaton(&automaton, "trigger", atoms, side, span),
            None => Some(()),
        }
    }
}

/// The automaton of a trigger: the states of `from`, then those of `to`. `None` if the trigger
/// always holds.
fn trigger_automaton(from: &Automaton, to: &Automaton) -> Option<Automaton> {
    if to.accepting[0] || from.accepting.iter().all(|a| !a) {
        return None;
    }
    // If r matches the empty word, a single accepting state replaces the states of r; its
    // transitions are those of the initial state of e.
    let at_once = from.accepting[0];
    let count = if at_once { 1 } else { from.steps.len() };
    let in_effect = |s: usize| if to.accepting[s] { 0 } else { count + s };
    let mut steps: Vec<Decision> = if at_once {
        vec![to.steps[0].map_successors(&in_effect)]
    } else {
        let in_cause = |s: usize| if from.accepting[s] { count } else { s };
        from.steps
            .iter()
            .map(|t| t.map_successors(&in_cause))
            .collect()
    };
    steps.extend(to.steps.iter().map(|t| t.map_successors(&in_effect)));
    let mut accepting = vec![true; count];
    accepting.resize(steps.len(), false);
    Some(Automaton { steps, accepting }.reachable().minimal())
}
