//! Finds a minimal core, that is, guarantees that clash and of which none can be omitted. Also
//! finds the assumptions that matter for this clash.
//!
//! The search is `QuickXplain` (Junker, AAAI 2004). It tries halves first, so that a core of `k`
//! out of `n` guarantees costs at most `2k · log2(n / k) + 2k` games, whereas omitting one
//! guarantee after the other costs `n` games and delta debugging (Zeller and Hildebrandt, TSE 28,
//! 2002) up to `n² + 3n`. The search is sound here because leaving out a guarantee never makes a
//! specification unrealizable.
//!
//! Without some of its assumptions, the core still clashes, but it may no longer be minimal: a
//! proper subset of it may clash, too. The assumptions that matter are a minimal set of assumptions
//! with which the core remains minimal. The same search finds them. Each of its tests solves up to
//! `k` games, where `k` is the number of guarantees in the core; each game omits one of them.

use super::arena::{Formulas, Selection};
use super::fixpoint::{Iterations, winning_region};
use super::reference::{AssumptionRef, GuaranteeRef, split_definitions};
use super::set_up::SPLIT;
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::Specification;

/// Returns a minimal unrealizable set of guarantees of an unrealizable specification, with the
/// definitions that it needs. The definitions are minimized last, since several guarantees can use
/// the same one.
pub fn minimal_core<K: Kernel>(
    formulas: &Formulas<K>,
    specification: &Specification,
) -> Result<Vec<GuaranteeRef>, Limit> {
    let (definitions, demands) = split_definitions(&specification.guarantees);
    let mut holds = |kept: &[GuaranteeRef]| unrealizable(formulas, Selection::Only(kept));
    let mut core = quick_xplain(&mut holds, &definitions, false, &demands)?;
    if !definitions.is_empty() {
        let needed = quick_xplain(&mut holds, &core, true, &definitions)?;
        core.extend(needed);
    }
    core.sort_unstable();
    Ok(core)
}

/// Returns a minimal set of assumptions under which the core stays minimal, that is, realizable
/// without any one of its guarantees.
pub fn assumptions_that_matter<K: Kernel>(
    formulas: &Formulas<K>,
    core: &[GuaranteeRef],
) -> Result<Vec<AssumptionRef>, Limit> {
    let mut others: Vec<Vec<GuaranteeRef>> = (0..core.len())
        .map(|i| [&core[..i], &core[i + 1..]].concat())
        .collect();
    let mut minimal = |assumed: &[AssumptionRef]| {
        for i in 0..others.len() {
            if unrealizable(formulas, Selection::Both(&others[i], assumed))? {
                // Moves the failing test to the front, because it is the most likely one to fail
                // again.
                others[..=i].rotate_right(1);
                return Ok(false);
            }
        }
        Ok(true)
    };
    if minimal(&[])? {
        return Ok(Vec::new());
    }
    let mut matters = quick_xplain(&mut minimal, &[], false, &formulas.assumptions())?;
    matters.sort_unstable();
    Ok(matters)
}

/// Returns a minimal subset of `candidates` that together with `kept` satisfies the monotone
/// property `holds`, provided that all `candidates` with `kept` satisfy it. If `grown` is false,
/// `kept` alone is known not to satisfy it and is not tested.
pub fn quick_xplain<T: Clone>(
    holds: &mut impl FnMut(&[T]) -> Result<bool, Limit>,
    kept: &[T],
    grown: bool,
    candidates: &[T],
) -> Result<Vec<T>, Limit> {
    if grown && holds(kept)? {
        return Ok(Vec::new());
    }
    if candidates.is_empty() {
        return Ok(Vec::new());
    }
    if let [single] = candidates {
        return Ok(vec![single.clone()]);
    }
    let (left, right) = candidates.split_at(candidates.len() / 2);
    let with_left = [kept, left].concat();
    let mut needed = quick_xplain(holds, &with_left, !left.is_empty(), right)?;
    let with_needed = [kept, &needed].concat();
    let more = quick_xplain(holds, &with_needed, !needed.is_empty(), left)?;
    needed.extend(more);
    Ok(needed)
}

fn unrealizable<K: Kernel>(
    formulas: &Formulas<K>,
    selection: Selection<'_>,
) -> Result<bool, Limit> {
    let arena = formulas.arena(&selection, SPLIT)?;
    Ok(winning_region(&arena, None, &Iterations::default())?.is_none())
}
