//! Examines the assumptions: contradictions, dead ends, and whether the machine can win by forcing
//! a violation. [`shape`] finds guarantees that demand less than they seem to.
//!
//! A specification is *well-separated* (Klein and Pnueli; Maoz and Ringert, "On well-separation of
//! GR(1) specifications", FSE 2016) when the machine cannot force the environment to violate its
//! assumptions. Only then is the strict semantics, in which safety takes precedence over justice,
//! equivalent to the plain implication from assumptions to guarantees. The check solves the same
//! game with the machine's justice replaced by `false`, and looks for winning states among the
//! states that can occur. As in that paper, it is done twice: for a machine that keeps its own
//! safety, and for an unrestricted one, which shows whether the assumptions are well-separated on
//! their own.

pub mod requests;
pub mod shape;

use super::arena::{Arena, Formulas, Selection};
use super::fixpoint::winning_states;
use super::lasting::cooperating;
use super::reachable::{self, reachable};
use super::reference::AssumptionRef;
use super::set_up::SPLIT;
use crate::symbolic::{Bit, Kernel, Limit};
use linewright_core::gr1::{FormulaKind, Specification, Time, VarId};
use serde::{Deserialize, Serialize};

/// A set of valuations: the values of the variables in the order of the specification, `None` for a
/// variable that can have any value.
pub type PartialValuation = Vec<Option<i64>>;

/// Findings about the assumptions of a specification.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentFindings {
    /// Whether the environment's initial conditions and invariants contradict each other. If so,
    /// every machine is correct, and the other fields are empty.
    pub cannot_start: bool,
    /// A valuation of step 0 after which the environment has no move.
    pub stuck_at_start: Option<PartialValuation>,
    /// A valuation that can occur while both sides satisfy their safety formulas, but after which
    /// the environment has no move.
    pub dead_end: Option<PartialValuation>,
    /// A valuation that can occur while both sides satisfy their safety formulas, and from which
    /// the machine can keep satisfying its own and force the environment to break an assumption;
    /// `None` if the specification is well-separated.
    pub forced: Option<PartialValuation>,
    /// The number of valuations that can occur and from which the machine can force the environment
    /// to break an assumption, and the number of all valuations that can occur.
    pub forced_states: [f64; 2],
    /// Like [`Self::forced`], for a machine that need not keep its safety.
    pub forced_recklessly: Option<PartialValuation>,
    /// Like [`Self::forced_states`], for a machine that need not keep its safety.
    pub forced_recklessly_states: [f64; 2],
    /// Assumptions that the machine can force the environment to break even if there are no other
    /// assumptions.
    pub broken: Vec<AssumptionRef>,
    /// Whether no play keeps all assumptions, even with a cooperating machine that ignores its
    /// guarantees.
    pub unsatisfiable: bool,
}

impl EnvironmentFindings {
    /// Whether the machine can never force the environment to break an assumption.
    pub fn is_well_separated(&self) -> bool {
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
            if assumption.kind == FormulaKind::Initial {
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
    let hopeless = m.is_false(&m.and(&first, &cooperating(&helped)?)?);

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

/// Returns a prime implicant of `set` within the larger set `within`: values of some variables such
/// that every state of `within` with these values belongs to `set`. None of the values can be left
/// out. Variables are left out greedily, internal ones first. Returns `None` if `set` is empty.
fn prime_implicant<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    set: &K::Function,
    within: &K::Function,
) -> Result<Option<PartialValuation>, Limit> {
    let (m, encoding) = (&arena.kernel, &arena.encoding);
    let Some(bits) = m.witness(set) else {
        return Ok(None);
    };
    let outside = m.and_not(within, set)?;
    let variables = &specification.variables;
    let ids = || (0..variables.len()).map(|i| VarId(i as u32));
    let mut values: PartialValuation = ids()
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

/// Returns the states from which the machine can force the environment to break an assumption.
fn forcing<K: Kernel>(arena: &Arena<K>) -> Result<K::Function, Limit> {
    winning_states(&Arena {
        goals: vec![arena.kernel.constant(false)],
        ..arena.clone()
    })
}
