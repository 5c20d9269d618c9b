//! A minimal core: guarantees that clash, none of which can be left out.
//!
//! `QuickXplain` (Junker, AAAI 2004): halves are tried first, so a core of `k` among `n` guarantees costs about `k · log2(n / k)`
//! games instead of `n`. It is sound here because leaving out a guarantee never makes a specification unrealizable.

use super::GuaranteeRef;
use super::arena::{Formulas, Selection};
use super::fixpoint::{Iterations, winning_region};
use super::set_up::SPLIT;
use crate::symbolic::{Kernel, Limit};

/// A minimal unrealizable set of guarantees of an unrealizable specification.
pub fn minimal_core<K: Kernel>(formulas: &Formulas<K>) -> Result<Vec<GuaranteeRef>, Limit> {
    let all = formulas.guarantees();
    let mut core = clash(formulas, &[], false, &all)?;
    core.sort_unstable();
    Ok(core)
}

/// The smallest part of `candidates` that clashes together with `kept`. `grown` says that `kept` has changed since it was
/// last found harmless.
fn clash<K: Kernel>(
    formulas: &Formulas<K>,
    kept: &[GuaranteeRef],
    grown: bool,
    candidates: &[GuaranteeRef],
) -> Result<Vec<GuaranteeRef>, Limit> {
    if grown && unrealizable(formulas, kept)? {
        return Ok(Vec::new());
    }
    if candidates.is_empty() {
        return Ok(Vec::new());
    }
    if let [single] = candidates {
        return Ok(vec![*single]);
    }
    let (left, right) = candidates.split_at(candidates.len() / 2);
    let with_left = [kept, left].concat();
    let mut needed = clash(formulas, &with_left, !left.is_empty(), right)?;
    let with_needed = [kept, &needed].concat();
    let more = clash(formulas, &with_needed, !needed.is_empty(), left)?;
    needed.extend(more);
    Ok(needed)
}

fn unrealizable<K: Kernel>(
    formulas: &Formulas<K>,
    guarantees: &[GuaranteeRef],
) -> Result<bool, Limit> {
    let arena = formulas.arena(&Selection::Only(guarantees), SPLIT)?;
    Ok(winning_region(&arena, None, &Iterations::default())?.is_none())
}
