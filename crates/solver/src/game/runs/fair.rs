//! Computes the states from which some infinite run stays within a set and meets all justice
//! infinitely often.
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. Pre( (Jⱼ ∧ Z′) ∨ Y′ ) ∧ Z
//! ```

use super::steps::Steps;
use crate::symbolic::{Kernel, Limit};

/// Returns the states of `within` from which some infinite run stays in `within` and meets all of
/// `again` infinitely often. Justice can mention next values.
pub fn fair<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let mut states = within.clone();
    narrow_to_fair(steps, &mut states, again)?;
    Ok(states)
}

/// Removes states from a set until those of [`fair`] are left. If a limit is reached, some are
/// removed, and the computation can continue with the set.
pub fn narrow_to_fair<K: Kernel>(
    steps: &Steps<K>,
    states: &mut K::Function,
    again: &[K::Function],
) -> Result<(), Limit> {
    let m = &steps.m;
    let one = |states: &K::Function| steps.before(states);
    let met =
        |justice: &K::Function, z: &K::Function| steps.before_step(&m.and(justice, &m.prime(z)?)?);
    fixpoint(steps, states, again, one, met)
}

/// Returns the states of `within` that have an infinite past in `within` in which all of `again` is
/// met infinitely often. This set is empty exactly if [`fair`] is empty, since both require a
/// cycle. If no run is expected, this set is computed first, because forward steps stay within the
/// reachable states. They are far cheaper than backward steps, which also lead to unreachable
/// states.
pub fn past<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let one = |states: &K::Function| steps.after(states);
    let met = |justice: &K::Function, z: &K::Function| steps.after(&steps.m.and(z, justice)?);
    let mut states = within.clone();
    fixpoint(steps, &mut states, again, one, met)?;
    Ok(states)
}

/// Narrows a set to the fixpoint in either direction. `one` returns the states one step away from a
/// set, and `met(J, Z)` the states one step away from Z by a step that meets J.
fn fixpoint<K: Kernel>(
    steps: &Steps<K>,
    z: &mut K::Function,
    again: &[K::Function],
    one: impl Fn(&K::Function) -> Result<K::Function, Limit>,
    met: impl Fn(&K::Function, &K::Function) -> Result<K::Function, Limit>,
) -> Result<(), Limit> {
    let m = &steps.m;
    let always = [m.constant(true)];
    let again = if again.is_empty() { &always } else { again };
    *z = m.and(&steps.states, z)?;
    // First restricts the set to infinite runs, because this is the cheapest part and often
    // sufficient.
    loop {
        let smaller = m.and(z, &one(z)?)?;
        if smaller == *z {
            break;
        }
        *z = smaller;
        m.safe_point()?;
    }
    loop {
        let before = z.clone();
        for justice in again {
            if m.is_false(z) {
                return Ok(());
            }
            let mut y = m.and(z, &met(justice, z)?)?;
            let mut new = y.clone();
            while !m.is_false(&new) {
                let more = m.and(z, &one(&new)?)?;
                new = m.and_not(&more, &y)?;
                y = m.or(&y, &new)?;
                m.safe_point()?;
            }
            *z = y;
        }
        if *z == before {
            return Ok(());
        }
    }
}
