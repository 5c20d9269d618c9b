//! Infinite plays that satisfy all justice of both sides, if both sides cooperate.
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. Pre( (Jⱼ ∧ Z′) ∨ Y′ ) ∧ Z
//! ```

use super::arena::Arena;
use crate::symbolic::{Kernel, Limit};

/// Returns the states of `within` from which some infinite path of `steps` stays in `within` and
/// satisfies all justice of both sides infinitely often.
pub fn lasting<K: Kernel>(
    arena: &Arena<K>,
    steps: &K::Function,
    within: &K::Function,
) -> Result<K::Function, Limit> {
    let m = &arena.kernel;
    let mut next = arena.inputs_next.clone();
    arena.outputs_next.iter().for_each(|bit| next.insert(bit));
    let mut z = m.and(&arena.states, within)?;
    loop {
        let mut smaller = z.clone();
        for justice in arena.assumptions.iter().chain(&arena.goals) {
            let met = m.and(justice, &m.prime(&smaller)?)?;
            let mut y = m.constant(false);
            loop {
                let target = m.or(&met, &m.prime(&y)?)?;
                let larger = m.and(&smaller, &m.and_exists(steps, &target, &next)?)?;
                if larger == y {
                    break;
                }
                y = larger;
                m.safe_point()?;
            }
            smaller = y;
        }
        if smaller == z {
            return Ok(z);
        }
        z = smaller;
    }
}

/// Returns the states from which both sides, if they cooperate, can keep all invariants and safety
/// for ever and satisfy all justice infinitely often.
pub fn cooperating<K: Kernel>(arena: &Arena<K>) -> Result<K::Function, Limit> {
    let m = &arena.kernel;
    let both = m.and(&arena.environment_moves()?, &arena.system_moves()?)?;
    lasting(arena, &both, &arena.states)
}
