//! Formulas of linear temporal logic, and the automata that come of them by progression.
//!
//! A state of such an automaton is what is left to be kept after the steps so far: a condition on
//! the steps to come, made of temporal formulas by "and" and "or". A step replaces each of these by
//! what it asks of the rest (Bacchus and Kabanza, "Using temporal logics to express search control
//! knowledge for planning", 2000). Conditions are [antichains](crate::antichain), so equal ones are
//! found.
//!
//! [`safety`] refuses what nothing can mend, [`buchi`] also sees to what has to come some day.

mod buchi;
mod formula;
mod progression;
mod safety;

pub use buchi::buchi;
pub use formula::{Formula, Formulas, Node};
pub use safety::{Limits, safety};
