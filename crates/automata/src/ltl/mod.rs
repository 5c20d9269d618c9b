//! Formulas of linear temporal logic, and their automata by progression.
//!
//! A state of such an automaton is the obligation that remains after the steps so far: a condition
//! on the steps to come, built from temporal formulas by "and" and "or". A step replaces each of
//! these by what it requires of the rest (Bacchus and Kabanza, "Using temporal logics to express
//! search control knowledge for planning", 2000). Conditions are [antichains](crate::antichain), so
//! equal ones are found.
//!
//! [`safety`] refuses runs that can no longer be repaired; [`buchi`] also handles eventualities.

mod buchi;
mod formula;
mod progression;
mod safety;

pub use buchi::buchi;
pub use formula::{Formula, Formulas, Node};
pub use safety::{Limits, safety};
