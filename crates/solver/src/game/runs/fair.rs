//! The states from which some run stays within a set for ever and meets all justice again and
//! again.
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. Pre( (Jⱼ ∧ Z′) ∨ Y′ ) ∧ Z
//! ```

use super::rule_encoder::Steps;
use crate::symbolic::{Kernel, Limit};

/// The fair states of `within`; justice may refer to next values.
pub fn fair<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let m = &steps.m;
    let one = |states: &K::Function| steps.before(states);
    let met =
        |justice: &K::Function, z: &K::Function| steps.before_step(&m.and(justice, &m.prime(z)?)?);
    settle(steps, within, again, one, met)
}

/// The states of `within` that have an infinite past in `within` with all justice met again and
/// again. The set is empty exactly if no run does this for ever, since both need a cycle. Steps
/// forward from reachable states stay within them and are far cheaper than steps back, which come
/// from everywhere; so it is checked first if no run is expected.
pub fn past<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let one = |states: &K::Function| steps.after(states);
    let met = |justice: &K::Function, z: &K::Function| steps.after_step(&steps.m.and(z, justice)?);
    settle(steps, within, again, one, met)
}

/// The fixpoint in either direction: `one` takes a step, `met(J, Z)` is a step that meets J, to or
/// from Z.
fn settle<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
    one: impl Fn(&K::Function) -> Result<K::Function, Limit>,
    met: impl Fn(&K::Function, &K::Function) -> Result<K::Function, Limit>,
) -> Result<K::Function, Limit> {
    let m = &steps.m;
    let always = [m.constant(true)];
    let again = if again.is_empty() { &always } else { again };
    let mut z = m.and(&steps.states, within)?;
    // Restricts to runs without an end first: this is the cheapest part, and often sufficient.
    loop {
        let smaller = m.and(&z, &one(&z)?)?;
        if smaller == z {
            break;
        }
        z = smaller;
        m.safe_point()?;
    }
    loop {
        let before = z.clone();
        for justice in again {
            if m.is_false(&z) {
                return Ok(z);
            }
            let mut y = m.and(&z, &met(justice, &z)?)?;
            let mut new = y.clone();
            while !m.is_false(&new) {
                let more = m.and(&z, &one(&new)?)?;
                new = m.and_not(&more, &y)?;
                y = m.or(&y, &new)?;
                m.safe_point()?;
            }
            z = y;
        }
        if z == before {
            return Ok(z);
        }
    }
}
