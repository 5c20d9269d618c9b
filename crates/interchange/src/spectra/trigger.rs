//! Triggers: `trig r |=> e`, and `G regexp(r)`, `GF regexp(r)`.
//!
//! Whenever r matches, e has to match the steps that follow (Amram, Ma'ayan, Maoz, Pistiner,
//! Ringert: Triggers for Reactive Synthesis Specifications, ICSE 2023). Matches do not overlap, and
//! each is the shortest:
//!
//! 1. Steps are read until those read so far match r; if that never happens, all is well.
//! 2. The steps from the next one on are read until they match e. That has to happen some day; then
//!    it begins anew with 1 in the step after.
//!
//! Where r matches the empty word, 1 takes no step. Where e does, nothing is asked. `GF regexp(r)`
//! is `trig true* |=> true* r`: again and again some steps match r. `G regexp(r)` is
//! `trig true* |=> r`: the run is cut into pieces that match r.

use super::reader::Reader;
use super::syntax::{Regexp, TemporalForm};
use super::value::Value;
use linewright_automata::derivative::ExtendedRegex as Re;
use linewright_automata::symbolic::{Automaton, Decision};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Owner;
use linewright_core::source::Span;

impl Reader {
    /// `trig from |=> to`
    pub fn trigger(&mut self, side: Owner, from: &Regexp, to: &Regexp, span: Span) -> Option<()> {
        let mut atoms = Vec::new();
        let (r, e) = (self.regexp(from, &mut atoms), self.regexp(to, &mut atoms));
        self.triggered(side, &r?, &e?, &atoms, span)
    }

    /// `G regexp(r)`, `GF regexp(r)`
    pub fn matched(
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
                    "a regular expression has to hold again and again or throughout",
                    "write `G regexp(r)` or `GF regexp(r)`; for a match at the beginning, `trig true |=> r` comes near",
                );
                return None;
            }
        };
        self.triggered(side, &any, &effect, &atoms, span)
    }

    fn triggered(
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
        match chained(&from, &to) {
            Some(automaton) => self.follow(&automaton, "trigger", atoms, side, span),
            None => Some(()),
        }
    }
}

/// The automaton of a trigger; `None` where nothing is asked. Its states are those of `from`, then
/// those of `to`.
pub(super) fn chained(from: &Automaton, to: &Automaton) -> Option<Automaton> {
    if to.accepting[0] || from.accepting.iter().all(|a| !a) {
        return None;
    }
    // Without a step for r, one state stands for what is done: it goes on as the beginning of e
    // does.
    let at_once = from.accepting[0];
    let count = if at_once { 1 } else { from.steps.len() };
    let in_effect = |s: usize| if to.accepting[s] { 0 } else { count + s };
    let mut steps: Vec<Decision> = if at_once {
        vec![to.steps[0].renamed(&in_effect)]
    } else {
        let in_cause = |s: usize| if from.accepting[s] { count } else { s };
        from.steps.iter().map(|t| t.renamed(&in_cause)).collect()
    };
    steps.extend(to.steps.iter().map(|t| t.renamed(&in_effect)));
    let mut accepting = vec![true; count];
    accepting.resize(steps.len(), false);
    Some(Automaton { steps, accepting }.reached().minimal())
}
