//! Why a contract is unrealizable: the counterstrategy of its core, verified, the play that shows
//! it, and what could be done.

use super::InternalError;
use linewright_core::gr1::Specification;
use linewright_solver::game::{self, Advice, GuaranteeRef, Limit, Limits, Play};
use linewright_solver::mealy::{self, Machine};
use serde::{Deserialize, Serialize};

/// Playing against the core, and looking for repairs, ends at so many nodes.
const MOST_NODES: u64 = 2_000_000;

/// Why a contract is unrealizable.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Explained {
    /// The play that shows it.
    pub play: Option<Play>,
    /// A machine of the plant that beats every controller, verified; see [`mealy::counter`].
    pub counterstrategy: Option<Machine>,
    /// What could be done.
    pub advice: Option<Advice>,
    /// Whether no limit of time or memory had a part in it.
    pub complete: bool,
}

/// Explains it as far as the limits allow. What is known already is given to `report`.
pub(super) fn explain(
    specification: &Specification,
    core: &[GuaranteeRef],
    limits: &Limits,
    report: &mut dyn FnMut(&Explained),
) -> Result<Explained, InternalError> {
    let limits = Limits {
        most_nodes: Some(MOST_NODES),
        ..*limits
    };
    let mut explained = Explained {
        complete: true,
        ..Explained::default()
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

impl Explained {
    /// A limit of the clock is not the same tomorrow.
    fn stopped(mut self, limit: Limit) -> Self {
        self.complete &= !matches!(limit, Limit::Late(_));
        self
    }
}
