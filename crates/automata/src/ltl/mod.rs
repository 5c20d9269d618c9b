//! Formulas of linear temporal logic, and their conversion to automata by progression.
//!
//! A state of such an automaton is the obligation that remains after the previous steps: a
//! condition on the following steps, built from temporal formulas with "and" and "or". A step
//! replaces each formula by what the formula requires of the steps after this one (Bacchus and
//! Kabanza, "Using temporal logics to express search control knowledge for planning", 2000).
//! Conditions are [antichains](crate::antichain), so that equivalent conditions are recognized as
//! one state.
//!
//! [`safety`] returns an automaton that refuses bad prefixes; [`buchi`] also handles eventualities.

mod buchi;
mod formula;
mod progression;
mod safety;

pub use buchi::buchi;
pub use formula::{Formula, Formulas, Node};
pub use safety::{Limits, safety};
