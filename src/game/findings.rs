//! What is odd about the assumptions: contradictions, dead ends, and whether the machine can win by breaking them.
//!
//! A specification is *well-separated* (Klein and Pnueli; Maoz and Ringert, "On well-separation of GR(1) specifications", FSE
//! 2016) when the machine cannot force the environment to violate its assumptions. Only then does "safety first, strictly"
//! equal the plain implication. The check is the same game with the machine's justice replaced by `false`, played from the
//! states that can occur while both sides keep their safety.

use super::arena::Arena;
use super::fixpoint::winning_states;
use crate::gr1::{Specification, Time, VarId};
use crate::symbolic::{BitSet, Kernel, Limit, Limits};
use serde::{Deserialize, Serialize};

/// What is odd about the environment's side. A valuation has one value a variable of the specification.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EnvironmentFindings {
    /// The environment's initial conditions and invariants contradict each other: every machine is right.
    pub cannot_start: bool,
    /// A first valuation after which the environment has no move.
    pub stuck_at_start: Option<Vec<i64>>,
    /// A valuation that can occur while both sides keep their safety, after which the environment has no move.
    pub dead_end: Option<Vec<i64>>,
    /// A valuation that can occur while both sides keep their safety, from which the machine can keep its safety and force
    /// the environment to break an assumption. `None`: the specification is well-separated.
    pub forced: Option<Vec<i64>>,
}

impl EnvironmentFindings {
    /// Whether the machine can never force the environment to break an assumption.
    pub fn well_separated(&self) -> bool {
        !self.cannot_start && self.forced.is_none()
    }
}

/// Examines the environment's side. Independent of whether the specification is realizable.
pub fn examine_environment(
    specification: &Specification,
    limits: &Limits,
) -> Result<EnvironmentFindings, Limit> {
    super::solver::examine(specification, limits)
}

/// The same, in a game that is encoded already.
pub fn examine<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
) -> Result<EnvironmentFindings, Limit> {
    let m = &arena.kernel;
    if m.is_false(&arena.env_initial) {
        return Ok(EnvironmentFindings {
            cannot_start: true,
            ..EnvironmentFindings::default()
        });
    }

    let now = BitSet::new(arena.inputs_now.iter().chain(arena.outputs_now.iter()));
    let environment = arena.environment_moves()?;
    let next_states = m.prime(&arena.states)?;
    let both = m.and(&environment, &m.and(&arena.system_moves()?, &next_states)?)?;
    let initial = m.and(&arena.env_initial, &arena.sys_initial)?;
    let mut reachable = initial.clone();
    let mut fresh = initial.clone();
    while !m.is_false(&fresh) {
        let successors = m.unprime(&m.and_exists(&fresh, &both, &now)?)?;
        fresh = m.and_not(&successors, &reachable)?;
        reachable = m.or(&reachable, &fresh)?;
    }

    let stuck = m.not(&m.exists(&environment, &arena.inputs_next)?)?;
    let stuck_at_start = m.and(&stuck, &initial)?;
    let dead_end = m.and(&stuck, &reachable)?;
    let hopeless = Arena {
        goals: vec![m.constant(false)],
        ..arena.clone()
    };
    let forced = m.and(&winning_states(&hopeless)?, &reachable)?;

    let valuation = |bits: Vec<bool>| -> Vec<i64> {
        let ids = (0..specification.variables.len()).map(|i| VarId(i as u32));
        ids.map(|v| arena.encoding.value(v, Time::Now, &bits))
            .collect()
    };
    Ok(EnvironmentFindings {
        cannot_start: false,
        stuck_at_start: m.witness(&stuck_at_start).map(valuation),
        dead_end: m.witness(&dead_end).map(valuation),
        forced: m.witness(&forced).map(valuation),
    })
}
