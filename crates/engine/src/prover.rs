//! Proves claims about machines and lines, and remembers the results in the cache.

use super::cache::{Cache, Key};
use linewright_algebra::closed::{self, ClosedComposition};
use linewright_algebra::proof::{self, Claim, Proof};
use linewright_algebra::system::System;
use linewright_language::contract::line::Line;
use linewright_line::UndecidedReason;
use linewright_line::abstraction::{self, Abstraction};
use linewright_solver::game::{Budget, Limit, Limits};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Proves claims within limits. With a cache, a claim that was decided before is not decided again.
///
/// A result depends only on the claim, the limits and the program. A limit that was reached is
/// remembered, too, unless it comes from `--timeout`, `--memory` or Ctrl-C.
#[derive(Debug, Clone, Copy)]
pub struct Prover<'a> {
    limits: Limits,
    cache: Option<&'a Cache>,
    discharges: Discharges,
}

/// Which formulas a discharge rests on, in proofs of machines. The verdict is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Discharges {
    /// A minimal set, for tables of discharges.
    Minimal,
    /// Any sufficient set, which is found sooner.
    Sufficient,
}

impl<'a> Prover<'a> {
    /// Creates a prover with these limits, and with this cache if there is one.
    pub fn new(limits: &Limits, cache: Option<&'a Cache>) -> Self {
        Self {
            limits: *limits,
            cache,
            discharges: Discharges::Sufficient,
        }
    }

    /// Returns a prover whose proofs of machines rest on such sets of formulas;
    /// [`Discharges::Sufficient`] by default.
    #[must_use]
    pub fn with_discharges(self, discharges: Discharges) -> Self {
        Self { discharges, ..self }
    }

    /// Limits of each claim.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns a prover with this budget for each claim.
    #[must_use]
    pub fn with_budget(self, budget: Budget) -> Self {
        Self {
            limits: self.limits.with_budget(budget),
            ..self
        }
    }

    /// See [`proof::prove`].
    pub fn prove(&self, system: &System, claim: &Claim) -> Result<Proof, Limit> {
        self.recall("prove", &(system, claim), |limits| {
            proof::prove(system, claim, limits)
        })
    }

    /// See [`proof::decide`].
    pub fn decide(&self, system: &System, claim: &Claim) -> Result<Proof, Limit> {
        self.recall("decide", &(system, claim), |limits| {
            proof::decide(system, claim, limits)
        })
    }

    /// See [`proof::prove_stepwise`] and [`proof::decide_stepwise`].
    pub fn prove_stepwise(&self, system: &System, claim: &Claim) -> Result<Proof, Limit> {
        match self.discharges {
            Discharges::Minimal => self.recall("prove stepwise", &(system, claim), |limits| {
                proof::prove_stepwise(system, claim, limits)
            }),
            Discharges::Sufficient => self.recall("decide stepwise", &(system, claim), |limits| {
                proof::decide_stepwise(system, claim, limits)
            }),
        }
    }

    /// See [`ClosedComposition::decide`]; the budget is that of closed compositions.
    pub fn decide_closed(
        &self,
        composition: &ClosedComposition<'_>,
    ) -> Result<closed::Verdict, Limit> {
        self.with_budget(Budget::CLOSED_COMPOSITION).recall(
            "closed composition",
            composition,
            |limits| composition.decide(limits),
        )
    }

    /// See [`ClosedComposition::count_states`]; the budget is that of closed compositions.
    pub fn count_states(&self, composition: &ClosedComposition<'_>) -> Result<f64, Limit> {
        self.with_budget(Budget::CLOSED_COMPOSITION).recall(
            "states of a closed composition",
            composition,
            |limits| composition.count_states(limits),
        )
    }

    /// See [`abstraction::examine`].
    pub fn examine_line(
        &self,
        line: &Line,
        most_variables: usize,
    ) -> Result<(Abstraction, abstraction::Verdict), UndecidedReason> {
        let mut own = None;
        let verdict = self.recall("line", &(line, most_variables), |limits| {
            let (abstraction, verdict) = abstraction::examine(line, limits, most_variables)?;
            own = Some(abstraction);
            Ok::<_, UndecidedReason>(verdict)
        })?;
        let abstraction = match own {
            Some(own) => own,
            None if verdict.at_once => Abstraction::at_once(line)?,
            None => Abstraction::of(line)?,
        };
        Ok((abstraction, verdict))
    }

    /// Returns the cached answer to a question, or finds it and stores it.
    fn recall<T, E>(
        &self,
        kind: &str,
        question: &impl Debug,
        answer: impl FnOnce(&Limits) -> Result<T, E>,
    ) -> Result<T, E>
    where
        Result<T, E>: Serialize + DeserializeOwned,
        E: Clone + Into<UndecidedReason>,
    {
        let Some(cache) = self.cache else {
            return answer(&self.limits);
        };
        let key = Key::of_proof(kind, question, &self.limits);
        if let Some(known) = cache.answer(&key) {
            return known;
        }
        let found = answer(&self.limits);
        // Within a proof, a limit can lead to a weaker answer instead of an error.
        let is_external = self.limits.check_time().is_err()
            || self.limits.deadline.has_exceeded_memory()
            || matches!(&found, Err(why) if why.clone().into().is_external());
        if !is_external {
            cache.store_answer(&key, &found);
        }
        found
    }
}
