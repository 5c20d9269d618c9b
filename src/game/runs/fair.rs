//! The states from which some run stays within a set for ever and meets all justice again and again.
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. Pre( (Jⱼ ∧ Z′) ∨ Y′ ) ∧ Z
//! ```

use super::board::Steps;
use crate::symbolic::{Kernel, Limit};

/// The fair states of `within`; justice may speak of next values.
pub fn fair<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let m = &steps.m;
    let always = [m.constant(true)];
    let again = if again.is_empty() { &always } else { again };
    let mut z = m.and(&steps.states, within)?;
    // Without an end first: it is the cheapest part, and often all that is needed.
    loop {
        let smaller = m.and(&z, &steps.before(&z)?)?;
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
            let met = m.and(justice, &m.prime(&z)?)?;
            let mut y = m.and(&z, &steps.before_step(&met)?)?;
            let mut new = y.clone();
            while !m.is_false(&new) {
                let more = m.and(&z, &steps.before(&new)?)?;
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

/// The states with a past without a beginning in `within` that has met all justice again and again: none exactly where no run does so
/// for ever, since both need a cycle. Steps forward from what can be reached stay within that, and are far cheaper than steps back,
/// which come from everywhere; so whoever expects that there is no run asks here first.
pub fn past<K: Kernel>(
    steps: &Steps<K>,
    within: &K::Function,
    again: &[K::Function],
) -> Result<K::Function, Limit> {
    let m = &steps.m;
    let always = [m.constant(true)];
    let again = if again.is_empty() { &always } else { again };
    let mut z = m.and(&steps.states, within)?;
    loop {
        let smaller = m.and(&z, &steps.after(&z)?)?;
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
            let met = m.and(&z, justice)?;
            let mut y = m.and(&z, &steps.after_step(&met)?)?;
            let mut new = y.clone();
            while !m.is_false(&new) {
                let more = m.and(&z, &steps.after(&new)?)?;
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
