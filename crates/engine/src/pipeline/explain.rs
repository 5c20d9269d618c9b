//! Explains why a contract is unrealizable: the verified counterstrategy of its core, the play that
//! shows it, and possible repairs.

use super::InternalError;
use linewright_core::gr1::Specification;
use linewright_solver::game::{self, Advice, GuaranteeRef, Limit, Limits, Play};
use linewright_solver::mealy::{self, Machine};
use serde::{Deserialize, Serialize};

/// Maximum node count while playing against the core and searching for repairs.
const MOST_NODES: u64 = 2_000_000;

/// Explanation of an unrealizable contract.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// The play that shows it.
    pub play: Option<Play>,
    /// A machine of the plant that beats every controller, verified; see [`mealy::counter`].
    pub counterstrategy: Option<Machine>,
    /// Possible repairs.
    pub advice: Option<Advice>,
    /// Whether no time or memory limit affected the result.
    pub complete: bool,
}

/// Explains the contract as far as the limits allow. Intermediate results are passed to `report`.
pub(super) fn explain(
    specification: &Specification,
    core: &[GuaranteeRef],
    limits: &Limits,
    report: &mut dyn FnMut(&Explanation),
) -> Result<Explanation, InternalError> {
    let limits = Limits {
        most_nodes: Some(MOST_NODES),
        ..*limits
    };
    let mut explained = Explanation {
        complete: true,
        ..Explanation::default()
    };
    let small = game::reduced(specification, core);
    let attack = match game::attack(&small, &specification.guarantees.initial, &limits) {
        Ok(Some(attack)) => attack,
        Ok(None) => {
            let rule = "nothing beats the core of a contract that was called unrealizable";
            return Err(InternalError::new(specification, rule.to_owned()));
        }
        Err(limit) => return Ok(explained.stopped(limit)),
    };
    let machine = mealy::counter::machine(&small, &attack);
    match mealy::verify::verify_counterstrategy(&small, &machine, &limits) {
        Ok(Ok(())) => explained.counterstrategy = Some(machine),
        Ok(Err(violation)) => {
            return Err(InternalError::new(
                specification,
                violation.clause.to_string(),
            ));
        }
        Err(limit) => explained = explained.stopped(limit),
    }
    explained.play = Some(attack.play.clone().within(core));
    report(&explained);
    match game::advise(specification, core, &attack.play, &limits) {
        Ok(advice) => explained.advice = Some(advice),
        Err(limit) => explained = explained.stopped(limit),
    }
    Ok(explained)
}

impl Explanation {
    /// A time limit may give another result in another run.
    fn stopped(mut self, limit: Limit) -> Self {
        self.complete &= !matches!(limit, Limit::Late(_));
        self
    }
}
