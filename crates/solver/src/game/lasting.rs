//! Plays that last for ever and keep all justice with both sides cooperating: what is possible at
//! all.
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. Pre( (Jⱼ ∧ Z′) ∨ Y′ ) ∧ Z
//! ```

use super::arena::Arena;
use crate::symbolic::{Kernel, Limit};

/// The states of `within` from which some path of `steps` stays there for ever, and meets all
/// justice of both sides again and again.
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

/// The states from which both sides together can keep everything for ever.
pub fn together<K: Kernel>(arena: &Arena<K>) -> Result<K::Function, Limit> {
    let m = &arena.kernel;
    let both = m.and(&arena.environment_moves()?, &arena.system_moves()?)?;
    lasting(arena, &both, &arena.states)
}
