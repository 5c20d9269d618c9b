//! Checks of the assumptions: contradictions, dead ends, and whether the machine can win by forcing
//! a violation. In [`shape`]: guarantees that demand less than they seem to.
//!
//! A specification is *well-separated* (Klein and Pnueli; Maoz and Ringert, "On well-separation of
//! GR(1) specifications", FSE 2016) when the machine cannot force the environment to violate its
//! assumptions. Only then does "safety first, strictly" equal the plain implication. The check is
//! the same game with the machine's justice replaced by `false`, played from the states that can
//! occur. As in that paper, it is made twice: for a machine that always keeps its own safety, and
//! for an unrestricted one, which shows whether the assumptions are meaningful by themselves.

pub mod requests;
pub mod shape;

use super::arena::{Arena, Formulas, Selection};
use super::fixpoint::winning_states;
use super::lasting::together;
use super::reachable::{self, reachable};
use super::reference::{AssumptionRef, GuaranteeKind};
use super::set_up::SPLIT;
use crate::symbolic::{Bit, Kernel, Limit};
use linewright_core::gr1::{Specification, Time, VarId};
use serde::{Deserialize, Serialize};

/// The values of the variables of a specification, in its order. `None`: every value of the
/// variable will do, given the others.
pub type Situation = Vec<Option<i64>>;

/// What is odd about the environment's side.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentFindings {
    /// The environment's initial conditions and invariants contradict each other: every machine is
    /// correct.
    pub cannot_start: bool,
    /// A first valuation after which the environment has no move.
    pub stuck_at_start: Option<Situation>,
    /// A valuation that can occur while both sides keep their safety, after which the environment
    /// has no move.
    pub dead_end: Option<Situation>,
    /// A valuation that can occur while both sides keep their safety, from which the machine can
    /// keep its safety and force the environment to break an assumption. `None`: the specification
    /// is well-separated.
    pub forced: Option<Situation>,
    /// In how many of the valuations that can occur it can do so, and how many can occur.
    pub forced_states: [f64; 2],
    /// The same for a machine that need not keep its safety: a valuation that can occur then.
    pub forced_recklessly: Option<Situation>,
    /// See [`Self::forced_recklessly`].
    pub forced_recklessly_states: [f64; 2],
    /// Assumptions that can each be broken alone in this way.
    pub broken: Vec<AssumptionRef>,
    /// No play keeps all assumptions, even with a cooperating machine that ignores its guarantees.
    pub unsatisfiable: bool,
}

impl EnvironmentFindings {
    /// Whether the machine can never force the environment to break an assumption.
    pub fn well_separated(&self) -> bool {
        !self.cannot_start && self.forced.is_none()
    }
}

/// Examines the environment of an encoded game.
pub fn examine<K: Kernel>(
    formulas: &Formulas<K>,
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

    let initial = m.and(&arena.env_initial, &arena.sys_initial)?;
    let moves = arena.environment_moves()?;
    let reachable = reachable(arena, &initial, &m.and(&moves, &arena.system_moves()?)?)?;
    let stuck = m.not(&m.exists(&moves, &arena.inputs_next)?)?;
    let stuck_at_start = m.and(&stuck, &initial)?;
    let dead_end = m.and(&stuck, &reachable)?;
    let forced = m.and(&forcing(arena)?, &reachable)?;

    // The game for a machine without guarantees.
    let reckless = formulas.arena(&Selection::Only(&[]), SPLIT)?;
    let first = m.and(&reckless.env_initial, &reckless.sys_initial)?;
    let anywhere = reachable::reachable(&reckless, &first, &moves)?;
    let recklessly = m.and(&forcing(&reckless)?, &anywhere)?;

    let mut broken = Vec::new();
    if !m.is_false(&forced) || !m.is_false(&recklessly) {
        let guarantees = formulas.guarantees();
        for assumption in formulas.assumptions() {
            if assumption.kind == GuaranteeKind::Initial {
                continue;
            }
            let guarantees = if m.is_false(&forced) {
                &[]
            } else {
                &guarantees[..]
            };
            let selection = Selection::Both(guarantees, std::slice::from_ref(&assumption));
            let alone = forcing(&formulas.arena(&selection, SPLIT)?)?;
            let whole = if m.is_false(&forced) {
                &recklessly
            } else {
                &forced
            };
            if !m.is_false(&m.and(&alone, whole)?) {
                broken.push(assumption);
            }
        }
    }
    let helped = Arena {
        goals: vec![m.constant(true)],
        ..reckless
    };
    let hopeless = m.is_false(&m.and(&first, &together(&helped)?)?);

    let situation = |set: &K::Function, within: &K::Function| {
        prime_implicant(arena, specification, set, within)
    };
    let count = |set: &K::Function| -> f64 {
        let bits = arena.encoding.pairs() as f64;
        m.export(&[set]).shares()[0] * bits.exp2()
    };
    Ok(EnvironmentFindings {
        cannot_start: false,
        stuck_at_start: situation(&stuck_at_start, &initial)?,
        dead_end: situation(&dead_end, &reachable)?,
        forced: situation(&forced, &reachable)?,
        forced_states: [count(&forced), count(&reachable)],
        forced_recklessly: situation(&recklessly, &anywhere)?,
        forced_recklessly_states: [count(&recklessly), count(&anywhere)],
        broken,
        unsatisfiable: hopeless,
    })
}

/// A prime implicant of a set within a larger one: the fewest values, none of which can be left
/// out, that together ensure that a state of the larger set belongs to the smaller. Variables are
/// left out greedily, internal ones first.
fn prime_implicant<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    set: &K::Function,
    within: &K::Function,
) -> Result<Option<Situation>, Limit> {
    let (m, encoding) = (&arena.kernel, &arena.encoding);
    let Some(bits) = m.witness(set) else {
        return Ok(None);
    };
    let outside = m.and_not(within, set)?;
    let variables = &specification.variables;
    let ids = || (0..variables.len()).map(|i| VarId(i as u32));
    let mut values: Situation = ids()
        .map(|v| Some(encoding.value(v, Time::Now, &bits)))
        .collect();
    let (internal, seen): (Vec<VarId>, Vec<VarId>) =
        ids().partition(|v| variables[v.0 as usize].internal);
    for candidate in internal.into_iter().chain(seen) {
        let kept = ids().filter(|v| *v != candidate && values[v.0 as usize].is_some());
        let literals: Vec<(Bit, bool)> = encoding
            .bit_set(kept, Time::Now)
            .iter()
            .map(|bit| (bit, bits[bit.index()]))
            .collect();
        if m.is_false(&m.and(&m.cube(&literals)?, &outside)?) {
            values[candidate.0 as usize] = None;
        }
    }
    Ok(Some(values))
}

/// The states from which the machine can make the environment break an assumption.
fn forcing<K: Kernel>(arena: &Arena<K>) -> Result<K::Function, Limit> {
    winning_states(&Arena {
        goals: vec![arena.kernel.constant(false)],
        ..arena.clone()
    })
}
