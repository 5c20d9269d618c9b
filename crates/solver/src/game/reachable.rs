//! Reachable states with both sides cooperating.

use super::arena::Arena;
use crate::symbolic::{BitSet, Kernel, Limit};
use linewright_core::gr1::Timing;

/// Returns the states of the arena that `moves` can reach from `from`, including `from`. If the
/// machine moves first, only answers that are legal for all inputs count.
pub fn reachable<K: Kernel>(
    arena: &Arena<K>,
    from: &K::Function,
    moves: &K::Function,
) -> Result<K::Function, Limit> {
    let m = &arena.kernel;
    let now = BitSet::new(arena.inputs_now.iter().chain(arena.outputs_now.iter()));
    let legal = m.prime(&arena.states)?;
    let mut moves = m.and(moves, &legal)?;
    if arena.timing == Timing::Moore {
        // A machine that moves first can give only answers that are legal for all inputs.
        moves = m.and(&moves, &arena.for_all_inputs(&legal)?)?;
    }
    let mut reachable = from.clone();
    let mut fresh = from.clone();
    while !m.is_false(&fresh) {
        m.safe_point()?;
        let successors = m.unprime(&m.and_exists(&fresh, &moves, &now)?)?;
        fresh = m.and_not(&successors, &reachable)?;
        reachable = m.or(&reachable, &fresh)?;
    }
    Ok(reachable)
}
