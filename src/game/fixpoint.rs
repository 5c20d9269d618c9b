//! The three-nested fixpoint of a GR(1) game, and the record of it that a strategy is made from.
//!
//! From Bloem et al. 2012, section 3, with justice on transitions, so that goals may speak of next values:
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. ⋁ᵢ νX. Z ∧ CPre( (Gⱼ ∧ Z′) ∨ Y′ ∨ (¬Aᵢ ∧ X′) )
//! ```
//!
//! `Gⱼ` are the machine's goals, `Aᵢ` the environment's assumptions, `CPre` is [`Arena::controllable_predecessor`]. The
//! conjunction with Z does not change the result, since everything found for the last Z lies in it, and lets every X start
//! from Z instead of from all states. The Z that one goal leaves is fed to the next one. Nothing is stored while deciding:
//! [`layers`] runs the two inner fixpoints once more, for the final Z.

use super::arena::Arena;
use crate::symbolic::{Function, Limit};

/// The states from which the machine wins, or `None` as soon as some initial choice of the environment is lost.
pub fn winning_region(arena: &Arena) -> Result<Option<Function>, Limit> {
    if !arena.wins_initially(&arena.states)? {
        return Ok(None);
    }
    greatest_region(arena, |z| arena.wins_initially(z))
}

/// The states from which the machine wins, whatever the initial ones are.
pub fn winning_states(arena: &Arena) -> Result<Function, Limit> {
    let region = greatest_region(arena, |_| Ok(true))?;
    Ok(region.unwrap_or_else(|| arena.manager.constant(false)))
}

/// The outermost fixpoint; `None` as soon as a Z is not `good` any more.
fn greatest_region(
    arena: &Arena,
    good: impl Fn(&Function) -> Result<bool, Limit>,
) -> Result<Option<Function>, Limit> {
    let mut z = arena.states.clone();
    let mut settled = 0; // For how many goals in a row Z has stayed as it is.
    for j in (0..arena.goals.len()).cycle() {
        let smaller = reach_goal(arena, j, &z, &mut |_, _| ())?;
        if smaller == z {
            settled += 1;
            if settled == arena.goals.len() {
                break;
            }
        } else {
            if !good(&smaller)? {
                return Ok(None);
            }
            z = smaller;
            settled = 0;
        }
    }
    Ok(Some(z))
}

/// `μY. ⋁ᵢ νX. Z ∧ CPre( (Gⱼ ∧ Z′) ∨ Y′ ∨ (¬Aᵢ ∧ X′) )`; calls `found(i, X)` for every X that adds something to Y.
fn reach_goal(
    arena: &Arena,
    j: usize,
    z: &Function,
    found: &mut impl FnMut(usize, &Function),
) -> Result<Function, Limit> {
    let m = &arena.manager;
    let goal = m.and(&arena.goals[j], &m.prime(z)?)?;
    let mut y = m.constant(false);
    let mut idle = 0; // How many assumptions in a row added nothing.
    for i in (0..arena.assumptions.len()).cycle() {
        let progress = m.or(&goal, &m.prime(&y)?)?;
        let waiting = m.not(&arena.assumptions[i])?;
        let mut x = z.clone();
        loop {
            let wait = m.and(&waiting, &m.prime(&x)?)?;
            let target = m.or(&progress, &wait)?;
            let smaller = m.and(z, &arena.controllable_predecessor(&target)?)?;
            if smaller == x {
                break;
            }
            x = smaller;
            if waiting.is_false() {
                break; // Then nothing depends on X.
            }
        }
        let larger = m.or(&y, &x)?;
        if larger == y {
            idle += 1;
            if idle >= arena.assumptions.len() {
                break;
            }
        } else {
            found(i, &x);
            idle = 0;
            y = larger;
        }
    }
    Ok(y)
}

/// One step of the inner fixpoints for a goal.
#[derive(Debug)]
pub struct Layer {
    /// The assumption that fails for ever if the play stays in `wait` for ever.
    pub assumption: usize,
    /// The X of this step: here the machine may wait, as long as that assumption does not hold.
    pub wait: Function,
    /// The Y after this step: all states from which the goal is at most this far.
    pub reached: Function,
}

/// The steps towards goal `j` within the winning region: a move into an earlier `reached` is progress.
pub fn layers(arena: &Arena, j: usize, region: &Function) -> Result<Vec<Layer>, Limit> {
    let m = &arena.manager;
    let mut steps = Vec::new();
    reach_goal(arena, j, region, &mut |i, x| steps.push((i, x.clone())))?;
    let mut y = m.constant(false);
    let mut layers = Vec::new();
    for (assumption, wait) in steps {
        y = m.or(&y, &wait)?;
        layers.push(Layer {
            assumption,
            wait,
            reached: y.clone(),
        });
    }
    Ok(layers)
}
