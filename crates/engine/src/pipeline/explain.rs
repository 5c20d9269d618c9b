//! Explains why a contract is unrealizable: the verified counterstrategy of its core, the play that
//! shows it, and possible repairs.

use super::InternalError;
use linewright_core::gr1::Specification;
use linewright_solver::game::{self, Advice, Budget, GuaranteeRef, Limit, Limits, Play};
use linewright_solver::mealy::{self, Machine};
use serde::{Deserialize, Serialize};

/// Explanation of an unrealizable contract.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// A play in which the core is violated.
    pub play: Option<Play>,
    /// The verified counterstrategy of the plant as a machine; see [`mealy::counter`].
    pub counterstrategy: Option<Machine>,
    /// Possible repairs.
    pub advice: Option<Advice>,
    /// Whether the result would be the same without a time limit or an interrupt.
    pub complete: bool,
    /// Limit that the user can raise and that stopped the explanation.
    #[serde(skip)]
    pub stopped_by: Option<Limit>,
}

/// Explains the contract as far as the limits allow. Intermediate results are passed to `report`.
pub(super) fn explain(
    specification: &Specification,
    core: &[GuaranteeRef],
    limits: &Limits,
    report: &mut dyn FnMut(&Explanation),
) -> Result<Explanation, InternalError> {
    let repairs = limits.with_budget(Budget::REPAIRS);
    let limits = limits.with_budget(Budget::COUNTERSTRATEGY);
    let mut explained = Explanation {
        complete: true,
        ..Explanation::default()
    };
    let small = game::select_guarantees(specification, core);
    let attack = match game::attack(&small, &specification.guarantees.initial, &limits) {
        Ok(Some(attack)) => attack,
        Ok(None) => {
            let rule = "the core of an unrealizable contract has no counterstrategy";
            return Err(InternalError::new(specification, rule.to_owned()));
        }
        Err(limit) => return Ok(explained.stopped(limits.attribute(limit))),
    };
    let machine = mealy::counter::to_machine(&small, &attack);
    match mealy::verify::verify_counterstrategy(&small, &machine, &limits) {
        Ok(Ok(())) => explained.counterstrategy = Some(machine),
        Ok(Err(violation)) => {
            return Err(InternalError::new(
                specification,
                violation.clause.to_string(),
            ));
        }
        Err(limit) => explained = explained.stopped(limits.attribute(limit)),
    }
    explained.play = Some(attack.play.clone().with_original_references(core));
    report(&explained);
    match game::advise(specification, core, &attack.play, &repairs) {
        Ok(advice) => explained.advice = Some(advice),
        Err(limit) => explained = explained.stopped(repairs.attribute(limit)),
    }
    Ok(explained)
}

impl Explanation {
    /// Records that a limit stopped the explanation. Only a deadline or an interrupt makes it
    /// incomplete: other limits give the same result in every run.
    pub(super) fn stopped(mut self, limit: Limit) -> Self {
        self.complete &= !matches!(limit, Limit::Stopped(_));
        let can_be_raised = limit.remedy().is_some();
        self.stopped_by = self.stopped_by.or(Some(limit).filter(|_| can_be_raised));
        self
    }
}
